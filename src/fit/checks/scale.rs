//! Units that are off by powers of ten where a contact and its model part.

use super::{Fault, Finding, finding, is_sound, quantile};
use crate::data::Record;
use crate::model::{Model, Structure};

/// Ratio of data and model that no change of parameters makes: half way to a factor of 10³ and beyond friction's own spread.
pub(super) const APART: f64 = 200.0;
/// Displacements over that at which the model slips, from which these are no ordinary slip.
const FAR: f64 = 500.0;

/// A contact's force and displacement against the model's friction limit and slip displacement.
pub(super) fn of_contact(model: &Model, record: &Record, found: &mut Vec<Finding>) {
    let (Structure::Prescribed, Some(contact)) = (&model.structure, &model.contact) else { return };
    let (Some(force), Some(displacement)) = (record.channel("force"), record.channel("displacement")) else {
        return;
    };
    if ![force, displacement].iter().all(|channel| is_sound(found, channel)) {
        return;
    }
    let range = |values: &[f64]| quantile(values, 0.99) - quantile(values, 0.01);
    let (force, displacement) = (range(&force.values), range(&displacement.values));
    let load = record.channel("normal_load").map_or(contact.normal_load, |load| quantile(&load.values, 0.5));
    let (stiffness, limit) = (contact.tangential_stiffness, contact.friction_coefficient * load);
    if !(stiffness > 0.0 && limit > 0.0 && force > 0.0 && displacement > 0.0) {
        return;
    }
    // The loop's height and width over those at which the model just slips.
    let (height, width) = (force / (2.0 * limit), displacement * stiffness / (2.0 * limit));
    let ratio = height / width.min(1.0);
    let (channel, cause) = if ratio > APART && height > 3.0 {
        ("force", "its unit is too large, as kN for N, or `contact.normal_load` is not in N")
    } else if ratio < 1.0 / APART {
        ("force", "its unit is too small, as N for kN, or `contact.normal_load` is not in N")
    } else if ratio > APART {
        (
            "displacement",
            "its unit is too small, as mm for m, or `contact.tangential_stiffness` is not in N/m",
        )
    } else if width > FAR {
        (
            "displacement",
            "its unit is too large, as mm for µm, or `contact.tangential_stiffness` is far too large",
        )
    } else {
        return;
    };
    let (what, measured, modelled, unit) = match channel {
        "force" => ("friction limit", 0.5 * force, limit, "N"),
        _ => ("slip displacement", 0.5 * displacement, limit / stiffness, "m"),
    };
    found.push(finding(record, channel, Fault::Scale { what, measured, modelled, unit, cause }));
}
