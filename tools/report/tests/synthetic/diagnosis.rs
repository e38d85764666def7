//! Diagnoses of every verdict, to look at and to test with.

use stickslip::data::Use;
use stickslip::diagnose::{
    Agreement, Candidate, Comparison, Confounding, Cost, Detectable, DiagnoseOptions, Diagnosis, Errors,
    Estimate, Evidence, Group, Noise, NoiseSource, Step, Untried, Verdict,
};
use stickslip::effects::CATALOGUE;
use stickslip::fit::residual::appearance;
use stickslip::model::Model;
use stickslip_report::diagnosis::Run;

use super::{channel, contact, noise, result, stage};

pub const MODEL: &str = r#"
schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 5.1e6
friction_coefficient = 0.47
normal_load = 162.0
"#;

pub fn run() -> Run {
    Run {
        model: "model.toml".into(),
        dataset: "data".into(),
        written: None,
        options: DiagnoseOptions::default(),
        seconds: 1.9,
        interrupted: false,
    }
}

/// The diagnosis called so on the command line of the example.
pub fn called(name: &str) -> Option<(Diagnosis, Run)> {
    let diagnosis = match name {
        "found" => found(),
        "group" => group(),
        "unexplained" => unexplained(),
        "nothing" => nothing(),
        "insufficient" => insufficient(),
        "large" => large(),
        _ => return None,
    };
    Some((diagnosis, run()))
}

fn estimate(name: &str, value: f64, spread: f64, unit: &'static str) -> Estimate {
    Estimate { name: name.into(), value, low: Some(value - spread), high: Some(value + spread), unit }
}

