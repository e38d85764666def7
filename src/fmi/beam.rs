//! A beam with its contact force prescribed from outside, or with its own frictional contact.

use super::description::{DependencyKind, Description, Experiment, Variable};
use super::{Behaviour, LoadRule};
use crate::contact::ContactLaw;
use crate::model::{Beam, Contact, Model};
use crate::system::ModalBeam;
use crate::time::{
    BeamChange, BeamInputChange, BeamInputs, BeamIntegrator, BeamMotion, BeamOutputs, BeamRates,
    Contact as Acting, Ramp, Settings,
};
use crate::vocabulary as v;

use DependencyKind::{Dependent, Fixed};

// Rows of both tables.
const EXCITATION: usize = 0;
/// Without a contact of its own: the contact force.
const CONTACT_FORCE: usize = 1;
/// With a contact: its normal load.
const NORMAL_LOAD: usize = 1;
/// First of the forces at the contact points.
const AT_POINTS: usize = 2;

/// Communication step (s) proposed for a beam whose contact is at its end alone, and for one with contact points. A
/// contact there holds the highest modes too: on the standard beam under strong coupling 1e-4 s leaves 1 % of the
/// displacement and 16 % of a friction damper's force, 1e-5 s 0.02 % and 0.2 %.
const STEPS: (f64, f64) = (1e-4, 1e-5);

/// Tolerances the integrator takes; a simulation's is moved to the nearest.
const TOLERANCES: (f64, f64) = (1e-13, 0.1);

/// Inputs and outputs of a beam, followed by `parameters`.
pub(super) fn describe(
    model: &Model,
    beam: &Beam,
    contact: Option<&Contact>,
    parameters: Vec<Variable>,
) -> Description {
    let sensors = sensor_positions(beam);
    let inputs = AT_POINTS + beam.contact_points.len();
    let outputs = if contact.is_some() { 5 } else { 2 } + 3 * sensors.len();
    let first_parameter = inputs + outputs;
    // A beam at rest has neither displacement nor velocity, and damping does not act on it.
    let at_rest = |names: &'static [&'static str]| {
        let rows = parameters.iter().enumerate();
        let rows = rows.filter(move |(_, row)| names.is_empty() || names.contains(&row.quantity.name));
        rows.filter(|(_, row)| !row.quantity.name.contains("damping"))
            .map(move |(index, _)| first_parameter + index)
            .collect::<Vec<_>>()
    };
    let axial = || at_rest(&["youngs_modulus", "width", "thickness", "length"]);
    let inertial = || at_rest(&BEAM_PARAMETERS);
    let second = match contact {
        Some(contact) => Variable::input(&v::NORMAL_LOAD, contact.normal_load),
        None => Variable::input(&v::CONTACT_FORCE, 0.0),
    };
    let mut variables = vec![Variable::input(&v::EXCITATION, 0.0), second];
    let at_points = beam.contact_points.iter();
    variables.extend(at_points.map(|position| Variable::contact_force_at(&v::CONTACT_FORCE, *position)));
    if contact.is_some() {
        let load = || [(NORMAL_LOAD, Dependent)];
        variables.extend([
            Variable::output(&v::FORCE).depends(load(), []),
            Variable::output(&v::DISSIPATED_ENERGY).depends(load(), []),
            Variable::output(&v::SLIP_STATE).integer().depends(load(), [NORMAL_LOAD]),
            Variable::output(&v::DISPLACEMENT).depends(load(), []),
            Variable::output(&v::VELOCITY).depends(load(), []),
        ]);
    } else {
        let initially = [CONTACT_FORCE].into_iter().chain(axial());
        variables.extend([
            Variable::output(&v::DISPLACEMENT).depends([(CONTACT_FORCE, Fixed)], initially),
            Variable::output(&v::VELOCITY),
        ]);
    }
    for position in sensors {
        let on = (0..inputs).map(|input| (input, if input == CONTACT_FORCE { Dependent } else { Fixed }));
        // A contact of its own that is at rest carries nothing, whatever its load.
        let initially = (0..inputs).filter(|input| contact.is_none() || *input != NORMAL_LOAD);
        variables.extend([
            Variable::sensor(&v::DISPLACEMENT, "displacement", position),
            Variable::sensor(&v::VELOCITY, "velocity", position),
            Variable::sensor(&v::ACCELERATION, "acceleration", position)
                .depends(on, initially.chain(inertial())),
        ]);
    }
    variables.extend(parameters);
    let (name, summary) = match (contact, beam.contact_points.len()) {
        (Some(_), _) => ("FrictionalBeam", "Beam in modal coordinates with a frictional support"),
        (None, 0) => ("ModalBeam", "Beam in modal coordinates, loaded by a contact force from outside"),
        (None, 1) => {
            ("ModalBeamTwoContacts", "Beam in modal coordinates, loaded by two contact forces from outside")
        }
        (None, _) => {
            ("ModalBeamContacts", "Beam in modal coordinates, loaded by several contact forces from outside")
        }
    };
    let step = if beam.contact_points.is_empty() { STEPS.0 } else { STEPS.1 };
    let experiment = Experiment { start: 0.0, stop: 0.2, tolerance: 1e-6, step };
    Description { name, summary, experiment, variables, model: model.to_toml() }
}

