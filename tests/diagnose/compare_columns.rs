//! What a comparison reads of a record, what it leaves aside, and which records a refit may see.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime, Use};
use stickslip::diagnose::{RefitError, Watch, evaluate, refit, unused_columns};
use stickslip::harmonic::{CurveSettings, phase_resonance};
use stickslip::model::{Model, Structure};
use stickslip::system::ModalBeam;

const JENKINS: &str = r#"
schema = "stickslip.model/1"
kind = "contact"
[contact]
law = "jenkins"
tangential_stiffness = 2.0e6
friction_coefficient = 0.5
normal_load = 100.0
"#;

fn linear_beam() -> Model {
    Model::parse(include_str!("../../examples/frictional-support/linear.toml")).unwrap()
}

fn modal(model: &Model) -> ModalBeam {
    let Structure::Beam(beam) = &model.structure else { panic!("a beam") };
    ModalBeam::new(beam).unwrap()
}

fn record(regime: Regime, columns: &[(&str, Vec<f64>)]) -> Record {
    let channel = |(name, values): &(&str, Vec<f64>)| Channel {
        name: (*name).to_owned(),
        unit: "1",
        values: values.clone(),
        noise: None,
    };
    Record { name: "r.csv".into(), regime, use_for: None, channels: columns.iter().map(channel).collect() }
}

fn dataset(records: Vec<Record>) -> Dataset {
    Dataset { title: None, records }
}

/// 64 samples of one period of 20 Hz.
fn times() -> Vec<f64> {
    (0..64).map(|k| f64::from(k) / (64.0 * 20.0)).collect()
}

fn wave(order: usize, size: f64) -> Vec<f64> {
    times().iter().map(|t| size * (order as f64 * TAU * 20.0 * t).cos()).collect()
}

/// A Jenkins loop of another stiffness than the model's.
fn contact_loop(stiffness: f64, use_for: Option<Use>) -> Record {
    let displacement = wave(1, 40e-6);
    let mut slider = 0.0;
    let force = displacement
        .iter()
        .map(|u| {
            let force = (stiffness * (u - slider)).clamp(-50.0, 50.0);
            slider = u - force / stiffness;
            force
        })
        .collect();
    let mut loop_record = record(
        Regime::FromRest,
        &[("time", times()), ("displacement", displacement), ("force", force), ("normal_load", wave(2, 9.0))],
    );
    loop_record.use_for = use_for;
    loop_record
}

#[test]
fn damping_of_a_backbone_counts_beside_its_frequency() {
    let model = linear_beam();
    let amplitudes = vec![1.0, 10.0];
    let found = phase_resonance(
        &modal(&model).system(None).unwrap(),
        1.0,
        &CurveSettings { harmonics: 5, ..CurveSettings::default() },
        None,
    )
    .unwrap();
    let hertz = found.angular_frequency / TAU;
    // Both channels scatter by 1 % about the model, so that each is off by its own standard deviation.
    let about = |value: f64| vec![0.99 * value, 1.01 * value];
    let table = record(
        Regime::Backbone,
        &[("amplitude", amplitudes), ("frequency", about(hertz)), ("damping_ratio", about(0.003))],
    );
    assert!(unused_columns(&model, &table).is_empty());
    let stage = evaluate("baseline", &model, &dataset(vec![table]));
    let channels = &stage.records[0].channels;
    assert_eq!(channels.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["frequency", "damping_ratio"]);
    for channel in channels {
        assert!((channel.error - 1.0).abs() < 1e-3, "{} {}", channel.name, channel.error);
    }
    assert!((stage.error - 1.0).abs() < 1e-3);
}

