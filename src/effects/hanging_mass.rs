//! A mass that hangs at the contact and vibrates (string and weights).

use super::{
    Effect, EffectParameter, InTables, Kind, Needs, Part, PlaceKind, Scales, experiments, magnitudes,
};
use crate::system::HangingMass;
use crate::vocabulary as v;

/// Ratio of frequencies to start from: what a resonator does is narrow, and a fit finds its frequency only from nearby.
const STEP: f64 = 1.1;
/// Steps beyond the drives' frequencies: the farther away, the less it matters how far.
const BEYOND: [i32; 9] = [1, 2, 3, 4, 5, 6, 8, 10, 12];
/// Steps between the drives' frequencies at most; wider ones where they are farther apart.
const BETWEEN: f64 = 24.0;

/// The farthest above the drives' frequencies: what a resonator does differs there by a hundredth, `1/FARTHEST²`, from what a mass
/// does that is fixed.
const FARTHEST: f64 = 10.0;

/// The drives' lowest and highest frequency (Hz).
fn drives(scales: &Scales) -> (f64, f64) {
    (scales.lowest_frequency.min(scales.frequency), scales.frequency)
}

/// Frequencies to start from (Hz), between those of the drives and beyond, the first the highest of the drives.
fn frequencies(scales: &Scales) -> Vec<f64> {
    let (low, high) = drives(scales);
    let apart = (high / low).ln();
    let step = STEP.ln().max(apart / BETWEEN);
    let steps = (apart / step).round();
    let between = (0..=steps as i32).map(|k| high * (-f64::from(k) * step).exp());
    let lowest = high * (-steps * step).exp();
    let beyond = BEYOND.iter().flat_map(|k| [high * STEP.powi(*k), lowest / STEP.powi(*k)]);
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
                let (low, high) = drives(scales);
                magnitudes(0.05 * low, FARTHEST * high, &frequencies(scales))
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

    /// In order.
    fn of(lowest_frequency: f64, frequency: f64) -> Vec<f64> {
        let mut of = frequencies(&Scales { frequency, lowest_frequency, ..Scales::default() });
        of.sort_by(f64::total_cmp);
        of
    }

    #[test]
    fn frequencies_are_close_between_the_drives_and_near_them_and_reach_far_beyond() {
        let is_near = |ratio: f64, of: f64| (ratio / of - 1.0).abs() < 1e-12;
        let (one, two) = (of(50.0, 50.0), of(50.0, 50.0 * STEP.powi(12)));
        assert_eq!((one.len(), one[9], two.len()), (19, 50.0, 31));
        for (found, low, high) in [(&one, 50.0, 50.0), (&two, 50.0, 50.0 * STEP.powi(12))] {
            let near = &found[3..found.len() - 3];
            assert!(near.windows(2).all(|pair| is_near(pair[1] / pair[0], STEP)));
            assert!(
                is_near(low / found[0], STEP.powi(12))
                    && is_near(found[found.len() - 1] / high, STEP.powi(12))
            );
        }
        // Drives that differ by rounding, or by little, are one.
        assert_eq!(of(50.0, 50.0 * (1.0 + 1e-15)).len(), 19);
        assert_eq!(of(49.9, 50.1).len(), 19);
        // However far apart, not too many.
        assert_eq!(of(1.0, 1e4).len(), 43);
    }

    #[test]
    fn the_range_of_frequencies_holds_what_it_starts_from() {
        for (lowest_frequency, frequency) in [(50.0, 160.0), (1.0, 0.02), (1.0, 50.0)] {
            let scales = Scales { frequency, lowest_frequency, ..Scales::default() };
            let range = (EFFECT.parameters[1].range)(&scales);
            assert!(range.starts.iter().all(|start| range.lower < *start && *start < range.upper));
        }
    }
}
