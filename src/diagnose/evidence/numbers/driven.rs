//! What the noise of the inputs makes of the parameters. A residual shows its size, not how it leads parameters astray: the
//! model is driven by that noise, and follows it for a while as it would follow another parameter. And it shakes a contact
//! beyond where the motion would have turned, again and again to the same side.
//!
//! Both are found by drawing other noise of the same colour (a parametric bootstrap, with the derivatives in place of fits): the
//! scatter of what it does is added to the intervals, its mean is taken off.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use crate::diagnose::evidence::joint::{Joint, Whitened, dot, first_failure, minus};
use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::Measured;
use crate::diagnose::evidence::posterior::{HERE, Posterior, UNSEEN, white_round};
use crate::diagnose::evidence::slot::Slot;
use crate::diagnose::measurements::colour::Memories;
use crate::diagnose::measurements::inputs::{Redrawn, redrawn};
use crate::fit::predict::WRONG_BRANCH;
use crate::model::Model;

/// Pairs of opposite noises that the inputs of each record are driven with; records beside each other add to the number.
const PAIRS: usize = 2;
const NOT_ALLOWED: &str = "the numbers do not allow for the noise of what drives the model";

/// What other noise of its inputs changes of the predictions of a record.
#[derive(Default)]
struct Driven {
    /// The derivatives by the parameters without that noise.
    columns: Vec<Vec<f64>>,
    pairs: Vec<Pair>,
}

/// The same by two opposite noises.
struct Pair {
    /// What one of them changes and the other takes back.
    odd: Vec<f64>,
    /// What both change.
    even: Vec<f64>,
    /// The derivatives under the first of them.
    columns: Vec<Vec<f64>>,
}

/// Takes off the parameters of `posterior` what the noise of the inputs makes of them in the mean, and adds to their covariance
/// what it gives them beyond what the residuals say already. Predictions stay those that all was compared by, and so do
/// unknowns at their bounds.
///
/// # Errors
/// Why it cannot be told; `posterior` is then unchanged.
pub(super) fn allow_for_inputs(data: &Measured, posterior: &mut Posterior) -> Result<(), String> {
    let redrawn = drawn(data, &posterior.model);
    if redrawn.iter().all(Option::is_none) {
        return Ok(());
    }
    let not_allowed = |reason: String| format!("{NOT_ALLOWED}: {reason}");
    let Shifted { model, y, more } = shifted(data, posterior, &redrawn).map_err(not_allowed)?;
    posterior.model = model;
    posterior.y[..y.len()].copy_from_slice(&y);
    widen(posterior, &more);
    Ok(())
}

/// Parameters without what the noise of the inputs made of them, and the covariance by which that scatters.
struct Shifted {
    model: Model,
    y: Vec<f64>,
    more: DMatrix<f64>,
}

fn shifted(data: &Measured, posterior: &Posterior, redrawn: &[Option<Redrawn>]) -> Result<Shifted, String> {
    let (latent, count) = (Latent::default(), posterior.unknowns.len());
    let mut joint = Joint::new(data, &posterior.model, &posterior.unknowns, &latent)?;
    let y = white_round(&mut joint, &posterior.y[..count], HERE)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    let (sums, model, moved) = (joint.sums_here(&y), joint.model(&y)?, joint.moved(&y)?);
    let of = |(k, slot): (usize, &mut Slot)| Driven::of(data, k, slot, &model, &moved, redrawn[k].as_ref());
    let driven = first_failure(joint.slots.par_iter_mut().enumerate().map(of))?;
    let runs = |driven: &Driven| (1 + 2 * driven.pairs.len()) + (1 + driven.pairs.len()) * moved.len();
    data.bench.count(joint.simulations + driven.iter().map(runs).sum::<usize>());
    let n = y.len();
    let mut curvature = DMatrix::from_row_slice(n, n, &sums.curvature);
    let held = joint.hold(&y, &mut curvature);
    let inverse = curvature.cholesky().ok_or("the curvature is not positive")?.inverse();
    let (mut scatter, mut mean) = (DMatrix::zeros(n, n), DVector::zeros(n));
    for (k, (record, driven)) in joint.whitened().iter().zip(&driven).enumerate() {
        if !driven.pairs.is_empty() {
            let driven = driven.whitened(&joint, k);
            scatter += driven.scattered(n, record);
            let (of_record, its_error) = driven.mean(n, record);
            (mean, scatter) = (mean + of_record, scatter + its_error);
        }
    }
    for i in held {
        scatter.row_mut(i).fill(0.0);
        scatter.column_mut(i).fill(0.0);
        mean[i] = 0.0;
    }
    let (more, step) = (&inverse * scatter * &inverse, &inverse * mean);
    if !more.iter().chain(&step).all(|x| x.is_finite()) {
        return Err("what it changes is not finite".to_owned());
    }
    let (lower, upper) = joint.bounds();
    let y: Vec<f64> = (0..count).map(|i| (y[i] + step[i]).clamp(lower[i], upper[i])).collect();
    Ok(Shifted { model: joint.model(&y)?, y, more })
}

