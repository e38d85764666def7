//! A mass that hangs at the contact and vibrates (string and weights).

use super::{
    Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, Scales, experiments, magnitudes,
};
use crate::system::HangingMass;
use crate::vocabulary as v;

/// Ratio of frequencies to start from: what a resonator does is narrow, and a fit finds its frequency only from nearby.
const STEP: f64 = 1.1;
/// Steps beyond the drives' frequencies: the farther away, the less it matters how far.
const BEYOND: [i32; 7] = [1, 2, 3, 4, 6, 9, 12];
/// Steps between the drives' frequencies at most; wider ones where they are farther apart.
const BETWEEN: f64 = 24.0;

/// Frequencies to start from (Hz), between those of the drives and beyond.
fn frequencies(scales: &Scales) -> Vec<f64> {
    let (low, high) = (scales.lowest_frequency.min(scales.frequency), scales.frequency);
    let steps = ((high / low).ln() / STEP.ln()).ceil().min(BETWEEN);
    let between = (0..=steps as i32).map(|k| high * (low / high).powf(f64::from(k) / steps.max(1.0)));
    let beyond = BEYOND.iter().flat_map(|k| [high * STEP.powi(*k), low / STEP.powi(*k)]);
    between.chain(beyond).collect()
}

pub(super) static EFFECT: Effect = Effect {
    id: "hanging_mass",
    title: "Hanging mass",
    summary: "A resonator hung at the contact: a mass on a string or a soft mount",
    explanation: "The weights that press the contact together hang on a string and move with it. Near the natural \
          frequency of these weights the response has a second, narrow resonance; far above it the weights hardly \
          move.",
    confirmation: "Change the length of the string: the narrow resonance moves with it.",
    confused_with: &[],
    next_experiment: experiments::SECOND_MODE,
    parameters: &[
        EffectParameter {
            quantity: &v::MASS,
            neutral: Some(0.0),
            range: |scales| {
                let mass = scales.structure_mass;
                magnitudes(1e-4 * mass, 10.0 * mass, &vec![0.01 * mass; frequencies(scales).len()])
            },
        },
        EffectParameter {
            quantity: &v::HANGING_FREQUENCY,
            neutral: None,
            range: |scales| {
                magnitudes(0.05 * scales.lowest_frequency, 20.0 * scales.frequency, &frequencies(scales))
            },
        },
    ],
    part: Part::HungAtContact,
    place: PlaceKind::Nowhere,
    kinds: &[Kind::Oscillator, Kind::Beam, Kind::PinRig],
    needs: Needs::Nothing,
    in_tables: InTables::Shown,
    apply: |values, _, changes| {
        changes.structure.hanging_masses.push(HangingMass { mass: values[0], frequency: values[1] });
    },
    signature: |seen| {
        seen.frequency_error.filter(|error| error.abs() > 0.001).map(|error| {
            format!("the resonances lie {:.1} % away from the model's at every level", 100.0 * error)
        })
    },
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_are_close_between_the_drives_and_near_them_and_reach_far_beyond() {
        let of = |lowest_frequency: f64, frequency: f64| {
            let mut of = frequencies(&Scales { frequency, lowest_frequency, ..Scales::default() });
            of.sort_by(f64::total_cmp);
            of
        };
        let one = of(50.0, 50.0);
        assert_eq!((one.len(), one[7]), (15, 50.0));
        let two = of(50.0, 160.0);
        let far = STEP.powi(12);
        assert!((two[0] * far / 50.0 - 1.0).abs() < 1e-12 && (two[27] / far / 160.0 - 1.0).abs() < 1e-12);
        let (near, rounding) = (two[3]..=two[24], 1e-12);
        let close = |pair: &[f64]| {
            pair[1] / pair[0] <= STEP + rounding || !near.contains(&pair[0]) || !near.contains(&pair[1])
        };
        assert!(two.len() == 28 && two.windows(2).all(close));
        // However far apart, not too many.
        assert_eq!(of(1.0, 1e4).len(), 39);
    }
}
