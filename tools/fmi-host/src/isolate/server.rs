//! The process that runs one FMU and nothing else.

use std::io::{self, Read, Write};
use std::path::Path;

use stickslip::cosim::{Severity, Slave, SlaveError, Stepped};

use super::protocol::{Call, Frame, Garbled, Reader, severity_number};
use crate::import::Fmu;
use crate::slave::FmuSlave;

/// Instantiates the FMU that is unpacked in `folder`, and that the user knows as `fmu`, as `name`, and does what the process that started this one asks
/// for, until that goes away. What the FMU prints is nobody's concern: nothing is said over standard output.
///
/// # Errors
/// A standard input that is not the connection [`crate::Fmu::isolated`] made.
pub fn serve(folder: &Path, fmu: &str, name: &str) -> io::Result<()> {
    #[cfg(unix)]
    std::thread::spawn(end_with_the_master);
    let (mut from, mut to) = connection()?;
    let mut answer = Frame::default();
    let slave = Fmu::in_folder(folder, fmu).and_then(|fmu| fmu.instantiate(name));
    let mut slave = match slave {
        Ok(slave) => {
            respond(&mut answer, Some(&slave), Ok(()), |_| {});
            answer.write(&mut to)?;
            slave
        }
        Err(error) => {
            let message = error.problem.to_string();
            let failed = SlaveError { slave: name.to_owned(), message, severity: Severity::Slave };
            respond(&mut answer, None, Err(failed), |_: &mut Frame| {});
            return answer.write(&mut to);
        }
    };
    let mut request = Frame::default();
    let mut space = Space::default();
    loop {
        match request.read(&mut from) {
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => return Ok(()),
            other => other?,
        }
        let mut reader = request.reader();
        let done = obey(&mut slave, &mut reader, &mut space);
        let done = done.map_err(|Garbled| io::Error::other("a request that cannot be read"))?;
        respond(&mut answer, Some(&slave), done, |answer| answer.numbers(&space.results));
        answer.write(&mut to)?;
    }
}

/// Ends this process with the one that started it, whatever the FMU is doing: it may never come back from a call.
#[cfg(unix)]
fn end_with_the_master() {
    use std::os::unix::process::parent_id;
    let master = parent_id();
    while parent_id() == master {
        std::thread::sleep(std::time::Duration::from_millis(500));
    }
    crate::binding::end_at_once()
}

/// Room for the numbers of a call.
#[derive(Debug, Default)]
struct Space {
    variables: Vec<usize>,
    others: Vec<usize>,
    values: Vec<f64>,
    results: Vec<f64>,
}

/// Does what the request says; numbers that come out are in `space.results`.
fn obey(
    slave: &mut FmuSlave,
    request: &mut Reader<'_>,
    space: &mut Space,
) -> Result<Result<(), SlaveError>, Garbled> {
    let Space { variables, others, values, results } = space;
    results.clear();
    let call = Call::from_number(request.byte()?).ok_or(Garbled)?;
    Ok(match call {
        Call::SetUp => slave.set_up(request.setup()?),
        Call::EnterInitialization => slave.enter_initialization(),
        Call::ExitInitialization => slave.exit_initialization(),
        Call::Terminate => slave.terminate(),
        Call::Save => slave.save(request.count()?),
        Call::Restore => slave.restore(request.count()?),
        Call::Set | Call::SetInputDerivatives => {
            request.positions(variables)?;
            request.numbers(values)?;
            if call == Call::Set {
                slave.set(variables, values)
            } else {
                let order = request.count()? as u32;
                slave.set_input_derivatives(variables, order, values)
            }
        }
        Call::Get => {
            request.positions(variables)?;
            results.resize(variables.len(), 0.0);
            slave.get(variables, results)
        }
        Call::OutputDerivatives => {
            request.positions(variables)?;
            let order = request.count()? as u32;
            results.resize(variables.len(), 0.0);
            slave.output_derivatives(variables, order, results)
        }
        Call::DirectionalDerivative => {
            request.positions(variables)?;
            request.positions(others)?;
            request.numbers(values)?;
            results.resize(variables.len(), 0.0);
            slave.directional_derivative(variables, others, values, results)
        }
        Call::DoStep => {
            let (time, step) = (request.number()?, request.number()?);
            slave.do_step(time, step).map(|stepped| {
                if let Stepped::Discarded(reached) = stepped {
                    results.push(reached);
                }
            })
        }
        Call::SetText => {
            let variable = request.text()?;
            slave.set_text(&variable, &request.text()?)
        }
    })
}

/// Writes an answer: messages, whether it succeeded, and what came out.
fn respond(
    answer: &mut Frame,
    slave: Option<&FmuSlave>,
    done: Result<(), SlaveError>,
    results: impl FnOnce(&mut Frame),
) {
    answer.clear();
    answer.messages(&slave.map(|slave| slave.log().take()).unwrap_or_default());
    match done {
        Ok(()) => {
            answer.byte(0);
            results(answer);
        }
        Err(error) => {
            answer.byte(1);
            answer.byte(severity_number(error.severity));
            answer.text(&error.message);
        }
    }
}

/// Both directions. On Unix, standard input is a socket, so that what the FMU prints on standard output is not taken
/// for an answer.
#[cfg(unix)]
fn connection() -> io::Result<(impl Read, impl Write)> {
    use std::os::fd::AsFd as _;
    use std::os::unix::net::UnixStream;
    let socket = UnixStream::from(io::stdin().as_fd().try_clone_to_owned()?);
    Ok((io::BufReader::new(socket.try_clone()?), socket))
}

#[cfg(not(unix))]
fn connection() -> io::Result<(impl Read, impl Write)> {
    Ok((io::stdin().lock(), io::stdout().lock()))
}
