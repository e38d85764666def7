//! How far the predictions of a dataset depend on each parameter that a fit may change: what a dataset can show.

use super::{Fitted, RecordResult, Skipped, evaluate};
use crate::data::{Dataset, Record};
use crate::fit::predict::deviation;
use crate::fit::{FitError, InterruptHook};
use crate::model::Model;

/// Fraction of a parameter by which it is changed.
const STEP: f64 = 0.1;

/// What a dataset can say of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Visibility {
    /// Its path.
    pub path: String,
    /// Root mean square change of all predictions for a change by a tenth, over each channel's standard deviation (1).
    pub change: f64,
    /// Paths of parameters that change the predictions in the same way, up to a factor, with the correlation of the changes (1):
    /// at least [`Fitted::TOLD`] in size.
    pub alike: Vec<(String, f64)>,
}

/// What a dataset can say of all of them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Shown {
    /// One entry per free parameter; none where no record is predicted.
    pub parameters: Vec<Visibility>,
    /// The records that the model does not predict: they say nothing.
    pub skipped: Vec<Skipped>,
}

/// What `dataset` can say of the free parameters of `model`, near the values they have. Records that the model does not
/// predict are left out, and told.
///
/// # Errors
/// [`FitError::Interrupted`] where `interrupt` asks for it.
///
/// ```
/// use stickslip::data::{Channel, Dataset, Record, Regime};
/// use stickslip::fit::compare::visibility;
/// use stickslip::model::Model;
/// # let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
/// #     tangential_stiffness = 2e3\nfriction_coefficient = 0.5\nnormal_load = 10.0";
/// let model = Model::parse(text)?;
/// let channel = |name: &str, unit, values: &[f64]| Channel { name: name.into(), unit, values: values.to_vec(), noise: None };
/// let channels = vec![
///     channel("time", "s", &[0.0, 1.0, 2.0]),
///     channel("displacement", "m", &[0.0, 0.5e-3, 1e-3]),
///     channel("force", "N", &[0.0, 1.0, 2.0]),
/// ];
/// let record = Record { name: "pull".into(), regime: Regime::FromRest, use_for: None, channels };
/// let shown = visibility(&model, &Dataset { title: None, records: vec![record] }, None)?;
/// // It sticks throughout: the friction coefficient changes nothing.
/// let of = |path: &str| shown.parameters.iter().find(|one| one.path == path).unwrap().change;
/// assert!(of("contact.tangential_stiffness") > 0.1 && of("contact.friction_coefficient") == 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn visibility(
    model: &Model,
    dataset: &Dataset,
    interrupt: Option<InterruptHook>,
) -> Result<Shown, FitError<String>> {
    let (base, skipped) = predictions(model, dataset);
    if base.iter().all(Option::is_none) {
        return Ok(Shown { parameters: Vec::new(), skipped });
    }
    let mut found: Vec<(String, Vec<f64>)> = Vec::new();
    for parameter in model.parameters().into_iter().filter(|parameter| parameter.free) {
        if interrupt.is_some_and(|interrupt| interrupt()) {
            return Err(FitError::Interrupted);
        }
        let range = parameter.upper - parameter.lower;
        let size = match parameter.value.abs() {
            0.0 if range.is_finite() => STEP * range,
            0.0 => STEP * parameter.quantity.nominal,
            size => size,
        };
        let moved = |sign: f64| {
            let mut trial = model.clone();
            trial
                .set(&parameter.path, parameter.value + sign * STEP * size)
                .ok()
                .map(|()| predictions(&trial, dataset).0)
        };
        // At a bound, or where the model is not solved on one side, the other is taken.
        let change = [1.0, -1.0].into_iter().filter_map(moved).find_map(|moved| difference(&base, &moved));
        found.push((parameter.path, change.unwrap_or_default()));
    }
    let paths: Vec<&str> = found.iter().map(|(path, _)| path.as_str()).collect();
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let one = |(index, (path, change)): (usize, &(String, Vec<f64>))| {
        let own = dot(change, change);
        let with = |(_, other): &(String, Vec<f64>)| {
            let size = (own * dot(other, other)).sqrt();
            if size > 0.0 { dot(change, other) / size } else { 0.0 }
        };
        let row: Vec<f64> = found.iter().map(with).collect();
        let count = change.len().max(1) as f64;
        Visibility {
            path: path.clone(),
            change: (own / count).sqrt(),
            alike: Fitted::told(index, &paths, &row),
        }
    };
    Ok(Shown { parameters: found.iter().enumerate().map(one).collect(), skipped })
}

/// Predictions of every compared channel over its standard deviation; `None` for a record that is not predicted, which is then
/// among the second.
fn predictions(model: &Model, dataset: &Dataset) -> (Vec<Option<Vec<f64>>>, Vec<Skipped>) {
    let stage = evaluate("", model, dataset);
    let of = |(record, result): (&Record, &RecordResult)| {
        let mut scaled = Vec::new();
        for channel in &result.channels {
            let deviation = deviation(record.channel(&channel.name)?).ok()?;
            scaled.extend(channel.predicted.iter().map(|value| value / deviation));
        }
        result.failure.is_none().then_some(scaled)
    };
    let pairs = || dataset.records.iter().zip(&stage.records);
    let failed = |(record, result): (&Record, &RecordResult)| {
        result.failure.clone().map(|reason| Skipped { record: record.name.clone(), reason })
    };
    (pairs().map(of).collect(), pairs().filter_map(failed).collect())
}

/// The change of all predictions that both have; `None` where the change is not finite or a record is lost.
fn difference(base: &[Option<Vec<f64>>], moved: &[Option<Vec<f64>>]) -> Option<Vec<f64>> {
    let mut all = Vec::new();
    for (base, moved) in base.iter().zip(moved) {
        let Some(base) = base else { continue };
        all.extend(base.iter().zip(moved.as_ref()?).map(|(base, moved)| moved - base));
    }
    all.iter().all(|change| change.is_finite()).then_some(all)
}
