//! The catalogue of effects as text for a terminal.

use stickslip::effects::{CATALOGUE, Effect, EffectParameter, Needs, Part, PlaceKind, look_alikes};

use crate::format;
use crate::table::{BOLD, Text};

/// Every effect of the catalogue in a few lines each, at most `width` columns wide (at least 40 are used).
pub fn catalogue_table(width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    for effect in CATALOGUE {
        out.paragraph(&format!("{}: {}", effect.id, effect.title), BOLD);
        out.indented(effect.summary);
    }
    out.line("");
    out.paragraph("`stickslip effects ID` describes an effect, its parameters, and how to confirm it.", "");
    out.finish()
}

/// All that the catalogue says of one effect.
pub fn effect_table(effect: &Effect, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    out.paragraph(&format!("{}: {}", effect.id, effect.title), BOLD);
    out.paragraph(effect.summary, "");
    let mut section = |title: &str, text: &[String]| {
        out.line("");
        out.paragraph(title, BOLD);
        text.iter().for_each(|one| out.indented(one));
    };
    section("What it is", &[effect.explanation.to_owned()]);
    section("How to confirm it", &[effect.confirmation.to_owned()]);
    let alike: Vec<String> = look_alikes(effect)
        .map(|(other, pair)| {
            format!("{}: {}. To distinguish them, {}.", other.title, pair.why, pair.experiment)
        })
        .collect();
    if !alike.is_empty() {
        section("What looks similar", &alike);
    }
    section("Parameters", &effect.parameters.iter().map(parameter).collect::<Vec<_>>());
    section("Where", &[place(effect)]);
    section("What the data must contain", &[needs(effect.needs).to_owned()]);
    out.finish()
}

/// Name, unit, meaning and bounds of a parameter.
pub fn parameter(parameter: &EffectParameter) -> String {
    let quantity = parameter.quantity;
    let unit = format::unit(quantity.unit);
    let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
    let bound = |value: f64| format::significant(value, 4);
    let (above, below) = if quantity.open { ("above", "below") } else { ("from", "up to") };
    let bounds = match (quantity.min, quantity.max) {
        (Some(min), Some(max)) => format!(" ({above} {} {below} {})", bound(min), bound(max)),
        (Some(min), None) => format!(" ({above} {})", bound(min)),
        (None, Some(max)) => format!(" ({below} {})", bound(max)),
        (None, None) => " (either sign)".to_owned(),
    };
    format!("{}{unit}: {}{bounds}", quantity.name, quantity.description)
}

fn place(effect: &Effect) -> String {
    let kinds: Vec<&str> = effect.kinds.iter().map(|kind| kind.name()).collect();
    let place = match effect.place {
        PlaceKind::Nowhere => "It needs no place".to_owned(),
        PlaceKind::Structure => format!("At a mass or a position: {0}@m2, {0}@x=0.55", effect.id),
        PlaceKind::Channel => format!("On a measured channel: {0}@force, {0}@displacement:m1", effect.id),
    };
    let fmu = match effect.part {
        part if part.is_in_fmu() => "FMUs include it",
        // Of a rig it is within.
        Part::NormalDirection => "FMUs of pin rigs include it, others do not",
        _ => "FMUs do not include it",
    };
    format!("{place}. In models of kind {}. {fmu}.", kinds.join(", "))
}

fn needs(needs: Needs) -> &'static str {
    match needs {
        Needs::Nothing => "Nothing beyond what its kind of model needs.",
        Needs::VaryingNormalLoad => "A measured normal load that varies.",
        Needs::NormalMotion => {
            "A measured normal displacement and normal load; the model needs contact.normal_stiffness."
        }
        Needs::Transient => "A start from rest: over a steady state the effect has no meaning.",
    }
}
