//! Records of every regime against models that made them.
//!
//! Items to verify: an unknown initial force is found; a steady loop needs no start; a beam from rest ends in
//! the steady state that harmonic balance finds; the error is the one the files define; a record that
//! cannot be predicted says why and leaves the others alone.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{Refit, Watch, evaluate, refit};
use stickslip::fit::Ending;
use stickslip::model::Model;

const STIFFNESS: f64 = 2e6;
const LIMIT: f64 = 50.0;

fn contact() -> Model {
    Model::parse(
        r#"
        schema = "stickslip.model/1"
        kind = "contact"
        [contact]
        law = "jenkins"
        tangential_stiffness = 2e6
        friction_coefficient = 0.5
        normal_load = 100.0
        "#,
    )
    .unwrap()
}

fn channel(name: &str, unit: &'static str, values: Vec<f64>) -> Channel {
    Channel { name: name.into(), unit, values, noise: None }
}

fn record(name: &str, regime: Regime, channels: Vec<Channel>) -> Record {
    Record { name: name.into(), regime, use_for: None, channels }
}

fn dataset(records: Vec<Record>) -> Dataset {
    Dataset { title: None, records }
}

/// A Jenkins loop stepped by hand from `slider` (m), `periods` of 200 samples and 40 µm.
fn measured_loop(mut slider: f64, periods: usize, regime: Regime) -> Record {
    let (mut time, mut displacement, mut force) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..200 * periods {
        let u = 40e-6 * (TAU * index as f64 / 200.0 + 0.3).sin();
        let t = (STIFFNESS * (u - slider)).clamp(-LIMIT, LIMIT);
        slider = u - t / STIFFNESS;
        time.push(index as f64 * 1e-3);
        displacement.push(u);
        force.push(t);
    }
    let channels = vec![
        channel("time", "s", time),
        channel("displacement", "m", displacement),
        channel("force", "N", force),
    ];
    record("loop.csv", regime, channels)
}

#[test]
fn an_unknown_initial_force_is_found_from_the_record() {
    for slider in [-8e-6, 0.0, 20e-6, 30e-6] {
        let stage =
            evaluate("", &contact(), &dataset(vec![measured_loop(slider, 2, Regime::UnknownInitialState)]));
        assert!(stage.error < 1e-4, "slider at {slider}: {}", stage.error);
    }
    // From rest it is another record: the slider does not start where the model has it.
    let stage = evaluate("", &contact(), &dataset(vec![measured_loop(30e-6, 2, Regime::FromRest)]));
    assert!(stage.error > 0.1, "{}", stage.error);
}

#[test]
fn a_late_force_is_late_from_the_first_sample_on() {
    let text = "[[effect]]\nid = \"sensor_delay\"\nchannel = \"force\"\ndelay = 0.007\n";
    let late = Model::parse(&format!("{}\n{text}", contact().to_toml())).unwrap();
    // The force of seven samples ago, in a record that is cut out of a longer one.
    let mut record = measured_loop(5e-6, 3, Regime::UnknownInitialState);
    for (channel, from) in record.channels.iter_mut().zip([150, 150, 143]) {
        channel.values.drain(..from);
        channel.values.truncate(440);
    }
    let stage = evaluate("", &late, &dataset(vec![record.clone()]));
    assert!(stage.error < 2e-3, "{}", stage.error);
    // A model without it is wrong by a stretch of the slope.
    assert!(evaluate("", &contact(), &dataset(vec![record])).error > 0.05);
}

#[test]
fn a_clock_of_another_rate_is_seen_to_the_end_of_the_record() {
    for error in [4e-3, -4e-3] {
        let text =
            format!("[[effect]]\nid = \"sensor_clock_drift\"\nchannel = \"force\"\nclock_error = {error}\n");
        let drifting = Model::parse(&format!("{}\n{text}", contact().to_toml())).unwrap();
        // In stick the force is that of a spring: the closed form of a sine.
        let angle = |index: f64| TAU * index / 50.0;
        let column = |amplitude: f64, rate: f64| {
            (0..1001).map(|i| amplitude * angle(f64::from(i) * rate).sin()).collect()
        };
        let channels = vec![
            channel("time", "s", (0..1001).map(|i| f64::from(i) * 1e-3).collect()),
            channel("displacement", "m", column(20e-6, 1.0)),
            channel("force", "N", column(20e-6 * STIFFNESS, 1.0 + error)),
        ];
        let record = record("stuck", Regime::UnknownInitialState, channels);
        let stage = evaluate("", &drifting, &dataset(vec![record.clone()]));
        assert!(stage.error < 1e-4, "{error}: {}", stage.error);
        // A phase that grows to half a radian: its mean square is a third of the last.
        let phase = 1000.0 * error * TAU / 50.0;
        let without = evaluate("", &contact(), &dataset(vec![record])).error;
        assert!((without / (phase.abs() / 3.0_f64.sqrt()) - 1.0).abs() < 0.05, "{without} {phase}");
    }
}

