//! Models as co-simulation slaves, and for importers that integrate, without any version of FMI: a variable table and an instance.
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
//! to the end of the step and change in [`Instance::do_step`] only. A force from outside bends the beam's end at once, so
//! that the velocity there has a part that goes with the rate of the force. Forces that are held step by step stand for
//! one that runs: its rate is their difference over the step. A contact point of the model file,
//! `[[contact_point]] position = 0.3`, takes the force of another contact, `contact_force:x=0.3`, and is a sensor as well:
//! `displacement:x=0.3`, `velocity:x=0.3`, `acceleration:x=0.3`. The force is restoring, as that of the support.
//!
//! # Oscillators
//! Masses start at rest. As with a contact, the inputs set before a step are those reached at its end, on a straight
//! line from the previous ones; outputs belong to the end of the step and change in [`Instance::do_step`] only.
//!
//! # Pin rigs
//! A beam whose pin slips and slaps starts at rest under its load. The force set before a step is that reached at its end,
//! on a straight line from the previous one; outputs belong to the end of the step and change in [`Instance::do_step`]
//! only. A communication step is divided into equal steps of the
//! [classical scheme](crate::time::ClassicalSteps), as many as the highest mode and the tolerance ask for.
//!
//! # Where the importer integrates
//! Every model has a continuous-time form as well ([`Template::continuous_instance`]; FMI's model exchange): continuous states are displacements and velocities of the
//! modes, and a contact alone has none. What a contact remembers is discrete: it stays as it was at the last accepted
//! instant ([`Instance::completed_step`], events), from which every look at inputs and states goes. Event indicators
//! change their sign at reversals (the velocity), at stick and slip, and at lift-off (the normal load; of a contact in two
//! directions its normal force, and below zero the distance). A contact alone
//! has reversals between accepted instants only where its `velocity` comes in beside its displacement. Rates of inputs
//! are unknown there: the `velocity` at the end of a beam lacks the part that goes with the rate of the force.
//!
//! # Derivatives of inputs with respect to time
//! FMI 2.0 (4.2.1) sets inputs and their derivatives "with respect to the beginning of a communication time step". With
//! a first derivative d ([`Instance::set_input_derivatives`]) an input of any model therefore begins the step at the
//! value set and is `value + d t` at t from there, and a cubic with the second and third derivatives, which are zero where
//! they are not given. A master that knows values and slopes at both ends of a step can thus give them all. What the previous step ended with is left at once: a beam takes a
//! jump as it takes one without a derivative; a contact, whose force depends on the way there, goes on a straight line
//! from the previous inputs to the values set, in no time, and from there on a straight line to the ends. An input
//! without a derivative meanwhile does as above: with contacts and oscillators it stays during the jump and runs from
//! its previous value to the one set during the step. A derivative of zero is a derivative: it holds a contact's input.
//!
//! The standard does not say how long a derivative lasts. Here it lasts for one step, since a stale one does harm where a
//! master has none to give. The input stays at the value reached, which is what reading it gives and what holds, or is
//! the start of a straight line, in the next step.
//!
//! # Derivatives of outputs with respect to time
//! [`Instance::output_derivatives`] gives the first ones at the end of the last step, coming from within the step: of
//! displacements the velocity and so on, of a contact force its tangents times the rates of displacement, velocity and
//! normal load, of an acceleration the equation of motion differentiated. That of the dissipated energy is the mean
//! power over the step (of a contact without its jump), and what curvature of the contact law adds to the acceleration
//! of a [frictional beam](crate::time)'s contact is looked up a moment ahead. Higher orders would need the second
//! derivatives of inputs; `maxOutputDerivativeOrder` is 1.
//!
//! # Derivatives of outputs with respect to inputs
//! FMI 2.0 (2.1.9) refers to the mathematical description of co-simulation (4.1.2) for what is differentiated. There
//! outputs are what `fmi2DoStep` makes of the inputs set before it, and no call can make others of them before the next
//! step. [`Instance::directional_derivative`] is that derivative: of the outputs at the end of the last step by the
//! inputs with which it was made, the state at its beginning and the derivatives set for inputs being what they were.
//! It is what repeating the step from a saved state with other inputs would show, and what Newton's method on
//! the interface of coupled models needs. As `h → 0` it becomes the direct feed-through at a communication point, on
//! which the dependencies in [`Description`] are based: those of a beam have no path through the motion, the
//! derivative has. In the initialization, and until the first step, it is the derivative of the initial outputs.
//!
//! Nothing is differenced but what no law tells, the dissipated energy and the curvature of a contact's loop, and the
//! steps of pin rigs, which are repeated with the inputs a little to either side. Elsewhere the step
//! is repeated with its linearisation: modes, contact forces and the memory of the law carry the change along, through
//! reversals and from stick to slip, and the step itself costs no more for it. On a kink it is one of the
//! two derivatives. [`Instance::line_derivative`] changes starts and ends of the inputs' lines separately.

mod continuous;
mod derivatives;
mod description;
mod error;
mod further;
mod instance;
mod kinds;
mod lines;
mod parameter;
mod saving;
mod snapshot;
mod stage;
mod template;
mod values;

pub use continuous::ContinuousForm;
pub use derivatives::{DERIVATIVE_ORDER, INPUT_DERIVATIVE_ORDER};
pub use description::{
    Causality, Dependency, DependencyKind, Description, Experiment, Initial, Variability, Variable,
    VariableType,
};
pub use error::Error;
pub use further::{Further, Shows};
pub use instance::Instance;
pub use snapshot::{Snapshot, SnapshotError};
pub use stage::{Setup, Stage};
pub use template::Template;

use crate::time::Ramp;
use std::fmt;

/// What a master asks of a step besides the values.
#[derive(Debug)]
pub(crate) struct Asked {
    /// Derivatives of the inputs with respect to time; empty if there is none.
    pub slopes: Vec<Option<lines::Derivatives>>,
    /// Relative, of the integration inside.
    pub tolerance: f64,
}

/// Not what is in it: every FMU would carry what it takes to write out an integrator.
impl fmt::Debug for dyn Behaviour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Behaviour")
    }
}

/// The physics behind an instance. It holds parameters and work space; what it remembers from step to
/// step is in `state` and `values`, which belong to the instance, so that saving an instance is a copy.
pub(crate) trait Behaviour: continuous::ContinuousTime + Send {
    /// Length of the state.
    fn state_len(&self) -> usize;

    /// Writes the state and the outputs at the start of a simulation, from nothing but the inputs in
    /// `values`. On error both are as before.
    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String>;

    /// One step of length `step` (s) with the inputs in `values`; writes the outputs, and inputs that have run on, to
    /// `values`. On error both are as before. (Arguments and outcome are as many as go through registers.)
    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        asked: &Asked,
        step: f64,
    ) -> Result<(), Box<str>>;

    /// Derivatives of all outputs with respect to time at the end of the last step.
    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String>;

    /// Change of all outputs at the end of the last step, or at the start, when the lines of the inputs over it change
    /// by `direction`; those of which the table's row is not in `unknowns` may be left zero. `tolerance` is that of the step.
    fn sensitivity(
        &mut self,
        state: &[f64],
        unknowns: &[u32],
        direction: &[Ramp],
        tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String>;
}
