//! A beam with its contact force prescribed from outside, or with its own frictional contact.

use super::description::{DependencyKind, Description, Experiment, Variable};
use super::{Behaviour, LoadRule};
use crate::contact::ContactLaw;
use crate::integrate::{
    BeamChange, BeamInputChange, BeamInputs, BeamIntegrator, BeamMotion, BeamOutputs, BeamRates,
    Contact as Acting, Ramp, Settings,
};
use crate::model::{Beam, Contact, Model};
use crate::structure::ModalBeam;
use crate::vocabulary as v;

use DependencyKind::{Dependent, Fixed};

// Rows of both tables.
const EXCITATION: usize = 0;
/// Without a contact of its own: the contact force.
const CONTACT_FORCE: usize = 1;
/// With a contact: its normal load.
const NORMAL_LOAD: usize = 1;
const FIRST_OUTPUT: usize = 2;

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
    let outputs = if contact.is_some() { 5 } else { 2 } + 3 * sensors.len();
    let first_parameter = FIRST_OUTPUT + outputs;
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
    let mut variables = vec![Variable::input(&v::EXCITATION, 0.0)];
    let acceleration_on;
    if let Some(contact) = contact {
        let load = || [(NORMAL_LOAD, Dependent)];
        acceleration_on = vec![(EXCITATION, Fixed), (NORMAL_LOAD, Dependent)];
        variables.extend([
            Variable::input(&v::NORMAL_LOAD, contact.normal_load),
            Variable::output(&v::FORCE).depends(load(), []),
            Variable::output(&v::DISSIPATED_ENERGY).depends(load(), []),
            Variable::output(&v::SLIP_STATE).integer().depends(load(), [NORMAL_LOAD]),
            Variable::output(&v::DISPLACEMENT).depends(load(), []),
            Variable::output(&v::VELOCITY).depends(load(), []),
        ]);
    } else {
        acceleration_on = vec![(EXCITATION, Fixed), (CONTACT_FORCE, Dependent)];
        let initially = [CONTACT_FORCE].into_iter().chain(axial());
        variables.extend([
            Variable::input(&v::CONTACT_FORCE, 0.0),
            Variable::output(&v::DISPLACEMENT).depends([(CONTACT_FORCE, Fixed)], initially),
            Variable::output(&v::VELOCITY),
        ]);
    }
    for position in sensors {
        let inputs =
            acceleration_on.iter().map(|(index, _)| *index).take(if contact.is_some() { 1 } else { 2 });
        variables.extend([
            Variable::sensor(&v::DISPLACEMENT, "displacement", position),
            Variable::sensor(&v::VELOCITY, "velocity", position),
            Variable::sensor(&v::ACCELERATION, "acceleration", position)
                .depends(acceleration_on.iter().copied(), inputs.chain(inertial())),
        ]);
    }
    variables.extend(parameters);
    let (name, summary) = match contact {
        Some(_) => ("FrictionalBeam", "Beam in modal coordinates with a frictional support"),
        None => ("ModalBeam", "Beam in modal coordinates, loaded by a contact force from outside"),
    };
    let experiment = Experiment { start: 0.0, stop: 0.2, tolerance: 1e-6, step: 1e-4 };
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