#[test]
fn a_steady_loop_needs_no_start() {
    let mut record = measured_loop(7e-6, 2, Regime::Steady);
    for channel in &mut record.channels {
        channel.values.drain(..200); // the first period is the transient
    }
    let stage = evaluate("", &contact(), &dataset(vec![record]));
    assert!(stage.error < 1e-12, "{}", stage.error);
}

#[test]
fn the_error_is_the_root_mean_square_over_the_standard_deviation() {
    let mut record = measured_loop(0.0, 1, Regime::FromRest);
    let measured = record.channels[2].values.clone();
    let count = measured.len() as f64;
    let mean = measured.iter().sum::<f64>() / count;
    let deviation = (measured.iter().map(|force| (force - mean).powi(2)).sum::<f64>() / count).sqrt();
    record.channels[2].values.iter_mut().for_each(|force| *force += 3.0);
    let stage = evaluate("", &contact(), &dataset(vec![record]));
    assert!((stage.error - 3.0 / deviation).abs() < 1e-12);
    assert!((stage.records[0].channels[0].rms - 3.0).abs() < 1e-12);
}

#[test]
fn a_refit_finds_the_contact_that_made_the_loops() {
    let mut start = contact();
    start.set("contact.tangential_stiffness", 1.2e6).unwrap();
    start.set("contact.friction_coefficient", 0.8).unwrap();
    let data = dataset(vec![
        measured_loop(0.0, 1, Regime::FromRest),
        measured_loop(5e-6, 1, Regime::UnknownInitialState),
    ]);
    let Refit { model, stage, .. } = refit("refitted", &start, &data, Watch::default()).unwrap();
    assert!(stage.error < 1e-4, "{}", stage.error);
    assert!((model.get("contact.tangential_stiffness").unwrap() / STIFFNESS - 1.0).abs() < 1e-3);
    assert!((model.get("contact.friction_coefficient").unwrap() / 0.5 - 1.0).abs() < 1e-3);
    assert!(
        stage
            .parameters
            .iter()
            .any(|parameter| parameter.fitted.as_ref().is_some_and(|fitted| fitted.from == Some(1.2e6)))
    );
}

/// A contact that is said to stick throughout has a friction coefficient that changes nothing: no derivative leads back
/// to where it slips.
#[test]
fn a_refit_comes_back_from_where_the_contact_never_slips() {
    let data = dataset(vec![
        measured_loop(0.0, 1, Regime::FromRest),
        measured_loop(5e-6, 1, Regime::UnknownInitialState),
    ]);
    for stiffness in [0.9e6, 1.2e6, 1.5e6, 4e6] {
        for friction in [0.2, 0.6, 0.7, 0.9, 1.2, 20.0] {
            let mut start = contact();
            start.set("contact.tangential_stiffness", stiffness).unwrap();
            start.set("contact.friction_coefficient", friction).unwrap();
            let Refit { stage, .. } = refit("refitted", &start, &data, Watch::default()).unwrap();
            assert!(stage.error < 1e-4, "from {stiffness} N/m, {friction}: {}", stage.error);
        }
    }
}

#[test]
fn what_the_records_do_not_show_stays_as_it_was() {
    // Never slips: 40 µm at 2e6 N/m are 80 N, below the limit of 100 N.
    let mut made = contact();
    made.set("contact.friction_coefficient", 1.0).unwrap();
    let mut record = measured_loop(0.0, 1, Regime::FromRest);
    let force: Vec<f64> = record.channels[1].values.iter().map(|u| STIFFNESS * u).collect();
    record.channels[2].values = force;
    let mut start = made.clone();
    start.set("contact.tangential_stiffness", 1.2e6).unwrap();
    start.set("contact.friction_coefficient", 1.3).unwrap();
    let Refit { model, stage, unseen, .. } =
        refit("refitted", &start, &dataset(vec![record]), Watch::default()).unwrap();
    assert!(stage.error < 1e-6, "{}", stage.error);
    assert_eq!(model.get("contact.friction_coefficient"), Some(1.3));
    assert_eq!(unseen, ["contact.friction_coefficient"]);
}

