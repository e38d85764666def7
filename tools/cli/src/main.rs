//! The program: compares models with measurements and exports them as FMUs.

/// Writes a line to standard error, unless only errors are wanted; a closed terminal is no error, so that results are not lost.
macro_rules! tell {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        if !$crate::terminal::is_quiet() {
            let _ = writeln!(std::io::stderr(), $($text)*);
        }
    }};
}

mod commands;
#[cfg(test)]
mod fuzz;
mod output;
mod progress;
mod terminal;

use std::io::Write as _;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Args, CommandFactory as _, Parser, Subcommand};

/// Friction contacts: compare models with measurements, export them as FMUs.
///
/// Exit codes: 0 done, 1 failed (a full disk, a solver that failed), 2 bad input or an output that could never be
/// written (nothing was written), 130 interrupted. The results of `simulate` are written even if it ends early (1) or
/// is interrupted (130) after its first step. `diagnose` ends with its verdict: 0 nothing missing, 10 effect found,
/// 11 not distinguishable, 12 unexplained, 13 insufficient data, 14 effect likely, its noise unknown.
#[derive(Parser)]
#[command(name = "stickslip", version)]
struct Cli {
    /// Show nothing but errors
    #[arg(short, long, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Subcommand)]
enum Command {
    /// Compare six models of a frictional support with its measured resonance frequencies and
    /// export the best as an FMU (also `stickslip` without a command)
    Demo(commands::demo::Demo),
    /// Make a dataset of files as laboratories export them, and tell what was guessed
    Import(commands::import::Import),
    /// Write a model file to begin with, and a folder for measurements
    New(commands::new::New),
    /// Look at a model, and at measurements beside it, before anything is fitted
    Check(commands::check::Check),
    /// Compare a model with a dataset, refit it, and compare again
    Compare(commands::compare::Compare),
    /// Find the physical effect that the model lacks, from measurements
    Diagnose(commands::diagnose::Diagnose),
    /// Add an effect to a model, refit it, and show the error before and after
    Add(commands::add::Add),
    /// Find what a beam's contact does, without assuming its law, and the law that predicts it
    Identify(commands::identify::Identify),
    /// Print the catalogue of effects, or the entry of one effect
    Effects(commands::effects::Effects),
    /// Follow the periodic response of a model to a harmonic force over frequency
    Frf(commands::frf::Frf),
    /// Follow a nonlinear normal mode: its frequency and damping over the amplitude
    Modes(commands::modes::Modes),
    /// Take the records of tests on a virtual rig, from a model of a beam
    Rig(commands::rig::Rig),
    /// Simulate a system of FMUs (SSP 1.0), or one FMU
    Simulate(commands::simulate::Simulate),
    /// Write one model as an FMU
    Export(commands::export::Export),
    /// Write the standard FMUs, and systems of them
    Fmu(commands::fmu::Fmu),
    /// Print what makes a shell complete this program's commands
    Completions(commands::manual::Completions),
    /// Print a page of the manual
    Man(commands::manual::Manual),
    #[command(name = commands::serve::NAME, hide = true)]
    ServeFmu(commands::serve::Serve),
    #[command(name = commands::sweep::NAME, hide = true)]
    Sweep(commands::sweep::Sweep),
}

/// Files for the results.
#[derive(Args, Clone, Default)]
struct ResultFiles {
    /// Write the results as JSON; `-` for standard output, and nothing else there
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Write the results as a self-contained HTML page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// What is said of measurements that come without a `dataset.toml`.
#[derive(Args, Clone, Default)]
struct LoneFile {
    /// Of a file without dataset.toml: what a column is, by its heading or its number from 1; may be given several times
    #[arg(long = "column", value_name = "HEADING=NAME [UNIT]", value_parser = commands::import::column)]
    columns: Vec<(String, stickslip_readers::ColumnRule)>,
    /// Of a file without dataset.toml: how its records begin; `unknown-initial-state` unless it is a table
    #[arg(long, value_name = "REGIME", value_parser = commands::import::regime)]
    regime: Option<stickslip::data::Regime>,
    /// Of a file without dataset.toml and without time stamps: samples in a second (Hz)
    #[arg(long, value_name = "HZ", value_parser = commands::import::rate)]
    sample_rate: Option<f64>,
}

/// Why the program ends without success; the message is complete.
#[derive(Debug)]
struct Failure {
    code: u8,
    message: String,
}

impl Failure {
    /// The user's input is at fault: exit code 2.
    fn input(message: impl Into<String>) -> Failure {
        Failure { code: 2, message: format!("error: {}", message.into()) }
    }

    /// The user's input is at fault, and `message` shows where.
    fn rendered(message: String) -> Failure {
        Failure { code: 2, message }
    }

    /// The program was asked to end before there was anything to keep.
    fn interrupted() -> Failure {
        Failure { code: 130, message: "interrupted before the first result".to_owned() }
    }

    /// Something else is at fault: exit code 1.
    fn other(message: impl Into<String>) -> Failure {
        Failure { code: 1, message: format!("error: {}", message.into()) }
    }
}

/// A panic of foreign code that reads a broken file becomes an error with its sentence: nothing else is said of it.
fn keep_quiet_about_foreign_code() {
    let other = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if std::thread::current().name() != Some(stickslip_readers::GUARDED) {
            other(panic);
        }
    }));
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    keep_quiet_about_foreign_code();
    if cli.quiet {
        terminal::be_quiet();
    }
    // The process of one FMU is ended by its master, and the one that sweeps ends after it.
    if !matches!(cli.command, Some(Command::ServeFmu(_) | Command::Sweep(_))) {
        progress::catch_interrupts();
    }
    match run(cli.command.unwrap_or_else(|| Command::Demo(Default::default()))) {
        Ok(_) if progress::interrupted() => ExitCode::from(130),
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            let _ = writeln!(std::io::stderr(), "{}", failure.message.trim_end());
            ExitCode::from(failure.code)
        }
    }
}

/// The exit code of a command that does not fail.
fn run(command: Command) -> Result<u8, Failure> {
    match command {
        Command::Demo(command) => command.run().map(|()| 0),
        Command::Import(command) => command.run().map(|()| 0),
        Command::New(command) => command.run().map(|()| 0),
        Command::Check(command) => command.run(),
        Command::Compare(command) => command.run().map(|()| 0),
        Command::Diagnose(command) => command.run(),
        Command::Add(command) => command.run().map(|()| 0),
        Command::Identify(command) => command.run().map(|()| 0),
        Command::Effects(command) => command.run().map(|()| 0),
        Command::Frf(command) => command.run().map(|()| 0),
        Command::Modes(command) => command.run().map(|()| 0),
        Command::Rig(command) => command.run().map(|()| 0),
        Command::Export(command) => command.run().map(|()| 0),
        Command::Fmu(command) => command.run().map(|()| 0),
        Command::Simulate(command) => command.run().map(|()| 0),
        Command::Completions(command) => command.run(Cli::command()).map(|()| 0),
        Command::Man(command) => command.run(Cli::command()).map(|()| 0),
        Command::ServeFmu(command) => command.run().map(|()| 0),
        Command::Sweep(command) => command.run().map(|()| 0),
    }
}
