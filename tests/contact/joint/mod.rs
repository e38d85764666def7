//! A contact with effects.

mod changes;
mod laws;

use stickslip::contact::{ContactLaw, Inputs, Jenkins, Joint, JointChanges, Valanis};

use crate::common::contact::{ContactHistory, close};

const STIFFNESS: f64 = 5e6;
const FRICTION: f64 = 0.5;
const LOAD: f64 = 150.0;
const LIMIT: f64 = FRICTION * LOAD;
/// Displacement at which Jenkins' element begins to slip (m).
const YIELD: f64 = LIMIT / STIFFNESS;

fn none() -> JointChanges {
    JointChanges::default()
}

fn jenkins() -> Jenkins {
    Jenkins::new(STIFFNESS, FRICTION).unwrap()
}

fn joint(changes: JointChanges) -> Joint {
    Joint::new(jenkins(), changes).unwrap()
}

fn on_valanis(changes: JointChanges) -> Joint {
    Joint::new(Valanis::new(STIFFNESS, FRICTION, 0.3, 0.0).unwrap(), changes).unwrap()
}

/// Force at the end of a motion through `corners` (m) in steps of at most `step` (m).
fn walk(law: &dyn ContactLaw, corners: &[f64], step: f64) -> (Vec<f64>, Vec<f64>, Vec<f64>) {
    let mut contact = ContactHistory::at_rest(law, LOAD);
    let (mut at, mut path, mut force) = (0.0, Vec::new(), Vec::new());
    let mut lost = Vec::new();
    for corner in corners {
        let steps = ((corner - at) / step).abs().ceil().max(1.0) as usize;
        for index in 1..=steps {
            let u = at + (corner - at) * index as f64 / steps as f64;
            let response = contact.go(u, LOAD);
            path.push(u);
            force.push(response.force);
            lost.push(response.dissipated_energy);
        }
        at = *corner;
    }
    (path, force, lost)
}

/// Dissipation of the third of three loops of amplitude `amplitude` (m).
fn loop_area(law: &dyn ContactLaw, amplitude: f64) -> f64 {
    ContactHistory::at_rest(law, LOAD).last_loop(amplitude, LOAD, 3).0
}

/// Deterministic histories with reversals; loads vary and now and then vanish.
fn history(seed: u64, count: usize) -> Vec<Inputs> {
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).max(1);
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let mut before = 0.0;
    (0..count)
        .map(|_| {
            let displacement = 6.0 * YIELD * (2.0 * random() - 1.0);
            let velocity = (displacement - before) / 1e-3;
            before = displacement;
            Inputs { displacement, velocity, normal_load: LOAD * (1.6 * random() - 0.2) }
        })
        .collect()
}
