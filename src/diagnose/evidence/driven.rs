//! What the noise of the inputs makes of the parameters. A residual does not show it: the model is driven by that noise, and
//! its parameters follow.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::joint::{Joint, dot};
use super::latent::Latent;
use super::measured::Measured;
use super::posterior::{HERE, Posterior, white_round};
use super::slot::Slot;
use crate::diagnose::measurements::inputs::shaken;

/// Times that the inputs of each record are driven with other noise: records beside each other add to the number.
const TIMES: u64 = 4;

/// `posterior` with the variance that the noise of the inputs gives its unknowns added to theirs, to first order: how far each
/// record moves them when its inputs have as much noise again.
pub(super) fn widened(data: &Measured, posterior: &Posterior) -> Result<Posterior, String> {
    let (latent, count) = (Latent::default(), posterior.unknowns.len());
    let mut joint = Joint::new(data, &posterior.model, &posterior.unknowns, &latent)?;
    let y = white_round(&mut joint, &posterior.y[..count], HERE)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    let (sums, model, whitened) = (joint.sums_here(&y), joint.model(&y)?, joint.whitened());
    let n = y.len();
    let factor = DMatrix::from_row_slice(n, n, &sums.curvature).cholesky();
    let factor = factor.ok_or("the curvature is not positive")?;
    let changes = |(k, slot): (usize, &mut Slot)| -> Vec<Vec<f64>> {
        let lane = data.lane(k);
        let change = |time: u64| {
            data.bench.unless_interrupted().ok()?;
            let record = shaken(&model, lane.record, k as u64 * TIMES + time)?;
            slot.driven_by(&model, &record, lane.seed.as_ref(), &y).ok()
        };
        (0..TIMES).filter_map(change).collect()
    };
    let changes: Vec<Vec<Vec<f64>>> = joint.slots.par_iter_mut().enumerate().map(changes).collect();
    data.bench.unless_interrupted()?;
    data.bench.count(changes.iter().map(Vec::len).sum());
    let mut more = DMatrix::zeros(n, n);
    for (k, (record, changes)) in whitened.iter().zip(&changes).enumerate() {
        for change in changes {
            let change = joint.noise.whiten(data, k, change);
            let mut gradient = DVector::zeros(n);
            record.columns.iter().for_each(|(i, column)| gradient[*i] = dot(column, &change));
            let moved = factor.solve(&gradient);
            more += &moved * moved.transpose() / changes.len() as f64;
        }
    }
    Ok(with_more(posterior, &more))
}

/// `posterior` with the covariance `more` added to that of its unknowns.
fn with_more(posterior: &Posterior, more: &DMatrix<f64>) -> Posterior {
    let count = posterior.unknowns.len();
    let own = |i: usize| posterior.deviations[i];
    let covariance =
        |i: usize, k: usize| posterior.correlations[i * count + k] * own(i) * own(k) + more[(i, k)];
    let deviations: Vec<f64> = (0..count).map(|i| own(i).hypot(more[(i, i)].sqrt())).collect();
    let pairs = (0..count).flat_map(|i| (0..count).map(move |k| (i, k)));
    let correlations = pairs.map(|(i, k)| covariance(i, k) / (deviations[i] * deviations[k])).collect();
    Posterior { deviations, correlations, ..posterior.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::samples::{from_rest, oscillator};
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::predict;
    use crate::model::Model;

    /// Squares of how far the parameters are off, in deviations: as fitted, and widened. The force is measured with noise of
    /// `of_force` of its amplitude, the displacement with far less.
    fn off(truth: &Model, of_force: f64, seed: u64) -> [f64; 2] {
        let mut noise = crate::numeric::random::Random::new(seed);
        let records = [6.0, 8.0, 12.0].map(|amplitude| {
            let mut record = from_rest(amplitude);
            record.channels[2].values = predict(truth, &record).unwrap()[0].values.clone();
            let size = record.channels[2].values.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
            record.channels[1].values.iter_mut().for_each(|x| *x += of_force * amplitude * noise.normal());
            record.channels[2].values.iter_mut().for_each(|x| *x += 1e-4 * size * noise.normal());
            record
        });
        let dataset = Dataset { title: None, records: records.to_vec() };
        let bench = WeightedDataset::new(truth, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let fitted = first(&data, None, truth).and_then(|(first, _)| again(&data, &first)).unwrap();
        let widened = widened(&data, &fitted).unwrap();
        assert_eq!(widened.y, fitted.y);
        [fitted, widened].map(|of| {
            let squares = of.y.iter().zip(&of.deviations).map(|(y, deviation)| (y / deviation).powi(2));
            squares.sum::<f64>() / of.y.len() as f64
        })
    }

    #[test]
    fn intervals_allow_for_the_noise_of_what_drives() {
        let truth = oscillator(2e3, 0.3);
        let found: Vec<[f64; 2]> = (0..12).map(|seed| off(&truth, 0.02, seed)).collect();
        let [fitted, widened] =
            [0, 1].map(|k| found.iter().map(|of| of[k]).sum::<f64>() / found.len() as f64);
        assert!(fitted > 2.5 && (0.4..2.0).contains(&widened), "{fitted} {widened}");
        let [fitted, widened] = off(&truth, 0.0, 1);
        assert_eq!(fitted, widened);
    }
}
