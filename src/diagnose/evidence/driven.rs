//! What the noise of the inputs makes of the parameters. A residual shows its size, not how it leads parameters astray: the
//! model is driven by that noise, and follows it for a while as it would follow another parameter.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::joint::{Joint, Whitened, dot};
use super::latent::Latent;
use super::measured::Measured;
use super::posterior::{HERE, Posterior, UNSEEN, white_round};
use super::slot::Slot;
use crate::data::Record;
use crate::diagnose::measurements::inputs::redrawn;
use crate::fit::predict::WRONG_BRANCH;
use crate::model::Model;

/// Times that the inputs of each record are driven with other noise: records beside each other add to the number.
const TIMES: u64 = 4;
const NARROW: &str = "the intervals do not allow for the noise of what drives the model";

/// Adds to the covariance of the unknowns of `posterior` what the noise of the inputs gives them, to first order: how far each
/// record moves them when its inputs have other noise, less what its residual says already.
///
/// # Errors
/// Why it cannot be told; `posterior` is then unchanged.
pub(super) fn widen(data: &Measured, posterior: &mut Posterior) -> Result<(), String> {
    let seed = |k: usize, time: u64| k as u64 * TIMES + time;
    let records: Vec<Vec<Record>> = (0..data.records.len())
        .map(|k| {
            let redrawn = |time| redrawn(&posterior.model, data.lane(k).record, seed(k, time));
            (0..TIMES).filter_map(redrawn).collect()
        })
        .collect();
    if records.iter().all(Vec::is_empty) {
        return Ok(());
    }
    let (latent, count) = (Latent::default(), posterior.unknowns.len());
    let mut joint = Joint::new(data, &posterior.model, &posterior.unknowns, &latent)?;
    let y = white_round(&mut joint, &posterior.y[..count], HERE)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    let (sums, model, whitened) = (joint.sums_here(&y), joint.model(&y)?, joint.whitened());
    let changes = |(k, slot): (usize, &mut Slot)| changes(data, k, slot, &model, &records[k]);
    let changes = joint.slots.par_iter_mut().enumerate().map(changes);
    let changes: Vec<Vec<Vec<f64>>> = changes.collect::<Result<_, String>>()?;
    data.bench.count(changes.iter().map(Vec::len).sum());
    let n = y.len();
    let factor = DMatrix::from_row_slice(n, n, &sums.curvature).cholesky();
    let inverse = factor.ok_or("the curvature is not positive")?.inverse();
    let mut more = DMatrix::zeros(n, n);
    for (k, (record, changes)) in whitened.iter().zip(&changes).enumerate() {
        let whitened: Vec<Vec<f64>> =
            changes.iter().map(|change| joint.noise.whiten(data, k, change)).collect();
        if !whitened.is_empty() {
            more += moved(&inverse, record, whitened);
        }
    }
    if !more.iter().all(|x| x.is_finite()) {
        return Err(format!("{NARROW}: what it changes is not finite"));
    }
    add(posterior, &more);
    Ok(())
}

/// What `records`, which are record `k` with other noise, change of its predictions.
fn changes(
    data: &Measured,
    k: usize,
    slot: &Slot,
    model: &Model,
    records: &[Record],
) -> Result<Vec<Vec<f64>>, String> {
    let lane = data.lane(k);
    let mut changes = Vec::new();
    for record in records {
        data.bench.unless_interrupted()?;
        let change = slot.driven_by(model, record, lane);
        changes.extend(change.ok().filter(|change| data.size_of(k, change) < WRONG_BRANCH));
    }
    if !records.is_empty() && changes.len() < 2 {
        return Err(format!("{NARROW}: `{}` has another response under other noise", lane.record.name));
    }
    Ok(changes)
}

/// Covariance of the unknowns, of which `inverse` is that under the noise of the residual, by whitened `changes` of a record's
/// predictions about their mean, beyond what white noise of their size would make: the residual holds that already.
fn moved(inverse: &DMatrix<f64>, record: &Whitened, changes: Vec<Vec<f64>>) -> DMatrix<f64> {
    let n = inverse.nrows();
    let freedom = (changes.len() - 1) as f64;
    let mean = |i: usize| changes.iter().map(|change| change[i]).sum::<f64>() / changes.len() as f64;
    let centre: Vec<f64> = (0..record.residuals.len()).map(mean).collect();
    let mut of_gradient = DMatrix::zeros(n, n);
    let mut square = 0.0;
    for change in &changes {
        let about: Vec<f64> = change.iter().zip(&centre).map(|(change, centre)| change - centre).collect();
        let mut gradient = DVector::zeros(n);
        record.columns.iter().for_each(|(i, column)| gradient[*i] = dot(column, &about));
        of_gradient += &gradient * gradient.transpose() / freedom;
        square += dot(&about, &about) / freedom;
    }
    let share = square / centre.len().max(1) as f64;
    for (i, one) in &record.columns {
        record.columns.iter().for_each(|(k, other)| of_gradient[(*i, *k)] -= share * dot(one, other));
    }
    inverse * of_gradient * inverse
}

