//! Strong coupling: the slaves of a loop repeat their step until their inputs equal the outputs of the others.
//!
//! Inputs run over the step from the value agreed upon at its beginning to that at its end, for slaves that interpolate: as
//! the cubic that has the slopes at both ends too, where the slave that gives the values tells them, else linearly. Others
//! take the value at the end if all they put out answers to it at once, and else hold the mean of both. All are
//! of second order, cubics of a higher one while the values are smooth.
//!
//! A slope at the end is an unknown as the value is. On a corner it may jump from one repetition to the next and not settle:
//! after some of them the last one is kept.
//!
//! A slave that cannot save its state steps once, with inputs extrapolated, before those of its loop that repeat.

use super::level::{Level, StepFrame, Trouble};
use super::signals::Signals;
use super::solve::Coupling;
use super::unit::{SignalSource, Unit};
use crate::cosim::slave::Severity;

/// An input that the iteration assumes.
#[derive(Debug, Clone, Copy)]
pub(in crate::cosim) struct Assumption {
    /// The signal that feeds it.
    pub source: usize,
    pub factor: f64,
    pub offset: f64,
    /// It is the slope at the end of the step, and not the value.
    pub slope: bool,
}

/// Repetitions in which slopes at the end of a step settle unless they lie on a corner.
const SETTLING: u32 = 10;

impl Assumption {
    /// Of the signal's value.
    pub fn of(&self, source: f64) -> f64 {
        self.factor * source + self.offset
    }

    /// What is expected at the end of a step (s).
    pub fn expected(&self, signals: &Signals, step: f64) -> f64 {
        if self.slope {
            return self.factor * signals.expected_slope(self.source, step);
        }
        self.of(signals.predicted[self.source])
    }
}

/// A step of a loop as equations for what its slaves assume of each other.
pub(in crate::cosim) struct LoopStep<'a> {
    pub units: &'a mut [Unit],
    pub levels: &'a mut [Level],
    pub frame: StepFrame<'a>,
    pub assumptions: &'a [Assumption],
    /// Changes of all signals; zero for those from outside the loop.
    pub changes: &'a mut [f64],
    /// Changes of their slopes at the end of the step.
    pub turns: &'a mut [f64],
    /// How often the slaves have stepped.
    pub repetitions: u32,
}

impl Coupling for LoopStep<'_> {
    type Trouble = Trouble;

    fn evaluate(&mut self, assumed: &[f64], residual: &mut [f64]) -> Result<(), Trouble> {
        let restore = self.repetitions > 0;
        self.repetitions += 1;
        for level in self.levels.iter_mut() {
            level.advance(self.units, &mut self.frame, restore, assumed)?;
        }
        for ((residual, assumption), assumed) in residual.iter_mut().zip(self.assumptions).zip(assumed) {
            let signals = &self.frame.signals;
            *residual = match assumption.slope {
                false => assumption.of(signals.next[assumption.source]) - assumed,
                true if self.repetitions > SETTLING => 0.0,
                true => assumption.factor * signals.slopes[1][assumption.source] - assumed,
            };
        }
        Ok(())
    }

    fn recovers(&self, trouble: &Trouble) -> bool {
        match trouble {
            Trouble::Failed(error) => error.severity != Severity::Fatal,
            Trouble::Discarded(..) => true,
        }
    }

    fn product(&mut self, direction: &[f64], change: &mut [f64]) -> Result<bool, Trouble> {
        let able = |unit: &Unit| unit.abilities.directional_derivatives || unit.channels.is_empty();
        let places = self.levels.first().map_or(0, |level| level.units.start)
            ..self.levels.last().map_or(0, |level| level.units.end);
        let units = &mut self.units[places];
        if !units.iter().all(able) {
            return Ok(false);
        }
        let step = self.frame.step;
        for unit in units {
            let directions = unit.direction.iter_mut().zip(&mut unit.turning);
            for ((direction_of, turning), channel) in directions.zip(&unit.channels) {
                *direction_of = match channel.origin {
                    SignalSource::Assumed(unknown) => direction[unknown],
                    SignalSource::Computed => channel.factor * self.changes[channel.source],
                    SignalSource::Extrapolated => 0.0,
                };
                *turning = match channel.slope {
                    Some(SignalSource::Assumed(unknown)) => step * direction[unknown],
                    Some(_) => step * channel.factor * self.turns[channel.source],
                    None => *direction_of,
                };
            }
            let own = unit.first..unit.first + unit.outputs.len();
            unit.derive(&mut self.changes[own.clone()], &mut self.turns[own], step)?;
        }
        for ((change, assumption), direction) in change.iter_mut().zip(self.assumptions).zip(direction) {
            let changes = if assumption.slope { &*self.turns } else { &*self.changes };
            *change = assumption.factor * changes[assumption.source] - direction;
        }
        Ok(true)
    }
}
