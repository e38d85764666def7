//! What the catalogue may lack: an explicit competitor of all effects.
//!
//! It is a force over displacement, velocity, distance since the last reversal, time and what the motion was shortly before, as
//! it is and as a factor of the force: small `tables` with normal weights. A contact that is moved as measured shows it as it is;
//! on a structure it would make the simulation diverge, and there it is a larger, coloured residual. Where the noise is unknown that
//! is nothing else than noise, and the force is what a structure passes on of it to first order (`passed_on`).

mod passed_on;
mod tables;

use nalgebra::{DMatrix, DVector};

use super::joint::Joint;
use super::latent::Latent;
use super::measured::Measured;
use super::noise_prior::NoisePrior;
use super::posterior::{HERE, Posterior, white_round};
use crate::fit::Sums;
use crate::model::Structure;

/// Rounds in which noise and discrepancy are told apart.
const ROUNDS: usize = 3;

/// What a set has beside its effects.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) enum Discrepancy {
    /// A force that follows the motion.
    Force,
    /// A residual of its own, which has its smallest size itself.
    Residual,
}

impl Discrepancy {
    /// Whether it is relevant where it makes predictions `with` of those `without` it: the smallest size of a residual is.
    pub(super) fn matters(self, data: &Measured, with: &[Vec<f64>], without: &[Vec<f64>]) -> bool {
        self == Self::Residual || data.relevance(with, without) >= data.assumptions().relevant
    }
}

/// A hypothesis with a discrepancy to first order: the most probable size of it, the log evidence, and where a whole fit
/// would start.
pub(super) struct Doubt {
    pub kind: Discrepancy,
    pub log_evidence: f64,
    pub y: Vec<f64>,
    pub latent: Latent,
    pub priors: Vec<Vec<NoisePrior>>,
    pub predictions: Vec<Vec<f64>>,
}

/// What the noise may be beside a discrepancy, with a residual of `alpha` of each channel that is none.
fn released(data: &Measured, alpha: f64) -> Vec<Vec<NoisePrior>> {
    let release = |prior: NoisePrior, size: f64| prior.released(alpha * size, data.assumptions().magnitude);
    data.channels.iter().map(|of| of.iter().map(|c| release(c.prior, c.size)).collect()).collect()
}

/// The discrepancy about `posterior` that has the most evidence.
pub(super) fn about(data: &Measured, posterior: &Posterior) -> Result<Doubt, String> {
    let moved = posterior.model.structure == Structure::Prescribed;
    if !moved && data.noise_is_known() {
        return residual(data, posterior);
    }
    let columns = if moved { tables::columns(data, posterior) } else { passed_on::columns(data, posterior)? };
    let force = force(data, posterior, columns)?;
    // What the noise may be beside it then stands for all that is missing: it does not follow the motion.
    if data.relevance(&force.predictions, &posterior.predictions) < data.assumptions().relevant {
        return residual(data, posterior).or(Ok(force));
    }
    Ok(force)
}

/// A residual of its own: the same predictions under a noise that may be larger than told.
fn residual(data: &Measured, posterior: &Posterior) -> Result<Doubt, String> {
    if !data.noise_is_known() {
        return Err("without a known noise a residual of its own is nothing else".to_owned());
    }
    if data.excess(&posterior.predictions) < data.assumptions().relevant {
        return Err("the residual is not relevantly larger than the noise".to_owned());
    }
    let (gain, priors) =
        larger_noise(data, &posterior.predictions).ok_or("no size of a residual is tried")?;
    Ok(Doubt {
        kind: Discrepancy::Residual,
        log_evidence: posterior.log_evidence + gain,
        y: posterior.y.clone(),
        latent: Latent::default(),
        priors,
        predictions: posterior.predictions.clone(),
    })
}

/// The size of a residual of its own that `predictions` speak for most: by how much more than for the noise that was told,
/// and what the noise may be beside it.
pub(super) fn larger_noise(data: &Measured, predictions: &[Vec<f64>]) -> Option<(f64, Vec<Vec<NoisePrior>>)> {
    let told = data.log_score(predictions);
    let under = |alpha: f64| {
        let priors = released(data, alpha);
        (data.log_score_under(&priors, predictions) - told, priors)
    };
    data.assumptions().discrepancies().map(under).max_by(|a, b| a.0.total_cmp(&b.0))
}

/// A force that follows the motion, of what the columns of `latent` are.
fn force(data: &Measured, posterior: &Posterior, mut latent: Latent) -> Result<Doubt, String> {
    let parameters = posterior.unknowns.len();
    let weights = parameters..parameters + latent.count;
    let mut shared = posterior.y[..parameters].to_vec();
    shared.resize(weights.end, 0.0);
    let mut joint = Joint::new(data, &posterior.model, &posterior.unknowns, &latent)?;
    let y = white_round(&mut joint, &shared, HERE)?;
    joint.priors = released(data, 0.0);
    let mut best: Option<Solved> = None;
    for _ in 0..ROUNDS {
        // What was found last taken off, the residuals show the noise.
        let residuals =
            best.as_ref().map_or_else(|| joint.residuals(), |best| joint.residuals_after(&best.step));
        joint.noise.renew(data, &joint.priors, &residuals, true);
        let (sums, constant) = (joint.sums_here(&y), joint.noise.log_constant(data));
        let sizes = data.assumptions().discrepancies();
        let found = sizes.filter_map(|alpha| solve(&sums, constant, &weights, alpha));
        best = found.max_by(|a, b| a.log_evidence.total_cmp(&b.log_evidence)).or(best);
    }
    let Solved { alpha, log_evidence, step } = best.ok_or("no discrepancy can be told")?;
    data.bench.count(joint.simulations);
    let residuals = joint.residuals_after(&step);
    let add = |(k, r): (usize, &Vec<f64>)| r.iter().zip(&data.lane(k).measured).map(|(r, m)| r + m).collect();
    let predictions = residuals.iter().enumerate().map(add).collect();
    let priors = std::mem::take(&mut joint.priors);
    drop(joint);
    let mut start: Vec<f64> = y[..weights.end].iter().zip(step.iter()).map(|(y, s)| y + s).collect();
    start[weights].iter_mut().for_each(|w| *w /= alpha);
    latent.columns.iter_mut().flatten().for_each(|(_, column)| column.iter_mut().for_each(|x| *x *= alpha));
    let kind = Discrepancy::Force;
    Ok(Doubt { kind, log_evidence, y: start, latent, priors, predictions })
}

/// The best step of all unknowns with a discrepancy of a size.
struct Solved {
    alpha: f64,
    log_evidence: f64,
    step: DVector<f64>,
}

/// From `sums` with weights of deviation one at zero.
fn solve(sums: &Sums, constant: f64, weights: &std::ops::Range<usize>, alpha: f64) -> Option<Solved> {
    let n = sums.gradient.len();
    let mut curvature = DMatrix::from_row_slice(n, n, &sums.curvature);
    weights.clone().for_each(|w| curvature[(w, w)] += alpha.powi(-2) - 1.0);
    let factor = curvature.cholesky()?;
    let gradient = DVector::from_column_slice(&sums.gradient);
    let step = -factor.solve(&gradient);
    let half_log_det: f64 = (0..n).map(|i| factor.l_dirty()[(i, i)].ln()).sum();
    let volume = half_log_det + weights.len() as f64 * alpha.ln();
    let log_evidence = constant - sums.cost - 0.5 * gradient.dot(&step) - volume;
    log_evidence.is_finite().then_some(Solved { alpha, log_evidence, step })
}
