//! One file per command.

pub mod add;
pub mod compare;
pub mod demo;
pub mod diagnose;
pub mod effects;
pub mod export;
pub mod fmu;
pub mod frf;
pub mod identify;
pub mod import;
pub mod manual;
pub mod modes;
pub mod rig;
pub mod serve;
pub mod simulate;
pub mod sweep;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use stickslip::data::Dataset;
use stickslip::diagnose::{Comparison, Noise, Refit, RefitError, Watch, refit, unused_columns};
use stickslip::fit::checks::{Finding, check};
use stickslip::fit::ring_down::{RingDown, tabulated};
use stickslip::fit::{Ending, FitError};
use stickslip::model::Model;

use stickslip_report::document::Section;
use stickslip_report::{InputFile, Settings};

use crate::output::{Outputs, say};
use crate::progress;
use crate::terminal::{colored, errors_are_colored, quoted};
use crate::{Failure, ResultFiles};

/// Reads a model file, or the model inside an FMU that this program exported; the failure points at the line.
fn read_model(path: &Path) -> Result<Model, Failure> {
    if path.extension().is_some_and(|end| end.eq_ignore_ascii_case("fmu")) {
        let failed = |reason: String| Failure::input(format!("{}: {reason}", path.display()));
        let bytes = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
        let text =
            stickslip_fmu_package::read_model_toml(&bytes).map_err(|error| failed(error.to_string()))?;
        return Model::parse(&text)
            .map_err(|error| failed(format!("resources/model.toml: {}", error.message)));
    }
    stickslip_readers::read_model(path).map_err(shown)
}

/// Reads a dataset as [`read_dataset`] does, with its free decays cut into levels; and those.
fn read_levels(path: &Path, model: &Model) -> Result<(Dataset, Vec<RingDown>), Failure> {
    Ok(tabulated(model, &read_dataset(path, model)?))
}

/// Reads a dataset and makes sure that it has what `model` needs.
fn read_dataset(path: &Path, model: &Model) -> Result<Dataset, Failure> {
    let dataset = stickslip_readers::read_dataset(path).map_err(shown)?;
    stickslip_readers::check_columns(&dataset, model).map_err(shown)?;
    Ok(dataset)
}

fn shown(error: stickslip_readers::InputError) -> Failure {
    Failure::rendered(error.render(errors_are_colored()))
}

/// Prints the comparison and puts the asked-for files among `outputs`, the page with `more` sections.
fn present(
    comparison: &Comparison,
    noise: &[Noise],
    more: &[Section],
    settings: &Settings,
    files: &ResultFiles,
    outputs: &mut Outputs,
) -> Result<(), Failure> {
    say(&stickslip_report::terminal_table(comparison, noise, 80, colored()))?;
    if let Some(path) = &files.json {
        let text = serde_json::to_string_pretty(&stickslip_report::json(comparison, noise))
            .map_err(|error| Failure::other(error.to_string()))?;
        outputs.add(path, text + "\n");
    }
    if let Some(path) = &files.report {
        outputs.add(path, stickslip_report::html_with(comparison, noise, more, settings));
    }
    Ok(())
}

/// How the results came about: command line, version, and what was read. `files` are named as the user
/// named them; a file beside a dataset gets the dataset's folder.
fn settings(files: &[&Path]) -> Result<Settings, Failure> {
    let input = |path: &&Path| {
        let bytes = std::fs::read(path)
            .map_err(|error| Failure::other(format!("cannot read {}: {error}", path.display())))?;
        Ok(InputFile { name: path.display().to_string(), sha256: hexadecimal(&Sha256::digest(bytes)) })
    };
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy())).collect();
    Ok(Settings {
        command: std::iter::once("stickslip".to_owned()).chain(arguments).collect::<Vec<_>>().join(" "),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        files: files.iter().map(input).collect::<Result<_, Failure>>()?,
        date: None,
    })
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The dataset's own file.
fn dataset_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("dataset.toml") } else { path.to_owned() }
}

