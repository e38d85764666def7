//! Refits the free parameters of a model to a dataset.

use rayon::prelude::*;

use super::score::RecordResidual;
use super::{Skipped, Stage, evaluate, intervals};
use crate::data::{Dataset, Record, Use};
use crate::fit::least_squares::fit_reviving;
use crate::fit::{self, Ending, FitError, InterruptHook, Options, ProgressHook};
use crate::model::Model;

/// How a refit is watched and stopped.
///
/// ```
/// use stickslip::fit::compare::Watch;
/// let progress = |fit: &stickslip::fit::Progress| println!("{}: {}", fit.iteration, fit.root_mean_square);
/// let watch = Watch { progress: Some(&progress), interrupt: None };
/// assert!(watch.progress.is_some());
/// ```
#[derive(Clone, Copy, Default)]
pub struct Watch<'a> {
    /// Called after every accepted step.
    pub progress: Option<ProgressHook<'a>>,
    /// Asked before every evaluation; `true` ends the fit with the best parameters so far.
    pub interrupt: Option<InterruptHook<'a>>,
}

/// Why a model could not be refitted.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum RefitError {
    /// No parameter is free.
    #[error("no parameter is free; name some in `[fit] free`")]
    NothingFree,
    /// Every record is kept for selecting or confirming.
    #[error("no record is used in the fit; mark one `use = \"fit\"`, or remove all marks")]
    NothingToFit,
    /// None of the records can be predicted with the parameters as they stand; this is the first.
    #[error("`{record}` cannot be predicted: {reason}")]
    Unpredictable {
        /// Its name in the dataset.
        record: String,
        /// What the solver said.
        reason: String,
    },
    /// Every record can be predicted, and all together cannot be fitted.
    #[error("the model cannot be fitted to these records: {reason}")]
    Unfitted {
        /// What the solver said.
        reason: String,
    },
    /// The fit itself.
    #[error("{0}")]
    Fit(#[from] FitError<String>),
}

/// A model with its parameters fitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Refit {
    /// The model.
    pub model: Model,
    /// Its predictions of all records, those that it was not fitted to among them.
    pub stage: Stage,
    /// Why the fit ended; a user should see anything but `Converged`.
    pub ending: Ending,
    /// Paths of free parameters on which none of the fitted records depends; they stay where they started.
    pub unseen: Vec<String>,
    /// The records that a fit may see but that the model as it stood does not predict: they are left out of the fit.
    pub skipped: Vec<Skipped>,
}

/// The records a fit may see: those marked `use = "fit"`, or where none is so marked those without a mark.
fn fitted(dataset: &Dataset) -> Vec<&Record> {
    let used = |use_for| dataset.records.iter().filter(|record| record.use_for == use_for).collect();
    let marked: Vec<&Record> = used(Some(Use::Fit));
    if marked.is_empty() { used(None) } else { marked }
}

