//! Effects that look alike, and the experiment that tells them apart.

use super::diagnosis::{Confounding, Group};

/// Correlation from which a pair is worth a line in the report.
pub(super) const ALIKE: f64 = 0.9;

/// Notes a correlation; of several places of the same pair the strongest.
pub(super) fn note(found: &mut Vec<Confounding>, effects: [&'static str; 2], correlation: f64) {
    if effects[0] == effects[1] {
        return;
    }
    match found.iter_mut().find(|known| known.effects == effects) {
        Some(known) if known.correlation.abs() < correlation.abs() => known.correlation = correlation,
        Some(_) => {}
        None => found.push(Confounding { effects, correlation }),
    }
}

/// What separates a pair; either order.
const EXPERIMENTS: &[(&str, &str, &str)] = &[
    (
        "asymmetry",
        "sensor_offset",
        "start a record from rest at a low level, where nothing slips: a shifted zero is there at once, an asymmetric \
         limit is not; or turn the part round, and the asymmetry changes sides",
    ),
    (
        "contact_damping",
        "sensor_delay",
        "repeat one level at two frequencies far apart: a delay's share of the force grows with the stiffness, a \
         damper's does not; or swap the sensors, and the delay stays with the channel",
    ),
    (
        "contact_damping",
        "quadratic_damping",
        "repeat one frequency at two levels: a damper's force grows with the speed, drag with its square",
    ),
    (
        "contact_damping",
        "velocity_weakening",
        "repeat one amplitude at speeds over two decades and plot the height of the loop against the logarithm of \
         the speed: weakening levels off, a damper does not",
    ),
    (
        "micro_slip",
        "backlash",
        "move the joint slowly around zero at the lowest level: within a play there is no force at all, with gradual \
         slip there is the full stiffness",
    ),
    (
        "residual_stiffness",
        "stiffening",
        "slip farther than in any record so far: a straight plateau means a spring, a bent one a stiffening contact",
    ),
    (
        "geometric_stiffening",
        "stiffening",
        "measure a second mode, or lift the contact off: the stiffening of the structure stays",
    ),
    (
        "added_mass",
        "support_compliance",
        "measure a second mode: an added mass matters where the mode moves, a soft clamp where it bends",
    ),
    (
        "added_mass",
        "sensor_gain",
        "fix a known mass beside the sensor: the frequencies must move as they should, whatever the sensor shows",
    ),
    (
        "wear",
        "velocity_weakening",
        "repeat the first record at the end: wear stays, weakening comes and goes with the speed",
    ),
    (
        "normal_load_variation",
        "asymmetry",
        "change the phase between normal load and motion, or hold the load constant",
    ),
];

/// What separates two kinds of effect where the table has no pair.
fn general(effect: &str) -> &'static str {
    match effect {
        "sensor_gain" | "sensor_offset" | "sensor_delay" => {
            "calibrate the sensor, or swap it with another: a fault of the measurement stays with the channel"
        }
        "wear" => "repeat the first record at the end of the test: what has worn stays worn",
        "normal_load_variation" => "repeat the test under another normal load",
        "velocity_weakening" | "contact_damping" => {
            "repeat one level at a frequency ten times lower and higher"
        }
        "geometric_stiffening" | "stiffening" | "quadratic_damping" => {
            "repeat the test at half of the lowest and twice the highest level"
        }
        "added_mass" | "support_compliance" | "hanging_mass" => {
            "excite a second mode and compare how far each resonance is off"
        }
        "normal_hardening" | "impact_damping" => "move the contact in the normal direction at two speeds",
        _ => "repeat the test at a lower level, from rest, and at a higher one",
    }
}

/// The experiment that separates `effects`.
pub(super) fn experiment(effects: &[&str]) -> String {
    let mut sentences: Vec<&str> = Vec::new();
    for (index, first) in effects.iter().enumerate() {
        for second in &effects[..index] {
            let pair = EXPERIMENTS
                .iter()
                .find(|(a, b, _)| (a == first && b == second) || (a == second && b == first))
                .map(|(_, _, text)| *text);
            let sentence = pair.unwrap_or_else(|| general(second));
            if !sentences.contains(&sentence) {
                sentences.push(sentence);
            }
        }
    }
    let mut text = sentences.join("; ");
    if let Some(first) = text.get(..1) {
        let upper = first.to_uppercase();
        text.replace_range(..1, &upper);
    }
    text
}

/// A group of tied effects, best first.
pub(super) fn group(effects: Vec<&'static str>) -> Group {
    let experiment = experiment(&effects);
    let reason = format!(
        "with each of them the records that choose are predicted equally well, to within one standard error ({})",
        effects.join(", ")
    );
    Group { effects, reason, experiment }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::{CATALOGUE, find};

    #[test]
    fn the_table_names_effects_and_either_order_finds_a_sentence() {
        for (a, b, text) in EXPERIMENTS {
            assert!(find(a).is_some() && find(b).is_some(), "{a} {b}");
            assert_eq!(experiment(&[a, b]), experiment(&[b, a]));
            assert_eq!(experiment(&[a, b]).to_lowercase(), text.to_lowercase());
        }
    }

    #[test]
    fn every_pair_has_an_experiment() {
        for first in CATALOGUE {
            for second in CATALOGUE {
                assert!(first == second || experiment(&[first.id, second.id]).len() > 20);
            }
        }
    }
}
