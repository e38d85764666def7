//! Laws and motions for the tests of the contact over a period.

use nalgebra::DMatrix;
use stickslip::contact::{ContactLaw, Inputs, Response, Slider, SlipState, StateTangents, Tangents};
use stickslip::harmonic::{ContactMapping, HarmonicSet, Method};

use super::contact::LOAD;

/// Any sliders side by side, with a step of their own for the sampled check.
#[derive(Debug, Clone)]
pub struct Sliders(pub Vec<Slider>);

impl ContactLaw for Sliders {
    fn state_len(&self) -> usize {
        self.0.len()
    }

    fn set_state(&self, _displacement: f64, _normal_load: f64, _force: f64, state: &mut [f64]) {
        state.fill(0.0);
    }

    fn step(&self, state: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        let (mut force, mut stiffness) = (0.0, 0.0);
        for ((slider, z), next) in self.0.iter().zip(state).zip(next.iter_mut()) {
            let (f, position) = slider.step(*z, inputs.displacement);
            *next = position;
            force += f;
            let x = inputs.displacement - position;
            if position == *z && (x >= slider.play_above || x <= slider.play_below) {
                stiffness += slider.stiffness;
            }
        }
        Response {
            force,
            tangents: Tangents { displacement: stiffness, ..Tangents::default() },
            dissipated_energy: 0.0,
            slip_state: SlipState::Slip,
        }
    }

    fn state_tangents(&self, state: &[f64], inputs: Inputs, out: &mut StateTangents) {
        let n = self.0.len();
        out.reset(n);
        for (i, (slider, z)) in self.0.iter().zip(state).enumerate() {
            let (_, position) = slider.step(*z, inputs.displacement);
            let x = inputs.displacement - position;
            if position != *z {
                out.next_by_displacement[i] = 1.0;
            } else {
                out.next_by_state[i * n + i] = 1.0;
                if x >= slider.play_above || x <= slider.play_below {
                    out.force_by_state[i] = -slider.stiffness;
                }
            }
        }
    }

    fn limit(&self, _normal_load: f64) -> f64 {
        self.0.iter().map(|slider| slider.upper_limit).sum()
    }

    fn is_odd(&self) -> bool {
        self.0.iter().all(Slider::is_odd)
    }

    fn sliders(&self, _normal_load: f64, out: &mut Vec<Slider>) -> bool {
        out.clear();
        out.extend_from_slice(&self.0);
        true
    }
}

pub fn slider(stiffness: f64, play: (f64, f64), limits: (f64, f64)) -> Slider {
    Slider { stiffness, play_below: play.0, play_above: play.1, lower_limit: limits.0, upper_limit: limits.1 }
}

/// Every kind of slider, alone and together, with displacements that exercise it.
pub fn cases() -> Vec<(&'static str, Vec<Slider>)> {
    let never = f64::INFINITY;
    vec![
        ("one", vec![Slider::jenkins(2.0, 0.6)]),
        ("stuck", vec![Slider::jenkins(2.0, 60.0)]),
        ("many", (1..=7).map(|i| Slider::jenkins(0.3 * f64::from(i), 0.17 * f64::from(i * i))).collect()),
        ("backlash", vec![slider(1.5, (-0.31, 0.31), (never, never))]),
        ("one-sided", vec![slider(1.5, (f64::NEG_INFINITY, 0.2), (never, never))]),
        ("asymmetric limits", vec![slider(1.7, (0.0, 0.0), (0.3, 0.9))]),
        ("play and limits", vec![slider(1.7, (-0.2, 0.1), (0.5, 0.4))]),
        ("spring", vec![slider(0.7, (0.0, 0.0), (never, never))]),
        (
            "all",
            vec![
                Slider::jenkins(2.0, 0.6),
                slider(1.5, (-0.31, 0.31), (never, never)),
                slider(1.5, (f64::NEG_INFINITY, 0.2), (never, never)),
                slider(1.7, (-0.2, 0.1), (0.5, 0.4)),
            ],
        ),
    ]
}

/// Displacements on harmonics 0..=5: simple loops, minor loops, bias and even harmonics.
pub fn motions() -> Vec<(&'static str, [f64; 11])> {
    vec![
        ("single", [0.0, 0.3, 1.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ("biased", [0.37, 0.9, -0.2, 0.21, 0.13, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
        ("minor loops", [0.05, 0.8, 0.1, 0.0, 0.11, -0.6, 0.33, 0.0, 0.05, 0.3, -0.41]),
        ("odd minor loops", [0.0, 0.7, 0.4, 0.0, 0.0, -0.5, 0.6, 0.0, 0.0, 0.3, -0.2]),
    ]
}

pub fn evaluated(law: &dyn ContactLaw, compliance: f64, set: HarmonicSet, u: &[f64]) -> ContactMapping {
    let mut map = ContactMapping::new(set, Method::Exact);
    map.evaluate(law, LOAD, compliance, 300.0, u).unwrap();
    map
}

/// Central differences of the force by the displacement.
pub fn differences(
    law: &dyn ContactLaw,
    compliance: f64,
    set: HarmonicSet,
    u: &[f64],
    step: f64,
) -> DMatrix<f64> {
    let mut out = DMatrix::zeros(u.len(), u.len());
    for j in 0..u.len() {
        let mut moved = u.to_vec();
        moved[j] = u[j] + step;
        let above = evaluated(law, compliance, set, &moved).force().to_vec();
        moved[j] = u[j] - step;
        let below = evaluated(law, compliance, set, &moved).force().to_vec();
        for i in 0..u.len() {
            out[(i, j)] = (above[i] - below[i]) / (2.0 * step);
        }
    }
    out
}

pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |a, b| if b.abs() > a { b.abs() } else { a })
}
