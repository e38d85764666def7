//! Every law of the catalogue under the published dual-mode test: the tones of the force (N) that hold both accelerations, as the
//! table of `benches/dual-mode-laws.md`.
//!
//! `cargo run --release -p stickslip --example dual_mode_laws`

use std::error::Error;
use std::f64::consts::TAU;

use stickslip::harmonic::{Assembly, CurveSettings, HeldTone, dual_tone_response};
use stickslip::model::Model;

const LEVELS: [[f64; 2]; 3] = [[14.0, 34.0], [17.5, 42.5], [20.0, 50.0]];
const NUMBERS: &str = "tangential_stiffness = 3.95e6\nfriction_coefficient = 0.6\nnormal_load = 68.67\nnormal_stiffness = 2.37e7\n";
const NORMAL: [(&str, &str); 4] = [
    ("constant load", ""),
    ("linear", "normal_law = \"linear\"\n"),
    ("cubic", "normal_law = \"cubic\"\nnormal_cubic_stiffness = 1e18\n"),
    ("hertz", "normal_law = \"hertz\"\nimpact_damping = 30.0\n"),
];

/// Laws with numbers of their own, and an effect.
fn laws() -> Vec<(&'static str, String, &'static str)> {
    let plain = |name, keys: &str| (name, format!("{keys}\n"), "");
    let measured: String = (1..=11).map(|knot| format!("slope_kept_{knot} = 0.8\n")).collect();
    let many = |name, effect| (name, "law = \"jenkins\"\n".to_owned(), effect);
    vec![
        plain("jenkins", "law = \"jenkins\""),
        many("jenkins, micro_slip 0.5", "[[effect]]\nid = \"micro_slip\"\nspread = 0.5\n"),
        many("jenkins, micro_slip 1", "[[effect]]\nid = \"micro_slip\"\nspread = 1.0\n"),
        plain("valanis 0.3", "law = \"valanis\"\nsmoothness = 0.3"),
        plain("valanis 0.95", "law = \"valanis\"\nsmoothness = 0.95"),
        plain("iwan −0.5, 1", "law = \"iwan\"\nexponent = -0.5\nratio = 1.0"),
        plain("bouc_wen 2", "law = \"bouc_wen\"\nsharpness = 2.0"),
        plain("bouc_wen 20", "law = \"bouc_wen\"\nsharpness = 20.0"),
        plain("measured", &format!("law = \"measured\"\n{measured}")),
    ]
}

fn main() -> Result<(), Box<dyn Error>> {
    let example = include_str!("slip-slap/model.toml");
    let rig = &example[..example.find("[contact]").ok_or("the example has no contact")?];
    println!("| law | normal direction | F1, F3 (N) at 14, 34 m/s² | at 17.5, 42.5 | at 20, 50 |");
    println!("|---|---|---|---|---|");
    for (name, law, effect) in &laws() {
        for (normal, direction) in NORMAL {
            let text = format!("{rig}[contact]\n{law}{NUMBERS}{direction}{effect}");
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
