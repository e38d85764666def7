//! Bounded least squares: closed forms, bounds, failures, uncertainty.

use std::convert::Infallible;
use std::sync::atomic::{AtomicUsize, Ordering};

use fastrand::Rng;
use stickslip::fit::{Difference, Ending, Fit, FitError, Options, Parameter, Scale, fit};

fn linear(start: f64, lower: f64, upper: f64) -> Parameter {
    Parameter { start, lower, upper, scale: Scale::Linear }
}

fn logarithmic(start: f64, lower: f64, upper: f64) -> Parameter {
    Parameter { start, lower, upper, scale: Scale::Logarithmic }
}

/// Rosenbrock's valley as residuals.
fn rosenbrock(p: &[f64], out: &mut [f64]) -> Result<(), Infallible> {
    out[0] = 1.0 - p[0];
    out[1] = 10.0 * (p[1] - p[0] * p[0]);
    Ok(())
}

/// Normal to a good approximation: twelve uniform numbers.
fn normal(numbers: &mut Rng) -> f64 {
    (0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0
}

#[test]
fn rosenbrock_minimum_is_found() {
    let parameters = [linear(-1.2, -5.0, 5.0), linear(1.0, -5.0, 5.0)];
    let options = Options { difference: Difference::Central, ..Options::default() };
    let fit = fit(rosenbrock, 2, &parameters, &options).unwrap();
    assert!(fit.parameters.iter().all(|p| (p - 1.0).abs() < 1e-5), "{fit:?}");
    assert_eq!(fit.ending, Ending::Converged);
    assert_eq!(fit.uncertainty.at_bound, [false, false]);
}

#[test]
fn active_bound_gives_the_constrained_minimum() {
    // With p0 ≤ 0.5 the minimum is (0.5, 0.25): the second residual vanishes, the first is 0.5.
    let parameters = [linear(-1.2, -5.0, 0.5), linear(1.0, -5.0, 5.0)];
    let fit = fit(rosenbrock, 2, &parameters, &Options::default()).unwrap();
    assert_eq!(fit.parameters[0], 0.5);
    assert!((fit.parameters[1] - 0.25).abs() < 1e-4, "{fit:?}");
    assert_eq!(fit.uncertainty.at_bound, [true, false]);
    assert!(fit.uncertainty.standard_error[0].is_none());
}

#[test]
fn parameters_never_leave_their_bounds_while_fitting() {
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), Infallible> {
        assert!((0.1..=0.7).contains(&p[0]) && (-0.2..=0.0).contains(&p[1]));
        rosenbrock(p, out)
    };
    let parameters = [logarithmic(0.1, 0.1, 0.7), linear(0.0, -0.2, 0.0)];
    for difference in [Difference::Forward, Difference::Central] {
        let options = Options { starts: 3, difference, ..Options::default() };
        let fit = fit(residual, 2, &parameters, &options).unwrap();
        assert_eq!(fit.parameters[1], 0.0, "the valley's floor lies above");
        assert!(fit.starts.iter().all(Option::is_some));
    }
}

/// y = a + b t with noise of size `sigma`; the closed form's estimates and standard errors beside.
fn line_fit(sigma: f64, numbers: &mut Rng) -> (Fit, [f64; 2], [f64; 2]) {
    let times: Vec<f64> = (0..12).map(|k| k as f64 / 4.0).collect();
    let measured: Vec<f64> = times.iter().map(|t| 2.0 - 0.7 * t + sigma * normal(numbers)).collect();
    let count = times.len() as f64;
    let (mean_t, mean_y) = (times.iter().sum::<f64>() / count, measured.iter().sum::<f64>() / count);
    let squares: f64 = times.iter().map(|t| (t - mean_t).powi(2)).sum();
    let slope = times.iter().zip(&measured).map(|(t, y)| (t - mean_t) * (y - mean_y)).sum::<f64>() / squares;
    let intercept = mean_y - slope * mean_t;
    let rest: f64 = times.iter().zip(&measured).map(|(t, y)| (y - intercept - slope * t).powi(2)).sum();
    let variance = rest / (count - 2.0);
    let errors = [(variance * (1.0 / count + mean_t * mean_t / squares)).sqrt(), (variance / squares).sqrt()];
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), Infallible> {
        for ((r, t), y) in out.iter_mut().zip(&times).zip(&measured) {
            *r = p[0] + p[1] * t - y;
        }
        Ok(())
    };
    let parameters = [linear(0.0, -10.0, 10.0), linear(0.0, f64::NEG_INFINITY, f64::INFINITY)];
    let fit = fit(residual, times.len(), &parameters, &Options::default()).unwrap();
    (fit, [intercept, slope], errors)
}

