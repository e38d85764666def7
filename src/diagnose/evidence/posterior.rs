//! The most probable parameters of a hypothesis, and its evidence by Laplace's method.

use nalgebra::{DMatrix, DVector};

use super::joint::{Joint, Tangents};
use super::latent::Latent;
use super::measured::Measured;
use super::noise_prior::NoisePrior;
use super::slot::Slot;
use super::unknown::Unknown;
use crate::diagnose::diagnosis::Estimate;
use crate::fit::compare::Fitted;
use crate::fit::predict::Seed;
use crate::model::Model;

/// A hypothesis at its most probable parameters.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Posterior {
    pub model: Model,
    pub unknowns: Vec<Unknown>,
    /// The coordinates of the unknowns, then the weights of a discrepancy. Of what is told, in the middle of the likelihood, without
    /// the errors of predictions and what noise of the inputs made of them.
    pub y: Vec<f64>,
    pub log_evidence: f64,
    /// Of the most probable parameters alone, without the volume around them.
    pub log_peak: f64,
    /// Standard deviations of the unknowns' coordinates.
    pub deviations: Vec<f64>,
    /// Correlations of the unknowns' coordinates, row-major.
    pub correlations: Vec<f64>,
    /// Per record.
    pub predictions: Vec<Vec<f64>>,
    pub simulations: usize,
}

/// Standard deviations to the ends of an interval that holds 95 % of a normal variable.
pub(super) const INTERVAL: f64 = 1.96;
/// Posterior over prior deviation above which the data say nothing of a number.
const UNDETERMINED: f64 = 0.95;
/// The same above which nothing in the data depends on it.
pub(super) const UNSEEN: f64 = 0.999_999;

impl Posterior {
    /// Whether the size of what candidate `owner` brought is more than so many deviations from none, and lies where physics
    /// bounds it if anything does.
    pub fn determines(&self, owner: usize, least: f64) -> bool {
        let first = self.unknowns.iter().position(|unknown| unknown.owner == Some(owner));
        // Its coordinate is 0 where it changes nothing.
        first.is_some_and(|k| {
            let (y, deviation) = (self.y[k].abs(), self.deviations[k]);
            deviation < UNDETERMINED && y > least * deviation && y < self.unknowns[k].coordinate.farthest()
        })
    }

    /// What candidates brought, or one of them, by their names alone.
    pub fn brought(&self, by: Option<usize>) -> Vec<Estimate> {
        let mine = |owner: Option<usize>| owner.is_some() && (by.is_none() || owner == by);
        let pairs = self.unknowns.iter().zip(self.estimates()).filter(|(unknown, _)| mine(unknown.owner));
        let short = |estimate: Estimate| {
            let name = estimate.name.rsplit('.').next().unwrap_or_default().to_owned();
            Estimate { name, ..estimate }
        };
        pairs.map(|(_, estimate)| short(estimate)).collect()
    }

    /// What the fit says of the unknown called `path`, which was `from` before; `None` for what was not fitted.
    pub fn fitted(&self, path: &str, from: Option<f64>) -> Option<Fitted> {
        let index = self.unknowns.iter().position(|unknown| unknown.path == path)?;
        let paths: Vec<&str> = self.unknowns.iter().map(|unknown| unknown.path.as_str()).collect();
        let row = self.correlations.chunks(paths.len()).nth(index).unwrap_or_default();
        let estimate = self.estimates().swap_remove(index);
        let at_bound = self.unknowns[index].coordinate.is_at_bound(self.y[index]);
        Some(Fitted {
            from,
            interval: estimate.low.zip(estimate.high).filter(|_| !at_bound).map(|(low, high)| [low, high]),
            at_bound,
            unseen: self.deviations[index] > UNSEEN,
            correlated: Fitted::told(index, &paths, row),
        })
    }

