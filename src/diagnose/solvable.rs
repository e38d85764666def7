//! Work on those records of a dataset that can be solved.

use super::error::DiagnoseError;
use crate::data::Dataset;
use crate::fit::compare::{RecordResult, RefitError, Skipped, Stage};

/// What `attempt` makes of `dataset`, or of it without the records that no fit can start from; and those.
///
/// # Errors
/// What `attempt` says where no such record is to blame, or where no record is left.
pub(super) fn of<T>(
    dataset: &Dataset,
    attempt: impl Fn(&Dataset) -> Result<T, DiagnoseError>,
) -> Result<(T, Vec<Skipped>), DiagnoseError> {
    let (mut rest, mut skipped) = (dataset.clone(), Vec::new());
    loop {
        let error = match attempt(&rest) {
            Ok(found) => return Ok((found, skipped)),
            Err(error) => error,
        };
        let DiagnoseError::Refit(RefitError::Unpredictable { record, reason }) = &error else {
            return Err(error);
        };
        let blamed =
            rest.records.iter().position(|other| other.name == *record).filter(|_| rest.records.len() > 1);
        let Some(place) = blamed else { return Err(error) };
        rest.records.remove(place);
        skipped.push(Skipped { record: record.clone(), reason: reason.clone() });
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