/// The parameters of the beam proper; those of a contact do not act while it is at rest.
const BEAM_PARAMETERS: [&str; 10] = [
    "youngs_modulus",
    "density",
    "length",
    "width",
    "thickness",
    "mass",
    "offset",
    "rotational_stiffness",
    "clamp_stiffness",
    "hanging_frequency",
];

/// Where the sensors sit, each place once; at the point masses if the model names none, and at the contact points.
fn sensor_positions(beam: &Beam) -> Vec<f64> {
    let masses = beam.point_masses.iter().map(|point| &point.position);
    let fallback = masses.filter(|_| beam.sensors.is_empty());
    let mut positions: Vec<f64> = Vec::new();
    for position in beam.sensors.iter().chain(fallback).chain(&beam.contact_points) {
        if !positions.contains(position) {
            positions.push(*position);
        }
    }
    positions
}

/// The physics of a beam.
pub(super) fn behaviour(beam: &Beam, model: &Model) -> Result<Box<dyn Behaviour>, String> {
    let beam = Beam { sensors: sensor_positions(beam), ..beam.clone() };
    let modal =
        ModalBeam::with_changes(&beam, &model.changes().structure).map_err(|error| error.to_string())?;
    let mut integrator = BeamIntegrator::new(&modal).map_err(|error| error.to_string())?;
    let law = model.law_of_any_values().map_err(|error| error.to_string())?;
    let motion = integrator.rest(law.as_deref().map(|law| (law, 0.0)));
    let outputs = integrator.new_outputs();
    let load = LoadRule::new(model);
    let held = vec![Ramp::held(0.0); AT_POINTS + beam.contact_points.len()];
    Ok(Box::new(BeamBehaviour {
        lines: held.clone(),
        beyond: held,
        before: motion.clone(),
        integrator,
        law,
        load,
        motion,
        outputs,
        rates: BeamRates::default(),
        change: BeamChange::default(),
        row: Vec::new(),
    }))
}

// What the state has behind the motion now and the motion before the last step: of that step
/// its length (s); 0 before the first;
const STEP: usize = 0;
/// the energy dissipated in it (J);
const DISSIPATED: usize = 1;
/// the inputs over it, start and end of each.
const LINES: usize = 2;

