//! One file per command.

pub mod add;
pub mod check;
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
pub mod new;
pub mod rig;
pub mod serve;
pub mod simulate;
pub mod sweep;
mod tables;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use sha2::{Digest as _, Sha256};
use stickslip::data::{Dataset, Record};
use stickslip::diagnose::{Comparison, Noise, Refit, RefitError, Watch, refit, unused_columns};
use stickslip::fit::FitError;
use stickslip::fit::checks::{Finding, check};
use stickslip::fit::ring_down::RingDown;
use stickslip::fit::tabulated;
use stickslip::model::{Model, Structure};
use stickslip_readers::ImportOptions;

use stickslip_report::document::Section;
use stickslip_report::{InputFile, Settings};

use crate::output::{Outputs, say};
use crate::progress;
use crate::terminal::{colored, errors_are_colored, quoted};
use crate::{Failure, LoneFile, ResultFiles};

/// Reads a model file, or the model inside an FMU that this program exported; the failure points at the line.
fn read_model(path: &Path) -> Result<Model, Failure> {
    let is_a = |kind: &str| path.extension().is_some_and(|end| end.eq_ignore_ascii_case(kind));
    if path.is_file() && (is_a("ssp") || is_a("ssd")) {
        return Err(Failure::input(format!(
            "{} is a system of FMUs (SSP), and no model; `stickslip simulate` runs it",
            path.display()
        )));
    }
    if is_a("fmu") {
        let failed = |reason: String| Failure::input(format!("{}: {reason}", path.display()));
        let bytes = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
        let text =
            stickslip_fmu_package::read_model_toml(&bytes).map_err(|error| failed(error.to_string()))?;
        return Model::parse(&text)
            .map_err(|error| failed(format!("resources/model.toml: {}", error.message)));
    }
    stickslip_readers::read_model(path).map_err(shown)
}

/// Measurements as a command takes them.
struct Measured {
    /// Free decays among the records are cut into levels.
    dataset: Dataset,
    ring_downs: Vec<RingDown>,
    /// What was guessed or done when they were read.
    notes: Vec<String>,
    /// The files that were read.
    files: Vec<PathBuf>,
}

/// Reads a dataset, or a file without a `dataset.toml`, with its free decays cut into levels; what was guessed is told.
fn read_measured(path: &Path, model: &Model, lone: &LoneFile) -> Result<Measured, Failure> {
    let (dataset, notes, files) = read_dataset(path, model, lone)?;
    let (dataset, ring_downs) = tabulated(model, &dataset);
    Ok(Measured { dataset, ring_downs, notes, files })
}

/// Whether `path` is a dataset: a folder, or a TOML file. Everything else holds measurements itself.
fn is_dataset(path: &Path) -> bool {
    !path.is_file() || path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"))
}

/// The records, what was guessed, and the files that were read.
type Told = (Dataset, Vec<String>, Vec<PathBuf>);

/// Reads a dataset and makes sure that it has what a prediction by `model` needs.
fn read_dataset(path: &Path, model: &Model, lone: &LoneFile) -> Result<Told, Failure> {
    let told = read_records(path, model, lone)?;
    stickslip_readers::check_columns(&told.0, model).map_err(shown)?;
    Ok(told)
}

/// Reads a dataset, or a file without a `dataset.toml`.
fn read_records(path: &Path, model: &Model, lone: &LoneFile) -> Result<Told, Failure> {
    let (dataset, notes, files) = if is_dataset(path) {
        if !lone.columns.is_empty() || lone.regime.is_some() || lone.sample_rate.is_some() {
            return Err(Failure::input(
                "--column, --regime and --sample-rate are for a file without dataset.toml; write `[columns]` and `regime` \
                 there, and time stamps in the file",
            ));
        }
        let (dataset, notes) = stickslip_readers::read_dataset_told(path).map_err(shown)?;
        let files = dataset_files(path, &dataset);
        (dataset, notes, files)
    } else {
        let structure = Some(!matches!(model.structure, Structure::Prescribed));
        let options = ImportOptions {
            columns: lone.columns.clone(),
            regime: lone.regime,
            structure,
            sample_rate: lone.sample_rate,
            part: None,
        };
        let imported = stickslip_readers::import_file(path, &options).map_err(shown)?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let notes = imported.notes.iter().map(|note| format!("{name}: {note}")).collect();
        let title = Some(name.into_owned());
        (Dataset { title, records: imported.records }, notes, vec![path.to_owned()])
    };
    notes.iter().for_each(|note| tell!("note: {note}"));
    Ok((dataset, notes, files))
}

/// What results call the measurements at `path`: by their title, or else by the name of their folder, which a path such as `.`
/// does not tell.
fn title_of(dataset: &Dataset, path: &Path) -> String {
    let folder =
        if path.is_file() { path.parent().filter(|folder| *folder != Path::new("")) } else { Some(path) };
    let whole = folder.unwrap_or(Path::new(".")).canonicalize().ok();
    let name = whole.as_deref().and_then(Path::file_name).map(|name| name.to_string_lossy().into_owned());
    dataset.title.clone().or(name).unwrap_or_else(|| path.display().to_string())
}

fn shown(error: stickslip_readers::InputError) -> Failure {
    Failure::rendered(error.render(errors_are_colored()))
}

/// Prints the comparison, writes its JSON and what is among `outputs` already, and puts the page with `more` sections, which takes
/// longer, among them.
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
    list(&outputs.write_results()?)?;
    if let Some(path) = &files.report {
        outputs.add(path, stickslip_report::html_with(comparison, noise, more, settings));
    }
    Ok(())
}

