//! Stepped sines.

use std::f64::consts::TAU;

use stickslip::contact::Inputs;
use stickslip::data::{Dataset, Record, Regime};
use stickslip::fit::compare::evaluate;
use stickslip::identify::harmonics;
use stickslip::model::{Beam, Model, Structure};
use stickslip::rig::{
    Accelerometer, Frequencies, Plan, RandomTest, SteppedSine, TestKind, test_on, test_with_truth_on,
};
use stickslip::time::{Integrator, Ramp, Settings};

use crate::{SENSORS, accelerations, published, record_of, rms, test};

const AT_SHAKER: &str = "acceleration:x=0.55";

/// Frequency (Hz) of a steady record of `periods` periods.
fn frequency(record: &Record, periods: usize) -> f64 {
    periods as f64 / (record.sample_step().unwrap() * record.len() as f64)
}

fn first_harmonic(record: &Record, name: &str, frequency: f64) -> (f64, f64) {
    let values = &record.channel(name).unwrap().values;
    let found = harmonics(record.time().unwrap(), values, frequency, 30).unwrap().coefficients;
    (found[1], found[2])
}

#[test]
fn the_sensor_at_the_shaker_shows_the_amplitude_that_is_held() {
    let model = published(6, |text| text);
    let mut plan = Plan::of_sensors(&SENSORS);
    plan.sensors[1].mass = 0.01;
    let amplitudes = vec![0.5, 20.0, 70.0];
    let around = Frequencies::AroundResonance { band: 1.0, count: 3 };
    let given = Frequencies::List(vec![48.0, 60.0]);
    for frequencies in [Frequencies::Resonance, around, given] {
        let sine = SteppedSine { frequencies, ..SteppedSine::at(amplitudes.clone()) };
        plan.tests.push(test(&format!("t{}", plan.tests.len()), TestKind::SteppedSine(sine)));
    }
    let records = test_on(&model, &plan, &mut |_| true).unwrap();
    assert_eq!(records.len(), 3 + 9 + 6);
    let levels = [1, 3, 2].into_iter().flat_map(|count| {
        amplitudes.iter().flat_map(move |amplitude| std::iter::repeat_n(*amplitude, count))
    });
    for (record, level) in records.iter().zip(levels) {
        assert_eq!((record.regime, record.len()), (Regime::Steady, 8 * 256));
        let (c, s) = first_harmonic(record, AT_SHAKER, frequency(record, 8));
        assert!((c.hypot(s) / level - 1.0).abs() < 1e-6, "{}: {}", record.name, c.hypot(s));
    }
    let band = frequency(&records[5], 8) - frequency(&records[3], 8);
    assert!((band - 1.0).abs() < 1e-9, "{band}");
    assert!((frequency(&records[12], 8) - 48.0).abs() < 1e-9);
}

#[test]
fn at_resonance_the_force_is_in_phase_with_the_velocity() {
    let record = record_of(&published(6, |text| text), TestKind::SteppedSine(SteppedSine::at(vec![40.0])));
    let at = frequency(&record, 8);
    let ((fc, fs), (ac, a_s)) =
        (first_harmonic(&record, "excitation", at), first_harmonic(&record, AT_SHAKER, at));
    // The acceleration is a quarter period ahead of the velocity.
    let aligned = (fc * ac + fs * a_s) / fc.hypot(fs) / ac.hypot(a_s);
    assert!(aligned.abs() < 1e-6, "{aligned}");
}

/// From rest, driven by the force of the record for as long as the beam's own motion lasts.
fn settled(model: &Model, record: &Record, frequency: f64) -> Vec<Vec<f64>> {
    let Structure::Beam(beam) = &model.structure else { panic!("a beam") };
    let seen = Structure::Beam(Beam { sensors: SENSORS.to_vec(), ..beam.clone() });
    let system = Model { structure: seen, ..model.clone() }.system().unwrap();
    let mut integrator = Integrator::new(&system).unwrap();
    let mut inputs = integrator.held_inputs();
    let mut motion = integrator.rest(&inputs).unwrap();
    let (step, per_period) = (record.sample_step().unwrap(), 256);
    let (c, s) = first_harmonic(record, "excitation", frequency);
    let force = |samples: f64| {
        let phase = TAU * frequency * step * samples;
        c * phase.cos() + s * phase.sin()
    };
    let (mut outputs, mut shown) = (Default::default(), vec![Vec::new(); SENSORS.len()]);
    let periods = 200;
    for k in 0..periods * per_period {
        let at = f64::from(k);
        let ends = [force(at), force(at + 0.5), force(at + 1.0)];
        inputs[0] =
            Ramp { start: ends[0], end: ends[2], bow: 4.0 * ends[1] - 2.0 * (ends[0] + ends[2]), skew: 0.0 };
        if k >= (periods - 1) * per_period {
            integrator.outputs(&motion, step, &inputs, &mut outputs).unwrap();
            let readings = shown.iter_mut().zip(&outputs.sensors);
            readings.for_each(|(shown, reading)| shown.push(reading.acceleration));
        }
        integrator.advance(&mut motion, step, &inputs, &Settings::default()).unwrap();
    }
    shown
}

#[test]
fn a_run_in_time_under_the_force_of_the_record_settles_to_the_record() {
    let model = published(8, |text| text);
    for level in [20.0, 40.0, 70.0] {
        let record = record_of(&model, TestKind::SteppedSine(SteppedSine::at(vec![level])));
        let settled = settled(&model, &record, frequency(&record, 8));
        for (balanced, marched) in accelerations(&record).into_iter().zip(&settled) {
            let off = rms(marched.iter().zip(balanced).map(|(m, b)| m - b)) / rms(balanced.iter().copied());
            assert!(off < 0.01, "{level}: {off}");
        }
    }
}

