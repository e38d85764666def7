//! Strong coupling: the slaves of a loop repeat their step until their inputs equal the outputs of the others.
//!
//! Inputs run linearly over the step, from the value agreed upon at its beginning to that at its end, for slaves that
//! interpolate. Others take the value at the end if all they put out answers to it at once, and else hold
//! the mean of both. All three are of second order.
//!
//! A slave that cannot save its state steps once, with inputs extrapolated, before those of its loop that repeat.

use super::level::{Level, StepFrame, Trouble};
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
}

impl Assumption {
    pub fn of(&self, source: f64) -> f64 {
        self.factor * source + self.offset
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
    /// The slaves are still at the beginning of the step.
    pub at_beginning: bool,
}

impl Coupling for LoopStep<'_> {
    type Trouble = Trouble;

    fn evaluate(&mut self, assumed: &[f64], residual: &mut [f64]) -> Result<(), Trouble> {
        let restore = !std::mem::replace(&mut self.at_beginning, false);
        for level in self.levels.iter_mut() {
            level.advance(self.units, &mut self.frame, restore, assumed)?;
        }
        for ((residual, assumption), assumed) in residual.iter_mut().zip(self.assumptions).zip(assumed) {
            *residual = assumption.of(self.frame.signals.next[assumption.source]) - assumed;
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
        for unit in units {
            for (direction_of, channel) in unit.direction.iter_mut().zip(&unit.channels) {
                *direction_of = match channel.origin {
                    SignalSource::Assumed(unknown) => direction[unknown],
                    SignalSource::Computed => channel.factor * self.changes[channel.source],
                    SignalSource::Extrapolated => 0.0,
                };
            }
            let own = unit.first..unit.first + unit.outputs.len();
            unit.derive(&mut self.changes[own])?;
        }
        for ((change, assumption), direction) in change.iter_mut().zip(self.assumptions).zip(direction) {
            *change = assumption.factor * self.changes[assumption.source] - direction;
        }
        Ok(true)
    }
}
