//! What is watched beside the trials: panics, trials without an end, memory.

use std::cell::RefCell;
use std::panic;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Once};
use std::thread;
use std::time::Duration;

thread_local! {
    /// Where and why this thread panicked last, if it makes trials.
    static LAST: RefCell<Option<String>> = const { RefCell::new(None) };
}

/// Puts the hook for panics of trials in place, once. Others that take the hook do this first: of two that take it at the same
/// time one is lost.
pub fn catch_panics() {
    static ONCE: Once = Once::new();
    ONCE.call_once(|| {
        let other = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            let trial = LAST.with_borrow_mut(|last| last.as_mut().map(|last| *last = panic.to_string()));
            if trial.is_none() {
                other(panic);
            }
        }));
    });
}

/// Keeps what this thread panics with, instead of printing it.
pub(crate) struct Panics;

impl Panics {
    pub fn caught() -> Self {
        catch_panics();
        LAST.set(Some(String::new()));
        Self
    }

    pub fn last(&self) -> String {
        LAST.with_borrow(|last| last.clone().unwrap_or_default())
    }
}

impl Drop for Panics {
    fn drop(&mut self) {
        LAST.set(None);
    }
}

/// How often it looks.
const LOOK: Duration = Duration::from_secs(1);
/// Time of the processor (s) after which a trial has no end. Of eighty calls a few may make the million attempts that a step has
/// before it is refused, 10 to 13 s each for a beam under a normal load of 1e12 N.
const ENDLESS: f64 = 120.0;

/// Ends the process, with the seed, where a trial has no end.
pub(crate) struct Watchdog {
    seed: Arc<AtomicU64>,
    done: Arc<AtomicBool>,
}

impl Watchdog {
    pub fn new(boundary: &str) -> Self {
        let boundary = boundary.to_owned();
        let (seed, done) = (Arc::new(AtomicU64::new(u64::MAX)), Arc::new(AtomicBool::new(false)));
        let own = Self { seed: Arc::clone(&seed), done: Arc::clone(&done) };
        thread::spawn(move || {
            let (mut last, mut since) = (u64::MAX, 0.0);
            while !done.load(Ordering::Relaxed) {
                thread::sleep(LOOK);
                let now = seed.load(Ordering::Relaxed);
                let used = processor_time();
                if now != last {
                    (last, since) = (now, used);
                }
                if used - since > ENDLESS {
                    eprintln!("{boundary}, FUZZ_SEED={now}: no end after {ENDLESS} s");
                    std::process::exit(1);
                }
            }
        });
        own
    }

    /// Which trial begins.
    pub fn now(&self, seed: u64) {
        self.seed.store(seed, Ordering::Relaxed);
    }
}

impl Drop for Watchdog {
    fn drop(&mut self) {
        self.done.store(true, Ordering::Relaxed);
    }
}

/// Time of the processor that this process had (s), however many others there are; 0 where the system does not tell.
fn processor_time() -> f64 {
    const PER_SECOND: f64 = 100.0;
    let status = std::fs::read_to_string("/proc/self/stat").unwrap_or_default();
    // The name of the program, in brackets, may hold anything.
    let numbers = status.rsplit(')').next().unwrap_or_default().split_whitespace();
    numbers.skip(11).take(2).filter_map(|word| word.parse::<f64>().ok()).sum::<f64>() / PER_SECOND
}

/// Memory of this process that is in use (kB); 0 where the system does not tell.
pub(crate) fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.and_then(|line| line.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
