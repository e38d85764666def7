//! An instance of an FMU as a slave of the master.
//!
//! [`table`] is what the master sees of an FMU, `component` the FMU's functions of either version, `values` sets and reads
//! variables by their kinds, `arrays` those of FMI 3.0 by their types.

mod arrays;
mod component;
pub(crate) mod table;
mod values;

pub(crate) use component::Component;

use std::sync::Arc;

use stickslip::cosim::{self, Abilities, Setup, Severity, SlaveError, Stepped, Variable};

use crate::binding::Status;
use crate::component::{Error, State};
use crate::description::{FmiVersion, Passed, TypeOfVariable};
use crate::import::{Fmu, Lone};
use crate::log::Log;
use table::{abilities, name_unit, table};
use values::Reals;

/// An instance in this process.
#[derive(Debug)]
pub struct FmuSlave {
    name: String,
    slave: Component,
    table: Vec<Variable>,
    /// How each row of the table is passed, in FMI 3.0.
    passed: Vec<Passed>,
    abilities: Abilities,
    slots: Vec<Option<State>>,
    /// What was set last, and what was read.
    inputs: Reals,
    outputs: Reals,
    /// Value references and whole numbers of a call.
    references: Vec<u32>,
    others: Vec<u32>,
    numbers: Vec<i32>,
    /// An earlier call made it useless.
    lost: Option<Severity>,
    fmu: Arc<Fmu>,
    _lone: Option<Lone>,
}

impl FmuSlave {
    pub(crate) fn new(fmu: Arc<Fmu>, name: &str, slave: Component, lone: Option<Lone>) -> Self {
        let description = fmu.description();
        Self {
            name: name.to_owned(),
            table: table(description),
            passed: description
                .variables
                .iter()
                .filter(|row| description.version == FmiVersion::Three && row.kind.is_number())
                .map(|row| row.passed)
                .collect(),
            abilities: abilities(description),
            slave,
            slots: Vec::new(),
            inputs: Reals::default(),
            outputs: Reals::default(),
            references: Vec::new(),
            others: Vec::new(),
            numbers: Vec::new(),
            lost: None,
            fmu,
            _lone: lone,
        }
    }

    /// What it says.
    pub fn log(&self) -> &Arc<Log> {
        self.slave.log()
    }

    /// The FMU it is an instance of.
    pub fn fmu(&self) -> &Arc<Fmu> {
        &self.fmu
    }

    /// Gives a variable without a unit the one that somebody else knows.
    pub fn name_unit(&mut self, variable: &str, unit: &str) {
        name_unit(&mut self.table, variable, unit);
    }

    /// Sets a String variable, which the master does not know.
    ///
    /// # Errors
    /// A variable that is no String, and what the FMU objects to.
    pub fn set_text(&mut self, variable: &str, text: &str) -> Result<(), SlaveError> {
        let rows = &self.fmu.description().variables;
        let row = rows.iter().find(|row| *row.name == *variable && row.kind == TypeOfVariable::String);
        let Some(row) = row else { return Err(self.refused(format!("`{variable}` is no String"))) };
        let reference = row.reference;
        let done = self.slave.set_string(reference, text);
        done.map_err(|error| self.failed(error, || format!("setting `{variable}` to {text:?}")))
    }

    /// The value of a String variable.
    ///
    /// # Errors
    /// As [`FmuSlave::set_text`].
    pub fn text(&mut self, variable: &str) -> Result<String, SlaveError> {
        let rows = &self.fmu.description().variables;
        let row = rows.iter().find(|row| *row.name == *variable && row.kind == TypeOfVariable::String);
        let Some(row) = row else { return Err(self.refused(format!("`{variable}` is no String"))) };
        let reference = row.reference;
        self.slave
            .get_string(reference)
            .map_err(|error| self.failed(error, || format!("reading `{variable}`")))
    }

