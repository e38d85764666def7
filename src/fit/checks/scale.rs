//! Units that are off by powers of ten: in a model, or where a contact and its model part.

use super::{Fault, Finding, finding, quantile};
use crate::data::Record;
use crate::model::{Model, Structure};

/// Ratio of data and model that no change of parameters makes: half way to a factor of 10³ and beyond friction's own spread.
pub(super) const APART: f64 = 200.0;
/// Displacements over that at which the model slips, from which these are no ordinary slip.
const FAR: f64 = 500.0;

/// Ends of a path, the least and the largest plausible value, and what one outside of them likely is.
const PLAUSIBLE: &[(&str, [f64; 2], [&str; 2])] = &[
    (
        ".youngs_modulus",
        [1e6, 1e13],
        ["is it in GPa or N/mm²? Pa is expected, 210e9 for steel", "Pa is expected, 210e9 for steel"],
    ),
    (".density", [1.0, 1e5], ["is it in g/cm³ or t/mm³? kg/m³ is expected", "kg/m³ is expected"]),
    (".length", [1e-4, 100.0], ["m is expected", "is it in mm? m is expected"]),
    (".width", [1e-6, 20.0], ["m is expected", "is it in mm? m is expected"]),
    (".thickness", [1e-6, 4.0], ["m is expected", "is it in mm? m is expected"]),
];

/// What is implausible in the model alone.
pub(super) fn of_model(model: &Model) -> Vec<Finding> {
    let judged = model.parameters().into_iter().filter_map(|parameter| {
        let (_, [low, high], causes) = PLAUSIBLE.iter().find(|(end, ..)| parameter.path.ends_with(end))?;
        let cause = match parameter.value {
            value if value < *low => causes[0],
            value if value > *high => causes[1],
            _ => return None,
        };
        let fault = Fault::Implausible { value: parameter.value, unit: parameter.quantity.unit, cause };
        Some(Finding { record: None, channel: Some(parameter.path), fault })
    });
    judged.collect()
}

/// A contact's force and displacement against the model's friction limit and slip displacement.
pub(super) fn of_contact(model: &Model, record: &Record, found: &mut Vec<Finding>) {
    let (Structure::Prescribed, Some(contact)) = (&model.structure, &model.contact) else { return };
    let (Some(force), Some(displacement)) = (record.channel("force"), record.channel("displacement")) else {
        return;
    };
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
        ("force", "is the force in N where the column says kN, or `contact.normal_load` in kN? N is expected")
    } else if ratio < 1.0 / APART {
        ("force", "is the force in kN where the column says N, or `contact.normal_load` in mN? N is expected")
    } else if ratio > APART {
        (
            "displacement",
            "is the displacement in m where the column says mm, or `contact.tangential_stiffness` in N/mm? N/m is expected",
        )
    } else if width > FAR {
        (
            "displacement",
            "is the displacement in mm where the column says m, or `contact.tangential_stiffness` a thousand times too large?",
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
