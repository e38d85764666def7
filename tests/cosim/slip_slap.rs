//! A contact in two directions on a structure of two coordinates, against the same in one piece.

use stickslip::contact::{SlipSlapInputs, SlipSlapWork};
use stickslip::cosim::{Algorithm, Method, Report, Settings, System};
use stickslip::model::Model;

use crate::common::cosim::*;
use crate::common::linear_slave::Linear;

const CONTACT: &str = include_str!("../../modelDescription/SlipSlapContact.toml");

/// Of the structure: mass (kg), stiffness (N/m) and coupling of the coordinates, damping (N s/m), and the motion at the
/// start: ξ, ξ̇, η, η̇. It slips, and leaves the contact and slaps back.
const MASS: f64 = 1.0;
const STIFFNESS: [[f64; 2]; 2] = [[2e5, 3e4], [3e4, 4e5]];
const DAMPING: f64 = 20.0;
const START: [f64; 4] = [0.0, 0.1, -1.2e-4, 0.0];
const STOP: f64 = 0.02;

/// Softer than the standard contact, with less damping, so that steps of 0.1 ms follow it.
fn contact() -> String {
    CONTACT.replace("3.95e6", "1e6").replace("2.37e7", "2e6").replace("= 30.0", "= 3.0")
}

fn rates([x, v, y, w]: [f64; 4], [s, n]: [f64; 2]) -> [f64; 4] {
    let [[a, b], [c, d]] = STIFFNESS;
    [v, -(a * x + b * y + DAMPING * v + s) / MASS, w, -(c * x + d * y + DAMPING * w + n) / MASS]
}

const OBSERVED: [(&str, &str); 10] = [
    ("structure", "xi"),
    ("structure", "xi_rate"),
    ("structure", "eta"),
    ("structure", "eta_rate"),
    ("contact", "force"),
    ("contact", "opening_force"),
    ("contact", "normal_force"),
    ("contact", "separation"),
    ("contact", "dissipated_energy"),
    ("contact", "impact_energy"),
];

fn coupled() -> System {
    let [[a, b], [c, d]] = STIFFNESS.map(|row| row.map(|stiffness| -stiffness / MASS));
    let damping = -DAMPING / MASS;
    #[rustfmt::skip]
    let matrix = [
        0.0, 1.0, 0.0, 0.0,
        a, damping, b, 0.0,
        0.0, 0.0, 0.0, 1.0,
        c, 0.0, d, damping,
    ];
    let mut unit = [0.0; 16];
    (0..4).for_each(|place| unit[5 * place] = 1.0);
    let inputs = [0.0, 0.0, -1.0 / MASS, 0.0, 0.0, 0.0, 0.0, -1.0 / MASS];
    let structure = Linear::new(
        "structure",
        &[("s", "N"), ("n", "N")],
        &[("xi", "m"), ("xi_rate", "m/s"), ("eta", "m"), ("eta_rate", "m/s")],
        [&matrix, &inputs, &unit, &[0.0; 8]],
        &START,
    );
    let mut system = System::new();
    system.add(structure.boxed()).unwrap();
    system.add(native("contact", &contact())).unwrap();
    for (from, to) in [
        (("structure", "xi"), ("contact", "displacement")),
        (("structure", "xi_rate"), ("contact", "velocity")),
        (("structure", "eta"), ("contact", "opening")),
        (("structure", "eta_rate"), ("contact", "opening_velocity")),
        (("contact", "force"), ("structure", "s")),
        (("contact", "opening_force"), ("structure", "n")),
    ] {
        system.connect(from, to, 1.0, 0.0).unwrap();
    }
    // Which force belongs to which motion no unit tells.
    system.declare_power(("structure", "s"), ("contact", "displacement")).unwrap();
    system.declare_power(("structure", "n"), ("contact", "opening")).unwrap();
    for (slave, variable) in OBSERVED {
        system.observe(slave, variable).unwrap();
    }
    system
}

