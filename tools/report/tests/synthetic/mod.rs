//! Comparisons to look at and to test with.
#![allow(dead_code, missing_docs)] // each user needs a part of it

pub mod diagnosis;

use std::f64::consts::TAU;

use stickslip::data::{Channel, Record, Regime, Use};
use stickslip::diagnose::{ChannelResult, Comparison, Fitted, Parameter, RecordResult, Stage};
use stickslip_report::{InputFile, Settings};

/// A first resonance (Hz) measured at held acceleration, and two published predictions of it.
const AMPLITUDE: [f64; 8] = [0.5, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
const MEASURED: [f64; 8] = [52.85, 52.79, 52.30, 51.62, 50.63, 50.55, 50.30, 50.11];
const PUBLISHED: [f64; 8] = [54.04, 53.29, 51.64, 50.60, 50.07, 49.76, 49.55, 49.41];
/// Residual patterns of refitted models, scaled below to a known RMS; their shape is made up.
const REFIT: [f64; 8] = [0.05, -0.10, -0.12, -0.17, 0.28, 0.04, -0.08, -0.12];
const REFIT_STIFF: [f64; 8] = [0.02, -0.07, -0.02, -0.10, 0.21, -0.03, -0.05, -0.04];

pub fn settings() -> Settings {
    Settings {
        command: "stickslip compare beam.toml backbone/dataset.toml --report page.html".into(),
        version: "0.1.0".into(),
        files: ["beam.toml", "backbone/dataset.toml", "backbone/f1.csv"]
            .iter()
            .enumerate()
            .map(|(i, name)| InputFile {
                name: (*name).into(),
                sha256: format!("{:016x}", 0x9e37_79b9_u64 * (i as u64 + 3)).repeat(4),
            })
            .collect(),
        date: None,
    }
}

pub fn channel(name: &str, unit: &'static str, values: Vec<f64>) -> Channel {
    Channel { name: name.into(), unit, values, noise: None }
}

pub fn parameter(path: &str, unit: &'static str, value: f64, fitted_from: Option<f64>) -> Parameter {
    Parameter { path: path.into(), unit, value, fitted: fitted_from.map(Fitted::from) }
}

/// The result of predicting `measured`, with the errors that belong to it.
pub fn result(measured: &Channel, predicted: Vec<f64>) -> RecordResult {
    let count = measured.values.len() as f64;
    let mean = measured.values.iter().sum::<f64>() / count;
    let spread = (measured.values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt();
    let squares: f64 = measured.values.iter().zip(&predicted).map(|(m, p)| (m - p).powi(2)).sum();
    let rms = (squares / count).sqrt();
    let channel = ChannelResult {
        name: measured.name.clone(),
        unit: measured.unit,
        error: rms / spread,
        rms,
        predicted,
    };
    RecordResult { error: rms / spread, channels: vec![channel], failure: None }
}

pub fn failed(reason: &str) -> RecordResult {
    RecordResult { error: f64::INFINITY, channels: vec![], failure: Some(reason.into()) }
}

pub fn stage(
    name: &str,
    parameters: Vec<Parameter>,
    records: Vec<RecordResult>,
    evaluations: usize,
) -> Stage {
    let good = || records.iter().filter(|record| record.failure.is_none());
    let error = (good().map(|record| record.error.powi(2)).sum::<f64>() / good().count() as f64).sqrt();
    Stage { name: name.into(), parameters, error, records, evaluations, notes: vec![] }
}

/// The backbone of a clamped beam with a frictional support, five stages.
pub fn backbone() -> Comparison {
    let frequency = channel("frequency", "Hz", MEASURED.to_vec());
    let scaled = |pattern: [f64; 8], rms: f64| -> Vec<f64> {
        let own = (pattern.iter().map(|r| r * r).sum::<f64>() / 8.0).sqrt();
        MEASURED.iter().zip(pattern).map(|(m, r)| m + r * rms / own).collect()
    };
    let law = |e0: f64, limit: f64, kappa: f64, et: f64, from: bool| {
        vec![
            parameter("beam.youngs_modulus", "Pa", 1.971e11, None),
            parameter("contact.tangential_stiffness", "N/m", e0, from.then_some(7.9e6)),
            parameter("contact.friction_coefficient", "1", limit / 147.15, from.then_some(0.617)),
            parameter("contact.normal_load", "N", 147.15, None),
            parameter("contact.smoothness", "1", kappa, from.then_some(0.3)),
            parameter("contact.residual_stiffness", "N/m", et, (et > 0.0).then_some(0.0)),
        ]
    };
    let linear = vec![
        parameter("beam.youngs_modulus", "Pa", 1.971e11, None),
        parameter("support.rotational_stiffness", "N.m/rad", 197.4, None),
    ];
    let one = |predicted: Vec<f64>| vec![result(&frequency, predicted)];
    let stages = vec![
        stage("linear beam", linear, one(vec![52.86; 8]), 0),
        stage("Valanis, published", law(7.9e6, 90.8046, 0.3, 0.0, false), one(PUBLISHED.to_vec()), 0),
        stage("Jenkins, refitted", law(5.1e6, 118.0, 1.0, 0.0, true), one(scaled(REFIT, 0.31)), 96),
        stage("Valanis, refitted", law(5.64e6, 140.0, 0.14, 0.0, true), one(scaled(REFIT, 0.15)), 214),
        stage(
            "Valanis with residual stiffness, refitted",
            law(5.54e6, 102.0, 0.67, 5.3e5, true),
            one(scaled(REFIT_STIFF, 0.10)),
            338,
        ),
    ];
    let amplitude = channel("amplitude", "m/s^2", AMPLITUDE.to_vec());
    let record = Record {
        name: "f1.csv".into(),
        regime: Regime::Backbone,
        use_for: None,
        channels: vec![amplitude, frequency],
    };
    Comparison {
        ring_downs: vec![],
        findings: vec![],
        notes: vec![],
        title: "Beam with a frictional support: first resonance".into(),
        records: vec![record],
        stages,
    }
}

/// Numbers from −1 to 1 that are the same on every machine.
pub fn noise(seed: u64) -> impl FnMut() -> f64 {
    // A fork, since the numbers of neighbouring seeds resemble each other.
    let mut numbers = fastrand::Rng::with_seed(seed).fork();
    move || 2.0 * numbers.f64() - 1.0
}

/// A Jenkins element with a parallel spring, over a motion.
pub fn jenkins(motion: &[f64], stiffness: f64, limit: &[f64], parallel: f64) -> Vec<f64> {
    let mut slider = 0.0;
    motion
        .iter()
        .zip(limit)
        .map(|(&u, &limit)| {
            let force = (stiffness * (u - slider)).clamp(-limit, limit);
            slider = u - force / stiffness;
            force + parallel * u
        })
        .collect()
}

/// Ten contact records with a residual stiffness that the baseline lacks; `samples` each.
pub fn contact(samples: usize) -> Comparison {
    let mut records = Vec::new();
    let (mut baseline, mut refitted, mut last) = (Vec::new(), Vec::new(), Vec::new());
    for index in 0..10_u32 {
        let mut random = noise(u64::from(index) + 1);
        let size = 8e-6 * (1.0 + f64::from(index));
        let time: Vec<f64> = (0..samples).map(|i| i as f64 / 2048.0).collect();
        let motion: Vec<f64> =
            time.iter().map(|t| size * (TAU * 5.0 * t).sin() * (1.0 + 0.2 * (TAU * 0.3 * t).sin())).collect();
        let load: Vec<f64> = time.iter().map(|t| 160.0 + 12.0 * (TAU * 10.0 * t).cos()).collect();
        let limit: Vec<f64> = load.iter().map(|n| 0.47 * n).collect();
        let constant = vec![0.47 * 160.0; samples];
        let mut force = channel("force", "N", jenkins(&motion, 5.1e6, &limit, 4e5));
        force.values.iter_mut().for_each(|f| *f += 0.9 * random());
        force.noise = Some(0.52);
        baseline.push(result(&force, jenkins(&motion, 5.1e6, &constant, 0.0)));
        refitted.push(result(&force, jenkins(&motion, 4.7e6, &vec![85.0; samples], 0.0)));
        last.push(result(&force, jenkins(&motion, 5.09e6, &constant, 4.02e5)));
        let name = format!("r{index}.csv");
        let mut channels = vec![
            channel("time", "s", time),
            channel("displacement", "m", motion),
            force,
            channel("normal_load", "N", load),
        ];
        if index == 3 {
            channels.pop();
        }
        let use_for = Some([Use::Fit, Use::Fit, Use::Select, Use::Confirm][index as usize % 4]);
        records.push(Record { name, regime: Regime::FromRest, use_for, channels });
    }
    let law = |stiffness: f64, coefficient: f64, from: bool| {
        vec![
            parameter("contact.tangential_stiffness", "N/m", stiffness, from.then_some(5.1e6)),
            parameter("contact.friction_coefficient", "1", coefficient, from.then_some(0.47)),
            parameter("contact.normal_load", "N", 160.0, None),
        ]
    };
    let mut with_effect = law(5.09e6, 0.47, true);
    with_effect.push(parameter("effect.residual_stiffness.stiffness", "N/m", 4.02e5, Some(0.0)));
    let stages = vec![
        stage("baseline", law(5.1e6, 0.47, false), baseline, 0),
        stage("refitted", law(4.7e6, 0.53, true), refitted, 88),
        stage("with residual stiffness", with_effect, last, 141),
    ];
    Comparison {
        title: "Bolted lap joint, ten records from rest".into(),
        records,
        ring_downs: vec![],
        findings: vec![],
        notes: vec![],
        stages,
    }
}

/// A beam with two accelerometers; the last stage fails in one of three records.
pub fn beam_with_failure() -> Comparison {
    let mut records = Vec::new();
    let (mut first, mut last) = (Vec::new(), Vec::new());
    for index in 0..3_u32 {
        let time: Vec<f64> = (0..1200).map(|i| f64::from(i) / 4096.0).collect();
        let sweep = |position: f64, detune: f64| -> Vec<f64> {
            time.iter()
                .map(|t| 30.0 * position * (TAU * (50.0 + detune) * t).sin() * (-3.0 * t).exp())
                .collect()
        };
        let tip = channel("acceleration:x=0.55", "m/s^2", sweep(0.55, 0.0));
        let middle = channel("acceleration:x=0.3", "m/s^2", sweep(0.3, 0.0));
        let both = |detune: f64| {
            let (mut one, two) = (result(&tip, sweep(0.55, detune)), result(&middle, sweep(0.3, detune)));
            one.channels.extend(two.channels);
            one
        };
        first.push(both(1.0 + f64::from(index)));
        last.push(if index == 1 {
            failed("the harmonic balance did not converge at 50.3 Hz (residual 2.1e-3 after 40 iterations)")
        } else {
            both(0.05)
        });
        let excitation = channel("excitation", "N", time.iter().map(|t| (TAU * 50.0 * t).sin()).collect());
        records.push(Record {
            name: format!("sweep-{index}.csv"),
            regime: Regime::Steady,
            use_for: None,
            channels: vec![channel("time", "s", time), excitation, tip, middle],
        });
    }
    let stages = vec![stage("baseline", vec![], first, 0), stage("refitted", vec![], last, 57)];
    Comparison {
        title: "Beam, three sweeps".into(),
        records,
        ring_downs: vec![],
        findings: vec![],
        notes: vec![],
        stages,
    }
}

/// Names that try to leave their place.
pub const HOSTILE: [&str; 4] = [
    "</script><script>alert(1)</script>",
    "<img src=https://example.invalid/x onerror=alert(2)>",
    "\" onmouseover=\"alert(3)\" x=\"&amp;",
    "\u{1b}[2J\u{202e}<a href='javascript:alert(4)'>%{x}</a>$\\LaTeX$",
];

/// As [`contact`], with every name from a file replaced by a hostile one.
pub fn hostile() -> Comparison {
    let mut comparison = contact(400);
    comparison.title = HOSTILE[0].into();
    for (index, record) in comparison.records.iter_mut().enumerate() {
        record.name = HOSTILE[index % 4].into();
    }
    for (index, stage) in comparison.stages.iter_mut().enumerate() {
        stage.name = HOSTILE[(index + 1) % 4].into();
        stage.parameters[0].path = HOSTILE[(index + 2) % 4].into();
        stage.records[index] = failed(HOSTILE[index]);
    }
    for record in 0..comparison.records.len() {
        for channel in &mut comparison.records[record].channels {
            if channel.name == "force" {
                channel.name = HOSTILE[1].into();
            }
        }
        for stage in &mut comparison.stages {
            stage.records[record].channels.iter_mut().for_each(|channel| channel.name = HOSTILE[1].into());
        }
    }
    comparison
}