/// Each record with other noise in what drives `model`.
fn drawn(data: &Measured, model: &Model) -> Vec<Option<Redrawn>> {
    let record = |k: usize| data.lane(k).record;
    let memories = Memories::of(model, (0..data.records.len()).map(record));
    (0..data.records.len()).map(|k| redrawn(model, record(k), &memories, (PAIRS, k as u64))).collect()
}

impl Driven {
    /// What the noise of `redrawn`, which is record `k` with other noise, changes of its predictions.
    fn of(
        data: &Measured,
        k: usize,
        slot: &Slot,
        model: &Model,
        moved: &[(Model, f64)],
        redrawn: Option<&Redrawn>,
    ) -> Result<Self, String> {
        let Some(Redrawn { quiet, pairs: redrawn }) = redrawn else { return Ok(Self::default()) };
        let lane = data.lane(k);
        let another = || format!("`{}` has another response under other noise", lane.record.name);
        let near = |there: &[f64], here: &[f64]| data.size_of(k, &minus(there, here)) < WRONG_BRANCH;
        let (quiet, columns) = slot.driven_by(model, moved, quiet, lane)?;
        if !near(&quiet, &slot.linearised) {
            return Err(another());
        }
        let mut pairs = Vec::new();
        for [one, other] in redrawn {
            data.bench.unless_interrupted()?;
            if let Ok((one, columns)) = slot.driven_by(model, moved, one, lane)
                && let Ok((other, _)) = slot.driven_by(model, &[], other, lane)
                && near(&one, &quiet)
                && near(&other, &quiet)
            {
                pairs.push(Pair::new(&one, &quiet, &other, columns));
            }
        }
        if pairs.is_empty() { Err(another()) } else { Ok(Self { columns, pairs }) }
    }

    /// In standard deviations of the noise of record `k`.
    fn whitened(&self, joint: &Joint, k: usize) -> Self {
        let whiten = |values: &Vec<f64>| joint.noise.whiten(joint.data, k, values);
        let all = |columns: &[Vec<f64>]| columns.iter().map(whiten).collect();
        let pair = |Pair { odd, even, columns }: &Pair| Pair {
            odd: whiten(odd),
            even: whiten(even),
            columns: all(columns),
        };
        Self { columns: all(&self.columns), pairs: self.pairs.iter().map(pair).collect() }
    }

    /// Mean gradient of `n` unknowns that this noise gives, to second order in it, and the covariance of that mean: what both
    /// of a pair change, and what one changes where it changes the derivatives, too.
    fn mean(&self, n: usize, record: &Whitened) -> (DVector<f64>, DMatrix<f64>) {
        let count = self.pairs.len() as f64;
        let gradient = |pair: &Pair| {
            let mut gradient = DVector::zeros(n);
            record.columns.iter().for_each(|(i, column)| gradient[*i] = dot(column, &pair.even));
            // The past of a record, which comes after the parameters, is another unknown in each simulation.
            for (i, (there, here)) in pair.columns.iter().zip(&self.columns).enumerate() {
                gradient[i] += dot(there, &pair.odd) - dot(here, &pair.odd);
            }
            gradient
        };
        let of_pairs: Vec<DVector<f64>> = self.pairs.iter().map(gradient).collect();
        let mean = of_pairs.iter().fold(DVector::zeros(n), |sum, of| sum + of) / count;
        let mut covariance = DMatrix::zeros(n, n);
        for of in of_pairs.iter().filter(|_| count > 1.0) {
            let about = of - &mean;
            covariance += &about * about.transpose() / (count * (count - 1.0));
        }
        (mean, covariance)
    }

    /// Mean square of the gradients of `n` unknowns that this noise gives, beyond what white noise of its size would make: the
    /// residual holds that already.
    fn scattered(&self, n: usize, record: &Whitened) -> DMatrix<f64> {
        let mut of_gradient = DMatrix::zeros(n, n);
        let mut square = 0.0;
        for Pair { odd, .. } in &self.pairs {
            let mut gradient = DVector::zeros(n);
            record.columns.iter().for_each(|(i, column)| gradient[*i] = dot(column, odd));
            of_gradient += &gradient * gradient.transpose() / self.pairs.len() as f64;
            square += dot(odd, odd) / self.pairs.len() as f64;
        }
        let share = square / record.residuals.len().max(1) as f64;
        for (i, one) in &record.columns {
            record.columns.iter().for_each(|(k, other)| of_gradient[(*i, *k)] -= share * dot(one, other));
        }
        of_gradient
    }
}

impl Pair {
    /// Of predictions under one noise, under none and under its opposite.
    fn new(one: &[f64], quiet: &[f64], other: &[f64], columns: Vec<Vec<f64>>) -> Self {
        let odd = one.iter().zip(other).map(|(one, other)| 0.5 * (one - other)).collect();
        let middle = one.iter().zip(other).map(|(one, other)| 0.5 * (one + other));
        Self { odd, even: middle.zip(quiet).map(|(middle, quiet)| middle - quiet).collect(), columns }
    }
}

