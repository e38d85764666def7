//! Free parameters that a fit can no longer change.
//!
//! The friction coefficient of a contact that never slips changes nothing: once a fit is there, no derivative leads
//! back to where the contact slips, and its last value has no meaning.

use super::options::{Options, Parameter};
use super::outcome::{Fit, FitError};
use super::starts::fit;
use crate::vocabulary::Scale;

/// Norm of the residuals' change with the whole of a parameter, over that of the residuals, below which it is unseen.
const UNSEEN: f64 = 1e-6;
/// Values that an unseen parameter is tried at on each side of where it started, and the factor between two.
const TRIED: i32 = 12;
const FACTOR: f64 = 1.5;

/// The fit of `residual` (of `count` numbers) to `parameters`, started again where a parameter that no longer had an effect
/// gets one again with a smaller error. A parameter without any effect ends where it started; the indices of these are
/// the second result.
///
/// # Errors
/// As [`fit`].
pub(crate) fn fit_reviving<F>(
    residual: F,
    count: usize,
    parameters: &[Parameter],
    options: &Options,
) -> Result<(Fit, Vec<usize>), FitError<String>>
where
    F: Fn(&[f64], &mut [f64]) -> Result<(), String> + Sync,
{
    let mut best = fit(&residual, count, parameters, options)?;
    for index in 0..parameters.len() {
        let interrupted = options.interrupt.is_some_and(|interrupt| interrupt());
        if interrupted || !is_unseen(&best, index) {
            continue;
        }
        let mut out = vec![0.0; count];
        let mut values = best.parameters.clone();
        let mut error = |value: f64| {
            values[index] = value;
            best.evaluations += 1;
            residual(&values, &mut out).map_or(f64::INFINITY, |()| {
                (out.iter().map(|r| r * r).sum::<f64>() / out.len() as f64).sqrt()
            })
        };
        let start = parameters[index].start;
        let at_start = error(start);
        let tried = tried(&parameters[index]).into_iter().map(|value| (error(value), value));
        let (least, value) =
            tried.fold((at_start, start), |best, other| if other.0 < best.0 { other } else { best });
        // What it is does not matter, unless the start lies where it does.
        if at_start <= best.root_mean_square * (1.0 + UNSEEN) {
            best.parameters[index] = start;
        }
        if least >= best.root_mean_square * (1.0 - UNSEEN) {
            continue;
        }
        let mut starts = parameters.to_vec();
        starts.iter_mut().zip(&best.parameters).for_each(|(start, value)| start.start = *value);
        starts[index].start = value;
        // Interrupted before it begins, it leaves the fit that there is.
        let Ok(again) = fit(&residual, count, &starts, options) else { continue };
        let evaluations = best.evaluations + again.evaluations;
        if again.root_mean_square < best.root_mean_square {
            best = again;
        }
        best.evaluations = evaluations;
    }
    // What ended at zero or at a bound need not be without effect: all of what it was could change something.
    let idle = |index: &usize| {
        let change = column(&best, *index) * parameters[*index].start.abs();
        change < UNSEEN * (count as f64).sqrt()
    };
    let unseen = (0..parameters.len())
        .filter(|index| is_unseen(&best, *index))
        .filter(|index| !(best.parameters[*index] == 0.0 || best.uncertainty.at_bound[*index]) || idle(index))
        .collect();
    Ok((best, unseen))
}

/// Whether the residuals at the end of `fit` do not depend on the `index`-th parameter.
fn is_unseen(fit: &Fit, index: usize) -> bool {
    let change = column(fit, index) * fit.parameters[index].abs();
    let norm = fit.root_mean_square * (fit.residuals.len() as f64).sqrt();
    !fit.jacobian.is_empty() && change < UNSEEN * norm
}

/// Norm of the residuals' derivatives by the `index`-th parameter.
fn column(fit: &Fit, index: usize) -> f64 {
    fit.jacobian.get(index).map_or(0.0, |column| column.iter().map(|x| x * x).sum::<f64>().sqrt())
}

/// Other values of a parameter, within its bounds.
fn tried(parameter: &Parameter) -> Vec<f64> {
    let Parameter { start, lower, upper, scale } = *parameter;
    let steps = (-TRIED..=TRIED).filter(|step| *step != 0);
    let value = |step: i32| match scale {
        Scale::Logarithmic => start * FACTOR.powi(step),
        Scale::Linear => start + start.abs() * f64::from(step) / f64::from(TRIED),
    };
    steps.map(value).filter(|value| (lower..=upper).contains(value)).collect()
}
