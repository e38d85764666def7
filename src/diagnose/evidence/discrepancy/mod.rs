//! What the catalogue may lack: an explicit competitor of all effects.
//!
//! It is a force over displacement, velocity, distance since the last reversal, time and what the motion was shortly before, as
//! it is and as a factor of the force: small `tables` with normal weights. A contact that is moved as measured shows it as it is;
//! on a structure it would make the simulation diverge, and there it is a larger, coloured residual. Where the noise is unknown that
//! is nothing else than noise, and the force is what a structure passes on of it to first order (`responses`).

mod responses;
mod tables;

use nalgebra::{DMatrix, DVector};

use super::joint::Joint;
use super::latent::Latent;
use super::measured::{Measured, MeasuredChannel};
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

/// What the noise may be beside a discrepancy, with a residual of `alpha` of each channel that is none, of the records that it
/// `concerns`.
fn released(data: &Measured, alpha: f64, concerns: impl Fn(usize) -> bool) -> Vec<Vec<NoisePrior>> {
    let release = |prior: NoisePrior, size: f64| prior.released(alpha * size, data.assumptions().magnitude);
    let of = |(k, channels): (usize, &Vec<MeasuredChannel>)| {
        let concerned = concerns(k);
        let prior = |c: &MeasuredChannel| if concerned { release(c.prior, c.size) } else { c.prior };
        channels.iter().map(prior).collect()
    };
    data.channels.iter().enumerate().map(of).collect()
}

/// Whether it is of a contact that is moved as measured, which shows a force as it is.
pub(super) fn is_moved(posterior: &Posterior) -> bool {
    posterior.model.structure == Structure::Prescribed
}

/// The discrepancy about `posterior` that has the most evidence.
pub(super) fn about(data: &Measured, posterior: &Posterior) -> Result<Doubt, String> {
    let moved = is_moved(posterior);
    if !moved && data.noise_is_known() {
        return residual(data, posterior);
    }
    let columns =
        if moved { tables::columns(data, posterior) } else { responses::columns(data, &posterior.model)? };
    let force = force(data, posterior, columns)?;
    if data.relevance(&force.predictions, &posterior.predictions) >= data.assumptions().relevant {
        return Ok(force);
    }
    // What the noise may be beside it then stands for all that is missing: it does not follow the motion.
    let residual = residual(data, posterior);
    if moved { residual.or(Ok(force)) } else { residual }
}

/// A residual of its own: the same predictions under a noise that may be larger than told.
fn residual(data: &Measured, posterior: &Posterior) -> Result<Doubt, String> {
    if !data.noise_is_known() {
        return Err("without a known noise a residual of its own is nothing else".to_owned());
    }
    let predictions = &posterior.predictions;
    let relevant = data.assumptions().relevant;
    // A structure shows all that is missing as a residual, a moved contact only what does not follow its motion.
    let moved = is_moved(posterior);
    let excess = if moved { data.unexplained(predictions) } else { data.excess(predictions) };
    if excess < relevant {
        return Err("the residual is not relevantly larger than the noise".to_owned());
    }
    // Of a noise that is a little larger than told in all records no one of them makes a residual of its own.
    let shows = |k: usize| moved || data.excess_of(k, &predictions[k]) >= relevant;
    let (gain, priors) = larger_noise(data, predictions, shows).ok_or("no size of a residual is tried")?;
    Ok(Doubt {
        kind: Discrepancy::Residual,
        log_evidence: posterior.log_evidence + gain,
        y: posterior.y.clone(),
        latent: Latent::default(),
        priors,
        predictions: posterior.predictions.clone(),
    })
}

/// The size of a residual of its own that `predictions` speak for most, in the records that it `concerns`: by how much more than
/// for the noise that was told, and what the noise may be beside it.
pub(super) fn larger_noise(
    data: &Measured,
    predictions: &[Vec<f64>],
    concerns: impl Fn(usize) -> bool,
) -> Option<(f64, Vec<Vec<NoisePrior>>)> {
    let told = data.log_score(predictions);
    let under = |alpha: f64| {
        let priors = released(data, alpha, &concerns);
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
    if is_moved(posterior) {
        joint.priors = released(data, 0.0, |_| true);
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;
    use crate::diagnose::Assumptions;
    use crate::diagnose::diagnosis::{Noise, NoiseSource};
    use crate::diagnose::evidence::first;
    use crate::diagnose::evidence::samples::{from_rest, oscillator};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::predict;

    const RECORDS: usize = 16;

    /// By how much a residual of its own is likelier than noise, if it is one: of a structure's records with noise as `told` and
    /// `real`, and a wave, all as fractions of the channel.
    fn gained(
        told: impl Fn(usize) -> f64,
        real: impl Fn(usize) -> f64,
        wave: impl Fn(usize) -> f64,
    ) -> Option<f64> {
        let model = oscillator(2e3, 0.4);
        let record = |k: usize| {
            let mut record = from_rest(6.0 + k as f64);
            record.channels[2].values = predict(&model, &record).unwrap()[0].values.clone();
            record
        };
        let dataset = Dataset { title: None, records: (0..RECORDS).map(record).collect() };
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let size = |k: usize| 1.0 / bench.lanes[k].scales[0];
        let noise = |record: usize| Noise {
            record,
            channel: "displacement:m1".into(),
            deviation: Some(told(record) * size(record)),
            log_error: 0.0,
            source: NoiseSource::Stated,
        };
        let (all, noise): (Vec<usize>, Vec<Noise>) = (0..RECORDS).map(|k| (k, noise(k))).unzip();
        let data = Measured::new(&bench, &all, &noise, &[]);
        let (mut posterior, _) = first(&data, None, &model).unwrap();
        let mut random = fastrand::Rng::with_seed(5);
        // Of deviation one.
        let mut white = || 2.0 * (random.f64() + random.f64() + random.f64() - 1.5);
        for (k, predicted) in posterior.predictions.iter_mut().enumerate() {
            predicted.copy_from_slice(&data.lane(k).measured);
            for (i, value) in predicted.iter_mut().enumerate() {
                let wave = wave(k) * 2.0_f64.sqrt() * (0.1 * i as f64).sin();
                *value += size(k) * (real(k) * white() + wave);
            }
        }
        residual(&data, &posterior).ok().map(|doubt| doubt.log_evidence - posterior.log_evidence)
    }

    #[test]
    fn what_a_few_records_of_a_structure_show_is_a_residual_of_its_own() {
        let certain = Assumptions::default().certainty();
        for few in [2, 4] {
            let gain = gained(|_| 0.003, |_| 0.003, |k| if k < few { 0.012 } else { 0.0 });
            assert!(gain.is_some_and(|gain| gain > certain), "{few}: {gain:?}");
        }
        let gain = gained(|_| 0.003, |_| 0.003, |_| 0.008);
        assert!(gain.is_none(), "{gain:?}");
    }

    #[test]
    fn a_noise_a_little_larger_than_told_is_none() {
        let at = |k: usize| if k == 0 { 0.02 } else { 0.003 };
        let gain = gained(at, |k| 1.15 * at(k), |_| 0.0);
        assert!(gain.is_none_or(|gain| gain < 1.5), "{gain:?}");
    }
}
