//! The slave whose FMU runs elsewhere.

use std::fmt;
use std::io;
use std::process::Command;
use std::sync::Arc;
use std::time::Duration;

use stickslip::cosim::{self, Abilities, Setup, Severity, SlaveError, Stepped, Variable};

use super::process::{PATIENCE, Process};
use super::protocol::{Call, Frame, Garbled, Reader, severity};
use crate::import::{Fmu, ImportProblem};
use crate::log::Log;
use crate::slave::table::{abilities, name_unit, table};

/// An instance in a process of its own. A crash over there is an error with [`Severity::Fatal`]; every call after it,
/// too.
pub struct IsolatedSlave {
    name: String,
    table: Vec<Variable>,
    abilities: Abilities,
    log: Arc<Log>,
    process: Process,
    frame: Frame,
    /// Why there is no process any more.
    lost: Option<String>,
    fmu: Arc<Fmu>,
}

impl fmt::Debug for IsolatedSlave {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("IsolatedSlave")
            .field("name", &self.name)
            .field("fmu", &self.fmu.name())
            .field("process", &self.process.child.id())
            .field("lost", &self.lost)
            .finish_non_exhaustive()
    }
}

impl IsolatedSlave {
    pub(crate) fn start(
        fmu: Arc<Fmu>,
        name: &str,
        command: Command,
        interrupted: fn() -> bool,
    ) -> Result<Self, ImportProblem> {
        let failed = |error: io::Error| ImportProblem::Process(error.to_string());
        let process = Process::start(command, interrupted).map_err(failed)?;
        let mut slave = Self {
            name: name.to_owned(),
            table: table(fmu.description()),
            abilities: abilities(fmu.description()),
            log: Arc::new(Log::default()),
            process,
            frame: Frame::default(),
            lost: None,
            fmu,
        };
        // The first answer says whether there is an instance.
        match slave.answer(|| "being instantiated".to_owned(), |_| Ok(())) {
            Ok(()) => Ok(slave),
            Err(error) => Err(ImportProblem::Process(error.message)),
        }
    }

    /// What it says.
    pub fn log(&self) -> &Arc<Log> {
        &self.log
    }

    /// The FMU it is an instance of.
    pub fn fmu(&self) -> &Arc<Fmu> {
        &self.fmu
    }

    /// As [`crate::FmuSlave::name_unit`].
    pub fn name_unit(&mut self, variable: &str, unit: &str) {
        name_unit(&mut self.table, variable, unit);
    }

    /// Number of its process.
    pub fn process_id(&self) -> u32 {
        self.process.child.id()
    }

    /// As [`crate::FmuSlave::set_text`].
    ///
    /// # Errors
    /// As there.
    pub fn set_text(&mut self, variable: &str, text: &str) -> Result<(), SlaveError> {
        self.ask(
            Call::SetText,
            |frame| {
                frame.text(variable);
                frame.text(text);
            },
            || format!("setting `{variable}`"),
        )
    }

    /// A call from which nothing but success comes back.
    fn ask(
        &mut self,
        call: Call,
        request: impl FnOnce(&mut Frame),
        what: impl FnOnce() -> String,
    ) -> Result<(), SlaveError> {
        self.call(call, request, what, |_| Ok(()))
    }

