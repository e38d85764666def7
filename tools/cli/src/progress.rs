//! Progress on the terminal, and Ctrl-C.

use std::io::IsTerminal as _;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

fn flag() -> &'static AtomicBool {
    static INTERRUPTED: OnceLock<AtomicBool> = OnceLock::new();
    INTERRUPTED.get_or_init(|| AtomicBool::new(false))
}

/// From here on the first Ctrl-C asks long work to stop with what it has; the second ends the program.
pub fn catch_interrupts() {
    let _ = ctrlc::set_handler(|| {
        if flag().swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    });
}

/// Whether Ctrl-C was pressed.
pub fn interrupted() -> bool {
    flag().load(Ordering::SeqCst)
}

/// A line that shows what is being worked on; invisible when standard error is not a terminal.
pub fn spinner(what: &str) -> ProgressBar {
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}: {msg} [{elapsed}]") {
        bar.set_style(style);
    }
    bar.set_prefix(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// How far long work has come: a bar on a terminal, elsewhere a line now and then.
pub struct Meter {
    bar: ProgressBar,
    /// When the last line was printed where there is no terminal.
    line: Option<Mutex<Instant>>,
    start: Instant,
}

/// Between two lines where there is no terminal.
const LINES: Duration = Duration::from_secs(10);

impl Meter {
    /// Nothing done yet.
    pub fn new() -> Self {
        let bar = ProgressBar::new(0);
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} [{elapsed}]") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        let start = Instant::now();
        Self { bar, line: (!std::io::stderr().is_terminal()).then(|| Mutex::new(start)), start }
    }

    /// `done` of `of` parts are done; `what` says which is next.
    pub fn show(&self, what: &str, done: usize, of: usize) {
        self.bar.set_length(of as u64);
        self.bar.set_position(done as u64);
        self.bar.set_message(what.to_owned());
        // A line that another thread is printing is not worth waiting for.
        if let Some(mut last) = self.line.as_ref().and_then(|line| line.try_lock().ok())
            && last.elapsed() >= LINES
        {
            *last = Instant::now();
            eprintln!("{done}/{of} {what} ({:.0} s)", self.start.elapsed().as_secs_f64());
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        self.bar.finish_and_clear();
    }
}
