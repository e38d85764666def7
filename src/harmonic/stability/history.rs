//! A contact along its periodic displacement: force and tangents at every phase of a grid, and the phases at which
//! its tangents jump.

use std::f64::consts::TAU;

use super::impulse::Impulse;
use super::regimes::Path;
use super::step::Step;
use crate::contact::{ContactLaw, Inputs, Period, PeriodicSolver, Slider};
use crate::time::exact::elements::Element;
use crate::time::{LoadedContact, OscillatorError};

/// Tangents at every point of the grid along the periodic state; the first point's step has no length. `motion` is the
/// displacement (m) and its derivative by phase. Where the force jumps there are `impulses` (behind a spring there are
/// none).
pub(super) fn history(
    contact: &LoadedContact,
    motion: &dyn Fn(f64) -> (f64, f64),
    angular_frequency: f64,
    grid: &[f64],
    impulses: bool,
) -> Result<Vec<Step>, OscillatorError> {
    let law: &dyn ContactLaw = contact.law;
    let (mut displacement, mut velocity) = (Vec::new(), Vec::new());
    for phase in grid {
        let (u, slope) = motion(*phase);
        displacement.push(u);
        velocity.push(angular_frequency * slope);
    }
    let loads = [contact.normal_load];
    let period = Period { displacement: &displacement[1..], velocity: &velocity[1..], normal_load: &loads };
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, contact.normal_load, 0.0, &mut state);
    PeriodicSolver::new()
        .solve(law, &period, &mut state)
        .map_err(|_| OscillatorError::NotPeriodic { iterations: 1, mismatch: f64::INFINITY })?;
    let mut next = state.clone();
    let mut out = Vec::with_capacity(grid.len());
    let mut found = Vec::new();
    for (k, (u, v)) in displacement.iter().zip(&velocity).enumerate() {
        let inputs = Inputs { displacement: *u, velocity: *v, normal_load: contact.normal_load };
        if impulses
            && k > 0
            && let Some(impulse) = Impulse::on_the_way(contact, &state, displacement[k - 1], inputs)
        {
            let apart = |k: usize| (displacement[k] - impulse.displacement).abs();
            found.push((if apart(k) <= apart(k - 1) { k } else { k - 1 }, impulse));
        }
        let mut step = Step::default();
        law.state_tangents(&state, inputs, &mut step.state);
        let response = law.step(&state, inputs, &mut next);
        step.force = response.force;
        step.by_displacement = response.tangents.displacement;
        step.by_velocity = response.tangents.velocity;
        state.copy_from_slice(&next);
        out.push(step);
    }
    for (k, impulse) in found {
        let width = grid[(k + 1).min(grid.len() - 1)] - grid[k.saturating_sub(1)];
        impulse.act(0.5 * width / angular_frequency, &mut out[k]);
    }
    Ok(out)
}

/// Phases in [0, 2π) at which sliders begin to slip or leave their play: what a disturbance of the displacement does
/// to the force jumps there. None for laws without sliders.
pub(super) fn jumps(contact: &LoadedContact, coefficients: &[f64]) -> Vec<f64> {
    let mut sliders: Vec<Slider> = Vec::new();
    if contact.law.sliders_and_damper(contact.normal_load, &mut sliders).is_none() {
        return Vec::new();
    }
    let acts = |slider: &Slider| slider.upper_limit > 0.0 || slider.lower_limit > 0.0;
    let elements = sliders.into_iter().filter(acts).map(|slider| Element { contact: 0, slider }).collect();
    Path::new(0, coefficients, 0, elements).jumps().into_iter().map(|phase| phase.rem_euclid(TAU)).collect()
}
