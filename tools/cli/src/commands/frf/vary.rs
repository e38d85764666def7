//! `stickslip frf --vary`: the response at one frequency, or a resonance, over a parameter or the force.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use stickslip::document::suggestion;
use stickslip::harmonic::{
    Assembly, Curve, CurveSettings, Ending, HarmonicError, Point, TrackedQuantity, Tracking, level_response,
    parameter_response, track_levels, track_parameter,
};
use stickslip::model::Model;
use stickslip_report::{ParameterReport, Settings, parameter_html};

use super::request::node;
use super::setup::Setup;
use super::{FrequencyUnit, Frf};
use crate::commands::{check_destinations, list, settings};
use crate::output::{Outputs, say};
use crate::{Failure, progress};

/// Arguments that go with `--vary`.
#[derive(clap::Args)]
pub struct Vary {
    /// Follow the response at one frequency over a parameter of the model instead, as
    /// contact.friction_coefficient=0.05:0.5, or over the force (N), as force=0.1:2; turning points are passed
    #[arg(long, value_name = "PATH=FROM:TO", requires = "at", conflicts_with_all = ["from", "to", "hold", "levels", "excite"])]
    vary: Option<String>,
    /// The frequency (in --unit) for --vary; with --track a frequency near the resonance at the first value
    #[arg(long, value_name = "FREQUENCY", requires = "vary", allow_negative_numbers = true)]
    at: Option<f64>,
    /// With --vary, follow a resonance instead of one frequency, at 51 values: peak:m1, where the displacement of a
    /// mass or sensor is largest, or phase:x=0.55, where its first harmonic is a quarter period behind the force
    #[arg(long, value_name = "QUANTITY:NODE", requires = "vary")]
    track: Option<String>,
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

/// The path that stands for the amplitude of the force.
const FORCE: &str = "force";
/// Values at which a resonance is located.
const TRACKED: usize = 51;

/// What is followed, checked.
struct Request<'a> {
    path: &'a str,
    range: [f64; 2],
    angular_frequency: f64,
    /// Amplitude of the force (N), unless it is what varies.
    force: Option<f64>,
    tracking: Option<Tracking>,
    settings: CurveSettings,
}

/// Follows the curve.
pub fn run(command: &Frf, model: &Model) -> Result<(), Failure> {
    let Vary { at, track, csv, .. } = &command.vary;
    check_destinations(&command.files, csv, &[&command.model])?;
    let setup = Setup::new(model, None)?;
    let request = request(command, setup.nodes())?;
    let curve = follow(model, setup.assembly(), &request)?;
    let path = request.path;
    let unit: FrequencyUnit = command.unit.into();
    let parameter = model.parameters().into_iter().find(|parameter| parameter.path == path);
    let report = ParameterReport {
        title: format!("Response of {} over {path}", command.model.display()),
        path,
        parameter_unit: match parameter {
            Some(parameter) => parameter.quantity.unit,
            None if path == FORCE => "N",
            None => "1",
        },
        range: request.range,
        unit,
        angular_frequency: request.angular_frequency,
        force: request.force,
        tracked: track.as_deref(),
        curve: &curve,
    };
    say(&table(&report))?;
    let how = settings(&[Path::new(&command.model)])?;
    let mut outputs = Outputs::default();
    if let Some(file) = &command.files.json {
        outputs.add(file, format!("{:#}\n", document(&report, *at, &how)));
    }
    if let Some(file) = &command.files.report {
        outputs.add(file, parameter_html(&report, &how));
    }
    if let Some(file) = csv {
        outputs.add(file, comma_separated(&report));
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

fn request<'a>(command: &'a Frf, nodes: &[String]) -> Result<Request<'a>, Failure> {
    let Vary { vary, at, track, .. } = &command.vary;
    let (path, range) = parsed(vary.as_deref().unwrap_or_default())?;
    let frequency = at.filter(|value| value.is_finite() && *value > 0.0);
    let frequency =
        frequency.ok_or_else(|| Failure::input("--at: the frequency must be a positive number"))?;
    let angular_frequency = FrequencyUnit::from(command.unit).to_angular(frequency);
    let force = match (path, command.force) {
        (FORCE, Some(_)) => {
            return Err(Failure::input("--vary force and --force: the force is either varied or given"));
        }
        (FORCE, None) => None,
        (_, force) => Some(force.unwrap_or(1.0)),
    };
    let tracking = track.as_deref().map(|text| tracking(text, nodes, angular_frequency)).transpose()?;
    Ok(Request { path, range, angular_frequency, force, tracking, settings: command.settings()? })
}

