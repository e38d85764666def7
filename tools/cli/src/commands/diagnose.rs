//! `stickslip diagnose`

use std::path::PathBuf;
use std::time::Instant;

use stickslip::diagnose::{
    Assumptions, DiagnoseError, DiagnoseOptions, DiagnoseWatch, Diagnosis, RefitError, Verdict, diagnose,
};
use stickslip::document::suggestion;
use stickslip::effects::{self, CATALOGUE, Effect};
use stickslip::fit::FitError;
use stickslip_report::diagnosis::{Run, diagnosis_html, diagnosis_json, diagnosis_table};

use super::{
    Measured, check_destinations, checked, dataset_file, list, read_measured, read_model, settings, tables,
    unused,
};
use crate::output::{Outputs, say};
use crate::{Failure, LoneFile, ResultFiles, progress};

/// NAME=VALUE of an assumption.
fn assumption(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("NAME=VALUE is expected, `odds=0.25` for example")?;
    let number = value.trim().parse().map_err(|_| format!("`{value}` is not a number"))?;
    Ok((name.trim().to_owned(), number))
}

/// Arguments of `stickslip diagnose`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip diagnose model.toml data/ --report diagnosis.html --json diagnosis.json
  stickslip diagnose model.toml data/ --effects backlash,wear,sensor_offset -o improved.toml

Exit codes: 0 nothing missing; 10 effect found; 11 not distinguishable; 12 unexplained; 13 insufficient
data; 14 effect likely, its noise unknown; 2 bad input (nothing is written); 1 failed; 130 interrupted by Ctrl-C (what was known is written).")]
pub struct Diagnose {
    /// The model file, or an FMU that carries one
    model: PathBuf,
    /// The dataset: `dataset.toml` or the folder that holds it
    dataset: PathBuf,
    /// Try only these effects of the catalogue (see `stickslip effects`)
    #[arg(long, value_name = "ID,ID,...", value_delimiter = ',')]
    effects: Option<Vec<String>>,
    /// Add at most N effects
    #[arg(long, value_name = "N", default_value_t = DiagnoseOptions::default().max_effects)]
    max_effects: usize,
    /// Take another value for granted (see docs/missing-effect.md); may be repeated
    #[arg(long, value_name = "NAME=VALUE", value_parser = assumption)]
    assume: Vec<(String, f64)>,
    /// Write the model with the effects found, refitted
    #[arg(short, long, value_name = "NEW.toml")]
    out: Option<PathBuf>,
    /// Write measured, predicted and residual values of every record, `RECORD-compared.csv`, to this folder
    #[arg(long, value_name = "DIR")]
    csv: Option<PathBuf>,
    #[command(flatten)]
    lone: LoneFile,
    #[command(flatten)]
    files: ResultFiles,
}

impl Diagnose {
    /// Diagnoses, and returns the verdict's exit code.
    pub fn run(self) -> Result<u8, Failure> {
        check_destinations(&self.files, &self.out, &[self.model.clone(), dataset_file(&self.dataset)])?;
        for id in self.effects.iter().flatten() {
            effect(id)?;
        }
        let options = self.options()?;
        let model = read_model(&self.model)?;
        let Measured { dataset, mut notes, files, .. } = read_measured(&self.dataset, &model, &self.lone)?;
        checked(&model, &dataset);
        let mut read = vec![self.model.clone()];
        read.extend(files);
        let folder = self.csv.as_deref();
        tables::check(&self.files, &self.out, folder, tables::compared(folder, &dataset.records), &read)?;
        let settings = settings(&read.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;

        let start = Instant::now();
        let mut diagnosis = watched(|watch| diagnose(&model, &dataset, &options, watch)).map_err(failed)?;
        notes.extend(unused(&model, &dataset));
        diagnosis.comparison.notes = notes;
        let mut outputs = Outputs::default();
        let run = Run {
            model: self.model.display().to_string(),
            dataset: self.dataset.display().to_string(),
            written: self.improved(&diagnosis, &mut outputs),
            options: options.clone(),
            seconds: start.elapsed().as_secs_f64(),
            interrupted: progress::interrupted(),
        };
        say(&diagnosis_table(&diagnosis, &run, 80, super::colored()))?;
        if let Some(path) = &self.files.json {
            outputs.add(path, format!("{:#}\n", diagnosis_json(&diagnosis, &run)));
        }
        list(&outputs.write_results()?)?;
        if let Some(path) = &self.files.report {
            outputs.add(path, diagnosis_html(&diagnosis, &run, &settings));
        }
        tables::add(folder, &diagnosis.comparison, &mut outputs)?;
        list(&outputs.write()?)?;
        Ok(diagnosis.exit_code())
    }

    fn options(&self) -> Result<DiagnoseOptions, Failure> {
        let mut assumptions = Assumptions::default();
        for (name, value) in &self.assume {
            assumptions =
                assumptions.with(name, *value).map_err(|error| Failure::input(error.to_string()))?;
        }
        Ok(DiagnoseOptions { effects: self.effects.clone(), max_effects: self.max_effects, assumptions })
    }

    /// Adds the model to the files to be written where the diagnosis stands for it.
    fn improved(&self, diagnosis: &Diagnosis, outputs: &mut Outputs) -> Option<String> {
        let path = self.out.as_ref()?;
        match diagnosis.verdict {
            Verdict::EffectFound | Verdict::NothingMissing => {
                outputs.add(path, diagnosis.model.to_toml());
                Some(path.display().to_string())
            }
            verdict => {
                tell!("note: {} is not written: the verdict is {}", path.display(), verdict.id());
                None
            }
        }
    }
}

/// The effect called `id`.
pub fn effect(id: &str) -> Result<&'static Effect, Failure> {
    effects::find(id).ok_or_else(|| {
        let ids: Vec<&str> = CATALOGUE.iter().map(|effect| effect.id).collect();
        Failure::input(format!("there is no effect `{id}`: {}", suggestion(id, &ids, "effects")))
    })
}

/// Runs `work` with its progress on the terminal.
pub fn watched<T>(work: impl FnOnce(DiagnoseWatch) -> T) -> T {
    let meter = progress::Progress::new();
    let show = |what: &str, done: usize, of: usize| {
        if done > 0 {
            progress::results_exist();
        }
        meter.show(what, done, of);
    };
    let done = work(DiagnoseWatch { progress: Some(&show), interrupt: Some(&progress::interrupted) });
    meter.finish();
    done
}

/// Why there is nothing to show.
pub fn failed(error: DiagnoseError) -> Failure {
    match error {
        DiagnoseError::Refit(RefitError::Fit(FitError::Interrupted)) => Failure::interrupted(),
        DiagnoseError::UnknownEffect(_)
        | DiagnoseError::Refit(RefitError::NothingFree | RefitError::NothingToFit) => {
            Failure::input(error.to_string())
        }
        DiagnoseError::Refit(_) => Failure::other(error.to_string()),
    }
}
