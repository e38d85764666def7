//! The published contact at the published levels, from samples to laws.

use std::f64::consts::TAU;

use super::{Identification, IdentifyOptions, LevelSource, identify};
use crate::contact::Law;
use crate::data::{Channel, Dataset, Record, Regime};
use crate::harmonic::Resonance;
use crate::identify::inversion::tests::{LEVELS, beam, description, error, measured, truths};
use crate::model::{Contact, Model, Structure};
use crate::numeric::fourier::value;

/// Samples a second, not in step with any period, and seconds.
const RATE: f64 = 4096.0;
const DURATION: f64 = 2.0;

/// The beam with another contact than the one in the records.
fn model() -> Model {
    let contact = Contact {
        law: Law::named("jenkins", &[]).unwrap(),
        tangential_stiffness: 1e6,
        friction_coefficient: 0.1,
        normal_load: 147.15,
        normal_stiffness: 0.0,
        normal: None,
    };
    let structure = Structure::Beam(description(4));
    Model { structure, contact: Some(contact), effects: Vec::new(), free: None }
}

fn channel(name: String, unit: &'static str, values: Vec<f64>) -> Channel {
    Channel { name, unit, values, noise: None }
}

/// Samples of `truths` with `noise` as a part of each channel's root mean square and gains of the accelerometers and the
/// load cell.
fn dataset(truths: &[Resonance], noise: f64, gains: [f64; 4], seed: u64) -> Dataset {
    let fine = beam(30);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let times: Vec<f64> = (0..(RATE * DURATION) as usize).map(|k| k as f64 / RATE).collect();
    let mut record = |(truth, level): (&Resonance, &f64)| {
        let motion = measured(&fine, truth);
        let mut sampled = |coefficients: &[f64], gain: f64| -> Vec<f64> {
            let size = (coefficients.iter().map(|x| x * x).sum::<f64>() / 2.0).sqrt();
            let at = |t: &f64| value(coefficients, truth.angular_frequency * t);
            times.iter().map(|t| gain * at(t) + noise * size * normal()).collect()
        };
        let mut channels = vec![
            channel("time".into(), "s", times.clone()),
            channel("excitation".into(), "N", sampled(&motion.excitation, gains[3])),
        ];
        for ((sensor, accelerations), gain) in fine.sensors.iter().zip(&motion.accelerations).zip(gains) {
            let name = format!("acceleration:x={}", sensor.position);
            channels.push(channel(name, "m/s^2", sampled(accelerations, gain)));
        }
        Record { name: format!("{level}.csv"), regime: Regime::Steady, use_for: None, channels }
    };
    Dataset { title: None, records: truths.iter().zip(&LEVELS).map(&mut record).collect() }
}

fn identified(dataset: &Dataset, gain: f64) -> Identification {
    let options = IdentifyOptions { excitation_gain: gain, sensor_gain: gain, ..IdentifyOptions::default() };
    identify(&model(), dataset, &options).unwrap()
}

/// Parameters of table 3 within 2 %; loops and predictions within `bound`, normalised.
fn check_table_3(found: &Identification, truths: &[Resonance], bound: f64) {
    let law = &found.laws[found.best.unwrap()];
    let truth = [7.9e6, 7.9e6 / 8.7e4 / 147.15, 0.3];
    assert_eq!(law.model.contact.unwrap().law.kind.name, "valanis");
    for (found, truth) in law.parameters.iter().zip(truth) {
        assert!((found.value / truth - 1.0).abs() < 0.02, "{found:?}");
    }
    let periods = &found.inversion.as_ref().unwrap().periods;
    for (period, truth) in periods.iter().zip(truths) {
        let count = period.force.len().min(truth.contact_force.len());
        let off = error(&period.force[1..count], &truth.contact_force[1..count]);
        assert!(off < bound, "{off}");
    }
    // One level was fitted, the largest; the others were predicted.
    assert_eq!(found.fitted, [LEVELS.len() - 1]);
    assert!(law.errors.iter().all(|error| error.unwrap() < bound), "{:?}", law.errors);
}

/// A record whose equations have no solution is left out and said; the others are identified.
#[test]
fn a_record_that_cannot_be_inverted_is_skipped() {
    let truths = truths(&beam(30));
    let mut dataset = dataset(&truths, 0.001, [1.0; 4], 3);
    let broken = &mut dataset.records[2];
    broken.channels.last_mut().unwrap().values[7] = f64::NAN;
    let name = broken.name.clone();
    let found = identified(&dataset, 0.01);
    assert_eq!(found.records.len(), LEVELS.len() - 1);
    assert!(found.skipped.iter().any(|(skipped, reason)| *skipped == name && reason.contains("no solution")));
    assert!(
        found.warnings.iter().any(|warning| warning.starts_with(&format!("{name} could not be inverted")))
    );
    assert!(found.best.is_some() && found.records.iter().all(|record| record.name != name));
    // Alone it leaves no force, and is no error either.
    dataset.records = vec![dataset.records.remove(2)];
    let found = identified(&dataset, 0.01);
    assert!(found.records.is_empty() && found.model.is_none() && found.skipped.len() == 1);
}

#[test]
fn table_3_comes_back_from_samples() {
    let truths = truths(&beam(30));
    let clean = identified(&dataset(&truths, 0.0, [1.0; 4], 1), 0.0);
    check_table_3(&clean, &truths, 0.02);
    let noisy = identified(&dataset(&truths, 0.01, [1.01, 0.99, 1.01, 0.99], 2), 0.01);
    check_table_3(&noisy, &truths, 0.05);
    // A period that no column tells is found between the lines of the spectrum.
    for (record, truth) in noisy.records.iter().zip(&truths) {
        assert!(
            (record.frequency * TAU / truth.angular_frequency - 1.0).abs() < 1e-5,
            "{}",
            record.frequency
        );
    }
    // Every level was held at its resonance, whose stiffness falls.
    let stiffness: Vec<f64> =
        noisy.levels.iter().map(|level| *level.rotational_stiffness.as_ref().unwrap()).collect();
    assert!(stiffness.len() == LEVELS.len() && stiffness.is_sorted_by(|a, b| a > b), "{stiffness:?}");
    let single = |source: &LevelSource| matches!(source, LevelSource::Single(_, off) if off.abs() < 0.02);
    assert!(noisy.levels.iter().all(|level| single(&level.source)), "{:?}", noisy.levels);
}
