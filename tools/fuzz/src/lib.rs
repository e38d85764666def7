//! Random executions of a boundary: counted, timed, and each repeatable by its number.
//!
//! A fuzzer is a test of the crate that it is about: it calls [`fuzz`] with what one trial does. Among the other tests it makes
//! a few thousand executions. As many as wanted, with a row of a table on standard error:
//!
//! ```sh
//! FUZZ_RUNS=10000000 cargo test --release -p stickslip-fmu fuzz -- --nocapture --test-threads 1
//! ```
//!
//! Trial `n` draws all chance from the number `FUZZ_SEED + n`, so that a fault is repeated by its seed: `FUZZ_SEED=4711 FUZZ_RUNS=1`.
//! [`mutate`] changes bytes, [`mutate_text`] lines and words.

mod mutate;
mod watch;

pub use fastrand::Rng;
pub use mutate::{mutate, mutate_text};
pub use watch::catch_panics;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use watch::{Panics, Watchdog, resident};

/// Executions among the other tests.
const FEW: u64 = 2_000;
/// Memory that may be taken after the first tenth of the executions (kB), where these are [`MANY`]: what one large file took, the
/// allocator keeps.
const GROWTH: u64 = 50_000;
/// Executions after which memory must be flat.
const MANY: u64 = 100_000;
/// Faults that are told; after them nothing new is learned.
const TOLD: usize = 10;

/// Makes trials of `boundary` until there are enough executions, and prints a row: boundary, executions, faults, the longest
/// trial by the clock on the wall with its seed, memory grown, seconds.
///
/// A trial returns how many executions it made, or what was wrong.
///
/// # Panics
/// After a fault: a trial that panicked or said so, or memory that grew. A trial that takes two minutes of the
/// processor ends the process.
pub fn fuzz(boundary: &str, mut trial: impl FnMut(&mut Rng) -> Result<u64, String>) {
    let (most, first) = (number("FUZZ_RUNS", FEW), number("FUZZ_SEED", 0));
    let (panics, watchdog) = (Panics::caught(), Watchdog::new(boundary));
    let (begin, mut longest, mut early) = (Instant::now(), (Duration::ZERO, first), None);
    let (mut executions, mut seed, mut faults) = (0, first, Vec::new());
    while executions < most && faults.len() < TOLD {
        watchdog.now(seed);
        let one = Instant::now();
        let done = catch_unwind(AssertUnwindSafe(|| trial(&mut Rng::with_seed(seed))));
        longest = longest.max((one.elapsed(), seed));
        let fault = match done {
            Err(_) => Some(format!("panicked {}", panics.last())),
            Ok(Err(wrong)) => Some(wrong),
            Ok(Ok(count)) => {
                executions += count.max(1);
                None
            }
        };
        if let Some(fault) = fault {
            executions += 1;
            eprintln!("{boundary}, FUZZ_SEED={seed}: {fault}");
            faults.push(seed);
        }
        if executions > most / 10 {
            early.get_or_insert_with(resident);
        }
        seed += 1;
    }
    let grown = resident().saturating_sub(early.unwrap_or_default());
    eprintln!(
        "\n| {boundary} | {executions} | {} | {:.3} ms ({}) | {grown} kB | {:.0} s |",
        faults.len(),
        longest.0.as_secs_f64() * 1e3,
        longest.1,
        begin.elapsed().as_secs_f64()
    );
    assert!(faults.is_empty(), "{boundary}: wrong with the seeds {faults:?}");
    assert!(most < MANY || grown < GROWTH, "{boundary}: {grown} kB more");
}

/// A folder for the files of trials, in memory where the system has such a place: a disk would take the most of the time.
pub fn folder() -> PathBuf {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { memory.to_owned() } else { std::env::temp_dir() }
}

/// The number in an environment variable, or another where there is none.
pub fn number(name: &str, otherwise: u64) -> u64 {
    std::env::var(name).ok().and_then(|text| text.parse().ok()).unwrap_or(otherwise)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn executions_are_counted_and_each_trial_has_chance_of_its_own() {
        let mut drawn = Vec::new();
        fuzz("nothing", |chance| {
            drawn.push(chance.u64(..));
            Ok(100)
        });
        assert_eq!(drawn.len() as u64, number("FUZZ_RUNS", FEW).div_ceil(100));
        drawn.sort_unstable();
        drawn.dedup();
        assert_eq!(drawn.len() as u64, number("FUZZ_RUNS", FEW).div_ceil(100));
    }

    #[test]
    #[should_panic(expected = "wrong with the seeds")]
    fn a_panic_is_a_fault() {
        fuzz("a panic", |chance| if chance.u8(0..4) == 0 { panic!("on purpose") } else { Ok(1) });
    }

    #[test]
    #[should_panic(expected = "wrong with the seeds")]
    fn a_wrong_result_is_a_fault() {
        fuzz("a wrong result", |chance| if chance.bool() { Ok(1) } else { Err("on purpose".to_owned()) });
    }
}
