//! The force on a lumped oscillator over time.

use super::OscillatorError;
use super::polynomial::{DEGREE, Series};

/// Force f(t) that acts along the structure's excitation row (N).
#[derive(Debug, Clone, PartialEq)]
pub enum Excitation {
    /// `level · (a0 + Σ c_h cos hΩt + s_h sin hΩt)`.
    Periodic {
        /// Ω (rad/s), above zero.
        angular_frequency: f64,
        /// Factor of the coefficients.
        level: f64,
        /// `[a0, c1, s1, c2, s2, …]` (N).
        coefficients: Vec<f64>,
    },
    /// Values joined by straight lines, the first at t = 0; the last is held ever after.
    Sampled {
        /// Time between two values (s), above zero.
        interval: f64,
        /// The values (N), at least one.
        values: Vec<f64>,
    },
}

impl Excitation {
    /// `amplitude · cos Ωt`.
    pub fn cosine(angular_frequency: f64, amplitude: f64) -> Self {
        Self::Periodic { angular_frequency, level: amplitude, coefficients: vec![0.0, 1.0, 0.0] }
    }

    /// No force.
    pub fn none() -> Self {
        Self::Sampled { interval: 1.0, values: vec![0.0] }
    }

    pub(crate) fn check(&self) -> Result<(), OscillatorError> {
        let (name, rate, level, values) = match self {
            Self::Periodic { angular_frequency, level, coefficients } => {
                ("excitation frequency", *angular_frequency, *level, coefficients)
            }
            Self::Sampled { interval, values } => ("excitation interval", *interval, 1.0, values),
        };
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(OscillatorError::Input { name, value: rate });
        }
        if values.is_empty() {
            return Err(OscillatorError::Length { name: "excitation", expected: 1, found: 0 });
        }
        match std::iter::once(&level).chain(values).find(|value| !value.is_finite()) {
            Some(value) => Err(OscillatorError::Input { name: "excitation", value: *value }),
            None => Ok(()),
        }
    }

    /// Fastest angular frequency in it (rad/s).
    pub(crate) fn fastest(&self) -> f64 {
        match self {
            Self::Periodic { angular_frequency, coefficients, .. } => {
                angular_frequency * (coefficients.len() / 2) as f64
            }
            Self::Sampled { .. } => 0.0,
        }
    }

    /// Time until the next corner after `time` (s).
    pub(crate) fn until_corner(&self, time: f64) -> f64 {
        match self {
            Self::Periodic { .. } => f64::INFINITY,
            Self::Sampled { interval, values } => {
                let index = segment(time, *interval) + 1;
                if index < values.len() { index as f64 * interval - time } else { f64::INFINITY }
            }
        }
    }

    /// Force at `time` (s); zero without any values.
    pub fn value(&self, time: f64) -> f64 {
        let mut series = [0.0; DEGREE + 1];
        self.expand(time, 0.0, &mut series);
        series[0]
    }

    /// Series over the step of `h` (s) from `time` (s), which contains no corner.
    pub(crate) fn expand(&self, time: f64, h: f64, out: &mut Series) {
        *out = [0.0; DEGREE + 1];
        match self {
            Self::Periodic { angular_frequency, level, coefficients } => {
                let Some((bias, pairs)) = coefficients.split_first() else { return };
                out[0] = level * bias;
                for (order, pair) in pairs.chunks(2).enumerate() {
                    let omega = (order + 1) as f64 * angular_frequency;
                    let (c, s) = (level * pair[0], level * pair.get(1).copied().unwrap_or(0.0));
                    if c == 0.0 && s == 0.0 {
                        continue;
                    }
                    let (sin, cos) = (omega * time).sin_cos();
                    let (even, odd) = (c * cos + s * sin, s * cos - c * sin);
                    let mut factor = 1.0;
                    for (j, out) in out.iter_mut().enumerate() {
                        *out += factor * if j % 2 == 0 { even } else { odd };
                        factor *= omega * h / (j + 1) as f64 * if j % 2 == 0 { 1.0 } else { -1.0 };
                    }
                }
            }
            Self::Sampled { interval, values } => {
                let index = segment(time, *interval);
                let Some(end) = values.get(index.saturating_add(1)) else {
                    out[0] = values.last().copied().unwrap_or(0.0);
                    return;
                };
                let slope = (end - values[index]) / interval;
                out[0] = values[index] + slope * (time - index as f64 * interval);
                out[1] = slope * h;
            }
        }
    }
}

/// Which interval `time` lies in; an instant a rounding error before a corner lies behind it.
fn segment(time: f64, interval: f64) -> usize {
    (time / interval + 1e-9).floor().max(0.0) as usize
}
