//! Small tables over what a motion shows and remembers: what a force may follow.

use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::{Measured, MeasuredChannel};
use crate::diagnose::evidence::posterior::Posterior;
use crate::fit::predict::Motion;

/// Nodes over displacement and velocity, over the distance since a reversal, and over time.
const NODES: [usize; 3] = [9, 6, 7];
/// Times over which the motion is remembered, over that in which it passes its range at full speed.
const MEMORIES: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// How a contact moves through one record.
pub(super) struct ContactMotion<'m> {
    pub motion: &'m Motion,
    /// Instants of its samples (s), where they are told.
    pub time: Option<&'m [f64]>,
}

/// Extremes over all records, by which the tables are scaled.
pub(super) struct Extremes {
    /// Of the displacement: where a sensor has its zero is no part of a motion.
    middle: f64,
    /// On either side of it.
    reach: f64,
    fastest: f64,
    longest: f64,
}

impl Extremes {
    /// Over all that `moved`.
    pub fn of<'m>(moved: impl Iterator<Item = ContactMotion<'m>> + Clone) -> Self {
        let motions = || moved.clone().map(|one| one.motion);
        let places = || motions().flat_map(|motion| motion.values.iter().copied());
        let [low, high] =
            [places().fold(f64::INFINITY, f64::min), places().fold(f64::NEG_INFINITY, f64::max)];
        let length = |one: ContactMotion| Some(one.time?.last()? - one.time?.first()?);
        Self {
            middle: 0.5 * (low + high),
            reach: f64::MIN_POSITIVE.max(0.5 * (high - low)),
            fastest: largest(motions().flat_map(|motion| motion.rates.iter().copied())),
            longest: largest(moved.clone().filter_map(length)),
        }
    }
}

pub(super) fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::MIN_POSITIVE, |a, b| a.max(b.abs()))
}

/// Of size one of each channel.
pub(super) fn columns(data: &Measured, posterior: &Posterior) -> Latent {
    let motion = |k: usize| {
        let record = data.lane(k).record;
        Some(Motion::even(&record.channel("displacement")?.values, record.sample_step()?))
    };
    let motions: Vec<Option<Motion>> = (0..data.records.len()).map(motion).collect();
    let moved = |k: usize| {
        let time = data.lane(k).record.time();
        motions[k].as_ref().map(|motion| ContactMotion { motion, time })
    };
    let extremes = Extremes::of((0..motions.len()).filter_map(moved));
    let size = |process: usize| {
        let of = |(k, channels): (usize, &Vec<MeasuredChannel>)| {
            let own = channels.iter().filter(|c| c.process == process);
            largest(own.flat_map(|c| data.lane(k).measured[c.range.clone()].iter().copied()))
        };
        largest(data.channels.iter().enumerate().map(of))
    };
    let mut latent = Latent::default();
    for (k, channels) in data.channels.iter().enumerate() {
        let all = data.lane(k).measured.len();
        let mut mine = Vec::new();
        for channel in channels {
            let Some(moved) = moved(k) else { continue };
            let scale = size(channel.process);
            let predicted = &posterior.predictions[k][channel.range.clone()];
            for (w, column) in of_force(&moved, predicted, &extremes).into_iter().enumerate() {
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

/// Hat functions of `x` over evenly spaced nodes in [−1, 1].
fn hats(nodes: usize, count: usize, x: impl Fn(usize) -> f64) -> Vec<Vec<f64>> {
    let hat = |node: usize, i: usize| {
        let place = (x(i).clamp(-1.0, 1.0) + 1.0) / 2.0 * (nodes - 1) as f64;
        (1.0 - (place - node as f64).abs()).max(0.0)
    };
    (0..nodes).map(|node| (0..count).map(|i| hat(node, i)).collect()).collect()
}

/// What may follow a motion under the `predicted` force, of size one.
pub(super) fn of_force(moved: &ContactMotion, predicted: &[f64], most: &Extremes) -> Vec<Vec<f64>> {
    let ContactMotion { motion, time } = moved;
    let (n, largest) = (predicted.len(), largest(predicted.iter().copied()));
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
    if let Some(time) = time {
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
