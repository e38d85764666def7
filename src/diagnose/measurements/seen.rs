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
