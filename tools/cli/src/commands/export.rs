//! `stickslip export`

use std::path::{Path, PathBuf};

use serde_json::json;
use stickslip::fmi::Instance;
use stickslip_fmu_package::{FmiVersion, Stamp, write_stamped_fmu};

use super::{check_destinations, list, read_model};
use crate::output::Outputs;
use crate::{Failure, ResultFiles};

/// Arguments of `stickslip export`.
#[derive(clap::Args)]
pub struct Export {
    /// The model file, or an FMU that carries one
    model: PathBuf,
    /// The FMU to write; its name becomes the model identifier
    #[arg(short, long, value_name = "X.fmu")]
    out: PathBuf,
    /// Version of FMI
    #[arg(long, value_name = "VERSION", value_parser = fmi_version, default_value = "2")]
    fmi: FmiVersion,
    /// Who made the FMU, for its description; the authors of this program where it is not given
    #[arg(long, value_name = "NAME")]
    author: Option<String>,
    /// When it was made, in UTC; that of this version where it is not given, so that the same model gives the same bytes
    #[arg(long, value_name = "2026-12-01T10:30:00Z")]
    date: Option<String>,
    #[command(flatten)]
    files: ResultFiles,
}

impl Export {
    /// Writes the FMU; with `--json` its variables as data, with `--report` its documentation page.
    pub fn run(self) -> Result<(), Failure> {
        check_destinations(&self.files, [&self.out], &[&self.model])?;
        let text = read_model(&self.model)?.to_toml();
        let name = model_identifier(&self.out)?;
        let failed = |error: stickslip_fmu_package::Error| Failure::input(format!("{error}"));
        let mut outputs = Outputs::default();
        let stamp = Stamp::new(self.author.as_deref(), self.date.as_deref()).map_err(failed)?;
        outputs.add(&self.out, write_stamped_fmu(self.fmi, &name, &text, &stamp).map_err(failed)?);
        let instance = Instance::new(&text).map_err(|error| Failure::input(format!("{error}")))?;
        let description = instance.description();
        if let Some(path) = &self.files.report {
            outputs.add(path, stickslip_fmu_package::documentation_html(self.fmi, &name, description, &text));
        }
        if let Some(path) = &self.files.json {
            let variables: Vec<_> = description
                .variables
                .iter()
                .map(|variable| {
                    json!({
                        "name": variable.name,
                        "causality": format!("{:?}", variable.causality).to_lowercase(),
                        "unit": variable.quantity.unit,
                        "description": variable.description,
                    })
                })
                .collect();
            let export = json!({
                "schema": "stickslip.export/1",
                "fmu": self.out,
                "fmi_version": self.fmi.number(),
                "model_identifier": name,
                "guid": description.guid().to_string(),
                "variables": variables,
            });
            outputs.add(path, format!("{export:#}\n"));
        }
        list(&outputs.write()?)
    }
}

/// A version as the user writes it.
pub fn fmi_version(text: &str) -> Result<FmiVersion, String> {
    match text {
        "2" | "2.0" => Ok(FmiVersion::Two),
        "3" | "3.0" => Ok(FmiVersion::Three),
        _ => Err("FMUs are written for FMI 2 and 3".to_owned()),
    }
}

/// The file's name without `.fmu`.
fn model_identifier(path: &Path) -> Result<String, Failure> {
    match (path.extension().and_then(|end| end.to_str()), path.file_stem().and_then(|stem| stem.to_str())) {
        (Some("fmu"), Some(stem)) => Ok(stem.to_owned()),
        _ => Err(Failure::input(format!("{} should end in .fmu", path.display()))),
    }
}
