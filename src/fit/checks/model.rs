//! Values of a model that no machine has: a unit is off.

use super::{Fault, Finding};
use crate::model::Model;
use crate::system::Beam;

/// Ends of a path, the least and the largest plausible value, and what one outside of them likely is. Density: between light wood and the
/// densest metals (osmium 22 600 kg/m³). Young's modulus: from soft plastics (polyethylene 2·10⁸ Pa) to diamond (1.2·10¹² Pa).
/// Friction: rubber and clean metals in vacuum reach 2 to 4. Sizes: between those of a chip and of a bridge.
const PLAUSIBLE: &[(&str, [f64; 2], [&str; 2])] = &[
    (
        ".youngs_modulus",
        [1e8, 1.3e12],
        ["is it in GPa or N/mm²? Pa is expected, 210e9 for steel", "Pa is expected, 210e9 for steel"],
    ),
    (
        ".density",
        [500.0, 25_000.0],
        [
            "it is that of cork or foam, or in g/cm³ or t/mm³; kg/m³ is expected, 7850 for steel",
            "kg/m³ is expected, 7850 for steel",
        ],
    ),
    (".length", [1e-4, 100.0], ["m is expected", "is it in mm? m is expected"]),
    (".width", [1e-6, 20.0], ["m is expected", "is it in mm? m is expected"]),
    (".thickness", [1e-6, 4.0], ["m is expected", "is it in mm? m is expected"]),
    (
        "contact.friction_coefficient",
        [0.0, 5.0],
        [
            "",
            "is it in %, or the friction limit in N? the force of friction over the normal load is expected",
        ],
    ),
];
/// Speed of sound √(E/ρ) (m/s) below which a beam would be of rubber: soft plastics have 450, lead 1190, steel 5200.
const SOUND: f64 = 300.0;
/// Masses of the beam from which what is fixed to it is no sensor or clamp: the beam would be its spring, and g are the likelier.
const HEAVY: f64 = 20.0;
/// Slip displacement (m) that no contact of machines has: they slip after micrometres.
const SLIPS: f64 = 0.1;

/// What is implausible in the model alone.
pub(super) fn of(model: &Model) -> Vec<Finding> {
    let judged = model.parameters().into_iter().filter_map(|parameter| {
        let (path, value) = (&parameter.path, parameter.value);
        let cause = of_bounds(path, value)
            .or_else(|| of_contact(model, path))
            .or_else(|| model.structure.beam().and_then(|beam| of_beam(beam, path, value)))?;
        let fault = Fault::Implausible { value, unit: parameter.quantity.unit, cause };
        Some(Finding { record: None, channel: Some(parameter.path), fault })
    });
    judged.collect()
}

/// Why a value is implausible by itself.
fn of_bounds(path: &str, value: f64) -> Option<&'static str> {
    let (_, [low, high], causes) = PLAUSIBLE.iter().find(|(end, ..)| path.ends_with(end))?;
    match value {
        value if value < *low => Some(causes[0]),
        value if value > *high => Some(causes[1]),
        _ => None,
    }
}

/// Why the stiffness of a contact is implausible beside its friction limit.
fn of_contact(model: &Model, path: &str) -> Option<&'static str> {
    let contact = model.contact.filter(|_| path == "contact.tangential_stiffness")?;
    // A coefficient that is off by itself is told by itself.
    let friction = contact.friction_coefficient;
    let limit = friction * contact.normal_load;
    let off = of_bounds("contact.friction_coefficient", friction).is_some();
    (!off && contact.tangential_stiffness > 0.0 && limit > SLIPS * contact.tangential_stiffness).then_some(
        "the contact would slip only after more than 0.1 m; is it in N/µm or N/mm, or `contact.normal_load` not in N? N/m is expected",
    )
}

/// Why a value is implausible beside others of the beam.
fn of_beam(beam: &Beam, path: &str, value: f64) -> Option<&'static str> {
    let heavy = HEAVY * beam.density * beam.length * beam.width * beam.thickness;
    let plausible = of_bounds("beam.density", beam.density).is_none();
    match path {
        "beam.youngs_modulus" if plausible && value < SOUND * SOUND * beam.density => Some(
            "with this density it is as soft as rubber; is it in kPa or N/mm²? Pa is expected, 210e9 for steel",
        ),
        "support.offset" if value.abs() > beam.length => {
            Some("it is larger than the beam is long; is it in mm? m is expected")
        }
        // A beam of implausible density has no mass to compare with.
        _ if path.starts_with("beam.point_mass.")
            && path.ends_with(".mass")
            && plausible
            && value > heavy =>
        {
            Some("it is more than 20 times the beam's own mass; is it in g? kg is expected")
        }
        _ => None,
    }
}
