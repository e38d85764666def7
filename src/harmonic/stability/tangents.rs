//! The variational equation of any law: the tangents of its steps on a grid, the structure exactly between two
//! phases under forces that run linearly, extrapolated until the map settles.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix};

use super::budget::Budget;
use super::disturbed::Disturbed;
use super::feedback::Feedback;
use crate::numeric::balancing::balance;
use crate::time::OscillatorError;
use crate::time::exact::multipliers;
use crate::time::exact::polynomial::{DEGREE, Series};
use crate::time::exact::system::System;

/// Grids tried that resolve the structure's own motion, each with half the steps of the one before.
const LEVELS: usize = 7;
/// The multipliers have settled where the last extrapolations differ by so much.
const SETTLED: f64 = 1e-10;
/// Still accepted on the finest grid.
const ACCEPTED: f64 = 1e-6;
/// Phases (rad) closer than this are the same.
const SAME_PHASE: f64 = 1e-10;
/// Most steps of a period.
const MOST_STEPS: usize = 1 << 16;

/// Cost of a step beyond its products, in multiplications.
const LEAST_STEP: usize = 4000;

/// The multipliers over a period. `enough` sees them all, each better than the last, and says whether they are good
/// enough, which they can be only on a grid that resolves the structure's own motion.
pub(super) fn multipliers_of(
    motion: &Disturbed,
    enough: &mut dyn FnMut(&[Complex<f64>]) -> bool,
    mut budget: Budget,
) -> Result<Vec<Complex<f64>>, OscillatorError> {
    let system = motion.system.as_ref();
    let period = TAU / motion.angular_frequency;
    let mut grid = first_grid(motion);
    // The structure's own motion must be resolved by every step.
    let longest = system.longest_step(&vec![0.0; system.contacts.len()], 0.0) * motion.angular_frequency;
    if TAU / longest >= MOST_STEPS as f64 {
        return Err(OscillatorError::TooManySteps { limit: MOST_STEPS, time: 0.0 });
    }
    // What a step costs at least, and its products.
    let (moving, channels) = (2 * system.size, system.contacts.len());
    let all = moving + motion.memory;
    let step = (LEAST_STEP + (moving + 2 * channels) * moving * all + 4 * channels * channels * all) as f64;
    // The deepest level asked for is the second on which all is resolved: no use beginning what cannot get there.
    let least = 2.0 * (TAU / longest).max(grid.len() as f64) * step;
    budget.allow(least, period)?;
    let resolved = |grid: &[f64]| grid.windows(2).all(|pair| pair[1] - pair[0] <= longest);
    let base: f64 = if motion.first_order() { 2.0 } else { 4.0 };
    let mut before: Vec<DMatrix<f64>> = Vec::new();
    let mut known: Vec<Complex<f64>> = Vec::new();
    let (mut change, mut levels) = (f64::INFINITY, 0);
    while levels < LEVELS && grid.len() < MOST_STEPS {
        if let Err(too_long) = budget.spend(grid.len() as f64 * step, period) {
            return if levels > 0 && change <= ACCEPTED { Ok(known) } else { Err(too_long) };
        }
        let row = extrapolated(on_grid(motion, &grid)?, &before, base);
        let fine = resolved(&grid);
        let (last, kept) = without_conserved(row.last().unwrap_or(&row[0]), 2 * system.size);
        let (last, scales) = balance(last);
        let of_map = before.last().map_or(f64::INFINITY, |previous| {
            let scaled = |i: usize, j: usize| previous[(kept[i], kept[j])] * scales[j] / scales[i];
            let places = (0..kept.len()).flat_map(|j| (0..kept.len()).map(move |i| (i, j)));
            let changes = places.map(|(i, j)| (scaled(i, j) - last[(i, j)]).abs());
            changes.fold(0.0, f64::max) / last.amax().max(1.0)
        });
        let found =
            multipliers(last).ok_or(OscillatorError::Diverged { time: TAU / motion.angular_frequency })?;
        // A map may differ in what the period forgets at once.
        change = of_map.min(distance(&found, &known));
        let enough = enough(&found);
        if fine && !before.is_empty() {
            levels += 1;
            if change <= SETTLED || enough || (levels == LEVELS && change <= ACCEPTED) {
                return Ok(found);
            }
        }
        known = found;
        before = row;
        grid = halved(&grid);
    }
    Err(OscillatorError::NotPeriodic { iterations: levels, mismatch: change })
}

