//! Lumped oscillators for the tests, written as matrices.

use stickslip::system::{LinearStructure, Output};

/// The two masses of the friction-vibration study: contact on the second mass, force on the first.
pub fn two_mass() -> LinearStructure {
    let output = |name: &str, i| Output { name: name.into(), row: vec![(i, 1.0)] };
    LinearStructure {
        size: 2,
        mass: vec![(0, 0, 1.0), (1, 1, 1.0)],
        damping: vec![(0, 0, 0.1), (1, 1, 0.1)],
        stiffness: vec![(0, 0, 1.5), (0, 1, -0.5), (1, 0, -0.5), (1, 1, 0.5)],
        contacts: vec![vec![(1, 1.0)]],
        excitation: vec![(0, 1.0)],
        outputs: vec![output("x", 0), output("y", 1)],
    }
}

/// One mass on a spring and a damper, `contacts` contacts on it.
pub fn single(mass: f64, damping: f64, stiffness: f64, contacts: usize) -> LinearStructure {
    LinearStructure {
        size: 1,
        mass: vec![(0, 0, mass)],
        damping: vec![(0, 0, damping)],
        stiffness: vec![(0, 0, stiffness)],
        contacts: vec![vec![(0, 1.0)]; contacts],
        excitation: vec![(0, 1.0)],
        outputs: vec![Output { name: "mass".into(), row: vec![(0, 1.0)] }],
    }
}

/// Masses of one kilogram in a row, springs of 1 N/m and dampers between them and to the ground.
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
        outputs: (0..masses).map(|i| Output { name: format!("{i}"), row: vec![(i, 1.0)] }).collect(),
    }
}
