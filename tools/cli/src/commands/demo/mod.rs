//! `stickslip demo`: models against published measurements, and a contact identified on the virtual rig.

mod unseen;

use std::path::{Path, PathBuf};

use stickslip::diagnose::{Comparison, Stage, evaluate, noise_of};
use stickslip_report::document::Section;

use super::present;
use crate::output::{Outputs, say};
use crate::{Failure, ResultFiles};

/// A file of the example that the program carries inside itself.
macro_rules! example {
    ($file:literal) => {
        include_str!(concat!("../../../../../examples/frictional-support/", $file))
    };
}

/// What the demonstration tries, in this order: name, model file, whether to refit it.
const STAGES: [(&str, &str, bool); 6] = [
    ("linear beam", "linear.toml", false),
    ("linear, refitted", "linear.toml", true),
    ("Valanis, published", "published.toml", false),
    ("Jenkins, refitted", "jenkins.toml", true),
    ("Valanis, refitted", "valanis.toml", true),
    ("Valanis + residual stiffness", "valanis-residual.toml", true),
];

/// The files, as they are written into the folder of results for the user to go on with.
const FILES: [(&str, &str); 11] = [
    ("README.md", example!("README.md")),
    ("dataset.toml", example!("dataset.toml")),
    ("backbone.csv", example!("backbone.csv")),
    ("linear.toml", example!("linear.toml")),
    ("published.toml", example!("published.toml")),
    ("jenkins.toml", example!("jenkins.toml")),
    ("valanis.toml", example!("valanis.toml")),
    ("valanis-residual.toml", example!("valanis-residual.toml")),
    ("rig.toml", example!("rig.toml")),
    ("unseen-level.toml", example!("unseen-level.toml")),
    ("predict.py", example!("predict.py")),
];

/// Arguments of `stickslip demo`.
#[derive(clap::Args)]
pub struct Demo {
    /// Folder for the example's files, the report, the best model and its FMU; created if missing
    #[arg(long, value_name = "DIR", default_value = DEFAULT_FOLDER)]
    out: PathBuf,
}

const DEFAULT_FOLDER: &str = "stickslip-demo";

impl Default for Demo {
    fn default() -> Self {
        Self { out: DEFAULT_FOLDER.into() }
    }
}

impl Demo {
    /// Compares, reports, exports.
    pub fn run(self) -> Result<(), Failure> {
        let example = self.out.join("frictional-support");
        std::fs::create_dir_all(&example)
            .map_err(|error| Failure::other(format!("cannot make {}: {error}", example.display())))?;
        write_example(&example, &FILES)?;
        let dataset = stickslip_readers::read_dataset(&example).map_err(super::shown)?;
        say(&format!("{}\n\n", dataset.title.as_deref().unwrap_or_default()))?;
        let mut models = Vec::new();
        let mut stages = Vec::new();
        for (name, file, fit) in STAGES {
            let model = super::read_model(&example.join(file))?;
            let done = if fit {
                super::refitted(name, &model, &dataset)?.map(|done| (done.model, done.stage))
            } else {
                let stage = evaluate(name, &model, &dataset);
                Some((model, stage))
            };
            // Interrupted: what was tried so far is shown.
            let Some((model, stage)) = done else { break };
            models.push(model);
            stages.push(stage);
        }
        let best = best(&stages);
        let unseen = unseen::predicted(&example)?;
        let read: Vec<PathBuf> = FILES.iter().skip(1).map(|(name, _)| example.join(name)).collect();
        let settings = super::settings(&read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
        let summary = format!("best: {}, exported as an FMU", stages[best].name);
        let title = "Resonance of a beam on a frictional support, measured at eight levels".to_owned();
        let noise = noise_of(&models[best], &dataset);
        let comparison = Comparison {
            title,
            records: dataset.records,
            ring_downs: Vec::new(),
            findings: Vec::new(),
            notes: Vec::new(),
            stages,
        };
        let mut outputs = Outputs::default();
        let sections: Vec<Section> = unseen.iter().map(|unseen| unseen.section.clone()).collect();
        let files = ResultFiles {
            json: Some(self.out.join("comparison.json")),
            report: Some(self.out.join("report.html")),
        };
        let exported = unseen.as_ref().map(|unseen| ("IdentifiedSupport", &unseen.model));
        for (name, model) in [("FrictionalSupport", &models[best])].into_iter().chain(exported) {
            let fmu = stickslip_fmu_package::write_fmu(name, &model.to_toml())
                .map_err(|error| Failure::other(error.to_string()))?;
            outputs.add(&self.out.join(format!("{name}.toml")), model.to_toml());
            outputs.add(&self.out.join(format!("{name}.fmu")), fmu);
        }
        present(&comparison, &noise, &sections, &settings, &files, &mut outputs)?;
        say(&format!("\n{summary}\n{}\n", unseen.map_or(String::new(), |unseen| unseen.summary)))?;
        super::list(&outputs.write()?)
    }
}

/// Writes the example's files, but not over one that the user has changed.
fn write_example(folder: &Path, all: &[(&str, &str)]) -> Result<(), Failure> {
    let mut files = Outputs::default();
    for &(name, text) in all {
        let path = folder.join(name);
        match std::fs::read(&path) {
            Ok(present) if present == text.as_bytes() => {}
            Ok(_) => {
                return Err(Failure::input(format!(
                    "{} differs from the example's file and is not replaced; choose another folder with `stickslip demo --out FOLDER`",
                    path.display()
                )));
            }
            Err(_) => files.add(&path, text),
        }
    }
    files.write().map(|_| ())
}

/// Index of the stage with the smallest error.
fn best(stages: &[Stage]) -> usize {
    let errors = stages.iter().map(|stage| if stage.error.is_nan() { f64::INFINITY } else { stage.error });
    errors.enumerate().min_by(|left, right| left.1.total_cmp(&right.1)).map_or(0, |(index, _)| index)
}
