//! The variational equation of any law: the tangents of its steps.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use super::signal::{evaluate, turning_points};
use super::{as_matrix, unit_columns};
use crate::contact::{ContactLaw, Inputs, Period, PeriodicSolver, StateTangents};
use crate::integrate::oscillator::polynomial::{DEGREE, Series};
use crate::integrate::oscillator::system::{System, dot};
use crate::integrate::{LoadedContact, OscillatorError};

/// Grids tried, each with half the steps of the one before.
const LEVELS: usize = 7;
/// The map has settled where the last extrapolations differ by this share of it.
const SETTLED: f64 = 1e-10;
/// Still accepted on the finest grid.
const ACCEPTED: f64 = 1e-6;

/// Derivatives of one step of a law.
#[derive(Default)]
struct Step {
    by_displacement: f64,
    by_velocity: f64,
    state: StateTangents,
}

pub(super) fn monodromy(
    system: &System,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
) -> Result<DMatrix<f64>, OscillatorError> {
    let longest = displacement.iter().map(|c| c.len()).max().unwrap_or(1);
    let base = (2 * longest).max(32);
    let mut grid: Vec<f64> = (0..=base).map(|k| TAU * k as f64 / base as f64).collect();
    displacement.iter().for_each(|c| grid.extend(turning_points(c)));
    grid.sort_by(f64::total_cmp);
    grid.dedup_by(|a, b| *a - *b < 1e-9);
    // The structure's own motion must be resolved by every step.
    let rate = system.longest_step(&vec![0.0; contacts.len()], 0.0) * angular_frequency;
    while grid.windows(2).any(|pair| pair[1] - pair[0] > rate) && grid.len() < 1 << 14 {
        grid = halved(&grid);
    }
    let mut rows: Vec<Vec<DMatrix<f64>>> = Vec::new();
    let mut change = f64::INFINITY;
    for level in 0..LEVELS {
        let mut row = vec![on_grid(system, contacts, displacement, angular_frequency, &grid)?];
        if let Some(before) = rows.last() {
            for k in 0..before.len() {
                let factor = 1.0 / (4f64.powi(k as i32 + 1) - 1.0);
                let better = &row[k] + (&row[k] - &before[k]) * factor;
                row.push(better);
            }
            let (last, previous) = (&row[row.len() - 1], &before[before.len() - 1]);
            change = (last - previous).amax() / last.amax().max(1.0);
        }
        rows.push(row);
        if change <= SETTLED || (level + 1 == LEVELS && change <= ACCEPTED) {
            let mut last = rows.pop().unwrap_or_default();
            let map = last.pop().ok_or(OscillatorError::Diverged { time: 0.0 })?;
            return Ok(without_conserved(&map, 2 * system.size));
        }
        grid = halved(&grid);
    }
    Err(OscillatorError::NotPeriodic { iterations: LEVELS, mismatch: change })
}

/// The map without the memory, from row `first` on, that a period leaves exactly as it was: what a stuck slider
/// remembers is neutral and no disturbance of the motion.
fn without_conserved(map: &DMatrix<f64>, first: usize) -> DMatrix<f64> {
    const EXACT: f64 = 1e-12;
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let conserved = |i: usize| (0..map.ncols()).all(|j| (map[(i, j)] - unit(i, j)).abs() <= EXACT);
    let kept: Vec<usize> = (0..map.nrows()).filter(|i| *i < first || !conserved(*i)).collect();
    map.select_rows(&kept).select_columns(&kept)
}

fn halved(grid: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(2 * grid.len());
    for pair in grid.windows(2) {
        out.extend([pair[0], 0.5 * (pair[0] + pair[1])]);
    }
    out.push(TAU);
    out
}

