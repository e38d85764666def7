//! What a diagnosis with the whole catalogue finds on the pin rig: records of the dual-mode test on a rig that has an effect,
//! and the model that lacks it. Prints a table; a case takes about seven minutes on two cores.
//!
//! `cargo run --release -p stickslip --example slip_slap_diagnosis [NAME]` runs the cases whose names hold NAME.

use std::error::Error;
use stickslip::data::Dataset;
use stickslip::diagnose::{DiagnoseOptions, DiagnoseWatch, Diagnosis, diagnose};
use stickslip::model::Model;
use stickslip::rig::{ChannelFault, DualMode, NoiseLevel, Plan, Test, TestKind, test_on};

const SENSORS: [f64; 3] = [0.55, 0.3, 0.05];
/// Amplitudes of the first and the third harmonic (m/s²), up to the highest that were published.
const LEVELS: [[f64; 2]; 6] =
    [[8.0, 20.0], [10.4, 26.0], [12.8, 32.0], [15.2, 38.0], [17.6, 44.0], [20.0, 50.0]];
/// Noise of every channel, as a part of its root mean square.
const NOISE: f64 = 0.01;

/// What the rig has that the model lacks, as in `model.toml`; in the last the model alone is another.
const CASES: [(&str, &str); 6] = [
    ("nothing", ""),
    ("`impact_damping`", "id = \"impact_damping\"\nimpact_damping = 300.0\n"),
    ("`normal_hardening`", "id = \"normal_hardening\"\nnormal_cubic_stiffness = 5e19\n"),
    ("`normal_hardening`, a fifth of that", "id = \"normal_hardening\"\nnormal_cubic_stiffness = 1e19\n"),
    ("`hanging_mass`", "id = \"hanging_mass\"\nmass = 0.3\nhanging_frequency = 56.0\n"),
    ("a load that varies (`normal_load_variation`)", ""),
];

fn main() -> Result<(), Box<dyn Error>> {
    let only = std::env::args().nth(1).unwrap_or_default();
    println!(
        "| the rig has | verdict | with | as given | refitted | with it | noise |\n|---|---|---|---|---|---|---|"
    );
    for (name, effect) in CASES.into_iter().filter(|(name, _)| name.contains(&only)) {
        println!("{}", told(name, &diagnosed(effect, name.starts_with("a load"))?));
    }
    Ok(())
}

/// The example's rig with `effect`; its contact under a constant load or under what presses it.
fn model(effect: &str, constant_load: bool) -> Result<Model, Box<dyn Error>> {
    let example = include_str!("slip-slap/model.toml");
    let plain = example.split("[[effect]]").next().unwrap_or(example);
    let law = if constant_load { "" } else { "normal_law = \"linear\"" };
    let text = plain
        .replace("law = \"jenkins\"", "law = \"valanis\"\nsmoothness = 0.3")
        .replace("normal_law = \"hertz\"", law)
        .lines()
        .filter(|line| !line.starts_with("normal_exponent") && !line.starts_with("impact_damping"))
        .fold(String::new(), |text, line| text + line + "\n");
    let added = if effect.is_empty() { String::new() } else { format!("[[effect]]\n{effect}") };
    Ok(Model::parse(&(text + &added))?)
}

/// The diagnosis of the model without `effect`, by records of the rig with it.
fn diagnosed(effect: &str, constant_load: bool) -> Result<Diagnosis, Box<dyn Error>> {
    let mut plan = Plan::of_sensors(&SENSORS);
    let fault = ChannelFault { noise: NoiseLevel::Fraction(NOISE), ..ChannelFault::default() };
    plan.chain.excitation = fault;
    plan.chain.accelerometers = vec![fault; SENSORS.len()];
    plan.chain.noise_told = true;
    let test = DualMode { periods: 2, ..DualMode::at(52.0, LEVELS.to_vec()) };
    plan.tests.push(Test { name: "level".into(), use_for: None, kind: TestKind::DualMode(test) });
    let records = test_on(&model(effect, false)?, &plan, &mut |_| true)?;
    let dataset = Dataset { title: None, records };
    let watch = DiagnoseWatch::default();
    Ok(diagnose(&model("", constant_load)?, &dataset, &DiagnoseOptions::default(), watch)?)
}

/// A row of the table.
fn told(name: &str, found: &Diagnosis) -> String {
    let brought = found.parameters.iter().filter(|parameter| parameter.name.starts_with("effect."));
    let mut with: Vec<String> = found.effects.iter().map(|effect| format!("`{effect}`")).collect();
    for number in brought.filter(|_| !found.effects.is_empty()) {
        let short = number.name.rsplit('.').next().unwrap_or_default();
        let interval = number.low.zip(number.high).map(|(low, high)| format!(" ({low:.4e} … {high:.4e})"));
        with.push(format!("{short} {:.4e}{}", number.value, interval.unwrap_or_default()));
    }
    let with = if with.is_empty() { "–".to_owned() } else { with.join(", ") };
    let error = &found.error;
    // Errors of the test records, but as given.
    format!(
        "| {name} | {} | {with} | {:.4} | {:.4} | {:.4} | {:.4} |",
        found.verdict.id(),
        error.baseline,
        error.test_refitted,
        error.test,
        error.test_noise_floor.unwrap_or(f64::NAN)
    )
}
