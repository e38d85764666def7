//! Tables of a stepped sine.
//!
//! Items to verify: amplitude and phase of a linear oscillator are those of the closed form, in any branch of the phase; the
//! contact of an oscillator by the exact flow and of a beam on the virtual rig is recovered; of several responses the measured
//! one is predicted; what bends a resonance comes first among the effects, and is named from sweeps that jump at its folds; of
//! a sensor's faults those are tried that a table can show, and a delay turns the phases.

use std::f64::consts::TAU;

use stickslip::contact::Jenkins;
use stickslip::data::{Channel, ChannelName, Dataset, Record, Regime};
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Verdict, Watch, diagnose, evaluate, refit};
use stickslip::harmonic::fourier;
use stickslip::model::Model;
use stickslip::rig::{Frequencies, Plan, SteppedSine, Test, TestKind, test_on};
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, ShootingSettings, shoot};

/// A table with these columns.
fn table(columns: Vec<(&str, Vec<f64>)>) -> Dataset {
    let channel = |(name, values): (&str, Vec<f64>)| {
        let unit = ChannelName::parse(name).unwrap().quantity.unit;
        Channel { name: name.into(), unit, values, noise: None }
    };
    let channels = columns.into_iter().map(channel).collect();
    let record = Record { name: "sweep.csv".into(), regime: Regime::SteppedSine, use_for: None, channels };
    Dataset { title: None, records: vec![record] }
}

fn oscillator(more: &str) -> Model {
    Model::parse(&format!(
        "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{{ name = \"m1\", mass = 2.0 }}]\n\
         spring = [{{ between = [\"ground\", \"m1\"], stiffness = 2e4, damping = 3.0 }}]\n{more}"
    ))
    .unwrap()
}

const FREQUENCIES: [f64; 9] = [13.0, 14.5, 15.4, 15.8, 16.0, 16.3, 17.0, 18.0, 20.0];

#[test]
fn a_linear_oscillator_has_its_closed_form() {
    for (quantity, order) in [("displacement", 0), ("velocity", 1), ("acceleration", 2)] {
        for turns in [-1.0, 0.0, 1.0] {
            let response = |f: f64| {
                let speed = TAU * f;
                let (real, imaginary) = (2e4 - 2.0 * speed * speed, 3.0 * speed);
                let ahead = f64::from(order) * 0.25 * TAU - imaginary.atan2(real) + turns * TAU;
                (5.0 / real.hypot(imaginary) * speed.powi(order), ahead)
            };
            let (amplitude, phase) = FREQUENCIES.iter().map(|f| response(*f)).unzip();
            let measured = table(vec![
                ("frequency", FREQUENCIES.to_vec()),
                ("excitation:m1", vec![5.0; 9]),
                (&format!("{quantity}:m1"), amplitude),
                ("phase:m1", phase),
            ]);
            let stage = evaluate("", &oscillator(""), &measured);
            assert_eq!(stage.records[0].failure, None);
            assert_eq!(stage.records[0].channels.len(), 2);
            assert!(stage.error < 1e-9, "{quantity}: {}", stage.error);
        }
    }
}

const CONTACT: &str = "contact = { at = \"m1\", law = \"jenkins\", tangential_stiffness = 4e3, friction_coefficient = 0.1, \
                       normal_load = 40.0 }\nfit = { free = [\"contact.*\", \"spring.1.damping\"] }";

/// Amplitude of the acceleration and phase by the exact flow.
fn exact(frequency: f64, force: f64) -> (f64, f64) {
    let (model, law) = (oscillator(CONTACT), Jenkins::new(4e3, 0.1).unwrap());
    let contacts = [LoadedContact { law: &law, normal_load: 40.0 }];
    let mut flow = OscillatorFlow::new(&model.system().unwrap().linear_part(), &contacts).unwrap();
    let excitation = Excitation::cosine(TAU * frequency, force);
    let mut motion = shoot(&mut flow, &excitation, None, &ShootingSettings::default()).unwrap().start;
    let mut samples = Vec::new();
    for _ in 0..512 {
        samples.push(flow.displacement(&motion)[0]);
        flow.advance(&mut motion, 1.0 / frequency / 512.0, &excitation).unwrap();
    }
    let first = fourier::from_samples(&samples, 1, 1);
    let speed = TAU * frequency;
    (first[1].hypot(first[2]) * speed * speed, (-first[2]).atan2(first[1]) + 0.5 * TAU)
}

