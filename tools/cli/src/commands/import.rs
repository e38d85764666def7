//! `stickslip import`

use std::path::PathBuf;

use stickslip::data::{Dataset, Regime};
use stickslip_readers::{ColumnRule, ImportOptions, dataset_toml, import_file, record_csv};

use super::shown;
use crate::Failure;
use crate::output::{Folder, say};

/// Arguments of `stickslip import`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip import messung.txt -o data
  stickslip import run1.csv run2.csv -o data --column 'AI0=force [kN]'
  stickslip import series.tdms -o data --regime steady --column 'AI1=-acceleration:x=0.55 [g]'

What was guessed is shown, and written into dataset.toml.
Exit codes: 0 done; 1 failed; 2 bad input. Where it is not 0 nothing is written.")]
pub struct Import {
    /// Tables, as a laboratory exports them: CSV and other text, MAT, HDF5, UFF 58, TDMS, Parquet
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Folder for dataset.toml and a CSV file per record; made, or empty
    #[arg(short, long, value_name = "DIR")]
    out: PathBuf,
    /// What a column is: its heading, or its number from 1, and `name [unit]`, with a minus before it where the sign is to be
    /// turned; may be given several times
    #[arg(long = "column", value_name = "HEADING=NAME [UNIT]", value_parser = column)]
    columns: Vec<(String, ColumnRule)>,
    /// How all records begin, or which table they are
    #[arg(long, value_name = "REGIME", value_parser = regime)]
    regime: Option<Regime>,
    /// Samples in a second (Hz), of files without time stamps
    #[arg(long, value_name = "HZ", value_parser = rate)]
    sample_rate: Option<f64>,
}

/// A sample rate (Hz).
pub fn rate(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|rate: &f64| *rate > 0.0 && rate.is_finite())
        .ok_or_else(|| "write a number of hertz above zero".to_owned())
}

/// `HEADING=NAME [UNIT]`, the sign turned by a minus before the name.
pub fn column(text: &str) -> Result<(String, ColumnRule), String> {
    let (heading, name) = text.split_once('=').ok_or("write HEADING=NAME [UNIT]")?;
    let name = name.trim();
    let rule = match name.strip_prefix('-') {
        Some(name) => ColumnRule { factor: -1.0, ..ColumnRule::of(name.trim()) },
        None => ColumnRule::of(name),
    };
    Ok((heading.trim().to_owned(), rule))
}

/// A regime as `dataset.toml` spells it.
pub fn regime(text: &str) -> Result<Regime, String> {
    stickslip_readers::regime(text)
        .ok_or_else(|| format!("legal are {}", stickslip_readers::regimes().join(", ")))
}

impl Import {
    /// Reads all files and writes the dataset.
    pub fn run(self) -> Result<(), Failure> {
        let folder = Folder::check(&self.out)?;
        let options = ImportOptions {
            columns: self.columns,
            regime: self.regime,
            sample_rate: self.sample_rate,
            ..ImportOptions::default()
        };
        let mut records = Vec::new();
        let mut told = String::new();
        for path in &self.files {
            let imported = import_file(path, &options).map_err(shown)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            for note in &imported.notes {
                told += &format!("{name}: {note}\n");
            }
            for record in imported.records {
                if records.iter().any(|other: &stickslip::data::Record| other.name == record.name) {
                    let message = format!("two files would become {}; rename one of them", record.name);
                    return Err(Failure::input(message));
                }
                records.push(record);
            }
        }
        let dataset = Dataset { title: None, records };
        let mut files = vec![("dataset.toml".to_owned(), commented(&told) + &dataset_toml(&dataset))];
        files.extend(dataset.records.iter().map(|record| (record.name.clone(), record_csv(record))));
        folder.write(&files)?;
        let count = dataset.records.len();
        let records = if count == 1 { "record" } else { "records" };
        say(&format!("{told}wrote {} with {count} {records}\n", self.out.display()))
    }
}

/// The notes as comments; a control character in a heading must not end one.
fn commented(notes: &str) -> String {
    let plain = |line: &str| line.replace(|letter: char| letter.is_control() && letter != '\t', " ");
    notes.lines().map(|line| format!("# {}\n", plain(line))).collect()
}
