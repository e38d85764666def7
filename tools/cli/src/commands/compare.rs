//! `stickslip compare`

use std::path::PathBuf;

use stickslip::diagnose::{Comparison, evaluate, refit};

use super::{check_destinations, dataset_files, list, present, read_dataset, read_model, settings, watched};
use crate::output::Outputs;
use crate::{Failure, ResultFiles};

/// Arguments of `stickslip compare`.
#[derive(clap::Args)]
pub struct Compare {
    /// The model file, or an FMU that carries one
    model: PathBuf,
    /// The dataset: `dataset.toml` or the folder that holds it
    dataset: PathBuf,
    /// Compare the model as it is; do not refit it
    #[arg(long)]
    no_fit: bool,
    /// Write the refitted model
    #[arg(short, long, value_name = "NEW.toml", conflicts_with = "no_fit")]
    out: Option<PathBuf>,
    #[command(flatten)]
    files: ResultFiles,
}

impl Compare {
    /// Compares.
    pub fn run(self) -> Result<(), Failure> {
        check_destinations(&self.files)?;
        self.out.iter().try_for_each(|path| Outputs::check(path))?;
        let model = read_model(&self.model)?;
        let dataset = read_dataset(&self.dataset, &model)?;
        let baseline = evaluate("baseline", &model, &dataset);
        let mut stages = vec![baseline];
        let mut outputs = Outputs::default();
        if !self.no_fit {
            let (refitted, stage) = watched("refitting", |watch| refit("refitted", &model, &dataset, watch))
                .map_err(|error| Failure::other(format!("the refit failed: {error}")))?;
            stages.push(stage);
            if let Some(path) = &self.out {
                outputs.add(path, refitted.to_toml());
            }
        }
        let title = dataset.title.clone().unwrap_or_else(|| self.dataset.display().to_string());
        let mut read = vec![self.model.clone()];
        read.extend(dataset_files(&self.dataset, &dataset));
        let settings = settings(&read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let comparison = Comparison { title, records: dataset.records, stages };
        present(&comparison, &settings, &self.files, &mut outputs)?;
        list(&outputs.write()?);
        Ok(())
    }
}
