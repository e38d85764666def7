//! Small oscillators with one contact.

use stickslip::model::{Anchor, Mass, Oscillator, Spring};
use stickslip::system::LinearStructure;

fn mass(name: &str) -> Mass {
    Mass { name: name.into(), mass: 1.0 }
}

fn spring(between: [Anchor; 2], stiffness: f64, damping: f64) -> Spring {
    Spring { between, stiffness, damping }
}

/// A mass of 1 kg on a spring and a damper, excited and in contact.
pub fn single_mass(stiffness: f64, damping: f64) -> LinearStructure {
    let springs = vec![spring([Anchor::Ground, Anchor::Mass(0)], stiffness, damping)];
    Oscillator { masses: vec![mass("m1")], springs, contact: Some(0), excitation: 0 }.structure().unwrap()
}

/// Two masses of 1 kg on springs of 1 and 0.5 N/m, each with a damper to the ground; excited at the first,
/// in contact at the second. Undamped and without the contact: 0.5411961 and 1.3065630 rad/s.
pub fn two_masses(damping: f64) -> LinearStructure {
    let (first, second) = (Anchor::Mass(0), Anchor::Mass(1));
    let springs = vec![
        spring([Anchor::Ground, first], 1.0, 0.0),
        spring([first, second], 0.5, 0.0),
        spring([Anchor::Ground, first], 0.0, damping),
        spring([Anchor::Ground, second], 0.0, damping),
    ];
    Oscillator { masses: vec![mass("m1"), mass("m2")], springs, contact: Some(1), excitation: 0 }
        .structure()
        .unwrap()
}
