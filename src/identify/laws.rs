//! Contact laws fitted to the identified force at some levels, and predicted at the others.

use nalgebra::{DMatrix, DVector};

use super::weights::{ROUGHLY, closeness, difference, factor};
use super::{ContactPeriod, IdentificationError, WIDE};
use crate::contact::LawKind;
use crate::fit::{Difference, Fit, InterruptHook, Options, Parameter, Scale, fit};
use crate::harmonic::{ContactMapping, HarmonicSet, Method};
use crate::model::{Contact, Law, Model, ModelParameter, Structure};

/// Starts of a fit, and its difference step: well above the error of a period's balance.
const STARTS: usize = 8;
/// Fits, each with the covariance of the law before.
const ROUNDS: usize = 3;
const STEP: f64 = 1e-4;

/// A law with the parameters that describe the identified contact best.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedLaw {
    /// A model of the contact alone.
    pub model: Model,
    /// Its parameters.
    pub parameters: Vec<IdentifiedParameter>,
    /// Root mean square of force less identified force over that of the identified force, means left out, of every period;
    /// `None` where the law has no periodic state.
    pub errors: Vec<Option<f64>>,
}

/// A parameter with its 95 % interval.
#[derive(Debug, Clone, PartialEq)]
pub struct IdentifiedParameter {
    /// Name as in a model file.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// The most likely value.
    pub value: f64,
    /// Ends of the interval; NaN where the data do not tell them. That of a value at a bound begins there.
    pub interval: [f64; 2],
}

/// Fits `kind` under the constant `normal_load` (N) to those of `periods` whose places are in `fitted`; `interrupt` may end it
/// early.
///
/// Force and displacement are both identified, their errors depend on each other, and a stiff contact makes a large force of
/// a small error of the displacement: what counts is the covariance of their difference under the law, known once a law is.
///
/// # Errors
/// No period to fit, a law that reproduces none of them, an interrupt before the first point.
pub fn fit_law(
    kind: &'static LawKind,
    normal_load: f64,
    periods: &[ContactPeriod],
    fitted: &[usize],
    interrupt: Option<InterruptHook>,
) -> Result<IdentifiedLaw, IdentificationError> {
    let seen: Vec<&ContactPeriod> = fitted.iter().filter_map(|place| periods.get(*place)).collect();
    let mut model = first_guess(kind, normal_load, &seen)?;
    let free: Vec<_> = model.parameters().into_iter().filter(|parameter| parameter.free).collect();
    let count: usize = seen.iter().map(|period| period.force.len()).sum();
    let mut found = None;
    for round in 0..ROUNDS {
        let expected = match round {
            0 => seen.iter().map(|period| period.covariance.clone()).collect(),
            _ => seen.iter().map(|period| difference(&model, period)).collect::<Result<Vec<_>, _>>()?,
        };
        let close = match round {
            0 => ROUGHLY,
            _ => closeness(&left(&model, &seen)?, &seen, &expected, count.saturating_sub(free.len())),
        };
        let factors =
            seen.iter().zip(expected).map(|(period, expected)| factor(kind, period, expected, close));
        let factors = factors.collect::<Result<Vec<_>, IdentificationError>>()?;
        let residual = |values: &[f64], out: &mut [f64]| -> Result<(), IdentificationError> {
            let tried = with(kind, &model, &free, values)?;
            let mut rest = out;
            for (period, factor) in seen.iter().zip(&factors) {
                let force = force_under(&tried, period)?;
                let off = DVector::from_fn(force.len(), |k, _| force[k] - period.force[k]);
                let (here, after) = rest.split_at_mut(force.len());
                let white = factor.solve_lower_triangular(&off);
                here.copy_from_slice(white.ok_or_else(|| unfit(kind, "a singular covariance"))?.as_slice());
                rest = after;
            }
            Ok(())
        };
        let start = |p: &ModelParameter| {
            let start = model.get(&p.path).unwrap_or(p.value);
            Parameter { start, lower: p.lower, upper: p.upper, scale: p.scale }
        };
        let options = Options {
            starts: if round == 0 { STARTS } else { 1 },
            difference: Difference::Central,
            difference_step: STEP,
            interrupt,
            ..Options::default()
        };
        let parameters: Vec<Parameter> = free.iter().map(start).collect();
        let fitted =
            fit(residual, count, &parameters, &options).map_err(|error| unfit(kind, &error.to_string()))?;
        model = with(kind, &model, &free, &fitted.parameters)?;
        found = Some(fitted);
    }
    let found = found.ok_or_else(|| unfit(kind, "no round"))?;
    let parameters = free.iter().enumerate().map(|(k, p)| told(p, k, &found)).collect();
    let errors = periods.iter().map(|period| error_of(&model, period)).collect();
    Ok(IdentifiedLaw { model, parameters, errors })
}

