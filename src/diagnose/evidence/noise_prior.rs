//! What is known of noise before anything is fitted.

use crate::diagnose::assumptions::Assumptions;

/// What is known of a channel's noise beforehand: its logarithm is evenly distributed up to a `largest` deviation, and normal
/// below and above.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) struct NoisePrior {
    pub deviation: f64,
    pub largest: f64,
    /// Standard deviations of the logarithm below and above.
    pub spreads: [f64; 2],
    /// The probability that what is told is wrong here, as where a record is spoilt, and the standard deviation above then.
    pub doubt: Option<[f64; 2]>,
}

impl NoisePrior {
    pub fn new(deviation: f64, spread: f64, assumed: &Assumptions) -> Self {
        // What is told may be a bound: a smaller noise speaks against nobody.
        let spreads = [assumed.unknown_noise, spread];
        let doubt = (spread < assumed.magnitude).then_some([1.0 - assumed.certain, assumed.magnitude]);
        Self { deviation, largest: deviation, spreads, doubt }
    }

    /// With something of `more` that is not noise beside it, of which its order of magnitude is known, to `spread`.
    pub fn released(self, more: f64, spread: f64) -> Self {
        let [below, above] = self.spreads;
        let largest = self.deviation.hypot(more);
        Self { largest, spreads: [below, above.max(spread)], doubt: None, ..self }
    }

    /// The deviation that a sum of squares of `count` innovations makes most probable, where they are `fraction` of the
    /// noise; and the log evidence of it beside the likelihood's.
    pub fn most_probable(&self, square: f64, count: usize, fraction: f64) -> (f64, f64) {
        let one = |spread: f64| self.within(spread, square, count, fraction);
        let Some([wrong, spread]) = self.doubt else { return one(self.spreads[1]) };
        let likelihood = |x: f64| -(count as f64) * x.ln() - 0.5 * square / (x * x);
        let [right, other] =
            [(one(self.spreads[1]), 1.0 - wrong), (one(spread), wrong)].map(|((x, evidence), weight)| {
                (x, evidence + weight.ln(), evidence + weight.ln() + likelihood(x))
            });
        let (x, evidence, _) = if other.2 > right.2 { other } else { right };
        (x, evidence)
    }

    /// The same where the logarithm has this standard deviation above.
    fn within(&self, above: f64, square: f64, count: usize, fraction: f64) -> (f64, f64) {
        let (n, below) = (count as f64, self.spreads[0]);
        let [low, high] = [self.deviation, self.largest].map(|x| (x * fraction.sqrt()).ln());
        let alone = (0.5 * (square / n).max(1e-300).ln()).max(low - 20.0);
        let (x, off, precision) = if alone < low {
            let x = beside(square, n, low, below);
            (x, (x - low) / below, below.powi(-2))
        } else if alone > high {
            let x = beside(square, n, high, above);
            (x, (x - high) / above, above.powi(-2))
        } else {
            (alone, 0.0, 0.0)
        };
        let width = 0.5 * (below + above) + (high - low) / std::f64::consts::TAU.sqrt();
        (x.exp(), -0.5 * off * off - width.ln() - 0.5 * (2.0 * n + precision).ln())
    }
}

/// The logarithm of a deviation that a sum of squares and a normal prior of it make most probable.
fn beside(square: f64, n: f64, centre: f64, spread: f64) -> f64 {
    // Newton: n x + S/2 e^{−2x} + (x − c)²/(2 s²).
    let mut x = 0.5 * (square / n).max(1e-300).ln().max(2.0 * centre - 40.0);
    for _ in 0..50 {
        let exponential = square * (-2.0 * x).exp();
        let slope = n - exponential + (x - centre) / (spread * spread);
        let curvature = 2.0 * exponential + 1.0 / (spread * spread);
        let step = (slope / curvature).clamp(-1.0, 1.0);
        x -= step;
        if step.abs() < 1e-12 {
            break;
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    const COUNT: usize = 1000;

    /// The deviation that residuals of a root mean square make most probable, and its log evidence with that of the
    /// likelihood.
    fn at(prior: NoisePrior, size: f64) -> (f64, f64) {
        let square = COUNT as f64 * size * size;
        let (deviation, evidence) = prior.most_probable(square, COUNT, 1.0);
        (deviation, evidence - COUNT as f64 * deviation.ln() - 0.5 * square / (deviation * deviation))
    }

    #[test]
    fn residuals_of_the_size_told_confirm_it_and_many_outweigh_it() {
        let prior = NoisePrior::new(2.0, 0.1, &Assumptions::default());
        assert!((at(prior, 2.0).0 - 2.0).abs() < 1e-9);
        assert!((at(prior, 2.3).0 / 2.3 - 1.0).abs() < 0.03 && at(prior, 2.3).0 < 2.3);
        assert!((at(prior, 3.0).0 / 3.0 - 1.0).abs() < 0.03 && at(prior, 3.0).0 < 3.0);
    }

    #[test]
    fn a_discrepancy_wins_where_the_residual_is_larger_than_the_noise_and_loses_where_it_is_not() {
        let told = NoisePrior::new(0.01, 0.1, &Assumptions::default());
        let gain = |size: f64| at(told.released(0.01, 1.0), size).1 - at(told, size).1;
        // Of one record little, since that may be spoilt; all of eight are not.
        assert!((1.5..5.0).contains(&gain(0.02)), "{}", gain(0.02));
        for size in [1e-4, 0.005, 0.01, 0.0105] {
            assert!(gain(size) < 0.0, "{size}: {}", gain(size));
        }
    }

    #[test]
    fn a_smaller_noise_than_told_costs_little() {
        let told = NoisePrior::new(0.01, 0.1, &Assumptions::default());
        let exact = NoisePrior::new(1e-4, 0.1, &Assumptions::default());
        let cost = at(exact, 1e-4).1 - at(told, 1e-4).1;
        assert!(cost < 5.0, "{cost}");
    }
}
