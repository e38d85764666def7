//! What counts as a repeat of an experiment, and what is made of noise that cannot be.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{
    DiagnoseOptions, DiagnoseWatch, Diagnosis, NoiseSource, Verdict, diagnose, noise_of,
};
use stickslip::model::Model;

const STIFFNESS: f64 = 5e6;
const LIMIT: f64 = 50.0;
const SAMPLES: usize = 400;
/// N/m.
const SOFT_STOP: f64 = 7e5;

fn model() -> Model {
    let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                tangential_stiffness = 5e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
    Model::parse(text).unwrap()
}

/// A sine from rest of `amplitude` (m) about `offset` (m), over two periods, on an ideal Jenkins element with a spring
/// beside it.
struct Test {
    amplitude: f64,
    offset: f64,
    step: f64,
    spring: f64,
    stated: Option<f64>,
}

const PLAIN: Test = Test { amplitude: 3e-5, offset: 0.0, step: 1e-3, spring: 0.0, stated: None };

/// Noise of deviation one: the same for the same seed.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    // A fork, since the numbers of neighbouring seeds resemble each other.
    let mut numbers = fastrand::Rng::with_seed(seed).fork();
    move || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0
}

impl Test {
    /// With force noise of `deviation` (N).
    fn record(&self, name: &str, seed: u64, deviation: f64) -> Record {
        let motion: Vec<f64> =
            (0..SAMPLES).map(|i| self.amplitude * (2.0 * TAU * i as f64 / SAMPLES as f64).sin()).collect();
        let (mut slider, mut noise) = (0.0, noise(seed));
        let force = motion.iter().map(|u: &f64| {
            let trial: f64 = STIFFNESS * (u - slider);
            let friction = trial.clamp(-LIMIT, LIMIT);
            slider = u - friction / STIFFNESS;
            friction + self.spring * u + deviation * noise()
        });
        let channel = |name: &str, unit, values, noise| Channel { name: name.into(), unit, values, noise };
        let channels = vec![
            channel("time", "s", (0..SAMPLES).map(|i| i as f64 * self.step).collect(), None),
            channel("force", "N", force.collect(), self.stated),
            channel("displacement", "m", motion.iter().map(|u| u + self.offset).collect(), None),
        ];
        Record { name: name.into(), regime: Regime::FromRest, use_for: None, channels }
    }
}

fn sources(records: Vec<Record>) -> Vec<NoiseSource> {
    noise_of(&model(), &Dataset { title: None, records }).iter().map(|noise| noise.source).collect()
}

/// One period alone, so that nothing is to be seen within a record.
fn short(mut record: Record) -> Record {
    for channel in &mut record.channels {
        channel.values.truncate(SAMPLES / 2);
    }
    record
}

#[test]
fn a_repeat_shows_the_noise_and_another_experiment_does_not() {
    let first = || short(PLAIN.record("a", 1, 0.5));
    let again = short(PLAIN.record("b", 2, 0.5));
    let noise = noise_of(&model(), &Dataset { title: None, records: vec![first(), again] });
    assert_eq!(noise[0].source, NoiseSource::Repeats);
    assert!((noise[0].deviation.unwrap() - 0.5).abs() < 0.05, "{noise:?}");
    // Ten times as fast; at another level about a large offset; under another load; the same file.
    let quick = short(Test { step: 1e-4, ..PLAIN }.record("b", 2, 0.5));
    assert_eq!(sources(vec![first(), quick]), [NoiseSource::Unknown; 2]);
    let lifted = |amplitude, seed| short(Test { offset: 1e-3, amplitude, ..PLAIN }.record("b", seed, 0.5));
    assert_eq!(sources(vec![lifted(3e-5, 1), lifted(2e-5, 2)]), [NoiseSource::Unknown; 2]);
    let loaded = |load: f64, seed| {
        let mut record = short(PLAIN.record("b", seed, 0.5));
        let values = vec![load; SAMPLES / 2];
        record.channels.push(Channel { name: "normal_load".into(), unit: "N", values, noise: None });
        record
    };
    assert_eq!(sources(vec![loaded(100.0, 1), loaded(120.0, 2)]), [NoiseSource::Unknown; 2]);
    assert_eq!(sources(vec![loaded(100.0, 1), loaded(100.0, 2)]), [NoiseSource::Repeats; 2]);
    assert_eq!(sources(vec![first(), first()]), [NoiseSource::Unknown; 2]);
}