/// `model` with other values of its `free` parameters.
fn with(
    kind: &LawKind,
    model: &Model,
    free: &[ModelParameter],
    values: &[f64],
) -> Result<Model, IdentificationError> {
    let mut new = model.clone();
    let pairs: Vec<(&str, f64)> = free.iter().map(|p| p.path.as_str()).zip(values.iter().copied()).collect();
    new.set_all(&pairs).map_err(|error| unfit(kind, &error.to_string()))?;
    Ok(new)
}

/// A fitted parameter. Its interval counts on the errors that the identification tells where the residuals are smaller.
fn told(parameter: &ModelParameter, k: usize, found: &Fit) -> IdentifiedParameter {
    let value = found.parameters[k];
    let squares: f64 = found.residuals.iter().map(|r| r * r).sum();
    let freedom = found.residuals.len().saturating_sub(found.parameters.len()).max(1) as f64;
    let wider = (squares / freedom).sqrt().min(1.0).recip();
    let widened = |end: f64| match parameter.scale {
        Scale::Logarithmic => value * (end / value).powf(wider),
        Scale::Linear => value + wider * (end - value),
    };
    let bounded = |end: f64| widened(end).clamp(parameter.lower, parameter.upper);
    let interval = match found.uncertainty.interval.get(k) {
        Some(Some(interval)) => [bounded(interval.low), bounded(interval.high)],
        _ if found.uncertainty.at_bound.get(k) == Some(&true) => {
            let reach = into_the_range(found, k, (squares / freedom).sqrt().max(1.0));
            let end = if value <= parameter.lower { value + reach } else { value - reach };
            [value.min(end).max(parameter.lower), value.max(end).min(parameter.upper)]
        }
        _ => [f64::NAN; 2],
    };
    IdentifiedParameter { name: parameter.quantity.name, unit: parameter.quantity.unit, value, interval }
}

/// How far parameter `k`, which ended at a bound, may lie inside: there the squares, all others refitted, exceed those at the
/// bound by as much as at the ends of a 95 % interval; NaN where they do not tell. `deviation` is that of a residual.
fn into_the_range(found: &Fit, k: usize, deviation: f64) -> f64 {
    let count = found.parameters.len();
    if found.jacobian.is_empty() {
        return f64::NAN;
    }
    let jacobian = DMatrix::from_fn(found.residuals.len(), count, |i, j| found.jacobian[j][i]);
    let bound = |j: usize| found.uncertainty.at_bound[j];
    let free: Vec<usize> = (0..count).filter(|j| !bound(*j)).collect();
    let others = jacobian.select_columns(&free);
    let own = jacobian.column(k).into_owned();
    let Ok(shared) = others.clone().svd(true, true).solve(&own, f64::EPSILON) else { return f64::NAN };
    let alone = own - others * shared;
    let curvature = alone.norm_squared();
    let residuals = DVector::from_column_slice(&found.residuals);
    // The unbounded optimum lies outside, this far.
    let outside = (alone.dot(&residuals) / curvature).abs();
    let wide = WIDE * deviation / curvature.sqrt();
    outside.hypot(wide) - outside
}

/// Coefficients of the force (N) of a contact that moves as in `period`, as many as were identified.
///
/// # Errors
/// A model that is no contact, a law without a periodic state there.
pub fn force_under(model: &Model, period: &ContactPeriod) -> Result<Vec<f64>, IdentificationError> {
    Ok(mapped(model, period)?.force()[..period.force.len()].to_vec())
}

/// What `model` leaves of the force of each of `periods` (N).
fn left(model: &Model, periods: &[&ContactPeriod]) -> Result<Vec<DVector<f64>>, IdentificationError> {
    let of = |period: &&ContactPeriod| {
        let force = force_under(model, period)?;
        Ok(DVector::from_fn(force.len(), |k, _| force[k] - period.force[k]))
    };
    periods.iter().map(of).collect()
}

