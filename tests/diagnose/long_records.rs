//! Long records, of which the search sees one sample of several: what is told is fitted to all of them.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Verdict, diagnose};
use stickslip::model::Model;

const STIFFNESS: f64 = 2e6;
const LIMIT: f64 = 50.0;
const BESIDE: f64 = 2e5;
const SAMPLES: usize = 20_000;
const NOISE: f64 = 0.1;

/// A slider with a spring beside it under cycles of 500 samples that grow to `amplitude` (m).
fn record(index: usize, amplitude: f64, noise: &mut impl FnMut() -> f64) -> Record {
    let time: Vec<f64> = (0..SAMPLES).map(|i| 1e-4 * i as f64).collect();
    let grown = |t: f64| 0.2 + 0.8 * t / (1e-4 * SAMPLES as f64);
    let motion: Vec<f64> = time.iter().map(|t| amplitude * (TAU * 20.0 * t).sin() * grown(*t)).collect();
    let (mut slider, mut before) = (0.0_f64, 0.0);
    let mut force = |displacement: &f64| {
        slider = (slider + STIFFNESS * (displacement - before)).clamp(-LIMIT, LIMIT);
        before = *displacement;
        slider + BESIDE * displacement + NOISE * noise()
    };
    let force = motion.iter().map(&mut force).collect();
    let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
    let channels =
        vec![channel("time", "s", time), channel("displacement", "m", motion), channel("force", "N", force)];
    Record { name: format!("level {index}"), regime: Regime::FromRest, use_for: None, channels }
}

#[test]
fn the_numbers_told_are_those_of_all_samples() {
    let mut numbers = fastrand::Rng::with_seed(1);
    let mut noise = move || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0;
    let records = (0..6).map(|index| record(index, 2e-5 * (1 + index) as f64, &mut noise)).collect();
    let dataset = Dataset { title: None, records };
    let given = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                 tangential_stiffness = 1.9e6\nfriction_coefficient = 0.52\nnormal_load = 100.0\n";
    let given = Model::parse(given).unwrap();
    let found = diagnose(&given, &dataset, &DiagnoseOptions::default(), DiagnoseWatch::default()).unwrap();
    assert_eq!((found.verdict, &found.effects[..]), (Verdict::EffectFound, &["residual_stiffness"][..]));
    assert!(found.cost.fitted_samples < found.cost.samples, "{:?}", found.cost);
    for (name, truth) in [
        ("contact.tangential_stiffness", STIFFNESS),
        ("contact.friction_coefficient", LIMIT / 100.0),
        ("effect.1.residual_stiffness", BESIDE),
    ] {
        let told = found.parameters.iter().find(|one| one.name == name).unwrap_or_else(|| {
            panic!("no {name} in {:?}", found.parameters);
        });
        let deviation = (told.high.unwrap() - told.low.unwrap()) / (2.0 * 1.96);
        let off = (told.value - truth) / deviation;
        assert!(off.abs() < 3.0, "{name}: {} for {truth}, {off} deviations off", told.value);
    }
}