fn diagnosed(records: Vec<Record>) -> Diagnosis {
    let options = DiagnoseOptions {
        effects: Some(["residual_stiffness", "backlash", "sensor_offset"].map(str::to_owned).to_vec()),
        ..DiagnoseOptions::default()
    };
    diagnose(&model(), &Dataset { title: None, records }, &options, DiagnoseWatch::default()).unwrap()
}

fn levels(of: impl Fn(usize) -> Test) -> Vec<Record> {
    (0..8).map(|i| of(i).record(&format!("r{i}"), i as u64, 0.3)).collect()
}

#[test]
fn noise_that_is_stated_a_hundred_times_too_large_hides_no_effect() {
    let found = diagnosed(levels(|i| Test {
        amplitude: 1e-5 * (2.0 + i as f64),
        spring: 5e5,
        stated: Some(30.0),
        ..PLAIN
    }));
    assert_eq!((found.verdict, found.effects), (Verdict::EffectFound, vec!["residual_stiffness"]));
}

#[test]
fn noise_that_is_stated_a_few_times_too_small_names_no_effect() {
    for (times, memory) in [(3.0, 0.0), (4.0, 0.0), (3.0, 0.9), (4.0, 0.9)] {
        let test =
            |i: u8| Test { amplitude: 1e-5 * (2.0 + f64::from(i)), stated: Some(0.3 / times), ..PLAIN };
        let mut records: Vec<Record> = (0..8).map(|i| test(i).record(&format!("r{i}"), 0, 0.0)).collect();
        for (seed, record) in (0..).zip(&mut records) {
            let (mut noise, mut last) = (noise(seed), 0.0);
            for force in &mut record.channels[1].values {
                last = memory * last + f64::sqrt(1.0 - memory * memory) * noise();
                *force += 0.3 * last;
            }
        }
        let found = diagnosed(records);
        assert!(found.effects.is_empty(), "{times} {memory}: {:?} {:?}", found.verdict, found.effects);
    }
}

#[test]
fn what_only_the_record_of_the_largest_motion_shows_is_not_passed_over() {
    // An end stop that is reached at the highest level alone.
    let mut records = levels(|i| Test { amplitude: 1e-5 * (2.0 + i as f64), stated: Some(0.3), ..PLAIN });
    let last = records.last_mut().unwrap();
    let motion = last.channels[2].values.clone();
    for (force, u) in last.channels[1].values.iter_mut().zip(motion) {
        *force += 2e6 * (u - 8e-5).max(0.0);
    }
    let found = diagnosed(records);
    assert_eq!(found.verdict, Verdict::Unexplained);
    assert!(found.reasons.iter().any(|reason| reason.contains("`r7`")), "{:?}", found.reasons);
}

/// Stuck records of small motions (m), and test records of larger ones.
fn judged_far_away(small: f64, large: f64) -> Vec<Record> {
    let test = |i: usize| matches!(i, 2 | 5);
    let mut records =
        levels(|i| Test { amplitude: if test(i) { large } else { small }, stated: Some(0.3), ..PLAIN });
    for (index, record) in records.iter_mut().enumerate() {
        record.use_for = Some(match index {
            2 | 5 => stickslip::data::Use::Confirm,
            1 | 4 => stickslip::data::Use::Select,
            _ => stickslip::data::Use::Fit,
        });
    }
    records
}

#[test]
fn records_that_tell_too_little_decide_nothing_and_what_they_cannot_explain_is_seen() {
    let of_doubt = |found: &Diagnosis| {
        found.reasons.iter().any(|reason| reason.contains("no explanation reaches a probability"))
    };
    // A stiffness from forces as small as their noise, judged where they are a hundred times as large.
    let found = diagnosed(judged_far_away(8e-8, 8e-6));
    assert!(
        found.verdict == Verdict::InsufficientData && of_doubt(&found),
        "{:?} {:?}",
        found.verdict,
        found.reasons
    );
    assert!(found.next_experiment.unwrap().starts_with("Measure more records"));
    // An end stop that the test records alone reach is significant.
    let mut records = judged_far_away(4e-6, 8e-6);
    for record in &mut records {
        let motion = record.channels[2].values.clone();
        for (force, u) in record.channels[1].values.iter_mut().zip(motion) {
            *force += 2e6 * (u - 7e-6).max(0.0);
        }
    }
    let found = diagnosed(records);
    assert!(
        found.verdict == Verdict::Unexplained && !of_doubt(&found),
        "{:?} {:?}",
        found.verdict,
        found.reasons
    );
}

