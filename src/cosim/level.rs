//! Slaves that do not wait for each other, stepped one by one or at the same time.

use super::settings::Parallel;
use super::signals::Signals;
use super::slave::{SlaveError, Stepped};
use super::unit::{Frame, Unit};
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};

/// What keeps a step from being done.
#[derive(Debug)]
pub(super) enum Trouble {
    /// A slave, by its place, gave up at this time (s).
    Discarded(usize, f64),
    /// A slave failed.
    Failed(SlaveError),
}

impl From<SlaveError> for Trouble {
    fn from(error: SlaveError) -> Self {
        Self::Failed(error)
    }
}

/// Time that a level must take one by one for threads to pay: waking one costs some ten microseconds.
const WORTH_THREADS: Duration = Duration::from_micros(40);
/// How often a level is timed before it is decided.
const TIMED: u32 = 4;
/// Parts for each thread, so that none waits long for another.
const PARTS: usize = 4;

/// A run of units.
#[derive(Debug)]
pub(super) struct Level {
    pub units: Range<usize>,
    parallel: Parallel,
    timed: u32,
    taken: Duration,
}

impl Level {
    pub fn new(units: Range<usize>, parallel: Parallel) -> Self {
        let parallel = if units.len() < 2 { Parallel::Never } else { parallel };
        Self { units, parallel, timed: 0, taken: Duration::ZERO }
    }

    /// Steps the level's units among `units` and writes their outputs to `signals`. Every one of them steps, whatever
    /// happens to the others, and the first trouble in their order is told: the same one by one and at the same time.
    pub fn advance(
        &mut self,
        units: &mut [Unit],
        frame: &mut StepFrame,
        restore: bool,
        assumed: &[f64],
    ) -> Result<(), Trouble> {
        let level = &mut units[self.units.clone()];
        let StepFrame { time, step, plain, signals } = frame;
        let now = Frame { time: *time, step: *step, plain: *plain, restore, signals, assumed };
        match self.parallel {
            Parallel::Never => level.iter_mut().for_each(|unit| unit.advance(&now)),
            Parallel::Always => {
                let parts = PARTS * rayon::current_num_threads();
                let size = level.len().div_ceil(parts).max(1);
                level
                    .par_chunks_mut(size)
                    .for_each(|units| units.iter_mut().for_each(|unit| unit.advance(&now)));
            }
            Parallel::Auto => {
                let start = Instant::now();
                level.iter_mut().for_each(|unit| unit.advance(&now));
                self.taken += start.elapsed();
                self.timed += 1;
                if self.timed == TIMED {
                    let pays = self.taken > TIMED * WORTH_THREADS && rayon::current_num_threads() > 1;
                    self.parallel = if pays { Parallel::Always } else { Parallel::Never };
                }
            }
        }
        for (place, unit) in level.iter_mut().enumerate() {
            match &unit.outcome {
                Ok(Stepped::Done) => {}
                Ok(Stepped::Discarded(reached)) => {
                    return Err(Trouble::Discarded(self.units.start + place, *reached));
                }
                Err(_) => {
                    let outcome = std::mem::replace(&mut unit.outcome, Ok(Stepped::Done));
                    return outcome.map_or_else(|error| Err(Trouble::Failed(error)), |_| Ok(()));
                }
            }
            signals.next[unit.first..unit.first + unit.outputs.len()].copy_from_slice(&unit.outputs);
        }
        Ok(())
    }
}

/// A step, and the signals that it writes.
#[derive(Debug)]
pub(super) struct StepFrame<'a> {
    pub time: f64,
    pub step: f64,
    pub plain: bool,
    pub signals: &'a mut Signals,
}
