//! From motion to numbers.

use super::chain::{Chain, ChannelFault, NoiseLevel};
use super::measured::{ContactSamples, Measured};
use super::plan::Accelerometer;
use super::tested::Tested;
use crate::data::{Channel, ChannelName, Place, Record, Regime, Use};
use crate::numeric::random::Random;
use crate::vocabulary::{self as v, Quantity};

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

    /// The record called `name`, the `number`-th of all, and the truth.
    pub fn tested(
        &self,
        name: &str,
        regime: Regime,
        use_for: Option<Use>,
        measured: Measured,
        number: u64,
    ) -> Tested {
        let contact = measured.contact.map(|contact| truth(name, regime, &measured.time, contact));
        let mut channels = vec![channel(&v::TIME, measured.time)];
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
        let record = Record { name: name.to_owned(), regime, use_for, channels };
        Tested { record, contact }
    }
}

/// What the contact did in the record called `name`.
fn truth(name: &str, regime: Regime, time: &[f64], contact: ContactSamples) -> Record {
    let stem = name.strip_suffix(".csv").unwrap_or(name);
    let mut channels = vec![
        channel(&v::TIME, time.to_vec()),
        channel(&v::DISPLACEMENT, contact.displacement),
        channel(&v::VELOCITY, contact.velocity),
        channel(&v::FORCE, contact.force),
    ];
    if let Some(normal) = contact.normal {
        channels.push(channel(&v::NORMAL_DISPLACEMENT, normal.displacement));
        channels.push(channel(&v::NORMAL_LOAD, normal.load));
    }
    Record { name: format!("{stem}-contact.csv"), regime, use_for: None, channels }
}

fn channel(quantity: &Quantity, values: Vec<f64>) -> Channel {
    Channel { name: quantity.name.into(), unit: quantity.unit, values, noise: None }
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
