//! What drives the beam: levels and frequencies around its resonances.

use std::f64::consts::TAU;

use super::{MODES, OFFSET};
use crate::physics::finite_elements::{Geometry, Modes};
use crate::physics::joint::Joint;
use crate::records::random::Random;

/// Excitation over the limit, and frequency: mode, and place between its resonance in stick (0) and in slip (1).
const PLAN: [(f64, usize, f64); 8] = [
    (0.00055, 0, 0.0),
    (0.15, 0, 0.3),
    (0.205, 0, 0.85),
    (0.21, 0, 0.6),
    (0.33, 0, 1.0),
    (0.50, 0, 1.45),
    (0.004, 1, 0.0),
    (0.175, 1, 0.8),
];

/// Levels of the first paper's experiment (m/s², first harmonic at the excitation), the frequency of the phase resonance
/// (Hz), and a force that comes near (N).
const HELD: [(f64, f64, f64); 8] = [
    (0.5, 53.95, 0.02),
    (10.0, 53.23, 2.4),
    (20.0, 51.62, 6.9),
    (30.0, 50.60, 9.7),
    (40.0, 50.07, 11.1),
    (50.0, 49.76, 12.2),
    (60.0, 49.56, 12.8),
    (70.0, 49.42, 13.5),
];

/// What drives the beam in one record.
#[derive(Clone)]
pub struct Excitation {
    /// Force (N); where a level is held, the one to begin with.
    pub size: f64,
    /// Hz.
    pub frequency: f64,
    /// At the start (rad).
    pub phase: f64,
    /// Of the normal load and of a disturbance.
    pub phases: [f64; 2],
    /// First harmonic of the acceleration at the excitation (m/s²) at which a controller holds it.
    pub held: Option<f64>,
}

impl Excitation {
    /// The same at `factor` times the level.
    pub fn at_level(&self, factor: f64) -> Self {
        Self { size: factor * self.size, held: self.held.map(|level| factor * level), ..self.clone() }
    }
}

/// Forces around the resonances in stick and in slip.
pub fn forces(geometry: &Geometry, joint: &Joint, limit: f64, random: &mut Random) -> Vec<Excitation> {
    let slipping = Modes::of(geometry, MODES);
    let axial = geometry.axial_stiffness();
    let stiffness = joint.stiffness * axial / (joint.stiffness + axial);
    let sticking = resonances_in_stick(&slipping, stiffness);
    PLAN.map(|(level, mode, place)| {
        let stuck = sticking[mode] / TAU;
        let slip = slipping.angular_frequencies[mode] / TAU;
        Excitation {
            size: level * random.about_one(0.12) * limit,
            frequency: stuck + (slip - stuck) * (place + random.between(-0.1, 0.1)),
            phase: random.phase(),
            phases: [random.phase(), random.phase()],
            held: None,
        }
    })
    .to_vec()
}

/// Levels that are held at their phase resonance, or within 0.1 Hz of it.
pub fn held_levels(random: &mut Random) -> Vec<Excitation> {
    HELD.map(|(level, frequency, size)| Excitation {
        size,
        frequency: frequency + random.between(-0.1, 0.1),
        phase: random.phase(),
        phases: [0.0; 2],
        held: Some(level),
    })
    .to_vec()
}

/// The lowest angular frequencies with a spring at the contact, in the space of the modes in slip.
fn resonances_in_stick(modes: &Modes, stiffness: f64) -> Vec<f64> {
    let slopes = modes.slopes_at_pin();
    let matrix = nalgebra::DMatrix::from_fn(MODES, MODES, |i, j| {
        let own = if i == j { modes.angular_frequencies[i].powi(2) } else { 0.0 };
        own + stiffness * OFFSET * OFFSET * slopes[i] * slopes[j]
    });
    let mut values: Vec<f64> =
        nalgebra::SymmetricEigen::new(matrix).eigenvalues.iter().map(|value| value.sqrt()).collect();
    values.sort_by(f64::total_cmp);
    values
}