#[test]
fn straight_line_matches_its_closed_form() {
    let (fit, estimates, errors) = line_fit(0.1, &mut Rng::with_seed(7));
    for k in 0..2 {
        assert!((fit.parameters[k] - estimates[k]).abs() < 1e-7, "{} {}", fit.parameters[k], estimates[k]);
        let error = fit.uncertainty.standard_error[k].unwrap();
        assert!((error / errors[k] - 1.0).abs() < 1e-6, "{error} {}", errors[k]);
        let interval = fit.uncertainty.interval[k].unwrap();
        assert!(((interval.high - interval.low) / (2.0 * 2.228139 * error) - 1.0).abs() < 1e-6);
    }
    // ∂r/∂a = 1, ∂r/∂b = t.
    assert!((fit.jacobian[0][8] - 1.0).abs() < 1e-8 && (fit.jacobian[1][8] - 2.0).abs() < 1e-8);
}

#[test]
fn intervals_cover_the_truth_at_their_level() {
    let mut numbers = Rng::with_seed(3);
    let trials = 200;
    let mut inside = 0;
    for _ in 0..trials {
        let (fit, _, _) = line_fit(0.1, &mut numbers);
        let interval = fit.uncertainty.interval[1].unwrap();
        inside += usize::from(interval.low <= -0.7 && -0.7 <= interval.high);
    }
    // 95 % ± three standard deviations of the count.
    assert!((181..=199).contains(&inside), "{inside} of {trials}");
}

#[test]
fn failed_evaluations_are_rejected_steps() {
    // The way from 0.2 to the minimum at 3 is open, but beyond 3.2 nothing can be evaluated, and the
    // first full step of this strongly curved residual leads to 15.
    let failures = AtomicUsize::new(0);
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), &'static str> {
        if p[0] > 3.2 {
            failures.fetch_add(1, Ordering::Relaxed);
            return Err("diverged");
        }
        out[0] = p[0].exp() - 3.0_f64.exp();
        out[1] = 0.1 * (p[0] - 3.0);
        Ok(())
    };
    let fit = fit(residual, 2, &[linear(0.2, 0.01, 1000.0)], &Options::default()).unwrap();
    assert!((fit.parameters[0] - 3.0).abs() < 1e-6, "{fit:?}");
    assert!(fit.failures > 0, "the region was never entered");
    assert_eq!(fit.failures, failures.load(Ordering::Relaxed));
    // From inside the region there is no start, and the reason comes back.
    let error = stickslip::fit::fit(residual, 2, &[linear(5.0, 4.0, 6.0)], &Options::default()).unwrap_err();
    assert_eq!(error, FitError::NoStart { first: Some("diverged") });
    // A further start finds the way out.
    let options = Options { starts: 8, ..Options::default() };
    let fit = stickslip::fit::fit(residual, 2, &[linear(5.0, 0.5, 6.0)], &options).unwrap();
    assert!((fit.parameters[0] - 3.0).abs() < 1e-6 && fit.starts[0].is_none());
}

#[test]
fn undetermined_parameters_have_no_interval() {
    // Only the product of the first two shows.
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), Infallible> {
        for (k, r) in out.iter_mut().enumerate() {
            *r = p[0] * p[1] * k as f64 + p[2] - (6.0 * k as f64 + 1.0) + 0.01 * (k % 2) as f64;
        }
        Ok(())
    };
    let positive = logarithmic(1.0, 0.1, 100.0);
    let fit = fit(residual, 6, &[positive, positive, linear(0.0, -5.0, 5.0)], &Options::default()).unwrap();
    assert!((fit.parameters[0] * fit.parameters[1] - 6.0).abs() < 0.02);
    assert_eq!(fit.uncertainty.standard_error[0], None);
    assert_eq!(fit.uncertainty.standard_error[1], None);
    assert!(fit.uncertainty.standard_error[2].is_some());
}

