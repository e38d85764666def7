//! Prediction covariance: the effect of the uncertainty of fitted parameters on predictions of other records.

use nalgebra::{DMatrix, SymmetricEigen};

use super::trial::{Unknown, products};
use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::model::Model;

/// Fraction of the curvature's diagonal that is added, so that parameters that the records do not determine have a variance, too.
const LEAST: f64 = 1e-10;

/// Mean square, in units of the noise's, that the uncertainty of `unknowns` of `model`, fitted to the records `fitted`, adds
/// on average to the residuals of the records `others`. Where a response is near a jump it can be far more than the
/// noise. Its own scatter is that of a square: with one uncertain parameter four times the average is two standard
/// errors.
pub(in crate::diagnose) fn of_predictions(
    bench: &WeightedDataset,
    model: &Model,
    unknowns: &[Unknown],
    fitted: &[usize],
    others: &[usize],
) -> Result<f64, String> {
    let (there, _) = products(bench, model, unknowns, others, &[])?;
    let (here, size) = products(bench, model, unknowns, fitted, &[])?;
    let shared = unknowns.len();
    let scale: Vec<f64> = (0..size).map(|j| here.curvature[(j, j)].sqrt()).collect();
    let seen: Vec<usize> = (0..size).filter(|&j| scale[j] > 0.0).collect();
    let scaled = DMatrix::from_fn(seen.len(), seen.len(), |a, b| {
        let own = if a == b { LEAST } else { 0.0 };
        here.curvature[(seen[a], seen[b])] / (scale[seen[a]] * scale[seen[b]]) + own
    });
    let inverse = scaled.try_inverse().ok_or("the covariance of the parameters cannot be computed")?;
    // Directions in which the others' predictions change independently of each other.
    let changes = SymmetricEigen::new(there.curvature.view((0, 0), (shared, shared)).into_owned());
    let mut along = DMatrix::zeros(size, shared);
    for (k, (direction, square)) in
        changes.eigenvectors.column_iter().zip(changes.eigenvalues.iter()).enumerate()
    {
        for (a, &j) in seen.iter().enumerate() {
            let moved = seen.iter().enumerate().filter(|(_, i)| **i < shared);
            let sum: f64 = moved.map(|(b, &i)| inverse[(a, b)] * direction[i] / scale[i]).sum();
            along[(j, k)] = square.max(0.0).sqrt() * sum / scale[j];
        }
    }
    Ok(here.variances(&along).iter().sum::<f64>() / there.count.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::refit::trial::{Effort, fit};
    use crate::fit::{Parameter, Scale};

    const STIFFNESS: f64 = 5e6; // N/m
    const LIMIT: f64 = 50.0; // N
    const DEVIATION: f64 = 3.0; // N

    /// Loops from rest of the levels (m) `levels`, with white noise of a number's own.
    fn dataset(levels: &[f64], draw: u64) -> Dataset {
        // A fork, since the numbers of neighbouring seeds resemble each other.
        let mut numbers = fastrand::Rng::with_seed(draw).fork();
        let mut normal = || (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0;
        let channel =
            |name: &str, unit, values: Vec<f64>| Channel { name: name.into(), unit, values, noise: None };
        let mut record = |level: &f64| {
            let moved: Vec<f64> = (0..400).map(|i| level * (0.05 * f64::from(i)).sin()).collect();
            let (mut force, mut last) = (0.0, 0.0);
            let measured = moved.iter().map(|u| {
                force = f64::clamp(force + STIFFNESS * (u - last), -LIMIT, LIMIT);
                last = *u;
                force + DEVIATION * normal()
            });
            let measured = measured.collect();
            let time = (0..400).map(|i| f64::from(i) * 1e-3).collect();
            let channels = vec![
                channel("time", "s", time),
                channel("displacement", "m", moved.clone()),
                channel("force", "N", measured),
            ];
            Record { name: "loop".into(), regime: Regime::FromRest, use_for: None, channels }
        };
        Dataset { title: None, records: levels.iter().map(&mut record).collect() }
    }

    fn unknown(path: &str, start: f64) -> Unknown {
        let parameter =
            Parameter { start, lower: 0.2 * start, upper: 5.0 * start, scale: Scale::Logarithmic };
        Unknown { path: path.into(), parameter, unit: "" }
    }

    /// The expected value is the scatter of predictions by fits to noise that is drawn anew.
    #[test]
    fn the_standard_error_of_predictions_is_their_scatter() {
        let text = format!(
            "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
             tangential_stiffness = {STIFFNESS}\nfriction_coefficient = 0.5\nnormal_load = {}\n",
            LIMIT / 0.5
        );
        let model = Model::parse(&text).unwrap();
        let unknowns = [
            unknown("contact.tangential_stiffness", STIFFNESS),
            unknown("contact.friction_coefficient", 0.5),
        ];
        // The first hardly slips: the limit is uncertain, and the second shows little else.
        const DRAWS: u64 = 60;
        let (mut scatter, mut expected) = (0.0, 0.0);
        for draw in 0..DRAWS {
            let data = dataset(&[1.05e-5, 5e-5], draw);
            let mut bench = WeightedDataset::new(&model, &data, None).unwrap();
            bench.lanes.iter_mut().for_each(|lane| lane.weights.fill(1.0 / DEVIATION));
            let exact = &bench.score(&model, &[1]).unwrap()[0].predictions;
            let fitted = fit(&bench, &model, &unknowns, &[0], Effort::Full).unwrap();
            let found = &bench.score(&fitted.model, &[1]).unwrap()[0].predictions;
            let square: f64 = found.iter().zip(exact).map(|(a, b)| ((a - b) / DEVIATION).powi(2)).sum();
            scatter += square / found.len() as f64 / DRAWS as f64;
            expected += of_predictions(&bench, &fitted.model, &unknowns, &[0], &[1]).unwrap() / DRAWS as f64;
        }
        assert!((0.6..1.6).contains(&(expected / scatter)), "{expected} of {scatter}");
    }
}
