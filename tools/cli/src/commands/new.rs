//! `stickslip new`

use std::path::PathBuf;

use stickslip_readers::read_model;

use super::{list, shown};
use crate::Failure;
use crate::output::{Folder, Outputs};

/// A model, and the header of the records that it is compared with.
const KINDS: [(&str, &str, &str); 4] = [
    ("contact", include_str!("../../templates/contact.toml"), "time [s],displacement [m],force [N]"),
    (
        "oscillator",
        include_str!("../../templates/oscillator.toml"),
        "time [s],excitation:m1 [N],acceleration:m1 [m/s^2],acceleration:m2 [m/s^2]",
    ),
    (
        "beam",
        include_str!("../../templates/beam.toml"),
        "time [s],excitation [N],acceleration:x=0.55 [m/s^2]",
    ),
    (
        "pin_rig",
        include_str!("../../templates/pin_rig.toml"),
        "time [s],excitation [N],acceleration:x=0.55 [m/s^2]",
    ),
];
const DATASET: &str = include_str!("../../templates/dataset.toml");
/// The file that the template of a dataset lists.
const RECORD: &str = "record-1.csv";

/// Arguments of `stickslip new`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip new beam -o beam.toml
  stickslip new contact -o joint.toml --template data

The numbers are those of steel and of common contacts: replace them. `stickslip check joint.toml data` says what they mean.
Exit codes: 0 done; 1 failed; 2 bad input.")]
pub struct New {
    /// What the contact is attached to
    #[arg(value_parser = KINDS.map(|(name, ..)| name))]
    kind: String,
    /// The model file; `-` for standard output
    #[arg(short, long, value_name = "MODEL.toml", default_value = "-")]
    out: PathBuf,
    /// Also make a folder for measurements, with a dataset.toml and the header of a record
    #[arg(long, value_name = "DIR")]
    template: Option<PathBuf>,
}

impl New {
    /// Writes the files.
    pub fn run(self) -> Result<(), Failure> {
        let known = KINDS.iter().find(|(name, ..)| *name == self.kind);
        let (_, model, header) =
            known.ok_or_else(|| Failure::input(format!("there is no kind `{}`", self.kind)))?;
        // A file that the user has worked on is never replaced.
        if self.out.exists() {
            return Err(Failure::input(format!(
                "{} is there already; name another file",
                self.out.display()
            )));
        }
        Outputs::check([&self.out], &[] as &[PathBuf])?;
        let folder = self.template.as_deref().map(Folder::check).transpose()?;
        let mut outputs = Outputs::default();
        outputs.add(&self.out, *model);
        let mut written = outputs.write()?;
        if let (Some(folder), Some(path)) = (folder, self.template) {
            folder.write(&[
                ("dataset.toml".to_owned(), DATASET.to_owned()),
                (RECORD.to_owned(), format!("{header}\n")),
            ])?;
            written.push(path);
        }
        if let Some(path) = written.iter().find(|path| path.extension().is_some_and(|end| end == "toml")) {
            read_model(path).map_err(shown)?;
        }
        list(&written)
    }
}
