//! Records said to begin at rest: those that were moving are named, whatever the excitation does.

use std::f64::consts::TAU;

use super::records::{channel, oscillator};
use super::{record, values};
use crate::data::{Dataset, Record, Regime};
use crate::fit::checks::check;

const RATE: f64 = 5000.0;
const NOISE: f64 = 0.01;

/// What drives the oscillator.
#[derive(Debug, Clone, Copy)]
enum Drive {
    /// A sine (Hz) that begins at once.
    Sine(f64),
    /// A force that is put on at once and stays.
    Step,
    /// Random force up to 300 Hz or so.
    Random,
}

/// The oscillator of the tests, its mass and stiffness changed by factors, from rest for a second, with noise and an offset of parts of each
/// channel's largest value: excitation, displacement, velocity and acceleration.
fn simulated(drive: Drive, seed: u64, factors: [f64; 2], offset: f64) -> [Vec<f64>; 4] {
    let (mass, spring, contact) = (factors[0], 1.9e5 * factors[1], 1.2e5 * factors[1]);
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut u, mut v, mut slider, mut filtered) = (0.0_f64, 0.0_f64, 0.0_f64, [0.0_f64; 2]);
    let mut out = [const { Vec::new() }; 4];
    const FINE: usize = 20;
    let step = 1.0 / RATE / FINE as f64;
    for k in 0..RATE as usize {
        let target = 300.0 * (random.f64() - 0.5);
        for fine in 0..FINE {
            let t = (k * FINE + fine) as f64 * step;
            filtered[0] += step * 1500.0 * (target - filtered[0]);
            filtered[1] += step * 1500.0 * (filtered[0] - filtered[1]);
            let force = match drive {
                Drive::Sine(frequency) => 20.0 * (TAU * frequency * t).sin(),
                Drive::Step => 30.0,
                Drive::Random => filtered[1],
            };
            slider = slider.clamp(u - 12.5 / contact, u + 12.5 / contact);
            let a = (force - spring * u - 6.0 * v - contact * (u - slider)) / mass;
            if fine == 0 {
                [force, u, v, a].into_iter().zip(&mut out).for_each(|(value, list)| list.push(value));
            }
            v += step * a;
            u += step * v;
        }
    }
    for list in &mut out {
        let most = list.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        list.iter_mut().for_each(|value| *value += most * (offset + NOISE * (random.f64() - 0.5)));
    }
    out
}

/// The record of the excitation and one channel (1 displacement, 2 velocity, 3 acceleration), from sample `from` on, said to begin at rest.
fn cut(all: &[Vec<f64>; 4], which: usize, from: usize) -> Record {
    let (name, unit) =
        [("displacement:m1", "m"), ("velocity:m1", "m/s"), ("acceleration:m1", "m/s^2")][which - 1];
    let part = |one: &Vec<f64>| one[from..].to_vec();
    let time = (0..all[0].len() - from).map(|k| k as f64 / RATE).collect();
    let channels = vec![
        channel("time", "s", time),
        channel("excitation:m1", "N", part(&all[0])),
        channel(name, unit, part(&all[which])),
    ];
    Record { name: "r.csv".to_owned(), regime: Regime::FromRest, use_for: None, channels }
}

fn is_named(record: Record) -> bool {
    let found = check(&oscillator(), &Dataset { title: None, records: vec![record] });
    found.iter().any(|one| one.fault.id() == "moving-at-start")
}

const DRIVES: [Drive; 6] =
    [Drive::Sine(30.0), Drive::Sine(70.0), Drive::Sine(88.0), Drive::Sine(150.0), Drive::Step, Drive::Random];

/// Friction, noise, an offset, and a model whose mass and stiffness are half or twice those of the machine.
#[test]
fn structures_from_rest_are_not_named() {
    for drive in DRIVES {
        for factors in [[1.0, 1.0], [0.5, 1.0], [2.0, 1.0], [1.0, 0.5], [1.0, 2.0]] {
            for (seed, offset) in [(1, 0.0), (2, 0.02), (3, -0.05), (4, 0.0)] {
                let all = simulated(drive, seed, factors, offset);
                for which in 1..4 {
                    assert!(!is_named(cut(&all, which, 0)), "{drive:?} {factors:?} {seed} channel {which}");
                }
            }
        }
    }
}

/// Some starts look like a response to the excitation: of all of them two thirds are named.
#[test]
fn structures_that_were_moving_are_named() {
    let (mut tried, mut missed) = (0, Vec::new());
    for drive in [Drive::Sine(70.0), Drive::Sine(88.0), Drive::Random] {
        for seed in 1..4 {
            let all = simulated(drive, seed, [1.0, 1.0], 0.0);
            for which in 1..4 {
                // Over a period and a half in eighths or so.
                for from in (0..12).map(|k| 1500 + 9 * k) {
                    tried += 1;
                    if !is_named(cut(&all, which, from)) {
                        missed.push(format!("{drive:?} {seed} channel {which} from {from}"));
                    }
                }
            }
        }
    }
    println!("{} of {tried} named", tried - missed.len());
    assert!(missed.len() * 3 <= tried, "{} of {tried}: {missed:?}", missed.len());
}

/// A contact at its friction limit where its displacement passes through zero.
#[test]
fn contacts_that_had_slipped_are_named_and_an_offset_is_not() {
    let found = |change: &dyn Fn(&mut Record), seed: u64| {
        let mut one = record("r.csv", 0.005, seed);
        one.regime = Regime::FromRest;
        change(&mut one);
        let found = check(&super::model(), &Dataset { title: None, records: vec![one] });
        found.iter().map(|one| (one.channel.clone().unwrap(), one.fault.id())).collect::<Vec<_>>()
    };
    for seed in 0..6 {
        let moved = found(
            &|one| {
                let u = values(one, "displacement").clone();
                let most = u.iter().fold(0.0_f64, |most, u| most.max(u.abs()));
                let passes = |k: &usize| u[*k] * u[*k + 1] <= 0.0 && u[*k].abs() < 0.05 * most;
                let from = (200..u.len() - 1).find(passes).unwrap();
                one.channels.iter_mut().for_each(|channel| drop(channel.values.drain(..from)));
                values(one, "time").iter_mut().for_each(|t| *t -= from as f64 * super::STEP);
            },
            seed,
        );
        assert_eq!(moved, [("force".to_owned(), "moving-at-start")], "seed {seed}");
        for part in [-0.5, -0.2, 0.1, 0.4] {
            let offset = found(&|one| values(one, "force").iter_mut().for_each(|f| *f += 80.0 * part), seed);
            assert_eq!(offset, [], "offset of {part}");
        }
    }
}
