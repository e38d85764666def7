//! `stickslip check`

use std::path::PathBuf;

use stickslip::data::{Dataset, Record};
use stickslip::diagnose::{NoiseSource, noise_of};
use stickslip::fit::FitError;
use stickslip::fit::checks::{check, natural_frequencies};
use stickslip::fit::compare::{Shown, Visibility, visibility};
use stickslip::model::{Model, Structure};
use stickslip_report::check::{CheckReport, Fact, check_json, check_table};

use super::{Measured, check_destinations, colored, dataset_file, list, read_measured, read_model};
use crate::output::{Outputs, say};
use crate::{Failure, LoneFile, ResultFiles, progress};

/// Natural frequencies that are shown.
const FREQUENCIES: usize = 6;

/// Arguments of `stickslip check`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip check model.toml
  stickslip check model.toml data --json checked.json

Exit codes: 0 nothing is wrong; 1 something is, and it is named; 2 bad input; 130 interrupted by Ctrl-C.")]
pub struct Check {
    /// The model file, or an FMU that carries one
    model: PathBuf,
    /// What it is to be compared with: `dataset.toml`, its folder, or a file of measurements
    dataset: Option<PathBuf>,
    #[command(flatten)]
    lone: LoneFile,
    /// Write the results as JSON; `-` for standard output, and nothing else there
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

impl Check {
    /// Looks at the model, and at the data beside it. The exit code.
    pub fn run(self) -> Result<u8, Failure> {
        let files = ResultFiles { json: self.json.clone(), report: None };
        let mut inputs = vec![self.model.clone()];
        inputs.extend(self.dataset.as_deref().map(dataset_file));
        check_destinations(&files, &None, &inputs)?;
        let model = read_model(&self.model)?;
        let measured =
            self.dataset.as_deref().map(|path| read_measured(path, &model, &self.lone)).transpose()?;
        let empty = Dataset { title: None, records: Vec::new() };
        let dataset = measured.as_ref().map_or(&empty, |measured| &measured.dataset);
        let bar = progress::spinner("check");
        let shown = visibility(&model, dataset, Some(&progress::interrupted));
        bar.finish_and_clear();
        let shown = match shown {
            Err(FitError::Interrupted) => {
                return Err(Failure { code: 130, message: "interrupted".to_owned() });
            }
            Err(error) => return Err(Failure::other(error.to_string())),
            Ok(shown) if measured.is_some() => shown,
            Ok(_) => Shown::default(),
        };
        let report = CheckReport {
            title: self.model.display().to_string(),
            facts: facts(&model),
            findings: check(&model, dataset),
            data: measured.as_ref().map(|_| data(&model, dataset)).unwrap_or_default(),
            limits: measured
                .as_ref()
                .map(|measured| limits(&model, measured, &shown.parameters))
                .unwrap_or_default(),
            visible: shown.parameters,
            skipped: shown.skipped,
        };
        say(&check_table(&report, 80, colored()))?;
        let mut outputs = Outputs::default();
        if let Some(path) = &self.json {
            outputs.add(path, format!("{:#}\n", check_json(&report)));
        }
        list(&outputs.write()?)?;
        Ok(u8::from(!report.findings.is_empty() || !report.skipped.is_empty()))
    }
}

/// What the model's numbers come to.
fn facts(model: &Model) -> Vec<Fact> {
    let mut facts = Vec::new();
    if let Some(contact) = &model.contact {
        let limit = contact.friction_coefficient * contact.normal_load;
        facts.push(Fact::new("friction limit", vec![limit], "N"));
        facts.push(Fact::new("slip displacement", vec![limit / contact.tangential_stiffness], "m"));
    }
    if let Some([free, stuck]) = natural_frequencies(model) {
        let first = |all: Vec<f64>| all.into_iter().take(FREQUENCIES).collect();
        if model.contact.is_some() {
            facts.push(Fact::new("natural frequencies, contact free", first(free), "Hz"));
            facts.push(Fact::new("natural frequencies, contact stuck", first(stuck), "Hz"));
        } else {
            facts.push(Fact::new("natural frequencies", first(free), "Hz"));
        }
    }
    facts
}

/// What each record is: length, rate and level.
fn data(model: &Model, dataset: &Dataset) -> Vec<Fact> {
    let mut facts = Vec::new();
    for record in &dataset.records {
        if let Some(time) = record.channel("time").filter(|time| time.values.len() > 1) {
            let (first, last) = (time.values[0], time.values[time.values.len() - 1]);
            facts.push(Fact::new(&format!("{}: length", record.name), vec![last - first], "s"));
            let rate = (time.values.len() - 1) as f64 / (last - first);
            facts.push(Fact::new(&format!("{}: rate", record.name), vec![rate], "Hz"));
        }
        if let (Structure::Prescribed, Some(slips)) = (&model.structure, slips(model, record)) {
            facts.push(Fact::new(
                &format!("{}: motion over the slip displacement", record.name),
                vec![slips],
                "1",
            ));
        }
    }
    facts
}

/// Half of the motion's range over the displacement at which the contact slips.
fn slips(model: &Model, record: &Record) -> Option<f64> {
    let contact = model.contact.as_ref()?;
    let values = &record.channel("displacement")?.values;
    let (low, high) =
        values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
    let slip = contact.friction_coefficient * contact.normal_load / contact.tangential_stiffness;
    Some(0.5 * (high - low) / slip).filter(|ratio| ratio.is_finite())
}

/// What these data cannot show, in sentences.
fn limits(model: &Model, measured: &Measured, shown: &[Visibility]) -> Vec<String> {
    let dataset = &measured.dataset;
    let mut limits = Vec::new();
    for one in shown.iter().filter(|one| one.change == 0.0) {
        limits.push(format!(
            "no prediction depends on `{}` near its value: these data cannot show it",
            one.path
        ));
    }
    if dataset.records.len() < 2 && dataset.records.iter().all(|record| !record.regime.is_table()) {
        limits.push("there is one record: `diagnose` needs a second one to test what it finds on".to_owned());
    }
    let unknown = noise_of(model, dataset).iter().any(|noise| noise.source == NoiseSource::Unknown);
    if unknown {
        limits.push("the noise is unknown: state `noise`, repeat a record, or measure several equal periods; else no verdict can tell noise from error".to_owned());
    }
    if let Structure::Prescribed = model.structure {
        let ratios: Vec<f64> = dataset.records.iter().filter_map(|record| slips(model, record)).collect();
        if !ratios.is_empty() && ratios.iter().all(|ratio| *ratio < 1.0) {
            limits.push(
                "by the model's numbers the contact never slips: its friction limit cannot be seen"
                    .to_owned(),
            );
        }
        let (low, high) = ratios.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), r| (l.min(*r), h.max(*r)));
        if ratios.len() > 1 && high < 1.5 * low {
            limits.push(
                "all records have about the same amplitude: laws that differ from level to level look alike"
                    .to_owned(),
            );
        }
        if dataset.records.iter().all(|record| record.channel("normal_load").is_none()) {
            limits
                .push("the normal load was not measured: a limit that follows it cannot be seen".to_owned());
        }
    }
    limits
}
