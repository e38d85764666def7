//! Tables 1 and 2 of the paper: a beam with rotational springs, measured by random and by stepped excitation.

use std::f64::consts::TAU;

use super::{IdentifyOptions, LevelSource, identify};
use crate::data::{Channel, Dataset, Record, Regime};
use crate::identify::inversion::tests::description;
use crate::model::{Model, Structure};
use crate::system::{Beam, ModalBeam, PointMass};

/// The beam that gives both tables.
fn published(rotational_stiffness: f64) -> Beam {
    let mass = |position, mass| PointMass { position, mass };
    let point_masses = vec![mass(0.55, 0.030), mass(0.3, 0.0175), mass(0.1, 0.005)];
    Beam { youngs_modulus: 203e9, point_masses, rotational_stiffness, ..description(5) }
}

fn channel(name: &str, unit: &'static str, values: Vec<f64>) -> Channel {
    Channel { name: name.into(), unit, values, noise: None }
}

fn record(name: &str, regime: Regime, step: f64, force: Vec<f64>, sensors: Vec<Vec<f64>>) -> Record {
    let times = (0..force.len()).map(|k| k as f64 * step).collect();
    let mut channels = vec![channel("time", "s", times), channel("excitation", "N", force)];
    let places = ["acceleration:x=0.55", "acceleration:x=0.3", "acceleration:x=0.1"];
    channels.extend(places.iter().zip(sensors).map(|(name, values)| channel(name, "m/s^2", values)));
    Record { name: name.into(), regime, use_for: None, channels }
}

fn model() -> Model {
    Model { structure: Structure::Beam(published(0.0)), contact: None, effects: Vec::new(), free: None }
}

/// Accelerations under a force held between samples, every mode stepped exactly, with 1 % of noise.
fn random_record(beam: &ModalBeam, rate: f64, seconds: f64) -> Record {
    let mut random = fastrand::Rng::with_seed(11);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let count = (rate * seconds) as usize;
    let force: Vec<f64> = (0..count).map(|_| 0.1 * normal()).collect();
    let mut sensors = vec![vec![0.0; count]; beam.sensors.len()];
    for (i, omega) in beam.angular_frequency.iter().enumerate() {
        let decay = beam.damping_ratio[i] * omega;
        let turned = (omega * omega - decay * decay).sqrt();
        let (e, (sin, cos)) = ((-decay / rate).exp(), (turned / rate).sin_cos());
        let (mut q, mut v) = (0.0, 0.0);
        for (k, held) in force.iter().enumerate() {
            let own = held * beam.excitation_shape[i];
            let acceleration = own - 2.0 * decay * v - omega * omega * q;
            sensors.iter_mut().zip(&beam.sensors).for_each(|(a, at)| a[k] += at.shape[i] * acceleration);
            let (rest, still) = (q - own / (omega * omega), own / (omega * omega));
            let slope = (v + decay * rest) / turned;
            q = still + e * (rest * cos + slope * sin);
            v = e * (turned * (slope * cos - rest * sin) - decay * (rest * cos + slope * sin));
        }
    }
    for values in &mut sensors {
        let size = (values.iter().map(|x| x * x).sum::<f64>() / count as f64).sqrt();
        values.iter_mut().for_each(|x| *x += 0.01 * size * normal());
    }
    record("random.csv", Regime::FromRest, 1.0 / rate, force, sensors)
}

#[test]
fn table_1_comes_back_from_random_excitation() {
    let beam = ModalBeam::new(&published(197.4)).unwrap();
    let dataset = Dataset { title: None, records: vec![random_record(&beam, 2048.0, 64.0)] };
    let options = IdentifyOptions { normal_load: Some(147.15), ..IdentifyOptions::default() };
    let found = identify(&model(), &dataset, &options).unwrap();
    let linear = &found.linear[0];
    for (pole, [truth, table]) in linear.poles.iter().zip([[52.78, 52.85], [164.02, 164.0], [330.37, 330.25]])
    {
        assert!((pole.frequency - truth).abs() < 0.1, "{pole:?}");
        assert!((pole.frequency - table).abs() < 0.2, "{pole:?}");
        assert!((pole.damping_ratio / 0.003 - 1.0).abs() < 0.25, "{pole:?}");
    }
    assert_eq!((linear.poles.len(), found.levels.len()), (3, 1));
    assert!((linear.rotational_stiffness.unwrap() / 197.4 - 1.0).abs() < 0.03, "{linear:?}");
    // No steady record, no force: said, not assumed.
    assert!(found.records.is_empty() && found.model.is_none() && found.warnings.len() == 1);
}