#[test]
fn a_relevant_error_in_what_was_foretold_counts_though_all_records_together_hide_it() {
    // An end stop so soft that it is relevant in the two test records alone, and not in the eight together.
    let mut records = judged_far_away(4e-6, 8e-6);
    for record in &mut records {
        let motion = record.channels[2].values.clone();
        for (force, u) in record.channels[1].values.iter_mut().zip(motion) {
            *force += SOFT_STOP * (u - 6e-6).max(0.0);
        }
    }
    let found = diagnosed(records);
    assert_eq!(found.verdict, Verdict::Unexplained, "{:?}", found.reasons);
}

#[test]
fn an_effect_that_raises_the_error_of_the_test_records_is_removed() {
    let mut records = levels(|i| Test { amplitude: 1e-5 * (2.0 + i as f64), ..PLAIN });
    for (index, record) in records.iter_mut().enumerate() {
        record.use_for = Some(match index {
            1 | 4 => stickslip::data::Use::Confirm,
            2 | 5 => stickslip::data::Use::Select,
            _ => stickslip::data::Use::Fit,
        });
        if index != 1 && index != 4 {
            record.channels[1].values.iter_mut().for_each(|force| *force += 5.0);
        }
    }
    let found = diagnosed(records);
    assert!(found.effects.is_empty(), "{:?}", found.effects);
    assert!(found.error.test <= found.error.test_refitted);
}

#[test]
fn a_ramp_is_as_good_as_a_steady_level() {
    // A sine whose amplitude grows: the effect shows at its end alone, which does not speak against it.
    let records: Vec<Record> =
        (0..8)
            .map(|i| {
                let mut record =
                    Test { amplitude: 1e-5 * (2.0 + i as f64), spring: 2e5, stated: Some(0.3), ..PLAIN }
                        .record(&format!("r{i}"), i as u64, 0.0);
                let motion: Vec<f64> = record.channels[2].values.clone();
                let ramp = |k: usize| (k as f64 / SAMPLES as f64).powi(2);
                let (mut slider, mut noise) = (0.0, noise(i as u64));
                for (k, u) in motion.iter().enumerate() {
                    let u = u * ramp(k);
                    let friction = (STIFFNESS * (u - slider)).clamp(-LIMIT, LIMIT);
                    slider = u - friction / STIFFNESS;
                    record.channels[2].values[k] = u;
                    record.channels[1].values[k] = friction + 2e5 * u + 0.3 * noise();
                }
                record
            })
            .collect();
    let found = diagnosed(records);
    assert_eq!((found.verdict, found.effects), (Verdict::EffectFound, vec!["residual_stiffness"]));
}

/// One period each at eight levels on a joint with a spring beside it, and a slow wandering of the force (N) that nobody
/// has told of.
fn wandering(deviation: f64) -> Vec<Record> {
    let memory: f64 = 0.99;
    let joint = |i: usize| Test { amplitude: 1e-5 * (2.0 + i as f64), spring: 1e5, ..PLAIN };
    let mut records: Vec<Record> =
        (0..8).map(|i| short(joint(i).record(&format!("r{i}"), i as u64, 0.3))).collect();
    for (i, record) in records.iter_mut().enumerate() {
        let (mut state, mut noise) = (0.0, noise(100 + i as u64));
        for force in &mut record.channels[1].values {
            state = memory * state + (1.0 - memory * memory).sqrt() * noise();
            *force += deviation * state;
        }
    }
    records
}

#[test]
fn what_wanders_more_than_an_effect_explains_is_not_taken_for_noise_by_a_guess() {
    let found = diagnosed(wandering(2.0));
    assert_eq!((found.verdict, found.effects), (Verdict::EffectFound, vec!["residual_stiffness"]));
    for deviation in [6.0, 8.0, 10.0] {
        let found = diagnosed(wandering(deviation));
        assert_eq!(found.verdict, Verdict::InsufficientData, "{deviation}");
        assert!(found.effects.is_empty() && found.groups.is_empty(), "{found:?}");
        assert!(found.reasons.iter().any(|reason| reason.contains("by more than they explain")), "{found:?}");
    }
}
