//! Tangents of the contact in two directions against differences, on random steps.

use stickslip::contact::{SlipSlap, SlipSlapInputs, SlipSlapTangents, SlipSlapWork};

use super::{History, frictions, motion, normals};

const INPUTS: usize = 4;

/// S, N and the next state from all that a step starts from: motion at its end, then the state.
fn outcome(contact: &SlipSlap, at: &[f64]) -> Vec<f64> {
    let (inputs, state) = at.split_at(INPUTS);
    let inputs = SlipSlapInputs { displacement: [inputs[0], inputs[1]], velocity: [inputs[2], inputs[3]] };
    let mut next = vec![0.0; state.len()];
    let response = contact.step(state, inputs, &mut next, &mut SlipSlapWork::default());
    response.force.into_iter().chain(next).collect()
}

/// Whether the derivative `analytic` lies between the differences to both sides, up to `tolerance`.
fn meets(analytic: f64, sides: [f64; 2], tolerance: f64) -> bool {
    let [low, high] = if sides[0] < sides[1] { sides } else { [sides[1], sides[0]] };
    analytic > low - tolerance && analytic < high + tolerance
}

/// How many derivatives of one step were compared, and of those how many do not meet the differences.
fn compare(contact: &SlipSlap, state: &[f64], inputs: SlipSlapInputs) -> (usize, usize) {
    let (mut tangents, mut work) = (SlipSlapTangents::default(), SlipSlapWork::default());
    let n = state.len();
    let response = contact.step_and_tangents(state, inputs, &mut vec![0.0; n], &mut tangents, &mut work);
    let short = contact.step(state, inputs, &mut vec![0.0; n], &mut work);
    for (one, other) in
        response.by_displacement.iter().zip(&short.by_displacement).flat_map(|(a, b)| a.iter().zip(b))
    {
        assert!((one - other).abs() <= 1e-9 * one.abs(), "both ways of a step have one tangent");
    }
    let SlipSlapInputs { displacement, velocity } = inputs;
    let at: Vec<f64> = displacement.into_iter().chain(velocity).chain(state.iter().copied()).collect();
    let here = outcome(contact, &at);
    let (mut compared, mut missed) = (0, 0);
    for column in 0..at.len() {
        let scale = match column {
            0 | 1 | 4 | 5 => 1e-5,
            2 | 3 | 6 | 7 => 1e-2,
            _ => at[column].abs().max(1e-6),
        };
        let span = 1e-6 * scale;
        let moved = |by: f64| {
            let mut at = at.clone();
            at[column] += by;
            outcome(contact, &at)
        };
        let (ahead, behind) = (moved(span), moved(-span));
        for row in 0..n + 2 {
            let analytic = match (row, column) {
                (0 | 1, 0 | 1) => response.by_displacement[row][column],
                (0 | 1, 2 | 3) => response.by_velocity[row][column - 2],
                (0 | 1, _) => tangents.force_by_state[row * n + column - INPUTS],
                (_, 0 | 1) => tangents.next_by_displacement[2 * (row - 2) + column],
                (_, 2 | 3) => tangents.next_by_velocity[2 * (row - 2) + column - 2],
                _ => tangents.next_by_state[(row - 2) * n + column - INPUTS],
            };
            let sides = [(here[row] - behind[row]) / span, (ahead[row] - here[row]) / span];
            // A force of 100 N, a displacement of 10 µm: in their measure a tangent of 1.
            let size = if row < 2 { 100.0 } else { here[row].abs().max(1e-5) } / scale;
            compared += 1;
            if !meets(analytic, sides, 2e-4 * size) {
                missed += 1;
            }
        }
    }
    (compared, missed)
}

#[test]
fn tangents_meet_differences_on_random_histories() {
    let mut random = fastrand::Rng::with_seed(22);
    let (mut compared, mut apart) = (0, 0);
    for law in frictions(1e5) {
        for normal in normals() {
            let mut history = History::new(law.clone(), normal);
            for step in 1..60 {
                // Amplitudes that slip, and open the contact in a part of the steps.
                let amplitudes = [30e-6, 6e-6].map(|most| most * random.f64());
                let inputs = motion(amplitudes, [1.0, 3.0], [0.0, 1.0], f64::from(step) * 1.37e-3);
                let (all, missed) = compare(&history.contact, &history.state, inputs);
                assert_eq!(missed, 0, "step {step} of {:?} under {normal:?}", history.contact.law());
                compared += all;
                apart += usize::from(history.go(inputs).normal_force == 0.0);
            }
        }
    }
    assert!(compared > 500_000 && apart >= 300, "{compared} derivatives, {apart} steps apart");
}
