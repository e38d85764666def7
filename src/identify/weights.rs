//! What a law may leave of an identified force: the errors of the identification, and what no law follows.

use nalgebra::{DMatrix, DVector};

use super::ContactPeriod;
use super::IdentificationError;
use super::laws::{mapped, unfit};
use crate::contact::LawKind;
use crate::model::Model;

/// How far a law is from a contact before that is estimated, as a part of the force's root mean square.
pub(super) const ROUGHLY: f64 = 1e-3;
/// No law is closer: balances and samples are not exact either.
const CLOSEST: f64 = 1e-6;
const FARTHEST: f64 = 10.0;
/// Halvings of the range between them, on a logarithmic scale.
const HALVINGS: usize = 40;

/// Covariance of the law's force under the identified motion less the identified force.
pub(super) fn difference(model: &Model, period: &ContactPeriod) -> Result<DMatrix<f64>, IdentificationError> {
    let map = mapped(model, period)?;
    let count = period.force.len();
    let slopes = map.jacobian().rows(0, count).into_owned();
    let cross = &slopes * &period.cross_covariance;
    let own = &slopes * &period.displacement_covariance * slopes.transpose();
    Ok(&period.covariance + own - &cross - cross.transpose())
}

/// The factor that makes what a law leaves of `period` white: errors of covariance `expected`, and in every coefficient what the law
/// does not follow, a part `close` of the force's root mean square.
pub(super) fn factor(
    kind: &LawKind,
    period: &ContactPeriod,
    mut expected: DMatrix<f64>,
    close: f64,
) -> Result<DMatrix<f64>, IdentificationError> {
    let variance = (close * size(period)).powi(2);
    (0..expected.nrows()).for_each(|k| expected[(k, k)] += variance);
    let factor = expected.cholesky().ok_or_else(|| unfit(kind, "the force has no covariance"))?;
    Ok(factor.l())
}

/// How closely a law follows the contact, which `left` so much of each period's force with `freedom` degrees of freedom: the least
/// part of the force's root mean square that, beside errors of covariance `expected`, explains all of it (the estimate of Mandel and
/// Paule). What the errors explain is no distance of the law's.
pub(super) fn closeness(
    left: &[DVector<f64>],
    periods: &[&ContactPeriod],
    expected: &[DMatrix<f64>],
    freedom: usize,
) -> f64 {
    // Along the axes of the errors a distance that is alike in all coefficients adds to each variance.
    let mut terms = Vec::new();
    for ((left, period), expected) in left.iter().zip(periods).zip(expected) {
        let axes = (0.5 * (expected + expected.transpose())).symmetric_eigen();
        let along = axes.eigenvectors.transpose() * left;
        let square = size(period).powi(2);
        terms.extend(
            along.iter().zip(&axes.eigenvalues).map(|(x, variance)| (x * x, variance.max(0.0), square)),
        );
    }
    let excess = |close: f64| {
        let weighed = |(x, variance, square): &(f64, f64, f64)| x / (variance + close * close * square);
        terms.iter().map(weighed).sum::<f64>() > freedom as f64
    };
    let (mut low, mut high) = (CLOSEST, FARTHEST);
    if !excess(low) {
        return low;
    }
    for _ in 0..HALVINGS {
        let middle = (low * high).sqrt();
        (low, high) = if excess(middle) { (middle, high) } else { (low, middle) };
    }
    high
}

/// Root mean square of the force, mean left out.
fn size(period: &ContactPeriod) -> f64 {
    (0.5 * period.force[1..].iter().map(|value| value * value).sum::<f64>()).sqrt()
}
