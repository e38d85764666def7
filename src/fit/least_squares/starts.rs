//! A fit from one or several starts.

use super::coordinate::Coordinate;
use super::levenberg_marquardt::{Limits, minimise};
use super::options::{Options, Parameter};
use super::outcome::{Ending, Fit, FitError};
use super::problem::{Residual, Run, half_square};
use super::uncertainty::Uncertainty;

/// Fits `parameters` so that the `count` numbers `residual` writes become small in the sum of squares.
/// `residual` gets the parameters in the caller's units and order, always within the bounds; an error,
/// or values that are not finite, make the step be rejected. It is called from several threads.
///
/// Give residuals one size, best by dividing by the noise's standard deviation.
///
/// ```
/// use stickslip::fit::{Options, Parameter, Scale, fit};
/// // Decay of a free vibration: amplitude and rate.
/// let times = [0.0, 1.0, 2.0, 3.0];
/// let measured = [2.0, 1.213061, 0.735759, 0.446260];
/// let residual = |p: &[f64], out: &mut [f64]| -> Result<(), std::convert::Infallible> {
///     for ((r, t), m) in out.iter_mut().zip(times).zip(measured) {
///         *r = p[0] * (-p[1] * t).exp() - m;
///     }
///     Ok(())
/// };
/// let positive = Parameter { start: 1.0, lower: 1e-3, upper: 1e3, scale: Scale::Logarithmic };
/// let fit = fit(residual, 4, &[positive, positive], &Options::default())?;
/// assert!((fit.parameters[0] - 2.0).abs() < 1e-5 && (fit.parameters[1] - 0.5).abs() < 1e-5);
/// # Ok::<(), stickslip::fit::FitError<std::convert::Infallible>>(())
/// ```
///
/// # Errors
/// [`FitError::InvalidInput`] and [`FitError::InvalidParameter`] for arguments that make no sense,
/// [`FitError::NoStart`] when the residual fails at every start.
pub fn fit<R, E>(
    residual: R,
    count: usize,
    parameters: &[Parameter],
    options: &Options,
) -> Result<Fit, FitError<E>>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    check(count, parameters, options)?;
    let coordinate = |(index, parameter)| {
        Coordinate::new(parameter).map_err(|what| FitError::InvalidParameter { index, what })
    };
    let coordinates: Vec<Coordinate> =
        parameters.iter().enumerate().map(coordinate).collect::<Result<_, _>>()?;
    let problem = Residual::new(&residual, count, &coordinates, options);
    let mut ends: Vec<Option<f64>> = Vec::with_capacity(options.starts);
    let mut best: Option<Minimum> = None;
    for start in 0..options.starts {
        let found = minimum(&problem, start);
        let interrupted =
            found.as_ref().is_none_or(|found| found.ending == Ending::Interrupted) && problem.interrupted();
        ends.push(found.as_ref().map(|found| (2.0 * found.cost / count as f64).sqrt()));
        if let Some(found) = found
            && best.as_ref().is_none_or(|best| found.cost < best.cost)
        {
            best = Some(found);
        }
        if interrupted {
            if let Some(best) = &mut best {
                best.ending = Ending::Interrupted;
            }
            break;
        }
    }
    match best {
        Some(best) => Ok(finish(&problem, best, ends)),
        None if problem.interrupted() => Err(FitError::Interrupted),
        None => Err(FitError::NoStart { first: problem.take_first_error() }),
    }
}

fn check<E>(count: usize, parameters: &[Parameter], options: &Options) -> Result<(), FitError<E>> {
    if count == 0 || parameters.is_empty() || options.starts == 0 {
        return Err(FitError::InvalidInput("a fit needs residuals, parameters and a start"));
    }
    let positive = [options.tolerance, options.difference_step, options.confidence];
    if positive.iter().any(|x| !(*x > 0.0 && x.is_finite())) || options.confidence >= 1.0 {
        return Err(FitError::InvalidInput("tolerance, difference step or confidence out of range"));
    }
    Ok(())
}

/// Start 0 is the caller's; the others follow the additive recurrence of the generalised golden ratio
/// (Roberts 2018), which spreads any number of points evenly.
fn start_point(coordinates: &[Coordinate], start: usize) -> Vec<f64> {
    if start == 0 {
        return vec![0.0; coordinates.len()];
    }
    let dimensions = coordinates.len() as f64;
    let mut ratio: f64 = 1.5;
    for _ in 0..60 {
        ratio = (1.0 + ratio).powf(1.0 / (dimensions + 1.0));
    }
    let along = |j: usize| (0.5 + start as f64 / ratio.powi(j as i32 + 1)).fract();
    coordinates.iter().enumerate().map(|(j, c)| if c.held() { 0.0 } else { c.spread(along(j)) }).collect()
}

/// The end of one start.
struct Minimum {
    start: usize,
    y: Vec<f64>,
    residuals: Vec<f64>,
    /// ½ Σ r².
    cost: f64,
    /// Columns of the Jacobian there, where it was not interrupted.
    columns: Option<Vec<Vec<f64>>>,
    ending: Ending,
}

/// The minimum that `start` leads to; `None` if that point cannot be evaluated.
fn minimum<R, E>(problem: &Residual<R, E>, start: usize) -> Option<Minimum>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    let Options { max_iterations: iterations, tolerance, .. } = *problem.options;
    let (lower, upper): (Vec<f64>, Vec<f64>) = problem.coordinates.iter().map(|c| (c.lower, c.upper)).unzip();
    let limits = Limits { iterations, tolerance, change: tolerance.sqrt(), ..Limits::default() };
    let mut run = Run::new(problem, start);
    let end = minimise(&mut run, start_point(problem.coordinates, start), &lower, &upper, limits)?;
    // Interrupted or not, the residuals returned belong to the parameters returned.
    let (residuals, columns) = run.end(&end.y);
    let ending = if columns.is_some() { end.ending } else { None };
    Some(Minimum {
        start,
        cost: half_square(&residuals),
        y: end.y,
        residuals,
        columns,
        ending: ending.unwrap_or(Ending::Interrupted),
    })
}

/// Judges the uncertainty of the best minimum.
fn finish<R, E>(problem: &Residual<R, E>, best: Minimum, starts: Vec<Option<f64>>) -> Fit
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    let Minimum { start: best_start, y, residuals, cost, columns, ending } = best;
    let at = |y: f64, c: &Coordinate| !c.held() && (y <= c.lower || y >= c.upper);
    let at_bound = y.iter().zip(problem.coordinates).map(|(y, c)| at(*y, c)).collect();
    let confidence = problem.options.confidence;
    let uncertainty = match &columns {
        Some(columns) => Uncertainty::new(problem.coordinates, &y, at_bound, columns, &residuals, confidence),
        None => Uncertainty::unknown(y.len()),
    };
    let mut jacobian = columns.unwrap_or_default();
    for (column, (coordinate, y)) in jacobian.iter_mut().zip(problem.coordinates.iter().zip(&y)) {
        let slope = coordinate.slope(*y);
        column.iter_mut().for_each(|value| *value /= slope);
    }
    Fit {
        parameters: problem.values(&y),
        root_mean_square: (2.0 * cost / problem.count as f64).sqrt(),
        residuals,
        jacobian,
        uncertainty,
        starts,
        best_start,
        evaluations: problem.evaluations(),
        failures: problem.failures(),
        ending,
    }
}