/// A map and its extrapolations (Romberg) by those `before`, from a grid of half the phases; halving a step divides the
/// error of a map by `base`.
fn extrapolated(map: DMatrix<f64>, before: &[DMatrix<f64>], base: f64) -> Vec<DMatrix<f64>> {
    let mut row = vec![map];
    for (k, before) in before.iter().enumerate() {
        let factor = 1.0 / (base.powi(k as i32 + 1) - 1.0);
        let better = &row[k] + (&row[k] - before) * factor;
        row.push(better);
    }
    row
}

/// Largest distance of a multiplier from all those known, of those that matter.
fn distance(found: &[Complex<f64>], known: &[Complex<f64>]) -> f64 {
    const VANISHING: f64 = 1e-6;
    let nearest = |m: &Complex<f64>| known.iter().map(|k| (m - k).norm()).fold(f64::INFINITY, f64::min);
    let largest = found.first().map_or(0.0, |first| first.norm()).max(1.0);
    found.iter().filter(|m| m.norm() > VANISHING * largest).map(nearest).fold(0.0, f64::max) / largest
}

fn first_grid(motion: &Disturbed) -> Vec<f64> {
    let base = (2 * motion.coefficients()).max(32);
    let mut grid: Vec<f64> = (0..=base).map(|k| TAU * k as f64 / base as f64).collect();
    grid.extend(motion.events().into_iter().map(|phase| phase.rem_euclid(TAU)));
    grid.sort_by(f64::total_cmp);
    grid.dedup_by(|a, b| *a - *b < SAME_PHASE);
    grid
}

/// The map without the memory, from row `first` on, that a period leaves exactly as it was: what a stuck slider
/// remembers is neutral and no disturbance of the motion. With the rows kept.
fn without_conserved(map: &DMatrix<f64>, first: usize) -> (DMatrix<f64>, Vec<usize>) {
    const EXACT: f64 = 1e-12;
    let unit = |i: usize, j: usize| f64::from(u8::from(i == j));
    let conserved = |i: usize| (0..map.ncols()).all(|j| (map[(i, j)] - unit(i, j)).abs() <= EXACT);
    let kept: Vec<usize> = (0..map.nrows()).filter(|i| *i < first || !conserved(*i)).collect();
    (map.select_rows(&kept).select_columns(&kept), kept)
}

fn halved(grid: &[f64]) -> Vec<f64> {
    let mut out = Vec::with_capacity(2 * grid.len());
    for pair in grid.windows(2) {
        out.extend([pair[0], 0.5 * (pair[0] + pair[1])]);
    }
    out.push(TAU);
    out
}

/// The structure's motion over a step: displacements above velocities.
struct Propagator {
    /// Length of the step (s).
    duration: f64,
    /// Without forces.
    free: DMatrix<f64>,
    /// Under constant forces along the channels, and under forces that rise by 1.
    held: DMatrix<f64>,
    rising: DMatrix<f64>,
    /// Displacements and velocities of the channels under rising forces.
    seen: DMatrix<f64>,
}

impl Propagator {
    fn new(system: &System, driven: &[System], channels: &DMatrix<f64>, duration: f64) -> Self {
        let (n, m) = (system.size, channels.nrows());
        let none = vec![0.0; m];
        // Long steps are doubled from short ones, whose series converges.
        let longest = system.longest_step(&none, 0.0);
        let doublings = (duration / longest).log2().ceil().max(0.0) as i32;
        let h = duration / 2f64.powi(doublings);
        let mut rise: Series = [0.0; DEGREE + 1];
        let mut series = system.series();
        let (mut x, mut v) = (vec![0.0; n], vec![0.0; n]);
        let zero = vec![0.0; n];
        let mut column = |system: &System, x0: &[f64], v0: &[f64], force: &Series| {
            system.expand(h, x0, v0, (&none, &none), Some(force), &mut series);
            system.at(&series, h, 1.0, &mut x, &mut v);
            [x.as_slice(), &v].concat()
        };
        let unforced = rise;
        let mut free = Vec::with_capacity(2 * n);
        for k in 0..2 * n {
            let mut unit = vec![0.0; 2 * n];
            unit[k] = 1.0;
            free.push(column(system, &unit[..n], &unit[n..], &unforced));
        }
        let mut under = |force: &Series| -> Vec<Vec<f64>> {
            driven.iter().map(|system| column(system, &zero, &zero, force)).collect()
        };
        rise[1] = 1.0;
        let rising = under(&rise);
        (rise[0], rise[1]) = (1.0, 0.0);
        let held = under(&rise);
        let matrix = |columns: &[Vec<f64>]| DMatrix::from_fn(2 * n, columns.len(), |i, j| columns[j][i]);
        let (mut free, mut held, mut rising) = (matrix(&free), matrix(&held), matrix(&rising));
        for _ in 0..doublings {
            // Half the rise in the first half; then what it has reached, held, and the other half.
            rising = (&free * &rising + &held + &rising) * 0.5;
            held = &free * &held + &held;
            free = &free * &free;
        }
        let mut seen = DMatrix::zeros(2 * m, m);
        seen.rows_mut(0, m).copy_from(&(channels * rising.rows(0, n)));
        seen.rows_mut(m, m).copy_from(&(channels * rising.rows(n, n)));
        Self { duration, free, held, rising, seen }
    }
}

