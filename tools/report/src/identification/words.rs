//! What the numbers of an identification mean, in sentences.

use stickslip::identify::{IdentifiedParameter, LevelSource};

use super::{IdentificationReport, name_of};
use crate::format;

impl IdentificationReport<'_> {
    /// The result in a sentence.
    pub(super) fn lead(&self) -> String {
        let records = format::count(self.found.records.len(), "steady record");
        let Some((law, predicted)) = self.best().zip(self.prediction()) else {
            return match self.found.records.is_empty() {
                true => format!(
                    "{} and no force of the contact.",
                    format::count(self.found.levels.len(), "resonance")
                ),
                false => format!("The contact’s force was identified in {records}; no law describes it."),
            };
        };
        if let Some(range) = self.found.range {
            return format!(
                "The contact’s force was identified in {records}. No law of the library describes it; the measured map stands \
                 for it, {predicted}. It holds for motions of up to ±\u{a0}{} about their middle.",
                format::engineering(range, "m")
            );
        }
        let numbers: Vec<String> =
            law.parameters.iter().map(|one| format!("{} {}", prose(one.name), value(one))).collect();
        format!(
            "The contact’s force was identified in {records}. Best law: {}, {predicted}; {}.",
            prose(name_of(law)),
            numbers.join(", ")
        )
    }

    /// How well the best law predicts, in words.
    fn prediction(&self) -> Option<String> {
        let law = self.best()?;
        let of = |fitted: bool| {
            let errors = law.errors.iter().enumerate().filter(move |(k, _)| self.is_fitted(*k) == fitted);
            errors.filter_map(|(_, error)| *error).fold(f64::NAN, f64::max)
        };
        let percent = |error: f64| format!("{}\u{a0}%", format::significant(100.0 * error, 2));
        Some(match of(false).is_nan() {
            true => format!("which leaves {} of the force it was fitted to", percent(of(true))),
            false => format!(
                "which predicts records it was not fitted to within {} of the force",
                percent(of(false))
            ),
        })
    }

    /// Why receptances are inverted, with the figures of these records.
    pub(super) fn method(&self) -> String {
        let off: Vec<f64> =
            self.found.records.iter().filter_map(|r| Some(r.published.as_ref()?.difference)).collect();
        let compared = match off.iter().copied().reduce(f64::max) {
            Some(most) => format!(
                " Two modes of the beam at each amplitude (the published way) give a force that differs by up to {}\u{a0}%.",
                format::significant(100.0 * most, 2)
            ),
            None => String::new(),
        };
        format!(
            "The force is the one that makes the linear beam move as measured: receptances of many modes, with the residual \
             flexibility of the rest, inverted for all records together, so that errors of the gains are told from the \
             force.{compared} Two modes lack what a moment at the end does to all others; therefore inversion is the default."
        )
    }
}

/// `tangential_stiffness` as prose.
pub(super) fn prose(name: &str) -> String {
    name.replace('_', " ")
}

/// `7.9 MN/m (7.7 … 8.1)`.
pub(super) fn value(one: &IdentifiedParameter) -> String {
    let [low, high] = one.interval.map(|end| format::engineering(end, one.unit));
    match one.interval.iter().all(|end| end.is_finite()) {
        true => format!("{} ({low} … {high})", format::engineering(one.value, one.unit)),
        false => format!("{} (not determined)", format::engineering(one.value, one.unit)),
    }
}

/// Where a resonance is from.
pub(super) fn source(source: &LevelSource) -> String {
    match source {
        LevelSource::Random => "random excitation".to_owned(),
        LevelSource::Stepped(records) => format!("fit of {}", format::count(records.len(), "record")),
        LevelSource::Single(record, off) => {
            format!("{record}, phase off by {}°", format::significant(off.to_degrees(), 2))
        }
        LevelSource::Table(record) => record.clone(),
    }
}
