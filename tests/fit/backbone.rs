//! Backbones: a contact law recovered from one that the harmonic balance itself made; tables with damping.
//!
//! Items to verify: a table of an oscillator is that of its free decay in the exact flow; the damping column tells what
//! frequencies alone do not, for oscillators and beams, and names the effect that only damps.

use std::f64::consts::TAU;

use stickslip::contact::{Jenkins, Valanis};
use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Verdict, Watch, diagnose, evaluate, refit};
use stickslip::fit::{Options, Parameter, Scale, fit};
use stickslip::harmonic::{CurveSettings, HarmonicError, Method, backbone};
use stickslip::model::Model;
use stickslip::system::ModalBeam;
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow};

use crate::common::beam::modal;
use crate::common::contact::loaded;

const LOAD: f64 = 100.0;

#[test]
fn valanis_parameters_are_recovered_from_exact_frequencies() {
    let beam = ModalBeam {
        shortening: vec![32.0],
        axial_flexibility: 1.5e-8,
        ..modal(&[TAU * 49.0], &[0.003], &[0.06], &[0.4])
    };
    let settings =
        CurveSettings { harmonics: 3, method: Method::Sampled { samples: 64 }, ..CurveSettings::default() };
    let amplitudes = [1.0, 12.0, 30.0, 70.0];
    let frequencies = |p: &[f64]| -> Result<Vec<f64>, HarmonicError> {
        let law = Valanis::new(p[0], p[1] / LOAD, p[2], 0.0)
            .map_err(|_| HarmonicError::InvalidInput("the law refuses the parameters"))?;
        let contact = loaded(law, LOAD);
        let found = backbone(&beam.system(contact.clone()).unwrap(), &amplitudes, &settings, &[])?;
        Ok(found.iter().map(|r| r.angular_frequency / TAU).collect())
    };
    let truth = [6.0e6, 95.0, 0.4];
    let measured = frequencies(&truth).unwrap();
    assert!(
        measured.windows(2).all(|pair| pair[1] < pair[0] - 0.05),
        "the backbone must soften: {measured:?}"
    );
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), HarmonicError> {
        out.iter_mut().zip(frequencies(p)?).zip(&measured).for_each(|((r, f), m)| *r = f - m);
        Ok(())
    };
    let parameters = [
        Parameter { start: 9e6, lower: 1e5, upper: 1e8, scale: Scale::Logarithmic },
        Parameter { start: 60.0, lower: 1.0, upper: 1e4, scale: Scale::Logarithmic },
        Parameter { start: 0.1, lower: 0.0, upper: 0.98, scale: Scale::Linear },
    ];
    let fit = fit(residual, amplitudes.len(), &parameters, &Options::default()).unwrap();
    for (found, truth) in fit.parameters.iter().zip(truth) {
        assert!((found / truth - 1.0).abs() < 1e-4, "{:?}", fit.parameters);
    }
    assert!(fit.root_mean_square < 1e-6);
}

/// A table with columns `amplitude` (m/s²), `frequency` (Hz) and `damping_ratio`.
fn table(amplitude: &str, rows: &[[f64; 3]], noise: [f64; 2]) -> Dataset {
    let channel = |(place, (name, unit)): (usize, (&str, _))| Channel {
        name: name.into(),
        unit,
        values: rows.iter().map(|row| row[place]).collect(),
        noise: place.checked_sub(1).map(|place| noise[place]).filter(|noise| *noise > 0.0),
    };
    let names = [(amplitude, "m/s^2"), ("frequency", "Hz"), ("damping_ratio", "1")];
    let channels = names.into_iter().enumerate().map(channel).collect();
    let record = Record { name: "backbone.csv".into(), regime: Regime::Backbone, use_for: None, channels };
    Dataset { title: None, records: vec![record] }
}

