//! What spoils a measurement and is in no catalogue: hum of the mains, an amplifier that clips, samples that are lost.

use std::f64::consts::TAU;

use crate::records::random::Random;
use crate::records::record::{Record, Role, root_mean_square};

/// What spoils all responses of a measurement.
#[derive(Debug, Clone, PartialEq)]
pub enum Spoilt {
    /// 50 Hz and its third harmonic in every channel, as large in every record.
    Hum {
        /// Amplitude over the largest root mean square of the channel.
        share: f64,
    },
    /// The channel ends at both sides, noise and all.
    Clipping {
        /// Where, over the largest value of the channel.
        share: f64,
    },
    /// Now and then some samples read zero.
    DropOuts {
        /// Fraction of the samples.
        share: f64,
    },
}

/// Samples that are lost together.
const LOST: usize = 12;

impl Spoilt {
    /// Names among the hidden effects.
    pub const IDS: [&'static str; 3] = ["unknown:hum", "unknown:clipping", "unknown:drop_outs"];

    /// Draws its numbers.
    pub fn draw(id: &str, strength: f64, random: &mut Random) -> Option<Self> {
        Some(match id {
            "unknown:hum" => Spoilt::Hum { share: strength * random.between(0.05, 0.1) },
            "unknown:clipping" => Spoilt::Clipping { share: 1.0 - strength * random.between(0.2, 0.35) },
            "unknown:drop_outs" => Spoilt::DropOuts { share: strength * random.between(0.02, 0.05) },
            _ => return None,
        })
    }

    /// Names that a program may give to it when it knows it.
    pub fn names(&self) -> &'static [&'static str] {
        match self {
            Spoilt::Hum { .. } => &["hum", "mains_hum", "sensor_hum"],
            Spoilt::Clipping { .. } => &["clipping", "sensor_clipping"],
            Spoilt::DropOuts { .. } => &["drop_outs", "sensor_drop_outs"],
        }
    }

    /// Spoils all responses.
    pub fn spoil(&self, records: &mut [Record], random: &mut Random) {
        let count = records.first().map_or(0, |record| record.columns.len());
        for place in 0..count {
            if records[0].columns[place].role != Role::Response {
                continue;
            }
            let largest = |of: fn(&[f64]) -> f64| {
                records.iter().map(|record| of(&record.columns[place].values)).fold(0.0, f64::max)
            };
            let rms = largest(root_mean_square);
            let peak = largest(|values| values.iter().fold(0.0, |peak, value| peak.max(value.abs())));
            for record in records.iter_mut() {
                let (times, rest) = record.columns.split_at_mut(1);
                self.spoil_channel(&times[0].values, &mut rest[place - 1].values, [rms, peak], random);
            }
        }
    }

    fn spoil_channel(&self, times: &[f64], values: &mut [f64], [rms, peak]: [f64; 2], random: &mut Random) {
        match self {
            Spoilt::Hum { share } => {
                let phases = [random.phase(), random.phase()];
                for (value, time) in values.iter_mut().zip(times) {
                    let wave = |harmonic: f64, phase: f64| (TAU * 50.0 * harmonic * time + phase).sin();
                    *value += share * rms * (wave(1.0, phases[0]) + 0.3 * wave(3.0, phases[1]));
                }
            }
            Spoilt::Clipping { share } => {
                values.iter_mut().for_each(|value| *value = value.clamp(-share * peak, share * peak));
            }
            Spoilt::DropOuts { share } => {
                let count = (share * values.len() as f64 / LOST as f64).ceil() as usize;
                for _ in 0..count {
                    let start = random.between(0.0, (values.len() - LOST) as f64) as usize;
                    values[start..start + LOST].fill(0.0);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::records::record::{Column, Regime};

    /// A second of a sine and of twice that.
    fn records() -> Vec<Record> {
        let times: Vec<f64> = (0..1000).map(|index| f64::from(index) * 1e-3).collect();
        let record = |size: f64| {
            let values: Vec<f64> = times.iter().map(|time| size * (TAU * 3.0 * time).sin()).collect();
            let columns = vec![
                Column::new("time", "s", Role::Exact, times.clone()),
                Column::new("displacement", "m", Role::Prescribed, values.clone()),
                Column::new("force", "N", Role::Response, values),
            ];
            Record { regime: Regime::FromRest, columns, told: Vec::new() }
        };
        vec![record(1.0), record(2.0)]
    }

    fn spoilt(how: &Spoilt) -> Vec<Vec<f64>> {
        let mut records = records();
        how.spoil(&mut records, &mut Random::new(3));
        for (spoilt, clean) in records.iter().zip(self::records()) {
            assert_eq!(spoilt.columns[..2], clean.columns[..2]);
        }
        records.iter().map(|record| record.columns[2].values.clone()).collect()
    }

    #[test]
    fn hum_is_as_large_in_every_record_and_is_at_50_and_150_hz() {
        let share = 0.1;
        for (spoilt, clean) in spoilt(&Spoilt::Hum { share }).iter().zip(records()) {
            let hum: Vec<f64> = spoilt.iter().zip(&clean.columns[2].values).map(|(a, b)| a - b).collect();
            let at = |frequency: f64| {
                let part = |shift: f64| {
                    let wave = |index: usize| (TAU * frequency * index as f64 * 1e-3 + shift).sin();
                    hum.iter().enumerate().map(|(index, value)| value * wave(index)).sum::<f64>() / 500.0
                };
                part(0.0).hypot(part(TAU / 4.0))
            };
            let expected = share * 2.0_f64.sqrt();
            assert!((at(50.0) / expected - 1.0).abs() < 1e-9 && (at(150.0) / expected - 0.3).abs() < 1e-9);
            let rest = root_mean_square(&hum) - expected * (1.0_f64 + 0.09).sqrt() / 2.0_f64.sqrt();
            assert!(rest.abs() < 1e-9, "{rest}");
        }
    }

    #[test]
    fn clipping_ends_at_one_level_and_leaves_the_rest() {
        let all = spoilt(&Spoilt::Clipping { share: 0.75 });
        // 0.75 of the largest of all records: the smaller one does not reach it.
        assert_eq!(all[0], records()[0].columns[2].values);
        let (highest, lowest) = all[1].iter().fold((0.0_f64, 0.0_f64), |(h, l), v| (h.max(*v), l.min(*v)));
        assert!((highest - 1.5).abs() < 1e-5 && (lowest + 1.5).abs() < 1e-5);
        let changed = all[1].iter().zip(&records()[1].columns[2].values).filter(|(a, b)| a != b).count();
        // Of a sine above 3/4: 2 acos(3/4)/π.
        assert!((changed as f64 / 1000.0 - 2.0 * 0.75_f64.acos() / (TAU / 2.0)).abs() < 0.01);
    }

    #[test]
    fn drop_outs_read_zero_and_are_as_many_as_said() {
        for values in spoilt(&Spoilt::DropOuts { share: 0.04 }) {
            let lost = values.iter().filter(|value| **value == 0.0).count();
            assert!((30..=50).contains(&lost), "{lost}");
        }
    }
}
