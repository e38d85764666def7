//! The interface of a slave: the same for native models and FMUs.
//!
//! native.rs: one of this library's models; source.rs: signals of time alone.

mod native;
mod source;

pub use native::NativeSlave;
pub use source::Source;

use std::fmt::Debug;
use std::sync::Arc;

/// What kind of number a variable is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A floating point number.
    Real,
    /// A whole number, or an item of an enumeration.
    Integer,
    /// True or false; 1 or 0 here.
    Boolean,
}

/// Who sets a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// The user, before the simulation.
    Parameter,
    /// Other slaves.
    Input,
    /// The slave.
    Output,
    /// The slave; others should not use it.
    Local,
}

/// A variable of a slave. A slave may have a million of them: texts are shared with whatever describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its name, unique in the slave.
    pub name: Arc<str>,
    /// By which it is set and read.
    pub reference: u32,
    /// What kind of number.
    pub kind: Kind,
    /// Who sets it.
    pub causality: Causality,
    /// Its unit as the slave writes it.
    pub unit: Option<Arc<str>>,
    /// Its value unless set, where the slave declares it.
    pub start: Option<f64>,
    /// Of an output: the positions in the table of the inputs on which it depends at a communication point;
    /// absent where the slave does not declare them, which means all.
    pub depends_on: Option<Arc<[usize]>>,
}

/// What a slave can do besides stepping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Abilities {
    /// [`Slave::save`] and [`Slave::restore`].
    pub saves_state: bool,
    /// Steps of different lengths.
    pub variable_step: bool,
    /// [`Slave::set_input_derivatives`].
    pub interpolates_inputs: bool,
    /// Highest order of those; 0 counts as 1 where inputs are interpolated.
    pub input_derivative_order: u32,
    /// Highest order of [`Slave::output_derivatives`]; 0: none.
    pub output_derivative_order: u32,
    /// [`Slave::directional_derivative`].
    pub directional_derivatives: bool,
}

/// The frame of a simulation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Setup {
    /// Relative tolerance inside the slave; its own where absent.
    pub tolerance: Option<f64>,
    /// Start (s).
    pub start: f64,
    /// Stop (s).
    pub stop: Option<f64>,
}

/// How a step ended that did not fail.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stepped {
    /// At its end.
    Done,
    /// The slave stopped within the step at this time (s); it can be restored and continue with a shorter step.
    Discarded(f64),
}

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Severity {
    /// This call failed; the slave is as before and can go on.
    Call,
    /// The slave cannot go on, others can.
    Slave,
    /// The slave has ended its process, or reports that every instance is lost.
    Fatal,
}

/// Why a slave did not carry out a call.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{slave}: {message}")]
pub struct SlaveError {
    /// The slave's name in the system.
    pub slave: String,
    /// What happened, with the variable if one is to blame, and the slave's own words if it said any.
    pub message: String,
    /// How bad it is.
    pub severity: Severity,
}

/// The answer of a slave without the ability.
fn unable(slave: &str, what: &str) -> SlaveError {
    SlaveError { slave: slave.to_owned(), message: format!("it cannot {what}"), severity: Severity::Call }
}

/// A slave: a model, or an FMU. Calls come in the order of FMI 2.0 co-simulation: [`Slave::set_up`],
/// [`Slave::enter_initialization`], [`Slave::exit_initialization`], steps, [`Slave::terminate`].
/// What needs an ability fails unless the slave has it.
pub trait Slave: Debug + Send {
    /// Its name in the system.
    fn name(&self) -> &str;

    /// Its table of variables, always the same.
    fn variables(&self) -> &[Variable];

    /// Whether its outputs may have corners at communication points; between those they are then straight.
    fn has_corners(&self) -> bool {
        false
    }

    /// What it can do.
    fn abilities(&self) -> Abilities;

    /// Sets the frame of the simulation.
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn set_up(&mut self, setup: Setup) -> Result<(), SlaveError> {
        let _ = setup;
        Ok(())
    }

    /// Begins the initialization.
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn enter_initialization(&mut self) -> Result<(), SlaveError> {
        Ok(())
    }

    /// Ends the initialization.
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn exit_initialization(&mut self) -> Result<(), SlaveError> {
        Ok(())
    }

    /// Sets variables of any kind, by their positions in the table.
    ///
    /// # Errors
    /// A value the slave refuses; the message names the variable.
    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError>;

    /// Reads variables of any kind, by their positions in the table.
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError>;

    /// Sets derivatives of Real inputs with respect to time, of `order` from 1 up to
    /// [`Abilities::input_derivative_order`], for the next step, which begins at the value last set: with the first alone
    /// the input at `t` is `value + derivative · t` after the step's beginning. Only with
    /// [`Abilities::interpolates_inputs`].
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn set_input_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &[f64],
    ) -> Result<(), SlaveError> {
        let _ = (variables, order, derivatives);
        Err(unable(self.name(), "interpolate inputs"))
    }

    /// Reads derivatives of Real outputs with respect to time at the end of the last step, of `order` 1 up to
    /// [`Abilities::output_derivative_order`].
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn output_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        let _ = (variables, order, derivatives);
        Err(unable(self.name(), "give derivatives of outputs"))
    }

    /// Change of the outputs `unknowns` at the end of the last step when the inputs `knowns` of that step change by
    /// `direction`; before the first step, of the initial outputs. A slave may leave out what passes through its
    /// motion within the step. Only with [`Abilities::directional_derivatives`].
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn directional_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        let _ = (unknowns, knowns, direction, change);
        Err(unable(self.name(), "give directional derivatives"))
    }

    /// As [`Slave::directional_derivative`], where only the ends of the inputs that ran over the last step change
    /// and their beginnings stay: `direction` has the changes of their ends, `slopes` those of their slopes there, times the
    /// step; it is empty where they ran linearly. A slave that cannot distinguish the two answers as there, which is
    /// the same but for what passes through its motion within the step.
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn end_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        slopes: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        let _ = slopes;
        self.directional_derivative(unknowns, knowns, direction, change)
    }

    /// Steps from `time` to `time + step` (s).
    ///
    /// # Errors
    /// A step that failed.
    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError>;

    /// Saves its state in slot `slot`; slots count from 0 and hold until overwritten. Only with
    /// [`Abilities::saves_state`].
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        let _ = slot;
        Err(unable(self.name(), "save its state"))
    }

    /// Goes on from where slot `slot` was saved.
    ///
    /// # Errors
    /// An empty slot, or whatever the slave objects to.
    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        let _ = slot;
        Err(unable(self.name(), "restore its state"))
    }

    /// Ends the simulation; values can still be read.
    ///
    /// # Errors
    /// Whatever the slave objects to.
    fn terminate(&mut self) -> Result<(), SlaveError> {
        Ok(())
    }
}