/// `peak:m1` or `phase:x=0.55`.
fn tracking(text: &str, nodes: &[String], angular_frequency: f64) -> Result<Tracking, Failure> {
    let wrong = |reason: String| Failure::input(format!("--track {text}: {reason}"));
    let (quantity, name) =
        text.split_once(':').ok_or_else(|| wrong("write it as peak:m1 or phase:x=0.55".to_owned()))?;
    let quantity = match quantity {
        "peak" => TrackedQuantity::Peak,
        "phase" => TrackedQuantity::Phase,
        _ => {
            let help = suggestion(quantity, &["peak", "phase"], "quantities");
            return Err(wrong(format!("`{quantity}` cannot be tracked; {help}")));
        }
    };
    Ok(Tracking { quantity, node: node(name, nodes).map_err(wrong)?, angular_frequency })
}

fn follow(model: &Model, assembly: &Assembly, request: &Request) -> Result<Curve, Failure> {
    let Request { path, range, angular_frequency, force, tracking, settings } = request;
    let values = values(*range);
    let bar = progress::spinner("frf");
    let mut watch = |point: &Point| {
        let value = if force.is_some() { point.parameter } else { point.level };
        bar.set_message(format!("{path} = {value}"));
        !progress::interrupted_after_a_step()
    };
    let found = match (force, tracking) {
        (None, None) => {
            level_response(assembly, *angular_frequency, range[0], range[1], settings, &mut watch)
        }
        (None, Some(tracking)) => track_levels(assembly, tracking, &values, settings, &mut watch),
        (Some(force), tracking) => {
            let over = model.assembly_over(path).map_err(|error| {
                let help = error.help.map_or(String::new(), |help| format!("; {help}"));
                Failure::input(format!("--vary {path}: {}{help}", error.message))
            })?;
            match tracking {
                None => parameter_response(&over, *angular_frequency, *force, *range, settings, &mut watch),
                Some(tracking) => track_parameter(&over, *force, tracking, &values, settings, &mut watch),
            }
        }
    };
    bar.finish_and_clear();
    let mut curve = found.map_err(|error| match error {
        HarmonicError::InvalidInput(_) | HarmonicError::Model(_) => Failure::input(error.to_string()),
        HarmonicError::Interrupted => Failure::interrupted(),
        _ => Failure::other(error.to_string()),
    })?;
    if force.is_none() {
        curve.points.iter_mut().for_each(|point| point.parameter = point.level);
    }
    Ok(curve)
}

/// Values of a range at which a resonance is located: evenly spaced by ratio or, across zero, by difference.
fn values([from, to]: [f64; 2]) -> Vec<f64> {
    let fraction = |index: usize| index as f64 / (TRACKED - 1) as f64;
    let value = |index: usize| match index {
        _ if index + 1 == TRACKED => to,
        _ if from * to > 0.0 => from * (to / from).powf(fraction(index)),
        _ => from + (to - from) * fraction(index),
    };
    (0..TRACKED).map(value).collect()
}

fn document(report: &ParameterReport, frequency: Option<f64>, how: &Settings) -> Value {
    let points = report.curve.points.iter().map(|point| {
        json!({
            "value": point.parameter, "frequency": report.unit.of(point.angular_frequency), "amplitude": point.amplitude, "stable": point.stable,
            "dissipated_energy": point.dissipated_energy(), "error_estimate": point.error_estimate,
        })
    });
    json!({
        "schema": "stickslip.parameter/1", "command": how.command, "version": how.version, "path": report.path,
        "nodes": report.curve.nodes, "frequency": frequency, "unit": report.unit.name(), "force": report.force,
        "tracked": report.tracked,
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

fn table(report: &ParameterReport) -> String {
    let curve = report.curve;
    let mut text = format!("{:>32}", report.path);
    if report.tracked.is_some() {
        let _ = write!(text, "  {:>17}", format!("frequency ({})", report.unit.name()));
    }
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
        if report.tracked.is_some() {
            let _ = write!(text, "  {:>17.6}", report.unit.of(point.angular_frequency));
        }
        for amplitude in &point.amplitude {
            let _ = write!(text, "  {amplitude:>14.6e}");
        }
        let _ =
            writeln!(text, "  {:>6}", point.stable.map_or("-", |stable| if stable { "yes" } else { "no" }));
    }
    let _ = writeln!(text, "{} responses", curve.points.len());
    text
}

fn comma_separated(report: &ParameterReport) -> String {
    let mut text = report.path.to_owned();
    if report.tracked.is_some() {
        let _ = write!(text, ",frequency [{}]", report.unit.name());
    }
    for node in &report.curve.nodes {
        let _ = write!(text, ",amplitude:{node} [m]");
    }
    text.push('\n');
    for point in &report.curve.points {
        let _ = write!(text, "{}", point.parameter);
        if report.tracked.is_some() {
            let _ = write!(text, ",{}", report.unit.of(point.angular_frequency));
        }
        for amplitude in &point.amplitude {
            let _ = write!(text, ",{amplitude}");
        }
        text.push('\n');
    }
    text
}