/// The map over the period on one grid.
fn on_grid(
    system: &System,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
    grid: &[f64],
) -> Result<DMatrix<f64>, OscillatorError> {
    let histories = contacts
        .iter()
        .zip(displacement)
        .map(|(contact, coefficients)| history(contact, coefficients, angular_frequency, grid))
        .collect::<Result<Vec<_>, _>>()?;
    let n = system.size;
    let count = contacts.len();
    let mut place = 2 * n;
    let places: Vec<usize> = contacts
        .iter()
        .map(|contact| {
            place += contact.law.state_len();
            place - contact.law.state_len()
        })
        .collect();
    // Forces of unit rise over a step, along each contact.
    let ramps: Vec<System> = (0..count).map(|i| system.driven_by_contact(i)).collect();
    let mut rise: Series = [0.0; DEGREE + 1];
    rise[1] = 1.0;
    let (none, zero) = (vec![0.0; count], vec![0.0; n]);
    let mut series = system.series();
    let mut columns = unit_columns(place);
    let mut forces = vec![vec![0.0; count]; place];
    let mut answers = vec![(vec![0.0; n], vec![0.0; n]); count];
    for k in 0..grid.len() {
        let h = if k == 0 { 0.0 } else { (grid[k] - grid[k - 1]) / angular_frequency };
        if k > 0 {
            for (ramp, (x, v)) in ramps.iter().zip(&mut answers) {
                ramp.expand(h, &zero, &zero, (&none, &none), Some(&rise), &mut series);
                system.at(&series, h, 1.0, x, v);
            }
        }
        let coupling = DMatrix::from_fn(count, count, |i, j| {
            let (step, row) = (&histories[i][k], &system.contacts[i]);
            let answer =
                step.by_displacement * dot(row, &answers[j].0) + step.by_velocity * dot(row, &answers[j].1);
            f64::from(u8::from(i == j)) - if k == 0 { 0.0 } else { answer }
        });
        let factors = coupling.lu();
        for (column, force) in columns.iter_mut().zip(&mut forces) {
            let (moving, memory) = column.split_at_mut(2 * n);
            let (x, v) = moving.split_at_mut(n);
            if k > 0 {
                system.expand(h, x, v, (&none, force), None, &mut series);
                system.at(&series, h, 1.0, x, v);
            }
            let mut change = DVector::from_fn(count, |i, _| {
                let (step, row) = (&histories[i][k], &system.contacts[i]);
                let state = &memory[places[i] - 2 * n..];
                let remembered = dot(&step.state.force_by_state, state);
                remembered + step.by_displacement * dot(row, x) + step.by_velocity * dot(row, v) - force[i]
            });
            if !factors.solve_mut(&mut change) {
                return Err(OscillatorError::Diverged { time: grid[k] / angular_frequency });
            }
            if k > 0 {
                for (j, (by_x, by_v)) in answers.iter().enumerate() {
                    x.iter_mut().zip(by_x).for_each(|(x, by)| *x += by * change[j]);
                    v.iter_mut().zip(by_v).for_each(|(v, by)| *v += by * change[j]);
                }
            }
            force.iter_mut().zip(change.iter()).for_each(|(force, change)| *force += change);
            for (i, row) in system.contacts.iter().enumerate() {
                let length = contacts[i].law.state_len();
                let state = &mut memory[places[i] - 2 * n..][..length];
                remember(&histories[i][k].state, dot(row, x), dot(row, v), state);
            }
        }
    }
    Ok(as_matrix(&columns))
}

/// The disturbed memory after a step.
fn remember(step: &StateTangents, displacement: f64, velocity: f64, state: &mut [f64]) {
    let before = state.to_vec();
    for (i, next) in state.iter_mut().enumerate() {
        let row = &step.next_by_state[i * before.len()..][..before.len()];
        *next = dot(row, &before)
            + step.next_by_displacement[i] * displacement
            + step.next_by_velocity[i] * velocity;
    }
}

/// Tangents at every point of the grid along the periodic state; the first point's step has no length.
fn history(
    contact: &LoadedContact,
    coefficients: &[f64],
    angular_frequency: f64,
    grid: &[f64],
) -> Result<Vec<Step>, OscillatorError> {
    let law: &dyn ContactLaw = contact.law;
    let (mut displacement, mut velocity) = (Vec::new(), Vec::new());
    for phase in grid {
        let (u, slope) = evaluate(coefficients, *phase);
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
    for (u, v) in displacement.iter().zip(&velocity) {
        let inputs = Inputs { displacement: *u, velocity: *v, normal_load: contact.normal_load };
        let mut step = Step::default();
        law.state_tangents(&state, inputs, &mut step.state);
        let response = law.step(&state, inputs, &mut next);
        step.by_displacement = response.tangents.displacement;
        step.by_velocity = response.tangents.velocity;
        state.copy_from_slice(&next);
        out.push(step);
    }
    Ok(out)
}
