//! `stickslip frf`

mod held;
mod loops;
mod request;
mod setup;
mod vary;

use std::path::{Path, PathBuf};
use std::time::Instant;

use indicatif::ProgressBar;
use stickslip::harmonic::{Assembly, Curve, Ending, HarmonicError, frequency_response};
use stickslip_report::responses::{
    FrequencyUnit, Held, ResponseCurve, Responses, responses_html, responses_json, responses_table,
};

use self::request::Request;
pub use self::request::node;
use self::setup::Setup;
use self::vary::Vary;
use super::{check_destinations, list, read_model, settings};
use crate::output::{Outputs, say};
use crate::{Failure, ResultFiles, progress};

/// Arguments of `stickslip frf`.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stickslip frf model.toml --from 0.2 --to 2 --unit rad/s --force 0.4 --report frf.html
  stickslip frf model.toml --from 0.2 --to 2 --unit rad/s --levels 0.05,0.1,0.4 --json frf.json
  stickslip frf beam.toml --from 45 --to 60 --hold acceleration:x=0.55=70
  stickslip frf beam.toml --from 45 --to 60 --hold acceleration:x=0.55 --levels 10,30,70
  stickslip frf model.toml --vary contact.friction_coefficient=0.05:0.5 --at 0.6 --unit rad/s --force 0.4
  stickslip frf model.toml --vary force=0.01:2 --at 0.6 --unit rad/s --track peak:m1

Exit codes: 0 done; 1 a curve ended before its end (what was found is written); 2 bad input (nothing is
written); 130 interrupted by Ctrl-C (what was found is written).")]
pub struct Frf {
    /// The model file (an oscillator, a beam or a pin rig), or an FMU that carries one
    model: PathBuf,
    /// First frequency (in --unit)
    #[arg(long, value_name = "FREQUENCY", allow_negative_numbers = true, required_unless_present = "vary")]
    from: Option<f64>,
    /// Last frequency (in --unit)
    #[arg(long, value_name = "FREQUENCY", allow_negative_numbers = true, required_unless_present = "vary")]
    to: Option<f64>,
    /// Unit of --from, --to and of the output; JSON has both units
    #[arg(long, value_enum, default_value_t = Unit::Hertz)]
    unit: Unit,
    /// Amplitude of the harmonic force (N); 1 N unless given
    #[arg(long, value_name = "N", conflicts_with_all = ["hold", "levels"], allow_negative_numbers = true)]
    force: Option<f64>,
    /// Several amplitudes, a curve for each: of the force (N), or of what --hold names (SI)
    #[arg(long, value_name = "A,B,...", value_delimiter = ',', value_parser = level, allow_negative_numbers = true)]
    levels: Vec<f64>,
    /// Hold the first harmonic of a response instead of the force: displacement (m), velocity (m/s) or
    /// acceleration (m/s²) of a mass or of a sensor, as acceleration:x=0.55=70 or displacement:m1=1e-3
    #[arg(long, value_name = "QUANTITY:NODE[=AMPLITUDE]")]
    hold: Option<String>,
    /// Mass that the force acts on (oscillators only); the model's excitation unless given
    #[arg(long, value_name = "MASS")]
    excite: Option<String>,
    /// Harmonics of the response; with --tolerance the number to start with
    #[arg(long, value_name = "H", default_value_t = 21)]
    harmonics: usize,
    /// Add harmonics until the estimated truncation error of the displacements is below this fraction of the
    /// amplitude, up to 101 harmonics or --harmonics if that is more. Without it the number of harmonics
    /// is fixed, and points with an estimate above 0.01 count as unresolved
    #[arg(long, value_name = "FRACTION", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// Do not compute stability. Without contacts and on sliders without play the response is always stable and no
    /// check is needed; otherwise stability is computed up to 60 degrees of freedom, except where a point would
    /// take longer than half a second
    #[arg(long)]
    no_stability: bool,
    #[command(flatten)]
    vary: Vary,
    #[command(flatten)]
    files: ResultFiles,
}

/// A level of a list, which may have spaces about it.
fn level(text: &str) -> Result<f64, String> {
    text.trim().parse().map_err(|_| "not a number".to_owned())
}

/// Units of frequency.
#[derive(Clone, Copy, clap::ValueEnum)]
enum Unit {
    #[value(name = "Hz")]
    Hertz,
    #[value(name = "rad/s")]
    RadiansPerSecond,
}

impl From<Unit> for FrequencyUnit {
    fn from(unit: Unit) -> Self {
        match unit {
            Unit::Hertz => FrequencyUnit::Hertz,
            Unit::RadiansPerSecond => FrequencyUnit::RadiansPerSecond,
        }
    }
}

