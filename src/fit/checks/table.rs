//! Motions beyond the table of a measured law.

use super::{Fault, Finding, finding, quantile};
use crate::contact::{MEASURED, Measured};
use crate::data::Record;
use crate::model::{Model, Structure};

/// Motions over the range from which they are beyond it: a table is made from noisy records, too.
const BEYOND: f64 = 1.01;

pub(super) fn of(model: &Model, record: &Record, found: &mut Vec<Finding>) {
    let (Structure::Prescribed, Some(contact)) = (&model.structure, &model.contact) else { return };
    let (Some(displacement), true) = (record.channel("displacement"), contact.law.kind == MEASURED) else {
        return;
    };
    let Ok(kept) = <&[f64; Measured::KNOTS - 1]>::try_from(contact.law.values()) else { return };
    let Ok(law) = Measured::new(contact.tangential_stiffness, contact.friction_coefficient, kept) else {
        return;
    };
    let load = record.channel("normal_load").map_or(contact.normal_load, |load| quantile(&load.values, 0.5));
    let ends = displacement
        .values
        .iter()
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(*value), high.max(*value)]);
    // The branches after a reversal have twice the curve's size.
    let (moved, range) = (0.5 * (ends[1] - ends[0]), law.range(load));
    if moved > BEYOND * range && range > 0.0 {
        found.push(finding(record, "displacement", Fault::BeyondTable { moved, range }));
    }
}
