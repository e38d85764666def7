//! The rig that slips and slaps as a co-simulation slave.

use std::f64::consts::TAU;

use stickslip::fmi::{Causality, Instance, Setup};
use stickslip::model::Model;
use stickslip::time::{ClassicalSteps, Energies};

const MODEL: &str = include_str!("../../examples/slip-slap/model.toml");
const FREQUENCY: f64 = 52.0;

fn running(tolerance: f64) -> Instance {
    let mut instance = Instance::new(MODEL).unwrap();
    instance.set_up(Setup { tolerance: Some(tolerance), ..Setup::default() }).unwrap();
    instance.enter_initialization().unwrap();
    instance.exit_initialization().unwrap();
    instance
}

fn read(instance: &mut Instance, name: &str) -> f64 {
    let reference = instance.description().reference(name).unwrap();
    let mut value = [0.0];
    instance.get_real(&[reference], &mut value).unwrap();
    value[0]
}

/// The dual sine of the reference values (N).
fn force(time: f64) -> f64 {
    let phase = TAU * FREQUENCY * time;
    1.85 * phase.sin() + 6.2 * (3.0 * phase).sin()
}

/// Goes to the end of step `k` under the dual sine, which begins within the step.
fn step(instance: &mut Instance, k: usize, step: f64) {
    let excitation = instance.description().reference("excitation").unwrap();
    instance.set_real(&[excitation], &[force((k + 1) as f64 * step)]).unwrap();
    instance.do_step(k as f64 * step, step).unwrap();
}

fn outputs(instance: &mut Instance) -> Vec<f64> {
    let description = instance.description();
    let real = |row: &u32| description.variables[*row as usize].name != "slip_state";
    let rows: Vec<u32> = description.references(Causality::Output).filter(real).collect();
    let mut values = vec![0.0; rows.len()];
    instance.get_real(&rows, &mut values).unwrap();
    values
}

