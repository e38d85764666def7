//! A beam with its contact force prescribed from outside, or with its own frictional contact.

use super::Behaviour;
use super::description::{DependencyKind, Description, Experiment, Variable};
use crate::model::{Beam, Contact, Model};
use crate::vocabulary as v;

use DependencyKind::{Dependent, Fixed};

// Rows of both tables.
const EXCITATION: usize = 0;
/// Without a contact of its own: the contact force.
const CONTACT_FORCE: usize = 1;
/// With a contact: its normal load.
const NORMAL_LOAD: usize = 1;

/// Inputs and outputs of a beam, followed by `parameters`.
pub(super) fn describe(
    model: &Model,
    beam: &Beam,
    contact: Option<&Contact>,
    parameters: Vec<Variable>,
) -> Description {
    let sensors = sensor_positions(beam);
    let outputs = if contact.is_some() { 5 } else { 2 } + 3 * sensors.len();
    let first_parameter = 2 + outputs;
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
            Variable::output(&v::VELOCITY),
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
const BEAM_PARAMETERS: [&str; 9] = [
    "youngs_modulus",
    "density",
    "length",
    "width",
    "thickness",
    "mass",
    "offset",
    "rotational_stiffness",
    "clamp_stiffness",
];

/// Where the sensors sit, each place once.
fn sensor_positions(beam: &Beam) -> Vec<f64> {
    let mut positions: Vec<f64> = Vec::new();
    for position in &beam.sensors {
        if !positions.contains(position) {
            positions.push(*position);
        }
    }
    positions
}

/// The physics of a beam.
pub(super) fn behaviour(beam: &Beam, contact: Option<&Contact>) -> Result<Box<dyn Behaviour>, String> {
    let _ = (beam, contact);
    Err("not built".to_owned())
}
