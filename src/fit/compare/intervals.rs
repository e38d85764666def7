//! What a refit says of each parameter: intervals that allow for residuals with a memory.

use nalgebra::DMatrix;

use super::comparison::Fitted;
use crate::fit::Fit;
use crate::model::ModelParameter;
use crate::vocabulary::Scale;

/// Blocks that the residuals are cut into at least: fewer say nothing of a variance.
const BLOCKS: usize = 20;

/// A memory that fades more slowly from sample to sample is not told apart from a wrong model.
const FADING: f64 = 0.98;

/// One entry per parameter of `free`, in the order of the `fit`; `unseen` are the indices of those without any effect.
pub(super) fn fitted(free: &[ModelParameter], fit: &Fit, unseen: &[usize]) -> Vec<Fitted> {
    let paths: Vec<&str> = free.iter().map(|parameter| parameter.path.as_str()).collect();
    let count = free.len();
    let known: Vec<usize> = (0..count).filter(|j| fit.uncertainty.interval[*j].is_some()).collect();
    let wider = memory(fit, count, &known);
    let factor = |j: usize| known.iter().position(|k| *k == j).map_or(1.0, |place| wider[place]);
    free.iter()
        .enumerate()
        .map(|(j, parameter)| Fitted {
            from: Some(parameter.value),
            interval: fit.uncertainty.interval[j].map(|interval| {
                let end = |end: f64| moved(parameter, fit.parameters[j], end, factor(j));
                [end(interval.low), end(interval.high)]
            }),
            at_bound: fit.uncertainty.at_bound[j],
            unseen: unseen.contains(&j),
            correlated: Fitted::told(j, &paths, &fit.uncertainty.correlation[j * count..(j + 1) * count]),
        })
        .collect()
}

/// The `end` of an interval around `value` that is `factor` times as wide, within the bounds.
fn moved(parameter: &ModelParameter, value: f64, end: f64, factor: f64) -> f64 {
    let end = match parameter.scale {
        Scale::Logarithmic if value > 0.0 && end > 0.0 => value * (end / value).powf(factor),
        _ => value + factor * (end - value),
    };
    end.clamp(parameter.lower, parameter.upper)
}

/// By how much the standard errors of the parameters `known` are larger than those of independent residuals (at least 1).
///
/// Each residual moves an estimate by its part of `(JᵀJ)⁻¹ Jᵀ r`, and the variance of the sum of these parts is that of the
/// estimate, whatever their memory.
fn memory(fit: &Fit, count: usize, known: &[usize]) -> Vec<f64> {
    let mut wider = vec![1.0_f64; known.len()];
    let rows = fit.residuals.len();
    if known.is_empty() || rows <= count || fit.jacobian.len() != count {
        return wider;
    }
    let row = |i: usize| known.iter().map(move |k| fit.jacobian[*k][i]);
    let mut curvature = DMatrix::<f64>::zeros(known.len(), known.len());
    for i in 0..rows {
        for (a, left) in row(i).enumerate() {
            row(i).enumerate().for_each(|(b, right)| curvature[(a, b)] += left * right);
        }
    }
    let Some(inverse) = curvature.cholesky().map(|factor| factor.inverse()) else { return wider };
    let variance = fit.residuals.iter().map(|r| r * r).sum::<f64>() / (rows - count) as f64;
    for (k, wider) in wider.iter_mut().enumerate() {
        // By how much each residual moves this estimate.
        let moved =
            |i: usize| fit.residuals[i] * row(i).zip(inverse.row(k).iter()).map(|(j, c)| j * c).sum::<f64>();
        let influence = (0..rows).map(moved).collect();
        let ratio = (variance_of_sum(influence) / (variance * inverse[(k, k)])).sqrt();
        *wider = if ratio.is_finite() { wider.max(ratio) } else { *wider };
    }
    wider
}

/// The variance of the sum of numbers with a memory: the largest that blocks of any length show, or a memory that fades
/// evenly (an autoregression of order one).
fn variance_of_sum(influence: Vec<f64>) -> f64 {
    let square = |all: &[f64]| all.iter().map(|x| x * x).sum::<f64>();
    let own = square(&influence);
    let product: f64 = influence.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let kept = if influence.len() >= BLOCKS { (product / own).clamp(0.0, FADING) } else { 0.0 };
    let mut largest = own * (1.0 + kept) / (1.0 - kept);
    let mut blocks = influence;
    while blocks.len() >= BLOCKS {
        largest = largest.max(square(&blocks));
        blocks = blocks.chunks(2).map(|pair| pair.iter().sum()).collect();
    }
    largest
}
