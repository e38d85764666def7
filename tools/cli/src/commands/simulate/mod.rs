//! `stickslip simulate`

mod assemble;
mod files;
mod inputs;
mod parquet;
mod parts;
mod run;
mod starts;

use std::io::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::ValueEnum;
use stickslip::cosim::{Adaptive, Algorithm, Control, Master, Method, Settings, Strong, SystemError};
use stickslip_fmi_host::ExitWatch;
use stickslip_report::simulation::{Simulation, simulation_html, simulation_table};

use super::sweep::watch_temporary_folders;
use super::{check_page, colored, list, settings};
use crate::output::{Outputs, say};
use crate::{Failure, progress};
use assemble::{Assembly, assemble};

/// Arguments of `stickslip simulate`.
#[derive(clap::Args)]
pub struct Simulate {
    /// The system: an SSP 1.0 package (.ssp) or description (.ssd), or a single FMU
    system: PathBuf,
    /// Stop time (s); unless given, the one that the system or its FMUs propose
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    stop: Option<f64>,
    /// Start time (s)
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    start: Option<f64>,
    /// Communication step (s), under `adaptive` the first one; unless given, the shortest that an FMU proposes, or a
    /// thousandth of the simulated time
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    step: Option<f64>,
    /// How the FMUs exchange their values
    #[arg(long, value_enum, default_value_t)]
    algorithm: Choice,
    /// Order to which inputs are extrapolated over a step under `jacobi` and `gauss-seidel`: 0 (held), 1 or 2
    #[arg(long, value_name = "ORDER", default_value_t = 1, value_parser = clap::value_parser!(u32).range(0..=2))]
    extrapolation: u32,
    /// Method by which a step is iterated under `strong` and `adaptive`
    #[arg(long, value_enum, default_value_t)]
    iteration: Iteration,
    /// Tolerance of the coupling: relative error of a step under `adaptive` (1e-4 unless given), end of the iteration
    /// under `strong` (1e-8 unless given)
    #[arg(long, value_name = "RELATIVE", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Relative tolerance inside the FMUs; the FMUs' own unless given
    #[arg(long, value_name = "RELATIVE", allow_negative_numbers = true)]
    fmu_tolerance: Option<f64>,
    /// Sets a parameter, or the start value of an input: `contact.normal_load=120`; can be given several times
    #[arg(long = "set", value_name = "NAME=VALUE")]
    set: Vec<String>,
    /// Inputs over time: a CSV file with the column `time [s]` and columns named as inputs of the system, or as
    /// `component.variable [unit]`; linear between its rows
    #[arg(long, value_name = "FILE.csv")]
    input: Option<PathBuf>,
    /// Declares that the inputs FORCE and MOTION (`structure.force=contact.displacement`) exchange power, where several
    /// such pairs join the same two FMUs and units cannot tell; can be given several times
    #[arg(long, value_name = "FORCE=MOTION")]
    power: Vec<String>,
    /// Records `component.variable` besides the outputs; can be given several times
    #[arg(long, value_name = "NAME")]
    record: Vec<String>,
    /// Records every COUNT-th communication point
    #[arg(long, value_name = "COUNT", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..))]
    every: u64,
    /// Runs each FMU in its own process, so that the results so far are written after a crash; unless given, those that
    /// were not exported by this program
    #[arg(long)]
    isolate: bool,
    /// Runs all FMUs in this process: faster, but an FMU that crashes takes the results with it
    #[arg(long, conflicts_with = "isolate")]
    no_isolate: bool,
    /// File for the time histories: .csv, .json or .parquet
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Write the results as a self-contained HTML page
    #[arg(long, value_name = "FILE.html")]
    report: Option<PathBuf>,
}

/// How FMUs exchange their values.
#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Choice {
    /// All FMUs step at once, with extrapolated inputs
    Jacobi,
    /// One FMU after the other, each with the new values of those before
    GaussSeidel,
    /// Each step is repeated until the values agree
    #[default]
    Strong,
    /// The same; the step size follows the error and the energy residual
    Adaptive,
}

/// How a step is iterated.
#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Iteration {
    /// Anderson's acceleration
    #[default]
    Anderson,
    /// Relaxation by Aitken's factor
    Aitken,
    /// Newton's method with directional derivatives
    Newton,
    /// No acceleration
    FixedPoint,
}

