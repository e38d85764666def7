//! A process with which frames are exchanged: its start, its end, and what it says last.

use std::collections::VecDeque;
use std::io::{self, Read, Write};
use std::process::{Child, ChildStderr, Command, Stdio};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// How long a process may take to end on request.
pub const PATIENCE: Duration = Duration::from_secs(2);
/// How long a process may take to answer once the run is interrupted.
const GRACE: Duration = Duration::from_secs(1);
/// Bytes of what a process writes to standard error that are kept: the last ones.
const LAST_WORDS: usize = 2000;

/// The other process and the connection with it.
pub struct Process {
    pub child: Child,
    pub to: Box<dyn Write + Send>,
    pub from: Box<dyn Read + Send>,
    words: Arc<Mutex<VecDeque<u8>>>,
    listener: Option<JoinHandle<()>>,
}

impl Process {
    pub fn start(mut command: Command, interrupted: fn() -> bool) -> io::Result<Self> {
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
    pub fn end(&mut self, patience: Duration) -> Option<std::process::ExitStatus> {
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
    pub fn last_words(&mut self) -> String {
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
