//! The error of the steps in time, and of the harmonics that are left out, taken off the parameters: fits repeat simulations
//! a thousand times, with an error that lies far below the noise of one sample, but not of all of them.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::evidence::joint::{Joint, dot, minus};
use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::{Measured, MeasuredChannel};
use crate::diagnose::evidence::posterior::{HERE, Posterior, white_round};
use crate::diagnose::evidence::slot::Slot;
use crate::model::{Model, Structure};

/// Steps in place of one; simulations that cannot be refined so far go as far as they can.
const FINER: usize = 8;
/// Moves at most: an error of many deviations, which may be small, is not taken off to first order.
const MOVES: usize = 2;
/// A move, in deviations, that is none.
const NEGLIGIBLE: f64 = 0.01;

/// Error of the steps in time over the noise, at most: half of a tenth, as what a model lacks may double it.
const UNNOTICED: f64 = 0.05;

/// Steps in place of one that simulations of each record need for an error of the steps far below the noise, by predictions
/// under `model`; one where that cannot be told.
pub(in crate::diagnose) fn steps_needed(data: &Measured, model: &Model) -> Vec<usize> {
    let needed = |k: usize| needed(data, k, model).unwrap_or(1);
    (0..data.records.len()).into_par_iter().map(needed).collect()
}

fn needed(data: &Measured, k: usize, model: &Model) -> Result<usize, String> {
    let lane = data.lane(k);
    // What is moved as measured, or solved for, takes no steps.
    if model.structure == Structure::Prescribed || lane.seed.is_some() {
        return Ok(1);
    }
    data.bench.unless_interrupted()?;
    let mut shown = lane.shown(model)?;
    let start = shown.settle(model)?;
    let (mut plain, mut fine) = (Vec::new(), Vec::new());
    shown.predict(model, &start, &mut plain)?;
    shown.refine(FINER);
    shown.predict(model, &start, &mut fine)?;
    data.bench.count(1 + FINER);
    let error = minus(&fine, &plain);
    let over_noise = |channel: &MeasuredChannel| {
        let error = &error[channel.range.clone()];
        (dot(error, error) / error.len() as f64).sqrt() / channel.prior.deviation
    };
    let largest = data.channels[k].iter().map(over_noise).fold(0.0, f64::max);
    // Of second order.
    let needed = (largest / UNNOTICED).sqrt().ceil();
    Ok((needed as usize).clamp(1, FINER))
}

/// `posterior` moved to where refined simulations fit best: unknowns at their bounds stay there, and so does all of it where
/// refined simulations leave more there than the others did, as another of several responses would. Records that cannot be
/// refined count as they are. The search before ends where the error of its own steps holds it up, a deviation and more away.
/// One that is in the `middle` of a likelihood without a smooth top moves by what the error alone changes.
pub(super) fn refined(data: &Measured, posterior: &Posterior, middle: bool) -> Result<Posterior, String> {
    if posterior.model.structure == Structure::Prescribed {
        return Ok(posterior.clone());
    }
    let (latent, count) = (Latent::default(), posterior.unknowns.len());
    let mut joint = Joint::new(data, &posterior.model, &posterior.unknowns, &latent)?;
    let y = white_round(&mut joint, &posterior.y[..count], HERE)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    let mut y = if middle { Refined::at(&mut joint, &y, false)?.moved } else { best_fit(&mut joint, y) };
    y.truncate(count);
    Ok(Posterior { model: joint.model(&y)?, y, ..posterior.clone() })
}

/// Where refined predictions fit best, from the point `y` that was linearised.
fn best_fit(joint: &mut Joint, mut y: Vec<f64>) -> Vec<f64> {
    let (mut best, mut least) = (y.clone(), joint.sums_here(&y).cost);
    for _ in 0..=MOVES {
        let Ok(there) = Refined::at(joint, &y, true) else { break };
        if there.cost < least {
            (best, least) = (y, there.cost);
        }
        y = there.moved;
        if there.deviations < NEGLIGIBLE || joint.minimise(&mut y, HERE).is_err() {
            break;
        }
    }
    best
}

