//! Both forces of a contact that slips and slaps.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use stickslip::data::Dataset;
use stickslip::identify::{ContactPeriod, IdentificationError, SlipSlapIdentification, identify_slip_slap};
use stickslip::model::{Model, PinnedBeam};
use stickslip::rig::{DualMode, RigError, Separation, Slap, separation_of, slap_in_time};
use stickslip::system::PinRig;
use stickslip_report::Settings;
use stickslip_report::slip_slap::{SlipSlapReport, slip_slap_html, slip_slap_json, slip_slap_table};

use super::{Identify, ROWS, failure, table_of};
use crate::commands::{colored, list};
use crate::output::{Outputs, say};
use crate::{Failure, progress};

/// The preload, as a part of that below which the pin parts, under which it is shown to slap; for so many periods.
const BELOW: f64 = 0.8;
/// The highest harmonic that a dual-mode test holds.
const HELD: u16 = 3;
const PERIODS: usize = 10;

/// What is written of each direction where it is identified: the names under which it may not be, and its column.
const COLUMNS: [(&str, &str); 5] = [
    ("tangential_displacement", "displacement [m]"),
    ("tangential_displacement", "velocity [m/s]"),
    ("tangential_force", "force [N]"),
    ("normal_displacement", "normal_displacement [m]"),
    ("normal_force", "normal_force [N]"),
];

impl Identify {
    /// Identifies both forces at the pin of `model`.
    pub(super) fn run_slip_slap(
        &self,
        (model, pinned): (&Model, &PinnedBeam),
        (dataset, data, notes): (&Dataset, &str, &[String]),
        settings: &Settings,
    ) -> Result<(), Failure> {
        self.refuse_laws()?;
        if self.harmonics < HELD {
            return Err(Failure::input(format!(
                "--harmonics: a dual-mode test holds the first and the third, so that at least {HELD} are needed"
            )));
        }
        let Some(found) = self.found_slip_slap(model, pinned, dataset)? else { return Ok(()) };
        let (separation, slap) = match self.separation {
            true => match separated(model, &found)? {
                Some((separation, slap)) => (separation, slap),
                None => return Ok(()),
            },
            false => (Vec::new(), None),
        };
        let report = SlipSlapReport {
            title: format!("Contact in two directions identified: {data}"),
            found: &found,
            truth: &[],
            separation: &separation,
            slap: slap.as_ref(),
            notes,
        };
        say(&slip_slap_table(&report, 100, colored()))?;
        let mut outputs = Outputs::default();
        if let Some(path) = &self.files.json {
            outputs.add(path, format!("{:#}\n", slip_slap_json(&report)));
        }
        if let Some(path) = &self.files.report {
            outputs.add(path, slip_slap_html(&report, settings));
        }
        self.add_slip_slap_tables(&found, &mut outputs)?;
        list(&outputs.write()?)
    }

    /// Laws are fitted to one direction alone.
    fn refuse_laws(&self) -> Result<(), Failure> {
        let refuse = |option: &str| {
            Err(Failure::input(format!(
                "{option}: no law is fitted to a contact in two directions; compare the forces found with those of a model"
            )))
        };
        match (&self.out, self.fit.is_empty()) {
            (Some(_), _) => refuse("--out"),
            (None, false) => refuse("--fit"),
            (None, true) => Ok(()),
        }
    }

    /// What the records tell; `None` after an interrupt.
    fn found_slip_slap(
        &self,
        model: &Model,
        pinned: &PinnedBeam,
        dataset: &Dataset,
    ) -> Result<Option<SlipSlapIdentification>, Failure> {
        let contact = model.contact.as_ref().ok_or_else(|| Failure::input("the model has no contact"))?;
        let rig = rig_of(model, pinned)?;
        let mut options = self.options();
        options.normal_load = options.normal_load.or(Some(contact.normal_load));
        let bar = progress::spinner("identify");
        let found = identify_slip_slap(&rig, dataset, &options);
        bar.finish_and_clear();
        if progress::interrupted() {
            tell!("note: interrupted; nothing was written");
            return Ok(None);
        }
        found.map(Some).map_err(|error: IdentificationError| failure(error))
    }