#[test]
fn every_motion_of_a_steady_record_counts_whatever_else_it_holds() {
    let (model, speed) = (linear_beam(), TAU * 20.0);
    // Far below the first resonance, without contact: the exact receptance of the modes.
    let beam = modal(&model);
    let (mut real, mut imaginary) = (0.0, 0.0);
    let Structure::Beam(description) = &model.structure else { panic!("a beam") };
    assert_eq!(description.excitation_position, 0.55);
    for i in 0..beam.angular_frequency.len() {
        let natural = beam.angular_frequency[i];
        let dynamic = natural * natural - speed * speed;
        let damping = 2.0 * beam.damping_ratio[i] * natural * speed;
        let size = beam.excitation_shape[i].powi(2) / (dynamic * dynamic + damping * damping);
        (real, imaginary) = (real + size * dynamic, imaginary - size * damping);
    }
    let motion = |order: i32| -> Vec<f64> {
        // H e^{iωt} differentiated: each order turns by a quarter period and multiplies by ω.
        let turned = |t: f64| speed * t + f64::from(order) * TAU / 4.0;
        let at = |t: &f64| speed.powi(order) * (real * turned(*t).cos() - imaginary * turned(*t).sin());
        times().iter().map(at).collect()
    };
    let steady = record(
        Regime::Steady,
        &[
            ("time", times()),
            ("frequency", wave(0, 20.0)),
            ("excitation", wave(1, 1.0)),
            ("velocity:x=0.55", motion(1)),
            ("displacement:x=0.55", motion(0)),
            ("acceleration:x=0.55", motion(2)),
        ],
    );
    assert_eq!(unused_columns(&model, &steady), ["frequency"]);
    let stage = evaluate("baseline", &model, &dataset(vec![steady]));
    assert_eq!(stage.records[0].failure, None);
    assert_eq!(stage.records[0].channels.len(), 3);
    for channel in &stage.records[0].channels {
        assert!(channel.error < 1e-6, "{} {}", channel.name, channel.error);
    }
}

#[test]
fn an_excitation_beyond_the_harmonics_kept_is_refused() {
    let model = linear_beam();
    let columns = |upper: f64| {
        let phases = (0..256).map(|k| TAU * f64::from(k) / 256.0);
        let excitation: Vec<f64> = phases.clone().map(|x| x.cos() + upper * (100.0 * x).cos()).collect();
        let time: Vec<f64> = (0..256).map(|k| f64::from(k) / (256.0 * 20.0)).collect();
        let acceleration = phases.map(f64::cos).collect();
        [("time", time), ("excitation", excitation), ("acceleration:x=0.55", acceleration)]
    };
    let data = dataset(vec![record(Regime::Steady, &columns(1.0)), record(Regime::Steady, &columns(0.01))]);
    let stage = evaluate("baseline", &model, &data);
    assert!(stage.records[0].failure.as_ref().unwrap().contains("beyond harmonic"), "{stage:?}");
    assert_eq!(stage.records[1].failure, None);
}

#[test]
fn a_measured_normal_load_is_an_input_and_what_nothing_reads_is_named() {
    let model = Model::parse(JENKINS).unwrap();
    let mut record = contact_loop(3e6, None);
    assert_eq!(unused_columns(&model, &record), [""; 0]);
    for channel in record.channels.iter_mut().filter(|channel| channel.name == "normal_load") {
        channel.name = "excitation".into();
    }
    assert_eq!(unused_columns(&model, &record), ["excitation"]);
}

#[test]
fn records_kept_for_confirming_are_not_fitted() {
    let model = Model::parse(JENKINS).unwrap();
    let stiffness = |records: Vec<Record>| {
        let refitted = refit("refitted", &model, &dataset(records), Watch::default());
        refitted.map(|refitted| refitted.model.get("contact.tangential_stiffness").unwrap())
    };
    let (a, b) = (3e6, 6e6);
    let close = |found: Result<f64, RefitError>, expected: f64| {
        let found = found.unwrap();
        assert!((found / expected - 1.0).abs() < 1e-4, "{found}");
    };
    close(stiffness(vec![contact_loop(a, Some(Use::Fit)), contact_loop(b, None)]), a);
    close(stiffness(vec![contact_loop(a, None), contact_loop(b, Some(Use::Confirm))]), a);
    close(stiffness(vec![contact_loop(a, None), contact_loop(b, Some(Use::Select))]), a);
    assert_eq!(stiffness(vec![contact_loop(b, Some(Use::Confirm))]), Err(RefitError::NothingToFit));
}

#[test]
fn a_channel_without_variation_stops_the_refit_by_name() {
    let model = Model::parse(JENKINS).unwrap();
    let mut constant = contact_loop(3e6, None);
    constant.channels[2].values.fill(0.1);
    let error = refit("refitted", &model, &dataset(vec![constant]), Watch::default()).unwrap_err();
    assert!(error.to_string().contains("`r.csv`") && error.to_string().contains("`force`"), "{error}");
}