/// Integrator, law and work space.
#[derive(Debug)]
struct BeamBehaviour {
    integrator: BeamIntegrator,
    law: Option<Box<dyn ContactLaw>>,
    load: LoadRule,
    motion: BeamMotion,
    before: BeamMotion,
    /// Excitation, contact force or normal load, and forces at the contact points over a step.
    lines: Vec<Ramp>,
    /// The same over a step that follows.
    beyond: Vec<Ramp>,
    outputs: BeamOutputs,
    rates: BeamRates,
    change: BeamChange,
    /// The outputs as they stand in the table.
    row: Vec<f64>,
}

/// What acts on the beam along `lines`.
fn acting<'a>(law: Option<&'a dyn ContactLaw>, load: LoadRule, lines: &'a [Ramp]) -> BeamInputs<'a> {
    let contact = match law {
        Some(law) => {
            let Ramp { start, end } = lines[NORMAL_LOAD];
            Acting::Friction { law, normal_load: Ramp { start: load.acting(start), end: load.acting(end) } }
        }
        None => Acting::Force(lines[CONTACT_FORCE]),
    };
    BeamInputs { excitation: lines[EXCITATION], contact, at_points: &lines[AT_POINTS..] }
}

/// A line going on beyond its end for as long again.
fn beyond(&Ramp { start, end }: &Ramp) -> Ramp {
    if start == end { Ramp::held(end) } else { Ramp { start: end, end: end + (end - start) } }
}

fn settings(tolerance: f64) -> Settings {
    Settings { tolerance: tolerance.clamp(TOLERANCES.0, TOLERANCES.1), ..Settings::default() }
}

impl BeamBehaviour {
    /// Reads the lines of the last step and its length (s) from `last`, what the state has of it.
    fn read_last(&mut self, last: &[f64]) -> f64 {
        for (line, saved) in self.lines.iter_mut().zip(last[LINES..].chunks_exact(2)) {
            *line = Ramp { start: saved[0], end: saved[1] };
        }
        last[STEP]
    }

    fn look_beyond(&mut self) {
        self.beyond.iter_mut().zip(&self.lines).for_each(|(next, line)| *next = beyond(line));
    }

    /// Outputs of the motion at the end of the lines over `step` (s), written to `values` with those ends.
    fn write_outputs(&mut self, values: &mut [f64], step: f64) -> Result<(), String> {
        self.look_beyond();
        let inputs = acting(self.law.as_deref(), self.load, &self.beyond);
        let outputs = &mut self.outputs;
        let read = self.integrator.outputs(&self.motion, step, &inputs, outputs);
        read.map_err(|error| error.to_string())?;
        self.row.clear();
        if self.law.is_some() {
            let slip_state = f64::from(outputs.slip_state as i32);
            self.row.extend([outputs.contact_force, outputs.dissipated_energy, slip_state]);
        }
        self.row.extend([outputs.displacement, outputs.velocity]);
        for sensor in &outputs.sensors {
            self.row.extend([sensor.displacement, sensor.velocity, sensor.acceleration]);
        }
        if !self.row.iter().all(|value| value.is_finite()) {
            return Err("an output is beyond all bounds".to_owned());
        }
        let (inputs, outputs) = values.split_at_mut(self.lines.len());
        outputs[..self.row.len()].copy_from_slice(&self.row);
        for (value, line) in inputs.iter_mut().zip(&self.lines) {
            *value = line.end;
        }
        Ok(())
    }

    /// Writes to `state` that the present motion was reached along the lines in `step` (s).
    fn store(&self, state: &mut [f64], step: f64, dissipated: f64) -> Result<(), String> {
        let (now, rest) = state.split_at_mut(self.motion.state_len());
        let (before, last) = rest.split_at_mut(self.motion.state_len());
        before.copy_from_slice(now);
        for (saved, Ramp { start, end }) in last[LINES..].chunks_exact_mut(2).zip(&self.lines) {
            saved.copy_from_slice(&[*start, *end]);
        }
        (last[STEP], last[DISSIPATED]) = (step, dissipated);
        if self.motion.write_state(now) { Ok(()) } else { Err(wrong_length()) }
    }
}

