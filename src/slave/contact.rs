//! A contact whose displacement and normal load are prescribed from outside.

use super::description::{DependencyKind, Description, Experiment, Variable};
use super::{Behaviour, LoadRule};
use crate::contact::{ContactLaw, Inputs};
use crate::model::{Contact, Law, Model};
use crate::vocabulary as v;

// Rows of the table.
const DISPLACEMENT: usize = 0;
const VELOCITY: usize = 1;
const NORMAL_LOAD: usize = 2;
const FORCE: usize = 3;
const DISSIPATED_ENERGY: usize = 4;
const SLIP_STATE: usize = 5;
const PARAMETERS: usize = 6;

/// Inputs and outputs of a contact, followed by `parameters`.
pub(super) fn describe(model: &Model, contact: &Contact, parameters: Vec<Variable>) -> Description {
    let (name, summary) = match contact.law {
        Law::Jenkins => ("JenkinsContact", "Friction contact: Jenkins' element"),
        Law::Valanis { .. } => ("ValanisContact", "Friction contact: Valanis' law"),
        Law::Iwan { .. } => ("IwanContact", "Friction contact: the four-parameter Iwan element"),
    };
    let joint = model.changes().joint;
    let rate_dependent = joint.damping != 0.0 || joint.weakening.is_some();
    let mut inputs = vec![DISPLACEMENT, NORMAL_LOAD];
    if rate_dependent {
        inputs.insert(1, VELOCITY);
    }
    let on = || inputs.iter().map(|input| (*input, DependencyKind::Dependent));
    let initially = || inputs.iter().copied().chain(PARAMETERS..PARAMETERS + parameters.len());
    let mut variables = vec![
        Variable::input(&v::DISPLACEMENT, 0.0),
        Variable::input(&v::VELOCITY, 0.0),
        Variable::input(&v::NORMAL_LOAD, contact.normal_load),
        Variable::output(&v::FORCE).depends(on(), initially()),
        Variable::output(&v::DISSIPATED_ENERGY).depends(on(), initially()),
        Variable::output(&v::SLIP_STATE).integer().depends(on(), initially()),
    ];
    variables.extend(parameters);
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description { name, summary, experiment, variables, model: model.to_toml() }
}

/// The law and room for one step.
#[derive(Debug)]
pub(super) struct ContactBehaviour {
    law: Box<dyn ContactLaw>,
    load: LoadRule,
    next: Vec<f64>,
}

impl ContactBehaviour {
    pub(super) fn new(model: &Model) -> Result<Self, String> {
        let law = model.law_of_any_values().map_err(|error| error.to_string())?;
        let law = law.ok_or("a contact model needs a contact")?;
        let next = vec![0.0; law.state_len()];
        Ok(Self { law, load: LoadRule::new(model), next })
    }

    fn advance(&mut self, state: &mut [f64], values: &mut [f64]) {
        let inputs = Inputs {
            displacement: values[DISPLACEMENT],
            velocity: values[VELOCITY],
            normal_load: self.load.acting(values[NORMAL_LOAD]),
        };
        let response = self.law.step(state, inputs, &mut self.next);
        state.copy_from_slice(&self.next);
        values[FORCE] = response.force;
        values[DISSIPATED_ENERGY] += response.dissipated_energy;
        values[SLIP_STATE] = f64::from(response.slip_state as i32);
    }
}

impl Behaviour for ContactBehaviour {
    fn state_len(&self) -> usize {
        self.law.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.law.set_state(0.0, self.load.acting(values[NORMAL_LOAD]), 0.0, state);
        values[DISSIPATED_ENERGY] = 0.0;
        self.advance(state, values);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        _step: f64,
        _tolerance: f64,
    ) -> Result<(), String> {
        self.advance(state, values);
        Ok(())
    }
}