#[test]
fn the_contact_of_an_oscillator_is_recovered() {
    let (mut columns, frequencies) =
        ([Vec::new(), Vec::new(), Vec::new(), Vec::new()], [15.0, 16.0, 16.6, 17.2, 18.0]);
    for force in [4.0, 10.0, 25.0] {
        for frequency in frequencies {
            let (amplitude, phase) = exact(frequency, force);
            let row = [frequency, force, amplitude, phase];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
    }
    let names = ["frequency", "excitation:m1", "acceleration:m1", "phase:m1"];
    let measured = table(names.into_iter().zip(columns).collect());
    let truth = oscillator(CONTACT);
    println!("at the truth {:.1e}", evaluate("", &truth, &measured).error);
    assert!(evaluate("", &truth, &measured).error < 1e-4);
    let mut start = truth.clone();
    let paths = ["contact.friction_coefficient", "contact.tangential_stiffness", "spring.1.damping"];
    for (path, factor) in paths.into_iter().zip([0.8, 1.15, 1.3]) {
        start.set(path, factor * truth.get(path).unwrap()).unwrap();
    }
    let found = refit("", &start, &measured, Watch::default()).unwrap();
    for path in paths {
        let ratio = found.model.get(path).unwrap() / truth.get(path).unwrap();
        assert!((ratio - 1.0).abs() < 2e-3, "{path}: {ratio}");
    }
}

#[test]
fn the_contact_of_a_beam_on_the_virtual_rig_is_recovered() {
    let text = include_str!("../../examples/frictional-support/published.toml");
    let free = "free = [\"contact.friction_coefficient\", \"beam.damping_ratio\"]";
    let truth = Model::parse(&text.replace("free = []", free)).unwrap();
    let mut plan = Plan::of_sensors(&[0.55, 0.2]);
    let held = SteppedSine {
        frequencies: Frequencies::List(vec![50.0, 51.5, 53.0, 54.5]),
        ..SteppedSine::at(vec![5.0, 20.0, 45.0])
    };
    plan.tests.push(Test { name: "held".into(), use_for: None, kind: TestKind::SteppedSine(held) });
    let names = ["frequency", "excitation", "acceleration:x=0.55", "acceleration:x=0.2", "phase:x=0.55"];
    let mut columns = vec![Vec::new(); names.len()];
    for record in test_on(&truth, &plan, &mut |_| true).unwrap() {
        let values = |name: &str| &record.channel(name).unwrap().values;
        let periods = stickslip::harmonic::whole_periods(values("excitation")).unwrap();
        let first = |name: &str| {
            let found = fourier::from_samples(values(name), periods, 1);
            (found[1].hypot(found[2]), (-found[2]).atan2(found[1]))
        };
        let time = values("time");
        let step = time[1] - time[0];
        columns[0].push(periods as f64 / (step * time.len() as f64));
        columns[1].push(first(names[1]).0);
        columns[2].push(first(names[2]).0);
        columns[3].push(first(names[3]).0);
        columns[4].push(first(names[2]).1 - first(names[1]).1);
    }
    let measured = table(names.into_iter().zip(columns).collect());
    let stage = evaluate("", &truth, &measured);
    println!("{:?}", stage.records[0].failure);
    println!("at the truth {:.1e}", stage.error);
    assert!(stage.error < 2e-3, "{}", stage.error);
    let mut start = truth.clone();
    let paths = ["contact.friction_coefficient", "beam.damping_ratio"];
    start.set(paths[0], 0.85 * truth.get(paths[0]).unwrap()).unwrap();
    start.set(paths[1], 1.3 * truth.get(paths[1]).unwrap()).unwrap();
    let found = refit("", &start, &measured, Watch::default()).unwrap();
    for path in paths {
        let ratio = found.model.get(path).unwrap() / truth.get(path).unwrap();
        assert!((ratio - 1.0).abs() < 0.01, "{path}: {ratio}");
    }
}

/// Rows of an oscillator with a cubic spring by its first harmonic alone, at held amplitudes (m): one force and phase each.
fn held(cubic: f64, amplitudes: &[f64], frequencies: &[f64]) -> Dataset {
    let mut random = fastrand::Rng::with_seed(8);
    let mut columns = vec![Vec::new(); 4];
    for amplitude in amplitudes {
        for frequency in frequencies {
            let speed = TAU * frequency;
            let stiffness = 2e4 + 0.75 * cubic * amplitude * amplitude;
            let (real, imaginary) = (stiffness - 2.0 * speed * speed, 3.0 * speed);
            let mut noise = || 0.01 * (random.f64() - 0.5);
            let row = [
                *frequency,
                amplitude * real.hypot(imaginary),
                amplitude * (1.0 + noise()),
                noise() - imaginary.atan2(real),
            ];
            columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
    }
    let names = ["frequency", "excitation:m1", "displacement:m1", "phase:m1"];
    let mut table = table(names.into_iter().zip(columns).collect());
    let square = amplitudes.iter().map(|a| a * a).sum::<f64>() / amplitudes.len() as f64;
    for (channel, noise) in table.records[0].channels[2..].iter_mut().zip([3e-3 * square.sqrt(), 3e-3]) {
        channel.noise = Some(noise);
    }
    table
}

fn stiffening(cubic: f64) -> Model {
    oscillator(&format!("effect = [{{ id = \"geometric_stiffening\", cubic_stiffness = {cubic} }}]"))
}

#[test]
fn of_several_responses_the_measured_one_is_predicted() {
    let measured = held(1e7, &[2e-3, 5e-3, 8e-3], &[15.0, 15.6, 16.8, 17.4, 18.0]);
    let stage = evaluate("", &stiffening(1e7), &measured);
    println!("at the truth {:.1e}", stage.error);
    assert!(stage.error < 0.03, "{}: {:?}", stage.error, stage.records[0].channels);
}

#[test]
fn what_bends_a_resonance_comes_first() {
    let measured = held(1e7, &[1e-3, 2e-3, 3e-3], &[15.0, 15.6, 15.8, 15.95, 16.2, 16.8, 18.0]);
    println!("at the truth {:.1e}", evaluate("", &stiffening(1e7), &measured).error);
    let effects = Some(vec!["geometric_stiffening".into(), "quadratic_damping".into(), "added_mass".into()]);
    let options = DiagnoseOptions { effects, ..DiagnoseOptions::default() };
    let told = diagnose(&oscillator(""), &measured, &options, DiagnoseWatch::default()).unwrap();
    assert_eq!((told.verdict, &told.effects[..]), (Verdict::EffectFound, &["geometric_stiffening"][..]));
    for one in &told.candidates {
        println!("{:?} {} {}", one.effects, one.error, one.gain_z);
    }
    let first = &told.candidates[0];
    assert_eq!(first.effects, ["geometric_stiffening"]);
    assert!(first.error < 0.01 && first.gain_z > 5.0, "{first:?}");
}

/// Amplitudes (m) of an oscillator with a cubic spring under a force (N), by its first harmonic alone: one, or three.
fn amplitudes(cubic: f64, force: f64, frequency: f64) -> Vec<f64> {
    let speed = TAU * frequency;
    let rest = |a: f64| {
        let real = 2e4 + 0.75 * cubic * a * a - 2.0 * speed * speed;
        (real * real + 9.0 * speed * speed).sqrt() * a - force
    };
    let grid: Vec<f64> = (0..=4000).map(|k| 1e-5 * f64::from(k)).collect();
    let crossed = |pair: &&[f64]| rest(pair[0]) * rest(pair[1]) <= 0.0;
    let root = |pair: &[f64]| {
        let (mut low, mut high) = (pair[0], pair[1]);
        for _ in 0..50 {
            let middle = 0.5 * (low + high);
            if rest(low) * rest(middle) <= 0.0 { high = middle } else { low = middle }
        }
        0.5 * (low + high)
    };
    grid.windows(2).filter(crossed).map(root).collect()
}

/// Sweeps up and down at constant forces: where there are three responses the measured is that of the way, and at a fold it jumps.
fn swept(cubic: f64, forces: &[f64]) -> Dataset {
    let mut random = fastrand::Rng::with_seed(9);
    let mut noise = || 0.01 * 3.46 * (random.f64() - 0.5);
    let up: Vec<f64> = (0..=24).map(|k| 15.0 + 0.1 * f64::from(k)).collect();
    let down: Vec<f64> = up.iter().rev().copied().collect();
    let mut records = Vec::new();
    for force in forces {
        for (way, frequencies) in [("up", &up), ("down", &down)] {
            let at = |frequency: &f64| {
                let all = amplitudes(cubic, *force, *frequency);
                if way == "up" { all[all.len() - 1] } else { all[0] }
            };
            let exact: Vec<f64> = frequencies.iter().map(at).collect();
            let shown = exact.iter().map(|a| a * (1.0 + noise())).collect();
            let columns = [
                ("frequency", frequencies.clone()),
                ("excitation:m1", vec![*force; exact.len()]),
                ("displacement:m1", shown),
            ];
            let record = table(columns.into()).records.remove(0);
            records.push(Record { name: format!("{way}-{force}.csv"), ..record });
        }
    }
    Dataset { title: None, records }
}

/// Of a model that is still without the effect there is but one response where three were measured.
#[test]
fn what_bends_a_resonance_over_is_named_from_sweeps_that_jump() {
    let (cubic, forces) = (1e7, [3.0, 5.0]);
    assert_eq!(amplitudes(cubic, 5.0, 16.5).len(), 3);
    let measured = swept(cubic, &forces);
    let stage = evaluate("", &stiffening(cubic), &measured);
    assert!(
        stage.records.iter().all(|record| record.failure.is_none()) && stage.error < 0.05,
        "{}",
        stage.error
    );
    let options = DiagnoseOptions::default();
    let told = diagnose(&oscillator(""), &measured, &options, DiagnoseWatch::default()).unwrap();
    assert_eq!((told.verdict, &told.effects[..]), (Verdict::EffectFound, &["geometric_stiffening"][..]));
    let found = told.model.get("effect.1.cubic_stiffness").unwrap();
    assert!((found / cubic - 1.0).abs() < 0.05, "{found}");
}

#[test]
fn of_a_sensors_faults_a_table_shows_gains_of_amplitudes_and_delays_of_phases() {
    let delay = 1.5e-3;
    let mut measured = held(0.0, &[2e-3, 3e-3], &[13.0, 14.5, 15.4, 15.8, 16.0, 16.3, 17.0, 18.0, 20.0]);
    let turns: Vec<f64> = measured.records[0].channels[0].values.iter().map(|f| TAU * f * delay).collect();
    measured.records[0].channels[3].values.iter_mut().zip(turns).for_each(|(phase, turn)| *phase -= turn);
    let faults = ["sensor_delay", "sensor_gain", "sensor_offset", "sensor_clock_drift"];
    let options =
        DiagnoseOptions { effects: Some(faults.map(Into::into).into()), ..DiagnoseOptions::default() };
    for copies in [1, 4] {
        let table = &measured.records[0];
        let rows = |k: usize| {
            let values = |all: &[f64]| all.iter().skip(k).step_by(copies).copied().collect();
            let channel = |one: &Channel| Channel { values: values(&one.values), ..one.clone() };
            let channels = table.channels.iter().map(channel).collect();
            Record { name: format!("{k}.csv"), channels, ..table.clone() }
        };
        let tables = Dataset { title: None, records: (0..copies).map(rows).collect() };
        let told = diagnose(&oscillator(""), &tables, &options, DiagnoseWatch::default()).unwrap();
        println!("{:?} {:?} {:?}", told.verdict, told.effects, told.reasons);
        let mut tried: Vec<String> = told
            .candidates
            .iter()
            .map(|one| format!("{}@{}", one.effects[0], one.location.as_deref().unwrap_or_default()))
            .collect();
        tried.sort();
        assert_eq!(tried, ["sensor_delay@phase:m1", "sensor_gain@displacement:m1"]);
        let untried = |id| told.untried.iter().any(|one| one.effect == id);
        assert!(untried("sensor_offset") && untried("sensor_clock_drift") && !untried("sensor_delay"));
        assert_eq!((told.verdict, &told.effects[..]), (Verdict::EffectFound, &["sensor_delay"][..]));
        let found = told.model.get("effect.1.delay").unwrap();
        assert!((found / delay - 1.0).abs() < 0.02, "{found}");
    }
}
