//! `stickslip compare`

use std::path::PathBuf;

use stickslip::diagnose::{Comparison, evaluate, noise_of};
use stickslip::model::Model;

use super::{
    Measured, check_destinations, checked, colored, dataset_file, list, present, read_measured, read_model,
    refitted, settings, tables, title_of, unused,
};
use crate::output::{Outputs, say};
use crate::{Failure, LoneFile, ResultFiles};

/// Arguments of `stickslip compare`.
#[derive(clap::Args)]
pub struct Compare {
    /// The model file, or an FMU that carries one
    model: PathBuf,
    /// The dataset: `dataset.toml`, the folder that holds it, or a file of measurements (see `stickslip import`)
    dataset: PathBuf,
    /// Compare the model as it is; do not refit it
    #[arg(long)]
    no_fit: bool,
    /// Show the error at each harmonic of records that repeat
    #[arg(long)]
    harmonics: bool,
    /// Write the refitted model
    #[arg(short, long, value_name = "NEW.toml", conflicts_with = "no_fit")]
    out: Option<PathBuf>,
    /// Write measured, predicted and residual values of every record, `RECORD-compared.csv`, to this folder
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    lone: LoneFile,
    #[command(flatten)]
    files: ResultFiles,
}

impl Compare {
    /// Compares.
    pub fn run(self) -> Result<(), Failure> {
        check_destinations(&self.files, &self.out, &[self.model.clone(), dataset_file(&self.dataset)])?;
        let model = read_model(&self.model)?;
        let Measured { dataset, ring_downs, mut notes, files } =
            read_measured(&self.dataset, &model, &self.lone)?;
        let mut read = vec![self.model.clone()];
        read.extend(files);
        let folder = self.csv.as_deref();
        tables::check(&self.files, &self.out, folder, tables::compared(folder, &dataset.records), &read)?;
        notes.extend(unused(&model, &dataset));
        let findings = checked(&model, &dataset);
        let noise = noise_of(&model, &dataset);
        let baseline = evaluate("baseline", &model, &dataset);
        let mut stages = vec![baseline];
        let mut outputs = Outputs::default();
        if self.fits(&model)
            && let Some(done) = refitted("refitted", &model, &dataset)?
        {
            stages.push(done.stage);
            if let Some(path) = &self.out {
                outputs.add(path, done.model.to_toml());
            }
        }
        let title = title_of(&dataset, &self.dataset);
        let settings = settings(&read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let comparison = Comparison { title, records: dataset.records, ring_downs, findings, notes, stages };
        present(&comparison, &noise, &[], &settings, &self.files, &mut outputs)?;
        tables::add(folder, &comparison, &mut outputs)?;
        if self.harmonics {
            say(&stickslip_report::harmonic_text(&comparison, 80, colored()))?;
        }
        list(&outputs.write()?)?;
        if comparison.stages.iter().all(|stage| stage.error.is_nan()) {
            return Err(Failure::other("no record can be predicted"));
        }
        Ok(())
    }

    /// Whether there is something to refit. A model with nothing free is compared as it is, unless its
    /// refitted form is asked for.
    fn fits(&self, model: &Model) -> bool {
        let nothing_free = !model.parameters().iter().any(|parameter| parameter.free);
        if !self.no_fit && self.out.is_none() && nothing_free {
            tell!("note: nothing is free in `[fit] free`; the model is compared as it is");
            return false;
        }
        !self.no_fit
    }
}
