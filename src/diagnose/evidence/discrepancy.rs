//! What the catalogue may lack: an explicit competitor of all effects.
//!
//! On a contact that is moved as measured it is a force over displacement, velocity, distance since the last reversal, time
//! and what the motion was shortly before, as it is and as a factor of the force: small tables with normal weights. On a
//! structure a force of its own would make the simulation diverge; there it is a larger, coloured residual.

use nalgebra::{DMatrix, DVector};

use super::joint::Joint;
use super::latent::Latent;
use super::measured::Measured;
use super::noise_prior::NoisePrior;
use super::posterior::{HERE, Posterior, white_round};
use crate::fit::Sums;
use crate::fit::predict::Motion;
use crate::model::Structure;

/// Nodes over displacement and velocity, over the distance since a reversal, and over time.
const NODES: [usize; 3] = [9, 6, 7];
/// Times over which the motion is remembered, over that in which it passes its range at full speed.
const MEMORIES: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

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
    if posterior.model.structure != Structure::Prescribed {
        return residual(data, posterior);
    }
    let force = force(data, posterior)?;
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

/// A force that follows the motion.
fn force(data: &Measured, posterior: &Posterior) -> Result<Doubt, String> {
    let mut latent = columns(data, posterior);
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

/// Hat functions of `x` over evenly spaced nodes in [−1, 1].
fn hats(nodes: usize, count: usize, x: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
    let hat = |node: usize, i: usize| {
        let place = (x(i).clamp(-1.0, 1.0) + 1.0) / 2.0 * (nodes - 1) as f64;
        (1.0 - (place - node as f64).abs()).max(0.0)
    };
    (0..nodes).map(|node| (0..count).map(|i| hat(node, i)).collect()).collect()
}

/// Extremes over all records, by which the tables are scaled.
struct Extremes {
    /// Of the displacement: where a sensor has its zero is no part of a motion.
    middle: f64,
    /// On either side of it.
    reach: f64,
    fastest: f64,
    longest: f64,
}

/// Of size one of each channel.
fn columns(data: &Measured, posterior: &Posterior) -> Latent {
    let motion = |k: usize| {
        let record = data.lane(k).record;
        Some(Motion::even(&record.channel("displacement")?.values, record.sample_step()?))
    };
    let motions: Vec<Option<Motion>> = (0..data.records.len()).map(motion).collect();
    let largest =
        |values: &mut dyn Iterator<Item = f64>| values.fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    let length = |k: usize| {
        let time = data.lane(k).record.time()?;
        Some(time.last()? - time.first()?)
    };
    let places = || motions.iter().flatten().flat_map(|m| m.values.iter().copied());
    let [low, high] = [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)];
    let extremes = Extremes {
        middle: 0.5 * (low + high),
        reach: f64::MIN_POSITIVE.max(0.5 * (high - low)),
        fastest: largest(&mut motions.iter().flatten().flat_map(|m| m.rates.iter().copied())),
        longest: largest(&mut (0..data.records.len()).filter_map(length)),
    };
    let size = |process: usize| {
        let of = |(k, channels): (usize, &Vec<super::measured::MeasuredChannel>)| {
            let own = channels.iter().filter(|c| c.process == process);
            largest(&mut own.flat_map(|c| data.lane(k).measured[c.range.clone()].iter().copied()))
        };
        largest(&mut data.channels.iter().enumerate().map(of))
    };
    let mut latent = Latent::default();
    for (k, channels) in data.channels.iter().enumerate() {
        let all = data.lane(k).measured.len();
        let mut mine = Vec::new();
        for channel in channels {
            let Some(motion) = &motions[k] else { continue };
            let scale = size(channel.process);
            let predicted = &posterior.predictions[k][channel.range.clone()];
            let local = of_channel(data, k, motion, predicted, &extremes);
            for (w, column) in local.into_iter().enumerate() {
                let mut whole = vec![0.0; all];
                whole[channel.range.clone()].iter_mut().zip(&column).for_each(|(a, b)| *a = scale * b);
                mine.push((w, whole));
                latent.count = latent.count.max(w + 1);
            }
        }
        latent.columns.push(mine);
    }
    latent
}

