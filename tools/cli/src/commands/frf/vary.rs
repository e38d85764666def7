//! `stickslip frf --vary`: the response at one frequency over a parameter.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use stickslip::harmonic::{AssemblyAt, Curve, CurveSettings, Ending, HarmonicError, parameter_response};
use stickslip::model::Model;
use stickslip_report::{ParameterReport, Settings, parameter_html};

use super::setup::Setup;
use super::{FrequencyUnit, Frf};
use crate::commands::{check_destinations, list, settings};
use crate::output::{Outputs, say};
use crate::{Failure, progress};

/// Arguments that go with `--vary`.
#[derive(clap::Args)]
pub struct Vary {
    /// Follow the response at one frequency over a parameter of the model instead, as
    /// contact.friction_coefficient=0.05:0.5; turning points are passed
    #[arg(long, value_name = "PATH=FROM:TO", requires = "at", conflicts_with_all = ["from", "to", "hold", "levels", "excite"])]
    vary: Option<String>,
    /// The frequency (in --unit) for --vary
    #[arg(long, value_name = "FREQUENCY", requires = "vary", allow_negative_numbers = true)]
    at: Option<f64>,
    /// Write the curve of --vary as a table
    #[arg(long, value_name = "FILE.csv", requires = "vary")]
    csv: Option<PathBuf>,
}

impl Vary {
    /// Whether there is something to vary.
    pub fn is_asked(&self) -> bool {
        self.vary.is_some()
    }
}

/// Follows the curve.
pub fn run(command: &Frf, model: &Model) -> Result<(), Failure> {
    let Vary { vary, at, csv } = &command.vary;
    let (path, range) = parsed(vary.as_deref().unwrap_or_default())?;
    check_destinations(&command.files, csv, &[&command.model])?;
    let unit: FrequencyUnit = command.unit.into();
    let frequency = at.filter(|value| value.is_finite() && *value > 0.0);
    let frequency =
        frequency.ok_or_else(|| Failure::input("--at: the frequency must be a positive number"))?;
    Setup::new(model, None)?;
    let over = model.assembly_over(path).map_err(|error| {
        Failure::input(format!(
            "--vary {path}: {}{}",
            error.message,
            error.help.map_or(String::new(), |help| format!("; {help}"))
        ))
    })?;
    let defaults = CurveSettings::default();
    let asked = CurveSettings {
        harmonics: command.harmonics,
        truncation: command.tolerance,
        max_harmonics: defaults.max_harmonics.max(command.harmonics),
        stability: !command.no_stability,
        ..defaults
    };
    let force = command.force.unwrap_or(1.0);
    let curve = follow(&over, unit.to_angular(frequency), force, (path, range), &asked)?;
    say(&table(path, &curve))?;
    let how = settings(&[Path::new(&command.model)])?;
    let parameter = model.parameters().into_iter().find(|parameter| parameter.path == path);
    let report = ParameterReport {
        title: format!("Response of {} over {path}", command.model.display()),
        path,
        parameter_unit: parameter.map_or("1", |parameter| parameter.quantity.unit),
        range,
        unit,
        angular_frequency: unit.to_angular(frequency),
        force,
        curve: &curve,
    };
    let mut outputs = Outputs::default();
    if let Some(file) = &command.files.json {
        outputs.add(file, format!("{:#}\n", document(&report, frequency, &how)));
    }
    if let Some(file) = &command.files.report {
        outputs.add(file, parameter_html(&report, &how));
    }
    if let Some(file) = csv {
        outputs.add(file, comma_separated(path, &curve));
    }
    list(&outputs.write()?)?;
    match curve.ending {
        Ending::Complete => Ok(()),
        Ending::Interrupted => {
            tell!("note: interrupted; these are the results so far");
            Ok(())
        }
        _ => Err(Failure::other("the curve ended before its end; what was found is shown")),
    }
}

fn follow(
    over: &AssemblyAt,
    angular_frequency: f64,
    force: f64,
    (path, range): (&str, [f64; 2]),
    asked: &CurveSettings,
) -> Result<Curve, Failure> {
    let bar = progress::spinner("frf");
    let found = parameter_response(over, angular_frequency, force, range, asked, &mut |point| {
        bar.set_message(format!("{path} = {}", point.parameter));
        !progress::interrupted()
    });
    bar.finish_and_clear();
    found.map_err(|error| match error {
        HarmonicError::InvalidInput(_) | HarmonicError::Model(_) => Failure::input(error.to_string()),
        _ => Failure::other(error.to_string()),
    })
}

fn document(report: &ParameterReport, frequency: f64, how: &Settings) -> Value {
    let points = report.curve.points.iter().map(|point| {
        json!({
            "value": point.parameter, "amplitude": point.amplitude, "stable": point.stable,
            "dissipated_energy": point.dissipated_energy(), "error_estimate": point.error_estimate,
        })
    });
    json!({
        "schema": "stickslip.parameter/1", "command": how.command, "version": how.version, "path": report.path,
        "nodes": report.curve.nodes, "frequency": frequency, "unit": report.unit.name(), "force": report.force,
        "complete": report.curve.ending == Ending::Complete, "points": points.collect::<Vec<_>>(),
    })
}

/// `contact.friction_coefficient=0.05:0.5`.
fn parsed(text: &str) -> Result<(&str, [f64; 2]), Failure> {
    let wrong =
        || Failure::input(format!("--vary {text}: write it as contact.friction_coefficient=0.05:0.5"));
    let (path, range) = text.split_once('=').ok_or_else(wrong)?;
    let (from, to) = range.split_once(':').ok_or_else(wrong)?;
    let number = |text: &str| text.trim().parse::<f64>().map_err(|_| wrong());
    Ok((path.trim(), [number(from)?, number(to)?]))
}

/// At most this many rows; the files have all.
const ROWS: usize = 25;

fn table(path: &str, curve: &Curve) -> String {
    let mut text = format!("{path:>32}");
    for node in &curve.nodes {
        let _ = write!(text, "  {:>14}", format!("{node} (m)"));
    }
    text.push_str("  stable\n");
    let last = curve.points.len().saturating_sub(1);
    let every = curve.points.len().div_ceil(ROWS).max(1);
    for (index, point) in curve.points.iter().enumerate() {
        if index % every != 0 && index != last {
            continue;
        }
        let _ = write!(text, "{:>32.6e}", point.parameter);
        for amplitude in &point.amplitude {
            let _ = write!(text, "  {amplitude:>14.6e}");
        }
        let _ =
            writeln!(text, "  {:>6}", point.stable.map_or("-", |stable| if stable { "yes" } else { "no" }));
    }
    let _ = writeln!(text, "{} responses", curve.points.len());
    text
}

fn comma_separated(path: &str, curve: &Curve) -> String {
    let mut text = path.to_owned();
    for node in &curve.nodes {
        let _ = write!(text, ",amplitude:{node} [m]");
    }
    text.push('\n');
    for point in &curve.points {
        let _ = write!(text, "{}", point.parameter);
        for amplitude in &point.amplitude {
            let _ = write!(text, ",{amplitude}");
        }
        text.push('\n');
    }
    text
}
