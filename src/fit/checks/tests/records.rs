//! Faults of loggers and of exports: error codes, lost samples, rounded time stamps, copies under another unit.

use super::{faults, ids, record, values};
use crate::data::{Channel, Dataset, Record, Regime};
use crate::fit::checks::check;
use crate::model::Model;

/// An oscillator of 1 kg on a spring and a contact.
pub(super) fn oscillator() -> Model {
    let text = r#"
        schema = "stickslip.model/1"
        kind = "oscillator"
        mass = [{ name = "m1", mass = 1.0 }]
        spring = [{ between = ["ground", "m1"], stiffness = 1.9e5, damping = 6.0 }]
        excitation = { at = "m1" }
        contact = { at = "m1", law = "jenkins", tangential_stiffness = 1.2e5, friction_coefficient = 0.5, normal_load = 25.0 }
    "#;
    Model::parse(text).unwrap()
}

pub(super) fn channel(name: &str, unit: &'static str, values: Vec<f64>) -> Channel {
    Channel { name: name.to_owned(), unit, values, noise: None }
}

/// A steady state of the oscillator, with noise of a hundredth.
fn vibration() -> Record {
    let mut random = fastrand::Rng::with_seed(5);
    let mut noise = || 0.02 * (random.f64() - 0.5);
    let time: Vec<f64> = (0..4000).map(|k| 2e-4 * f64::from(k)).collect();
    let mut of = |size: f64, late: f64| -> Vec<f64> {
        time.iter().map(|t| size * ((430.0 * t - late).sin() + 0.1 * (1290.0 * t).sin() + noise())).collect()
    };
    let channels = vec![
        channel("excitation:m1", "N", of(10.0, 0.0)),
        channel("acceleration:m1", "m/s^2", of(45.0, -0.8)),
        channel("time", "s", time.clone()),
    ];
    Record { name: "r.csv".to_owned(), regime: Regime::UnknownInitialState, use_for: None, channels }
}

/// What is said of the steady state after `change`.
fn said(change: impl Fn(&mut Record)) -> Vec<String> {
    let mut one = vibration();
    change(&mut one);
    check(&oscillator(), &Dataset { title: None, records: vec![one] })
        .iter()
        .map(ToString::to_string)
        .collect()
}

#[test]
fn error_codes_are_outliers_and_all_are_counted() {
    let cases: [(&str, Vec<usize>, f64); 6] = [
        ("force", vec![500, 501], -9999.0),
        ("force", (500..505).collect(), -9999.0),
        ("force", vec![30, 201, 202, 505, 800, 1111], -9999.0),
        ("force", (0..20).map(|k| 57 * k).collect(), 99_999.0),
        ("displacement", (700..730).collect(), 1.0),
        ("force", vec![0], -9999.0),
    ];
    for (name, places, code) in cases {
        for found in faults(|one| places.iter().for_each(|k| values(one, name)[*k] = code)) {
            assert_eq!(found, ["outlier"], "{name} {places:?}");
        }
        let mut one = record("r.csv", 0.01, 3);
        places.iter().for_each(|k| values(&mut one, name)[*k] = code);
        let found = check(&super::model(), &Dataset { title: None, records: vec![one] });
        let count = format!("({} such samples)", places.len());
        assert!(places.len() == 1 || found[0].to_string().contains(&count), "{}", found[0]);
    }
}

/// Pulses of a hammer and of a trigger stand as far above the rest, and were measured.
#[test]
fn pulses_of_an_excitation_are_no_error_codes() {
    let clean = said(|one| {
        let force = values(one, "excitation:m1");
        force.iter_mut().for_each(|value| *value *= 1e-4);
        for (k, part) in [0.2, 0.7, 1.0, 0.71, 0.19].into_iter().enumerate() {
            force[900 + k] = 80.0 * part;
        }
    });
    assert_eq!(clean, Vec::<String>::new());
}

#[test]
fn zeros_in_motion_are_drop_outs_scattered_or_in_a_row() {
    let scattered: Vec<usize> = (0..40).map(|k| 29 * k + (k * k) % 17).collect();
    for found in faults(|one| scattered.iter().for_each(|k| values(one, "force")[*k] = 0.0)) {
        assert_eq!(found, ["drop-outs"]);
    }
    let found = said(|one| values(one, "acceleration:m1")[2000..2040].fill(0.0));
    assert!(found.len() == 1 && found[0].contains("1 drop-out from sample 2001"), "{found:?}");
}

