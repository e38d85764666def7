//! The starts of records of unknown past: scanned before a fit, and again where its end shows that one was missed.

use rayon::prelude::*;

use super::joint::{Joint, dot, minus};
use super::measured::{Measured, NoiseModel};
use super::slot::Slot;

/// Noise over what was told of it, from which a record's start may be wrong.
const LOUD: f64 = 1.05;

impl Joint<'_, '_> {
    /// Finds the records' own starts by their scans at the `shared` unknowns; gives the whole point.
    pub fn settle(&mut self, shared: &[f64]) -> Result<Vec<f64>, String> {
        let model = self.model(shared)?;
        let (data, noise) = (self.data, &self.noise);
        self.slots
            .par_iter_mut()
            .enumerate()
            .try_for_each(|(k, slot)| slot.scan(&model, &data.lane(k).measured, &weights(data, noise, k)))?;
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
                other.scan(&model, &lane.measured, &weights)?;
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