/// How the results came about: command line, version, and what was read. `files` are named as the user
/// named them; a file beside a dataset gets the dataset's folder.
fn settings(files: &[&Path]) -> Result<Settings, Failure> {
    let input = |path: &&Path| {
        let mut digest = Sha256::new();
        let read =
            std::fs::File::open(path).and_then(|mut file| std::io::copy(&mut file, &mut Hashed(&mut digest)));
        read.map_err(|error| Failure::other(format!("cannot read {}: {error}", path.display())))?;
        Ok(InputFile { name: path.display().to_string(), sha256: hexadecimal(&digest.finalize()) })
    };
    let arguments: Vec<String> =
        std::env::args_os().skip(1).map(|word| quoted(&word.to_string_lossy())).collect();
    Ok(Settings {
        command: std::iter::once("stickslip".to_owned()).chain(arguments).collect::<Vec<_>>().join(" "),
        version: env!("CARGO_PKG_VERSION").to_owned(),
        files: files.iter().map(input).collect::<Result<_, Failure>>()?,
        date: date(files),
    })
}

/// When the files were last changed, so that the same input gives the same page; `SOURCE_DATE_EPOCH` says another date.
fn date(files: &[&Path]) -> Option<String> {
    let told = std::env::var("SOURCE_DATE_EPOCH").ok().and_then(|seconds| seconds.trim().parse().ok());
    if let Some(seconds) = told {
        return Some(day(seconds));
    }
    let changed = |path: &&Path| std::fs::metadata(path).ok()?.modified().ok();
    let newest = files.iter().filter_map(changed).max()?;
    let seconds = newest.duration_since(std::time::UNIX_EPOCH).ok()?.as_secs();
    Some(format!("from files of {}", day(seconds)))
}

/// The day (UTC) of a time in seconds since 1970, as 2026-03-12.
fn day(seconds: u64) -> String {
    // Days are counted from 1 March of the year 0: a leap day then ends its year.
    let days = seconds / 86_400 + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1_460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let part = (5 * day_of_year + 2) / 153;
    let month = if part < 10 { part + 3 } else { part - 9 };
    let year = 400 * era + year_of_era + u64::from(month <= 2);
    format!("{year:04}-{month:02}-{:02}", day_of_year - (153 * part + 2) / 5 + 1)
}

/// A digest of what is written to it: a file is not held in memory for its digest.
struct Hashed<'d>(&'d mut Sha256);

impl std::io::Write for Hashed<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
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
    // The part of a file that holds several records follows its name.
    let table = |record: &Record| {
        let whole = folder.join(&record.name);
        match record.name.rsplit_once(':') {
            Some((file, _)) if !whole.exists() => folder.join(file),
            _ => whole,
        }
    };
    let mut files: Vec<PathBuf> = std::iter::once(file).chain(dataset.records.iter().map(table)).collect();
    let mut seen = BTreeSet::new();
    files.retain(|file| seen.insert(file.clone()));
    files
}

/// Says what was written.
fn list(written: &[PathBuf]) -> Result<(), Failure> {
    written.iter().try_for_each(|path| say(&format!("wrote {}\n", path.display())))
}

/// Refits `model` as the stage `name`; what a reader must know of the fit is among its notes. `None` when it was
/// interrupted before it had improved the model.
fn refitted(name: &str, model: &Model, dataset: &Dataset) -> Result<Option<Refit>, Failure> {
    if progress::interrupted() {
        return Ok(None);
    }
    // Those of the model as it was.
    progress::results_exist();
    let done = match watched(name, |watch| refit(name, model, dataset, watch)) {
        Err(RefitError::Fit(FitError::Interrupted)) => None,
        Err(error @ (RefitError::NothingFree | RefitError::NothingToFit)) => {
            return Err(Failure::input(format!("{name}: {error}")));
        }
        Err(error) => return Err(Failure::other(format!("{name}: {error}"))),
        Ok(done) => Some(done),
    };
    match &done {
        None => tell!("note: {name}: interrupted before the first result"),
        Some(_) if progress::interrupted() => {
            tell!("note: {name}: interrupted; these are the results so far");
        }
        Some(_) => {}
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

/// Tells the columns of the dataset that a comparison with `model` does not use, each once, and returns the sentences.
fn unused(model: &Model, dataset: &Dataset) -> Vec<String> {
    let mut records_of: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for record in &dataset.records {
        for column in unused_columns(model, record) {
            records_of.entry(column).or_default().push(&record.name);
        }
    }
    let sentence = |(column, records): (&str, Vec<&str>)| {
        let reason = match column {
            "normal_load" => "; the model's normal load is constant",
            _ => "",
        };
        let others = match records.len() {
            1 => String::new(),
            count => format!(" and {} more", count - 1),
        };
        format!("{}{others}: column `{column}` is not used{reason}", records[0])
    };
    let sentences: Vec<String> = records_of.into_iter().map(sentence).collect();
    sentences.iter().for_each(|sentence| tell!("note: {sentence}"));
    sentences
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

#[cfg(test)]
mod tests {
    #[test]
    fn days_are_those_of_the_calendar() {
        let days = [
            (0, "1970-01-01"),
            (951_782_400, "2000-02-29"),
            (1_773_273_600, "2026-03-12"),
            (4_107_542_399, "2100-02-28"),
        ];
        assert!(days.iter().all(|(seconds, day)| super::day(*seconds) == *day));
    }
}
