//! The program behind `cargo xtask hidden-effects`.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use rayon::prelude::*;
use stickslip_hidden_effects::case::{self, Case, Kind};
use stickslip_hidden_effects::files;

/// Simulated measurements with a hidden effect, and the score of a diagnosis of them
#[derive(Parser)]
struct Arguments {
    /// Only so many cases
    #[arg(long)]
    cases: Option<usize>,
    /// Only this kind: contact, oscillator, beam
    #[arg(long)]
    kind: Option<String>,
    /// Only cases whose name holds this text
    #[arg(long)]
    filter: Option<String>,
    /// Generate the cases and stop
    #[arg(long)]
    generate: bool,
    /// List the cases and stop
    #[arg(long)]
    list: bool,
    /// Folder for cases and results
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
    let kind = match &arguments.kind {
        None => None,
        Some(word) => match Kind::ALL.into_iter().find(|kind| kind.word() == word) {
            Some(kind) => Some(kind),
            None => return Err(format!("no kind `{word}`: contact, oscillator, beam")),
        },
    };
    let text = arguments.filter.as_deref().unwrap_or_default();
    let cases: Vec<Case> = case::sealed()
        .into_iter()
        .filter(|case| kind.is_none_or(|kind| case.kind == kind) && case.name().contains(text))
        .take(arguments.cases.unwrap_or(usize::MAX))
        .collect();
    if arguments.list {
        cases.iter().for_each(|case| println!("{}", case.name()));
        return Ok(());
    }
    let root = arguments.out.join(format!("cases-{}", files::GENERATION));
    std::fs::create_dir_all(&root).map_err(|error| format!("{}: {error}", root.display()))?;
    cases.par_iter().try_for_each(|case| files::write(&root, case).map(|_| ()))?;
    files::write_truth(&root, &cases)?;
    println!("{} cases in {}", cases.len(), root.display());
    Ok(())
}
