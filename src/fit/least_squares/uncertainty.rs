//! Standard errors and intervals of fitted parameters.

use nalgebra::DMatrix;

use super::coordinate::Coordinate;
use crate::numeric::student::student_quantile;

/// Directions of the scaled Jacobian whose singular value falls below this fraction of the largest are
/// not determined by the data.
const UNDETERMINED: f64 = 1e-7;

/// An interval of one parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Interval {
    /// Lower end, never below the bound.
    pub low: f64,
    /// Upper end, never above the bound.
    pub high: f64,
}

/// Standard errors and intervals, one entry per parameter.
///
/// The covariance is `s² (JᵀJ)⁻¹` with `s² = Σ r²/(m − p)`: it takes the residuals for independent
/// and of one size, and the model for linear within the interval. Coloured residuals make true
/// intervals wider. Parameters at a bound are held, and the others' intervals are those given that.
/// Intervals use Student's t with m − p degrees of freedom, in the parameter's scale (for a
/// logarithmic parameter a factor, hence asymmetric).
#[derive(Debug, Clone, PartialEq)]
pub struct Uncertainty {
    /// Standard error in the parameter's unit; `None` for one that is held, at a bound, or not
    /// determined by the data.
    pub standard_error: Vec<Option<f64>>,
    /// Interval; `None` like the standard error. An undetermined parameter must never be printed as a
    /// bare number.
    pub interval: Vec<Option<Interval>>,
    /// Correlation of the estimates, row-major `p × p`; zero where there is no standard error.
    pub correlation: Vec<f64>,
    /// Whether the parameter ended at one of its bounds.
    pub at_bound: Vec<bool>,
}

impl Uncertainty {
    /// Nothing known.
    pub(super) fn unknown(parameters: usize) -> Self {
        Self {
            standard_error: vec![None; parameters],
            interval: vec![None; parameters],
            correlation: vec![0.0; parameters * parameters],
            at_bound: vec![false; parameters],
        }
    }

    /// From the residuals and the Jacobian's `columns` in coordinates `y`.
    pub(super) fn new(
        coordinates: &[Coordinate],
        y: &[f64],
        at_bound: Vec<bool>,
        columns: &[Vec<f64>],
        residuals: &[f64],
        confidence: f64,
    ) -> Self {
        let mut result = Self { at_bound, ..Self::unknown(y.len()) };
        let free: Vec<usize> = (0..y.len())
            .filter(|j| !coordinates[*j].held() && !result.at_bound[*j])
            .filter(|j| columns[*j].iter().all(|x| x.is_finite()) && columns[*j].iter().any(|x| *x != 0.0))
            .collect();
        if free.is_empty() || residuals.len() <= free.len() {
            return result;
        }
        let freedom = residuals.len() - free.len();
        let variance = residuals.iter().map(|r| r * r).sum::<f64>() / freedom as f64;
        // Columns scaled to length one: what is undetermined must not depend on units.
        let lengths: Vec<f64> =
            free.iter().map(|j| columns[*j].iter().map(|x| x * x).sum::<f64>().sqrt()).collect();
        let decomposition =
            triangle(residuals.len(), free.len(), |i, k| columns[free[k]][i] / lengths[k]).svd(false, true);
        let Some(directions) = decomposition.v_t else { return result };
        let singular = &decomposition.singular_values;
        let floor = UNDETERMINED * singular.max();
        let determined: Vec<bool> = (0..free.len())
            .map(|k| (0..singular.len()).all(|d| singular[d] > floor || directions[(d, k)].abs() < 1e-3))
            .collect();
        let covariance = |a: usize, b: usize| -> f64 {
            let kept = (0..singular.len()).filter(|d| singular[*d] > floor);
            variance
                * kept.map(|d| directions[(d, a)] * directions[(d, b)] / singular[d].powi(2)).sum::<f64>()
                / (lengths[a] * lengths[b])
        };
        let quantile = student_quantile(0.5 + 0.5 * confidence, freedom);
        for (a, &i) in free.iter().enumerate().filter(|(a, _)| determined[*a]) {
            let deviation = covariance(a, a).sqrt();
            let coordinate = coordinates[i];
            result.standard_error[i] = Some(deviation * coordinate.slope(y[i]));
            let reach = quantile * deviation;
            result.interval[i] =
                Some(Interval { low: coordinate.value(y[i] - reach), high: coordinate.value(y[i] + reach) });
            for (b, &j) in free.iter().enumerate().filter(|(b, _)| determined[*b]) {
                let product = deviation * covariance(b, b).sqrt();
                result.correlation[i * y.len() + j] =
                    if product > 0.0 { covariance(a, b) / product } else { 0.0 };
            }
        }
        result
    }
}

/// Rows taken up at a time.
const BLOCK: usize = 1024;

/// The triangle `R` of `A = Q R`, with the singular values and directions of the `rows × columns` matrix of `entry`, which
/// is never held whole.
fn triangle(rows: usize, columns: usize, entry: impl Fn(usize, usize) -> f64) -> DMatrix<f64> {
    let mut above = DMatrix::zeros(0, columns);
    for first in (0..rows).step_by(BLOCK) {
        let held = above.nrows();
        let stacked = DMatrix::from_fn(held + BLOCK.min(rows - first), columns, |i, k| {
            if i < held { above[(i, k)] } else { entry(first + i - held, k) }
        });
        above = stacked.qr().r();
    }
    above
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tall_matrix_has_the_singular_values_of_its_triangle() {
        let entry = |i: usize, k: usize| ((i * (k + 2)) as f64 * 0.37).sin() + 0.2 * k as f64;
        for rows in [3, 1024, 1025, 5000] {
            let whole = DMatrix::from_fn(rows, 3, entry).singular_values();
            let found = triangle(rows, 3, entry).singular_values();
            assert!((&found - &whole).norm() < 1e-12 * whole.norm(), "{rows}: {found} for {whole}");
        }
    }
}
