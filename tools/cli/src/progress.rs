//! Progress on the terminal, and signals that ask the program to end.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, OnceLock};
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::{Failure, terminal};

fn flag() -> &'static AtomicBool {
    static INTERRUPTED: OnceLock<AtomicBool> = OnceLock::new();
    INTERRUPTED.get_or_init(|| AtomicBool::new(false))
}

/// Whether there are results already, which are to be kept.
static RESULTS: AtomicBool = AtomicBool::new(false);
/// Whether files are being written.
static WRITING: AtomicBool = AtomicBool::new(false);
/// Whether the results are written, and only what is made of them is missing.
static WRITTEN: AtomicBool = AtomicBool::new(false);

/// Work that has no results yet is left so long after an interrupt.
const NOTICE: Duration = Duration::from_millis(800);
/// After an interrupt, a note says after this time what the program waits for.
const PATIENCE: Duration = Duration::from_secs(2);
/// Results that are not ready so long after an interrupt are not waited for.
const LONGEST: Duration = Duration::from_secs(5);

/// From here on the first Ctrl-C (or SIGTERM or SIGHUP) asks long work to stop with what it has, and ends the program within
/// a second where there are no results yet; the second one ends the program in any case.
pub fn catch_interrupts() {
    on_signals(|| {
        if flag().swap(true, Ordering::SeqCst) {
            stickslip_readers::archive::remove_unpacked();
            std::process::exit(130);
        }
        std::thread::spawn(|| {
            std::thread::sleep(NOTICE);
            leave_unless(RESULTS.load(Ordering::SeqCst));
            leave_when_written(PATIENCE - NOTICE);
            tell!(
                "note: interrupted; still waiting for a calculation or an FMU to come back; Ctrl-C again ends at once, \
                 without results"
            );
            leave_when_written(LONGEST - PATIENCE);
            leave_unless(false);
        });
    });
}

/// For so long, ends the program as soon as its results are written.
fn leave_when_written(within: Duration) {
    let begin = Instant::now();
    while begin.elapsed() < within {
        std::thread::sleep(LOOK);
        leave_unless(true);
    }
}

/// Ends the program unless it is `on_its_way` to its results or writes files.
fn leave_unless(on_its_way: bool) {
    let written = WRITTEN.load(Ordering::SeqCst);
    if on_its_way && !written || WRITING.load(Ordering::SeqCst) {
        return;
    }
    if written {
        tell!("note: interrupted: these are the results so far; their report and tables are not written");
    } else {
        tell!("interrupted in the middle of a calculation: there are no results");
    }
    stickslip_readers::archive::remove_unpacked();
    std::process::exit(130);
}

#[cfg(unix)]
fn on_signals(handle: impl Fn() + Send + 'static) {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
    let mut wanted = vec![SIGINT, SIGTERM];
    if !hangups_are_ignored() {
        wanted.push(SIGHUP);
    }
    if let Ok(mut signals) = signal_hook::iterator::Signals::new(wanted) {
        std::thread::spawn(move || signals.forever().for_each(|_| handle()));
    }
}

/// Whether the program was started by `nohup`, to go on when its terminal is closed.
#[cfg(unix)]
fn hangups_are_ignored() -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let ignored = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    // SIGHUP is the first signal.
    ignored.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask & 1 != 0)
}

#[cfg(not(unix))]
fn on_signals(handle: impl Fn() + Send + 'static) {
    let _ = ctrlc::set_handler(handle);
}

/// Whether the program was asked to end.
pub fn interrupted() -> bool {
    flag().load(Ordering::SeqCst)
}

/// From here on there are results, which an interrupt keeps: the work is given a little time to come back with them.
pub fn results_exist() {
    RESULTS.store(true, Ordering::SeqCst);
}

/// The same as [`interrupted`], asked by work that has made a step that is worth keeping.
pub fn interrupted_after_a_step() -> bool {
    results_exist();
    interrupted()
}

/// From here on an interrupt waits: results are being written, whole or not at all.
pub fn begin_to_write() {
    WRITING.store(true, Ordering::SeqCst);
}

/// From here on only what is made of written results is missing, which an interrupt does not wait for.
pub fn results_are_written() {
    WRITTEN.store(true, Ordering::SeqCst);
    WRITING.store(false, Ordering::SeqCst);
}

/// Between two looks at whether work is done.
const LOOK: Duration = Duration::from_millis(10);

/// What `work` comes to, or nothing once the program is asked to end: a thread does it, and is left then. For work that does
/// not look by itself often enough.
///
/// # Errors
/// Work that ended in the middle.
pub fn left_when_interrupted<T: Send + 'static>(
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<Option<T>, Failure> {
    let work = std::thread::spawn(work);
    while !work.is_finished() {
        if interrupted() {
            return Ok(None);
        }
        std::thread::sleep(LOOK);
    }
    work.join().map(Some).map_err(|_| Failure::other("a calculation ended in the middle"))
}

/// A line that shows what is being worked on; invisible when standard error is not a terminal.
pub fn spinner(what: &str) -> ProgressBar {
    if terminal::is_quiet() || !terminal::moves_its_cursor() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new_spinner();
    if let Ok(style) = ProgressStyle::with_template("{spinner} {prefix}: {msg} [{elapsed}]") {
        bar.set_style(style);
    }
    bar.set_prefix(what.to_owned());
    bar.enable_steady_tick(Duration::from_millis(100));
    bar
}

/// How far long work has come: a bar on a terminal, elsewhere a line now and then.
pub struct Progress {
    bar: ProgressBar,
    /// When the last line was printed where there is no terminal.
    line: Option<Mutex<Instant>>,
    start: Instant,
}

/// Between two lines where there is no terminal.
const LINES: Duration = Duration::from_secs(10);

impl Progress {
    /// Nothing done yet.
    pub fn new() -> Self {
        let moves = terminal::moves_its_cursor();
        let bar = if moves && !terminal::is_quiet() { ProgressBar::new(0) } else { ProgressBar::hidden() };
        if let Ok(style) = ProgressStyle::with_template("{bar:24} {pos}/{len} {msg} [{elapsed}]") {
            bar.set_style(style);
        }
        bar.enable_steady_tick(Duration::from_millis(200));
        let start = Instant::now();
        Self { bar, line: (!moves).then(|| Mutex::new(start)), start }
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
            tell!("{done}/{of} {what} ({:.0} s)", self.start.elapsed().as_secs_f64());
        }
    }

    /// Takes the bar away.
    pub fn finish(self) {
        self.clear();
    }

    /// The same, of a meter that others may still hold.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}
