//! `stickslip identify`: a contact behind a beam here, one in two directions in `slip_slap`, its stiffness from frequencies in
//! `stiffness`.

mod slip_slap;
mod stiffness;

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use stickslip::data::{Dataset, Regime};
use stickslip::identify::{
    ContactPeriod, Identification, IdentificationError, IdentifyOptions, ModeCount, identify,
};
use stickslip::model::{Model, Structure};
use stickslip_report::identification::{
    IdentificationReport, identification_html, identification_json, identification_table,
};

use super::{
    check_destinations, colored, dataset_file, list, read_model, read_records, settings, tables, title_of,
};
use crate::output::{Outputs, say};
use crate::{Failure, LoneFile, ResultFiles, progress};

/// Rows of a table of the contact, over one period.
const ROWS: usize = 512;

/// Arguments of `stickslip identify`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip identify beam.toml data/ --report contact.html --csv contact/
  stickslip identify beam.toml data/ --fit level-70 --json contact.json -o identified.toml
  stickslip identify beam.toml level-70.csv --regime steady --csv contact/
  stickslip identify rig.toml data/ --report both.html --csv contact/ --separation
  stickslip identify rig.toml --frequencies 52.79,164.4,335.9
  stickslip export identified.toml -o Support.fmu

Steady records give the contact's force and motion, all of them together; laws are fitted to some of them and predict the
others. Records under random excitation give the linear modes, free decays and backbone tables the resonance over the
amplitude. The law of the model's own contact is not used, its normal
load is. Of a pin rig dual-mode records give both forces of its contact, without laws, and natural frequencies the stiffness
of its contact as far as they tell it.

Exit codes: 0 done; 1 failed, such as a record of --fit that cannot be inverted; 2 bad input (nothing is written); 130 interrupted by Ctrl-C (nothing is written).")]
pub struct Identify {
    /// The model file of a beam or a pin rig, or an FMU that carries one
    model: PathBuf,
    /// The dataset: `dataset.toml`, the folder that holds it, or a file of measurements (see `stickslip import`)
    #[arg(required_unless_present = "frequencies")]
    dataset: Option<PathBuf>,
    /// Instead of a dataset, of a pin rig: the first natural frequencies of the beam's own modes (Hz), the contact sticking; at
    /// least three
    #[arg(long, value_name = "HZ,...", value_delimiter = ',', value_parser = positive, conflicts_with_all = OF_RECORDS)]
    frequencies: Vec<f64>,
    /// Standard deviation of each of the frequencies (1)
    #[arg(long, value_name = "PART", default_value_t = 1e-3, value_parser = positive, conflicts_with = "dataset")]
    frequency_error: f64,
    /// Standard deviation of Young's modulus in the model (1), with --frequencies
    #[arg(long, value_name = "PART", default_value_t = 5e-3, value_parser = positive, conflicts_with = "dataset")]
    modulus_error: f64,
    /// Fit laws to these records and predict the others; the one with the largest motion if not given
    #[arg(long, value_name = "RECORD,...", value_delimiter = ',')]
    fit: Vec<String>,
    /// Standard deviation of the gain of every sensor (1)
    #[arg(long, value_name = "PART", default_value_t = 0.01, value_parser = not_negative)]
    sensor_gain: f64,
    /// Standard deviation of the gain of the load cell (1)
    #[arg(long, value_name = "PART", default_value_t = 0.01, value_parser = not_negative)]
    excitation_gain: f64,
    /// Standard deviation of the mass at every sensor (kg)
    #[arg(long, value_name = "MASS", default_value_t = 0.0, value_parser = not_negative)]
    sensor_mass: f64,
    /// Modes of the beam, the rest following statically, or `model` for what the model file says; whichever of 30 and the
    /// model file explains the records better if not given
    #[arg(long, value_name = "COUNT")]
    modes: Option<Modes>,
    /// Harmonics at most; fewer where the rest lies within the noise
    #[arg(long, value_name = "COUNT", default_value_t = 15, value_parser = clap::value_parser!(u16).range(1..=60))]
    harmonics: u16,
    /// Normal load (N) in place of the model's
    #[arg(long, value_name = "LOAD", value_parser = positive)]
    normal_load: Option<f64>,
    /// Write the contact's motion and force over one period of every steady record, `RECORD-contact.csv`, to this folder
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    /// Write the model with the law that predicts best
    #[arg(short, long, value_name = "NEW.toml")]
    out: Option<PathBuf>,
    /// Of a pin rig, search on its model, contact included, the preload below which the pin leaves its support
    #[arg(long)]
    separation: bool,
    #[command(flatten)]
    lone: LoneFile,
    #[command(flatten)]
    files: ResultFiles,
}

/// `--modes`.
#[derive(Clone, Copy)]
struct Modes(ModeCount);

impl std::str::FromStr for Modes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let count = || text.parse().ok().filter(|count| (3..=60).contains(count)).map(ModeCount::Fixed);
        let modes = if text == "model" { Some(ModeCount::Model) } else { count() };
        modes.map(Modes).ok_or_else(|| "a number from 3 to 60, or `model`, is expected".to_owned())
    }
}