/// The map over the period on one grid.
fn on_grid(motion: &Disturbed, grid: &[f64]) -> Result<DMatrix<f64>, OscillatorError> {
    const SAME_STEP: f64 = 1e-11;
    let (system, angular_frequency) = (motion.system.as_ref(), motion.angular_frequency);
    let feedback = motion.feedback(grid)?;
    let (n, m) = (system.size, system.contacts.len());
    let size = 2 * n + motion.memory;
    let channels = DMatrix::from_fn(m, n, |i, j| system.contacts[i][j]);
    let driven: Vec<System> = (0..m).map(|i| system.driven_by_contact(i)).collect();
    let mut propagators: Vec<Propagator> = Vec::new();
    let mut moving = DMatrix::<f64>::identity(2 * n, size);
    // Displacements and velocities of the channels, then memory.
    let mut seen = DMatrix::<f64>::zeros(2 * m + motion.memory, size);
    (0..motion.memory).for_each(|k| seen[(2 * m + k, 2 * n + k)] = 1.0);
    let mut force = DMatrix::<f64>::zeros(m, size);
    let (mut ahead, mut change) = (moving.clone(), force.clone());
    let mut memory = DMatrix::<f64>::zeros(motion.memory, size);
    for (k, Feedback { force: forces, memory: memories, .. }) in feedback.iter().enumerate() {
        let step = if k == 0 {
            None
        } else {
            let h = (grid[k] - grid[k - 1]) / angular_frequency;
            let known = propagators.iter().position(|p| (p.duration - h).abs() <= SAME_STEP * h);
            let place = known.unwrap_or_else(|| {
                propagators.push(Propagator::new(system, &driven, &channels, h));
                propagators.len() - 1
            });
            Some(&propagators[place])
        };
        if let Some(step) = step {
            ahead.gemm(1.0, &step.free, &moving, 0.0);
            ahead.gemm(1.0, &step.held, &force, 1.0);
            std::mem::swap(&mut ahead, &mut moving);
        }
        seen.rows_mut(0, m).gemm(1.0, &channels, &moving.rows(0, n), 0.0);
        seen.rows_mut(m, m).gemm(1.0, &channels, &moving.rows(n, n), 0.0);
        change.copy_from(&force);
        change.gemm(1.0, forces, &seen, -1.0);
        if let Some(step) = step {
            let mut coupling = DMatrix::<f64>::identity(m, m);
            coupling.gemm(-1.0, &forces.columns(0, 2 * m), &step.seen, 1.0);
            if !coupling.lu().solve_mut(&mut change) {
                return Err(OscillatorError::Diverged { time: grid[k] / angular_frequency });
            }
            moving.gemm(1.0, &step.rising, &change, 1.0);
            seen.rows_mut(0, 2 * m).gemm(1.0, &step.seen, &change, 1.0);
        }
        force += &change;
        memory.gemm(1.0, memories, &seen, 0.0);
        seen.rows_mut(2 * m, memory.nrows()).copy_from(&memory);
    }
    let mut map = DMatrix::zeros(size, size);
    map.rows_mut(0, 2 * n).copy_from(&moving);
    map.rows_mut(2 * n, memory.nrows()).copy_from(&memory);
    Ok(map)
}
