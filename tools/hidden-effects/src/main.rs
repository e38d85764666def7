//! The program behind `cargo xtask hidden-effects`.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use clap::Parser;
use rayon::prelude::*;
use serde_json::Value;
use stickslip_hidden_effects::cases::case::{Case, Kind};
use stickslip_hidden_effects::cases::files;
use stickslip_hidden_effects::cases::sealed::sealed;
use stickslip_hidden_effects::cases::three::three;
use stickslip_hidden_effects::scoring::run::{self, Plan, Task};
use stickslip_hidden_effects::scoring::truth::Truth;
use stickslip_hidden_effects::scoring::visibility::visibility;
use stickslip_hidden_effects::scoring::{agreement, assumptions, machine, table};

/// Simulated measurements with a hidden effect, and the score of a diagnosis of them
#[derive(Parser)]
#[command(name = "cargo xtask hidden-effects")]
struct Arguments {
    /// Only so many cases
    #[arg(long)]
    cases: Option<usize>,
    /// Only this kind: contact, oscillator, beam
    #[arg(long)]
    kind: Option<String>,
    /// Only cases whose name holds this text; several: each must be in it. Later kinds: further, 32-records, 128-records,
    /// ramped, noise-untold, long-delay, mass-off, coarse, held-levels, dahl, bouc_wen, valanis, and the names of what is
    /// outside the catalogue
    #[arg(long)]
    filter: Vec<String>,
    /// Another set of the same cases, all numbers and all noise drawn anew
    #[arg(long, default_value_t = 0)]
    set: usize,
    /// Cases that hide three effects instead, for a diagnosis that may add so many; the page counts them as pairs
    #[arg(long)]
    three: bool,
    /// Runs side by side; with one the program takes all cores
    #[arg(long, default_value_t = std::thread::available_parallelism().map_or(1, usize::from))]
    jobs: usize,
    /// Score the cases of this folder (truth.json beside them) instead of the sealed ones
    #[arg(long)]
    data: Option<PathBuf>,
    /// Forget the answers that are there
    #[arg(long)]
    fresh: bool,
    /// Keep the answers that another build of the program gave
    #[arg(long)]
    resume: bool,
    /// Seconds after which a run has failed
    #[arg(long, default_value_t = 900)]
    longest: u64,
    /// Generate the cases and stop
    #[arg(long)]
    generate: bool,
    /// List the cases and stop
    #[arg(long)]
    list: bool,
    /// Tell how much of each hidden effect a refit of the base model cannot absorb, and stop
    #[arg(long)]
    visibility: bool,
    /// Compare the program's model, all that is hidden written into it, with the measurements, and stop: the
    /// error over the noise is 1 where the program's physics and the generator's agree
    #[arg(long)]
    agreement: bool,
    /// Tell instead how each number that the program takes for granted, halved and doubled, changes its verdicts
    #[arg(long)]
    assumptions: bool,
    /// Write the table here as well
    #[arg(long)]
    table: Option<PathBuf>,
    /// The program to score
    #[arg(long, default_value = "target/release/stickslip")]
    program: PathBuf,
    /// Folder for cases and answers
    #[arg(long, default_value = "target/hidden-effects")]
    out: PathBuf,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    if let Some(data) = &arguments.data {
        let tasks = given(arguments, data)?;
        let name = data.file_name().map_or("data".into(), |name| name.to_string_lossy().into_owned());
        return score(arguments, &tasks, &format!("data-{name}"));
    }
    let cases = chosen(arguments)?;
    if arguments.list {
        cases.iter().for_each(|case| println!("{}", case.name()));
        return Ok(());
    }
    if arguments.visibility {
        return show(&cases);
    }
    let root = arguments.out.join(format!("cases-{}", files::GENERATION));
    fs::create_dir_all(&root).map_err(|error| format!("{}: {error}", root.display()))?;
    if arguments.generate {
        cases.par_iter().try_for_each(|case| files::write(&root, case).map(|_| ()))?;
        files::write_truth(&root, &cases)?;
        println!("{} cases in {}", cases.len(), root.display());
        return Ok(());
    }
    if arguments.agreement {
        return agreement::show(&arguments.program, &root, &arguments.out.join("true-models"), &cases);
    }
    files::write_truth(&root, &cases)?;
    let tasks = cases.into_iter().map(|case| task(&root, case)).collect::<Result<Vec<_>, _>>()?;
    score(arguments, &tasks, &format!("sealed-{}", files::GENERATION))
}

/// More than any set has of one case.
const REPLICAS: usize = 100;

