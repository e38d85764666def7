//! Coloured noise: an autoregressive process, fitted to residuals and taken out of them.

/// Highest order tried.
const MOST: usize = 12;

/// A process `x_t = Σ a_k x_{t−k} + e_t` with innovations of variance one, and its predictors of all lower orders, which
/// the first samples of a record need.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Autoregression {
    /// Per order from 0 the coefficients, and the innovations' deviation over that of the last order.
    predictors: Vec<(Vec<f64>, f64)>,
    /// Innovation variance over the variance of the process.
    pub fraction: f64,
}

impl Autoregression {
    /// Values from which on a process is sought; of fewer all are white.
    pub const FEWEST: usize = 4 * MOST;

    /// White noise.
    pub fn white() -> Self {
        Self { predictors: vec![(Vec::new(), 1.0)], fraction: 1.0 }
    }

    /// Fitted to `series` of one channel, each scaled by its own root mean square (Levinson's recursion on the pooled
    /// autocovariance, which is stable); the order that has the most evidence, so that two hypotheses differ by nothing that chance has chosen.
    pub fn fit<'a>(series: impl Iterator<Item = &'a [f64]>) -> Self {
        let mut covariance = [0.0; MOST + 1];
        let mut count = 0;
        for values in series {
            let square: f64 = values.iter().map(|x| x * x).sum();
            if square <= 0.0 {
                continue;
            }
            let scale = values.len() as f64 / square;
            for (lag, sum) in covariance.iter_mut().enumerate() {
                let pairs = values.iter().zip(values.get(lag..).unwrap_or(&[]));
                *sum += scale * pairs.map(|(a, b)| a * b).sum::<f64>();
            }
            count += values.len();
        }
        if count < Self::FEWEST {
            return Self::white();
        }
        let (mut coefficients, mut variance) = (Vec::<f64>::new(), covariance[0]);
        let mut all = vec![(coefficients.clone(), variance)];
        for order in 1..=MOST {
            let known: f64 =
                coefficients.iter().enumerate().map(|(k, a)| a * covariance[order - 1 - k]).sum();
            let reflection = (covariance[order] - known) / variance;
            let before = coefficients.clone();
            for (k, a) in coefficients.iter_mut().enumerate() {
                *a -= reflection * before[order - 2 - k];
            }
            coefficients.push(reflection);
            variance *= (1.0 - reflection * reflection).max(1e-12);
            all.push((coefficients.clone(), variance));
        }
        let n = count as f64;
        let criterion = |order: usize| n * all[order].1.ln() + order as f64 * n.ln();
        let order = (0..=MOST).min_by(|a, b| criterion(*a).total_cmp(&criterion(*b))).unwrap_or(0);
        let last = all[order].1;
        all.truncate(order + 1);
        let predictors = all.into_iter().map(|(a, v)| (a, (v / last).sqrt())).collect();
        Self { predictors, fraction: last / covariance[0] }
    }

    /// The order.
    pub fn order(&self) -> usize {
        self.predictors.len() - 1
    }

    /// Puts the innovations in place of `values`, those of the first samples by predictors of lower order.
    pub fn whiten(&self, values: &mut [f64]) {
        let order = self.order();
        // From the last on: the values before one are still there when it is predicted by them.
        for t in (0..values.len()).rev() {
            let (coefficients, deviation) = &self.predictors[t.min(order)];
            let (past, now) = values.split_at_mut(t);
            let predicted: f64 = coefficients.iter().zip(past.iter().rev()).map(|(a, x)| a * x).sum();
            now[0] = (now[0] - predicted) / deviation;
        }
    }

    /// ½ ln of the determinant of the covariance of a record, over that of its innovations alone.
    pub fn log_determinant(&self) -> f64 {
        self.predictors[..self.order()].iter().map(|(_, deviation)| deviation.ln()).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `count` values of `x = memory · x + e`, e of deviation one, from its stationary distribution.
    fn process(memory: f64, count: usize) -> Vec<f64> {
        let mut numbers = fastrand::Rng::with_seed(3).fork();
        let mut normal = || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0;
        let mut last = normal() / (1.0 - memory * memory).sqrt();
        let mut next = || {
            let now = last;
            last = memory * last + normal();
            now
        };
        (0..count).map(|_| next()).collect()
    }

    #[test]
    fn the_innovations_of_a_process_are_white_and_of_its_own_size() {
        for memory in [0.0, 0.5, 0.95] {
            let values = process(memory, 20_000);
            let found = Autoregression::fit(std::iter::once(values.as_slice()));
            let mut e = values.clone();
            found.whiten(&mut e);
            let product =
                |lag: usize| e.iter().zip(&e[lag..]).map(|(a, b)| a * b).sum::<f64>() / e.len() as f64;
            assert!((product(0) - 1.0).abs() < 0.05, "memory {memory}: {}", product(0));
            assert!((1..5).all(|lag| product(lag).abs() < 0.03), "memory {memory}");
            assert!((found.fraction - (1.0 - memory * memory)).abs() < 0.05, "{memory}: {}", found.fraction);
        }
    }

    /// The determinant of the covariance of a first-order process over that of its innovations is `1/(1 − a²)`, however
    /// long the record.
    #[test]
    fn the_determinant_is_that_of_the_first_sample() {
        let values = process(0.9, 5000);
        let found = Autoregression::fit(std::iter::once(values.as_slice()));
        let (last, first) = (found.predictors.last().unwrap(), &found.predictors[0]);
        assert!(last.1 == 1.0 && first.0.is_empty());
        let expected = -0.5 * found.fraction.ln();
        assert!(found.log_determinant() >= expected && found.log_determinant() < expected + 0.1);
    }

    #[test]
    fn too_few_values_are_taken_for_white() {
        assert_eq!(Autoregression::fit(std::iter::once(&[1.0, 1.1, 1.2][..])), Autoregression::white());
    }
}
