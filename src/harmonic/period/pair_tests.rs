//! A contact in two directions over a period: its derivatives, and the state that reproduces itself.

use std::sync::Arc;

use super::pair::PairCycle;
use crate::contact::{
    BoucWen, ContactLaw, Jenkins, NormalDirection, NormalLaw, ParallelSliders, SlipSlap, Valanis,
};
use crate::numeric::fourier::work_per_cycle;

const SPEED: f64 = 330.0;
const SAMPLES: usize = 1024;

fn contact(law: Arc<dyn ContactLaw>, gain: f64) -> SlipSlap {
    let normal = NormalDirection::new(NormalLaw::Hertz { exponent: 1.5 }, 60.0, 2e7, 20.0).unwrap();
    SlipSlap::new(law, normal).with_load_gain(gain)
}

fn laws() -> [Arc<dyn ContactLaw>; 3] {
    let sliders: Vec<(f64, f64)> = (0..10).map(|k| (4e5, 0.006 * (2.0 * f64::from(k) + 1.0))).collect();
    [
        Arc::new(Valanis::new(4e6, 0.6, 0.3, 0.0).unwrap()),
        Arc::new(Jenkins::new(4e6, 0.6).unwrap()),
        Arc::new(ParallelSliders::new(&sliders).unwrap()),
    ]
}

/// Coefficients of ξ and η (m) of a motion of this size: two tones, and constants.
fn motion(size: f64) -> [Vec<f64>; 2] {
    let xi = [0.1, 0.9, 0.2, 0.0, 0.0, 0.1, 0.4].map(|x| size * x);
    let eta = [0.02, 0.03, -0.05, 0.01, 0.0, 0.02, 0.06].map(|x| 0.4 * size * x);
    [xi.to_vec(), eta.to_vec()]
}

fn evaluated(contact: &SlipSlap, [xi, eta]: &[Vec<f64>; 2], speed: f64, derivatives: bool) -> PairCycle {
    let mut cycle = PairCycle::new([3, 3], SAMPLES);
    cycle.evaluate(contact, speed, [xi, eta], derivatives).unwrap();
    cycle
}

#[test]
fn derivatives_are_those_of_differences() {
    for law in laws() {
        for gain in [0.0, 1.0] {
            for size in [2e-6, 20e-6] {
                let contact = contact(law.clone(), gain);
                let at = motion(size);
                let cycle = evaluated(&contact, &at, SPEED, true);
                let stiffness = 4e6;
                for column in 0..15 {
                    let moved = |step: f64| {
                        let (mut there, mut speed) = (at.clone(), SPEED);
                        match column {
                            14 => speed += step,
                            _ => there[column / 7][column % 7] += step,
                        }
                        evaluated(&contact, &there, speed, false)
                    };
                    let step = if column == 14 { 1e-4 * SPEED } else { 1e-4 * size };
                    let (ahead, behind) = (moved(step), moved(-step));
                    for direction in 0..2 {
                        for row in 0..7 {
                            let [a, b] = [&ahead, &behind].map(|cycle| cycle.force(direction)[row]);
                            let expected = (a - b) / (2.0 * step);
                            let found = cycle.derivatives(direction, row)[column];
                            // The force of one slider has corners, at which both sides differ.
                            let scale = if column == 14 { stiffness * size / SPEED } else { stiffness };
                            assert!(
                                (found - expected).abs() < 0.02 * scale,
                                "{law:?}, gain {gain}, {size} m: force {direction} {row} by {column}: {found} \
                                 {expected}"
                            );
                        }
                    }
                }
            }
        }
    }
}

/// Valanis' law forgets by exp(−4 (1 − κ) λ X) a period alone, Bouc and Wen's by less than rounding shows from one period to the
/// next: marching to the end of it would take thousands, or for ever.
#[test]
fn what_forgets_slowly_is_found_all_the_same() {
    let bouc_wen = |sharpness, unloading| -> Arc<dyn ContactLaw> {
        Arc::new(BoucWen::new(4e6, 0.6, sharpness, unloading, 0.0).unwrap())
    };
    let gradual = [laws()[0].clone(), bouc_wen(2.0, 1.5), bouc_wen(4.5, 1.0), bouc_wen(20.0, 1.0)];
    for (law, size) in gradual.iter().flat_map(|law| [1e-8, 1e-7, 1e-6, 3e-6, 1e-5].map(|size| (law, size))) {
        let at = motion(size);
        let cycle = evaluated(&contact(law.clone(), 0.0), &at, SPEED, true);
        let own = cycle.summaries()[0].dissipated_energy;
        let area = work_per_cycle(cycle.force(0), &at[0]);
        // The loop closes, so that its area is what friction takes; harmonics beyond these have no part in it.
        let size = cycle.force(0).iter().fold(0.0_f64, |most, x| most.max(x.abs())) * size;
        assert!(own >= 0.0 && (own - area).abs() < 1e-4 * own + 1e-9 * size, "{law:?} {size}: {own} {area}");
    }
}