/// What refined predictions say at a point.
struct Refined {
    /// Half the sum of squares, of residuals and of the unknowns.
    cost: f64,
    /// Where predictions that change with the unknowns as those at the point fit best.
    moved: Vec<f64>,
    /// How far that is, in deviations.
    deviations: f64,
}

impl Refined {
    /// At the point `y` that was linearised, moved from there by the `whole` slope, or by what the error adds to it.
    fn at(joint: &mut Joint, y: &[f64], whole: bool) -> Result<Self, String> {
        let (data, n) = (joint.data, y.len());
        let (sums, model, whitened) = (joint.sums_here(y), joint.model(y)?, joint.whitened());
        let error = |slot: &mut Slot| {
            data.bench.unless_interrupted().and_then(|()| slot.step_error(&model, y, FINER)).ok()
        };
        let errors: Vec<Option<Vec<f64>>> = joint.slots.par_iter_mut().map(error).collect();
        data.bench.unless_interrupted()?;
        data.bench.count(FINER * whitened.len());
        let mut cost = sums.cost;
        let mut gradient = if whole { DVector::from_vec(sums.gradient) } else { DVector::zeros(n) };
        for (k, (record, error)) in whitened.iter().zip(errors).enumerate() {
            let Some(error) = error else { continue };
            let error = joint.noise.whiten(data, k, &error);
            cost += dot(&record.residuals, &error) + 0.5 * dot(&error, &error);
            record.columns.iter().for_each(|(i, column)| gradient[*i] += dot(column, &error));
        }
        let mut curvature = DMatrix::from_row_slice(n, n, &sums.curvature);
        joint.hold(y, &mut curvature).into_iter().for_each(|i| gradient[i] = 0.0);
        let factor = curvature.cholesky().ok_or("the curvature is not positive")?;
        let step = factor.solve(&gradient);
        let deviations = step.dot(&gradient).sqrt();
        if !deviations.is_finite() {
            return Err("the error of the predictions is not finite".to_owned());
        }
        let (lower, upper) = joint.bounds();
        let inside = |i: usize| (y[i] - step[i]).max(lower[i]).min(upper[i]);
        Ok(Self { cost, moved: (0..n).map(inside).collect(), deviations })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::samples::{from_rest, oscillator};
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::ObservedSimulation;

    fn beam(stiffness: f64, friction: f64) -> Model {
        Model::parse(&format!(
            "schema = \"stickslip.model/1\"\nkind = \"beam\"\nsupport = {{ offset = 0.006 }}\nexcitation = {{ position = 0.55 }}\n\
             [beam]\nlength = 0.6\nwidth = 0.04\nthickness = 0.005\ndensity = 7850.0\nyoungs_modulus = 1.94e11\nmodes = 3\n\
             damping_ratio = 0.004\npoint_mass = [{{ position = 0.55, mass = 0.025 }}]\n[contact]\nlaw = \"jenkins\"\n\
             tangential_stiffness = {stiffness}\nfriction_coefficient = {friction}\nnormal_load = 150.0\n"
        ))
        .unwrap()
    }

    fn channel(name: &str, unit: &'static str, values: Vec<f64>) -> Channel {
        Channel { name: name.into(), unit, values, noise: None }
    }

    /// In a steady state under a cosine of `amplitude` (N) at `frequency` (Hz).
    fn steady(amplitude: f64, frequency: f64) -> Record {
        let angles: Vec<f64> = (0..192).map(|i| TAU * f64::from(i) / 96.0).collect();
        let time = angles.iter().map(|angle| angle / TAU / frequency).collect();
        let channels = vec![
            channel("time", "s", time),
            channel("excitation", "N", angles.iter().map(|angle| amplitude * angle.cos()).collect()),
            channel("acceleration:x=0.55", "m/s^2", vec![0.0; 192]),
            channel("acceleration:x=0.1", "m/s^2", vec![0.0; 192]),
        ];
        Record { name: "r".into(), regime: Regime::Steady, use_for: None, channels }
    }

    /// `record` as far finer steps than those of fits, or more harmonics, give it.
    fn measured(truth: &Model, mut record: Record) -> Record {
        let mut values = Vec::new();
        let mut shown = ObservedSimulation::new(truth, &record).unwrap();
        shown.refine(100);
        shown.predict(truth, &[], &mut values).unwrap();
        drop(shown);
        let length = record.channels[0].values.len();
        for (channel, values) in record.channels[2..].iter_mut().zip(values.chunks_exact(length)) {
            channel.values = values.to_vec();
        }
        record
    }

    /// Error of the contact's parameters, of a fit and of what is refined of it.
    fn errors(truth: &Model, given: &Model, records: Vec<Record>) -> [f64; 2] {
        let numbers: Vec<usize> = (0..records.len()).collect();
        let dataset = Dataset { title: None, records };
        let bench = WeightedDataset::new(given, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &numbers, &[], &[]);
        let fitted = first(&data, None, given).and_then(|(first, _)| again(&data, &first)).unwrap();
        let refined = refined(&data, &fitted, false).unwrap();
        [fitted, refined].map(|of| {
            let off = |path: &str| (of.model.get(path).unwrap() / truth.get(path).unwrap()).ln().abs();
            off("contact.tangential_stiffness").max(off("contact.friction_coefficient"))
        })
    }

    #[test]
    fn parameters_are_freed_of_the_error_of_the_steps() {
        for (stiffness, friction) in [(2e3, 0.3), (5e3, 0.4), (1e3, 0.2)] {
            let truth = oscillator(stiffness, friction);
            let given = oscillator(1.1 * stiffness, 0.95 * friction);
            let [before, after] = errors(&truth, &given, vec![measured(&truth, from_rest(8.0))]);
            assert!(before > 1e-6 && after < 0.3 * before, "{before} {after}");
        }
    }

    #[test]
    fn records_take_the_steps_that_their_noise_asks_for() {
        let truth = oscillator(2e3, 0.3);
        let dataset = Dataset { title: None, records: vec![measured(&truth, from_rest(8.0))] };
        let mut bench = WeightedDataset::new(&truth, &dataset, Assumptions::default(), None).unwrap();
        let exact = bench.lanes[0].measured.clone();
        let deviation = 1.0 / bench.lanes[0].scales[0];
        for (noise, least) in [(0.2, 1), (1e-2, 2), (1e-3, 3)] {
            let mut data = Measured::new(&bench, &[0], &[], &[]);
            data.channels[0][0].prior.deviation = noise * deviation;
            let steps = steps_needed(&data, &truth);
            assert!(steps[0] >= least && (least > 1 || steps[0] == 1), "{noise}: {steps:?}");
            bench.lanes[0].steps = steps[0];
            let error = minus(&bench.score(&truth, &[0]).unwrap()[0].predictions, &exact);
            let error = (dot(&error, &error) / error.len() as f64).sqrt();
            assert!(error < 0.1 * noise * deviation, "{noise}: {}", error / (noise * deviation));
            bench.lanes[0].steps = 1;
        }
    }

    #[test]
    fn parameters_of_a_beam_are_freed_of_the_harmonics_left_out() {
        for (stiffness, friction) in [(7e6, 0.4), (5e6, 0.3)] {
            let truth = beam(stiffness, friction);
            let given = beam(1.05 * stiffness, 0.97 * friction);
            let records = [(12.0, 51.0), (6.0, 51.5)].map(|(force, at)| measured(&truth, steady(force, at)));
            let [before, after] = errors(&truth, &given, records.to_vec());
            assert!(before > 1e-5 && after < 0.3 * before, "{before} {after}");
        }
    }
}