/// The steady state under a normal load that swings is what the motion from rest settles to.
#[test]
fn a_beam_in_a_steady_state_follows_the_measured_normal_load() {
    let text = include_str!("../../examples/frictional-support/published.toml");
    let mut beam =
        Model::parse(&format!("{text}\n[[effect]]\nid = \"normal_load_variation\"\nload_gain = 1.0\n"))
            .unwrap();
    beam.set("beam.damping_ratio", 0.05).unwrap();
    let constant = beam.get("contact.normal_load").unwrap();
    let predicted = |regime: Regime, periods: usize, swing: f64| {
        let time = (0..64 * periods).map(|k| k as f64 / (64.0 * 20.0)).collect();
        let repeated = |wave: Vec<f64>| -> Vec<f64> { wave.repeat(periods) };
        let load = wave(2, swing * constant).iter().map(|change| constant + change).collect();
        let columns = [
            ("time", time),
            ("excitation", repeated(wave(1, 200.0))),
            ("normal_load", repeated(load)),
            ("velocity:x=0.55", repeated(wave(1, 1.0))),
        ];
        let stage = evaluate("", &beam, &dataset(vec![record(regime, &columns)]));
        assert_eq!(stage.records[0].failure, None);
        let values = &stage.records[0].channels[0].predicted;
        values[values.len() - 64..].to_vec()
    };
    let apart = |a: &[f64], b: &[f64]| {
        let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>().sqrt();
        square(&mut a.iter().zip(b).map(|(a, b)| a - b)) / square(&mut b.iter().copied())
    };
    for swing in [0.5, 1.5] {
        let settled = predicted(Regime::FromRest, 60, swing);
        let steady = predicted(Regime::Steady, 1, swing);
        let under_constant = predicted(Regime::Steady, 1, 0.0);
        // From sample to sample excitation and load run on straight lines.
        assert!(apart(&steady, &settled) < 5e-3, "{swing}: {}", apart(&steady, &settled));
        assert!(apart(&steady, &under_constant) > 0.02, "the swing matters");
    }
}

/// A beam from rest whose contact follows a measured normal load: held at another value it is the beam with that load,
/// and half a gain is half the change.
#[test]
fn a_beam_from_rest_follows_the_measured_normal_load() {
    let text = include_str!("../../examples/frictional-support/published.toml");
    let beam = Model::parse(text).unwrap();
    let constant = beam.get("contact.normal_load").unwrap();
    let following = |gain: f64| {
        let effect = format!("[[effect]]\nid = \"normal_load_variation\"\nload_gain = {gain}\n");
        Model::parse(&format!("{text}\n{effect}")).unwrap()
    };
    let measured = |load: Vec<f64>| {
        let columns =
            [("time", times()), ("excitation", wave(1, 60.0)), ("acceleration:x=0.55", wave(1, 1.0))];
        let mut columns = columns.to_vec();
        columns.push(("normal_load", load));
        dataset(vec![record(Regime::FromRest, &columns)])
    };
    let predicted = |model: &Model, load: f64| {
        let stage = evaluate("", model, &measured(vec![load; 64]));
        assert_eq!(stage.records[0].failure, None);
        stage.records[0].channels[0].predicted.clone()
    };
    let mut pressed = beam.clone();
    pressed.set("contact.normal_load", 1.5 * constant).unwrap();
    let expected = predicted(&pressed, constant);
    assert_ne!(expected, predicted(&beam, constant));
    let largest = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (gain, load) in [(1.0, 1.5 * constant), (0.5, 2.0 * constant)] {
        let found = predicted(&following(gain), load);
        let apart = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-6 * largest, "gain {gain}: {apart} of {largest}");
    }
    // A load that changes is not its mean.
    let swinging: Vec<f64> = wave(1, 0.4 * constant).iter().map(|change| constant + change).collect();
    let stage = evaluate("", &following(1.0), &measured(swinging));
    assert_ne!(stage.records[0].channels[0].predicted, predicted(&beam, constant));
}
