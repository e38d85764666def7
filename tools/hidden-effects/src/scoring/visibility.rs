//! How much of a hidden effect a fit of the base model cannot absorb: what is there to be found.

use nalgebra::{DMatrix, DVector};

use crate::records::record::{Record, root_mean_square};
use crate::rigs::rig::Rig;

/// Change of the responses by what is hidden, over their root mean square, as the mean square over records
/// and channels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Visibility {
    /// With the base parameters as they are.
    pub change: f64,
    /// After a refit of the base model's parameters.
    pub left: f64,
}

/// Steps of the refit, in parameters' logarithms.
const ROUNDS: usize = 6;

/// Measures it by the generator's own simulation, without noise.
///
/// # Errors
/// A refit whose equations are singular.
pub fn visibility(rig: &dyn Rig) -> Result<Visibility, String> {
    let seen = rig.respond();
    let plain = rig.plain();
    let start: Vec<f64> = plain.base().iter().map(|value| value.ln()).collect();
    let residual = |logarithms: &[f64]| {
        let base: Vec<f64> = logarithms.iter().map(|value| value.exp()).collect();
        compare(&seen, &plain.with_base(&base).respond())
    };
    let mut here = start;
    let mut rest = residual(&here);
    let change = size(&rest);
    let mut damping = 1e-3;
    for _ in 0..ROUNDS {
        let columns: Vec<DVector<f64>> = (0..here.len())
            .map(|index| {
                let mut moved = here.clone();
                moved[index] += 1e-3;
                (residual(&moved) - &rest) / 1e-3
            })
            .collect();
        let jacobian = DMatrix::from_columns(&columns);
        let mut normal = jacobian.transpose() * &jacobian;
        for index in 0..here.len() {
            normal[(index, index)] *= 1.0 + damping;
        }
        let step = normal.lu().solve(&(jacobian.transpose() * &rest)).ok_or("a singular refit")?;
        let trial: Vec<f64> =
            here.iter().zip(step.iter()).map(|(value, step)| value - step.clamp(-0.5, 0.5)).collect();
        let next = residual(&trial);
        if next.norm() < rest.norm() {
            let gained = 1.0 - next.norm() / rest.norm();
            (here, rest) = (trial, next);
            damping *= 0.1;
            if gained < 1e-3 {
                break;
            }
        } else {
            damping = (damping * 30.0).max(1e-2);
        }
    }
    Ok(Visibility { change, left: size(&rest) })
}

fn size(residual: &DVector<f64>) -> f64 {
    residual.norm() / (residual.len() as f64).sqrt()
}

/// Differences of all responses, each over its root mean square.
fn compare(seen: &[Record], predicted: &[Record]) -> DVector<f64> {
    let mut differences = Vec::new();
    for (seen, predicted) in seen.iter().zip(predicted) {
        // Where one motion has no steady state another level was taken: nothing to compare.
        if driven(seen) != driven(predicted) {
            continue;
        }
        for (seen, predicted) in seen.responses().zip(predicted.responses()) {
            let scale = 1.0 / root_mean_square(&seen.values);
            differences.extend(seen.values.iter().zip(&predicted.values).map(|(a, b)| scale * (b - a)));
        }
    }
    DVector::from_vec(differences)
}

fn driven(record: &Record) -> Option<&Vec<f64>> {
    record.columns.iter().find(|column| column.name.starts_with("excitation")).map(|column| &column.values)
}