/// The dataset's own file and the tables it lists.
fn dataset_files(path: &Path, dataset: &Dataset) -> Vec<PathBuf> {
    let file = dataset_file(path);
    let folder = file.parent().unwrap_or(Path::new("")).to_owned();
    std::iter::once(file).chain(dataset.records.iter().map(|record| folder.join(&record.name))).collect()
}

/// Says what was written.
fn list(written: &[PathBuf]) -> Result<(), Failure> {
    written.iter().try_for_each(|path| say(&format!("wrote {}\n", path.display())))
}

/// Refits `model` as the stage `name`, and warns when the fit did not converge. `None` when it was
/// interrupted before it had improved the model.
fn refitted(name: &str, model: &Model, dataset: &Dataset) -> Result<Option<Refit>, Failure> {
    let done = match watched(name, |watch| refit(name, model, dataset, watch)) {
        Err(RefitError::Fit(FitError::Interrupted)) => None,
        Err(error @ (RefitError::NothingFree | RefitError::NothingToFit)) => {
            return Err(Failure::input(format!("{name}: {error}")));
        }
        Err(error) => return Err(Failure::other(format!("{name}: {error}"))),
        Ok(done) => Some(done),
    };
    match done.as_ref().map_or(Ending::Interrupted, |done| done.ending) {
        Ending::Converged => {}
        Ending::Interrupted => tell!("note: {name}: interrupted; these are the results so far"),
        Ending::StepLimit => tell!("note: {name}: the fit was still improving when its steps ran out"),
        Ending::Stalled => {
            tell!("note: {name}: the fit ended where no step lowered the error, short of convergence");
        }
    }
    if let Some(Refit { model, unseen, .. }) = &done {
        for path in unseen {
            let value = model.get(path).unwrap_or(f64::NAN);
            tell!("note: {name}: no fitted record depends on {path}, which stays {value}");
        }
    }
    Ok(done)
}

/// What is wrong with the dataset or with the model's units: said before a fit, which may take its time.
fn checked(model: &Model, dataset: &Dataset) -> Vec<Finding> {
    let found = check(model, dataset);
    for sentence in stickslip_report::findings(&found) {
        tell!("warning: {sentence}");
    }
    found
}

/// Names the columns of the dataset that a comparison with `model` does not use, each once.
fn tell_unused(model: &Model, dataset: &Dataset) {
    let mut records_of: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for record in &dataset.records {
        for column in unused_columns(model, record) {
            records_of.entry(column).or_default().push(&record.name);
        }
    }
    for (column, records) in records_of {
        let reason = match column {
            "normal_load" => "; the model's normal load is constant",
            _ => "",
        };
        let others = match records.len() {
            1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        tell!("note: {}{others}: column `{column}` is not used{reason}", records[0]);
    }
}

/// Runs `work` with a spinner that shows the evaluations and the error of the fit so far.
fn watched<T>(what: &str, work: impl FnOnce(Watch) -> T) -> T {
    let bar = progress::spinner(what);
    let show = |at: &stickslip::fit::Progress| {
        bar.set_message(format!("step {}, {} evaluations", at.iteration, at.evaluations));
    };
    let done = work(Watch { progress: Some(&show), interrupt: Some(&progress::interrupted) });
    bar.finish_and_clear();
    done
}

/// Refuses destinations that could not be written or would replace one of the `inputs`, before any work.
fn check_destinations<'p>(
    files: &'p ResultFiles,
    other: impl IntoIterator<Item = &'p PathBuf>,
    inputs: &[impl AsRef<Path>],
) -> Result<(), Failure> {
    Outputs::check(files.json.iter().chain(&files.report).chain(other), inputs)?;
    check_page(files.report.as_deref())
}

/// Refuses a report that a browser would not know as an HTML page.
fn check_page(report: Option<&Path>) -> Result<(), Failure> {
    let extension = |path: &Path| Some(path.extension()?.to_string_lossy().to_lowercase());
    match report.and_then(|path| Some((path, extension(path)?))) {
        Some((path, other)) if !["html", "htm"].contains(&other.as_str()) => Err(Failure::input(format!(
            "{}: reports are HTML pages; the name should end in .html",
            path.display()
        ))),
        _ => Ok(()),
    }
}
