//! Peaks and folds located between two points of a curve.

use super::*;
use crate::harmonic::newton::problem::Stopping;
use crate::numeric::bracket::Bracket;

/// Why nothing was found between two points.
pub(crate) enum NotFound {
    /// There was no solution on the way.
    Lost,
    /// The value at the previous point has the other sign: if it passes through zero, there (the solution there).
    AtPrevious(Location),
    /// The value at the present point is this one, of the other sign: if it passes through zero, further on.
    AtPresent(Option<f64>),
}

impl Path<'_> {
    /// Finds the point between the previous and the present one where `test`, a function of the location,
    /// passes through zero (its values there are `low` and `high`, of opposite sign); the present point and
    /// the step are left alone. Fails where the solution is lost on the way, or one of the values had the wrong sign.
    pub fn locate(
        &mut self,
        (low, high): (f64, f64),
        test: &mut dyn FnMut(&mut dyn PeriodicSystem, &Location) -> f64,
    ) -> Result<Location, NotFound> {
        const ROUNDS: usize = 60;
        /// Fraction of the way at which the place is known well enough: what is largest there is known to the square.
        const SHARPEST: f64 = 1e-11;
        const NEAR_END: f64 = 1e-6;
        let stopping =
            Stopping { tolerance: self.route.stopping.tolerance.min(1e-12), ..self.route.stopping };
        std::mem::swap(&mut self.previous, &mut self.present);
        let kept = (self.step, self.last_step);
        self.unit.normalise(&mut self.present);
        self.unit.normalise(&mut self.previous);
        self.set_plane();
        let base = self.arc.at(&self.present.x, &self.present.at);
        let reach = self.arc.at(&self.previous.x, &self.previous.at) - base;
        let mut bracket = Bracket::new((0.0, low), (reach, high));
        let mut found = None;
        for _ in 0..ROUNDS {
            let place = bracket.next();
            if found.is_some() && (place - bracket.latest.0).abs() <= SHARPEST * reach.abs() {
                break;
            }
            let Some(value) = self.test_at(base, place, reach, &stopping, test) else { break };
            found = Some(self.next.clone());
            if value == 0.0 {
                break;
            }
            bracket.take((place, value));
        }
        // The directions along a curve are those of the last Newton step: close to an extremum the sign at an end
        // may have been wrong, and that end is what was found.
        let mut wrong = None;
        for (end, expected) in [(0.0, low), (reach, high)] {
            if (bracket.latest.0 - end).abs() <= NEAR_END * reach.abs() && bracket.latest.1 * expected < 0.0 {
                let exact = self.test_at(base, end, reach, &stopping, test);
                if exact.is_none_or(|exact| exact * expected < 0.0) {
                    let there = self.next.clone();
                    wrong = Some(if end == 0.0 {
                        NotFound::AtPrevious(there)
                    } else {
                        NotFound::AtPresent(exact)
                    });
                }
            }
        }
        std::mem::swap(&mut self.previous, &mut self.present);
        self.next.clone_from(&self.present);
        (self.step, self.last_step) = kept;
        match wrong {
            Some(wrong) => Err(wrong),
            None => found.ok_or(NotFound::Lost),
        }
    }

    /// `test` at `place` on the way of length `reach` from `base`, where `next` is left; `None` where there is no
    /// solution.
    fn test_at(
        &mut self,
        base: f64,
        place: f64,
        reach: f64,
        stopping: &Stopping,
        test: &mut dyn FnMut(&mut dyn PeriodicSystem, &Location) -> f64,
    ) -> Option<f64> {
        self.set_plane();
        self.interpolate(place / reach, reach);
        self.arc.target = base + place;
        self.solve_loosely(stopping).ok()?;
        if !self.newton.refactor(self.system, &self.free) {
            return None;
        }
        self.find_direction(false).ok()?;
        let unit = self.unit;
        unit.normalise(&mut self.next);
        Some(test(self.system, &self.next)).filter(|value| value.is_finite())
    }

    /// The plane's solution, or the best there is at the accuracy of rounding.
    fn solve_loosely(&mut self, stopping: &Stopping) -> Result<(), HarmonicError> {
        let guess = (self.next.x.clone(), self.next.at);
        if self.solve_on_plane(stopping).is_ok() {
            return Ok(());
        }
        (self.next.x, self.next.at) = guess;
        let stopping = self.route.stopping;
        self.solve_on_plane(&stopping)
    }

    /// Puts `next` between the present and the previous point (swapped: the present one comes first) on
    /// Hermite's cubic.
    fn interpolate(&mut self, fraction: f64, reach: f64) {
        let (s2, s3) = (fraction * fraction, fraction * fraction * fraction);
        let (h0, h1) = (2.0 * s3 - 3.0 * s2 + 1.0, 3.0 * s2 - 2.0 * s3);
        let (g0, g1) = (reach * (s3 - 2.0 * s2 + fraction), reach * (s3 - s2));
        let (a, b) = (&self.present, &self.previous);
        self.next.x.clear();
        let ends = a.x.iter().zip(&a.unknowns).zip(b.x.iter().zip(&b.unknowns));
        self.next.x.extend(ends.map(|((xa, da), (xb, db))| h0 * xa + g0 * da + h1 * xb + g1 * db));
        self.next.at = a.at;
        for scalar in &self.free {
            let k = scalar.index();
            let ends = h0 * a.at.get(*scalar) + h1 * b.at.get(*scalar);
            self.next.at.set(*scalar, ends + g0 * a.scalars[k] + g1 * b.scalars[k]);
        }
    }
}