/// Fits the model's free parameters to the dataset and evaluates the result.
///
/// Fitted to the records marked `use = "fit"`, where none is so marked to those without a mark. The
/// residual is the error that [`Stage::error`] reports, over these records alone. A record that the model as it stands
/// does not predict is left out of the fit, and named.
///
/// # Errors
/// [`RefitError`].
///
/// ```
/// use stickslip::prelude::*;
/// let model = Model::parse(
///     r#"
///     schema = "stickslip.model/1"
///     kind = "contact"
///     contact = { law = "jenkins", tangential_stiffness = 2e3, friction_coefficient = 0.1, normal_load = 10.0 }
///     "#,
/// )?;
/// // Up and down by 2 mm, and the force of a slider of 2 N/mm that slips at 1.5 N instead of 1 N.
/// let displacement: Vec<f64> = (0..40).map(|k: i32| 2e-4 * f64::from(10 - (k - 10).abs())).collect();
/// let mut slider = 0.0;
/// let force = displacement.iter().map(|u: &f64| {
///     slider = f64::clamp(slider, u - 7.5e-4, u + 7.5e-4);
///     2e3 * (u - slider)
/// }).collect();
/// let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
/// let channels = vec![
///     channel("time", "s", (0..40).map(f64::from).collect()),
///     channel("displacement", "m", displacement),
///     channel("force", "N", force),
/// ];
/// let record = Record { name: "triangle".into(), regime: Regime::FromRest, use_for: None, channels };
/// let dataset = Dataset { title: None, records: vec![record] };
///
/// assert!(evaluate("as given", &model, &dataset).error > 0.1);
/// let fitted = refit("refitted", &model, &dataset, Watch::default())?.model;
/// let limit = 10.0 * fitted.get("contact.friction_coefficient").unwrap();
/// assert!((limit - 1.5).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn refit(name: &str, model: &Model, dataset: &Dataset, watch: Watch) -> Result<Refit, RefitError> {
    let free: Vec<_> = model.parameters().into_iter().filter(|parameter| parameter.free).collect();
    if free.is_empty() {
        return Err(RefitError::NothingFree);
    }
    let found = predicted(model, fitted(dataset), watch.interrupt);
    if watch.interrupt.is_some_and(|interrupted| interrupted()) {
        return Err(FitError::Interrupted.into());
    }
    let Predicted { records: fitted, values: count, skipped } = found?;
    let with = |values: &[f64]| -> Result<Model, String> {
        let mut trial = model.clone();
        let pairs: Vec<_> =
            free.iter().zip(values).map(|(parameter, value)| (&parameter.path, *value)).collect();
        trial.set_all(&pairs).map_err(|error| error.to_string())?;
        Ok(trial)
    };
    let residual = |values: &[f64], out: &mut [f64]| -> Result<(), String> {
        let trial = with(values)?;
        let (mut rest, mut part) = (out, Vec::new());
        for record in &fitted {
            record.write(&trial, watch.interrupt, &mut part)?;
            let (here, after) = std::mem::take(&mut rest).split_at_mut(part.len());
            here.copy_from_slice(&part);
            rest = after;
        }
        Ok(())
    };
    let parameters: Vec<_> = free
        .iter()
        .map(|free| fit::Parameter {
            start: free.value,
            lower: free.lower,
            upper: free.upper,
            scale: free.scale,
        })
        .collect();
    let options = Options { progress: watch.progress, interrupt: watch.interrupt, ..Options::default() };
    let (fit, unseen) = fit_reviving(residual, count, &parameters, &options)?;
    let best = with(&fit.parameters).map_err(|reason| FitError::NoStart { first: Some(reason) })?;
    let mut stage = evaluate(name, &best, dataset);
    stage.evaluations = fit.evaluations;
    for (free, fitted) in free.iter().zip(intervals::fitted(&free, &fit, &unseen)) {
        let here = stage.parameters.iter_mut().filter(|parameter| parameter.path == free.path);
        here.for_each(|parameter| parameter.fitted = Some(fitted.clone()));
    }
    let unseen: Vec<String> = unseen.into_iter().map(|index| free[index].path.clone()).collect();
    stage.notes.extend(notes(fit.ending, &best, &unseen));
    Ok(Refit { model: best, stage, ending: fit.ending, unseen, skipped })
}

/// What a reader must know of a fit that ended as `ending`.
fn notes(ending: Ending, best: &Model, unseen: &[String]) -> Vec<String> {
    let ended = match ending {
        Ending::Converged => None,
        Ending::Interrupted => Some("the fit was interrupted; these are the results so far"),
        Ending::StepLimit => Some("the fit was still improving when its steps ran out"),
        Ending::Stalled => Some("the fit ended where no step lowered the error, short of convergence"),
    };
    let stays = |path: &String| {
        let value = best.get(path).unwrap_or(f64::NAN);
        format!("no fitted record depends on `{path}`, which keeps its value {value}")
    };
    ended.map(str::to_owned).into_iter().chain(unseen.iter().map(stays)).collect()
}

/// The records that a model predicts, and the others.
struct Predicted<'d> {
    records: Vec<RecordResidual<'d>>,
    /// Values in them.
    values: usize,
    skipped: Vec<Skipped>,
}

/// Those of `records` that `model` predicts as it stands: at least one.
fn predicted<'d>(
    model: &Model,
    records: Vec<&'d Record>,
    interrupt: Option<InterruptHook>,
) -> Result<Predicted<'d>, RefitError> {
    let mut found = Predicted { records: Vec::new(), values: 0, skipped: Vec::new() };
    let tried = |record| {
        let residual = RecordResidual::new(model, record)?;
        residual.write(model, interrupt, &mut Vec::new()).map(|()| residual)
    };
    let all: Vec<Result<RecordResidual, String>> = records.par_iter().map(|record| tried(record)).collect();
    for (record, tried) in records.iter().zip(all) {
        match tried {
            Ok(residual) => {
                found.values += residual.len();
                found.records.push(residual);
            }
            Err(reason) => found.skipped.push(Skipped { record: record.name.clone(), reason }),
        }
    }
    match found.skipped.first() {
        Some(Skipped { record, reason }) if found.records.is_empty() => {
            Err(RefitError::Unpredictable { record: record.clone(), reason: reason.clone() })
        }
        None if found.records.is_empty() => Err(RefitError::NothingToFit),
        _ => Ok(found),
    }
}
