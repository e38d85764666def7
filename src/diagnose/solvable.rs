//! Work on those records of a dataset that can be solved.

use super::error::DiagnoseError;
use super::evaluate;
use crate::data::Dataset;
use crate::fit::compare::{RecordResult, RefitError, Skipped, Stage};
use crate::model::Model;

/// What `attempt` makes of `dataset`, or of it without the records that `model` cannot predict; and those.
///
/// # Errors
/// What `attempt` says where no such record is to blame, or where no record is left.
pub(super) fn of<T>(
    model: &Model,
    dataset: &Dataset,
    attempt: impl Fn(&Dataset) -> Result<T, DiagnoseError>,
) -> Result<(T, Vec<Skipped>), DiagnoseError> {
    let (mut rest, mut skipped) = (dataset.clone(), Vec::new());
    loop {
        let error = match attempt(&rest) {
            Ok(found) => return Ok((found, skipped)),
            Err(error) => error,
        };
        let DiagnoseError::Refit(RefitError::Unpredictable { record, .. }) = &error else {
            return Err(error);
        };
        let blamed =
            rest.records.iter().position(|other| other.name == *record).filter(|_| rest.records.len() > 1);
        let Some(place) = blamed else { return Err(error) };
        let alone = Dataset { title: None, records: vec![rest.records.remove(place)] };
        // A fit may fail although the model predicts every record.
        let Some(reason) = evaluate("", model, &alone).records.remove(0).failure else { return Err(error) };
        skipped.push(Skipped { record: alone.records[0].name.clone(), reason });
    }
}

/// Puts the records that were left out back in their places in `stage`, with the reasons.
pub(super) fn tell(stage: &mut Stage, dataset: &Dataset, skipped: &[Skipped]) {
    for (place, record) in dataset.records.iter().enumerate() {
        if let Some(one) = skipped.iter().find(|one| one.record == record.name) {
            let failure = Some(one.reason.clone());
            stage.records.insert(place, RecordResult { error: f64::NAN, channels: Vec::new(), failure });
        }
    }
}