/// What must hold of a name over a period: half of its range or an end of it, a factor of unit, value and tolerance.
type Reference = (&'static str, fn(f64, f64) -> f64, f64, f64, f64);

#[test]
fn a_run_from_rest_reaches_the_steady_state_of_harmonic_balance() {
    const PER_PERIOD: usize = 400;
    const PERIODS: usize = 150;
    let mut instance = running(1e-6);
    let duration = 1.0 / FREQUENCY / PER_PERIOD as f64;
    let half = |low: f64, high: f64| 0.5 * (high - low);
    let references: [Reference; 6] = [
        ("force", |low, _| low, 1.0, -31.5, 1.0),
        ("force", |_, high| high, 1.0, 53.0, 1.0),
        ("opening_force", half, 1.0, 24.3, 0.5),
        ("displacement", half, 1e6, 18.9, 0.2),
        ("opening", half, 1e6, 1.03, 0.03),
        ("normal_force", |low, _| low, 1.0, 44.0, 1.0),
    ];
    for k in 0..(PERIODS - 1) * PER_PERIOD {
        step(&mut instance, k, duration);
    }
    let mut ranges = [[f64::INFINITY, f64::NEG_INFINITY]; 6];
    let mut sums = [0.0; 4];
    for k in (PERIODS - 1) * PER_PERIOD..PERIODS * PER_PERIOD {
        step(&mut instance, k, duration);
        for (range, (name, ..)) in ranges.iter_mut().zip(&references) {
            let value = read(&mut instance, name);
            *range = [range[0].min(value), range[1].max(value)];
        }
        let acceleration = read(&mut instance, "acceleration:x=0.55");
        for (order, pair) in [1.0, 3.0].into_iter().zip(sums.chunks_exact_mut(2)) {
            let phase = order * TAU * (k + 1) as f64 / PER_PERIOD as f64;
            pair[0] += acceleration * phase.cos() * 2.0 / PER_PERIOD as f64;
            pair[1] += acceleration * phase.sin() * 2.0 / PER_PERIOD as f64;
        }
        assert_eq!(read(&mut instance, "separation"), 0.0);
    }
    for ([low, high], (name, of, unit, value, tolerance)) in ranges.into_iter().zip(references) {
        let found = unit * of(low, high);
        assert!((found - value).abs() <= tolerance, "{name} is {found}, not {value} ± {tolerance}");
    }
    let [a1, a3] = [sums[0].hypot(sums[1]), sums[2].hypot(sums[3])];
    assert!((a1 - 20.0).abs() <= 0.2 && (a3 - 50.0).abs() <= 0.2, "{a1} and {a3} m/s²");
}

#[test]
fn a_slave_is_the_native_scheme_under_a_force_that_runs_linearly() {
    let mut instance = running(1e-6);
    let system = Model::parse(MODEL).unwrap().system().unwrap();
    let mut steps = ClassicalSteps::new(&system).unwrap();
    let mut motion = steps.rest();
    let duration = 1e-4;
    let count = (duration / steps.longest_step()).ceil() as usize;
    for k in 0..60 {
        step(&mut instance, k, duration);
        let [from, to] = [k, k + 1].map(|k| force(k as f64 * duration));
        for i in 0..count {
            let at = |part: f64| from + (to - from) * (i as f64 + part) / count as f64;
            steps.advance(&mut motion, duration / count as f64, [at(0.0), at(0.5), at(1.0)]);
        }
        let contact = &motion.contacts[0];
        let near = |found: f64, value: f64| (found - value).abs() <= 1e-9 * value.abs().max(1e-6);
        assert!(near(read(&mut instance, "force"), contact.force[0]));
        assert!(near(read(&mut instance, "normal_force"), contact.normal_force));
        assert!(near(read(&mut instance, "opening"), contact.displacement[1]));
    }
    let friction = read(&mut instance, "dissipated_energy");
    assert!(friction > 0.0 && (friction / motion.energies.friction - 1.0).abs() < 1e-9);
    // What the exciter did is in the motion, in the contact's springs, or dissipated: no more is than it did.
    let Energies { work, viscous, friction, impact } = motion.energies;
    assert!(viscous + friction + impact < work);
}

#[test]
fn steps_within_a_step_converge_with_order_two() {
    let run = |tolerance: f64| {
        let mut instance = running(tolerance);
        (0..100).for_each(|k| step(&mut instance, k, 1e-4));
        ["force", "opening_force", "velocity:x=0.55"].map(|name| read(&mut instance, name))
    };
    let [coarse, middle, fine] = [1e-6, 1e-6 / 16.0, 1e-6 / 1024.0].map(run);
    for ((coarse, middle), fine) in coarse.into_iter().zip(middle).zip(fine) {
        let (far, near) = ((coarse - fine).abs(), (middle - fine).abs());
        // A quarter of the step: a sixteenth of the error.
        assert!(near < far / 8.0 || far < 1e-9 * fine.abs(), "{coarse} {middle} {fine}");
        assert!(far < 1e-3 * fine.abs(), "{coarse} {fine}");
    }
}

#[test]
fn a_saved_state_goes_on_bit_by_bit() {
    let mut instance = running(1e-6);
    (0..50).for_each(|k| step(&mut instance, k, 1e-4));
    let saved = instance.snapshot();
    (50..60).for_each(|k| step(&mut instance, k, 1e-4));
    let first = outputs(&mut instance);
    instance.restore(&saved).unwrap();
    (50..60).for_each(|k| step(&mut instance, k, 1e-4));
    assert_eq!(bits(&outputs(&mut instance)), bits(&first));
    let mut other = running(1e-6);
    other.restore(&saved).unwrap();
    (50..60).for_each(|k| step(&mut other, k, 1e-4));
    assert_eq!(bits(&outputs(&mut other)), bits(&first));
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|value| value.to_bits()).collect()
}