    /// A call from which numbers come back.
    fn call<T>(
        &mut self,
        call: Call,
        request: impl FnOnce(&mut Frame),
        what: impl FnOnce() -> String,
        result: impl FnOnce(&mut Reader<'_>) -> Result<T, Garbled>,
    ) -> Result<T, SlaveError> {
        if let Some(reason) = &self.lost {
            let message = format!("{} ({}): {reason}", what(), self.fmu.name());
            return Err(SlaveError { slave: self.name.clone(), message, severity: Severity::Fatal });
        }
        self.frame.clear();
        self.frame.byte(call as u8);
        request(&mut self.frame);
        if let Err(error) = self.frame.write(&mut self.process.to) {
            return Err(self.gone(&error, what));
        }
        self.answer(what, result)
    }

    fn answer<T>(
        &mut self,
        what: impl FnOnce() -> String,
        result: impl FnOnce(&mut Reader<'_>) -> Result<T, Garbled>,
    ) -> Result<T, SlaveError> {
        if let Err(error) = self.frame.read(&mut self.process.from) {
            return Err(self.gone(&error, what));
        }
        match self.understood(result) {
            Ok(done) => done,
            Err(Garbled) => Err(self.gone(&io::Error::other("its answer cannot be read"), what)),
        }
    }

    fn understood<T>(
        &self,
        result: impl FnOnce(&mut Reader<'_>) -> Result<T, Garbled>,
    ) -> Result<Result<T, SlaveError>, Garbled> {
        let mut reader = self.frame.reader();
        for message in reader.messages()? {
            for _ in 0..message.times.min(1000) {
                self.log.push(message.status, &message.category, &message.text);
            }
        }
        if reader.byte()? == 0 {
            return result(&mut reader).map(Ok);
        }
        let severity = severity(reader.byte()?);
        Ok(Err(SlaveError { slave: self.name.clone(), message: reader.text()?, severity }))
    }

    /// The process does not answer any more.
    fn gone(&mut self, error: &io::Error, what: impl FnOnce() -> String) -> SlaveError {
        let unanswered = error.kind() == io::ErrorKind::TimedOut;
        let mut reason = match self.process.end(if unanswered { Duration::ZERO } else { PATIENCE }) {
            Some(status) => format!("its process has ended ({status})"),
            None if unanswered => {
                "the run was interrupted, the FMU did not answer, and its process was ended".to_owned()
            }
            None => format!("its process cannot be reached: {error}"),
        };
        let words = self.process.last_words();
        if !words.is_empty() {
            reason += &format!("; its last output: {words}");
        }
        let message = format!("{} ({}): {reason}", what(), self.fmu.name());
        self.lost = Some(reason);
        SlaveError { slave: self.name.clone(), message, severity: Severity::Fatal }
    }
}

impl cosim::Slave for IsolatedSlave {
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
        self.ask(Call::SetUp, |frame| frame.setup(setup), || "being set up".to_owned())
    }

    fn enter_initialization(&mut self) -> Result<(), SlaveError> {
        self.ask(Call::EnterInitialization, |_| {}, || "entering its initialization".to_owned())
    }

    fn exit_initialization(&mut self) -> Result<(), SlaveError> {
        self.ask(Call::ExitInitialization, |_| {}, || "leaving its initialization".to_owned())
    }

    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        let request = |frame: &mut Frame| {
            frame.positions(variables);
            frame.numbers(values);
        };
        self.ask(Call::Set, request, || "setting variables".to_owned())
    }

    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        let request = |frame: &mut Frame| frame.positions(variables);
        self.call(Call::Get, request, || "reading variables".to_owned(), |reader| reader.fill(values))
    }

    fn set_input_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &[f64],
    ) -> Result<(), SlaveError> {
        let request = |frame: &mut Frame| {
            frame.positions(variables);
            frame.numbers(derivatives);
            frame.count(order as usize);
        };
        self.ask(Call::SetInputDerivatives, request, || "setting derivatives of inputs".to_owned())
    }

    fn output_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        let request = |frame: &mut Frame| {
            frame.positions(variables);
            frame.count(order as usize);
        };
        let what = || "reading derivatives of outputs".to_owned();
        self.call(Call::OutputDerivatives, request, what, |reader| reader.fill(derivatives))
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        let request = |frame: &mut Frame| {
            frame.positions(unknowns);
            frame.positions(knowns);
            frame.numbers(direction);
        };
        let what = || "a directional derivative".to_owned();
        self.call(Call::DirectionalDerivative, request, what, |reader| reader.fill(change))
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        let request = |frame: &mut Frame| {
            frame.number(time);
            frame.number(step);
        };
        let what = || format!("the step from {time} s to {} s", time + step);
        self.call(Call::DoStep, request, what, |reader| {
            let reached = reader.count()? != 0;
            Ok(if reached { Stepped::Discarded(reader.number()?) } else { Stepped::Done })
        })
    }

    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        self.ask(Call::Save, |frame| frame.count(slot), || "saving its state".to_owned())
    }

    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        self.ask(Call::Restore, |frame| frame.count(slot), || "going back to a saved state".to_owned())
    }

    fn terminate(&mut self) -> Result<(), SlaveError> {
        self.ask(Call::Terminate, |_| {}, || "being ended".to_owned())
    }
}
