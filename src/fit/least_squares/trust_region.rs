//! The adapter to the optimisation crate, and the only file that knows it.

use basin::{
    BoxBounds, ConstraintDescription, ConstraintSet, Constraints, CostFunction, DenseMatrix, Executor,
    Jacobian, Residual, StepOutcome, Termination, TrustRegionReflective,
};

use super::coordinate::Coordinate;
use super::options::{Options, Parameter, Progress};
use super::outcome::{Ending, Fit, FitError};
use super::problem::{Scaled, Stop};
use super::uncertainty::Uncertainty;

/// Share of a coordinate's unit within which a parameter counts as being at its bound: the method
/// keeps strictly inside and only approaches it.
const AT_BOUND: f64 = 1e-4;

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
    let coordinates: Vec<Coordinate> =
        parameters.iter().enumerate().map(|(i, p)| Coordinate::new(i, p)).collect::<Result<_, _>>()?;
    let problem = Scaled::new(&residual, count, &coordinates, options);
    let mut ends: Vec<Option<f64>> = Vec::with_capacity(options.starts);
    let mut best: Option<(usize, Run)> = None;
    for start in 0..options.starts {
        let run = run_from(&problem, start_point(&coordinates, start), start, options);
        let interrupted = run.as_ref().is_none_or(|run| run.ending == Ending::Interrupted)
            && options.interrupt.is_some_and(|interrupt| interrupt());
        ends.push(run.as_ref().map(|run| run.root_mean_square(count)));
        if let Some(run) = run
            && best.as_ref().is_none_or(|(_, best)| run.cost < best.cost)
        {
            best = Some((start, run));
        }
        if interrupted {
            if let Some((_, best)) = &mut best {
                best.ending = Ending::Interrupted;
            }
            break;
        }
    }
    let Some((best_start, run)) = best else {
        let first = problem.take_first_error();
        let interrupted = options.interrupt.is_some_and(|interrupt| interrupt());
        return Err(if interrupted { FitError::Interrupted } else { FitError::NoStart { first } });
    };
    Ok(finish(&problem, run, best_start, ends, options))
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
    let share = |j: usize| (0.5 + start as f64 / ratio.powi(j as i32 + 1)).fract();
    coordinates.iter().enumerate().map(|(j, c)| if c.held() { 0.0 } else { c.spread(share(j)) }).collect()
}

/// The best point of one start.
struct Run {
    y: Vec<f64>,
    residuals: Vec<f64>,
    /// ½ Σ r².
    cost: f64,
    ending: Ending,
}

impl Run {
    fn root_mean_square(&self, count: usize) -> f64 {
        (2.0 * self.cost / count as f64).sqrt()
    }
}

fn half_square(residuals: &[f64]) -> f64 {
    0.5 * residuals.iter().map(|r| r * r).sum::<f64>()
}

