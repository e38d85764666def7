//! The measured map as a law: a loading curve tabulated from identified loops.

use nalgebra::{DMatrix, DVector};

use super::laws::{error_of, force_under, unfit};
use super::weights::{ROUGHLY, closeness, difference, factor};
use super::{ContactPeriod, IdentificationError, IdentifiedLaw, IdentifiedParameter, WIDE};
use crate::contact::{MEASURED, Measured};
use crate::model::{Contact, Law, Model, ModelParameter, Structure};
use crate::numeric::fourier::value;
use crate::numeric::nonnegative::nonnegative;
use crate::vocabulary::Quantity;

/// Solutions, each with the covariance of the law before.
const ROUNDS: usize = 3;
/// Places of the knots that are tried, evenly over the way from one to the next.
const PLACES: u32 = 8;
/// Steps of a period in which the largest displacement is looked for.
const STEPS: usize = 512;
/// Difference step of the parameters, in parts of the stiffness.
const STEP: f64 = 1e-6;

/// Tabulates the loading curve of those of `periods` whose places are in `fitted`, under the constant `normal_load` (N): the
/// one that holds for their largest motion, and whose branches describe them best.
///
/// The force of a table is linear in the falls of its slope at the knots, none of which may be negative; so the best table is
/// found without a start.
///
/// # Errors
/// No period to fit, no motion or no force in any.
pub fn tabulate(
    normal_load: f64,
    periods: &[ContactPeriod],
    fitted: &[usize],
) -> Result<IdentifiedLaw, IdentificationError> {
    let seen: Vec<&ContactPeriod> = fitted.iter().filter_map(|place| periods.get(*place)).collect();
    let range = seen.iter().map(|period| half_range(period)).fold(0.0, f64::max);
    if !(range > 0.0 && normal_load > 0.0) {
        return Err(unfit(MEASURED, "no motion or no normal load"));
    }
    let (end, columns) = best_knots(&seen, range, normal_load)?;
    let mut covariances: Vec<DMatrix<f64>> = seen.iter().map(|period| period.covariance.clone()).collect();
    let (mut found, mut close) = (None, ROUGHLY);
    for _ in 0..ROUNDS {
        let table = Table::of(&seen, &columns, &covariances, close)?;
        let model = table.model(end, normal_load)?;
        covariances = seen
            .iter()
            .map(|period| difference(&model, period))
            .collect::<Result<_, IdentificationError>>()?;
        close = closeness(&table.left(&seen, &columns), &seen, &covariances, table.freedom);
        found = Some((table, model));
    }
    let (table, model) = found.ok_or_else(|| unfit(MEASURED, "no round"))?;
    let parameters = table.parameters(&model, end, normal_load);
    let errors = periods.iter().map(|period| error_of(&model, period)).collect();
    Ok(IdentifiedLaw { model, parameters, errors })
}

/// The end of a table (m) that is at the largest motion or up to a knot beyond it, and what sliders at its knots do: where a
/// contact yields at once, a knot must be near.
fn best_knots(
    seen: &[&ContactPeriod],
    range: f64,
    normal_load: f64,
) -> Result<(f64, Vec<DMatrix<f64>>), IdentificationError> {
    let covariances: Vec<DMatrix<f64>> = seen.iter().map(|period| period.covariance.clone()).collect();
    let mut best: Option<(f64, f64, Vec<DMatrix<f64>>)> = None;
    for place in 0..PLACES {
        let end = range * Measured::SPACING.powf(f64::from(place) / f64::from(PLACES));
        let columns = seen.iter().map(|period| branches(period, end, normal_load));
        let columns = columns.collect::<Result<Vec<_>, IdentificationError>>()?;
        let left = Table::of(seen, &columns, &covariances, ROUGHLY)?.misfit;
        if best.as_ref().is_none_or(|(least, _, _)| left < *least) {
            best = Some((left, end, columns));
        }
    }
    best.map(|(_, end, columns)| (end, columns)).ok_or_else(|| unfit(MEASURED, "no place for its knots"))
}

/// Half of what lies between the largest and the smallest displacement (m).
pub(super) fn half_range(period: &ContactPeriod) -> f64 {
    let at = |k: usize| value(&period.displacement, std::f64::consts::TAU * k as f64 / STEPS as f64);
    let (low, high) = (0..STEPS)
        .map(at)
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(u), high.max(u)));
    0.5 * (high - low)
}

/// Force coefficients, column by column, of sliders of unit stiffness that yield at the knots of `range`.
fn branches(
    period: &ContactPeriod,
    range: f64,
    normal_load: f64,
) -> Result<DMatrix<f64>, IdentificationError> {
    let jenkins = Law::named("jenkins", &[]).ok_or_else(|| unfit(MEASURED, "no slider"))?;
    let slider = |knot: f64| {
        let contact = Contact {
            law: jenkins,
            tangential_stiffness: 1.0,
            friction_coefficient: knot * range / normal_load,
            normal_load,
            normal_stiffness: 0.0,
            normal: None,
        };
        force_under(&of_contact(contact), period).map(DVector::from_vec)
    };
    let columns = Measured::knots().into_iter().map(slider).collect::<Result<Vec<_>, _>>()?;
    Ok(DMatrix::from_columns(&columns))
}