#[test]
fn a_step_that_is_far_too_long_is_refused_and_leaves_the_slave_as_it_was() {
    let mut instance = running(1e-6);
    step(&mut instance, 0, 1e-4);
    let before = outputs(&mut instance);
    let error = instance.do_step(1e-4, 1e4).unwrap_err();
    assert!(error.to_string().contains("too long"), "{error}");
    assert_eq!(outputs(&mut instance), before);
}

#[test]
fn parameters_of_pin_string_and_contact_act() {
    let lowest = |name: &str, value: f64| {
        let mut instance = Instance::new(MODEL).unwrap();
        let reference = instance.description().reference(name).unwrap();
        instance.set_real(&[reference], &[value]).unwrap();
        instance.set_up(Setup::default()).unwrap();
        instance.enter_initialization().unwrap();
        instance.exit_initialization().unwrap();
        (0..30).for_each(|k| step(&mut instance, k, 1e-4));
        read(&mut instance, "normal_force")
    };
    let values = [
        lowest("pin.mass", 0.0355),
        lowest("pin.mass", 0.05),
        lowest("string.mass", 5.0),
        lowest("pin.normal_lever", 0.003),
        lowest("normal_load", 40.0),
    ];
    for (place, value) in values.iter().enumerate() {
        assert!(values[..place].iter().all(|other| (other - value).abs() > 1e-6), "{values:?}");
    }
}

const SHOWN: [&str; 5] = ["force", "opening_force", "displacement", "velocity:x=0.55", "acceleration:x=0.55"];

fn references(instance: &Instance) -> [u32; 5] {
    SHOWN.map(|name| instance.description().reference(name).unwrap())
}

#[test]
fn directional_derivatives_are_what_repeating_the_step_shows() {
    let mut instance = running(1e-6);
    (0..50).for_each(|k| step(&mut instance, k, 1e-4));
    let saved = instance.snapshot();
    let (rows, excitation) = (references(&instance), instance.description().reference("excitation").unwrap());
    let mut repeated = |more: f64| {
        instance.restore(&saved).unwrap();
        instance.set_real(&[excitation], &[force(51.0 * 1e-4) + more]).unwrap();
        instance.do_step(50.0 * 1e-4, 1e-4).unwrap();
        SHOWN.map(|name| read(&mut instance, name))
    };
    let span = 2e-3;
    let (up, down) = (repeated(span), repeated(-span));
    repeated(0.0);
    let mut change = [0.0; 5];
    instance.directional_derivative(&rows, &[excitation], &[3.0], &mut change).unwrap();
    for (((name, up), down), change) in SHOWN.iter().zip(up).zip(down).zip(change) {
        let differenced = 3.0 * (up - down) / (2.0 * span);
        assert!((change - differenced).abs() <= 1e-3 * differenced.abs(), "{name}: {change} {differenced}");
        assert!(change != 0.0, "{name}");
    }
}

#[test]
fn output_derivatives_are_what_a_short_step_further_shows() {
    let mut instance = running(1e-6);
    (0..50).for_each(|k| step(&mut instance, k, 1e-4));
    let (rows, excitation) = (references(&instance), instance.description().reference("excitation").unwrap());
    let (mut before, mut rates) = ([0.0; 5], [0.0; 5]);
    instance.output_derivatives(&rows, &[1; 5], &mut rates).unwrap();
    instance.get_real(&rows, &mut before).unwrap();
    let (last, time) = (force(50.0 * 1e-4), 50.0 * 1e-4);
    let slope = (last - force(49.0 * 1e-4)) / 1e-4;
    let ahead = 2e-8;
    instance.set_real(&[excitation], &[last + slope * ahead]).unwrap();
    instance.do_step(time, ahead).unwrap();
    for (((name, row), before), rate) in SHOWN.iter().zip(rows).zip(before).zip(rates) {
        let mut after = [0.0];
        instance.get_real(&[row], &mut after).unwrap();
        let differenced = (after[0] - before) / ahead;
        assert!((rate - differenced).abs() <= 1e-2 * differenced.abs(), "{name}: {rate} {differenced}");
    }
}
