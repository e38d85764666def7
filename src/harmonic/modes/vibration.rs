//! A free vibration carried from amplitude to amplitude.

use crate::harmonic::newton::Point;
use crate::harmonic::newton::condition::{HeldAmplitude, Phase};
use crate::harmonic::newton::problem::{Condition, Newton};
use crate::harmonic::newton::system::{PeriodicSystem, Scalar};
use crate::harmonic::response::stepwise::{LastSolutions, StepwiseContinuation};
use crate::harmonic::response::tracker::{Solution, describe_by};
use crate::harmonic::{CurveSettings, HarmonicError};

const FREE: [Scalar; 2] = [Scalar::AngularFrequency, Scalar::SelfExcitation];

/// Carries a free vibration from amplitude to amplitude.
pub(super) struct FreeVibration<'s> {
    pub system: &'s mut (dyn PeriodicSystem + 's),
    pub settings: CurveSettings,
    pub newton: Newton,
    pub node: usize,
    /// What of it is held: displacement (0) … acceleration (2).
    pub derivative: usize,
    /// Where to look at the first amplitude.
    pub first: Solution,
}

impl FreeVibration<'_> {
    /// The vibration just found. A free vibration may begin at any phase, so that the balance alone does not tell
    /// how it answers to harmonics left out: frequency, damping, amplitude and phase take part.
    fn describe(&mut self, solution: &Solution) -> Result<Point, HarmonicError> {
        let prepared = self.newton.prepare(self.system, &FREE);
        let newton = &self.newton;
        let mut right = Vec::new();
        describe_by(self.system, solution, &self.settings, &mut |change| {
            let unknowns = change.len();
            right.clear();
            right.extend(change.iter().map(|r| r / newton.scale()));
            right.resize(unknowns + FREE.len(), 0.0);
            if prepared && newton.solve_linear(&mut right) {
                change.copy_from_slice(&right[..unknowns]);
            } else {
                change.fill(f64::INFINITY);
            }
        })
    }

    /// The vibration at an amplitude: shape, frequency and damping on straight lines over its logarithm.
    fn predicted(amplitude: f64, reached: &LastSolutions) -> Option<Solution> {
        let (last_amplitude, last) = reached.first()?;
        let ratio = amplitude / last_amplitude;
        let mut start = last.clone();
        start.x.iter_mut().for_each(|x| *x *= ratio);
        if let Some((before_amplitude, before)) = reached.get(1)
            && before_amplitude != last_amplitude
        {
            let ahead = ratio.ln() / (last_amplitude / before_amplitude).ln();
            let ahead = ahead.clamp(-1.0, 2.0);
            let scale = amplitude / before_amplitude;
            start.x.iter_mut().zip(&before.x).for_each(|(x, b)| *x += ahead * (*x - scale * b));
            let line = |last: f64, before: f64| last + ahead * (last - before);
            start.at.angular_frequency = line(last.at.angular_frequency, before.at.angular_frequency)
                .clamp(0.9 * last.at.angular_frequency, 1.1 * last.at.angular_frequency);
            start.at.self_excitation = line(last.at.self_excitation, before.at.self_excitation);
        }
        Some(start)
    }
}

impl StepwiseContinuation for FreeVibration<'_> {
    fn parts(&mut self) -> (&mut dyn PeriodicSystem, &CurveSettings) {
        (&mut *self.system, &self.settings)
    }

    fn start(&mut self, amplitude: f64, reached: &LastSolutions) -> Result<Solution, HarmonicError> {
        Ok(Self::predicted(amplitude, reached).unwrap_or_else(|| self.first.clone()))
    }

    fn solve(&mut self, amplitude: f64, solution: &mut Solution) -> Result<Point, HarmonicError> {
        let mut held = HeldAmplitude::new(self.node, 1, self.derivative, amplitude);
        let mut phase = Phase::behind(self.node, 1, [1.0, 0.0], 0.0);
        let conditions: &mut [&mut dyn Condition] = &mut [&mut held, &mut phase];
        let Solution { x, at } = &mut *solution;
        let effort = self.newton.solve(self.system, x, at, &FREE, conditions, &self.settings.stopping())?;
        let mut point = self.describe(solution)?;
        point.iterations = effort.iterations;
        Ok(point)
    }
}