/// Adds the covariance `more`, where it is one, to that of the unknowns.
fn add(posterior: &mut Posterior, more: &DMatrix<f64>) {
    let count = posterior.unknowns.len();
    let own = posterior.deviations.clone();
    let more = |i: usize, k: usize| if more[(i, i)] > 0.0 && more[(k, k)] > 0.0 { more[(i, k)] } else { 0.0 };
    let size = |i: usize| own[i].hypot(more(i, i).sqrt());
    // Nothing that was seen is unseen by noise.
    posterior.deviations = (0..count).map(|i| size(i).min(own[i].max(UNSEEN))).collect();
    for (place, correlation) in posterior.correlations.iter_mut().enumerate() {
        let (i, k) = (place / count, place % count);
        *correlation = ((*correlation * own[i] * own[k] + more(i, k)) / (size(i) * size(k))).clamp(-1.0, 1.0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::samples::{from_rest, oscillator, slider};
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::predict;
    use crate::numeric::random::Random;

    /// Mean square of how far the parameters are off, in deviations: as fitted, and widened.
    fn off(truth: &Model, records: Vec<Record>) -> [f64; 2] {
        let dataset = Dataset { title: None, records };
        let bench = WeightedDataset::new(truth, &dataset, Assumptions::default(), None).unwrap();
        let all: Vec<usize> = (0..dataset.records.len()).collect();
        let data = Measured::new(&bench, &all, &[], &[]);
        let fitted = first(&data, None, truth).and_then(|(first, _)| again(&data, &first)).unwrap();
        let mut widened = fitted.clone();
        widen(&data, &mut widened).unwrap();
        [fitted, widened].map(|of| {
            let squares = of.y.iter().zip(&of.deviations).map(|(y, deviation)| (y / deviation).powi(2));
            squares.sum::<f64>() / of.y.len() as f64
        })
    }

    /// The mean of that over twelve measurements by `records`.
    fn mean_off(truth: &Model, records: impl Fn(&mut Random) -> Vec<Record>) -> [f64; 2] {
        let found: Vec<[f64; 2]> = (0..12).map(|seed| off(truth, records(&mut Random::new(seed)))).collect();
        [0, 1].map(|k| found.iter().map(|of| of[k]).sum::<f64>() / found.len() as f64)
    }

    /// Adds noise, a fraction of the largest value each, to the last two channels.
    fn measured(record: &mut Record, noise: [f64; 2], random: &mut Random) {
        let first = record.channels.len() - 2;
        for (channel, noise) in record.channels[first..].iter_mut().zip(noise) {
            let size = channel.values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            channel.values.iter_mut().for_each(|x| *x += noise * size * random.normal());
        }
    }

    /// An oscillator from rest, its force measured with noise of `of_force` of its amplitude, its displacement with far less.
    fn oscillators(truth: &Model, of_force: f64, random: &mut Random) -> Vec<Record> {
        let record = |amplitude: f64| {
            let mut record = from_rest(amplitude);
            record.channels[2].values = predict(truth, &record).unwrap()[0].values.clone();
            measured(&mut record, [of_force, 1e-4], random);
            record
        };
        [6.0, 8.0, 12.0].map(record).to_vec()
    }

    /// A contact on the way round its loop, which nobody saw begin.
    fn loops(truth: &Model, random: &mut Random) -> Vec<Record> {
        let record = |amplitude: f64| {
            let motion = |i: u32| amplitude * (0.05 * f64::from(i)).sin();
            let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
            let channels = vec![
                channel("time", "s", (0..1000).map(|i| 1e-3 * f64::from(i)).collect()),
                channel("displacement", "m", (0..1000).map(motion).collect()),
                channel("force", "N", vec![0.0; 1000]),
            ];
            let mut record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
            record.channels[2].values = predict(truth, &record).unwrap()[0].values.clone();
            record.regime = Regime::UnknownInitialState;
            record.channels.iter_mut().for_each(|channel| drop(channel.values.drain(..300)));
            measured(&mut record, [3e-3, 1e-3], random);
            record
        };
        [4e-5, 8e-5].map(record).to_vec()
    }

    #[test]
    fn intervals_allow_for_the_noise_of_what_drives() {
        let truth = oscillator(2e3, 0.3);
        let [fitted, widened] = mean_off(&truth, |random| oscillators(&truth, 0.02, random));
        assert!(fitted > 2.5 && (0.5..1.8).contains(&widened), "{fitted} {widened}");
        let [fitted, widened] = off(&truth, oscillators(&truth, 0.0, &mut Random::new(1)));
        assert_eq!(fitted, widened);
    }

    #[test]
    fn noise_that_the_residual_shows_widens_nothing_and_an_unknown_past_neither() {
        let truth = slider("");
        let [fitted, widened] = mean_off(&truth, |random| loops(&truth, random));
        assert!((0.3..2.0).contains(&widened) && widened > 0.6 * fitted, "{fitted} {widened}");
    }
}
