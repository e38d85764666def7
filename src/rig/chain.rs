//! What lies between motion and numbers: gains, delays, noise.

use super::error::RigError;
use crate::numeric::random::Random;

/// Longest delay (s): that of a chain is far below it.
const LONGEST_DELAY: f64 = 0.1;
/// Part of the seed that gains are drawn of, far from those of noise.
const GAINS: u64 = u64::MAX;

/// The measuring chain. A list may be shorter than the channels: the rest is perfect.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Chain {
    /// Of the load cell.
    pub excitation: ChannelFault,
    /// Of every accelerometer, in their order.
    pub accelerometers: Vec<ChannelFault>,
    /// Standard deviation of gains about those of the channels (1), drawn once for all records.
    pub gain_scatter: f64,
    /// Seed of noise and gains.
    pub seed: u64,
    /// Whether the records say how large their noise is.
    pub noise_told: bool,
}

/// Faults of one channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChannelFault {
    /// Shown value over the true one.
    pub gain: f64,
    /// How much later the value is shown (s).
    pub delay: f64,
    /// White noise on top.
    pub noise: NoiseLevel,
}

impl Default for ChannelFault {
    fn default() -> Self {
        Self { gain: 1.0, delay: 0.0, noise: NoiseLevel::Deviation(0.0) }
    }
}

/// How much noise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NoiseLevel {
    /// Standard deviation as a fraction of the channel's root mean square in the record.
    Fraction(f64),
    /// Standard deviation in the channel's unit.
    Deviation(f64),
}

impl Chain {
    /// The faults of the load cell and of `sensors` accelerometers, gains as drawn.
    pub fn faults(&self, sensors: usize) -> Vec<ChannelFault> {
        let mut random = Random::of_part(self.seed, GAINS);
        let known = std::iter::once(&self.excitation).chain(&self.accelerometers).copied();
        let all = known.chain(std::iter::repeat(ChannelFault::default())).take(1 + sensors);
        all.map(|fault| ChannelFault {
            gain: fault.gain * (1.0 + self.gain_scatter * random.normal()),
            ..fault
        })
        .collect()
    }

    pub(super) fn check(&self, sensors: usize) -> Result<(), RigError> {
        let legal = |fault: &ChannelFault| {
            let (NoiseLevel::Fraction(noise) | NoiseLevel::Deviation(noise)) = fault.noise;
            fault.gain.is_finite()
                && (0.0..=LONGEST_DELAY).contains(&fault.delay)
                && (0.0..f64::INFINITY).contains(&noise)
        };
        if self.faults(sensors).iter().all(legal) && (0.0..1.0).contains(&self.gain_scatter) {
            return Ok(());
        }
        Err(RigError::Input(format!(
            "gains must be finite, delays between 0 and {LONGEST_DELAY} s, noise at least 0, the scatter of gains below 1"
        )))
    }
}
