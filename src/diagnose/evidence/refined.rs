//! The error of the steps in time, and of the harmonics that are left out, taken off the parameters: fits repeat simulations
//! a thousand times, with an error that lies far below the noise of one sample, but not of all of them.

use nalgebra::{DMatrix, DVector};

use super::joint::{Joint, dot};
use super::latent::Latent;
use super::measured::Measured;
use super::posterior::{HERE, Posterior, white_round};
use crate::model::Structure;

/// Steps in place of one.
const FINER: usize = 8;

/// Steps of Gauss and Newton: the error of the steps may move a parameter by many of its deviations, which are small.
const ROUNDS: usize = 2;

/// `posterior` moved to where simulations in finer steps fit best.
pub(super) fn refined(data: &Measured, posterior: &Posterior) -> Result<Posterior, String> {
    if posterior.model.structure == Structure::Prescribed {
        return Ok(posterior.clone());
    }
    let (latent, count) = (Latent::default(), posterior.unknowns.len());
    let mut joint = Joint::new(data, &posterior.model, &posterior.unknowns, &latent)?;
    let mut y = white_round(&mut joint, &posterior.y[..count], HERE)?;
    for _ in 0..ROUNDS {
        joint.minimise(&mut y, HERE.steps, HERE.tolerance)?;
        joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
        y = stepped(&mut joint, &y)?;
    }
    y.truncate(count);
    Ok(Posterior { model: joint.model(&y)?, y, ..posterior.clone() })
}

/// A step from `y` towards where predictions in finer steps, that change with the unknowns as those here, fit best.
fn stepped(joint: &mut Joint, y: &[f64]) -> Result<Vec<f64>, String> {
    let data = joint.data;
    let sums = joint.sums_here(y);
    let factor = DMatrix::from_row_slice(y.len(), y.len(), &sums.curvature).cholesky();
    let factor = factor.ok_or("the curvature is not positive")?;
    let mut gradient = DVector::from_vec(sums.gradient);
    let (model, whitened) = (joint.model(y)?, joint.whitened());
    for (k, record) in whitened.iter().enumerate() {
        let error = joint.slots[k].step_error(&model, y, FINER)?;
        let error = joint.noise.whiten(data, k, &error);
        record.columns.iter().for_each(|(i, column)| gradient[*i] += dot(column, &error));
    }
    data.bench.count(FINER * whitened.len());
    let step = factor.solve(&gradient);
    Ok(y.iter().zip(step.iter()).map(|(y, by)| y - by).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::ObservedSimulation;
    use crate::model::Model;

    fn model(stiffness: f64, friction: f64) -> Model {
        Model::parse(&format!(
            "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n[[mass]]\nname = \"m1\"\nmass = 1.0\n\
             [[spring]]\nbetween = [\"ground\", \"m1\"]\nstiffness = 4e3\ndamping = 1.0\n[contact]\nat = \"m1\"\n\
             law = \"jenkins\"\ntangential_stiffness = {stiffness}\nfriction_coefficient = {friction}\n\
             normal_load = 10.0\n"
        ))
        .unwrap()
    }

    /// From rest under a sine, which the contact slips at, as steps far finer than those of fits give it.
    fn measured(truth: &Model) -> Record {
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let channels = vec![
            channel("time", "s", (0..800).map(|i| f64::from(i) * 2e-3).collect()),
            channel("excitation:m1", "N", (0..800).map(|i| 8.0 * (0.13 * f64::from(i)).sin()).collect()),
            channel("displacement:m1", "m", vec![0.0; 800]),
        ];
        let mut record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
        let mut values = Vec::new();
        let mut shown = ObservedSimulation::new(truth, &record).unwrap();
        shown.refine(100);
        shown.predict(truth, &[], &mut values).unwrap();
        drop(shown);
        record.channels[2].values = values;
        record
    }

    #[test]
    fn parameters_are_freed_of_the_error_of_the_steps() {
        for (stiffness, friction) in [(2e3, 0.3), (5e3, 0.4), (1e3, 0.2)] {
            let truth = model(stiffness, friction);
            let dataset = Dataset { title: None, records: vec![measured(&truth)] };
            let given = model(1.1 * stiffness, 0.95 * friction);
            let bench = WeightedDataset::new(&given, &dataset, Assumptions::default(), None).unwrap();
            let data = Measured::new(&bench, &[0], &[], &[]);
            let fitted = first(&data, None, &given).and_then(|(first, _)| again(&data, &first)).unwrap();
            let refined = refined(&data, &fitted).unwrap();
            let error = |of: &Posterior| {
                let off = |path: &str| (of.model.get(path).unwrap() / truth.get(path).unwrap()).ln().abs();
                off("contact.tangential_stiffness").max(off("contact.friction_coefficient"))
            };
            let (before, after) = (error(&fitted), error(&refined));
            assert!(before > 1e-6 && after < 0.3 * before, "{before} {after}");
        }
    }
}