    /// One period of every record, without what is not identified.
    fn add_slip_slap_tables(
        &self,
        found: &SlipSlapIdentification,
        outputs: &mut Outputs,
    ) -> Result<(), Failure> {
        let Some(folder) = self.table_folder()? else { return Ok(()) };
        let told: Vec<usize> = (0..COLUMNS.len())
            .filter(|column| found.unidentified.iter().all(|one| one.name != COLUMNS[*column].0))
            .collect();
        for column in (0..COLUMNS.len()).filter(|column| !told.contains(column)) {
            let (name, column) = COLUMNS[column];
            let reason = found.unidentified.iter().find(|one| one.name == name).map(|one| &*one.reason);
            tell!("note: the tables leave out `{column}`: {}", reason.unwrap_or_default());
        }
        let periods = found.inversion.periods.iter().zip(&found.inversion.normal);
        for (record, (along, across)) in found.records.iter().zip(periods) {
            let table = table([along, across], found.preload, &told);
            outputs.add(&table_of(folder, &record.name), table);
        }
        Ok(())
    }
}

/// The rig with the contact's springs.
pub(super) fn rig_of(model: &Model, pinned: &PinnedBeam) -> Result<PinRig, Failure> {
    let rig = pinned.rig(model.contact.as_ref(), &model.changes().structure);
    rig.map_err(|error| Failure::input(error.to_string()))
}

/// One period, its end left out, in the record's own time: the columns `told`.
fn table([along, across]: [&ContactPeriod; 2], preload: f64, told: &[usize]) -> String {
    let duration = TAU / along.angular_frequency;
    let names: Vec<&str> = told.iter().map(|column| COLUMNS[*column].1).collect();
    let mut text = format!("time [s],{}\n", names.join(","));
    for row in 0..ROWS {
        let time = duration * row as f64 / ROWS as f64;
        let [displacement, velocity, force] = along.at(time);
        let [opening, _, lacking] = across.at(time);
        // As in records: positive where the contact closes.
        let all = [displacement, velocity, force, -opening, preload - lacking];
        let _ = write!(text, "{time:.9e}");
        for column in told {
            let _ = write!(text, ",{:.9e}", all[*column]);
        }
        text.push('\n');
    }
    text
}

/// Below which preload the model's pin leaves its support at the levels of the records, and the slap under a smaller one at
/// the last of them; `None` after an interrupt.
type Separated = (Vec<Separation>, Option<Slap>);

fn separated(model: &Model, found: &SlipSlapIdentification) -> Result<Option<Separated>, Failure> {
    let tests: Vec<DualMode> = found
        .records
        .iter()
        .map(|record| DualMode::at(record.frequency, vec![record.accelerations]))
        .collect();
    let model = model.clone();
    let work = move || -> Result<Separated, RigError> {
        let mut all = Vec::new();
        for test in &tests {
            all.extend(separation_of(&model, test)?);
        }
        let last = all.last().zip(tests.last());
        let slap = last.and_then(|(one, test)| Some((one.onset?, one.forces, test)));
        let slap = slap.map(|(onset, forces, test)| {
            slap_in_time(&model.under_preload(BELOW * onset).system()?, forces, test, PERIODS)
        });
        Ok((all, slap.transpose()?))
    };
    let bar = progress::spinner("separation");
    let found = progress::left_when_interrupted(work)?;
    bar.finish_and_clear();
    match found {
        None => {
            tell!("note: interrupted; nothing was written");
            Ok(None)
        }
        Some(found) => found.map(Some).map_err(|error| Failure::other(format!("--separation: {error}"))),
    }
}