impl Behaviour for BeamBehaviour {
    fn state_len(&self) -> usize {
        2 * self.motion.state_len() + LINES + 2 * self.lines.len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.motion =
            self.integrator.rest(self.law.as_deref().map(|law| (law, self.load.acting(values[NORMAL_LOAD]))));
        self.lines.iter_mut().zip(&*values).for_each(|(line, value)| *line = Ramp::held(*value));
        self.write_outputs(values, f64::INFINITY)?;
        self.store(state, 0.0, 0.0)
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        slopes: &[Option<f64>],
        step: f64,
        tolerance: f64,
    ) -> Result<(), String> {
        if !self.motion.read_state(&state[..self.motion.state_len()]) {
            return Err(wrong_length());
        }
        for (input, line) in self.lines.iter_mut().enumerate() {
            let slope = slopes.get(input).copied().flatten().unwrap_or(0.0);
            *line = Ramp::with_slope(values[input], slope, step);
        }
        let inputs = acting(self.law.as_deref(), self.load, &self.lines);
        let dissipated = self.motion.dissipated_energy();
        let advanced = self.integrator.advance(&mut self.motion, step, &inputs, &settings(tolerance));
        advanced.map_err(|error| error.to_string())?;
        let dissipated = self.motion.dissipated_energy() - dissipated;
        self.write_outputs(values, step)?;
        self.store(state, step, dissipated)
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let (now, rest) = state.split_at(self.motion.state_len());
        let last = &rest[self.motion.state_len()..];
        let step = self.read_last(last);
        if !self.motion.read_state(now) {
            return Err(wrong_length());
        }
        let (duration, mean_power) =
            if step > 0.0 { (step, last[DISSIPATED] / step) } else { (f64::INFINITY, 0.0) };
        self.look_beyond();
        let inputs = acting(self.law.as_deref(), self.load, &self.beyond);
        let found = self.integrator.output_rates(&self.motion, duration, &inputs, &mut self.rates);
        found.map_err(|error| error.to_string())?;
        self.row.clear();
        if self.law.is_some() {
            self.row.extend([self.rates.contact_force, mean_power, 0.0]);
        }
        self.row.extend([self.rates.displacement, self.rates.velocity]);
        self.row.extend(self.rates.sensors.iter().flatten());
        rates.copy_from_slice(&self.row);
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        direction: &[Ramp],
        tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        let (before, last) = state[self.motion.state_len()..].split_at(self.motion.state_len());
        let step = self.read_last(last);
        let duration = (step > 0.0).then_some(step);
        // Before the first step there is no motion before it.
        let from = if duration.is_some() { before } else { &state[..self.motion.state_len()] };
        if !self.before.read_state(from) {
            return Err(wrong_length());
        }
        let inputs = acting(self.law.as_deref(), self.load, &self.lines);
        let gain = if self.law.is_some() { self.load.gain() } else { 1.0 };
        let Ramp { start, end } = direction[CONTACT_FORCE];
        let contact = Ramp { start: gain * start, end: gain * end };
        let at_points = &direction[AT_POINTS..];
        let by = BeamInputChange { excitation: direction[EXCITATION], contact, at_points };
        let (beam, settings) = (&mut self.integrator, settings(tolerance));
        let followed = beam.follow(&self.before, duration, &inputs, &settings, (&mut self.change, &by));
        let (displacement, velocity) = followed.map_err(|error| error.to_string())?;
        self.row.clear();
        if self.law.is_some() {
            self.row.extend([self.change.force, self.change.dissipated_energy, 0.0]);
        }
        self.row.extend([displacement, velocity]);
        for sensor in &self.integrator.beam().sensors {
            self.row.extend(self.change.sensor(&sensor.shape));
        }
        change.copy_from_slice(&self.row);
        Ok(())
    }
}

/// Lengths come from the same motion; a difference would be a fault here.
fn wrong_length() -> String {
    "the state has another length than the beam's motion".to_owned()
}
