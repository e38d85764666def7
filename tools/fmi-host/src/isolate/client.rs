//! The slave whose FMU runs elsewhere.

use std::collections::VecDeque;
use std::fmt;
use std::io::{self, Read, Write};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use stickslip::cosim::{self, Abilities, Setup, Severity, SlaveError, Stepped, Variable};

use super::protocol::{Call, Frame, Garbled, Reader, severity};
use crate::import::{Fmu, ImportProblem};
use crate::log::Log;
use crate::slave::{abilities, name_unit, table};

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

/// How long a process may take to end on request.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long a process may take to answer once the run is interrupted.
const GRACE: Duration = Duration::from_secs(1);
/// Bytes of what a process writes to standard error that are kept: the last ones.
const LAST_WORDS: usize = 2000;

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

    fn set_input_derivatives(&mut self, variables: &[usize], derivatives: &[f64]) -> Result<(), SlaveError> {
        let request = |frame: &mut Frame| {
            frame.positions(variables);
            frame.numbers(derivatives);
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

/// The other process and the connection with it.
struct Process {
    child: Child,
    to: Box<dyn Write + Send>,
    from: Box<dyn Read + Send>,
    words: Arc<Mutex<VecDeque<u8>>>,
    listener: Option<JoinHandle<()>>,
}

impl Process {
    fn start(mut command: Command, interrupted: fn() -> bool) -> io::Result<Self> {
        command.stderr(Stdio::piped());
        // Ctrl-C is for the master, which then ends its slaves in order.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(&mut command, 0);
        let (mut child, to, from) = connected(command, interrupted)?;
        let words = Arc::new(Mutex::new(VecDeque::new()));
        let listener = child.stderr.take().map(|errors| {
            let words = Arc::clone(&words);
            std::thread::spawn(move || listen(errors, &words))
        });
        Ok(Self { child, to, from, words, listener })
    }

    /// Waits until the process has ended, or ends it; how it ended by itself.
    fn end(&mut self, patience: Duration) -> Option<std::process::ExitStatus> {
        let begin = Instant::now();
        while begin.elapsed() < patience {
            match self.child.try_wait() {
                Ok(Some(status)) => return Some(status),
                Ok(None) => std::thread::sleep(Duration::from_millis(5)),
                Err(_) => break,
            }
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
        None
    }

    /// What it wrote to standard error last, on one line. Only after its end.
    fn last_words(&mut self) -> String {
        if let Some(listener) = self.listener.take() {
            let _ = listener.join();
        }
        let words = self.words.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes: Vec<u8> = words.iter().copied().collect();
        let text = String::from_utf8_lossy(&bytes);
        let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
        lines.join(" / ")
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        // The process ends when it is not connected any more.
        self.to = Box::new(io::sink());
        self.from = Box::new(io::empty());
        self.end(PATIENCE);
    }
}

fn listen(mut errors: ChildStderr, words: &Mutex<VecDeque<u8>>) {
    let mut buffer = [0; 1024];
    while let Ok(read @ 1..) = errors.read(&mut buffer) {
        let mut words = words.lock().unwrap_or_else(PoisonError::into_inner);
        words.extend(&buffer[..read]);
        let surplus = words.len().saturating_sub(LAST_WORDS);
        words.drain(..surplus);
    }
}

type Connected = (Child, Box<dyn Write + Send>, Box<dyn Read + Send>);

/// Starts the process with a socket for its standard input, which works both ways.
#[cfg(unix)]
fn connected(mut command: Command, interrupted: fn() -> bool) -> io::Result<Connected> {
    use std::os::fd::OwnedFd;
    use std::os::unix::net::UnixStream;
    /// How often it is looked whether there is an interrupt.
    const LOOK: Duration = Duration::from_millis(100);
    let (here, there) = UnixStream::pair()?;
    let child = command.stdin(OwnedFd::from(there)).stdout(Stdio::null()).spawn()?;
    // The command keeps its end of the socket open, and the end of the process would not be noticed.
    drop(command);
    let to = here.try_clone()?;
    here.set_read_timeout(Some(LOOK))?;
    Ok((child, Box::new(to), Box::new(io::BufReader::new(Answers { socket: here, interrupted }))))
}

/// What the process answers. It may take as long as it likes, until there is an interrupt.
#[cfg(unix)]
struct Answers {
    socket: std::os::unix::net::UnixStream,
    interrupted: fn() -> bool,
}

#[cfg(unix)]
impl Read for Answers {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let mut since = None;
        loop {
            match self.socket.read(buffer) {
                Err(error) if matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::TimedOut) => {
                    if (self.interrupted)() && since.get_or_insert_with(Instant::now).elapsed() >= GRACE {
                        return Err(io::ErrorKind::TimedOut.into());
                    }
                }
                other => return other,
            }
        }
    }
}

#[cfg(not(unix))]
fn connected(mut command: Command, _interrupted: fn() -> bool) -> io::Result<Connected> {
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn()?;
    match (child.stdin.take(), child.stdout.take()) {
        (Some(to), Some(from)) => Ok((child, Box::new(to), Box::new(io::BufReader::new(from)))),
        _ => Err(io::Error::other("no connection")),
    }
}