    /// The state in slot `slot` as bytes, with which another process can go on.
    ///
    /// # Errors
    /// An empty slot, an FMU that cannot, and what it objects to.
    pub fn serialized(&mut self, slot: usize) -> Result<Vec<u8>, SlaveError> {
        let Some(state) = self.slots.get(slot).and_then(Option::as_ref) else {
            return Err(self.refused(format!("nothing was saved in slot {slot}")));
        };
        let bytes = self.slave.serialize(state);
        bytes.map_err(|error| self.failed(error, || "writing a saved state as bytes".to_owned()))
    }

    /// Puts a state that was written as bytes in slot `slot`.
    ///
    /// # Errors
    /// What the FMU objects to.
    pub fn deserialize(&mut self, slot: usize, bytes: &[u8]) -> Result<(), SlaveError> {
        let state = self.slave.deserialize(bytes);
        let state =
            state.map_err(|error| self.failed(error, || "reading a saved state from bytes".to_owned()))?;
        if let Some(old) = self.slot(slot).replace(state) {
            let _ = self.slave.free(old);
        }
        Ok(())
    }

    fn slot(&mut self, slot: usize) -> &mut Option<State> {
        if self.slots.len() <= slot {
            self.slots.resize_with(slot + 1, || None);
        }
        &mut self.slots[slot]
    }

    /// A call that was not even tried.
    fn refused(&self, message: String) -> SlaveError {
        SlaveError { slave: self.name.clone(), message, severity: Severity::Call }
    }

    /// A call that failed; `what` says what was being done.
    fn failed(&mut self, error: Error, what: impl FnOnce() -> String) -> SlaveError {
        let severity = match &error {
            Error::Call { status: Status::Fatal, .. } => Severity::Fatal,
            Error::Call { status: Status::Discard, .. } => Severity::Call,
            Error::Call { .. } => Severity::Slave,
            _ => Severity::Call,
        };
        if severity != Severity::Call {
            self.lost = self.lost.max_with(severity);
        }
        let mut message = format!("{} ({}): {error}", what(), self.fmu.name());
        if let Some(words) = self.slave.log().take_failure() {
            message.push_str("; the FMU says: ");
            message.push_str(&words);
        }
        SlaveError { slave: self.name.clone(), message, severity }
    }

    /// Names of variables for a message.
    fn named(&self, variables: &[usize]) -> String {
        let mut text = String::new();
        for (index, variable) in variables.iter().enumerate() {
            if index == 6 {
                text += &format!(" and {} more", variables.len() - index);
                break;
            }
            let name = self.table.get(*variable).map_or("?", |row| &*row.name);
            text += if index == 0 { "`" } else { ", `" };
            text += name;
            text += "`";
        }
        text
    }
}

/// The worse of two.
trait MaxWith {
    fn max_with(self, other: Severity) -> Self;
}

impl MaxWith for Option<Severity> {
    fn max_with(self, other: Severity) -> Self {
        if self == Some(Severity::Fatal) { self } else { Some(other) }
    }
}

impl cosim::Slave for FmuSlave {
    fn name(&self) -> &str {
        &self.name
    }

    fn variables(&self) -> &[Variable] {
        &self.table
    }

    fn abilities(&self) -> Abilities {
        self.abilities
    }

    fn set_up(&mut self, setup: Setup) -> Result<(), SlaveError> {
        let done = self.slave.set_up_until(setup.tolerance, setup.start, setup.stop);
        done.map_err(|error| self.failed(error, || "being set up".to_owned()))
    }

    fn enter_initialization(&mut self) -> Result<(), SlaveError> {
        let done = self.slave.enter_initialization();
        done.map_err(|error| self.failed(error, || "entering its initialization".to_owned()))
    }

