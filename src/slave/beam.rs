//! A beam with its contact force prescribed from outside, or with its own frictional contact.

use super::description::{DependencyKind, Description, Experiment, Variable};
use super::{Behaviour, LoadRule};
use crate::contact::ContactLaw;
use crate::integrate::{
    BeamInputs, BeamIntegrator, BeamMotion, BeamOutputs, Contact as Acting, Ramp, Settings,
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
    Ok(Box::new(BeamBehaviour { integrator, law, load, motion, outputs, row: Vec::new() }))
}

/// Integrator, law and work space.
#[derive(Debug)]
struct BeamBehaviour {
    integrator: BeamIntegrator,
    law: Option<Box<dyn ContactLaw>>,
    load: LoadRule,
    motion: BeamMotion,
    outputs: BeamOutputs,
    /// The outputs as they stand in the table.
    row: Vec<f64>,
}

/// The inputs in `values`, held.
fn held<'a>(law: Option<&'a dyn ContactLaw>, load: LoadRule, values: &[f64]) -> BeamInputs<'a> {
    let contact = match law {
        Some(law) => Acting::Friction { law, normal_load: Ramp::held(load.acting(values[NORMAL_LOAD])) },
        None => Acting::Force(Ramp::held(values[CONTACT_FORCE])),
    };
    BeamInputs { excitation: Ramp::held(values[EXCITATION]), contact }
}

impl BeamBehaviour {
    /// Outputs of the motion under the inputs in `values`, written there.
    fn write_outputs(&mut self, values: &mut [f64]) -> Result<(), String> {
        let inputs = held(self.law.as_deref(), self.load, values);
        let outputs = &mut self.outputs;
        let read = self.integrator.outputs(&self.motion, f64::INFINITY, &inputs, outputs);
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
        Ok(())
    }
}

impl Behaviour for BeamBehaviour {
    fn state_len(&self) -> usize {
        self.motion.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.motion =
            self.integrator.rest(self.law.as_deref().map(|law| (law, self.load.acting(values[NORMAL_LOAD]))));
        self.write_outputs(values)?;
        if self.motion.write_state(state) { Ok(()) } else { Err(wrong_length()) }
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        step: f64,
        tolerance: f64,
    ) -> Result<(), String> {
        if !self.motion.read_state(state) {
            return Err(wrong_length());
        }
        let tolerance = tolerance.clamp(TOLERANCES.0, TOLERANCES.1);
        let settings = Settings { tolerance, ..Settings::default() };
        let inputs = held(self.law.as_deref(), self.load, values);
        let advanced = self.integrator.advance(&mut self.motion, step, &inputs, &settings);
        advanced.map_err(|error| error.to_string())?;
        self.write_outputs(values)?;
        if self.motion.write_state(state) { Ok(()) } else { Err(wrong_length()) }
    }
}

/// Lengths come from the same motion; a difference would be a fault here.
fn wrong_length() -> String {
    "the state has another length than the beam's motion".to_owned()
}
