//! Compare a model with a dataset, refit it, compare again.

use super::comparison::{Parameter, RecordResult, Stage};
use super::{predict, score};
use crate::identify::{self, FitError, FitOptions};
use crate::measure::{Dataset, Use};
use crate::model::Model;

/// Predicts every record of `dataset` with `model` and scores the predictions.
///
/// A record that cannot be predicted keeps the reason in [`RecordResult::failure`]; the others count.
pub fn evaluate(name: &str, model: &Model, dataset: &Dataset) -> Stage {
    let records: Vec<RecordResult> = dataset.records.iter().map(|record| predict::scored(model, record)).collect();
    let parameters = model
        .parameters()
        .into_iter()
        .map(|parameter| Parameter {
            unit: parameter.quantity.unit,
            value: parameter.value,
            path: parameter.path,
            fitted_from: None,
        })
        .collect();
    Stage { name: name.to_owned(), parameters, error: score::total(&records), records, evaluations: 0 }
}

/// Fits the model's free parameters to the dataset and evaluates the result.
///
/// Fitted to the records marked `use = "fit"`; to all records where none is so marked. The residual is
/// the error that [`Stage::error`] reports, so that the fit lowers what the user reads. `go_on` is asked
/// now and then with the number of evaluations and the best error so far; `false` ends the fit with the
/// best parameters found.
pub fn refit(
    name: &str,
    model: &Model,
    dataset: &Dataset,
    go_on: &mut (dyn FnMut(usize, f64) -> bool + Send),
) -> Result<(Model, Stage), FitError> {
    let free: Vec<_> = model.parameters().into_iter().filter(|parameter| parameter.free).collect();
    let marked = dataset.records.iter().any(|record| record.use_for == Some(Use::Fit));
    let fitted: Vec<_> =
        dataset.records.iter().filter(|record| !marked || record.use_for == Some(Use::Fit)).collect();
    let with = |values: &[f64]| -> Result<Model, String> {
        let mut trial = model.clone();
        for (parameter, value) in free.iter().zip(values) {
            trial.set(&parameter.path, *value).map_err(|error| error.to_string())?;
        }
        Ok(trial)
    };
    let problem = identify::Problem {
        parameters: free.iter().map(predict::fit_parameter).collect(),
        residual: &|values: &[f64]| {
            let trial = with(values)?;
            let mut residual = Vec::new();
            for record in &fitted {
                residual.extend(predict::normalised_residual(&trial, record)?);
            }
            Ok(residual)
        },
    };
    let fit = identify::fit(&problem, &FitOptions::default(), go_on)?;
    let best = with(&fit.parameters).map_err(FitError::Evaluation)?;
    let mut stage = evaluate(name, &best, dataset);
    stage.evaluations = fit.evaluations;
    for parameter in &mut stage.parameters {
        parameter.fitted_from = free.iter().find(|free| free.path == parameter.path).map(|free| free.value);
    }
    Ok((best, stage))
}