fn of_contact(contact: Contact) -> Model {
    Model { structure: Structure::Prescribed, contact: Some(contact), effects: Vec::new(), free: None }
}

/// Falls of the slope (N/m) at the knots, and the covariance of those above zero.
struct Table {
    falls: [f64; Measured::KNOTS],
    free: Vec<usize>,
    covariance: DMatrix<f64>,
    /// Mean square of what it leaves, over the errors.
    misfit: f64,
    /// Coefficients beyond those that the falls above zero take.
    freedom: usize,
}

impl Table {
    fn of(
        seen: &[&ContactPeriod],
        columns: &[DMatrix<f64>],
        covariances: &[DMatrix<f64>],
        close: f64,
    ) -> Result<Self, IdentificationError> {
        let singular = || unfit(MEASURED, "its force has no covariance");
        let rows = columns.iter().map(DMatrix::nrows).sum();
        let mut matrix = DMatrix::zeros(rows, Measured::KNOTS);
        let mut right = DVector::zeros(rows);
        let mut row = 0;
        for ((period, columns), covariance) in seen.iter().zip(columns).zip(covariances) {
            let factor = factor(MEASURED, period, covariance.clone(), close)?;
            let white = factor.solve_lower_triangular(columns).ok_or_else(singular)?;
            let force = DVector::from_column_slice(&period.force);
            let target = factor.solve_lower_triangular(&force).ok_or_else(singular)?;
            matrix.rows_mut(row, white.nrows()).copy_from(&white);
            right.rows_mut(row, target.len()).copy_from(&target);
            row += target.len();
        }
        let (falls, free) = nonnegative(&matrix, &right).ok_or_else(|| unfit(MEASURED, "no best table"))?;
        let inner = matrix.select_columns(&free);
        let freedom = rows.saturating_sub(free.len()).max(1);
        let misfit = (&matrix * &falls - right).norm_squared() / freedom as f64;
        let covariance = (inner.transpose() * &inner).cholesky().ok_or_else(singular)?.inverse();
        let falls = std::array::from_fn(|k| falls[k]);
        Ok(Self { falls, free, covariance: covariance * misfit.max(1.0), misfit, freedom })
    }

    /// What it leaves of the force of each period (N).
    fn left(&self, seen: &[&ContactPeriod], columns: &[DMatrix<f64>]) -> Vec<DVector<f64>> {
        let falls = DVector::from_column_slice(&self.falls);
        let of = |(period, columns): (&&ContactPeriod, &DMatrix<f64>)| {
            columns * &falls - DVector::from_column_slice(&period.force)
        };
        seen.iter().zip(columns).map(of).collect()
    }

    fn model(&self, range: f64, normal_load: f64) -> Result<Model, IdentificationError> {
        let values = Measured::values_of(&self.falls, range, normal_load);
        let values = values.ok_or_else(|| unfit(MEASURED, "no force resists the motion"))?;
        let law =
            Law::new(MEASURED, &values[2..]).ok_or_else(|| unfit(MEASURED, "a table of another length"))?;
        Ok(of_contact(Contact {
            law,
            tangential_stiffness: values[0],
            friction_coefficient: values[1],
            normal_load,
            normal_stiffness: 0.0,
            normal: None,
        }))
    }

    /// With intervals where the parameter depends on a fall above zero.
    fn parameters(&self, model: &Model, range: f64, normal_load: f64) -> Vec<IdentifiedParameter> {
        let step = STEP * self.falls.iter().sum::<f64>();
        let at = |k: usize, step: f64| {
            let mut falls = self.falls;
            falls[k] += step;
            Measured::values_of(&falls, range, normal_load)
        };
        // One-sided where a fall is smaller than the step.
        let slope = |k: &usize| -> Option<Vec<f64>> {
            let down = step.min(self.falls[*k]);
            let pairs = at(*k, step)?.into_iter().zip(at(*k, -down)?);
            Some(pairs.map(|(up, low)| (up - low) / (step + down)).collect())
        };
        let slopes: Vec<Option<Vec<f64>>> = self.free.iter().map(slope).collect();
        let told = |(place, parameter): (usize, ModelParameter)| {
            let by = |k: usize| slopes[k].as_ref().map_or(0.0, |slope| slope[place]);
            let slopes = DVector::from_fn(self.free.len(), |k, _| by(k));
            let wide = WIDE * (slopes.transpose() * &self.covariance * &slopes)[(0, 0)].sqrt();
            let ends = [parameter.value - wide, parameter.value + wide];
            let interval = match wide > 0.0 {
                true => ends.map(|end| end.clamp(parameter.lower, parameter.upper)),
                false => [f64::NAN; 2],
            };
            let Quantity { name, unit, .. } = *parameter.quantity;
            IdentifiedParameter { name, unit, value: parameter.value, interval }
        };
        model.parameters().into_iter().filter(|parameter| parameter.free).enumerate().map(told).collect()
    }
}