/// The same in one piece, by the trapezoidal rule in steps of `step`: a row every `every` steps.
fn monolithic(step: f64, every: u64) -> Vec<[f64; 10]> {
    let contact = Model::parse(&contact()).unwrap().slip_slap().unwrap().unwrap();
    let mut state = vec![0.0; contact.state_len()];
    contact.set_state([0.0; 2], 0.0, &mut state);
    let (mut next, mut work) = (state.clone(), SlipSlapWork::default());
    let inputs = |[x, v, y, w]: [f64; 4]| SlipSlapInputs { displacement: [x, y], velocity: [v, w] };
    let mut at = START;
    // The contact goes from rest to the motion at the start.
    let mut response = contact.step(&state, inputs(at), &mut next, &mut work);
    state.copy_from_slice(&next);
    let mut energies = [response.friction_energy, response.impact_energy];
    let row = |at: [f64; 4], response: &stickslip::contact::SlipSlapResponse, energies: [f64; 2]| {
        let [s, n] = response.force;
        let [x, v, y, w] = at;
        [x, v, y, w, s, n, response.normal_force, response.separation, energies[0], energies[1]]
    };
    let mut rows = vec![row(at, &response, energies)];
    for index in 0..(STOP / step).round() as u64 {
        let before = rates(at, response.force);
        let mut end = at;
        for _ in 0..6 {
            response = contact.step(&state, inputs(end), &mut next, &mut work);
            let after = rates(end, response.force);
            end = std::array::from_fn(|i| at[i] + 0.5 * step * (before[i] + after[i]));
        }
        response = contact.step(&state, inputs(end), &mut next, &mut work);
        state.copy_from_slice(&next);
        energies = [energies[0] + response.friction_energy, energies[1] + response.impact_energy];
        at = end;
        if (index + 1) % every == 0 {
            rows.push(row(at, &response, energies));
        }
    }
    rows
}

const COARSEST: f64 = 1e-4;

type Outcome = ([f64; 10], Report);

/// Of every signal the error in the mean square over that signal, and the report.
fn errors(algorithm: &Algorithm, step: f64, exact: &[[f64; 10]]) -> Outcome {
    let (rows, report) = record(coupled(), Settings::new(algorithm.clone(), step, STOP)).unwrap();
    let every = (COARSEST / step).round() as usize;
    let mean_square = |of: &dyn Fn(usize, usize) -> f64, signal| {
        (0..exact.len()).map(|row| of(row, signal).powi(2)).sum::<f64>().sqrt()
    };
    let off = |row: usize, signal: usize| rows[row * every].1[signal] - exact[row][signal];
    let errors = std::array::from_fn(|signal| {
        mean_square(&off, signal) / mean_square(&|row, signal| exact[row][signal], signal)
    });
    (errors, report)
}

#[test]
fn strong_coupling_converges_with_order_two_on_every_signal_and_closes_both_works() {
    let exact = monolithic(1e-6, 100);
    let column = |signal: usize| exact.iter().map(move |row| row[signal]);
    assert!(column(7).any(|separation| separation > 0.0), "it leaves the contact");
    let [.., friction, impact] = exact[exact.len() - 1];
    assert!(friction > 1e-4 && impact > 0.0, "and dissipates");
    // Where in a step it sticks or parts is a matter of chance: the largest error of three steps each.
    let level = |divisors: [f64; 3]| {
        let runs = divisors.map(|divisor| errors(&strong(Method::Newton), COARSEST / divisor, &exact));
        assert!(runs.iter().all(|(_, report)| report.unconverged == 0));
        let most = |of: &dyn Fn(&Outcome) -> f64| runs.iter().map(of).fold(0.0, f64::max);
        let signals: Vec<f64> = (0..10).map(|signal| most(&|run| run.0[signal])).collect();
        let residuals = [0, 1].map(|pair| most(&|run| run.1.energy[pair].magnitude));
        (signals, residuals)
    };
    let ((coarse, first), (fine, last)) = (level([1.0, 2.0, 3.0]), level([8.0, 16.0, 24.0]));
    for (signal, (_, name)) in OBSERVED.iter().enumerate() {
        let order = (coarse[signal] / fine[signal]).log2() / 3.0;
        assert!(order > 1.75, "{name}: {:e} to {:e}, {order}", coarse[signal], fine[signal]);
    }
    // Where both sides take and give forces as lines, their works agree to round-off; without iteration they do not.
    assert!(first.iter().chain(&last).all(|residual| *residual < 1e-9 * friction));
    let [first, last] = [2.0, 16.0].map(|divisor| errors(&JACOBI, COARSEST / divisor, &exact).1.energy);
    for (first, last) in first.iter().zip(&last) {
        assert!(last.magnitude < first.magnitude / 6.0, "{first:?} to {last:?}");
    }
}