#[test]
fn a_sensor_has_mass() {
    let model = published(6, |text| text);
    let resonance = |mass: f64| {
        let mut plan = Plan::of_sensors(&SENSORS);
        plan.sensors[1] = Accelerometer { position: 0.3, mass };
        plan.tests.push(test("held", TestKind::SteppedSine(SteppedSine::at(vec![20.0]))));
        frequency(&test_on(&model, &plan, &mut |_| true).unwrap()[0], 8)
    };
    let listed =
        published(6, |text| text.replace("position = 0.3\nmass = 0.005", "position = 0.3\nmass = 0.025"));
    let sine = TestKind::SteppedSine(SteppedSine::at(vec![20.0]));
    let expected = frequency(&record_of(&listed, sine), 8);
    assert!((resonance(0.02) / expected - 1.0).abs() < 1e-9);
    assert!(resonance(0.0) > expected + 0.2);
}

/// Sensors may be lighter than the model says, but not lighter than nothing.
#[test]
fn a_sensor_may_lack_mass_that_the_model_has() {
    let tested = |mass: f64| {
        let mut plan = Plan::of_sensors(&SENSORS);
        plan.sensors[1].mass = mass;
        plan.tests.push(test("held", TestKind::SteppedSine(SteppedSine::at(vec![20.0]))));
        test_on(&published(6, |text| text), &plan, &mut |_| true)
    };
    let lighter =
        published(6, |text| text.replace("position = 0.3\nmass = 0.005", "position = 0.3\nmass = 0.003"));
    let sine = TestKind::SteppedSine(SteppedSine::at(vec![20.0]));
    let expected = frequency(&record_of(&lighter, sine), 8);
    assert!((frequency(&tested(-0.002).unwrap()[0], 8) / expected - 1.0).abs() < 1e-9);
    let refused = tested(-0.006).unwrap_err().to_string();
    assert!(refused.contains("mass") && refused.contains("-0.001"), "{refused}");
}

/// The law alone, moved as the rig says its contact moves, has the force that the rig says.
#[test]
fn the_truth_beside_a_record_is_what_the_law_does() {
    let model = published(4, |text| text);
    let mut plan = Plan::of_sensors(&SENSORS);
    let steady = SteppedSine { samples_per_period: 1024, ..SteppedSine::at(vec![50.0]) };
    let random =
        RandomTest { force: 2.0, band: [20.0, 200.0], duration: 0.3, sampling: 2e4, lead: 0.0, seed: 1 };
    plan.tests
        .extend([test("steady", TestKind::SteppedSine(steady)), test("random", TestKind::Random(random))]);
    for tested in test_with_truth_on(&model, &plan, &mut |_| true).unwrap() {
        let truth = tested.contact.unwrap();
        let column = |name: &str| truth.channel(name).unwrap().values.as_slice();
        let (law, load) = (model.law().unwrap().unwrap(), 147.15);
        let mut state = vec![0.0; law.state_len()];
        law.set_state(0.0, load, 0.0, &mut state);
        let forces: Vec<f64> = column("displacement")
            .iter()
            .map(|u| law.advance(&mut state, Inputs { displacement: *u, velocity: 0.0, normal_load: load }))
            .collect();
        // The memory of a steady state is there after a period.
        let settled = if tested.record.name == "steady.csv" { 1024 } else { 0 };
        let off = rms(forces.iter().zip(column("force")).skip(settled).map(|(a, b)| a - b));
        assert!(off < 5e-3 * rms(column("force").iter().copied()), "{}: {off}", truth.name);
        let step = column("time")[1];
        let speeds = column("displacement").windows(3).map(|u| (u[2] - u[0]) / (2.0 * step));
        let off = rms(speeds.zip(&column("velocity")[1..]).map(|(a, b)| a - b));
        assert!(off < 5e-3 * rms(column("velocity").iter().copied()), "{}: {off}", truth.name);
    }
}

/// A table that ends where the contact has moved by 14.7 µm: of the two levels the larger goes beyond.
#[test]
fn a_comparison_names_the_record_that_leaves_the_table_of_a_measured_law() {
    let kept: String = (1..12).map(|k| format!("slope_kept_{k} = 1.0\n")).collect();
    let model = published(4, |text| {
        let (beam, _) = text.split_once("[contact]").unwrap();
        format!(
            "{beam}[contact]\nlaw = \"measured\"\ntangential_stiffness = 7.0e6\nfriction_coefficient = 0.7\n\
             normal_load = 147.15\n{kept}"
        )
    });
    let mut plan = Plan::of_sensors(&SENSORS);
    plan.tests.push(test("level", TestKind::SteppedSine(SteppedSine::at(vec![5.0, 70.0]))));
    let tested = test_with_truth_on(&model, &plan, &mut |_| true).unwrap();
    let records: Vec<Record> = tested.iter().map(|tested| tested.record.clone()).collect();
    let truth = &tested[1].contact.as_ref().unwrap().channel("displacement").unwrap().values;
    let ends = truth.iter().fold([f64::MAX, f64::MIN], |[low, high], u| [low.min(*u), high.max(*u)]);
    let stage = evaluate("", &model, &Dataset { title: None, records });
    let [note] = &stage.notes[..] else { panic!("{:?}", stage.notes) };
    assert!(note.starts_with("in level-2") && note.contains("ends at 14.715 µm"), "{note}");
    let (_, told) = note.split_once("± ").unwrap();
    let told: f64 = told.split_once(" µm").unwrap().0.parse().unwrap();
    assert!((told / (0.5e6 * (ends[1] - ends[0])) - 1.0).abs() < 0.01, "{note}: {ends:?}");
}
