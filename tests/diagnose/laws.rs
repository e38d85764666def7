//! Gradual slip under a model with one slider: the effect is named, then the law that describes it, whose numbers are those
//! that made the data. The data come from the laws' differential equations, in steps a fortieth of the samples'.

use std::f64::consts::TAU;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Verdict, add, diagnose};
use stickslip::effects;
use stickslip::model::Model;

const STIFFNESS: f64 = 5e6;
const LIMIT: f64 = 72.0;
const SAMPLES: usize = 500;
const NOISE: f64 = 0.4;

fn model() -> Model {
    let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                tangential_stiffness = 4.5e6\nfriction_coefficient = 0.47\nnormal_load = 160.0\n";
    Model::parse(text).unwrap()
}

/// `dT/du` over the stiffness, of the force over the limit, for a direction.
type Slope = fn(f64, f64) -> f64;

fn forces(slope: Slope, motion: &[f64]) -> Vec<f64> {
    let (steps, mut force) = (40, 0.0_f64);
    let mut forces = vec![0.0];
    for pair in motion.windows(2) {
        let step = (pair[1] - pair[0]) / f64::from(steps) * STIFFNESS / LIMIT;
        for _ in 0..steps {
            let middle = force + 0.5 * step * slope(force, step.signum());
            force += step * slope(middle, step.signum());
        }
        forces.push(LIMIT * force);
    }
    forces
}

fn dataset(slope: Slope) -> Dataset {
    let mut numbers = fastrand::Rng::with_seed(11).fork();
    let mut noise = move || NOISE * ((0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0);
    let mut record = |(index, level): (usize, &f64)| {
        let time: Vec<f64> = (0..SAMPLES).map(|i| 1e-3 * i as f64).collect();
        let amplitude = level * LIMIT / STIFFNESS;
        let at = |t: &f64| amplitude * ((TAU * 7.0 * t).sin() + 0.4 * (TAU * 17.0 * t).sin());
        let motion: Vec<f64> = time.iter().map(at).collect();
        let force = forces(slope, &motion).iter().map(|force| force + noise()).collect();
        let channel = |name: &str, unit, values, noise| Channel { name: name.into(), unit, values, noise };
        let channels = vec![
            channel("time", "s", time, None),
            channel("displacement", "m", motion, None),
            channel("force", "N", force, Some(NOISE)),
        ];
        Record { name: format!("level {index}"), regime: Regime::FromRest, use_for: None, channels }
    };
    let levels = [0.6, 1.0, 1.5, 2.5, 4.0, 6.0];
    Dataset { title: None, records: levels.iter().enumerate().map(&mut record).collect() }
}

/// Checks that `slope` is called micro-slip and described by `law`, whose `parameter` is `value` within its interval.
fn described(slope: Slope, law: &str, parameter: &str, value: f64) {
    let dataset = dataset(slope);
    let found = diagnose(&model(), &dataset, &DiagnoseOptions::default(), DiagnoseWatch::default()).unwrap();
    assert_eq!(
        (found.verdict, &found.effects[..]),
        (Verdict::EffectFound, &["micro_slip"][..]),
        "{:#?}",
        found.reasons
    );
    assert_eq!(found.law, Some(law));
    let path = format!("contact.{parameter}");
    let told = found.parameters.iter().find(|one| one.name == path).unwrap();
    let (low, high) = (told.low.unwrap(), told.high.unwrap());
    let wide = 0.5 * (high - low);
    assert!((low - wide..=high + wide).contains(&value), "{low} … {high} for {value}");
    assert!(found.error.test < 1.05 * found.error.noise_floor.unwrap(), "{:?}", found.error);

    let effect = effects::find("micro_slip").unwrap();
    let added = add(&model(), effect, None, &dataset, DiagnoseWatch::default()).unwrap();
    let contact = added.model.contact.unwrap();
    assert_eq!((contact.law.kind.name, added.model.effects.len()), (law, 0));
    let again = Model::parse(&added.model.to_toml()).unwrap();
    assert_eq!(again.contact, added.model.contact);
}

#[test]
fn valanis_law_describes_its_own_data() {
    described(|force, sign| (1.0 - sign * force) / (1.0 - 0.4 * sign * force), "valanis", "smoothness", 0.4);
}

/// Dahl's law with an exponent of one is that of Valanis with a smoothness of zero.
#[test]
fn valanis_law_describes_dahl_data() {
    described(|force, sign| 1.0 - sign * force, "valanis", "smoothness", 0.0);
}

#[test]
fn bouc_and_wen_describe_their_own_data() {
    let slope = |force: f64, sign: f64| if sign * force > 0.0 { 1.0 - force.abs().powi(3) } else { 1.0 };
    described(slope, "bouc_wen", "sharpness", 3.0);
}
