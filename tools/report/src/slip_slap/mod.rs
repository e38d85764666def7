//! What dual-mode records tell of a contact that slips and slaps: a page, a text for the terminal, and JSON. `page` says which
//! tables and figures there are, `figures`, `published` and `tables` make them.

mod figures;
mod json;
mod page;
mod published;
mod tables;

pub use json::slip_slap_json;

use stickslip::data::Record;
use stickslip::identify::{ContactPeriod, SlipSlapIdentification, SlipSlapRecord};
use stickslip::rig::{Separation, Slap};

use crate::Settings;
use crate::document::document_html;

/// An identification of a contact in two directions, and what is known beside it.
#[derive(Debug, Clone)]
pub struct SlipSlapReport<'a> {
    /// What was identified from what.
    pub title: String,
    /// What was found.
    pub found: &'a SlipSlapIdentification,
    /// What the contact truly did in each record, where records are simulated: `displacement`, `force`, `normal_displacement` and
    /// `normal_load` over whole periods from time zero; empty otherwise.
    pub truth: &'a [Record],
    /// Below which preload a model of the rig parts from its support; empty where nobody asked.
    pub separation: &'a [Separation],
    /// And what follows in time.
    pub slap: Option<&'a Slap>,
    /// What was guessed or done when the measurements were read.
    pub notes: &'a [String],
}

/// One self-contained HTML page of the identification.
pub fn slip_slap_html(report: &SlipSlapReport, settings: &Settings) -> String {
    document_html(&report.document(), settings)
}

/// The result, the page's tables and what could not be identified, in lines of at most `width` columns (at least 40 are used). With
/// `color`, ANSI sequences are added.
pub fn slip_slap_table(report: &SlipSlapReport, width: usize, color: bool) -> String {
    crate::identification::document_table(&report.document(), width, color)
}

impl SlipSlapReport<'_> {
    /// Every record with the contact along and across the beam.
    fn periods(&self) -> impl Iterator<Item = (&SlipSlapRecord, [&ContactPeriod; 2])> {
        let inversion = &self.found.inversion;
        let pairs = inversion.periods.iter().zip(&inversion.normal).map(|(along, across)| [along, across]);
        self.found.records.iter().zip(pairs)
    }

    fn is_unidentified(&self, name: &str) -> bool {
        self.found.unidentified.iter().any(|one| one.name == name)
    }
}

/// The levels of a record, as a name.
fn level(record: &SlipSlapRecord) -> String {
    let [first, third] = record.accelerations.map(|a| crate::format::significant(a, 3));
    format!("{first}, {third} m/s²")
}
