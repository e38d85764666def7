use std::f64::consts::TAU;

use super::*;
use crate::data::{Channel, Regime};
use crate::fit::compare::ChannelResult;

const SAMPLES: usize = 800;
const STEP: f64 = 1e-3;

/// Noise of deviation one.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut numbers = fastrand::Rng::with_seed(seed);
    move || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0
}

/// Motion of record `k` at a time: two sines of a level of its own.
fn motion(k: usize, t: f64) -> f64 {
    let level = 1e-3 * (1.0 + 0.3 * k as f64);
    level
        * ((TAU * (5.0 + 0.37 * k as f64) * t).sin() + 0.4 * (TAU * (13.0 - 0.21 * k as f64) * t + 1.0).sin())
}

fn of(lacks: impl FnMut(usize, f64, f64, f64) -> f64) -> (Vec<Record>, Stage) {
    moved_by(motion, lacks)
}

/// Nine records under `motion` whose force is predicted as a spring's and measured as that and what `lacks` says of record,
/// time, displacement, and velocity.
fn moved_by(
    motion: impl Fn(usize, f64) -> f64,
    mut lacks: impl FnMut(usize, f64, f64, f64) -> f64,
) -> (Vec<Record>, Stage) {
    let (mut records, mut results) = (Vec::new(), Vec::new());
    for k in 0..9 {
        let time: Vec<f64> = (0..SAMPLES).map(|i| STEP * i as f64).collect();
        let moved: Vec<f64> = time.iter().map(|t| motion(k, *t)).collect();
        let predicted: Vec<f64> = moved.iter().map(|u| 1e4 * u).collect();
        let velocity = |t: f64| (motion(k, t + 1e-6) - motion(k, t - 1e-6)) / 2e-6;
        let force =
            (0..SAMPLES).map(|i| predicted[i] + lacks(k, time[i], moved[i], velocity(time[i]))).collect();
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let channels = vec![
            channel("time", "s", time),
            channel("displacement", "m", moved),
            channel("force", "N", force),
        ];
        let name = format!("r{k}.csv");
        records.push(Record { name, regime: Regime::UnknownInitialState, use_for: None, channels });
        let force = ChannelResult { name: "force".into(), unit: "N", error: 1.0, rms: 1.0, predicted };
        results.push(RecordResult { error: 1.0, channels: vec![force], failure: None });
    }
    let stage = Stage {
        name: "refitted".into(),
        parameters: vec![],
        error: 1.0,
        records: results,
        evaluations: 0,
        notes: vec![],
    };
    (records, stage)
}

fn seen(lacks: impl FnMut(usize, f64, f64, f64) -> f64) -> Appearance {
    let (records, stage) = of(lacks);
    appearance(&records, &stage)
}

fn fraction(found: &Appearance, against: &str) -> f64 {
    found.shapes.iter().find(|shape| shape.against == against).unwrap().fraction
}

#[test]
fn white_noise_is_attributed_to_nothing() {
    for seed in 0..20 {
        let mut noise = noise(seed);
        let found = seen(|_, _, _, _| noise());
        for shape in &found.shapes {
            assert!(shape.fraction < 0.01, "{} {}", shape.against, shape.fraction);
        }
        assert!(found.shapes.iter().filter(|shape| shape.fraction > 0.0).count() <= 1);
        assert_eq!(found.hints.iter().filter(|hint| hint.is_of_the_measurement()).count(), 0);
    }
}

#[test]
fn noise_with_a_memory_of_its_own_is_attributed_to_nothing() {
    for seed in 0..20 {
        let (mut noise, mut last) = (noise(100 + seed), 0.0);
        let found = seen(|_, _, _, _| {
            last = 0.95 * last + 0.31 * noise();
            last
        });
        let told: Vec<_> =
            found.shapes.iter().filter(|s| s.fraction > 0.0).map(|s| (s.against, s.fraction)).collect();
        assert!(told.len() <= 1 && told.iter().all(|(_, fraction)| *fraction < 0.03), "{seed} {told:?}");
        assert!(found.hints.iter().all(|hint| !hint.is_of_the_measurement()), "{seed} {:?}", found.hints);
    }
}