fn of_channel(
    data: &Measured,
    k: usize,
    motion: &Motion,
    predicted: &[f64],
    most: &Extremes,
) -> Vec<Vec<f64>> {
    let n = predicted.len();
    let largest = predicted.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    let by_force = |columns: Vec<Vec<f64>>| -> Vec<Vec<f64>> {
        let times = |column: Vec<f64>| column.iter().zip(predicted).map(|(x, f)| x * f / largest).collect();
        columns.into_iter().map(times).collect()
    };
    let u = |i: usize| (motion.values[i] - most.middle) / most.reach;
    let v = |i: usize| {
        let v = motion.rates[i] / most.fastest;
        v.signum() * v.abs().sqrt()
    };
    let mut since = vec![0.0; n];
    for i in 1..n {
        let turned = motion.rates[i] * motion.rates[i - 1] <= 0.0;
        let step = (motion.values[i] - motion.values[i - 1]).abs();
        since[i] = if turned { 0.0 } else { since[i - 1] + step };
    }
    let along = |i: usize| 2.0 * (since[i] / (2.0 * most.reach)).clamp(0.0, 1.0).sqrt() - 1.0;
    let mut found = hats(NODES[0], n, u);
    found.extend(hats(NODES[0], n, v));
    found.extend(by_force(hats(NODES[0], n, u)));
    found.extend(by_force(hats(NODES[0], n, v)));
    let signed = |column: Vec<f64>| -> Vec<f64> {
        column.iter().zip(&motion.rates).map(|(x, v)| x * v.signum()).collect()
    };
    found.extend(hats(NODES[1], n, along).into_iter().map(signed));
    if let Some(time) = data.lane(k).record.time() {
        let place = |i: usize| 2.0 * (time[i] - time[0]) / most.longest - 1.0;
        found.extend(by_force(hats(NODES[2], n, place)));
        found.extend(hats(NODES[2], n, place));
        found.extend(MEMORIES.map(|memory| remembered(motion, time, memory * most.reach / most.fastest)));
    }
    found
}

/// The velocity of the last `memory` seconds, of size one.
fn remembered(motion: &Motion, time: &[f64], memory: f64) -> Vec<f64> {
    let mut value = 0.0;
    let mut values: Vec<f64> = (0..motion.rates.len())
        .map(|i| {
            let step = if i > 0 { time[i] - time[i - 1] } else { 0.0 };
            let kept = (-step / memory).exp();
            value = kept * value + (1.0 - kept) * motion.rates[i];
            value
        })
        .collect();
    let largest = values.iter().fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()));
    values.iter_mut().for_each(|x| *x /= largest);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::first;
    use crate::diagnose::evidence::samples::slider;
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;

    /// A contact moved to and fro about a place (m).
    fn moved(about: f64) -> Dataset {
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let place = |i: i32| 1e-4 * (0.1 * f64::from(i)).sin();
        let channels = vec![
            channel("time", "s", (0..200).map(|i| 1e-3 * f64::from(i)).collect()),
            channel("displacement", "m", (0..200).map(|i| about + place(i)).collect()),
            channel("force", "N", (0..200).map(|i| (1e6 * place(i)).clamp(-50.0, 50.0)).collect()),
        ];
        let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
        Dataset { title: None, records: vec![record] }
    }

    #[test]
    fn tables_are_of_the_motion_wherever_the_sensor_has_its_zero() {
        let model = slider("");
        let [centred, displaced] = [moved(0.0), moved(0.125)];
        let [centred, displaced] = [&centred, &displaced]
            .map(|dataset| WeightedDataset::new(&model, dataset, Assumptions::default(), None).unwrap());
        let [centred, displaced] = [&centred, &displaced].map(|bench| Measured::new(bench, &[0], &[], &[]));
        let (posterior, _) = first(&centred, None, &model).unwrap();
        let [centred, displaced] = [&centred, &displaced].map(|data| columns(data, &posterior));
        assert_eq!(centred.count, displaced.count);
        for ((w, one), (_, other)) in centred.columns[0].iter().zip(&displaced.columns[0]) {
            let apart = one.iter().zip(other).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-6 * one.iter().fold(1e-3, |most: f64, x| most.max(x.abs())), "{w}: {apart}");
        }
    }
}