/// Runs the solver from `y`; `None` if that point cannot be evaluated.
fn run_from<R, E>(problem: &Scaled<R, E>, y: Vec<f64>, start: usize, options: &Options) -> Option<Run>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    let residuals = problem.evaluate(&y).ok()?;
    let cost = half_square(&residuals);
    if !cost.is_finite() {
        return None;
    }
    let mut run = Run { y, residuals, cost, ending: Ending::Converged };
    if cost == 0.0 {
        return Some(run);
    }
    // The solver's gradient test is absolute: it sees residuals whose sum of squares starts at one.
    let adapter = Adapter::new(problem, 1.0 / (2.0 * cost).sqrt());
    let scale = adapter.scale * adapter.scale;
    let solver = TrustRegionReflective::new().with_absolute_scaled_gradient_tolerance(1e-12);
    let Ok(mut stepper) = Executor::from_start(adapter, solver, run.y.clone()).into_stepper() else {
        run.ending = Ending::Interrupted;
        return Some(run);
    };
    for iteration in 1..=options.max_iterations {
        let outcome = stepper.step();
        let Ok(outcome) = outcome else {
            run.ending = Ending::Interrupted;
            break;
        };
        let state = stepper.state();
        let (y, cost) = (basin::State::param(state), basin::State::cost(state) / scale);
        let change = (run.cost - cost) / run.cost;
        let step = distance(y, &run.y);
        if cost < run.cost {
            run.y.copy_from_slice(y);
            run.cost = cost;
        }
        if let Some(progress) = options.progress {
            progress(&Progress {
                start,
                starts: options.starts,
                iteration,
                root_mean_square: run.root_mean_square(problem.count),
                evaluations: problem.evaluations(),
            });
        }
        if let StepOutcome::Stopped(report) = outcome {
            run.ending = match report.termination {
                Termination::Converged(_) => Ending::Converged,
                _ => Ending::Stalled,
            };
            break;
        }
        // The first step starts from a point moved off the bounds, and may not compare.
        if iteration > 1 && change.abs() <= options.tolerance && step <= options.tolerance.sqrt() {
            run.ending = Ending::Converged;
            break;
        }
        run.ending = Ending::StepLimit;
    }
    // The solver keeps no residuals. Interrupted or not, those returned belong to the parameters returned.
    run.residuals = problem.evaluate_uninterrupted(&run.y);
    run.cost = half_square(&run.residuals);
    Some(run)
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Moves parameters that approached a bound onto it, and judges the uncertainty.
fn finish<R, E>(
    problem: &Scaled<R, E>,
    mut run: Run,
    best_start: usize,
    starts: Vec<Option<f64>>,
    options: &Options,
) -> Fit
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    let mut snapped = run.y.clone();
    let mut at_bound = vec![false; snapped.len()];
    for ((y, c), at) in snapped.iter_mut().zip(problem.coordinates).zip(&mut at_bound) {
        let bound = if *y - c.lower < c.upper - *y { c.lower } else { c.upper };
        if !c.held() && (*y - bound).abs() <= AT_BOUND {
            (*y, *at) = (bound, true);
        }
    }
    if snapped != run.y
        && let Ok(residuals) = problem.evaluate(&snapped)
    {
        let cost = half_square(&residuals);
        if cost <= run.cost * (1.0 + 1e-6) {
            run = Run { y: snapped, residuals, cost, ..run };
        } else {
            at_bound.fill(false);
        }
    }
    let (columns, uncertainty) = match problem.jacobian(&run.y) {
        Ok(columns) => {
            let uncertainty = Uncertainty::new(
                problem.coordinates,
                &run.y,
                at_bound,
                &columns,
                &run.residuals,
                options.confidence,
            );
            (columns, uncertainty)
        }
        Err(Stop) => {
            run.ending = Ending::Interrupted;
            (Vec::new(), Uncertainty::unknown(run.y.len()))
        }
    };
    let slopes: Vec<f64> = problem.coordinates.iter().zip(&run.y).map(|(c, y)| c.slope(*y)).collect();
    let rows = if columns.is_empty() { 0 } else { problem.count };
    let jacobian =
        (0..rows).flat_map(|i| columns.iter().zip(&slopes).map(move |(column, s)| column[i] / s)).collect();
    Fit {
        parameters: problem.values(&run.y),
        root_mean_square: run.root_mean_square(problem.count),
        residuals: run.residuals,
        jacobian,
        uncertainty,
        starts,
        best_start,
        evaluations: problem.evaluations(),
        failures: problem.failures(),
        ending: run.ending,
    }
}

/// The problem as the crate wants it.
struct Adapter<'a, 'b, R, E> {
    problem: &'a Scaled<'b, R, E>,
    scale: f64,
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl<'a, 'b, R, E> Adapter<'a, 'b, R, E> {
    fn new(problem: &'a Scaled<'b, R, E>, scale: f64) -> Self {
        let lower = problem.coordinates.iter().map(|c| c.lower).collect();
        let upper = problem.coordinates.iter().map(|c| c.upper.max(c.lower)).collect();
        Self { problem, scale, lower, upper }
    }
}

impl<R, E> Constraints for Adapter<'_, '_, R, E> {
    type Set = ConstraintSet<BoxBounds<Vec<f64>>>;

    fn constraints(&self) -> <Self::Set as ConstraintDescription>::Borrowed<'_> {
        ConstraintSet::new().with_bounds(BoxBounds::new(Some(&self.lower), Some(&self.upper)))
    }
}

impl<R, E> CostFunction for Adapter<'_, '_, R, E>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    type Param = Vec<f64>;
    type Output = f64;
    type Error = Stop;

    fn cost(&self, y: &Vec<f64>) -> Result<f64, Stop> {
        self.residual(y).map(|r| half_square(&r))
    }
}

impl<R, E> Residual for Adapter<'_, '_, R, E>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    type Param = Vec<f64>;
    type Output = Vec<f64>;
    type Error = Stop;

    fn residual(&self, y: &Vec<f64>) -> Result<Vec<f64>, Stop> {
        let mut residuals = self.problem.evaluate(y)?;
        residuals.iter_mut().for_each(|r| *r *= self.scale);
        Ok(residuals)
    }
}

impl<R, E> Jacobian for Adapter<'_, '_, R, E>
where
    R: Fn(&[f64], &mut [f64]) -> Result<(), E> + Sync,
    E: Send,
{
    type Jacobian = DenseMatrix<f64>;

    fn jacobian(&self, y: &Vec<f64>) -> Result<DenseMatrix<f64>, Stop> {
        let columns = self.problem.jacobian(y)?;
        Ok(DenseMatrix::from_fn(self.problem.count, y.len(), |i, j| self.scale * columns[j][i]))
    }
}
