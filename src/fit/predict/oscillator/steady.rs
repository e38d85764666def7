//! The periodic state of an oscillator: Newton's method on displacements and velocities, while the contact's memory
//! follows period by period.
//!
//! A contact that slips forgets where it was within a period, and one that sticks keeps what it remembers: neither
//! needs Newton's method, while a lightly damped structure would need hundreds of periods without.

use nalgebra::{DMatrix, DVector};

use super::run::Run;

/// Newton steps before the search is given up.
const MOST_STEPS: usize = 40;
/// Periods run before the first Newton step, so that the contact has found its loop.
const FIRST_PERIODS: usize = 3;
/// Change over a period, as share of the motion, that counts as none.
const PERIODIC: f64 = 1e-9;
/// Change over a period that is still well below any noise, where the steps no longer help.
const NEARLY: f64 = 1e-5;
/// Step of the differences, as share of the motion.
const DIFFERENCE: f64 = 1e-6;

/// The state at the first sample of the periodic motion over `samples` samples; from `start` if there is one.
pub(super) fn periodic(run: &mut Run, start: Option<&[f64]>, samples: usize) -> Result<Vec<f64>, String> {
    let n = run.size();
    let rest = run.rest();
    // A neighbour may have another mass hanging at its contact.
    let mut state = match start {
        Some(start) if start.len() == rest.len() => start.to_vec(),
        _ => rest,
    };
    if start.is_none() {
        for _ in 0..FIRST_PERIODS {
            over_a_period(run, &mut state, samples)?;
        }
    }
    let mut mismatch = f64::INFINITY;
    let mut best: Option<(f64, Vec<f64>)> = None;
    for _ in 0..MOST_STEPS {
        let mut end = state.clone();
        let scales = over_a_period(run, &mut end, samples)?;
        mismatch = change(&state, &end, &scales, n);
        if best.as_ref().is_none_or(|(least, _)| mismatch < *least) {
            best = Some((mismatch, end.clone()));
        }
        if mismatch <= PERIODIC {
            return Ok(end);
        }
        let correction = newton(run, &state, &end, &scales, samples)?;
        state = end;
        for (x, correction) in state[..2 * n].iter_mut().zip(correction.iter()) {
            *x += correction;
        }
        run.settle(&mut state);
    }
    match best {
        Some((least, end)) if least <= NEARLY => Ok(end),
        _ => Err(format!(
            "no periodic motion was found: over a period it still changes by {mismatch:.1e} of itself"
        )),
    }
}

/// Runs `state` over a period; returns the largest displacement and velocity on the way.
fn over_a_period(run: &mut Run, state: &mut [f64], samples: usize) -> Result<[f64; 2], String> {
    let n = run.size();
    let mut largest = [0.0_f64; 2];
    for index in 0..samples {
        run.advance(state, index)?;
        for (largest, part) in largest.iter_mut().zip(state.chunks_exact(n)) {
            *largest = part.iter().fold(*largest, |largest, x| largest.max(x.abs()));
        }
    }
    Ok(largest.map(|largest| if largest > 0.0 { largest } else { 1.0 }))
}

fn change(start: &[f64], end: &[f64], scales: &[f64; 2], n: usize) -> f64 {
    let pairs = start[..2 * n].iter().zip(&end[..2 * n]).enumerate();
    pairs.map(|(i, (a, b))| (a - b).abs() / scales[i / n]).fold(0.0, f64::max)
}

/// What to add to the end of a period, by differences of the period map.
fn newton(
    run: &mut Run,
    state: &[f64],
    end: &[f64],
    scales: &[f64; 2],
    samples: usize,
) -> Result<DVector<f64>, String> {
    let n = run.size();
    let mut system = DMatrix::zeros(2 * n, 2 * n);
    for j in 0..2 * n {
        let step = DIFFERENCE * scales[j / n];
        let mut moved = state.to_vec();
        moved[j] += step;
        over_a_period(run, &mut moved, samples)?;
        for i in 0..2 * n {
            let derivative = (moved[i] - end[i]) / step;
            // In units of the motion, so that displacements and velocities weigh alike.
            let unit = scales[j / n] / scales[i / n];
            system[(i, j)] = (if i == j { 1.0 } else { 0.0 }) - derivative * unit;
        }
    }
    // x* = P(x*) ≈ P(x) + P' (x* − x) gives (1 − P') (x* − P(x)) = P' (P(x) − x).
    let moved = DVector::from_fn(2 * n, |i, _| (end[i] - state[i]) / scales[i / n]);
    let right = &moved - &system * &moved;
    let solved = system.svd(true, true).solve(&right, 1e-12).map_err(str::to_owned)?;
    Ok(DVector::from_fn(2 * n, |i, _| solved[i] * scales[i / n]))
}