    /// Every unknown with its 95 % interval.
    pub fn estimates(&self) -> Vec<Estimate> {
        let one = |((unknown, y), deviation): ((&Unknown, &f64), &f64)| {
            // Within the bounds: the inverse of a number below zero is none that the other may have.
            let (lower, upper) = unknown.coordinate.bounds();
            let end =
                |sign: f64| unknown.coordinate.value((y + sign * INTERVAL * deviation).max(lower).min(upper));
            let ends =
                (*deviation < UNDETERMINED).then(|| (end(-1.0).min(end(1.0)), end(-1.0).max(end(1.0))));
            Estimate {
                name: unknown.path.clone(),
                value: unknown.coordinate.value(*y),
                low: ends.map(|ends| ends.0),
                high: ends.map(|ends| ends.1),
                unit: unknown.unit,
            }
        };
        self.unknowns.iter().zip(&self.y).zip(&self.deviations).map(one).collect()
    }
}

/// How far a round goes.
#[derive(Debug, Clone, Copy)]
pub(super) struct Extent {
    pub(super) steps: usize,
    /// Relative fall of the sum of squares that ends them.
    pub(super) tolerance: f64,
    /// Trials of a step.
    pub(super) trials: usize,
}

/// A first look.
pub(super) const LOOK: Extent = Extent { steps: 6, tolerance: 1e-3, trials: 10 };
/// A glance; a step that fails so often would be a short one.
pub(super) const GLANCE: Extent = Extent { steps: 2, trials: 5, ..LOOK };
/// No step, only what is there.
pub(super) const HERE: Extent = Extent { steps: 0, ..LOOK };
/// A round of a whole fit.
pub(super) const ROUND: Extent = Extent { steps: 12, tolerance: 1e-5, ..LOOK };
/// Rounds with coloured noise at most; a change of the log evidence that is none.
const ROUNDS: (usize, f64) = (5, 0.1);

/// A hypothesis to be fitted: a model whose unknowns start at `y`.
pub(super) struct Start<'a> {
    pub model: &'a Model,
    pub unknowns: &'a [Unknown],
    pub y: &'a [f64],
}

/// Records with a solution each, for others to start from.
pub(in crate::diagnose) type Solutions = Vec<(usize, Seed)>;

/// A first look, with white noise; the evidence is what the last linearisation promises under the noise that is left.
pub(super) fn screen(data: &Measured, start: &Start, extent: Extent) -> Result<Posterior, String> {
    screened(data, start, extent).map(|(found, _)| found)
}

/// The same with the solutions there, record by record, where motions are solved for.
pub(super) fn screened(
    data: &Measured,
    start: &Start,
    extent: Extent,
) -> Result<(Posterior, Solutions), String> {
    let latent = Latent::default();
    let mut joint = Joint::new(data, start.model, start.unknowns, &latent)?;
    let y = white_round(&mut joint, start.y, extent)?;
    let found = promised(&mut joint, start.unknowns, y)?;
    let solution =
        |(record, slot): (&usize, &Slot)| Some((*record, Seed::Near(slot.shown.solution()?.clone())));
    let solutions = data.records.iter().zip(&joint.slots).filter_map(solution).collect();
    Ok((found, solutions))
}

/// A glance at a hypothesis with more unknowns than one whose derivatives are `known`.
pub(super) fn glance(data: &Measured, start: &Start, known: Option<&Tangents>) -> Result<Posterior, String> {
    let latent = Latent::default();
    let mut joint = Joint::new(data, start.model, start.unknowns, &latent)?;
    let mut y = joint.settle(start.y, true)?;
    if let Some(known) = known {
        joint.extend(&y, known)?;
    }
    white_steps(&mut joint, &mut y, GLANCE)?;
    promised(&mut joint, start.unknowns, y)
}

/// What the last linearisation promises under the noise that is left.
fn promised(joint: &mut Joint, unknowns: &[Unknown], mut y: Vec<f64>) -> Result<Posterior, String> {
    joint.noise.renew(joint.data, &joint.priors, &joint.residuals(), true);
    let found = posterior(joint, unknowns, &mut y, true)?;
    joint.data.bench.count_refit();
    joint.data.bench.count(joint.simulations);
    Ok(found)
}