fn candidate(
    effects: &[&'static str],
    error: f64,
    gain_z: f64,
    gain_fraction: f64,
    parameters: Vec<Estimate>,
) -> Candidate {
    Candidate {
        effects: effects.to_vec(),
        law: None,
        location: None,
        error,
        gain_z,
        gain_fraction,
        parameters,
        evaluations: 57,
    }
}

fn candidates() -> Vec<Candidate> {
    let mut all = vec![
        candidate(
            &["residual_stiffness"],
            0.021,
            41.2,
            0.991,
            vec![estimate("residual_stiffness", 4.02e5, 6e3, "N/m")],
        ),
        candidate(
            &["stiffening"],
            0.12,
            14.0,
            0.61,
            vec![estimate("cubic_stiffness", 8.1e13, 9e12, "N/m^3")],
        ),
        candidate(
            &["velocity_weakening"],
            0.31,
            4.4,
            0.12,
            vec![
                estimate("weakening", -0.21, 0.05, "1"),
                Estimate { low: None, high: None, ..estimate("weakening_velocity", 1e-3, 0.0, "m/s") },
            ],
        ),
        candidate(&["wear"], 0.378, 0.6, 0.01, vec![estimate("rate", 0.8, 1.6, "1/m")]),
        candidate(&["asymmetry"], 0.381, -1.2, -0.02, vec![estimate("asymmetry", 0.01, 0.02, "1")]),
        candidate(&["backlash"], 0.39, -2.4, -0.05, vec![estimate("half_gap", 1.2e-7, 9e-8, "m")]),
        Candidate {
            law: None,
            location: Some("force".into()),
            ..candidate(&["sensor_offset"], 0.38, -0.4, -0.001, vec![estimate("bias", 0.02, 0.05, "N")])
        },
    ];
    all.push(candidate(&["micro_slip"], 0.38, 0.0, 0.0, vec![]));
    all
}

fn confounding() -> Vec<Confounding> {
    let ids: Vec<&'static str> =
        candidates().iter().filter(|one| !one.parameters.is_empty()).map(|one| one.effects[0]).collect();
    let mut random = noise(7);
    let mut all = Vec::new();
    for (index, &one) in ids.iter().enumerate() {
        for &other in &ids[..index] {
            let close = [one, other] == ["stiffening", "residual_stiffness"];
            let correlation = if close { 0.93 } else { 0.8 * random() };
            all.push(Confounding { effects: [one, other], correlation });
        }
    }
    all
}

/// A spring beside the contact was missing.
pub fn found() -> Diagnosis {
    of(contact(1_200))
}

fn of(comparison: Comparison) -> Diagnosis {
    let records = comparison.records.len();
    let split: Vec<Use> =
        (0..records).map(|i| [Use::Fit, Use::Fit, Use::Select, Use::Confirm][i % 4]).collect();
    let errors: Vec<f64> = comparison.stages.iter().map(|stage| stage.error).collect();
    let (&baseline, &last) = (errors.first().unwrap(), errors.last().unwrap());
    let sources = [NoiseSource::Stated, NoiseSource::Periods, NoiseSource::Repeats, NoiseSource::Carried];
    Diagnosis {
        verdict: Verdict::EffectFound,
        probability: 0.998,
        noise_is_known: true,
        law: None,
        reasons: vec![
            "With residual stiffness the error on the selecting records falls to the noise; every other single effect \
             leaves at least six times as much."
                .into(),
            "The fall is seen in every block of the selecting records (z = 41)."
                .into(),
        ],
        effects: vec!["residual_stiffness"],
        surrogates: vec![],
        groups: vec![],
        error: Errors {
            baseline,
            refitted: errors[1.min(errors.len() - 1)],
            last,
            test: 0.011,
            test_refitted: 0.32,
            noise_floor: Some(0.01),
            test_noise_floor: Some(0.0102),
        },
        chi_square: Some(1.04),
        steps: vec![Step {
            added: vec!["residual_stiffness"],
            error: 0.021,
            gain_z: 41.2,
            gain_fraction: 0.991,
        }],
        candidates: candidates(),
        parameters: candidates().remove(0).parameters,
        rounds: vec![candidates().split_off(3)],
        untried: vec![
            Untried { effect: "normal_hardening", reason: "no record has a normal displacement".into() },
            Untried { effect: "added_mass", reason: "a bare contact has no structure".into() },
        ],
        confounding: confounding(),
        detectable: CATALOGUE
            .iter()
            .take(9)
            .map(|effect| Detectable {
                effect: effect.id,
                parameter: effect.parameters[0].quantity.name,
                value: (effect.id != "wear").then_some(0.012_345),
                unit: effect.parameters[0].quantity.unit,
                relevant: (effect.id != "wear").then_some(0.03),
            })
            .collect(),
        evidence: vec![Evidence {
            effect: "residual_stiffness",
            seen: "in slip the measured force goes on rising with 8 % of the slope in stick (loop, residual against \
                   displacement)"
                .into(),
            otherwise: Some("a stop that is reached at large displacement would rise late and steeply instead".into()),
        }],
        residual: comparison.stages.last().map(|stage| appearance(&comparison.records, stage)).unwrap_or_default(),
        next_experiment: None,
        split,
        skipped: vec![],
        noise: (0..records)
            .map(|record| Noise {
                record,
                channel: "force".into(),
                deviation: Some(0.52),
                log_error: 0.0,
                source: sources[record % 4],
            })
            .collect(),
        comparison,
        model: Model::parse(MODEL).unwrap(),
        agreement: Agreement { starts: 2, agreeing: 2 },
        cost: Cost { refits: 34, simulations: 19_200, samples: 9600, fitted_samples: 9600 },
    }
}

pub fn group() -> Diagnosis {
    Diagnosis {
        verdict: Verdict::NotDistinguishable,
        effects: vec![],
        groups: vec![Group {
            effects: vec!["asymmetry", "sensor_offset"],
            reason: "with an unknown state at the start a limit that depends on direction and an offset of the force are \
                     the same thing"
                .into(),
            experiment: "Record one start from rest: the first rise then shows the zero of the load cell.".into(),
        }],
        evidence: vec![],
        next_experiment: Some("Record one start from rest: the first rise then shows the zero of the load cell.".into()),
        ..found()
    }
}

/// Friction that depends on the position, which the catalogue does not have.
pub fn unexplained() -> Diagnosis {
    let mut comparison = contact(1_200);
    for (index, record) in comparison.records.iter_mut().enumerate() {
        let motion = record.channel("displacement").unwrap().values.clone();
        let force = record.channels.iter_mut().find(|channel| channel.name == "force").unwrap();
        for (value, u) in force.values.iter_mut().zip(&motion) {
            *value += 12.0 * (u / 1e-5).sin();
        }
        let force = force.clone();
        for stage in &mut comparison.stages {
            let predicted = stage.records[index].channels[0].predicted.clone();
            stage.records[index] = result(&force, predicted);
        }
    }
    Diagnosis {
        verdict: Verdict::Unexplained,
        effects: vec![],
        surrogates: vec!["residual_stiffness"],
        chi_square: Some(23.0),
        next_experiment: None,
        error: Errors { noise_floor: None, test_noise_floor: None, test: 0.21, ..found().error },
        ..of(comparison)
    }
}

pub fn nothing() -> Diagnosis {
    let mut comparison = contact(1_200);
    comparison.stages.truncate(2);
    Diagnosis {
        verdict: Verdict::NothingMissing,
        effects: vec![],
        steps: vec![],
        evidence: vec![],
        reasons: vec![
            "The residual is as large as the noise and white against displacement, velocity and time.".into(),
        ],
        ..of(comparison)
    }
}

/// Nothing is known, and no number is finite.
pub fn insufficient() -> Diagnosis {
    let mut comparison = contact(40);
    comparison.records.truncate(1);
    comparison.stages.truncate(1);
    comparison.stages[0].records.truncate(1);
    Diagnosis {
        verdict: Verdict::InsufficientData,
        probability: f64::NAN,
        noise_is_known: false,
        law: None,
        reasons: vec!["There is one record, and nothing is left to choose by.".into()],
        effects: vec![],
        steps: vec![],
        candidates: vec![],
        parameters: vec![],
        rounds: vec![],
        confounding: vec![],
        detectable: vec![],
        evidence: vec![],
        error: Errors {
            baseline: 0.4,
            refitted: f64::NAN,
            last: f64::INFINITY,
            test: f64::NAN,
            test_refitted: f64::NAN,
            noise_floor: None,
            test_noise_floor: None,
        },
        chi_square: None,
        ..of(comparison)
    }
}

/// Eight records of 2 400 samples in three channels, four stages.
pub fn large() -> Diagnosis {
    let mut records = Vec::new();
    let mut all = vec![Vec::new(); 4];
    for index in 0..8_u32 {
        let mut random = noise(u64::from(index) + 1);
        let time: Vec<f64> = (0..2_400).map(|i| f64::from(i) / 2_400.0).collect();
        let excitation: Vec<f64> = time.iter().map(|t| (200.0 * t).sin() * f64::from(index + 1)).collect();
        let places = ["acceleration:x=0.1", "acceleration:x=0.3", "acceleration:x=0.55"];
        let measured: Vec<_> = places
            .iter()
            .enumerate()
            .map(|(place, name)| {
                let size = 3.0 * (place + 1) as f64;
                let values = time.iter().map(|t| size * (200.0 * t + 0.3).sin() + 0.05 * random()).collect();
                channel(name, "m/s^2", values)
            })
            .collect();
        for (stage, results) in all.iter_mut().enumerate() {
            let mut random = noise(91 + stage as u64);
            let error = [1.0, 0.6, 0.3, 0.02][stage];
            let mut joined: Option<stickslip::diagnose::RecordResult> = None;
            for channel in &measured {
                let predicted = channel.values.iter().map(|value| value + error * random()).collect();
                let one = result(channel, predicted);
                match &mut joined {
                    None => joined = Some(one),
                    Some(joined) => joined.channels.extend(one.channels),
                }
            }
            results.push(joined.unwrap());
        }
        let mut channels = vec![channel("time", "s", time), channel("excitation", "N", excitation)];
        channels.extend(measured);
        let regime =
            if index % 2 == 0 { stickslip::data::Regime::Steady } else { stickslip::data::Regime::FromRest };
        records.push(stickslip::data::Record {
            name: format!("r{index}.csv"),
            regime,
            use_for: None,
            channels,
        });
    }
    let names = ["as given", "refitted", "+ micro-slip", "+ micro-slip + wear"];
    let stages = names.iter().zip(all).map(|(name, records)| stage(name, vec![], records, 12)).collect();
    of(Comparison {
        title: "Beam, eight records".into(),
        records,
        ring_downs: vec![],
        findings: vec![],
        notes: vec![],
        stages,
    })
}