/// Adds the covariance `more`, where it is one, to that of the unknowns.
pub(super) fn widen(posterior: &mut Posterior, more: &DMatrix<f64>) {
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
    use crate::data::{Dataset, Record, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::samples::{from_rest, moved, oscillator, slider};
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::colour::Colour;
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::predict;
    use crate::numeric::random::Random;

    /// As fitted, and with the noise of the inputs allowed for.
    fn allowed(truth: &Model, records: Vec<Record>) -> [Posterior; 2] {
        let dataset = Dataset { title: None, records };
        let bench = WeightedDataset::new(truth, &dataset, Assumptions::default(), None).unwrap();
        let all: Vec<usize> = (0..dataset.records.len()).collect();
        let data = Measured::new(&bench, &all, &[], &[]);
        let fitted = first(&data, None, truth).and_then(|(first, _)| again(&data, &first)).unwrap();
        let mut allowed = fitted.clone();
        allow_for_inputs(&data, &mut allowed).unwrap();
        [fitted, allowed]
    }

    /// Mean square of how far the parameters are off, in deviations.
    fn off(of: &Posterior) -> f64 {
        let squares = of.y.iter().zip(&of.deviations).map(|(y, deviation)| (y / deviation).powi(2));
        squares.sum::<f64>() / of.y.len() as f64
    }

    /// The mean of that over twelve measurements by `records`, of both.
    fn mean_off(truth: &Model, records: impl Fn(&mut Random) -> Vec<Record>) -> [f64; 2] {
        let found: Vec<[f64; 2]> =
            (0..12).map(|seed| allowed(truth, records(&mut Random::new(seed))).map(|of| off(&of))).collect();
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
            let mut record = moved(truth, 1000, 1e-3, |i| amplitude * (0.05 * f64::from(i)).sin());
            record.regime = Regime::UnknownInitialState;
            record.channels.iter_mut().for_each(|channel| drop(channel.values.drain(..300)));
            measured(&mut record, [3e-3, 1e-3], random);
            record
        };
        [4e-5, 8e-5].map(record).to_vec()
    }

    /// A contact that was at rest, its displacement slow and measured with noise that remembers.
    fn shaken(truth: &Model, random: &mut Random) -> Vec<Record> {
        let record = |amplitude: f64| {
            let motion = |i: u32| {
                let time = 2e-3 * f64::from(i);
                amplitude * (0.3 + 0.05 * time) * (3.0 * time * (1.0 + 0.1 * time)).sin()
            };
            let mut record = moved(truth, 6000, 2e-3, motion);
            measured(&mut record, [0.0, 0.01], random);
            let noise = Colour { deviation: 1e-3 * amplitude, memory: 0.95 }.drawn(6000, random);
            record.channels[1].values.iter_mut().zip(noise).for_each(|(x, noise)| *x += noise);
            record
        };
        [3e-5, 6e-5, 1.2e-4].map(record).to_vec()
    }

    #[test]
    fn what_noise_does_to_one_side_is_taken_off() {
        let truth = slider("");
        let (mut bias, mut mean) = ([[0.0; 2]; 2], 0.0);
        for seed in 0..12 {
            let both = allowed(&truth, shaken(&truth, &mut Random::new(seed)));
            for (bias, of) in bias.iter_mut().zip(&both) {
                bias.iter_mut().zip(&of.y).for_each(|(bias, y)| *bias += y / 12.0);
            }
            assert_eq!(both[0].predictions, both[1].predictions);
            mean += off(&both[1]) / 12.0;
        }
        let [fitted, allowed] = bias;
        // The stiffness is too low and the limit too high.
        assert!(fitted[0] < -6e-4 && fitted[1] > 6e-4, "{fitted:?}");
        assert!(
            allowed.iter().zip(fitted).all(|(less, more)| less.abs() < 0.5 * more.abs()),
            "{allowed:?} {fitted:?}"
        );
        assert!((0.3..1.8).contains(&mean), "{mean}");
    }

    #[test]
    fn intervals_allow_for_the_noise_of_what_drives() {
        let truth = oscillator(2e3, 0.3);
        let [fitted, widened] = mean_off(&truth, |random| oscillators(&truth, 0.02, random));
        assert!(fitted > 2.5 && (0.5..1.8).contains(&widened), "{fitted} {widened}");
        let [fitted, widened] =
            allowed(&truth, oscillators(&truth, 0.0, &mut Random::new(1))).map(|of| off(&of));
        assert_eq!(fitted, widened);
    }

    #[test]
    fn noise_that_the_residual_shows_widens_nothing_and_an_unknown_past_neither() {
        let truth = slider("");
        let [fitted, widened] = mean_off(&truth, |random| loops(&truth, random));
        assert!((0.3..2.0).contains(&widened) && widened > 0.6 * fitted, "{fitted} {widened}");
        for seed in 0..4 {
            let [fitted, allowed] = allowed(&truth, loops(&truth, &mut Random::new(seed)));
            let shifts = fitted.y.iter().zip(&allowed.y).map(|(before, after)| (after - before).abs());
            assert!(shifts.zip(&allowed.deviations).all(|(shift, deviation)| shift < 0.7 * deviation));
        }
    }
}
