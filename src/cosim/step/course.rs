//! How an input runs over a step.

/// A cubic of the fraction of a step, or a straight line.
#[derive(Debug, Clone, Copy, Default)]
pub(in crate::cosim) struct Course {
    begin: f64,
    end: f64,
    /// What makes it a cubic: coefficients of the first to the third power.
    powers: Option<[f64; 3]>,
}

impl Course {
    /// From one end to the other, with slopes over the step there, or straight.
    pub fn new([begin, end]: [f64; 2], slopes: Option<[f64; 2]>) -> Self {
        let rise = end - begin;
        let powers =
            slopes.map(|[first, last]| [first, 3.0 * rise - 2.0 * first - last, first + last - 2.0 * rise]);
        Self { begin, end, powers }
    }

    /// Whether it is a cubic.
    pub fn is_curved(&self) -> bool {
        self.powers.is_some()
    }

    /// At a fraction of the step; exact at both ends.
    pub fn at(&self, fraction: f64) -> f64 {
        if fraction == 1.0 {
            return self.end;
        }
        let [first, second, third] = self.powers.unwrap_or([self.end - self.begin, 0.0, 0.0]);
        self.begin + fraction * (first + fraction * (second + fraction * third))
    }

    /// Its mean between two fractions of the step.
    pub fn mean(&self, from: f64, to: f64) -> f64 {
        let ends = 0.5 * (self.at(from) + self.at(to));
        // Simpson's rule is exact for cubics.
        if self.is_curved() { (ends + 2.0 * self.at(0.5 * (from + to))) / 3.0 } else { ends }
    }

    /// Its first three derivatives with respect to time at the beginning of a step of `step` (s).
    pub fn derivatives(&self, step: f64) -> [f64; 3] {
        match self.powers {
            None => [(self.end - self.begin) / step, 0.0, 0.0],
            Some([first, second, third]) => {
                [first / step, 2.0 * second / (step * step), 6.0 * third / (step * step * step)]
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_met_by_its_ends_and_slopes() {
        let cubic = |t: f64| 1.0 - 2.0 * t + 0.5 * t * t + 3.0 * t.powi(3);
        let slope = |t: f64| -2.0 + t + 9.0 * t * t;
        let step = 0.4;
        let course = Course::new([cubic(0.0), cubic(step)], Some([step * slope(0.0), step * slope(step)]));
        for fraction in [0.0, 0.3, 1.0] {
            assert!((course.at(fraction) - cubic(fraction * step)).abs() < 1e-14);
        }
        let expected = [-2.0, 1.0, 18.0];
        let derivatives = course.derivatives(step);
        assert!(derivatives.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-11), "{derivatives:?}");
        let integral = |t: f64| t - t * t + t.powi(3) / 6.0 + 0.75 * t.powi(4);
        let mean = (integral(step) - integral(0.5 * step)) / (0.5 * step);
        assert!((course.mean(0.5, 1.0) - mean).abs() < 1e-14);
    }
}