#[test]
fn single_lost_samples_are_gaps_and_counted() {
    let lost = |places: &[usize]| {
        said(|one| {
            for place in places.iter().rev() {
                one.channels.iter_mut().for_each(|channel| {
                    _ = channel.values.remove(*place);
                });
            }
        })
    };
    let found = lost(&[2000]);
    assert!(found.len() == 1 && found[0].contains("about 1 sample is missing"), "{found:?}");
    let every: Vec<usize> = (1..41).map(|k| 97 * k).collect();
    let found = lost(&every);
    assert!(found.len() == 1 && found[0].contains("about 40 samples are missing"), "{found:?}");
}

#[test]
fn rounded_time_stamps_are_named_with_what_to_do_and_jitter_is_not() {
    let stamped = |step: f64, digit: f64| {
        said(move |one| {
            values(one, "time")
                .iter_mut()
                .enumerate()
                .for_each(|(k, t)| *t = (step * k as f64 / digit).round() * digit);
        })
    };
    for (step, digit) in [(1.0 / 5120.0, 1e-4), (1.0 / 2048.0, 1e-4), (1.5e-4, 1e-4)] {
        let found = stamped(step, digit);
        assert!(found.len() == 1 && found[0].contains("with more digits"), "{step} {digit}: {found:?}");
    }
    for (step, digit) in [(2e-4, 1e-4), (1.0 / 5120.0, 1e-5), (1.0 / 2048.0, 1e-6)] {
        assert_eq!(stamped(step, digit), Vec::<String>::new(), "{step} {digit}");
    }
    for size in [0.05, 0.2, 0.4, 0.8] {
        let mut random = fastrand::Rng::with_seed(9);
        let mut jitter = move || size * 2e-4 * (random.f64() - 0.5);
        let mut one = vibration();
        values(&mut one, "time").iter_mut().for_each(|t| *t += jitter());
        let found = check(&oscillator(), &Dataset { title: None, records: vec![one] });
        assert_eq!(found, [], "jitter of {size}");
    }
}

/// Error codes and jumps are no motion: nothing is said of the model's frequencies and sizes by them.
#[test]
fn a_channel_with_a_fault_makes_no_finding_of_scale() {
    let found = said(|one| values(one, "acceleration:m1")[2000..2100].fill(99_999.0));
    assert!(found.len() == 1 && found[0].contains("(100 such samples)"), "{found:?}");
    let found = said(|one| values(one, "acceleration:m1")[2000..].iter_mut().for_each(|a| *a += 135.0));
    assert_eq!(found, Vec::<String>::new());
}

/// A sentence that is true whether the column says m or mm, with one sign at its end.
#[test]
fn findings_of_scale_end_without_a_sign_of_their_own() {
    for (name, factor) in [("force", 1e3), ("force", 1e-3), ("displacement", 1e3), ("displacement", 1e-3)] {
        let mut one = record("r.csv", 0.01, 3);
        values(&mut one, name).iter_mut().for_each(|value| *value *= factor);
        let found = check(&super::model(), &Dataset { title: None, records: vec![one] });
        let said = found[0].to_string();
        assert!(found.len() == 1 && found[0].fault.id() == "scale", "{found:?}");
        assert!(!said.ends_with(['?', '.']) && !said.contains("where the column says"), "{said}");
    }
}

#[test]
fn copies_are_named_whatever_their_unit() {
    for (name, unit, factor) in
        [("velocity:m1", "m/s", 1.0), ("displacement:m1", "m", 1e-3), ("velocity:m1", "m/s", 1e-3)]
    {
        let found = said(|one| {
            let copy = values(one, "acceleration:m1").iter().map(|value| factor * value).collect();
            one.channels.push(channel(name, unit, copy));
        });
        assert!(found.len() == 1 && found[0].contains("has the values of `acceleration:m1`"), "{found:?}");
    }
    // A rigid mass of 0.5 kg needs half the acceleration, and that is physics.
    let found = said(|one| {
        let force = values(one, "acceleration:m1").iter().map(|value| 0.5 * value).collect();
        *values(one, "excitation:m1") = force;
    });
    assert!(!found.iter().any(|one| one.contains("has the values")), "{found:?}");
    assert_eq!(ids(vec![record("a.csv", 0.0, 1)]), Vec::<&str>::new());
}
