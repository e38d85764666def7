//! Models as co-simulation slaves, without any version of FMI: a variable table and an instance.
//!
//! # One table
//! [`Description`] lists the variables of a model once. The `modelDescription.xml` of an FMU, its
//! documentation, the dispatch of values and the identity check (the GUID) all come from it. A value
//! reference is a position in the table.
//!
//! # Contacts
//! The inputs set before [`Instance::do_step`]`(t, h)` are those reached at `t + h`, on a straight line
//! from the previous ones; the outputs then belong to `t + h`. The laws are rate-independent: `h` must
//! be positive and finite, and plays no other role. A contact starts unstressed at displacement 0
//! under the normal load set at initialization and goes from there to the initial displacement. During
//! initialization the outputs follow the inputs and parameters without leaving a trace.
//!
//! # Beams
//! A beam starts at rest and undeformed. Its inputs are held constant over a step. Its outputs belong
//! to the end of the step and change in [`Instance::do_step`] only.
//!
//! # Oscillators
//! Masses start at rest. As with a contact, the inputs set before a step are those reached at its end, on a straight
//! line from the previous ones; outputs belong to the end of the step and change in [`Instance::do_step`] only.

mod beam;
mod contact;
mod derivatives;
mod description;
mod error;
mod instance;
mod oscillator;
mod parameter;
mod snapshot;

pub use derivatives::DERIVATIVE_ORDER;
pub use description::{
    Causality, Dependency, DependencyKind, Description, Experiment, Initial, Variability, Variable,
    VariableType,
};
pub use error::Error;
pub use instance::{Instance, Setup, Stage};
pub use snapshot::{Snapshot, SnapshotError};

use crate::effects::JointChanges;
use crate::integrate::Ramp;
use crate::model::{Model, Structure};
use std::fmt::Debug;

/// The physics behind an instance. It holds parameters and work space; what it remembers from step to
/// step is in `state` and `values`, which belong to the instance, so that saving an instance is a copy.
pub(crate) trait Behaviour: Debug + Send {
    /// Length of the state.
    fn state_len(&self) -> usize;

    /// Writes the state and the outputs at the start of a simulation, from nothing but the inputs in
    /// `values`. On error both are as before.
    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String>;

    /// One step of length `step` (s) with the inputs in `values` and their derivatives in `slopes`, which is empty if
    /// there is none; writes the outputs, and inputs that have run on, to `values`. On error both are as before.
    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        slopes: &[Option<f64>],
        step: f64,
        tolerance: f64,
    ) -> Result<(), String>;

    /// Derivatives of all outputs with respect to time at the end of the last step.
    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String>;

    /// Change of all outputs at the end of the last step, or at the start, when the lines of the inputs over it change
    /// by `direction`. `tolerance` is that of the step.
    fn sensitivity(
        &mut self,
        state: &[f64],
        direction: &[Ramp],
        tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String>;
}

/// The normal load that acts, from the one that comes in.
#[derive(Debug, Clone, Copy)]
struct LoadRule {
    joint: JointChanges,
    constant: f64,
}

impl LoadRule {
    fn new(model: &Model) -> Self {
        Self {
            joint: model.changes().joint,
            constant: model.contact.map_or(0.0, |contact| contact.normal_load),
        }
    }

    /// Change of N per change of the input (1).
    fn gain(&self) -> f64 {
        self.joint.load_gain.unwrap_or(1.0)
    }

    /// N, of the `input` (N): all of it, or the share of its change that reaches the contact.
    fn acting(&self, input: f64) -> f64 {
        match self.joint.load_gain {
            None => input,
            Some(_) => self.joint.normal_load(self.constant, Some(input)),
        }
    }
}

/// The variable table of a model whose parameters have the rows `parameters`.
fn describe(model: &Model, parameters: Vec<Variable>) -> Result<Description, String> {
    match (&model.structure, &model.contact) {
        (Structure::Prescribed, Some(contact)) => Ok(contact::describe(model, contact, parameters)),
        (Structure::Prescribed, None) => Err("a contact model needs a contact".to_owned()),
        (Structure::Beam(beam), contact) => Ok(beam::describe(model, beam, contact.as_ref(), parameters)),
        (Structure::Oscillator(oscillator), contact) => {
            Ok(oscillator::describe(model, oscillator, contact.as_ref(), parameters))
        }
    }
}

/// The physics of a model.
fn behaviour(model: &Model) -> Result<Box<dyn Behaviour>, String> {
    match (&model.structure, &model.contact) {
        (Structure::Prescribed, _) => Ok(Box::new(contact::ContactBehaviour::new(model)?)),
        (Structure::Beam(beam), _) => beam::behaviour(beam, model),
        (Structure::Oscillator(oscillator), _) => oscillator::behaviour(model, oscillator),
    }
}
