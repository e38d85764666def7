//! The sections of an identification's page.

use super::IdentificationReport;
use crate::document::{Block, Document, Section};
use crate::format;

impl IdentificationReport<'_> {
    pub(super) fn document(&self) -> Document {
        let mut sections = Vec::new();
        let mut section = |id: &str, title: &str, blocks: Vec<Block>| {
            if !blocks.is_empty() {
                sections.push(Section { id: id.into(), title: title.into(), blocks });
            }
        };
        if !self.found.records.is_empty() {
            section("contact", "Force of the contact", self.contact());
            section("laws", "Laws", self.laws());
            section(
                "records",
                "Records",
                vec![Block::Table(self.record_table()), Block::Note(self.method())],
            );
            section("chain", "Measuring chain", self.chain());
            section("published", "The published way: modes at every amplitude", self.published());
        }
        section("levels", "Resonance over the amplitude", self.levels());
        section("linear", "Linear modes", self.linear());
        section("unidentified", "What these records do not tell", self.unidentified());
        section("skipped", "Records not used", self.skipped());
        section("reading", "How the measurements were read", reading(self.notes));
        Document {
            title: self.title.clone(),
            lead: self.lead(),
            warnings: self.warnings(),
            scope: format!(
                "{} identified, {} not used; intervals are those of 95\u{a0}%.",
                format::count(self.found.records.len(), "steady record"),
                self.found.skipped.len()
            ),
            sections,
        }
    }

    fn warnings(&self) -> Vec<String> {
        let of = |record: &stickslip::identify::ContactRecord| {
            record.warnings.iter().map(|warning| format!("{}: {warning}.", record.name)).collect::<Vec<_>>()
        };
        let failed = self.found.failed_laws.iter().map(|(_, reason)| format!("Not compared: {reason}."));
        let records = self.found.records.iter().flat_map(of);
        self.found.warnings.iter().cloned().chain(records).chain(failed).collect()
    }

    fn contact(&self) -> Vec<Block> {
        vec![Block::Plots(vec![self.loops(), self.over_velocity(), self.map(), self.histories()])]
    }

    fn laws(&self) -> Vec<Block> {
        if self.found.laws.is_empty() {
            return Vec::new();
        }
        let note = "Error of the force under the identified motion, over the force’s root mean square, means left out.";
        vec![
            Block::Table(self.parameter_table()),
            Block::Table(self.error_table()),
            Block::Note(note.to_owned()),
            Block::Plots(self.errors().into_iter().collect()),
        ]
    }

    fn levels(&self) -> Vec<Block> {
        if self.found.levels.is_empty() {
            return Vec::new();
        }
        let mut blocks = vec![Block::Table(self.level_table())];
        if self.found.levels.len() > 1 {
            blocks.push(Block::Plots(self.held_responses().into_iter().chain(self.backbones()).collect()));
        }
        blocks
    }

    fn linear(&self) -> Vec<Block> {
        let of = |record| [Block::Table(self.mode_table(record)), Block::Plots(self.responses(record))];
        self.found.linear.iter().flat_map(of).collect()
    }

    fn unidentified(&self) -> Vec<Block> {
        let text =
            |one: &stickslip::identify::Unidentified| Block::Text(format!("{}: {}.", one.name, one.reason));
        self.found.unidentified.iter().map(text).collect()
    }

    fn skipped(&self) -> Vec<Block> {
        self.found
            .skipped
            .iter()
            .map(|(record, reason)| Block::Text(format!("{record}: {reason}.")))
            .collect()
    }
}

/// What was guessed or done when the measurements were read; the terminal has told it by then.
pub(crate) fn reading(notes: &[String]) -> Vec<Block> {
    notes.iter().map(|note| Block::Note(format!("{note}."))).collect()
}
