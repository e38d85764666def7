//! From motion to numbers: gains, delays, noise.

use super::{Accelerometer, Measured, RigError, Test, TestKind};
use crate::data::{Channel, ChannelName, Place, Record, Regime};
use crate::numeric::random::Random;
use crate::vocabulary as v;

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

/// The chain with its gains drawn.
pub(super) struct Spoiler<'p> {
    chain: &'p Chain,
    sensors: &'p [Accelerometer],
    faults: Vec<ChannelFault>,
    delays: Vec<f64>,
}

impl<'p> Spoiler<'p> {
    pub fn new(chain: &'p Chain, sensors: &'p [Accelerometer]) -> Self {
        let faults = chain.faults(sensors.len());
        let delays = faults.iter().map(|fault| fault.delay).collect();
        Self { chain, sensors, faults, delays }
    }

    /// Of the load cell, then of every accelerometer (s).
    pub fn delays(&self) -> &[f64] {
        &self.delays
    }

    /// The record called `name`, the `number`-th of all.
    pub fn record(&self, name: &str, test: &Test, measured: Measured, number: u64) -> Record {
        let regime = match &test.kind {
            TestKind::SteppedSine(_) => Regime::Steady,
            TestKind::Random(test) if test.lead == 0.0 => Regime::FromRest,
            TestKind::Random(_) | TestKind::RingDown(_) => Regime::UnknownInitialState,
        };
        let mut channels = vec![Channel {
            name: v::TIME.name.into(),
            unit: v::TIME.unit,
            values: measured.time,
            noise: None,
        }];
        let place = |sensor: &Accelerometer| {
            ChannelName { quantity: &v::ACCELERATION, place: Place::Position(sensor.position) }.to_string()
        };
        let accelerations = self.sensors.iter().map(place).zip(measured.accelerations.into_iter().map(Some));
        let all = std::iter::once((v::EXCITATION.name.to_owned(), measured.excitation)).chain(accelerations);
        for (column, ((name, values), fault)) in all.zip(&self.faults).enumerate() {
            let Some(values) = values else { continue };
            let unit = if column == 0 { v::EXCITATION.unit } else { v::ACCELERATION.unit };
            let random = Random::of_part(self.chain.seed, number << 16 | column as u64);
            let (values, deviation) = spoilt(values, fault, random);
            let noise = Some(deviation).filter(|noise| self.chain.noise_told && *noise > 0.0);
            channels.push(Channel { name, unit, values, noise });
        }
        Record { name: name.to_owned(), regime, use_for: test.use_for, channels }
    }
}

/// What is shown, and the noise in it.
fn spoilt(mut values: Vec<f64>, fault: &ChannelFault, mut random: Random) -> (Vec<f64>, f64) {
    values.iter_mut().for_each(|value| *value *= fault.gain);
    let square = values.iter().map(|value| value * value).sum::<f64>() / values.len().max(1) as f64;
    let deviation = match fault.noise {
        NoiseLevel::Fraction(fraction) => fraction * square.sqrt(),
        NoiseLevel::Deviation(deviation) => deviation,
    };
    if deviation > 0.0 {
        values.iter_mut().for_each(|value| *value += deviation * random.normal());
    }
    (values, deviation)
}