impl Frf {
    /// Follows the curves.
    pub fn run(self) -> Result<(), Failure> {
        check_destinations(&self.files, None, &[&self.model])?;
        let model = read_model(&self.model)?;
        if self.vary.is_asked() {
            return vary::run(&self, &model);
        }
        let setup = Setup::new(&model, self.excite.as_deref())?;
        let request = Request::new(&self, setup.nodes())?;
        let assembly = setup.assembly();
        let started = Instant::now();
        let curves = follow_all(assembly, &request, setup.losses().contact > 0)?;
        let responses = Responses {
            title: format!("Response of {}", self.model.display()),
            unit: request.unit,
            range: request.range,
            held: request
                .hold
                .as_ref()
                .map(|hold| Held { node: setup.nodes()[hold.node].clone(), derivative: hold.derivative }),
            harmonics: self.harmonics,
            tolerance: self.tolerance,
            stability: !self.no_stability,
            losses: setup.losses(),
            curves,
            seconds: started.elapsed().as_secs_f64(),
        };
        self.present(&responses)?;
        if progress::interrupted() {
            tell!("note: interrupted; these are the results so far");
        } else if !responses.complete() {
            return Err(Failure::other("a curve ended before its end; what was found is shown"));
        }
        Ok(())
    }

    fn present(&self, responses: &Responses) -> Result<(), Failure> {
        say(&responses_table(responses, 80, crate::terminal::colored()))?;
        let settings = settings(&[Path::new(&self.model)])?;
        let mut outputs = Outputs::default();
        if let Some(path) = &self.files.json {
            outputs.add(path, format!("{:#}\n", responses_json(responses, &settings)));
        }
        if let Some(path) = &self.files.report {
            outputs.add(path, responses_html(responses, &settings));
        }
        list(&outputs.write()?)
    }
}

/// One curve after the other, until all are done or Ctrl-C.
fn follow_all(
    assembly: &Assembly,
    request: &Request,
    has_contact: bool,
) -> Result<Vec<ResponseCurve>, Failure> {
    let bar = progress::spinner("frf");
    let mut curves = Vec::new();
    for (index, &level) in request.levels.iter().enumerate() {
        if progress::interrupted() {
            break;
        }
        let which = match request.levels.len() {
            1 => String::new(),
            count => format!("curve {} of {count}, ", index + 1),
        };
        let curve = follow(assembly, request, (level, has_contact), &which, &bar)?;
        // Of a curve that was interrupted before its first point there is nothing to show.
        if curve.curve.ending != Ending::Interrupted || !curve.curve.points.is_empty() {
            curves.push(curve);
        }
    }
    bar.finish_and_clear();
    if curves.is_empty() { Err(Failure::interrupted()) } else { Ok(curves) }
}

fn follow(
    assembly: &Assembly,
    request: &Request,
    (level, has_contact): (f64, bool),
    which: &str,
    bar: &ProgressBar,
) -> Result<ResponseCurve, Failure> {
    let started = Instant::now();
    let control = request.control(level);
    let mut count = 0_usize;
    let mut shown: Option<Instant> = None;
    let found = frequency_response(
        assembly,
        request.range.0,
        request.range.1,
        &control,
        &request.settings,
        &mut |point| {
            count += 1;
            // Points come by the ten thousand a second; a terminal need not follow.
            if shown.is_none_or(|last| last.elapsed().as_millis() > 50) {
                shown = Some(Instant::now());
                let place = request.unit.shown(point.angular_frequency);
                bar.set_message(format!("{which}{count} points, at {place}"));
            }
            !progress::interrupted_after_a_step()
        },
    );
    let (mut curve, failure) = match found {
        Ok(curve) => (curve, None),
        Err(HarmonicError::InvalidInput(reason)) => return Err(Failure::input(reason)),
        Err(HarmonicError::Interrupted) => (Curve { ending: Ending::Interrupted, ..empty(request) }, None),
        Err(error) => (empty(request), Some(error.to_string())),
    };
    let (mut phase_resonances, mut loops) = (Vec::new(), Vec::new());
    if let Some(hold) = request.hold.filter(|_| !progress::interrupted()) {
        phase_resonances = held::phase_resonances(assembly, request, hold, &control, &curve);
        curve.peaks = held::resonances(assembly, request, hold, &control, &curve);
    }
    if has_contact && !progress::interrupted() {
        loops = loops::at_peaks(assembly, request, &control, level, &curve);
    }
    let seconds = started.elapsed().as_secs_f64();
    Ok(ResponseCurve { level, curve, phase_resonances, loops, failure, seconds })
}

/// A curve of which not even the first point was found.
fn empty(request: &Request) -> Curve {
    Curve {
        nodes: request.nodes.clone(),
        points: Vec::new(),
        peaks: Vec::new(),
        folds: Vec::new(),
        ending: Ending::Stuck,
    }
}
