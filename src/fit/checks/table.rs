//! Motions beyond the table of a measured law.

use super::{Fault, Finding, finding, quantile};
use crate::contact::{MEASURED, Measured};
use crate::data::Record;
use crate::model::{Contact, Model, Structure};

/// Motions over the range from which they are beyond it: a table is made from noisy records, too.
pub(in crate::fit) const BEYOND: f64 = 1.01;

/// Where the table of a contact's measured law ends (m) under `load` (N); `None` of other laws.
pub(in crate::fit) fn range_of(contact: &Contact, load: f64) -> Option<f64> {
    if contact.law.kind != MEASURED {
        return None;
    }
    let kept = <&[f64; Measured::KNOTS - 1]>::try_from(contact.law.values()).ok()?;
    let law = Measured::new(contact.tangential_stiffness, contact.friction_coefficient, kept).ok()?;
    Some(law.range(load)).filter(|range| *range > 0.0)
}

pub(super) fn of(model: &Model, record: &Record, found: &mut Vec<Finding>) {
    let (Structure::Prescribed, Some(contact)) = (&model.structure, &model.contact) else { return };
    let Some(displacement) = record.channel("displacement") else { return };
    let load = record.channel("normal_load").map_or(contact.normal_load, |load| quantile(&load.values, 0.5));
    let Some(range) = range_of(contact, load) else { return };
    let ends = displacement
        .values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)]);
    // The branches after a reversal have twice the curve's size.
    let moved = 0.5 * (ends[1] - ends[0]);
    if moved > BEYOND * range {
        found.push(finding(record, "displacement", Fault::BeyondTable { moved, range }));
    }
}