/// Without a proposal, an experiment has so many steps.
const STEPS: f64 = 1000.0;
/// So many steps take hours, whatever the FMUs do in them.
const MOST_STEPS: f64 = 1e9;
/// Bytes of results that the user should know of.
const LARGE: f64 = 5e8;

impl Simulate {
    /// Simulates, and writes what it came to, whole or so far; nothing where it made no step.
    pub fn run(self) -> Result<(), Failure> {
        let destinations: Vec<&PathBuf> = self.out.iter().chain(&self.report).collect();
        let inputs: Vec<&PathBuf> = std::iter::once(&self.system).chain(&self.input).collect();
        Outputs::check(destinations, &inputs)?;
        check_page(self.report.as_deref())?;
        if let Some(out) = &self.out {
            files::check_kind(out)?;
        }
        watch_temporary_folders();
        let watch = ExitWatch::new(exit_expected);
        let assembly = assemble(&self)?;
        for remark in &assembly.remarks {
            tell!("note: {remark}");
        }
        let settings = self.settings(&assembly)?;
        let algorithm = self.algorithm_name();
        let Assembly { title, system, remarks, logs, outputs, .. } = assembly;
        let begin = Instant::now();
        let master = Master::new(system, settings.clone()).map_err(refused)?;
        self.tell_size(&master, &settings)?;
        let mut simulation = run::simulate(master, &settings, self.every);
        drop(watch);
        run::add_outputs(&mut simulation, outputs);
        simulation.seconds = begin.elapsed().as_secs_f64();
        simulation.title = title;
        simulation.algorithm = algorithm;
        simulation.notes.extend(logs.into_iter().flat_map(|(name, log)| said(&name, &log)));
        simulation.notes.extend(self.advice(&settings, &simulation));
        if simulation.report.steps == 0 && (simulation.failure.is_some() || simulation.report.interrupted) {
            return Err(nothing_done(&simulation));
        }
        self.present(&mut simulation, remarks)?;
        match simulation.failure {
            Some(reason) if !progress::interrupted() => Err(Failure::other(reason)),
            _ => Ok(()),
        }
    }

    /// Prints the table and writes the files, with the remarks that were printed before the run.
    fn present(&self, simulation: &mut Simulation, remarks: Vec<String>) -> Result<(), Failure> {
        say(&simulation_table(simulation, 100, colored()))?;
        simulation.notes.splice(..0, remarks);
        let mut outputs = Outputs::default();
        if let Some(path) = &self.out {
            outputs.add(path, files::written(path, simulation));
        }
        if let Some(path) = &self.report {
            let files: Vec<&Path> =
                std::iter::once(self.system.as_path()).chain(self.input.as_deref()).collect();
            outputs.add(path, simulation_html(simulation, &settings(&files)?));
        }
        list(&outputs.write()?)
    }

    fn settings(&self, assembly: &Assembly) -> Result<Settings, Failure> {
        let start = self.start.or(assembly.start).unwrap_or(0.0);
        let stop = self.stop.or(assembly.stop);
        let stop = stop.ok_or_else(|| {
            Failure::input("neither the system nor its FMUs propose a stop; give --stop SECONDS")
        })?;
        let span = stop - start;
        let step = self.step.or(assembly.step).unwrap_or(if span > 0.0 { span / STEPS } else { 1.0 });
        let mut settings = Settings::new(self.coupling(), step, stop);
        settings.start = start;
        settings.tolerance = self.fmu_tolerance;
        if self.algorithm == Choice::Adaptive {
            settings.adaptive = Some(Adaptive {
                tolerance: self.tolerance.unwrap_or(1e-4),
                smallest: step * 1e-4,
                largest: (span / 20.0).max(step),
                control: Control::Both,
            });
        }
        Ok(settings)
    }

    /// Refuses runs of too many steps, and warns of very large results.
    fn tell_size(&self, master: &Master, settings: &Settings) -> Result<(), Failure> {
        let Settings { start, stop, step, adaptive, .. } = settings;
        let steps = ((stop - start) / step).ceil();
        if adaptive.is_some() {
            return Ok(());
        }
        if steps > MOST_STEPS {
            return Err(Failure::input(format!(
                "a step of {step:e} s makes {steps:.0e} steps from {start} s to {stop} s; give a longer --step \
                 ({:e} s makes {STEPS} steps)",
                (stop - start) / STEPS
            )));
        }
        let columns = master.observed().len() + 1;
        let bytes = steps / self.every as f64 * columns as f64 * 8.0;
        if bytes > LARGE {
            tell!(
                "note: {steps:.1e} steps with {columns} columns need about {:.1} GB of memory, and more in a file; \
                 --every {:.0} records a thousandth of that",
                bytes * 1e-9,
                self.every as f64 * 1000.0
            );
        }
        Ok(())
    }