    fn exit_initialization(&mut self) -> Result<(), SlaveError> {
        let done = self.slave.exit_initialization();
        done.map_err(|error| self.failed(error, || "leaving its initialization".to_owned()))
    }

    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        match self.inputs.references_of(variables) {
            Some(references) if references.len() == values.len() => {
                let done = self.slave.set_real(references, values);
                done.map_err(|error| self.not_set(error, variables, values))
            }
            _ => self.set_of_all_kinds(variables, values),
        }
    }

    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        match self.outputs.references_of(variables) {
            Some(references) if references.len() == values.len() => {
                let done = self.slave.get_real(references, values);
                done.map_err(|error| self.not_read(error, variables))
            }
            _ => self.get_of_all_kinds(variables, values),
        }
    }

    fn set_input_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &[f64],
    ) -> Result<(), SlaveError> {
        self.references_of(variables)?;
        let done = match &mut self.slave {
            Component::Two(slave) => {
                self.numbers.clear();
                self.numbers.resize(variables.len(), order.cast_signed());
                slave.set_input_derivatives(&self.references, &self.numbers, derivatives)
            }
            Component::Three(slave) => {
                slave.set_input_derivatives(&self.references, order, derivatives);
                Ok(())
            }
        };
        done.map_err(|error| {
            let names = self.named(variables);
            self.failed(error, || format!("setting derivatives of {names}"))
        })
    }

    fn output_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        self.references_of(variables)?;
        let Component::Two(slave) = &mut self.slave else {
            return self.output_derivatives_3(variables, order.cast_signed(), derivatives);
        };
        self.numbers.clear();
        self.numbers.resize(variables.len(), order.cast_signed());
        let done = slave.get_output_derivatives(&self.references, &self.numbers, derivatives);
        done.map_err(|error| {
            let names = self.named(variables);
            self.failed(error, || format!("reading derivatives of {names}"))
        })
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        self.references_of(unknowns)?;
        std::mem::swap(&mut self.references, &mut self.others);
        self.references_of(knowns)?;
        let done = match &mut self.slave {
            Component::Two(slave) => {
                slave.directional_derivative(&self.others, &self.references, direction, change)
            }
            Component::Three(_) => self.directional_derivative_3(unknowns, knowns, direction, change),
        };
        done.map_err(|error| {
            let (of, on) = (self.named(unknowns), self.named(knowns));
            self.failed(error, || format!("the derivative of {of} with respect to {on}"))
        })
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        let done = self.slave.do_step(time, step, !self.abilities.saves_state);
        let what = || format!("the step from {time} s to {} s", time + step);
        let discarded = matches!(done, Err(Error::Call { status: Status::Discard, .. }));
        match done {
            Ok(()) if !self.slave.wants_to_end(false) => Ok(Stepped::Done),
            Ok(()) | Err(Error::Call { status: Status::Discard, .. }) => {
                if self.slave.wants_to_end(discarded) {
                    let words = self
                        .slave
                        .log()
                        .take_failure()
                        .map_or_else(String::new, |words| format!(": {words}"));
                    let message = format!(
                        "{} ({}): the FMU asks for the end of the simulation{words}",
                        what(),
                        self.fmu.name()
                    );
                    return Err(SlaveError { slave: self.name.clone(), message, severity: Severity::Slave });
                }
                // An FMU that does not tell how far it came is taken not to have come anywhere.
                let reached = self.slave.reached();
                Ok(Stepped::Discarded(reached.map_or(time, |reached| reached.clamp(time, time + step))))
            }
            Err(error) => Err(self.failed(error, what)),
        }
    }

    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        let saved = match self.slot(slot).take() {
            Some(mut state) => {
                let saved = self.slave.save_again(&mut state);
                *self.slot(slot) = Some(state);
                saved
            }
            None => self.slave.save().map(|state| *self.slot(slot) = Some(state)),
        };
        saved.map_err(|error| self.failed(error, || "saving its state".to_owned()))
    }

    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        let Some(state) = self.slots.get(slot).and_then(Option::as_ref) else {
            return Err(self.refused(format!("nothing was saved in slot {slot}")));
        };
        let done = self.slave.restore(state);
        done.map_err(|error| self.failed(error, || "going back to a saved state".to_owned()))?;
        if self.lost == Some(Severity::Slave) {
            self.lost = None;
        }
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), SlaveError> {
        // FMI: not after an error.
        if self.lost.is_some() {
            return Ok(());
        }
        let done = self.slave.terminate();
        done.map_err(|error| self.failed(error, || "being ended".to_owned()))
    }
}

impl Drop for FmuSlave {
    fn drop(&mut self) {
        for state in self.slots.drain(..).flatten() {
            // After a fatal error this fails, and leaks.
            let _ = self.slave.free(state);
        }
    }
}