fn chosen(arguments: &Arguments) -> Result<Vec<Case>, String> {
    if let Some(word) =
        arguments.kind.as_deref().filter(|word| Kind::ALL.iter().all(|kind| kind.word() != *word))
    {
        return Err(format!("no kind `{word}`: contact, oscillator, beam"));
    }
    let cases = if arguments.three { three() } else { sealed() };
    let cases: Vec<Case> = cases
        .into_iter()
        .map(|case| Case { replica: case.replica + REPLICAS * arguments.set, ..case })
        .filter(|case| wanted(arguments, case.kind.word(), &case.name()))
        .take(arguments.cases.unwrap_or(usize::MAX))
        .collect();
    if cases.is_empty() { Err("no such case; --list lists them".to_owned()) } else { Ok(cases) }
}

fn wanted(arguments: &Arguments, kind: &str, name: &str) -> bool {
    arguments.kind.as_deref().is_none_or(|wanted| wanted == kind)
        && arguments.filter.iter().all(|text| name.contains(text.as_str()))
}

fn task(root: &Path, case: Case) -> Result<Task, String> {
    let root = root.to_owned();
    Ok(Task {
        name: case.name(),
        truth: Truth::read(&files::truth(&case)?)?,
        folder: Box::new(move || files::write(&root, &case)),
    })
}

/// The cases of a folder with `truth.json`.
fn given(arguments: &Arguments, data: &Path) -> Result<Vec<Task>, String> {
    let path = data.join("truth.json");
    let text = fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
    let all: Value = serde_json::from_str(&text).map_err(|error| format!("{}: {error}", path.display()))?;
    let entries = all.as_object().ok_or_else(|| format!("{}: not a table of cases", path.display()))?;
    let mut tasks = Vec::new();
    for (name, entry) in entries {
        let truth = Truth::read(entry).map_err(|error| format!("{}: {name}: {error}", path.display()))?;
        let folder = data.join(name);
        if wanted(arguments, &truth.kind, name) {
            tasks.push(Task { name: name.clone(), truth, folder: Box::new(move || Ok(folder.clone())) });
        }
    }
    // case-2 before case-10.
    tasks.sort_by_key(|task| (task.name.len(), task.name.clone()));
    tasks.truncate(arguments.cases.unwrap_or(usize::MAX));
    Ok(tasks)
}

fn score(arguments: &Arguments, tasks: &[Task], set: &str) -> Result<(), String> {
    let plan = Plan {
        program: arguments.program.clone(),
        results: arguments.out.join(if arguments.three { format!("{set}-three") } else { set.to_owned() }),
        jobs: arguments.jobs,
        fresh: arguments.fresh,
        resume: arguments.resume,
        assume: None,
        max_effects: arguments.three.then_some(3),
        longest: Duration::from_secs(arguments.longest),
    };
    if arguments.assumptions {
        let page = assumptions::markdown(&plan, tasks, &command())?;
        println!("{page}");
        return arguments.table.as_ref().map_or(Ok(()), |path| written(path, &page));
    }
    let outcomes = run::run(&plan, tasks)?;
    let page = table::markdown(&outcomes, &command(), &machine(arguments.jobs));
    println!("{page}");
    let mut targets = vec![
        (arguments.out.join(format!("{set}.md")), page.clone()),
        (arguments.out.join(format!("{set}.json")), format!("{:#}\n", machine::readable(&outcomes))),
    ];
    targets.extend(arguments.table.iter().map(|path| (path.clone(), page.clone())));
    for (path, text) in targets {
        written(&path, &text)?;
    }
    Ok(())
}

fn written(path: &Path, text: &str) -> Result<(), String> {
    fs::write(path, text).map_err(|error| format!("{}: {error}", path.display()))
}

/// What a reader types to see the same.
fn command() -> String {
    let own = ["--program", "--out", "--table"];
    let mut words = vec!["cargo xtask hidden-effects".to_owned()];
    let mut arguments = std::env::args().skip(1);
    while let Some(word) = arguments.next() {
        if own.contains(&word.as_str()) {
            arguments.next();
        } else {
            words.push(word);
        }
    }
    words.join(" ")
}

fn machine(jobs: usize) -> String {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    format!(
        "Machine: {cores} cores, {jobs} cases side by side, {} threads each.",
        (cores / jobs.max(1)).max(1)
    )
}

fn show(cases: &[Case]) -> Result<(), String> {
    println!("| case | change % | not absorbed % | over the noise |\n|---|---:|---:|---:|");
    let rows: Vec<String> = cases
        .par_iter()
        .filter(|case| !case.effects.is_empty())
        .map(|case| {
            let seen = visibility(case.draw()?.rig.as_ref())?;
            let (change, left) = (100.0 * seen.change, 100.0 * seen.left);
            let row = format!(
                "| {} | {change:.1} | {left:.2} | {:.1} |",
                case.name(),
                seen.left / case.noise.share
            );
            eprintln!("{row}");
            Ok(row)
        })
        .collect::<Result<_, String>>()?;
    rows.iter().for_each(|row| println!("{row}"));
    Ok(())
}