#[test]
fn a_function_of_one_thing_is_attributed_to_it_with_its_part_of_the_variance() {
    // A signal as large as the noise is half of the variance.
    let of_place = |noise: &mut dyn FnMut() -> f64, u: f64| 2.0_f64.sqrt() * (2500.0 * u).sin() + noise();
    let mut first = noise(1);
    let place = seen(|_, _, u, _| of_place(&mut first, u));
    assert_eq!(place.shapes[0].against, "displacement");
    let mut second = noise(2);
    let speed = seen(|_, _, _, v| (v / 0.01).tanh() + noise_of(&mut second));
    assert_eq!(speed.shapes[0].against, "velocity");
    let mut third = noise(3);
    let time = seen(|_, t, _, _| (TAU * 1.3 * t).cos() * 2.0_f64.sqrt() + noise_of(&mut third));
    assert_eq!(time.shapes[0].against, "time in the record");
    for found in [&place, &speed, &time] {
        let share = found.shapes[0].fraction;
        assert!((0.3..0.6).contains(&share), "{} {share}", found.shapes[0].against);
    }
    assert!(fraction(&place, "time in the record") < 0.05 && fraction(&time, "displacement") < 0.05);
}

fn noise_of(noise: &mut impl FnMut() -> f64) -> f64 {
    noise()
}

#[test]
fn the_mean_of_a_shape_is_the_function_that_made_it() {
    let mut noise = noise(4);
    let found = seen(|_, _, u, _| 3e3 * u + 5.0 + 0.2 * noise());
    let shape = &found.shapes[0];
    assert_eq!((shape.against, shape.unit, shape.x_unit), ("displacement", "N", "m"));
    for (x, mean) in shape.x.iter().zip(&shape.mean) {
        assert!((mean - 3e3 * x - 5.0).abs() < 0.4, "{mean} at {x}");
    }
}

#[test]
fn what_follows_the_last_reversal_is_memory() {
    // Exponentially forgotten from each corner: neither place nor speed tells it.
    let mut noise = noise(5);
    let (records, _) = of(|_, _, _, _| 0.0);
    let moved: Vec<Vec<f64>> =
        records.iter().map(|record| record.channel("displacement").unwrap().values.clone()).collect();
    let turns: Vec<Vec<usize>> = moved.iter().map(|values| reversals(values)).collect();
    let found = seen(|k, t, u, _| {
        let here = (t / STEP).round() as usize;
        let last = turns[k].iter().rev().find(|turn| **turn <= here);
        last.map_or(0.0, |turn| 3.0 * (-(u - moved[k][*turn]).abs() / 4e-4).exp()) + 0.3 * noise()
    });
    assert!(found.shapes[0].remembers(), "{}", found.shapes[0].against);
    assert!(found.hints.iter().any(|hint| hint.id() == "memory"), "{:?}", found.hints);
}

#[test]
fn a_hum_is_found_within_a_line_with_its_amplitude_and_harmonics_of_the_motion_are_none() {
    let bin = 1.0 / (STEP * SAMPLES as f64);
    for (frequency, amplitude) in [(50.0, 1.5), (61.7, 0.6), (203.1, 3.0)] {
        let mut noise = noise(6);
        let found = seen(|k, t, _, _| amplitude * (TAU * frequency * t + k as f64).sin() + noise());
        let lines: Vec<&Line> = found
            .hints
            .iter()
            .filter_map(|hint| if let Hint::Hum(line) = hint { Some(line) } else { None })
            .collect();
        assert_eq!(lines.len(), 1, "{frequency}: {lines:?}");
        assert!((lines[0].frequency - frequency).abs() < 0.3 * bin, "{frequency}: {}", lines[0].frequency);
        assert!((lines[0].amplitude / amplitude - 1.0).abs() < 0.15, "{amplitude}: {}", lines[0].amplitude);
        assert_eq!((lines[0].unit, lines[0].records[1]), ("N", 9));
    }
    let mut noise = noise(7);
    let harmonics = seen(|_, _, u, _| 2e9 * u.powi(3) + 0.1 * noise());
    assert!(harmonics.hints.iter().all(|hint| hint.id() != "hum"), "{:?}", harmonics.hints);
}

