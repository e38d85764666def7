//! `stickslip compare`

use std::path::PathBuf;

use stickslip::diagnose::{Comparison, evaluate, refit};

use super::{check_destinations, present, read_dataset, read_model};
use crate::output::Outputs;
use crate::progress::{self, interrupted};
use crate::{Failure, ResultFiles};

/// Arguments of `stickslip compare`.
#[derive(clap::Args)]
pub struct Compare {
    /// The model file
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
            let bar = progress::spinner("refitting");
            let fitted = refit("refitted", &model, &dataset, &mut |evaluations, error| {
                bar.set_message(format!("{evaluations} evaluations, error {error:.4}"));
                !interrupted()
            });
            bar.finish_and_clear();
            let (refitted, stage) =
                fitted.map_err(|error| Failure::other(format!("error: the refit failed: {error}")))?;
            stages.push(stage);
            if let Some(path) = &self.out {
                outputs.add(path, refitted.to_toml());
            }
        }
        let title = dataset.title.clone().unwrap_or_else(|| self.dataset.display().to_string());
        let comparison = Comparison { title, records: dataset.records, stages };
        let settings = super::settings(&[&self.model], &[&self.dataset])?;
        present(&comparison, &settings, &self.files, &mut outputs)?;
        for path in outputs.write()? {
            println!("wrote {}", path.display());
        }
        Ok(())
    }
}
