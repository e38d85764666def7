//! `stickslip demo`

use std::path::PathBuf;

use stickslip::diagnose::{Comparison, Stage, evaluate, refit};
use stickslip::measure::Dataset;
use stickslip::model::Model;

use super::present;
use crate::output::Outputs;
use crate::progress::{self, interrupted};
use crate::{Failure, ResultFiles};

/// The example that the program carries inside itself.
macro_rules! example {
    ($file:literal) => {
        include_str!(concat!("../../../../examples/frictional-support/", $file))
    };
}

/// What the demonstration tries, in this order: name, model file, whether to refit it.
const STAGES: [(&str, &str, bool); 5] = [
    ("linear beam", example!("linear.toml"), false),
    ("Valanis, published", example!("published.toml"), false),
    ("Jenkins, refitted", example!("jenkins.toml"), true),
    ("Valanis, refitted", example!("valanis.toml"), true),
    ("Valanis + residual stiffness", example!("valanis-residual.toml"), true),
];

/// Arguments of `stickslip demo`.
#[derive(clap::Args)]
pub struct Demo {
    /// Folder for the report, the numbers, the best model and its FMU; made if it is not there
    #[arg(long, value_name = "DIR", default_value = "stickslip-demo")]
    out: PathBuf,
}

impl Default for Demo {
    fn default() -> Self {
        Self { out: "stickslip-demo".into() }
    }
}

impl Demo {
    /// Compares, reports, exports.
    pub fn run(self) -> Result<(), Failure> {
        let dataset = stickslip_readers::parse_dataset(
            "examples/frictional-support/dataset.toml",
            example!("dataset.toml"),
            &[("backbone.csv", example!("backbone.csv"))],
        )
        .map_err(super::shown)?;
        println!("{}\n", dataset.title.as_deref().unwrap_or_default());
        let (models, stages): (Vec<Model>, Vec<Stage>) = STAGES
            .iter()
            .map(|stage| run_stage(stage, &dataset))
            .collect::<Result<Vec<_>, _>>()?
            .into_iter()
            .unzip();
        let best = stages
            .iter()
            .zip(&models)
            .min_by(|(left, _), (right, _)| left.error.total_cmp(&right.error))
            .map(|(_, model)| model.to_toml())
            .ok_or_else(|| Failure::other("nothing was compared"))?;

        std::fs::create_dir_all(&self.out)
            .map_err(|error| Failure::other(format!("cannot make {}: {error}", self.out.display())))?;
        let mut outputs = Outputs::default();
        let comparison = Comparison {
            title: "Resonance of a beam on a frictional support, measured at eight levels".into(),
            records: dataset.records,
            stages,
        };
        let settings = super::settings(&[], &[]);
        let files = ResultFiles {
            json: Some(self.out.join("comparison.json")),
            report: Some(self.out.join("report.html")),
        };
        present(&comparison, &settings, &files, &mut outputs)?;
        let fmu = stickslip_fmu_package::write_fmu("FrictionalSupport", &best)
            .map_err(|error| Failure::other(error.to_string()))?;
        outputs.add(&self.out.join("FrictionalSupport.toml"), best);
        outputs.add(&self.out.join("FrictionalSupport.fmu"), fmu);
        println!();
        super::list(&outputs.write()?);
        Ok(())
    }
}

fn run_stage((name, text, fit): &(&str, &str, bool), dataset: &Dataset) -> Result<(Model, Stage), Failure> {
    let bar = progress::spinner(name);
    let model = Model::parse(text).map_err(|error| Failure::other(format!("{name}: {error}")))?;
    let done = if *fit {
        refit(name, &model, dataset, &mut |evaluations, error| {
            bar.set_message(format!("{evaluations} evaluations, error {error:.4}"));
            !interrupted()
        })
        .map_err(|error| Failure::other(format!("{name}: the refit failed: {error}")))
    } else {
        Ok((model.clone(), evaluate(name, &model, dataset)))
    };
    bar.finish_and_clear();
    done
}
