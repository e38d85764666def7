//! The starts of records of unknown past: scanned before a fit, and again where its end shows that one was missed.

use rayon::prelude::*;

use super::joint::{Joint, dot, first_failure, minus};
use super::measured::{Measured, NoiseModel};
use super::slot::Slot;

/// Noise over what was told of it, from which a record's start may be wrong.
const LOUD: f64 = 1.05;

impl Joint<'_, '_> {
    /// Finds the records' own starts by their scans at the `shared` unknowns, for a point that is `moved` on or not; gives the
    /// whole point.
    pub fn settle(&mut self, shared: &[f64], moved: bool) -> Result<Vec<f64>, String> {
        let model = self.model(shared)?;
        let (data, noise) = (self.data, &self.noise);
        let scan = |(k, slot): (usize, &mut Slot)| {
            slot.scan(&model, &data.lane(k).measured, &weights(data, noise, k), moved)
        };
        first_failure(self.slots.par_iter_mut().enumerate().map(scan))?;
        let mut offset = self.shared();
        let mut y = shared.to_vec();
        for slot in &mut self.slots {
            slot.offset = offset;
            offset += slot.own.len();
            y.extend_from_slice(&slot.own_start);
        }
        Ok(y)
    }

    /// Scans the starts of records anew whose noise at `y` is more than was told, and takes those that explain more; whether
    /// there was any.
    pub fn rescan(&mut self, y: &mut [f64]) -> Result<bool, String> {
        let model = self.model(y)?;
        let (data, noise, priors, base) = (self.data, &self.noise, &self.priors, self.base);
        let here: &[f64] = y;
        let found: Vec<Option<(usize, Vec<f64>)>> = self
            .slots
            .par_iter_mut()
            .enumerate()
            .map(|(k, slot)| {
                let (lane, weights) = (data.lane(k), weights(data, noise, k));
                let left = minus(&slot.linearised, &lane.measured);
                let seen = |range: &std::ops::Range<usize>| {
                    let part = &left[range.clone()];
                    (dot(part, part) / part.len() as f64).sqrt()
                };
                let mut channels = data.channels[k].iter().zip(&priors[k]);
                let loud = channels.any(|(channel, told)| seen(&channel.range) > LOUD * told.largest);
                if slot.own.is_empty() || !loud {
                    return Ok(None);
                }
                // Of a simulation of its own: what its numbers mean belongs to the hypothesis that it chose.
                let mut other = Slot::new(lane.shown(base)?);
                other.scan(&model, &lane.measured, &weights, false)?;
                other.offset = slot.offset;
                let cost = |slot: &mut Slot, values: &[f64]| -> Result<f64, String> {
                    slot.shown.predict(&model, values, &mut slot.predictions)?;
                    let e = noise.whiten(data, k, &minus(&slot.predictions, &lane.measured));
                    Ok(0.5 * dot(&e, &e))
                };
                let values: Vec<f64> =
                    other.own.iter().zip(&other.own_start).map(|(c, y)| c.value(*y)).collect();
                let before = slot.own_values(here);
                if cost(slot, &before)? - cost(&mut other, &values)? <= 1.0 {
                    return Ok(None);
                }
                *slot = other;
                Ok(Some((slot.offset, slot.own_start.clone())))
            })
            .collect::<Result<_, String>>()?;
        let mut any = false;
        for (offset, other) in found.into_iter().flatten() {
            y[offset..offset + other.len()].copy_from_slice(&other);
            any = true;
        }
        if any {
            self.forget_linearised();
        }
        Ok(any)
    }
}

/// One over the deviation of every sample of the record in place `k`.
fn weights(data: &Measured, noise: &NoiseModel, k: usize) -> Vec<f64> {
    let mut weights = vec![0.0; data.lane(k).measured.len()];
    for (channel, size) in data.channels[k].iter().zip(&noise.sizes[k]) {
        weights[channel.range.clone()].fill(1.0 / size);
    }
    weights
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::latent::Latent;
    use crate::diagnose::evidence::posterior::HERE;
    use crate::diagnose::evidence::samples::slider;
    use crate::diagnose::evidence::unknown::of_model;
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::SumOfSquares;
    use crate::fit::predict::predict;
    use crate::model::Model;

    fn model(spread: f64) -> Model {
        slider(&format!(
            "[[effect]]\nid = \"micro_slip\"\nspread = {spread}\n[[effect]]\nid = \"backlash\"\nhalf_gap = 1e-5\n"
        ))
    }

    /// The second half of a motion from rest, whose frequency and centre differ from record to record.
    fn moved(index: u32) -> Record {
        let (rate, phase) = (0.031 + 0.007 * f64::from(index), 1.3 * f64::from(index));
        let displacement = |i: usize| {
            let sine = |rate: f64| (TAU * rate * i as f64 + phase).sin();
            6e-5 * sine(rate) + 3e-5 * sine(0.31 * rate)
        };
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let time = |count: usize| channel("time", "s", (0..count).map(|i| 1e-3 * i as f64).collect());
        let whole =
            channel("displacement", "m", (0..600).map(|i| displacement(i) - displacement(0)).collect());
        let force = channel("force", "N", vec![0.0; 600]);
        let mut record = Record {
            name: format!("r{index}"),
            regime: Regime::FromRest,
            use_for: None,
            channels: vec![time(600), whole, force],
        };
        record.channels[2].values = predict(&model(0.8), &record).unwrap()[0].values.clone();
        for channel in &mut record.channels {
            channel.values.drain(..300);
        }
        record.channels[0] = time(300);
        Record { regime: Regime::UnknownInitialState, ..record }
    }

    #[test]
    fn a_scan_anew_never_makes_a_fit_worse() {
        let dataset = Dataset { title: None, records: (0..8).map(moved).collect() };
        let base = model(0.3);
        let bench = WeightedDataset::new(&base, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2, 3, 4, 5, 6, 7], &[], &[]);
        let (unknowns, latent) = (of_model(&base, data.assumptions()), Latent::default());
        let mut found = 0;
        for y in
            [[1.0, 0.5, 0.0, -1.0], [-1.0, 0.4, 1.0, 0.5], [0.5, -0.5, 1.5, -0.5], [-0.5, 0.0, -1.0, 1.0]]
        {
            let mut joint = Joint::new(&data, &base, &unknowns, &latent).unwrap();
            let mut y = joint.settle(&y[..unknowns.len()], false).unwrap();
            // Elsewhere than where the starts were found.
            y[..unknowns.len()].iter_mut().for_each(|y| *y *= -0.5);
            joint.minimise(&mut y, HERE).unwrap();
            let before = joint.cost(&y).unwrap();
            let there = y.clone();
            found += usize::from(joint.rescan(&mut y).unwrap());
            // A simulation that took another's place was linearised nowhere, though the point be the same.
            assert!(joint.sums(&there).is_some());
            let after = joint.cost(&y).unwrap();
            assert!(after <= before * (1.0 + 1e-12), "{before} {after}");
        }
        assert!(found > 0);
    }
}
