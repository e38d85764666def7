//! From records of a rig to an FMU, and a level that it has not seen.

use std::f64::consts::TAU;
use std::path::Path;

use stickslip::data::{Channel, Dataset, Record};
use stickslip::fmi::{Instance, Setup};
use stickslip::harmonic::fourier::value;
use stickslip::identify::{IdentifyOptions, harmonics, identify};
use stickslip::model::Model;
use stickslip::rig::{TestKind, test_on};
use stickslip_report::document::{Axis, Block, Line, Panel, Plot, Section, Stroke, palette};

use crate::{Failure, progress};

/// Of the record and of the FMU's motion.
const HARMONICS: usize = 9;
/// Periods from rest until the motion repeats, those that are looked at, and steps of each.
const SETTLING: usize = 150;
const LAST: usize = 8;
const STEPS: usize = 256;

/// The identified model, what it predicts, in a sentence, and the picture of it.
pub(super) struct Unseen {
    pub model: Model,
    pub summary: String,
    pub section: Section,
}

/// Tests the example's plans in `example` on the rig, identifies the contact, and drives the FMU's model by the force of the
/// record that it has not seen; `None` after an interrupt.
pub(super) fn predicted(example: &Path) -> Result<Option<Unseen>, Failure> {
    let failed = |error: String| Failure::other(error);
    let Some((model, records)) = tested(&example.join("rig.toml"))? else { return Ok(None) };
    let Some((_, unseen)) = tested(&example.join("unseen-level.toml"))? else { return Ok(None) };
    let dataset = Dataset { title: None, records };
    let options = IdentifyOptions { interrupt: Some(&progress::interrupted), ..IdentifyOptions::default() };
    let found = identify(&model, &dataset, &options);
    if progress::interrupted() {
        return Ok(None);
    }
    let found = found.map_err(|error| failed(error.to_string()))?;
    let model = found.model.ok_or_else(|| failed("no law describes the contact of the rig".to_owned()))?;
    let motions = Motion::under(&model, &unseen[0]).map_err(failed)?;
    let worst = motions.iter().map(Motion::off).fold(0.0, f64::max);
    let summary = format!(
        "A contact identified from the accelerations of {} other levels predicts 45 m/s², as an FMU, within {:.1} %.",
        found.records.len(),
        100.0 * worst
    );
    let section = Section {
        id: "unseen".into(),
        title: "From accelerometers to an FMU: a level that it has not seen".into(),
        blocks: vec![Block::Text(summary.clone()), Block::Plots(vec![picture(&motions)])],
    };
    Ok(Some(Unseen { model, summary, section }))
}

/// The steady records of a plan, and its model.
fn tested(plan: &Path) -> Result<Option<(Model, Vec<Record>)>, Failure> {
    let mut plan = stickslip_readers::read_plan(plan).map_err(super::super::shown)?;
    plan.plan.tests.retain(|test| matches!(test.kind, TestKind::SteppedSine(_)));
    let made = test_on(&plan.model, &plan.plan, &mut |_| !progress::interrupted());
    if progress::interrupted() {
        return Ok(None);
    }
    Ok(Some((plan.model, made.map_err(|error| Failure::other(error.to_string()))?)))
}

/// A sensor's motion over a period: coefficients in the record and of the FMU.
struct Motion {
    name: String,
    unit: &'static str,
    recorded: Vec<f64>,
    predicted: Vec<f64>,
}

impl Motion {
    /// Every acceleration of `record` and of the FMU of `model` under the record's force, from rest until it repeats.
    fn under(model: &Model, record: &Record) -> Result<Vec<Self>, String> {
        let times = &record.channel("time").ok_or("no time")?.values;
        // A record of the rig holds eight periods.
        let frequency = LAST as f64 / (record.sample_step().ok_or("no even steps")? * times.len() as f64);
        let fitted = |values: &[f64], times: &[f64], count| {
            let found = harmonics(times, values, frequency, count).map_err(|error| error.to_string());
            found.map(|found| found.coefficients)
        };
        let force = fitted(&record.channel("excitation").ok_or("no excitation")?.values, times, 1)?;
        let channels = || record.channels.iter().filter(|channel| channel.name.starts_with("acceleration"));
        let names: Vec<&str> = channels().map(|channel| channel.name.as_str()).collect();
        let (then, shown) = driven(model, &force, frequency, &names).map_err(|error| error.to_string())?;
        let one = |(channel, values): (&Channel, &Vec<f64>)| {
            Ok(Self {
                name: channel.name.clone(),
                unit: channel.unit,
                recorded: fitted(&channel.values, times, HARMONICS)?,
                predicted: fitted(values, &then, HARMONICS)?,
            })
        };
        channels().zip(&shown).map(one).collect()
    }

