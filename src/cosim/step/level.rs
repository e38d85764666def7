//! Slaves that do not wait for each other, stepped one by one or at the same time.

use super::signals::Signals;
use super::unit::{Frame, Unit, copy_few};
use crate::cosim::settings::Parallel;
use crate::cosim::slave::{SlaveError, Stepped};
use rayon::prelude::*;
use std::ops::Range;
use std::time::{Duration, Instant};

/// What keeps a step from being done.
#[derive(Debug)]
pub(in crate::cosim) enum Trouble {
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
pub(in crate::cosim) struct Level {
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
    /// happens to the others, and the first error in their order is returned: the same one by one and at the same time.
    pub fn advance(
        &mut self,
        units: &mut [Unit],
        frame: &mut StepFrame,
        restore: bool,
        assumed: &[f64],
    ) -> Result<(), Trouble> {
        let level = &mut units[self.units.clone()];
        let first = self.units.start;
        if self.parallel == Parallel::Always {
            let size = level.len().div_ceil(PARTS * rayon::current_num_threads()).max(1);
            let now = frame.seen(restore, assumed);
            level.par_chunks_mut(size).for_each(|units| units.iter_mut().for_each(|unit| unit.advance(&now)));
            return level
                .iter_mut()
                .enumerate()
                .try_for_each(|(place, unit)| collect(unit, first + place, frame.signals));
        }
        let start = (self.parallel == Parallel::Auto).then(Instant::now);
        let mut result = Ok(());
        for (place, unit) in level.iter_mut().enumerate() {
            unit.advance(&frame.seen(restore, assumed));
            // While it is still in the cache. None waits for another, so none reads this.
            if result.is_ok() {
                result = collect(unit, first + place, frame.signals);
            }
        }
        if let Some(start) = start {
            self.taken += start.elapsed();
            self.timed += 1;
            if self.timed == TIMED {
                let pays = self.taken > TIMED * WORTH_THREADS && rayon::current_num_threads() > 1;
                self.parallel = if pays { Parallel::Always } else { Parallel::Never };
            }
        }
        result
    }
}

/// Writes the outputs of a unit that has stepped to `signals`, or returns its error.
fn collect(unit: &mut Unit, place: usize, signals: &mut Signals) -> Result<(), Trouble> {
    match &unit.outcome {
        Ok(Stepped::Done) => {
            let own = unit.first..unit.first + unit.outputs.len();
            copy_few(&mut signals.next[own], &unit.outputs);
            for (place, slope) in unit.coupled_places.iter().zip(&unit.slopes_out) {
                signals.slopes[1][unit.first + place] = *slope;
            }
            Ok(())
        }
        Ok(Stepped::Discarded(reached)) => Err(Trouble::Discarded(place, *reached)),
        Err(_) => {
            let outcome = std::mem::replace(&mut unit.outcome, Ok(Stepped::Done));
            outcome.map_or_else(|error| Err(Trouble::Failed(error)), |_| Ok(()))
        }
    }
}

/// A step, and the signals that it writes.
#[derive(Debug)]
pub(in crate::cosim) struct StepFrame<'a> {
    pub time: f64,
    pub step: f64,
    pub plain: bool,
    pub signals: &'a mut Signals,
}

impl StepFrame<'_> {
    /// The calls that a slave receives.
    fn seen<'f>(&'f self, restore: bool, assumed: &'f [f64]) -> Frame<'f> {
        Frame { time: self.time, step: self.step, plain: self.plain, restore, signals: self.signals, assumed }
    }
}