#[test]
fn harmonics_of_two_tones_are_no_hum_whichever_is_the_larger() {
    for third in [0.3, 1.0, 3.0] {
        let two = |k: usize, t: f64| {
            let level = 1e-3 * (1.0 + 0.3 * k as f64);
            level * ((TAU * 41.3 * t).sin() + third * (TAU * 123.9 * t + 0.7).sin())
        };
        let mut noise = noise(9);
        let (records, stage) = moved_by(two, |_, _, u, _| 2e9 * u.powi(3) + 0.1 * noise());
        let hints = appearance(&records, &stage).hints;
        assert!(hints.iter().all(|hint| hint.id() != "hum"), "{third}: {hints:?}");
        // One that neither makes is.
        let (records, stage) = moved_by(two, |_, t, _, _| 2.0 * (TAU * 180.1 * t).sin() + 0.1 * noise());
        let hints = appearance(&records, &stage).hints;
        assert!(hints.iter().any(|hint| hint.id() == "hum"), "{third}: {hints:?}");
    }
}

#[test]
fn a_harmonic_that_resounds_in_a_record_of_few_periods_is_no_hum() {
    let rate = TAU * 4.0 / (STEP * SAMPLES as f64);
    let few = |k: usize, t: f64| 1e-3 * (1.0 + 0.3 * k as f64) * (rate * t).sin();
    let mut noise = noise(11);
    let (mut records, stage) =
        moved_by(few, |_, t, _, _| 2.0 * (16.0 * rate * t + 0.4).sin() + 0.1 * noise());
    let hum = |records: &[Record]| appearance(records, &stage).hints.iter().any(|hint| hint.id() == "hum");
    // A few slow cycles are no steady state: what stands out there is one.
    assert!(hum(&records));
    records.iter_mut().for_each(|record| record.regime = Regime::Steady);
    assert!(!hum(&records));
}

/// What is seen when the force, noise and all, is changed sample by sample.
fn spoilt(change: impl Fn(usize, f64) -> f64) -> Vec<Hint> {
    let mut noise = noise(8);
    let (mut records, stage) = of(|_, _, _, _| 0.1 * noise());
    for record in &mut records {
        let force = record.channels.iter_mut().find(|channel| channel.name == "force").unwrap();
        force.values.iter_mut().enumerate().for_each(|(i, value)| *value = change(i, *value));
    }
    appearance(&records, &stage).hints
}

#[test]
fn clipping_is_told_with_its_levels() {
    let hints = spoilt(|_, force| force.clamp(-20.0, 20.0));
    let Some(Hint::Clipping { levels, fraction, .. }) = hints.iter().find(|hint| hint.id() == "clipping")
    else {
        panic!("{hints:?}")
    };
    assert_eq!(levels[..], [-20.0, 20.0]);
    assert!(*fraction > 0.005 && *fraction < 0.3, "{fraction}");
    assert!(spoilt(|_, force| force).iter().all(|hint| !hint.is_of_the_measurement()));
}

#[test]
fn a_coarse_channel_is_not_clipped() {
    let hints = spoilt(|_, force| (force / 0.5).round() * 0.5);
    assert!(hints.iter().all(|hint| hint.id() != "clipping"), "{hints:?}");
}

#[test]
fn drop_outs_are_counted() {
    let hints = spoilt(|i, force| if i % 200 < 10 { 0.0 } else { force });
    let Some(Hint::DropOuts { count, samples, zero, .. }) =
        hints.iter().find(|hint| hint.id() == "drop-outs")
    else {
        panic!("{hints:?}")
    };
    assert!(*zero && *count > 20 && *count <= 36 && *samples == 10 * count, "{count} {samples}");
}

#[test]
fn a_stiffness_that_falls_along_the_records_is_drift() {
    let mut noise = noise(9);
    let found = seen(|_, t, u, _| -0.2 * (t - 0.4) * 1e4 * u + 0.1 * noise());
    let change = found.hints.iter().find_map(|hint| match hint {
        Hint::Drift { change, .. } => Some(*change),
        _ => None,
    });
    // 20 % per second over halves of 0.4 s.
    assert!((change.unwrap() + 0.08).abs() < 0.02, "{change:?}");
}

#[test]
fn a_gain_that_rises_from_record_to_record_is_drift_over_records() {
    let mut noise = noise(10);
    let found = seen(|k, _, u, _| 0.01 * (k as f64 - 4.0) * 1e4 * u + 0.1 * noise());
    let change = found.hints.iter().find_map(|hint| match hint {
        Hint::DriftOverRecords { change, .. } => Some(*change),
        _ => None,
    });
    assert!((change.unwrap() - 0.08).abs() < 0.01, "{change:?}");
}
