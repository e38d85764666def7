//! Energy: what goes in is kept or dissipated.

use std::sync::Arc;

use stickslip::contact::{Jenkins, NormalLaw};

use super::{History, PRELOAD, frictions, motion, normal, normals};
use crate::common::contact::close;

/// One period of impacts and slip in `steps` steps: energy in (J) by the trapezoidal rule along both directions, that by
/// friction, by impacts, and what is kept at the end less that at the start in the normal direction.
fn period(history: &mut History, steps: u32, amplitudes: [f64; 2]) -> [f64; 4] {
    let inputs = |step: u32| {
        let time = f64::from(step) / f64::from(steps) / 50.0;
        motion(amplitudes, [1.0, 3.0], [0.3, 0.9], time)
    };
    let mut before = (inputs(0), history.go(inputs(0)).force);
    let (start, mut sums) = (before.0.displacement[1], [0.0; 4]);
    for step in 1..=steps {
        let now = inputs(step);
        let response = history.go(now);
        assert!(response.friction_energy >= 0.0 && response.impact_energy >= 0.0);
        for direction in 0..2 {
            let way = now.displacement[direction] - before.0.displacement[direction];
            sums[0] += 0.5 * (before.1[direction] + response.force[direction]) * way;
        }
        sums[1] += response.friction_energy;
        sums[2] += response.impact_energy;
        before = (now, response.force);
    }
    let normal = history.contact.normal();
    sums[3] = normal.stored_energy(before.0.displacement[1]) - normal.stored_energy(start);
    sums
}

#[test]
fn dissipation_is_never_negative_and_closes_the_work_of_a_period_with_order_two() {
    for law in frictions(0.0) {
        for direction in normals() {
            let open = |steps| {
                let mut history = History::new(law.clone(), direction);
                let amplitudes = [25e-6, 1.2 * direction.static_approach()];
                period(&mut history, steps, amplitudes);
                let [work, friction, impact, _] = period(&mut history, steps, amplitudes);
                ((work - friction - impact).abs(), friction + impact)
            };
            let ((coarse, _), (fine, whole)) = (open(500), open(4000));
            // Gradual laws fall behind order two where the limit grows from nothing, after the bodies have met.
            let factor = if law.has_stick() { 20.0 } else { 9.0 };
            assert!(
                fine < coarse / factor || fine < 1e-6 * whole,
                "{coarse:e} to {fine:e}: {law:?}, {direction:?}"
            );
            assert!(fine < 2e-4 * whole, "{fine:e} of {whole:e}");
        }
    }
}

/// Along the straight way of one step the normal direction's energies close to round-off, with as fine a quadrature as
/// needed for the work.
#[test]
fn within_a_step_work_against_the_normal_force_is_kept_or_dissipated() {
    for direction in normals() {
        let mut history = History::new(Arc::new(Jenkins::new(3.95e6, 0.6).unwrap()), direction);
        let parting = direction.static_approach();
        for (rate, opening) in [(-0.02, -0.4), (-0.05, -0.9), (0.03, -0.2), (0.06, 0.5)] {
            let from = [history.state[1], history.state[3]];
            let to = [opening * parting, rate];
            let inputs =
                stickslip::contact::SlipSlapInputs { displacement: [0.0, to[0]], velocity: [0.0, to[1]] };
            // The rates belong to the way, or no energy is dissipated.
            let response = history.go(inputs);
            let parts = 20_000;
            let force = |part: f64| {
                let at = |i: usize| from[i] + part / f64::from(parts) * (to[i] - from[i]);
                direction.force(at(0), at(1))
            };
            let work: f64 = (0..parts).map(|part| force(f64::from(part) + 0.5)).sum::<f64>()
                * (from[0] - to[0])
                / f64::from(parts);
            let kept = direction.stored_energy(to[0]) - direction.stored_energy(from[0]);
            let expected = (work - kept).max(0.0);
            close(response.impact_energy, expected, 1e-8 * PRELOAD * parting);
        }
    }
}

/// Into contact and out again: the force is zero at both ends of the loop, and what it encloses is dissipated.
#[test]
fn hunt_and_crossleys_loop_closes_at_zero_force_and_encloses_the_impact_energy() {
    let damping = 30.0;
    let direction = normal(NormalLaw::Hertz { exponent: 1.5 }, damping);
    let (depth, omega, parting) = (8e-6, 600.0, direction.static_approach());
    let mut history = History::new(Arc::new(Jenkins::new(3.95e6, 0.6).unwrap()), direction);
    let at = |phase: f64| stickslip::contact::SlipSlapInputs {
        displacement: [0.0, parting - depth * phase.sin()],
        velocity: [0.0, -depth * omega * phase.cos()],
    };
    history.go(at(-0.2));
    let (steps, mut energy) = (4000, 0.0);
    let mut forces = Vec::new();
    for step in 0..=steps {
        let response = history.go(at(std::f64::consts::PI * f64::from(step) / f64::from(steps)));
        energy += response.impact_energy;
        forces.push(response.normal_force);
    }
    assert!(forces[0] < 1e-9 && forces[steps as usize] < 1e-9);
    // λ ∫ K δ^p δ̇² dt with δ = D sin φ: λ K D^(p+2) ω ∫ sin^p cos² dφ, by the midpoint rule.
    let constant = PRELOAD / parting.powf(1.5);
    let nodes = 100_000;
    let integral: f64 = (0..nodes)
        .map(|node| std::f64::consts::PI * (f64::from(node) + 0.5) / f64::from(nodes))
        .map(|phase| phase.sin().powf(1.5) * phase.cos() * phase.cos())
        .sum::<f64>()
        * std::f64::consts::PI
        / f64::from(nodes);
    let expected = damping * constant * depth.powf(3.5) * omega * integral;
    close(energy, expected, 1e-5 * expected);
}
