//! The length of the next step, and whether the last one was short enough.

use crate::cosim::settings::{Adaptive, Control};
use crate::cosim::step::engine::Engine;

/// Part of the step that the measures allow which is taken.
const CAUTION: f64 = 0.9;
/// A step grows and shrinks by these factors at most.
const GROWTH: (f64, f64) = (0.2, 2.0);
/// Where a step must be repeated for another reason than a measure.
const RETREAT: f64 = 0.5;

/// Controls the step of a run.
#[derive(Debug, Clone, Copy)]
pub(in crate::cosim) struct StepControl {
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

    /// What of the step tried last is beyond its tolerance, if anything. Sets the length of the next.
    pub fn judge(&mut self, engine: &mut Engine, step: f64, settled: bool) -> Option<String> {
        let (residual, connection) = engine.measure_energy(step);
        let (missed, unit, place) = missed(engine);
        let (measure, by_energy) = match self.settings.control {
            Control::Discards => (0.0, false),
            Control::Energy => (residual, true),
            Control::Both if residual > missed => (residual, true),
            Control::Error | Control::Both => (missed, false),
        };
        let measure = measure / self.settings.tolerance;
        let limit = |engine: &Engine| match by_energy {
            true => format!("the energy at {}", engine.energy.residuals[connection].force),
            false => engine.units[unit].output_name(place),
        };
        let Adaptive { smallest, largest, .. } = self.settings;
        if !settled || measure.is_nan() {
            self.retreat(step, 0.0);
            return Some(if settled { limit(engine) } else { "the repetition of the step".to_owned() });
        }
        // What is held misses by the first order, what is extrapolated by the second.
        let exponent = -1.0 / f64::from(engine.order.min(1) + 1);
        let factor = (CAUTION * measure.powf(exponent)).clamp(GROWTH.0, GROWTH.1);
        let good = measure <= 1.0;
        if !good {
            engine.signals.size_up();
        }
        // One that was good does not make the next one try again.
        self.step = (if good { factor } else { factor.min(CAUTION) } * step).clamp(smallest, largest);
        (!good).then(|| limit(engine))
    }
}

/// Largest difference between what was expected of a connected output and what came, over its largest magnitude so far;
/// which output of which unit that is.
fn missed(engine: &Engine) -> (f64, usize, usize) {
    let signals = &engine.signals;
    let mut worst = (0.0_f64, 0, 0);
    for (number, unit) in engine.units.iter().enumerate() {
        for place in &unit.coupled_places {
            let index = unit.first + place;
            let missed = (signals.next[index] - signals.predicted[index]).abs();
            let relative = missed / signals.peak[index].max(signals.next[index].abs());
            // NaN must not be lost in the comparison.
            if missed > 0.0 && relative > worst.0 || missed.is_nan() {
                worst = (relative, number, *place);
            }
        }
    }
    worst
}