const OSCILLATOR: &str = "
    schema = \"stickslip.model/1\"
    kind = \"oscillator\"
    mass = [{ name = \"m1\", mass = 1.3 }]
    spring = [{ between = [\"ground\", \"m1\"], stiffness = 1.1e4, damping = 0.4 }]
    contact = { at = \"m1\", law = \"jenkins\", tangential_stiffness = 900.0, friction_coefficient = 0.3, normal_load = 10.0 }
";

/// Amplitude, frequency and damping from peak to peak of a free decay from `start` (m), by the exact flow.
fn decay(model: &Model, start: f64, peaks: usize) -> Vec<[f64; 3]> {
    let contact = model.contact.unwrap();
    let law = Jenkins::new(contact.tangential_stiffness, contact.friction_coefficient).unwrap();
    let contacts = [LoadedContact { law: &law, normal_load: contact.normal_load }];
    let mut flow = OscillatorFlow::new(&model.system().unwrap().linear_part(), &contacts).unwrap();
    // Pushed slowly to the start, and let go once it is still.
    let held = 1.1e4 * start + contact.friction_coefficient * contact.normal_load;
    let push = Excitation::Sampled { interval: 60.0, values: vec![0.0, held] };
    let mut motion = flow.rest();
    flow.advance(&mut motion, 120.0, &push).unwrap();
    let silent = Excitation::none();
    let (mut found, mut before) = (Vec::new(), 0.0);
    let step = 1e-4;
    while found.len() < 2 * peaks {
        flow.advance(&mut motion, step, &silent).unwrap();
        let (x, v) = (flow.displacement(&motion)[0], flow.velocity(&motion)[0]);
        if v * before < 0.0 {
            // Back to where the velocity vanishes, as on a straight line.
            found.push([motion.time() - step * v / (v - before), x.abs()]);
        }
        before = v;
    }
    // Over whole periods, positive and negative peaks alike.
    let row = |three: &[[f64; 2]]| {
        let speed = TAU / (three[2][0] - three[0][0]);
        let amplitude = 0.25 * (three[0][1] + 2.0 * three[1][1] + three[2][1]);
        let ratio = (three[0][1] / three[2][1]).ln() / TAU;
        [amplitude * speed * speed, speed / TAU, ratio]
    };
    found[2..].windows(3).map(row).collect()
}

#[test]
fn a_table_of_an_oscillator_is_that_of_its_free_decay() {
    let model = Model::parse(OSCILLATOR).unwrap();
    let rows = decay(&model, 0.03, 60);
    let stage = evaluate("", &model, &table("amplitude", &rows, [0.0; 2]));
    assert_eq!(stage.records[0].failure, None);
    for (channel, most) in stage.records[0].channels.iter().zip([0.05, 0.08]) {
        println!("{}: {:.4}", channel.name, channel.error);
        assert!(channel.error < most, "{}: {}", channel.name, channel.error);
    }
    let (first, last) = (rows[0], rows[rows.len() - 1]);
    println!("{first:?} … {last:?}");
    // The same by the name of the mass.
    assert_eq!(evaluate("", &model, &table("amplitude:m1", &rows, [0.0; 2])).error, stage.error);
}

/// What `model` says of amplitudes.
fn made_by(model: &Model, amplitudes: &[f64]) -> Dataset {
    let rows: Vec<[f64; 3]> = amplitudes.iter().map(|a| [*a, 10.0 + a, 0.01 + a]).collect();
    let blank = table("amplitude", &rows, [0.0; 2]);
    let mut made = blank.clone();
    let found = &evaluate("", model, &blank).records[0];
    assert_eq!(found.failure, None);
    for (channel, found) in made.records[0].channels[1..].iter_mut().zip(&found.channels) {
        channel.values = found.predicted.clone();
    }
    made
}

#[test]
fn damping_tells_what_frequencies_alone_do_not() {
    let beam = include_str!("../../examples/frictional-support/published.toml")
        .replace("free = []", "free = [\"contact.friction_coefficient\", \"beam.damping_ratio\"]");
    for (text, path, levels) in [
        (OSCILLATOR, "spring.1.damping", [5.0, 20.0, 60.0, 150.0]),
        (&beam, "beam.damping_ratio", [2.0, 10.0, 30.0, 60.0]),
    ] {
        let truth = Model::parse(text).unwrap();
        let measured = made_by(&truth, &levels);
        let mut start = truth.clone();
        start.set(path, 1.7 * truth.get(path).unwrap()).unwrap();
        start
            .set("contact.friction_coefficient", 0.8 * truth.get("contact.friction_coefficient").unwrap())
            .unwrap();
        let found = refit("", &start, &measured, Watch::default()).unwrap();
        assert!((found.model.get(path).unwrap() / truth.get(path).unwrap() - 1.0).abs() < 1e-3, "{path}");
        // Frequencies at phase resonance tell a little of it, those of a free vibration nothing.
        let mut without = measured.clone();
        without.records[0].channels.pop();
        let blind = refit("", &start, &without, Watch::default()).unwrap();
        assert!(text != OSCILLATOR || blind.unseen == [path], "{:?}", blind.unseen);
    }
}

#[test]
fn drag_is_found_in_the_damping_of_a_table() {
    let text = "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\nmass = [{ name = \"m1\", mass = 2.0 }]\n\
         spring = [{ between = [\"ground\", \"m1\"], stiffness = 2e4, damping = 3.0 }]";
    let mut random = fastrand::Rng::with_seed(3);
    let mut noise = |size: f64| size * 3.46 * (random.f64() - 0.5);
    // ζ = ζ₀ + 4 q X / (3 π m): drag q|v|v takes 8/3 q ω² X³ in a cycle.
    let rows: Vec<[f64; 3]> = (1..=24)
        .map(|level| {
            let acceleration = 2.5 * f64::from(level);
            let drag = 4.0 * 6.0 * (acceleration / 1e4) / (3.0 * std::f64::consts::PI * 2.0);
            [acceleration, 100.0 / TAU + noise(2e-3), 3.0 / 400.0 + drag + noise(1e-4)]
        })
        .collect();
    let model = Model::parse(text).unwrap();
    let measured = table("amplitude:m1", &rows, [2e-3, 1e-4]);
    let found = diagnose(&model, &measured, &DiagnoseOptions::default(), DiagnoseWatch::default()).unwrap();
    println!("{:?} {:?} {:?} {:?}", found.verdict, found.probability, found.effects, found.reasons);
    assert_eq!((found.verdict, &found.effects[..]), (Verdict::EffectFound, &["quadratic_damping"][..]));
    let drag = found.model.get("effect.1.quadratic_damping").unwrap();
    assert!((drag / 6.0 - 1.0).abs() < 0.05, "{drag}");
}