#[test]
fn several_starts_find_the_deeper_of_two_valleys() {
    // (p² − 1)² tilted: a local minimum near +1, the global one near −1.
    let residual = |p: &[f64], out: &mut [f64]| -> Result<(), Infallible> {
        out[0] = p[0] * p[0] - 1.0;
        out[1] = 0.4 * (p[0] + 1.5);
        Ok(())
    };
    let parameter = [linear(1.5, -2.0, 2.0)];
    let single = fit(residual, 2, &parameter, &Options::default()).unwrap();
    assert!(single.parameters[0] > 0.0);
    let options = Options { starts: 4, ..Options::default() };
    let several = fit(residual, 2, &parameter, &options).unwrap();
    assert!(several.parameters[0] < 0.0 && several.best_start > 0);
    assert_eq!(several.starts.len(), 4);
    // Same numbers in every run, whatever the threads do.
    assert_eq!(several, fit(residual, 2, &parameter, &options).unwrap());
}

#[test]
fn held_parameters_stay() {
    let parameters = [linear(-1.2, -5.0, 5.0), linear(0.49, 0.49, 0.49)];
    let fit = fit(rosenbrock, 2, &parameters, &Options::default()).unwrap();
    assert_eq!(fit.parameters[1], 0.49);
    // d/dp of (1 − p)² + 100 (0.49 − p²)² has its root at −0.6929 on this side of zero.
    let p = fit.parameters[0];
    assert!((-2.0 * (1.0 - p) - 400.0 * p * (0.49 - p * p)).abs() < 1e-2, "{p}");
}

#[test]
fn progress_is_reported_and_interrupt_obeyed() {
    let told = AtomicUsize::new(0);
    let progress = |_: &stickslip::fit::Progress| {
        told.fetch_add(1, Ordering::Relaxed);
    };
    let interrupt = || told.load(Ordering::Relaxed) >= 3;
    let parameters = [linear(-1.2, -5.0, 5.0), linear(1.0, -5.0, 5.0)];
    let options =
        Options { starts: 5, progress: Some(&progress), interrupt: Some(&interrupt), ..Options::default() };
    let cut = fit(rosenbrock, 2, &parameters, &options).unwrap();
    assert_eq!(cut.ending, Ending::Interrupted);
    let mut there = [0.0; 2];
    rosenbrock(&cut.parameters, &mut there).unwrap();
    assert_eq!(cut.residuals, there, "residuals of the parameters returned");
    assert_eq!(told.load(Ordering::Relaxed), 3);
    let at_once = || true;
    let options = Options { interrupt: Some(&at_once), ..Options::default() };
    assert_eq!(fit(rosenbrock, 2, &parameters, &options).unwrap_err(), FitError::Interrupted);
}

#[test]
fn nonsense_is_refused() {
    let options = Options::default();
    let refuse = |p: Parameter| fit(rosenbrock, 2, &[p, linear(0.0, -1.0, 1.0)], &options).unwrap_err();
    assert!(matches!(refuse(linear(0.0, 1.0, -1.0)), FitError::InvalidParameter { index: 0, .. }));
    assert!(matches!(refuse(linear(f64::NAN, -1.0, 1.0)), FitError::InvalidParameter { index: 0, .. }));
    assert!(matches!(refuse(logarithmic(1.0, 0.0, 1.0)), FitError::InvalidParameter { index: 0, .. }));
    assert!(matches!(fit(rosenbrock, 2, &[], &options), Err(FitError::InvalidInput(_))));
    assert!(matches!(fit(rosenbrock, 0, &[linear(0.0, 0.0, 1.0)], &options), Err(FitError::InvalidInput(_))));
}
