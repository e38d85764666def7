//! Random excitation.

use std::f64::consts::TAU;

use stickslip::data::{Dataset, Record, Regime};
use stickslip::diagnose::evaluate;
use stickslip::identify::{frequency_response_of, poles};
use stickslip::model::{Beam, Model, Structure};
use stickslip::rig::{Chain, ChannelFault, NoiseLevel, Plan, RandomTest, TestKind, test_on};
use stickslip::system::ModalBeam;

use crate::{accelerations, published, record_of, rms, test};

const TEST: RandomTest =
    RandomTest { force: 0.05, band: [5.0, 450.0], duration: 30.0, sampling: 2048.0, lead: 0.0, seed: 3 };

/// Natural frequencies (Hz) with the contact stuck: its stiffness in series with the beam's is a rotational spring.
fn stuck(model: &Model) -> Vec<f64> {
    let Structure::Beam(beam) = &model.structure else { panic!("a beam") };
    let series = beam.length / (beam.youngs_modulus * beam.width * beam.thickness);
    let stiffness = 1.0 / (1.0 / model.get("contact.tangential_stiffness").unwrap() + series);
    let rotational_stiffness = stiffness * beam.offset * beam.offset;
    let modes = ModalBeam::new(&Beam { rotational_stiffness, ..beam.clone() }).unwrap();
    modes.angular_frequency.iter().map(|omega| omega / TAU).collect()
}

#[test]
fn the_frequency_responses_have_the_modes_of_the_beam_on_the_stuck_contact() {
    // With the correction few modes have the frequencies of all.
    let model = published(8, |text| text.replace("modes = 8", "modes = 8\nstatic_correction = true"));
    let record = record_of(&model, TestKind::Random(TEST));
    assert_eq!((record.regime, record.len()), (Regime::FromRest, 30 * 2048));
    let force = &record.channel("excitation").unwrap().values;
    let responses: Vec<_> = accelerations(&record)
        .into_iter()
        .map(|a| frequency_response_of(force, a, TEST.sampling, 8192).unwrap())
        .collect();
    let found = poles(&responses, [20.0, 400.0], 24).unwrap();
    for expected in &stuck(&model)[..3] {
        let nearest =
            found.iter().map(|pole| (pole.frequency / expected - 1.0).abs()).fold(f64::MAX, f64::min);
        assert!(nearest < 1e-3, "{expected} Hz: {nearest:e} of {found:?}");
    }
}

#[test]
fn a_record_begins_at_rest_or_in_the_middle_of_a_motion() {
    let model = published(4, |text| text);
    let short = RandomTest { duration: 2.0, band: [20.0, 450.0], ..TEST };
    let after = |lead: f64| record_of(&model, TestKind::Random(RandomTest { lead, ..short.clone() }));
    let (rest, going, later) = (after(0.0), after(6.0), after(8.0));
    assert_eq!((rest.regime, going.regime), (Regime::FromRest, Regime::UnknownInitialState));
    // The same force: it repeats after its duration.
    let force = |record: &Record| record.channel("excitation").unwrap().values.clone();
    assert!(force(&rest).iter().zip(&force(&going)).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!((rms(force(&rest).into_iter()) / TEST.force - 1.0).abs() < 1e-9);
    // The beam's own motion from the beginning has gone.
    let apart = |one: &Record, other: &Record| {
        let (one, other) = (accelerations(one)[1], accelerations(other)[1]);
        rms(one.iter().zip(other).map(|(a, b)| a - b)) / rms(one.iter().copied())
    };
    assert!(apart(&going, &rest) > 0.1, "{}", apart(&going, &rest));
    assert!(apart(&going, &later) < 0.01, "{}", apart(&going, &later));
}

/// The error that the model that made a record has on it, without noise and over that of noise alone.
#[test]
fn a_random_record_compares_at_its_noise_floor() {
    let model = published(4, |text| text);
    let dataset = |noise: f64| {
        let noisy = ChannelFault { noise: NoiseLevel::Fraction(noise), ..ChannelFault::default() };
        let mut plan = Plan::of_sensors(&crate::SENSORS);
        plan.chain = Chain { accelerometers: vec![noisy; 3], seed: 5, ..Chain::default() };
        let random = RandomTest { force: 2.0, duration: 2.0, ..TEST };
        plan.tests.push(test("random", TestKind::Random(random)));
        Dataset { title: None, records: test_on(&model, &plan, &mut |_| true).unwrap() }
    };
    let error = |noise: f64| {
        let stage = evaluate("", &model, &dataset(noise));
        assert_eq!(stage.records[0].failure, None);
        stage.error
    };
    let (clean, noisy) = (error(0.0), error(0.01));
    println!("{clean:.2e} without noise, {:.3} times the floor of 1 %", noisy / 0.01);
    assert!(noisy < 1.1 * 0.01, "{noisy}");
}