/// A whole fit: white noise first, so that noise with a memory does not absorb what a better start would explain.
pub(super) fn fit(
    data: &Measured,
    start: &Start,
    latent: &Latent,
    priors: Option<&[Vec<NoisePrior>]>,
) -> Result<Posterior, String> {
    let mut joint = Joint::new(data, start.model, start.unknowns, latent)?;
    if let Some(priors) = priors {
        joint.priors = priors.to_vec();
    }
    let mut shared = start.y.to_vec();
    shared.resize(joint.shared(), 0.0);
    let mut y = white_round(&mut joint, &shared, ROUND)?;
    let mut best: Option<Posterior> = None;
    for _ in 0..ROUNDS.0 {
        let found = match coloured_round(&mut joint, start.unknowns, &mut y) {
            Ok(found) => found,
            // What was found before stands.
            Err(_) if best.is_some() && !data.bench.interrupted() => break,
            Err(failure) => return Err(failure),
        };
        let last = best.as_ref().map_or(f64::NEG_INFINITY, |best| best.log_evidence);
        let change = found.log_evidence - last;
        if change > 0.0 {
            best = Some(found);
        }
        if change.abs() < ROUNDS.1 {
            break;
        }
    }
    data.bench.count_refit();
    data.bench.count(joint.simulations);
    best.ok_or_else(|| "the evidence is not finite".to_owned())
}

/// A round with noise as coloured as the residual is, from the last linearised point `y`.
fn coloured_round(joint: &mut Joint, unknowns: &[Unknown], y: &mut Vec<f64>) -> Result<Posterior, String> {
    let data = joint.data;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    joint.minimise(y, ROUND)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    if joint.rescan(y)? {
        joint.minimise(y, ROUND)?;
        joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    }
    posterior(joint, unknowns, y, false)
}

/// From the `shared` unknowns with starts of the records scanned anew, under white noise of the size of the residuals.
pub(super) fn white_round(joint: &mut Joint, shared: &[f64], extent: Extent) -> Result<Vec<f64>, String> {
    let mut y = joint.settle(shared, extent.steps > 0)?;
    white_steps(joint, &mut y, extent)?;
    Ok(y)
}

/// The same from the point `y`.
fn white_steps(joint: &mut Joint, y: &mut Vec<f64>, extent: Extent) -> Result<(), String> {
    let data = joint.data;
    joint.minimise(y, HERE)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), false);
    if extent.steps > 0 {
        joint.minimise(y, extent)?;
        joint.noise.renew(data, &joint.priors, &joint.residuals(), false);
    }
    Ok(())
}

/// At the last linearised point `y` under the present noise; `promised` with what one more step would gain.
fn posterior(
    joint: &Joint,
    unknowns: &[Unknown],
    y: &mut [f64],
    promised: bool,
) -> Result<Posterior, String> {
    let sums = joint.sums_here(y);
    let n = y.len();
    let curvature = DMatrix::from_row_slice(n, n, &sums.curvature);
    let factor = curvature.cholesky().ok_or("the curvature is not positive")?;
    let half_log_det: f64 = (0..n).map(|i| factor.l_dirty()[(i, i)].ln()).sum();
    let mut log_peak = joint.noise.log_constant(joint.data) - sums.cost;
    if promised {
        let gradient = DVector::from_column_slice(&sums.gradient);
        log_peak += 0.5 * gradient.dot(&factor.solve(&gradient));
    }
    let log_evidence = log_peak - half_log_det;
    if !log_evidence.is_finite() {
        return Err("the evidence is not finite".to_owned());
    }
    let inverse = factor.inverse();
    let own = |i: usize| inverse[(i, i)].sqrt();
    let pairs = (0..unknowns.len()).flat_map(|i| (0..unknowns.len()).map(move |k| (i, k)));
    Ok(Posterior {
        model: joint.model(y)?,
        unknowns: unknowns.to_vec(),
        y: y[..joint.shared()].to_vec(),
        log_evidence,
        log_peak,
        deviations: (0..unknowns.len()).map(own).collect(),
        correlations: pairs.map(|(i, k)| inverse[(i, k)] / (own(i) * own(k))).collect(),
        predictions: joint.predictions(),
        simulations: joint.simulations,
    })
}
