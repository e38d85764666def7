//! The sections of the page.

use stickslip::identify::SlipSlapRecord;

use super::SlipSlapReport;
use crate::document::{Block, Document, Section};
use crate::format;
use crate::identification::reading;

/// What records tell of separation.
enum Parting {
    /// None occurs: at least this force (N) presses the pin on its support.
    Never(f64),
    /// It occurs.
    Leaves,
    /// The normal force is not known well enough.
    Untold,
}

impl SlipSlapReport<'_> {
    pub(super) fn document(&self) -> Document {
        let mut sections = Vec::new();
        let mut section = |id: &str, title: &str, blocks: Vec<Block>| {
            if !blocks.is_empty() {
                sections.push(Section { id: id.into(), title: title.into(), blocks });
            }
        };
        section("loops", "Forces of the contact", self.loops());
        section("slip", "Slip, hardening and coupling", self.slip());
        section("separation", "Separation", self.separation());
        section("published", "The published way: nonlinear modes", self.published());
        section("chain", "Measuring chain", self.chain());
        section("unidentified", "What these records do not tell", self.unidentified());
        section("skipped", "Records not used", self.skipped());
        section("reading", "How the measurements were read", reading(self.notes));
        Document {
            title: self.title.clone(),
            lead: self.lead(),
            warnings: self.found.warnings.clone(),
            scope: format!(
                "{} identified, {} not used; intervals are those of 95\u{a0}%.",
                format::count(self.found.records.len(), "steady record"),
                self.found.skipped.len()
            ),
            sections,
        }
    }

    fn lead(&self) -> String {
        let records = format::count(self.found.records.len(), "steady record");
        let told = match ["tangential_force", "normal_force"].map(|name| !self.is_unidentified(name)) {
            [true, true] => format!("Both forces of the contact were identified in {records}"),
            [true, false] => format!(
                "The tangential force of the contact was identified in {records}; the normal force is not told by these records (see \
                 “What these records do not tell”)"
            ),
            [false, true] => {
                format!("The normal force of the contact was identified in {records}, the tangential was not")
            }
            [false, false] => {
                return format!(
                    "Neither force of the contact is told by {records}: see “What these records do not tell”, and what is shown below as \
                     an order of magnitude at best."
                );
            }
        };
        let coupling = match &self.found.coupling {
            _ if self.is_unidentified("normal_force") => None,
            Some(coupling) if coupling.explained > 0.0 => Some(format!(
                "the limit of friction follows the normal force by a factor of {}, which explains {}\u{a0}% of what a constant limit \
                 leaves",
                format::significant(coupling.following, 2),
                format::significant(100.0 * coupling.explained, 2)
            )),
            Some(_) => Some("nothing shows that the limit of friction follows the normal force".to_owned()),
            None => Some("no sliders describe the tangential force".to_owned()),
        };
        let parting = match self.parting() {
            Parting::Never(least) => {
                format!(
                    "the pin never leaves its support (at least {} press on it)",
                    format::engineering(least, "N")
                )
            }
            Parting::Leaves => "the pin leaves its support".to_owned(),
            Parting::Untold => "whether the pin leaves its support is not told".to_owned(),
        };
        let further: Vec<String> = coupling.into_iter().chain([parting]).collect();
        format!("{told}, no law assumed: {}.", further.join("; "))
    }

    /// Whether the pin leaves its support in any record, within the 95 % intervals of the normal force.
    fn parting(&self) -> Parting {
        let ends = |sign: f64| {
            let of = |record: &SlipSlapRecord| record.normal_force[0] + sign * record.force_intervals[1];
            self.found.records.iter().map(of).fold(f64::INFINITY, f64::min)
        };
        match (ends(-1.0), ends(1.0)) {
            _ if self.is_unidentified("normal_force") => Parting::Untold,
            (low, _) if low > 0.0 => Parting::Never(self.least_normal_force()),
            (_, high) if high < 0.0 => Parting::Leaves,
            _ => Parting::Untold,
        }
    }

    /// The same for programs; `None` where it is not told.
    pub(super) fn separates(&self) -> Option<bool> {
        match self.parting() {
            Parting::Never(_) => Some(false),
            Parting::Leaves => Some(true),
            Parting::Untold => None,
        }
    }

    pub(super) fn least_normal_force(&self) -> f64 {
        self.found.records.iter().map(|record| record.normal_force[0]).fold(f64::INFINITY, f64::min)
    }

    fn loops(&self) -> Vec<Block> {
        let plots = vec![self.tangential(), self.normal(), self.tangential_history(), self.normal_history()];
        vec![Block::Plots(plots), Block::Table(self.force_table()), Block::Note(self.method())]
    }

    fn slip(&self) -> Vec<Block> {
        let mut blocks = vec![
            Block::Text(
                "A hysteresis consists of a loop for every two reversals of its displacement: a large one, and smaller ones within it. \
                 A motion of two tones ω and 3ω turns six times a period at most, so that three loops are all it can have, one large \
                 and two within. Along the way the contact sticks, slips in part (micro-slip) or as a whole (macro-slip), by the slope \
                 of force over displacement: above 90\u{a0}%, between, and below 10\u{a0}% of that of a contact that sticks."
                    .to_owned(),
            ),
            Block::Table(self.slip_table()),
            Block::Table(self.hardening_table()),
        ];
        if self.is_unidentified("normal_stiffness") {
            let text = "The slopes of the normal force, and how it hardens, are not identified where they change with what is assumed of \
                        the beam: its modulus would have to be known to some ten-thousandths.";
            blocks.push(Block::Warning(text.to_owned()));
        }
        if let Some(coupling) = &self.found.coupling {
            let [low, high] = coupling.interval.map(|end| format::significant(end, 2));
            let [constant, following] = coupling.left.map(|left| format::significant(100.0 * left, 2));
            blocks.push(Block::Text(format!(
                "Coupling: sliders under a limit μ[N₀ + κ(N_c − N₀)] describe the tangential forces best with κ = {} ({low} … {high}); \
                 0 is a constant limit, 1 Coulomb’s. A constant limit leaves {constant}\u{a0}% of the force, the one that follows \
                 {following}\u{a0}%: the normal force explains {}\u{a0}% of what the limit’s variation does.",
                format::significant(coupling.following, 2),
                format::significant(100.0 * coupling.explained, 2)
            )));
        }
        blocks
    }

    fn separation(&self) -> Vec<Block> {
        let (least, preload) = (self.least_normal_force(), self.found.preload);
        let weight = |force: f64| {
            format!("{} ({}\u{a0}kg)", format::engineering(force, "N"), format::significant(force / 9.81, 2))
        };
        let text = match self.parting() {
            Parting::Never(least) => format!(
                "No separation occurs in these records: under a preload of {} at least {} press the pin on its support. The normal \
                 force swings by about as much under any preload, so that these records foretell separation below about {}.",
                weight(preload),
                format::engineering(least, "N"),
                weight(preload - least)
            ),
            Parting::Leaves => {
                format!(
                    "The pin leaves its support in these records, under a preload of {}.",
                    weight(preload)
                )
            }
            Parting::Untold => format!(
                "These records do not tell whether the pin leaves its support under a preload of {}: by the numbers at least {} press \
                 on it, but the normal force is not known well enough.",
                weight(preload),
                format::engineering(least, "N")
            ),
        };
        let mut blocks = vec![Block::Text(text)];
        if !self.separation.is_empty() {
            blocks.push(Block::Text("By a model of the rig, both amplitudes held:".to_owned()));
            blocks.push(Block::Table(self.separation_table()));
        }
        if let Some(slap) = self.slap {
            blocks.push(Block::Text(format!(
                "Under {} the model’s pin leaves its support {} in {}, and comes back; impacts take {}.",
                weight(slap.preload),
                format::count(slap.partings, "time"),
                format::engineering(slap.time.last().copied().unwrap_or(0.0), "s"),
                format::engineering(slap.impact_energy, "J")
            )));
            blocks.push(Block::Plots(vec![super::figures::slap(slap)]));
        }
        blocks
    }

    fn method(&self) -> String {
        let [tangential, normal, ..] =
            self.found.by_modulus.map(|change| format::significant(100.0 * change, 2));
        format!(
            "The forces are those that make the rig without its contact move as measured: receptances inverted, for all records \
             together, so that errors of the gains are told from the forces. Young’s modulus 0.1\u{a0}% larger changes the tangential \
             force by {tangential}\u{a0}%, the normal by {normal}\u{a0}%. Means are left out of the figures: accelerometers show none."
        )
    }

    fn chain(&self) -> Vec<Block> {
        crate::identification::chain_blocks(&self.found.inversion, &self.found.rig)
    }

    fn unidentified(&self) -> Vec<Block> {
        let text =
            |one: &stickslip::identify::Unidentified| Block::Text(format!("{}: {}.", one.name, one.reason));
        self.found.unidentified.iter().map(text).collect()
    }

    fn skipped(&self) -> Vec<Block> {
        let text = |(record, reason): &(String, String)| Block::Text(format!("{record}: {reason}."));
        self.found.skipped.iter().map(text).collect()
    }
}
