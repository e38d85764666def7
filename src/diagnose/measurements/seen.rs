//! A standard deviation with what is known of its own error.

/// A standard deviation that was measured.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Seen {
    pub deviation: f64,
    /// Standard error of its logarithm.
    pub log_error: f64,
}

impl Seen {
    /// From differences between samples that only noise makes different. Correlated noise has fewer independent
    /// values than samples.
    pub fn of(deviation: f64, differences: &[f64], longest: usize) -> Self {
        let product = |lag: usize| -> f64 {
            let pairs = differences.iter().zip(differences.get(lag..).unwrap_or(&[]));
            pairs.map(|(a, b)| a * b).sum()
        };
        let power = product(0);
        let correlations =
            (1..longest).map(|lag| product(lag) / power).take_while(|fraction| *fraction > DEAD);
        let (mut lags, mut together) = (0, 1.0);
        for fraction in correlations {
            lags += 1;
            together += 2.0 * fraction * fraction;
        }
        // What does not die away is a drift, and no noise.
        let is_noise = power > 0.0 && lags + 1 < longest;
        let log_error = if is_noise { (together / (2.0 * differences.len() as f64)).sqrt() } else { 0.0 };
        Self { deviation, log_error }
    }
}

/// Correlation of noise below which it has died away.
const DEAD: f64 = 0.1;

/// Noise for tests.
#[cfg(test)]
pub(super) mod samples {
    /// Normal numbers (the sum of twelve uniform ones), the same in every run.
    pub fn normal(seed: u64) -> impl FnMut() -> f64 {
        // A fork, since the numbers of neighbouring seeds resemble each other.
        let mut numbers = fastrand::Rng::with_seed(seed).fork();
        move || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0
    }

    /// As many with a deviation of one, each correlated by `memory` with the one before.
    pub fn coloured(seed: u64, memory: f64, count: usize) -> Vec<f64> {
        let mut noise = normal(seed);
        let mut last = noise();
        let mut next = || {
            last = memory * last + (1.0 - memory * memory).sqrt() * noise();
            last
        };
        (0..count).map(|_| next()).collect()
    }
}