/// Records of a stepped sine in a band of 1 Hz about the resonance of the beam with this spring, at this amplitude.
fn stepped(level: f64, stiffness: f64, normal: &mut impl FnMut() -> f64) -> Vec<Record> {
    let beam = ModalBeam::new(&published(stiffness)).unwrap();
    let (rate, count) = (2048.0, 4096);
    let first = beam.angular_frequency[0] / TAU;
    let at = |k: usize| {
        let frequency = first - 0.5 + k as f64 / 8.0;
        let omega = TAU * frequency;
        // Accelerance at the sensors, real and imaginary part.
        let accelerance = |shape: &[f64]| {
            (0..shape.len()).fold([0.0; 2], |[re, im], i| {
                let (natural, ratio) = (beam.angular_frequency[i], beam.damping_ratio[i]);
                let (a, b) = (natural * natural - omega * omega, 2.0 * ratio * natural * omega);
                let gain = -omega * omega * shape[i] * beam.excitation_shape[i] / (a * a + b * b);
                [re + gain * a, im - gain * b]
            })
        };
        let held = accelerance(&beam.sensors[0].shape);
        let force = level / held[0].hypot(held[1]);
        let mut signal = |[re, im]: [f64; 2]| -> Vec<f64> {
            let size = 0.01 * re.hypot(im) / 2_f64.sqrt();
            let value = |k: usize| {
                let (sin, cos) = (omega * k as f64 / rate).sin_cos();
                re * cos - im * sin
            };
            (0..count).map(|k| value(k) + size * normal()).collect()
        };
        let excitation = signal([force, 0.0]);
        let moved = |shape: &[f64]| accelerance(shape).map(|part| force * part);
        let sensors = beam.sensors.iter().map(|sensor| signal(moved(&sensor.shape))).collect();
        record(&format!("{level}-{k}.csv"), Regime::Steady, 1.0 / rate, excitation, sensors)
    };
    (0..9).map(at).collect()
}

#[test]
fn table_2_comes_back_from_stepped_sines() {
    let table = [
        (10.0, 192.8, 52.78),
        (20.0, 167.1, 52.34),
        (30.0, 125.4, 51.58),
        (40.0, 73.6, 50.55),
        (50.0, 71.4, 50.50),
        (60.0, 65.7, 50.38),
        (70.0, 58.7, 50.23),
    ];
    let mut random = fastrand::Rng::with_seed(12);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let records =
        table.iter().flat_map(|(level, stiffness, _)| stepped(*level, *stiffness, &mut normal)).collect();
    let options = IdentifyOptions { normal_load: Some(147.15), ..IdentifyOptions::default() };
    let found = identify(&model(), &Dataset { title: None, records }, &options).unwrap();
    assert_eq!(found.levels.len(), table.len());
    for (level, (amplitude, stiffness, frequency)) in found.levels.iter().zip(table) {
        assert!(matches!(&level.source, LevelSource::Stepped(records) if records.len() == 9));
        assert!((level.amplitude / amplitude - 1.0).abs() < 0.01, "{level:?}");
        assert!((level.frequency - frequency).abs() < 0.12, "{level:?}");
        assert!((level.damping_ratio.unwrap() / 0.003 - 1.0).abs() < 0.1, "{level:?}");
        let told = level.rotational_stiffness.as_ref().unwrap();
        assert!((told / stiffness - 1.0).abs() < 0.03, "{told} {stiffness}");
    }
    // The contact is identified at each resonance alone; the other records are named.
    assert_eq!((found.records.len(), found.skipped.len()), (7, 56));
    assert!(found.skipped.iter().all(|(_, reason)| reason.contains("resonance at")));
}
