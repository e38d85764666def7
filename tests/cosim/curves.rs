//! Every signal of a beam with its contact under strong coupling, against the same in much shorter steps.

use stickslip::cosim::{Abilities, Algorithm, Method, Settings, Strong, System};

use crate::common::cosim::*;
use crate::common::linear_slave::{EVERYTHING, TWO_MASSES, joined};

const FAST: Shaker = Shaker { amplitude: 60.0, omega: 324.0, growth: 0.02 };
const STOP: f64 = 0.1;
/// The shortest step (s), which stands for the exact solution.
const FINEST: f64 = 2.5e-6;

/// What is compared, in the order of [`signals`].
const NAMES: [&str; 8] = [
    "beam.displacement",
    "beam.velocity",
    "contact.force",
    "beam.displacement:x=0.55",
    "beam.velocity:x=0.55",
    "beam.acceleration:x=0.55",
    "beam.acceleration:x=0.1",
    "contact.dissipated_energy",
];

fn signals(contact: &str, step: f64) -> Rows {
    let mut system: System = beam_with(contact, FAST);
    for variable in ["velocity:x=0.55", "acceleration:x=0.55", "acceleration:x=0.1"] {
        system.observe("beam", variable).unwrap();
    }
    system.observe("contact", "dissipated_energy").unwrap();
    let strong = Strong { method: Method::Anderson { depth: 5 }, tolerance: 1e-11, iterations: 50 };
    let settings =
        Settings { tolerance: Some(1e-10), ..Settings::new(Algorithm::Strong(strong), step, STOP) };
    let (rows, report) = record(system, settings).unwrap();
    assert_eq!(report.unconverged, 0);
    rows
}

/// Errors of all signals at a step of so many of the finest, relative to their standard deviations.
fn errors(contact: &str, exact: &Rows, finer: u32) -> Vec<f64> {
    let rows = signals(contact, f64::from(finer) * FINEST);
    let count = rows.len() as f64;
    let error = |signal: usize| {
        let exact = || exact.iter().step_by(finer as usize).map(|(_, values)| values[signal]);
        let mean = exact().sum::<f64>() / count;
        let spread = exact().map(|value| (value - mean).powi(2)).sum::<f64>();
        let off: f64 =
            rows.iter().zip(exact()).map(|((_, values), exact)| (values[signal] - exact).powi(2)).sum();
        (off / spread).sqrt()
    };
    (0..NAMES.len()).map(error).collect()
}

#[test]
fn cubics_by_end_values_and_slopes_make_every_signal_accurate() {
    // At 1e-4 s; the least orders between 4e-4 s and 5e-5 s of displacements, velocities but for the contact's own, and all.
    // A corner of Jenkins' force lies somewhere in a step, and no cubic follows it.
    for (contact, largest, least) in [(VALANIS, 1e-4, [2.5, 2.9, 2.0]), (JENKINS, 3e-3, [2.0, 1.9, 1.9])] {
        let exact = signals(contact, FINEST);
        let [coarse, usual, fine] = [160, 40, 20].map(|finer| errors(contact, &exact, finer));
        for (signal, name) in NAMES.iter().enumerate() {
            let order = (coarse[signal] / fine[signal]).log2() / 3.0;
            let [displacement, velocity, any] = least;
            let least = match *name {
                "beam.velocity:x=0.55" => velocity,
                name if name.contains("displacement") => displacement,
                _ => any,
            };
            assert!(usual[signal] < largest, "{name}: {:.1e}", usual[signal]);
            assert!(
                order > least,
                "{name}: order {order:.2}, {:.1e} to {:.1e}",
                coarse[signal],
                fine[signal]
            );
        }
    }
}

#[test]
fn slaves_that_know_first_derivatives_alone_follow_cubics_in_parts_of_a_step() {
    let exact = TWO_MASSES.exact(2.0);
    let error = |variable_step: bool| {
        let abilities = Abilities { variable_step, ..EVERYTHING };
        let slaves = TWO_MASSES.slaves().map(|slave| slave.with(abilities));
        let algorithm = Algorithm::Strong(Strong { tolerance: 1e-12, ..Strong::default() });
        let (rows, _) = record(joined(slaves), Settings::new(algorithm, 0.01, 2.0)).unwrap();
        let (_, end) = rows.last().unwrap();
        (end[0] - exact[0]).abs() + (end[2] - exact[2]).abs()
    };
    // One of a fixed step goes straight.
    let (straight, in_parts) = (error(false), error(true));
    assert!(in_parts < 0.1 * straight, "{in_parts:e} {straight:e}");
}