    /// Root mean square of the difference over that of the record, means left out.
    fn off(&self) -> f64 {
        let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|value| value * value).sum::<f64>();
        let pairs = self.recorded.iter().zip(&self.predicted).skip(1);
        (squares(&mut pairs.map(|(a, b)| a - b)) / squares(&mut self.recorded.iter().skip(1).copied())).sqrt()
    }
}

/// The last periods of the outputs `names` of the FMU of `model` under a `force` (coefficients, N) that runs straight from step
/// to step, and their times (s).
fn driven(
    model: &Model,
    force: &[f64],
    frequency: f64,
    names: &[&str],
) -> Result<(Vec<f64>, Vec<Vec<f64>>), stickslip::fmi::Error> {
    let mut fmu = Instance::from_model(model)?;
    let reference = |name: &str| {
        let missing = || stickslip::fmi::Error::Model(format!("it has no variable {name}"));
        fmu.description().reference(name).ok_or_else(missing)
    };
    let outputs = names.iter().map(|name| reference(name)).collect::<Result<Vec<u32>, _>>()?;
    let excitation = [reference("excitation")?];
    fmu.set_up(Setup::default())?;
    fmu.enter_initialization()?;
    fmu.exit_initialization()?;
    let step = 1.0 / frequency / STEPS as f64;
    let at = |k: usize| value(force, TAU * k as f64 / STEPS as f64);
    let (mut times, mut shown) = (Vec::new(), vec![Vec::new(); outputs.len()]);
    let mut row = vec![0.0; outputs.len()];
    for k in 0..SETTLING * STEPS {
        fmu.set_real(&excitation, &[at(k)])?;
        fmu.set_input_derivatives(&excitation, &[1], &[(at(k + 1) - at(k)) / step])?;
        fmu.do_step(k as f64 * step, step)?;
        if k >= (SETTLING - LAST) * STEPS {
            fmu.get_real(&outputs, &mut row)?;
            times.push((k + 1) as f64 * step);
            shown.iter_mut().zip(&row).for_each(|(values, value)| values.push(*value));
        }
    }
    Ok((times, shown))
}

/// Every acceleration over a period: the record as points, the FMU as a line.
fn picture(motions: &[Motion]) -> Plot {
    let line = |name: &str, coefficients: &[f64], steps: usize, stroke: Stroke| Line {
        name: name.to_owned(),
        x: (0..=steps).map(|k| k as f64 / steps as f64).collect(),
        y: (0..=steps).map(|k| value(coefficients, TAU * k as f64 / steps as f64)).collect(),
        stroke,
    };
    let pair = |(k, motion): (usize, &Motion)| {
        let colour = &palette(k, motions.len());
        [
            line(
                &format!("{}, rig", motion.name),
                &motion.recorded,
                64,
                Stroke::points(colour, "circle-open"),
            ),
            line(&format!("{}, FMU", motion.name), &motion.predicted, STEPS, Stroke::solid(colour)),
        ]
    };
    let unit = motions.first().map_or("1", |motion| motion.unit);
    Plot {
        caption: "Accelerations over a period at 45 m/s², a level that was neither fitted nor used for the measuring chain: the \
                  rig without noise (points), and the FMU of the identified model under the rig’s force, from rest (lines)."
            .into(),
        half: false,
        x: Axis::new("time over period", "1"),
        panels: vec![Panel {
            y: Axis::new("acceleration", unit),
            lines: motions.iter().enumerate().flat_map(pair).collect(),
        }],
    }
}
