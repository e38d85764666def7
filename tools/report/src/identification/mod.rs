//! The results of an identification: a page, a text for the terminal, and JSON. `page` says which tables and figures there
//! are, `tables`, `figures` and `published` make them; the terminal shows the same tables.

mod figures;
mod json;
mod page;
mod published;
mod tables;
mod terminal;
mod words;

pub use json::identification_json;
pub(crate) use page::reading;
pub(crate) use published::{half, over_period, points};
pub(crate) use tables::{chain_blocks, table};
pub(crate) use terminal::document_table;
pub use terminal::identification_table;

use stickslip::identify::{ContactPeriod, ContactRecord, Identification, IdentifiedLaw, force_under};

use crate::Settings;
use crate::document::document_html;

/// An identification, and what it is of.
#[derive(Debug, Clone)]
pub struct IdentificationReport<'a> {
    /// What was identified from what.
    pub title: String,
    /// What was found.
    pub found: &'a Identification,
    /// What was guessed or done when the measurements were read.
    pub notes: &'a [String],
}

/// One self-contained HTML page of the identification.
pub fn identification_html(report: &IdentificationReport, settings: &Settings) -> String {
    document_html(&report.document(), settings)
}

impl IdentificationReport<'_> {
    /// Every record with the contact's period in it.
    fn periods(&self) -> impl Iterator<Item = (&ContactRecord, &ContactPeriod)> {
        let periods = self.found.inversion.iter().flat_map(|inversion| &inversion.periods);
        self.found.records.iter().zip(periods)
    }

    fn best(&self) -> Option<&IdentifiedLaw> {
        self.found.best.map(|best| &self.found.laws[best])
    }

    fn is_fitted(&self, record: usize) -> bool {
        self.found.fitted.contains(&record)
    }
}

/// The name that a model file gives a law.
fn name_of(law: &IdentifiedLaw) -> &'static str {
    law.model.contact.map_or("", |contact| contact.law.kind.name)
}

/// The contact's motion in `period` with the force that `law` has under it; `None` where it has no periodic one.
fn under(law: &IdentifiedLaw, period: &ContactPeriod) -> Option<ContactPeriod> {
    let force = force_under(&law.model, period).ok()?;
    Some(ContactPeriod { force, ..period.clone() })
}

/// Displacement, velocity and force at `count` equal steps of a period, the first again at the end.
fn samples(period: &ContactPeriod, count: usize) -> Vec<[f64; 3]> {
    let duration = std::f64::consts::TAU / period.angular_frequency;
    (0..=count).map(|k| period.at(duration * k as f64 / count as f64)).collect()
}