/// The contact of `model` under the motion of `period`.
pub(super) fn mapped(model: &Model, period: &ContactPeriod) -> Result<ContactMapping, IdentificationError> {
    let contact =
        model.contact.ok_or_else(|| IdentificationError::Failed("the model has no contact".to_owned()))?;
    let law = model.law().map_err(|error| IdentificationError::Failed(error.to_string()))?;
    let law = law.ok_or_else(|| IdentificationError::Failed("the model has no contact".to_owned()))?;
    let set = HarmonicSet::full(period.displacement.len() / 2);
    let mut map = ContactMapping::new(set, Method::Exact);
    map.evaluate(law.as_ref(), contact.normal_load, 0.0, period.angular_frequency, &period.displacement)
        .map_err(|error| IdentificationError::Failed(error.to_string()))?;
    Ok(map)
}

pub(super) fn error_of(model: &Model, period: &ContactPeriod) -> Option<f64> {
    let force = force_under(model, period).ok()?;
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let off = squares(&mut force.iter().zip(&period.force).skip(1).map(|(a, b)| a - b));
    Some((off / squares(&mut period.force.iter().skip(1).copied())).sqrt())
}

/// A law as stiff as the stiffest of the periods, with a limit a little above the largest force.
fn first_guess(
    kind: &'static LawKind,
    normal_load: f64,
    periods: &[&ContactPeriod],
) -> Result<Model, IdentificationError> {
    let size = |coefficients: &[f64]| coefficients[1].hypot(coefficients[2]);
    let slopes = periods.iter().map(|period| size(&period.force) / size(&period.displacement));
    let stiffness = slopes.fold(0.0, f64::max);
    let largest = periods.iter().map(|period| size(&period.force)).fold(0.0, f64::max);
    if !(stiffness > 0.0 && largest > 0.0 && normal_load > 0.0) {
        return Err(unfit(kind, "no force, no motion or no normal load"));
    }
    let own: Vec<f64> =
        kind.parameters.iter().map(|one| one.default.unwrap_or_else(|| middle(one, stiffness))).collect();
    let law =
        Law::new(kind, &own).ok_or_else(|| unfit(kind, "its parameters are not those of the catalogue"))?;
    let contact = Contact {
        law,
        tangential_stiffness: 1.5 * stiffness,
        friction_coefficient: 1.1 * largest / normal_load,
        normal_load,
        normal_stiffness: 0.0,
        normal: None,
    };
    Ok(Model { structure: Structure::Prescribed, contact: Some(contact), effects: Vec::new(), free: None })
}

fn middle(parameter: &crate::contact::LawParameter, stiffness: f64) -> f64 {
    let (lower, upper, scale) = (parameter.range)(stiffness);
    match scale {
        Scale::Logarithmic => (lower * upper).sqrt(),
        Scale::Linear => 0.5 * (lower + upper),
    }
}

pub(super) fn unfit(kind: &LawKind, why: &str) -> IdentificationError {
    IdentificationError::Failed(format!("the law `{}` was not fitted: {why}", kind.name))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points that fall, and a line that may not: beside the bound the squares rise by those of an interval where it ends.
    #[test]
    fn an_interval_at_a_bound_ends_where_the_squares_have_risen() {
        let points: Vec<[f64; 2]> =
            (0..50).map(f64::from).map(|i| [0.1 * i, 3.0 - 0.02 * i + (7.0 * i).sin()]).collect();
        let residual = |p: &[f64], out: &mut [f64]| -> Result<(), IdentificationError> {
            out.iter_mut().zip(&points).for_each(|(r, [x, y])| *r = p[0] + p[1] * x - y);
            Ok(())
        };
        let range = |lower: f64| Parameter { start: 0.5, lower, upper: 10.0, scale: Scale::Linear };
        let found = fit(residual, 50, &[range(-10.0), range(0.0)], &Options::default()).unwrap();
        assert!(found.uncertainty.at_bound[1] && found.parameters[1] == 0.0);
        let end = into_the_range(&found, 1, 0.7);
        let squares = |slope: f64| {
            let level = points.iter().map(|[x, y]| y - slope * x).sum::<f64>() / 50.0;
            points.iter().map(|[x, y]| (level + slope * x - y).powi(2)).sum::<f64>()
        };
        let rise = squares(end) - squares(0.0);
        assert!((rise / (1.96 * 0.7_f64).powi(2) - 1.0).abs() < 1e-6, "{rise}");
    }
}
