//! `stickslip modes`

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use stickslip::harmonic::{
    Assembly, CurveSettings, HarmonicError, Interrupt, ModeRange, NonlinearMode, nonlinear_mode,
};
use stickslip::model::Structure;
use stickslip_report::{ModeReport, Settings, mode_html};

use super::frf::node;
use super::{check_destinations, list, read_model, settings};
use crate::output::{Outputs, say};
use crate::{Failure, ResultFiles, progress};

/// Arguments of `stickslip modes`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip modes model.toml --from 0.01 --to 1
  stickslip modes beam.toml --mode 1 --node x=0.55 --from 1e-6 --to 1e-3 --report mode.html

Free vibrations of one amplitude after the other, whose losses an artificial negative damping makes good: the resonances
of the forced structure lie on them where damping is small.

Exit codes: 0 done; 1 no vibration was found from some amplitude on (what was found is written); 2 bad input; 130
interrupted by Ctrl-C (what was found is written).")]
pub struct Modes {
    /// The model file (an oscillator, a beam or a pin rig), or an FMU that carries one
    model: PathBuf,
    /// Which mode, counted from 1 by the frequencies of the structure with a contact that sticks
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    mode: usize,
    /// Mass or sensor whose first harmonic is the amplitude; the first one if not given
    #[arg(long, value_name = "NODE")]
    node: Option<String>,
    /// First amplitude (m)
    #[arg(long, value_name = "AMPLITUDE", allow_negative_numbers = true)]
    from: f64,
    /// Last amplitude (m)
    #[arg(long, value_name = "AMPLITUDE", allow_negative_numbers = true)]
    to: f64,
    /// Number of amplitudes, evenly spaced by ratio
    #[arg(long, value_name = "COUNT", default_value_t = 25)]
    points: usize,
    /// Harmonics of the vibration
    #[arg(long, value_name = "H", default_value_t = 21)]
    harmonics: usize,
    #[command(flatten)]
    files: ResultFiles,
    /// Write the results as a table
    #[arg(long, value_name = "FILE.csv")]
    csv: Option<PathBuf>,
}

impl Modes {
    /// Follows the mode.
    pub fn run(self) -> Result<(), Failure> {
        check_destinations(&self.files, &self.csv, &[&self.model])?;
        let model = read_model(&self.model)?;
        if model.structure == Structure::Prescribed {
            return Err(Failure::input(
                "a contact alone has no modes; the kind must be \"oscillator\", \"beam\" or \"pin_rig\"",
            ));
        }
        let assembly = Assembly::new(model.system().map_err(|error| Failure::input(error.to_string()))?);
        let nodes = assembly.nodes();
        let range = self.range(&nodes)?;
        let defaults = CurveSettings::default();
        let asked = CurveSettings {
            harmonics: self.harmonics,
            stability: false,
            interrupt: Some(Interrupt(progress::interrupted)),
            ..defaults
        };
        let bar = progress::spinner("modes");
        let found = nonlinear_mode(&assembly, &range, &asked, &mut |point| {
            bar.set_message(format!("amplitude {:.3e} m", point.amplitude));
            !progress::interrupted_after_a_step()
        });
        bar.finish_and_clear();
        let mode = found.map_err(|error| match error {
            HarmonicError::InvalidInput(reason) => Failure::input(reason),
            HarmonicError::Interrupted => Failure::interrupted(),
            _ => Failure::other(error.to_string()),
        })?;
        say(&table(&nodes[range.node], &mode))?;
        let mut outputs = Outputs::default();
        let how = settings(&[Path::new(&self.model)])?;
        if let Some(path) = &self.files.json {
            outputs.add(path, format!("{:#}\n", self.document(&nodes, range.node, &mode, &how)));
        }
        if let Some(path) = &self.files.report {
            outputs.add(path, mode_html(&self.report(&nodes, range.node, &mode), &how));
        }
        if let Some(path) = &self.csv {
            outputs.add(path, comma_separated(&mode));
        }
        list(&outputs.write()?)?;
        if progress::interrupted() {
            tell!("note: interrupted; these are the results so far");
        } else if let Some(error) = mode.lost {
            return Err(Failure::other(format!("no vibration of the next amplitude was found: {error}")));
        }
        Ok(())
    }

    fn range(&self, nodes: &[String]) -> Result<ModeRange, Failure> {
        let node = match &self.node {
            None => 0,
            Some(name) => node(name, nodes).map_err(|error| Failure::input(format!("--node: {error}")))?,
        };
        let mode =
            self.mode.checked_sub(1).ok_or_else(|| Failure::input("--mode: modes are counted from 1"))?;
        Ok(ModeRange { mode, node, amplitudes: [self.from, self.to], points: self.points })
    }

    fn report<'a>(&self, nodes: &'a [String], node: usize, mode: &'a NonlinearMode) -> ModeReport<'a> {
        let title = format!("Mode {} of {}", self.mode, self.model.display());
        ModeReport { title, nodes, node, asked: self.points, harmonics: self.harmonics, mode }
    }

    fn document(&self, nodes: &[String], node: usize, mode: &NonlinearMode, how: &Settings) -> Value {
        let points: Vec<Value> = mode
            .points
            .iter()
            .map(|point| {
                json!({
                    "amplitude": point.amplitude, "omega": point.angular_frequency,
                    "frequency": point.angular_frequency / TAU, "damping_ratio": point.damping_ratio,
                    "dissipated_energy": point.dissipated_energy, "shape": point.point.amplitude,
                    "error_estimate": point.point.error_estimate,
                })
            })
            .collect();
        json!({
            "schema": "stickslip.modes/1", "command": how.command, "version": how.version, "mode": self.mode,
            "node": nodes[node], "nodes": nodes, "linear_omega": mode.angular_frequency,
            "complete": mode.points.len() == self.points, "points": points,
        })
    }
}

fn table(node: &str, mode: &NonlinearMode) -> String {
    let mut text =
        format!("linear: {:.6} Hz with the contact as it is at rest\n", mode.angular_frequency / TAU);
    let _ = writeln!(
        text,
        "{:>14}  {:>14}  {:>12}  {:>18}",
        format!("{node} (m)"),
        "frequency (Hz)",
        "damping (%)",
        "loss per cycle (J)"
    );
    for point in &mode.points {
        let _ = writeln!(
            text,
            "{:>14.6e}  {:>14.6}  {:>12.4}  {:>18.6e}",
            point.amplitude,
            point.angular_frequency / TAU,
            100.0 * point.damping_ratio,
            point.dissipated_energy
        );
    }
    text
}

fn comma_separated(mode: &NonlinearMode) -> String {
    let mut text = String::from("amplitude [m],frequency [Hz],damping_ratio [1],dissipated_energy [J]\n");
    for point in &mode.points {
        let frequency = point.angular_frequency / TAU;
        let _ = writeln!(
            text,
            "{},{frequency},{},{}",
            point.amplitude, point.damping_ratio, point.dissipated_energy
        );
    }
    text
}