    /// What to try where an adapted step is short for long.
    fn advice(&self, settings: &Settings, simulation: &Simulation) -> Option<String> {
        let adaptive = settings.adaptive.as_ref()?;
        let report = &simulation.report;
        let (limit, times) = report.limits.first()?;
        let mean = (report.time - settings.start) / report.steps.max(1) as f64;
        if report.forced == 0 && mean > 0.1 * settings.step {
            return None;
        }
        let forced = match report.forced {
            0 => String::new(),
            forced => format!(
                "; {forced} of {} were beyond it but could not be shorter than {:.0e} s",
                report.steps, adaptive.smallest
            ),
        };
        Some(format!(
            "the tolerance of {:e} makes the steps {mean:.1e} s on average, most often because of {limit} ({times} \
             times){forced}; try a larger --tolerance, or --algorithm strong with a --step that resolves the motion",
            adaptive.tolerance
        ))
    }

    fn coupling(&self) -> Algorithm {
        let extrapolation = self.extrapolation;
        let method = match self.iteration {
            Iteration::Anderson => Method::Anderson { depth: 5 },
            Iteration::Aitken => Method::Aitken,
            Iteration::Newton => Method::Newton,
            Iteration::FixedPoint => Method::FixedPoint,
        };
        let strong = Strong { method, ..Strong::default() };
        match self.algorithm {
            Choice::Jacobi => Algorithm::Jacobi { extrapolation },
            Choice::GaussSeidel => Algorithm::GaussSeidel { extrapolation, order: None },
            Choice::Strong => {
                Algorithm::Strong(Strong { tolerance: self.tolerance.unwrap_or(strong.tolerance), ..strong })
            }
            Choice::Adaptive => Algorithm::Strong(strong),
        }
    }

    fn algorithm_name(&self) -> String {
        let name = |value: &dyn Fn() -> Option<clap::builder::PossibleValue>| {
            value().map_or_else(String::new, |value| value.get_name().to_owned())
        };
        let own = name(&|| self.algorithm.to_possible_value());
        match self.algorithm {
            Choice::Jacobi | Choice::GaussSeidel => format!("{own}, extrapolation {}", self.extrapolation),
            Choice::Strong | Choice::Adaptive => {
                format!("{own}, {}", name(&|| self.iteration.to_possible_value()))
            }
        }
    }
}

/// Whether the program itself ends; if not, an FMU has called `exit`, and this says so.
fn exit_expected() -> bool {
    if !progress::interrupted() {
        let _ = writeln!(
            std::io::stderr(),
            "error: an FMU has ended the program by calling `exit`; nothing was written; without --no-isolate the results \
             so far would be"
        );
        stickslip_readers::archive::remove_unpacked();
    }
    progress::interrupted()
}

/// A system that cannot be what is asked for.
fn refused(error: SystemError) -> Failure {
    Failure::input(error.to_string())
}

/// The end of a run before its start, for which the input is to blame if nobody interrupted it.
fn not_begun(message: String) -> Failure {
    Failure { code: if progress::interrupted() { 130 } else { 2 }, ..Failure::input(message) }
}

/// The end of a run that made no step, and so came to nothing.
fn nothing_done(simulation: &Simulation) -> Failure {
    let reason = simulation.failure.as_deref().unwrap_or("interrupted before the first step");
    let message = format!("{reason}; nothing was written");
    if simulation.time.is_empty() || progress::interrupted() {
        not_begun(message)
    } else {
        Failure::other(message)
    }
}

/// What an FMU said that the user should know.
fn said(name: &str, log: &stickslip_fmi_host::Log) -> Vec<String> {
    use stickslip_fmi_host::Status;
    /// Messages shown of one FMU.
    const SHOWN: usize = 5;
    let messages: Vec<_> =
        log.messages().into_iter().filter(|message| message.status != Status::Ok).collect();
    let mut lines: Vec<String> = messages
        .iter()
        .take(SHOWN)
        .map(|message| match message.times {
            1 => format!("{name} says: {}", message.text),
            times => format!("{name} says {times} times: {}", message.text),
        })
        .collect();
    if messages.len() > SHOWN {
        lines.push(format!("{name} says {} more", messages.len() - SHOWN));
    }
    lines
}