/// Where the sensors sit, each place once; at the point masses if the model names none.
fn sensor_positions(beam: &Beam) -> Vec<f64> {
    let masses = beam.point_masses.iter().map(|point| &point.position);
    let fallback = masses.filter(|_| beam.sensors.is_empty());
    let mut positions: Vec<f64> = Vec::new();
    for position in beam.sensors.iter().chain(fallback) {
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
    Ok(Box::new(BeamBehaviour {
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

// What the state has behind the motion now and the motion before the last step.
/// The inputs over that step: start and end of each.
const LINES: usize = 0;
/// Its length (s); 0 before the first.
const STEP: usize = 4;
/// Energy dissipated in it (J).
const DISSIPATED: usize = 5;
const LAST_STEP: usize = 6;

/// Integrator, law and work space.
#[derive(Debug)]
struct BeamBehaviour {
    integrator: BeamIntegrator,
    law: Option<Box<dyn ContactLaw>>,
    load: LoadRule,
    motion: BeamMotion,
    before: BeamMotion,
    outputs: BeamOutputs,
    rates: BeamRates,
    change: BeamChange,
    /// The outputs as they stand in the table.
    row: Vec<f64>,
}

/// Excitation, and contact force or normal load, over a step.
type Lines = [Ramp; FIRST_OUTPUT];

/// What acts on the beam along `lines`.
fn acting<'a>(law: Option<&'a dyn ContactLaw>, load: LoadRule, lines: &Lines) -> BeamInputs<'a> {
    let contact = match law {
        Some(law) => {
            let Ramp { start, end } = lines[NORMAL_LOAD];
            Acting::Friction { law, normal_load: Ramp { start: load.acting(start), end: load.acting(end) } }
        }
        None => Acting::Force(lines[CONTACT_FORCE]),
    };
    BeamInputs { excitation: lines[EXCITATION], contact }
}

/// `lines` going on beyond their ends for as long again.
fn beyond(lines: &Lines) -> Lines {
    lines.map(
        |Ramp { start, end }| {
            if start == end { Ramp::held(end) } else { Ramp { start: end, end: end + (end - start) } }
        },
    )
}

fn settings(tolerance: f64) -> Settings {
    Settings { tolerance: tolerance.clamp(TOLERANCES.0, TOLERANCES.1), ..Settings::default() }
}

fn read_last(last: &[f64]) -> (Lines, f64) {
    let line = |input: usize| Ramp { start: last[LINES + 2 * input], end: last[LINES + 2 * input + 1] };
    (std::array::from_fn(line), last[STEP])
}

impl BeamBehaviour {
    /// Outputs of the motion at the end of `lines` over `step` (s), written to `values` with those ends.
    fn write_outputs(&mut self, values: &mut [f64], lines: &Lines, step: f64) -> Result<(), String> {
        let inputs = acting(self.law.as_deref(), self.load, &beyond(lines));
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
        values[FIRST_OUTPUT..FIRST_OUTPUT + self.row.len()].copy_from_slice(&self.row);
        for (value, line) in values.iter_mut().zip(lines) {
            *value = line.end;
        }
        Ok(())
    }

    /// Writes to `state` that the present motion was reached along `lines` in `step` (s).
    fn store(&self, state: &mut [f64], lines: &Lines, step: f64, dissipated: f64) -> Result<(), String> {
        let (now, rest) = state.split_at_mut(self.motion.state_len());
        let (before, last) = rest.split_at_mut(self.motion.state_len());
        before.copy_from_slice(now);
        for (input, Ramp { start, end }) in lines.iter().enumerate() {
            last[LINES + 2 * input..][..2].copy_from_slice(&[*start, *end]);
        }
        (last[STEP], last[DISSIPATED]) = (step, dissipated);
        if self.motion.write_state(now) { Ok(()) } else { Err(wrong_length()) }
    }
}

impl Behaviour for BeamBehaviour {
    fn state_len(&self) -> usize {
        2 * self.motion.state_len() + LAST_STEP
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.motion =
            self.integrator.rest(self.law.as_deref().map(|law| (law, self.load.acting(values[NORMAL_LOAD]))));
        let lines = [EXCITATION, CONTACT_FORCE].map(|input| Ramp::held(values[input]));
        self.write_outputs(values, &lines, f64::INFINITY)?;
        self.store(state, &lines, 0.0, 0.0)
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
        let slope = |input: usize| slopes.get(input).copied().flatten().unwrap_or(0.0);
        let lines =
            [EXCITATION, CONTACT_FORCE].map(|input| Ramp::with_slope(values[input], slope(input), step));
        let inputs = acting(self.law.as_deref(), self.load, &lines);
        let dissipated = self.motion.dissipated_energy();
        let advanced = self.integrator.advance(&mut self.motion, step, &inputs, &settings(tolerance));
        advanced.map_err(|error| error.to_string())?;
        let dissipated = self.motion.dissipated_energy() - dissipated;
        self.write_outputs(values, &lines, step)?;
        self.store(state, &lines, step, dissipated)
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let (now, rest) = state.split_at(self.motion.state_len());
        let last = &rest[self.motion.state_len()..];
        let (lines, step) = read_last(last);
        if !self.motion.read_state(now) {
            return Err(wrong_length());
        }
        let (duration, mean_power) =
            if step > 0.0 { (step, last[DISSIPATED] / step) } else { (f64::INFINITY, 0.0) };
        let inputs = acting(self.law.as_deref(), self.load, &beyond(&lines));
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
        let (lines, step) = read_last(last);
        let duration = (step > 0.0).then_some(step);
        // Before the first step there is no motion before it.
        let from = if duration.is_some() { before } else { &state[..self.motion.state_len()] };
        if !self.before.read_state(from) {
            return Err(wrong_length());
        }
        let inputs = acting(self.law.as_deref(), self.load, &lines);
        let gain = if self.law.is_some() { self.load.gain() } else { 1.0 };
        let Ramp { start, end } = direction[CONTACT_FORCE];
        let contact = Ramp { start: gain * start, end: gain * end };
        let by = BeamInputChange { excitation: direction[EXCITATION], contact };
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
