//! The length of the next step, and whether the last one was short enough.

use super::engine::Engine;
use super::settings::{Adaptive, Control};
use super::signals::Signals;

/// Part of the step that the measures allow which is taken.
const CAUTION: f64 = 0.9;
/// A step grows and shrinks by these factors at most.
const GROWTH: (f64, f64) = (0.2, 2.0);
/// Where a step must be repeated for another reason than a measure.
const RETREAT: f64 = 0.5;

/// Controls the step of a run.
#[derive(Debug, Clone, Copy)]
pub(super) struct StepControl {
    settings: Adaptive,
    /// Length to try next (s).
    pub step: f64,
}

impl StepControl {
    pub fn new(settings: Adaptive, first: f64) -> Self {
        Self { settings, step: first.clamp(settings.smallest, settings.largest) }
    }

    /// The step cannot be shorter.
    pub fn at_smallest(&self, step: f64) -> bool {
        step <= self.settings.smallest * (1.0 + 1e-9)
    }

    /// After trouble that reached the part `reached` of the step tried.
    pub fn retreat(&mut self, step: f64, reached: f64) {
        let part = if reached > 0.0 && reached < 1.0 { CAUTION * reached } else { RETREAT };
        self.step = (part.max(GROWTH.0) * step).max(self.settings.smallest);
    }

    /// Is the step tried last good enough? Sets the length of the next.
    pub fn judge(&mut self, engine: &mut Engine, step: f64, settled: bool) -> bool {
        let energy = engine.measure_energy(step);
        let measure = match self.settings.control {
            Control::Discards => 0.0,
            Control::Energy => energy,
            Control::Error => missed(&engine.signals),
            Control::Both => energy.max(missed(&engine.signals)),
        } / self.settings.tolerance;
        let Adaptive { smallest, largest, .. } = self.settings;
        if !settled || measure.is_nan() {
            self.retreat(step, 0.0);
            return false;
        }
        // What is held misses by the first order, what is extrapolated by the second.
        let exponent = -1.0 / f64::from(engine.order.min(1) + 1);
        let factor = (CAUTION * measure.powf(exponent)).clamp(GROWTH.0, GROWTH.1);
        let good = measure <= 1.0;
        // One that was good does not make the next one try again.
        self.step = (if good { factor } else { factor.min(CAUTION) } * step).clamp(smallest, largest);
        good
    }
}

/// Largest difference between what was expected of a signal and what came, over its largest magnitude so far.
fn missed(signals: &Signals) -> f64 {
    let mut worst = 0.0_f64;
    for index in (0..signals.now.len()).filter(|index| signals.real[*index]) {
        let missed = (signals.next[index] - signals.predicted[index]).abs();
        let size = signals.peak[index].max(signals.next[index].abs());
        if missed > 0.0 {
            worst = worst.max(missed / size);
        }
    }
    worst
}
