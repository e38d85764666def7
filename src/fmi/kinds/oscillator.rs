//! Masses and springs with a frictional contact, or without.

use super::LoadRule;
use super::driven::{DrivenSystem, Table};
use crate::fmi::Behaviour;
use crate::fmi::continuous::ContinuousForm;
use crate::fmi::description::{DependencyKind, Description, Experiment, Variable};
use crate::model::{Contact, Model, Oscillator};
use crate::time::Integrator;
use crate::vocabulary::{self as v, Quantity};

use std::borrow::Cow;

/// Most masses: a step costs their number, and the modes its cube.
const MOST_MASSES: usize = 200;
/// Outputs of the contact: force, dissipated energy, slip state, slip fraction.
const OF_CONTACT: usize = 4;

/// Inputs and outputs of an oscillator, followed by `parameters`.
pub(super) fn describe(
    model: &Model,
    oscillator: &Oscillator,
    contact: Option<&Contact>,
    parameters: Vec<Variable>,
) -> Description {
    let masses = &oscillator.masses;
    let inputs = masses.len() + usize::from(contact.is_some());
    let outputs = 3 * masses.len() + if contact.is_some() { OF_CONTACT } else { 0 };
    let first_parameter = inputs + outputs;
    // All inputs run to their values within the step, and whatever they move moves everything.
    let on = || (0..inputs).map(|index| (index, DependencyKind::Dependent));
    let at = |quantity: &Quantity, name: &str| -> Cow<'static, str> {
        Cow::Owned(format!("{}:{name}", quantity.name))
    };
    let mut variables: Vec<Variable> = masses
        .iter()
        .map(|mass| Variable {
            name: at(&v::EXCITATION, &mass.name),
            description: Cow::Owned(format!("Force of the exciter on mass {}", mass.name)),
            ..Variable::input(&v::EXCITATION, 0.0)
        })
        .collect();
    if let Some(contact) = contact {
        let load = masses.len();
        variables.extend([
            Variable::input(&v::NORMAL_LOAD, contact.normal_load),
            Variable::output(&v::FORCE).depends(on(), []),
            Variable::output(&v::DISSIPATED_ENERGY).depends(on(), []),
            Variable::output(&v::SLIP_STATE).integer().depends(on(), [load]),
            Variable::output(&v::SLIP_FRACTION).discrete().depends(on(), [load]),
        ]);
    }
    for mass in masses {
        let motions = [
            (&v::DISPLACEMENT, "Displacement"),
            (&v::VELOCITY, "Velocity"),
            (&v::ACCELERATION, "Acceleration"),
        ];
        for (order, (quantity, noun)) in motions.into_iter().enumerate() {
            // At rest the excitation accelerates, and nothing has moved yet.
            let accelerated = (0..masses.len()).chain(first_parameter..first_parameter + parameters.len());
            let initially = accelerated.filter(|_| order == 2);
            let row = Variable {
                name: at(quantity, &mass.name),
                description: Cow::Owned(format!("{noun} of mass {}", mass.name)),
                ..Variable::output(quantity)
            };
            variables.push(row.depends(on(), initially));
        }
    }
    variables.extend(parameters);
    let (name, summary) = match contact {
        Some(_) => ("FrictionOscillator", "Masses and springs with a friction contact"),
        None => ("Oscillator", "Masses and springs"),
    };
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description {
        name,
        summary,
        experiment,
        variables,
        continuous: ContinuousForm::default(),
        model: model.to_toml(),
    }
}

/// The physics of an oscillator: every mass is driven and read.
pub(super) fn behaviour(model: &Model, oscillator: &Oscillator) -> Result<Box<dyn Behaviour>, String> {
    let masses = oscillator.masses.len();
    if masses > MOST_MASSES {
        return Err(format!("{masses} masses are too many for an FMU; {MOST_MASSES} is the limit"));
    }
    let own = usize::from(model.contact.is_some());
    let mut system = model.system().map_err(|error| error.to_string())?;
    system.driven.clone_from(&system.sensors);
    let stuck = model
        .contact
        .map(|contact| contact.tangential_stiffness + model.changes().joint.residual_stiffness.max(0.0));
    let integrator = Integrator::new(&system).map_err(|error| error.to_string())?;
    let table = Table {
        inputs: masses + own,
        load: (own == 1).then_some(masses),
        shows_port: false,
        runs: true,
        longest: Some(integrator.longest_step(stuck.as_slice(), f64::INFINITY)),
    };
    Ok(Box::new(DrivenSystem::new(&system, own, table, LoadRule::new(model))?))
}
