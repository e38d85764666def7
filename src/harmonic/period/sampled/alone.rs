//! The force without its derivatives: a hundredth of the work.

use super::SampledCycle;
use crate::harmonic::period::PeriodicContact;

/// Change of the force from period to period (fraction of the largest) at which the period repeats itself.
const REPEATED: f64 = 1e-13;
/// Friction forgets in one period; what does not in so many is left to Newton's method.
const MOST_PERIODS: usize = 6;

impl SampledCycle {
    /// As [`SampledCycle::evaluate`] for the force alone, by marching until a period repeats itself; false where none
    /// does. The next evaluation of the same displacement starts from there.
    pub fn force_alone(&mut self, contact: &PeriodicContact, angular_frequency: f64, u: &[f64]) -> bool {
        self.take_motion(contact, u);
        self.forget();
        self.origin = self.farthest_sample();
        self.state.copy_from_slice(&self.without_history);
        self.force_scale = 0.0;
        self.step_alone(contact, angular_frequency, self.origin, 0.0);
        std::mem::swap(&mut self.state, &mut self.next);
        self.force_samples.fill(f64::NAN);
        for _ in 0..MOST_PERIODS {
            self.start.copy_from_slice(&self.state);
            let change = self.march_alone(contact, angular_frequency);
            if change <= REPEATED * self.force_scale {
                self.previous.copy_from_slice(u);
                self.start_sensitivity.fill(0.0);
                self.settled = true;
                self.force_samples
                    .iter_mut()
                    .zip(&self.jump.given)
                    .for_each(|(force, given)| *force += given);
                self.basis.project(&self.force_samples, &mut self.force);
                return true;
            }
        }
        false
    }

    /// One period from `state`, to where `state` is after it; the largest change of the force at a sample.
    fn march_alone(&mut self, contact: &PeriodicContact, angular_frequency: f64) -> f64 {
        self.jump.given.clear();
        self.jump.given.resize(self.samples, 0.0);
        let (mut last, mut largest, mut change) = (0.0, 0.0_f64, 0.0_f64);
        for i in 1..=self.samples {
            let k = (self.origin + i) % self.samples;
            let known = self.force_samples[k];
            let predicted = if known.is_finite() { known } else { last };
            last = self.step_alone(contact, angular_frequency, k, predicted).1.force;
            self.force_samples[k] = last;
            if contact.compliance == 0.0 && i > 1 {
                self.place_jump(contact, angular_frequency, k, false);
            }
            largest = largest.max(last.abs());
            let apart = (last - known).abs();
            // `max` would drop a NaN.
            change = if apart > change || apart.is_nan() { apart } else { change };
            std::mem::swap(&mut self.state, &mut self.next);
        }
        self.force_scale = largest;
        change
    }
}
