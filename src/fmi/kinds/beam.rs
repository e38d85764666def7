//! A beam with its contact force prescribed from outside, or with its own frictional contact.

use std::sync::Arc;

use super::LoadRule;
use super::driven::{DrivenSystem, Table};
use crate::fmi::Behaviour;
use crate::fmi::continuous::ContinuousForm;
use crate::fmi::description::{DependencyKind, Description, Experiment, Variable};
use crate::model::{Beam, Contact, Model};
use crate::system::ModalBeam;
use crate::vocabulary as v;

use DependencyKind::{Dependent, Fixed};

// Rows of both tables; the first is the excitation.
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

/// Inputs and outputs of a beam, followed by `parameters`.
pub(super) fn describe(
    model: &Model,
    beam: &Beam,
    contact: Option<&Contact>,
    parameters: Vec<Variable>,
) -> Description {
    let sensors = sensor_positions(beam);
    let inputs = AT_POINTS + beam.contact_points.len();
    let outputs = if contact.is_some() { 6 } else { 2 } + 3 * sensors.len();
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
            Variable::output(&v::SLIP_FRACTION).discrete().depends(load(), [NORMAL_LOAD]),
            Variable::output(&v::DISPLACEMENT).depends(load(), []),
            Variable::output(&v::VELOCITY).depends(load(), []),
        ]);
    } else {
        let initially = [CONTACT_FORCE].into_iter().chain(axial());
        variables.extend([
            Variable::output(&v::DISPLACEMENT).depends([(CONTACT_FORCE, Fixed)], initially),
            // By the rate of the force, which a held one changes by its jump over the step.
            Variable::output(&v::VELOCITY).depends([(CONTACT_FORCE, Dependent)], []),
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
    let (name, summary) = name_and_summary(contact.is_some(), beam.contact_points.len());
    let step = if beam.contact_points.is_empty() { STEPS.0 } else { STEPS.1 };
    let experiment = Experiment { start: 0.0, stop: 0.2, tolerance: 1e-6, step };
    Description {
        name,
        summary,
        experiment,
        variables,
        continuous: ContinuousForm::default(),
        model: model.to_toml(),
    }
}

/// Name and summary of the slave of a beam with a contact of its own or without, and so many contact points.
fn name_and_summary(has_contact: bool, points: usize) -> (&'static str, &'static str) {
    match (has_contact, points) {
        (true, _) => ("FrictionalBeam", "Beam in modal coordinates with a frictional support"),
        (false, 0) => ("ModalBeam", "Beam in modal coordinates, loaded by a contact force from outside"),
        (false, 1) => {
            ("ModalBeamTwoContacts", "Beam in modal coordinates, loaded by two contact forces from outside")
        }
        (false, _) => {
            ("ModalBeamContacts", "Beam in modal coordinates, loaded by several contact forces from outside")
        }
    }
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
pub(super) fn sensor_positions(beam: &Beam) -> Vec<f64> {
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
    let law = model.law().map_err(|error| error.to_string())?;
    let table = Table {
        inputs: AT_POINTS + beam.contact_points.len(),
        load: law.is_some().then_some(NORMAL_LOAD),
        shows_port: true,
        runs: false,
        longest: None,
    };
    let system = modal.system(law.map(|law| (Arc::from(law), 0.0))).map_err(|error| error.to_string())?;
    // The end and the contact points.
    let own = 1 + beam.contact_points.len();
    Ok(Box::new(DrivenSystem::new(&system, own, table, LoadRule::new(model))?))
}