#[test]
fn an_interrupted_refit_keeps_the_best_so_far() {
    let mut start = contact();
    start.set("contact.friction_coefficient", 0.8).unwrap();
    let data = dataset(vec![measured_loop(0.0, 1, Regime::FromRest)]);
    let before = evaluate("", &start, &data).error;
    let calls = std::sync::atomic::AtomicUsize::new(0);
    let interrupt = || calls.fetch_add(1, std::sync::atomic::Ordering::SeqCst) >= 12;
    let watch = Watch { interrupt: Some(&interrupt), ..Watch::default() };
    let Refit { stage, ending, .. } = refit("", &start, &data, watch).unwrap();
    assert_eq!(ending, Ending::Interrupted);
    assert!(stage.error <= before && stage.evaluations <= 16, "{} {}", stage.error, stage.evaluations);
}

#[test]
fn a_record_that_cannot_be_predicted_says_why_and_leaves_the_others_alone() {
    let mut flat = measured_loop(0.0, 1, Regime::FromRest);
    flat.channels[2].values.fill(1.0);
    let stage = evaluate("", &contact(), &dataset(vec![flat, measured_loop(0.0, 1, Regime::FromRest)]));
    assert!(stage.records[0].failure.as_ref().unwrap().contains("force"));
    assert!(stage.records[1].failure.is_none() && stage.error < 1e-12);
}

#[test]
fn a_beam_from_rest_ends_in_the_steady_state_of_harmonic_balance() {
    let text = include_str!("../../examples/frictional-support/published.toml").replace("= 0.003", "= 0.02");
    let model = Model::parse(&text).unwrap();
    let (per_period, periods, kept) = (256, 60, 2);
    let period = 1.0 / 51.0;
    let instants: Vec<f64> =
        (0..per_period * periods).map(|k| period * k as f64 / per_period as f64).collect();
    let force: Vec<f64> = instants.iter().map(|t| 8.0 * (TAU * t / period).sin()).collect();
    let blank: Vec<f64> = instants.iter().map(|t| t.sin()).collect();
    let positions = ["acceleration:x=0.55", "acceleration:x=0.2"];
    let mut channels = vec![channel("time", "s", instants), channel("excitation", "N", force)];
    channels.extend(positions.map(|name| channel(name, "m/s^2", blank.clone())));
    let transient = record("rest.csv", Regime::FromRest, channels);
    let from_rest = evaluate("", &model, &dataset(vec![transient.clone()]));
    assert_eq!(from_rest.records[0].failure, None);

    // What the integration ends in becomes the measurement of a steady record.
    let last = per_period * (periods - kept);
    let mut steady = Record { regime: Regime::Steady, ..transient };
    for (channel, result) in steady.channels[2..].iter_mut().zip(&from_rest.records[0].channels) {
        channel.values = result.predicted.clone();
    }
    for channel in &mut steady.channels {
        channel.values.drain(..last);
    }
    let stage = evaluate("", &model, &dataset(vec![steady]));
    assert_eq!(stage.records[0].failure, None);
    // Truncation at 30 harmonics, and the rest of the transient.
    assert!(stage.error < 5e-3, "{}", stage.error);
}
/// Noise with a memory of ten samples: intervals that take every sample for new information would be three times too short.
#[test]
fn intervals_of_a_refit_hold_the_truth_under_noise_with_a_memory() {
    let mut inside = 0;
    for seed in 0..40 {
        let mut numbers = fastrand::Rng::with_seed(seed);
        let mut noise = 0.0;
        let mut record = measured_loop(0.0, 4, Regime::FromRest);
        for force in &mut record.channels[2].values {
            noise = 0.9 * noise + (12.0_f64).sqrt() * (numbers.f64() - 0.5);
            *force += noise;
        }
        let mut start = contact();
        start.set("contact.tangential_stiffness", 1.1 * STIFFNESS).unwrap();
        let stage = refit("refitted", &start, &dataset(vec![record]), Watch::default()).unwrap().stage;
        let of = |path: &str| {
            stage.parameters.iter().find(|one| one.path == path).unwrap().fitted.clone().unwrap()
        };
        for (path, truth) in
            [("contact.tangential_stiffness", STIFFNESS), ("contact.friction_coefficient", 0.5)]
        {
            let [low, high] = of(path).interval.unwrap();
            inside += usize::from(low < truth && truth < high);
        }
    }
    println!("{inside} of 80 intervals hold the truth");
    assert!(inside >= 70, "{inside} of 80");
}
