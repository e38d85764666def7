//! Lumped oscillators, written as matrices.

use std::sync::Arc;

use stickslip::contact::ContactLaw;
use stickslip::harmonic::{Assembly, CurveSettings};
use stickslip::system::{LinearStructure, Output};

fn outputs(size: usize) -> Vec<Output> {
    (0..size).map(|i| Output { name: format!("m{}", i + 1), row: vec![(i, 1.0)] }).collect()
}

/// One mass on a spring and a damper, excited, with `contacts` contacts on it.
pub fn single(mass: f64, damping: f64, stiffness: f64, contacts: usize) -> LinearStructure {
    LinearStructure {
        size: 1,
        mass: vec![(0, 0, mass)],
        damping: vec![(0, 0, damping)],
        stiffness: vec![(0, 0, stiffness)],
        contacts: vec![vec![(0, 1.0)]; contacts],
        excitation: vec![(0, 1.0)],
        outputs: outputs(1),
    }
}

/// The two masses of 1 kg of the friction-vibration study, where `damping` is 0.1: springs of 1 N/m to the ground and 0.5 N/m
/// between them, each with a damper to the ground; excited at the first, in contact at the second. Undamped and without
/// the contact: 0.5411961 and 1.3065630 rad/s.
pub fn two_masses(damping: f64) -> LinearStructure {
    LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, damping), (1, 1, damping)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: outputs(2),
    }
}

/// Masses of 1 kg in a row between two walls, springs of 1 N/m and dampers between them; contacts at the last and between two.
pub fn chain(masses: usize, damping: f64) -> LinearStructure {
    let band = |factor: f64| {
        let mut entries = vec![];
        for i in 0..masses {
            for j in i.saturating_sub(1)..(i + 2).min(masses) {
                entries.push((i, j, if i == j { 2.0 * factor } else { -factor }));
            }
        }
        entries
    };
    LinearStructure {
        size: masses,
        mass: (0..masses).map(|i| (i, i, 1.0)).collect(),
        damping: band(damping),
        stiffness: band(1.0),
        contacts: vec![vec![(masses - 1, 1.0)], vec![(masses / 2, 1.0), (masses / 2 - 1, -1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: outputs(masses),
    }
}

/// The structure with one law under a load of 1 N.
pub fn in_contact(structure: &LinearStructure, law: impl ContactLaw + 'static) -> Assembly {
    under_load(structure, Arc::new(law), 1.0)
}

/// The structure with one law under `normal_load` (N).
pub fn under_load(structure: &LinearStructure, law: Arc<dyn ContactLaw>, normal_load: f64) -> Assembly {
    Assembly::new(structure.system(vec![(law, normal_load)]))
}

pub fn settings(harmonics: usize) -> CurveSettings {
    CurveSettings { harmonics, ..CurveSettings::default() }
}
