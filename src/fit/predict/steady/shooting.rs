//! The periodic state of an oscillator: Newton's method on displacements and velocities, while the contact's memory
//! follows period by period.
//!
//! A contact that slips forgets where it was within a period, and one that sticks keeps what it remembers: neither
//! needs Newton's method, while a lightly damped structure would need hundreds of periods without.

use nalgebra::{DMatrix, DVector};

use crate::data::{Channel, Record};
use crate::fit::predict::stepper::system::{ExcitedSystem, SystemStepper};
use crate::fit::predict::stepper::{Stepper, march};
use crate::model::Model;
use crate::time::Motion;

/// Newton steps before the search is given up.
const MOST_STEPS: usize = 40;
/// Periods run before the first Newton step, so that the contact has found its loop.
const FIRST_PERIODS: usize = 3;
/// Change over a period, as a fraction of the motion, that counts as none.
const PERIODIC: f64 = 1e-9;
/// Change over a period that is still well below any noise, where the steps no longer help.
const NEARLY: f64 = 1e-5;
/// Step of the differences, as a fraction of the motion.
const DIFFERENCE: f64 = 1e-6;

/// A steady record of an oscillator: one period is stepped through, the others are like it.
pub(super) struct ShotOscillator {
    oscillator: ExcitedSystem,
    channels: usize,
    samples: usize,
    /// Where the search for a steady state begins.
    start: Option<Motion>,
}

impl ShotOscillator {
    /// Of `channels` of `record`, for models with the masses of `model`.
    pub fn new(model: &Model, record: &Record, channels: &[&Channel]) -> Result<Self, String> {
        let oscillator = ExcitedSystem::new(model, record, channels)?;
        Ok(Self { oscillator, channels: channels.len(), samples: record.len(), start: None })
    }

    /// Writes the predictions; returns the motion at the first sample.
    pub fn simulate(&self, model: &Model, out: &mut Vec<f64>) -> Result<Motion, String> {
        let mut stepper = self.oscillator.stepper(model)?;
        let period = self.oscillator.excitation.samples;
        shoot(&mut stepper, self.start.as_ref(), period)?;
        let first = stepper.motion().clone();
        let mut one = Vec::new();
        march(&mut stepper, self.channels, period, &mut one)?;
        out.clear();
        for channel in one.chunks_exact(period) {
            out.extend(channel.iter().cycle().take(self.samples));
        }
        Ok(first)
    }

    /// The same; the motion is the start of what follows.
    pub fn settle(&mut self, model: &Model, out: &mut Vec<f64>) -> Result<(), String> {
        self.start = Some(self.simulate(model, out)?);
        Ok(())
    }
}

/// Brings `stepper` to the first sample of the periodic motion over `samples` samples; from `start` if there is one.
fn shoot(stepper: &mut SystemStepper, start: Option<&Motion>, samples: usize) -> Result<(), String> {
    // A neighbour may have another mass hanging at its contact.
    if let Some(start) = start.filter(|start| start.state_len() == stepper.motion().state_len()) {
        stepper.set(start);
    }
    if start.is_none() {
        for _ in 0..FIRST_PERIODS {
            over_a_period(stepper, samples)?;
        }
    }
    let mut mismatch = f64::INFINITY;
    let mut best: Option<(f64, Motion)> = None;
    for _ in 0..MOST_STEPS {
        let begin = stepper.motion().clone();
        let scales = over_a_period(stepper, samples)?;
        let end = stepper.motion().clone();
        mismatch = change(&begin, &end, &scales);
        if best.as_ref().is_none_or(|(least, _)| mismatch < *least) {
            best = Some((mismatch, end.clone()));
        }
        if mismatch <= PERIODIC {
            return Ok(());
        }
        let correction = newton(stepper, &begin, &end, &scales, samples)?;
        let mut corrected = end;
        for (x, correction) in corrected.modal_state_mut().iter_mut().zip(correction.iter()) {
            *x += correction;
        }
        stepper.settle(&corrected)?;
    }
    match best {
        Some((least, end)) if least <= NEARLY => {
            stepper.set(&end);
            Ok(())
        }
        _ => Err(format!(
            "no periodic motion was found: over a period it still changes by {mismatch:.1e} of itself"
        )),
    }
}

/// Steps over a period; returns the largest modal displacement and velocity on the way.
fn over_a_period(stepper: &mut SystemStepper, samples: usize) -> Result<[f64; 2], String> {
    let mut largest = [0.0_f64; 2];
    for index in 0..samples {
        stepper.advance(index)?;
        let motion = stepper.motion();
        let motion = [motion.modal_displacement(), motion.modal_velocity()];
        for (largest, part) in largest.iter_mut().zip(motion) {
            *largest = part.iter().fold(*largest, |largest, x| largest.max(x.abs()));
        }
    }
    Ok(largest.map(|largest| if largest > 0.0 { largest } else { 1.0 }))
}

fn change(start: &Motion, end: &Motion, scales: &[f64; 2]) -> f64 {
    let n = start.modes();
    let pairs = start.modal_state().iter().zip(end.modal_state()).enumerate();
    pairs.map(|(i, (a, b))| (a - b).abs() / scales[i / n]).fold(0.0, f64::max)
}

/// What to add to the end of a period, by differences of the period map.
fn newton(
    stepper: &mut SystemStepper,
    begin: &Motion,
    end: &Motion,
    scales: &[f64; 2],
    samples: usize,
) -> Result<DVector<f64>, String> {
    let n = begin.modes();
    let (begun, ended) = (begin.modal_state(), end.modal_state());
    let mut moved = begin.clone();
    let mut system = DMatrix::zeros(2 * n, 2 * n);
    for j in 0..2 * n {
        let step = DIFFERENCE * scales[j / n];
        moved.clone_from(begin);
        moved.modal_state_mut()[j] += step;
        stepper.set(&moved);
        over_a_period(stepper, samples)?;
        let after = stepper.motion().modal_state();
        for i in 0..2 * n {
            let derivative = (after[i] - ended[i]) / step;
            // In units of the motion, so that displacements and velocities weigh alike.
            let unit = scales[j / n] / scales[i / n];
            system[(i, j)] = (if i == j { 1.0 } else { 0.0 }) - derivative * unit;
        }
    }
    // x* = P(x*) ≈ P(x) + P' (x* − x) gives (1 − P') (x* − P(x)) = P' (P(x) − x).
    let moved = DVector::from_fn(2 * n, |i, _| (ended[i] - begun[i]) / scales[i / n]);
    let right = &moved - &system * &moved;
    let solved = system.svd(true, true).solve(&right, 1e-12).map_err(str::to_owned)?;
    Ok(DVector::from_fn(2 * n, |i, _| solved[i] * scales[i / n]))
}
