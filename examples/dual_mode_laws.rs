//! Every law of the catalogue under the published dual-mode test: the tones of the force (N) that hold both accelerations, as a
//! table of `docs/validation.md`.
//!
//! `cargo run --release -p stickslip --example dual_mode_laws`

use std::error::Error;
use std::f64::consts::TAU;

use stickslip::contact::{LAWS, LawKind, LawParameter};
use stickslip::harmonic::{Assembly, CurveSettings, HeldTone, dual_tone_response};
use stickslip::model::Model;
use stickslip::vocabulary::Scale;

const STIFFNESS: f64 = 3.95e6;
const LEVELS: [[f64; 2]; 3] = [[14.0, 34.0], [17.5, 42.5], [20.0, 50.0]];
const NORMAL: [(&str, &str); 4] = [
    ("constant load", ""),
    ("linear", "normal_law = \"linear\"\n"),
    ("cubic", "normal_law = \"cubic\"\nnormal_cubic_stiffness = 1e18\n"),
    ("hertz", "normal_law = \"hertz\"\nimpact_damping = 30.0\n"),
];

/// The keys of a law, each of its own parameters in the middle of what a fit may try.
fn keys(law: &LawKind) -> String {
    let middle = |parameter: &LawParameter| {
        let (low, high, scale) = (parameter.range)(STIFFNESS);
        let value = if scale == Scale::Logarithmic { (low * high).sqrt() } else { 0.5 * (low + high) };
        format!("{} = {value:?}\n", parameter.quantity.name)
    };
    format!("law = \"{}\"\n{}", law.name, law.parameters.iter().map(middle).collect::<String>())
}

fn main() -> Result<(), Box<dyn Error>> {
    let example = include_str!("slip-slap/model.toml");
    let rig = &example[..example.find("[contact]").ok_or("the example has no contact")?];
    let many = "[[effect]]\nid = \"micro_slip\"\nspread = 1.0\n";
    let mut laws: Vec<(String, String, &str)> =
        LAWS.iter().map(|law| (law.name.to_owned(), keys(law), "")).collect();
    laws.insert(1, ("jenkins, micro_slip".to_owned(), keys(LAWS[0]), many));
    println!(
        "| law | normal direction | F1, F3 (N) at 14, 34 m/s² | at 17.5, 42.5 | at 20, 50 |\n|---|---|---|---|---|"
    );
    for (name, law, effect) in &laws {
        for (normal, direction) in NORMAL {
            let numbers = "friction_coefficient = 0.6\nnormal_load = 68.67\nnormal_stiffness = 2.37e7\n";
            let text = format!(
                "{rig}[contact]\n{law}tangential_stiffness = {STIFFNESS:?}\n{numbers}{direction}{effect}"
            );
            let assembly = Assembly::new(Model::parse(&text)?.system()?);
            let settings = CurveSettings { harmonics: 15, ..CurveSettings::default() };
            let held = LEVELS.map(|[first, third]| {
                let tone = |order, amplitude| HeldTone { order, amplitude, phase: 0.0 };
                let (node, tones) = (assembly.nodes().len() - 1, [tone(1, first), tone(3, third)]);
                match dual_tone_response(&assembly, TAU * 52.0, node, tones, &settings) {
                    Ok(found) => format!("{:.3}, {:.3}", found.force[0], found.force[1]),
                    Err(error) => error.to_string(),
                }
            });
            println!("| {name} | {normal} | {} |", held.join(" | "));
        }
    }
    Ok(())
}