/// What takes records, or a law.
const OF_RECORDS: [&str; 14] = [
    "dataset",
    "fit",
    "sensor_gain",
    "excitation_gain",
    "sensor_mass",
    "modes",
    "harmonics",
    "normal_load",
    "csv",
    "out",
    "separation",
    "report",
    "columns",
    "regime",
];

fn positive(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok().filter(|number: &f64| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "a positive number is expected".to_owned())
}

fn not_negative(text: &str) -> Result<f64, String> {
    let number: Option<f64> = text.parse().ok().filter(|number: &f64| number.is_finite() && *number >= 0.0);
    number.ok_or_else(|| "a number that is not negative is expected".to_owned())
}

impl Identify {
    /// Identifies.
    pub fn run(self) -> Result<(), Failure> {
        let Some(source) = self.dataset.as_deref() else { return self.run_stiffness() };
        check_destinations(&self.files, &self.out, &[self.model.clone(), dataset_file(source)])?;
        let model = read_model(&self.model)?;
        let (dataset, notes, files) = read_records(source, &model, &self.lone)?;
        let data = title_of(&dataset, source);
        let mut read = vec![self.model.clone()];
        read.extend(files);
        self.check_tables(&dataset, &read)?;
        let settings = settings(&read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        if let Structure::PinRig(pinned) = &model.structure {
            return self.run_slip_slap((&model, pinned), (&dataset, &data, &notes), &settings);
        }
        if self.separation {
            return Err(Failure::input("--separation: the model's kind must be \"pin_rig\""));
        }
        let Some(found) = self.found(&model, &dataset)? else { return Ok(()) };
        let title = format!("Contact identified: {data}");
        let report = IdentificationReport { title, found: &found, notes: &notes };
        say(&identification_table(&report, 100, colored()))?;
        let mut outputs = Outputs::default();
        if let Some(path) = &self.files.json {
            outputs.add(path, format!("{:#}\n", identification_json(&report)));
        }
        if let Some(path) = &self.files.report {
            outputs.add(path, identification_html(&report, &settings));
        }
        self.add_tables(&found, &mut outputs)?;
        if let Some((path, new)) = self.out.as_ref().zip(found.model.as_ref()) {
            outputs.add(path, new.to_toml());
        }
        list(&outputs.write()?)?;
        match &self.out {
            Some(path) if found.model.is_none() => Err(Failure::other(format!(
                "no law describes the contact: {} was not written",
                path.display()
            ))),
            _ => Ok(()),
        }
    }

    /// What the records tell; `None` after an interrupt.
    fn found(&self, model: &Model, dataset: &Dataset) -> Result<Option<Identification>, Failure> {
        let bar = progress::spinner("identify");
        let found = identify(model, dataset, &self.options());
        bar.finish_and_clear();
        if progress::interrupted() {
            tell!("note: interrupted; nothing was written");
            return Ok(None);
        }
        found.map(Some).map_err(failure)
    }

    fn options(&self) -> IdentifyOptions<'static> {
        IdentifyOptions {
            excitation_gain: self.excitation_gain,
            sensor_gain: self.sensor_gain,
            sensor_mass: self.sensor_mass,
            modes: self.modes.map_or(IdentifyOptions::default().modes, |modes| modes.0),
            harmonics: self.harmonics.into(),
            fitted: self.fit.clone(),
            normal_load: self.normal_load,
            interrupt: Some(&progress::interrupted),
        }
    }

    /// Refuses tables that could not be written, before any work; their folder may still be missing.
    fn check_tables(&self, dataset: &Dataset, inputs: &[PathBuf]) -> Result<(), Failure> {
        let steady = dataset.records.iter().filter(|record| record.regime == Regime::Steady);
        let folder = self.csv.as_deref();
        let all =
            folder.into_iter().flat_map(|folder| steady.clone().map(|record| table_of(folder, &record.name)));
        tables::check(&self.files, &self.out, folder, all, inputs)
    }

    /// The folder of `--csv`, made where it is missing.
    fn table_folder(&self) -> Result<Option<&Path>, Failure> {
        let Some(folder) = &self.csv else { return Ok(None) };
        tables::made(folder).map(Some)
    }

    fn add_tables(&self, found: &Identification, outputs: &mut Outputs) -> Result<(), Failure> {
        let Some(inversion) = &found.inversion else { return Ok(()) };
        let Some(folder) = self.table_folder()? else { return Ok(()) };
        for (record, period) in found.records.iter().zip(&inversion.periods) {
            outputs.add(&table_of(folder, &record.name), table(period));
        }
        Ok(())
    }
}

fn failure(error: IdentificationError) -> Failure {
    match error {
        IdentificationError::NotIdentified { .. } => Failure::other(error.to_string()),
        IdentificationError::Failed(message) => Failure::input(message),
    }
}

fn table_of(folder: &Path, record: &str) -> PathBuf {
    tables::table_of(folder, record, "contact")
}

/// One period, its end left out, in the record's own time.
fn table(period: &ContactPeriod) -> String {
    let duration = TAU / period.angular_frequency;
    let mut text = String::from("time [s],displacement [m],velocity [m/s],force [N]\n");
    for row in 0..ROWS {
        let time = duration * row as f64 / ROWS as f64;
        let [displacement, velocity, force] = period.at(time);
        let _ = writeln!(text, "{time:.9e},{displacement:.9e},{velocity:.9e},{force:.9e}");
    }
    text
}
