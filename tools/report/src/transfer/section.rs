//! Plots and tables of the responses.

use stickslip::diagnose::Comparison;

use super::curves::curves;
use super::peaks::{Peak, peaks};
use super::{Curve, Point, Response, Source};
use crate::document::{
    Axis, Block, Cell, Line, Panel, Plot, Scaling, Section, Stroke, Table, palette, scientific,
};
use crate::format;
use crate::plots::prose;

/// Curves of a figure at most.
const CURVES: usize = 8;
/// Rows of a table at most.
const ROWS: usize = 60;
/// Points below which a curve has no peaks to look for.
const FEW: usize = 5;
/// Steady records whose frequencies differ by less than this fraction are told by their level.
const SAME_FREQUENCY: f64 = 0.02;

/// The section on first-harmonic responses; `None` where no record shows one.
pub fn section(comparison: &Comparison) -> Option<Section> {
    let all = curves(comparison);
    let mut blocks = vec![Block::Note(
        "The first harmonic of each channel over that of what drives it, measured and predicted: amplitude, and phase, positive \
         where the channel is ahead."
            .to_owned(),
    )];
    let mut channels: Vec<(&str, Source)> = Vec::new();
    for curve in &all {
        if !channels.contains(&(&curve.channel, curve.source)) {
            channels.push((&curve.channel, curve.source));
        }
    }
    let stages: Vec<&str> = comparison.stages.iter().map(|stage| stage.name.as_str()).collect();
    let mut plots = Vec::new();
    for (channel, source) in channels {
        let same: Vec<&Curve> =
            all.iter().filter(|one| one.channel == channel && one.source == source).collect();
        plots.push(plot(&same, &stages));
    }
    blocks.push(Block::Plots(plots));
    blocks.extend(peak_blocks(&all));
    blocks.extend(steady_table(&all));
    let title = "First-harmonic responses".to_owned();
    (!all.is_empty()).then(|| Section { id: "responses".to_owned(), title, blocks })
}

/// Of one channel: magnitude above, phase below.
fn plot(curves: &[&Curve], stages: &[&str]) -> Plot {
    let drawn = &curves[..curves.len().min(CURVES)];
    let first = drawn[0];
    let over_level = first.source == Source::Steady && same_frequency(&first.points);
    let (mut sizes, mut phases) = (Vec::new(), Vec::new());
    for (index, curve) in drawn.iter().enumerate() {
        let name = if curve.record.is_empty() { "steady records" } else { &curve.record };
        let x: Vec<f64> =
            curve.points.iter().map(|point| if over_level { point.level } else { point.frequency }).collect();
        for (responses, stroke) in strokes(curve, &palette(index, drawn.len()), stages.len(), drawn.len()) {
            let line = |y: Vec<f64>| Line { name: name.to_owned(), x: x.clone(), y, stroke: stroke.clone() };
            sizes.push(line(responses.iter().map(|one| one.map_or(f64::NAN, |one| one.size)).collect()));
            let degrees = phase_line(&curve.points, &responses);
            if degrees.iter().any(|value| value.is_finite()) {
                phases.push(line(degrees));
            }
        }
    }
    let magnitude = Axis::new(format::shorten(&ratio_name(first), 40), first.unit).scaled(Scaling::Either);
    let mut panels = vec![Panel { y: magnitude, lines: sizes }];
    if !phases.is_empty() {
        panels.push(Panel { y: Axis::new("phase", "°"), lines: phases });
    }
    let x = match over_level {
        true => Axis::new(format!("amplitude of {}", prose(&first.drive.0)), first.drive.1),
        false => Axis::new("frequency", "Hz"),
    };
    Plot { caption: caption(curves, drawn.len(), stages), half: false, x, panels }
}

/// What is drawn of a curve, and how: the predictions of the last stage and, among few curves, of the first, then the
/// measurement.
fn strokes(
    curve: &Curve,
    colour: &str,
    stages: usize,
    curves: usize,
) -> Vec<(Vec<Option<Response>>, Stroke)> {
    let last = stages.saturating_sub(1);
    let steady = curve.source == Source::Steady;
    let shown = if last > 0 && curves <= CURVES / 2 { vec![0, last] } else { vec![last] };
    let of = |stage: usize| {
        let predicted = curve.points.iter().map(|point| point.predicted.get(stage).copied().flatten());
        (predicted.collect(), predicted_stroke(colour, stage == last, steady))
    };
    let mut all: Vec<(Vec<Option<Response>>, Stroke)> = shown.into_iter().map(of).collect();
    let measured = Stroke { note: "measured", ..Stroke::points(colour, "circle-open") };
    all.push((curve.points.iter().map(|point| Some(point.measured)).collect(), measured));
    all
}

fn caption(curves: &[&Curve], drawn: usize, stages: &[&str]) -> String {
    let first = curves[0];
    let from = match first.source {
        Source::Table => "tables of a stepped sine",
        Source::Sweep => {
            "slow sine sweeps, cut into stretches of a few cycles; how fast a sweep was is not taken off"
        }
        Source::Steady => "steady records, each of which is a point",
    };
    let rest = match curves.len() {
        all if all > drawn => format!(" The first {drawn} of {all} records are drawn."),
        _ => String::new(),
    };
    let lines = if first.source == Source::Steady { "Crosses" } else { "Full lines" };
    format!(
        "{} over {}, from {from}. Circles: measured. {lines}: predicted by “{}”.{rest}",
        prose(&first.channel),
        prose(&first.drive.0),
        stages.last().copied().unwrap_or_default()
    )
}

fn predicted_stroke(colour: &str, last: bool, steady: bool) -> Stroke {
    match (last, steady) {
        (true, false) => Stroke { note: "predicted", ..Stroke::solid(colour) },
        (true, true) => Stroke { note: "predicted", ..Stroke::points(colour, "x-thin-open") },
        (false, false) => Stroke { note: "first stage", width: 1.25, ..Stroke::dashed(colour) },
        (false, true) => Stroke { note: "first stage", ..Stroke::points(colour, "triangle-down-open") },
    }
}

/// `acceleration/excitation`, as prose.
fn ratio_name(curve: &Curve) -> String {
    let quantity = |name: &str| prose(name.split_once(':').map_or(name, |(quantity, _)| quantity));
    format!("{}/{}", quantity(&curve.channel), quantity(&curve.drive.0))
}

fn same_frequency(points: &[Point]) -> bool {
    let low = points.iter().map(|point| point.frequency).fold(f64::INFINITY, f64::min);
    let high = points.iter().map(|point| point.frequency).fold(0.0, f64::max);
    points.len() > 1 && high - low < SAME_FREQUENCY * high
}

/// Phases in degrees: those of the measurement go on where they pass ±180°, the predicted ones stay beside them.
fn phase_line(points: &[Point], responses: &[Option<Response>]) -> Vec<f64> {
    let turn = 360.0;
    let mut before: Option<f64> = None;
    let mut line = Vec::with_capacity(points.len());
    for (point, response) in points.iter().zip(responses) {
        let near = |phase: f64, other: f64| phase - turn * ((phase - other) / turn).round();
        let measured =
            point.measured.phase.map(f64::to_degrees).map(|phase| near(phase, before.unwrap_or(phase)));
        before = measured.or(before);
        let phase = response.and_then(|one| one.phase).map(f64::to_degrees);
        line.push(phase.map_or(f64::NAN, |phase| near(phase, measured.unwrap_or(phase))));
    }
    line
}

/// Stretches of a curve in which the frequency rises, or falls, as points in order of rising frequency.
fn runs(points: &[Point]) -> Vec<Vec<&Point>> {
    let mut all: Vec<Vec<&Point>> = Vec::new();
    let mut direction = 0.0;
    for point in points {
        let step = all.last().and_then(|run| run.last()).map_or(0.0, |last| point.frequency - last.frequency);
        match all.last_mut() {
            Some(run) if step * direction > 0.0 || (run.len() == 1 && step != 0.0) => {
                direction = step;
                run.push(point);
            }
            _ => all.push(vec![point]),
        }
    }
    for run in &mut all {
        run.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    }
    all
}

/// The measured peaks, each with the predicted one next to it.
fn pairs(run: &[&Point], order: i32) -> Vec<(Option<Peak>, Option<Peak>)> {
    let of = |response: &dyn Fn(&Point) -> Option<Response>| {
        let known: Vec<(f64, f64)> =
            run.iter().filter_map(|point| Some((point.frequency, response(point)?.size))).collect();
        let (frequency, size): (Vec<f64>, Vec<f64>) = known.into_iter().unzip();
        peaks(&frequency, &size, order)
    };
    let measured = of(&|point| Some(point.measured));
    let mut predicted = of(&|point| point.predicted.last().copied().flatten());
    let mut all = Vec::new();
    for one in measured {
        let distance = |other: &Peak| (other.frequency / one.frequency).ln().abs();
        let nearest =
            (0..predicted.len()).min_by(|&a, &b| distance(&predicted[a]).total_cmp(&distance(&predicted[b])));
        let near =
            nearest.filter(|&place| distance(&predicted[place]) < 0.2).map(|place| predicted.remove(place));
        all.push((Some(one), near));
    }
    all.extend(predicted.into_iter().map(|one| (None, Some(one))));
    all
}

/// Measured and predicted peaks of one curve, a row each.
fn peak_rows(curve: &Curve, several: bool) -> Vec<Vec<Cell>> {
    let Some(order) = curve.order.filter(|_| curve.source != Source::Steady) else { return Vec::new() };
    let numbers = |peak: Option<Peak>| {
        let of = |value: fn(&Peak) -> f64| peak.as_ref().map_or(f64::NAN, value);
        let damping = peak.and_then(|peak| peak.damping).unwrap_or(f64::NAN);
        let height = Cell::Scientific(of(|peak| peak.size));
        [Cell::Number(of(|peak| peak.frequency), 2), height, Cell::Number(100.0 * damping, 2)]
    };
    let remark = |whose: &str, peak: Option<Peak>| {
        let text = peak.map_or("no peak", |peak| peak.remark);
        (!text.is_empty()).then(|| format!("{whose}: {text}"))
    };
    let runs = runs(&curve.points);
    let found = runs.iter().filter(|run| run.len() >= FEW).flat_map(|run| pairs(run, order));
    let row = |(measured, predicted)| {
        let mut row = vec![Cell::text(&curve.record)];
        if several {
            row.push(Cell::text(prose(&curve.channel)));
        }
        row.extend(numbers(measured));
        row.extend(numbers(predicted));
        let remarks = [remark("measured", measured), remark("predicted", predicted)];
        row.push(Cell::text(remarks.into_iter().flatten().collect::<Vec<_>>().join("; ")));
        row
    };
    found.map(row).collect()
}

fn peak_blocks(curves: &[Curve]) -> Vec<Block> {
    let several = curves.iter().any(|curve| curve.channel != curves[0].channel);
    let mut rows: Vec<Vec<Cell>> = curves.iter().flat_map(|curve| peak_rows(curve, several)).collect();
    if rows.is_empty() {
        return Vec::new();
    }
    rows.truncate(ROWS);
    let same = curves.iter().all(|curve| curve.unit == curves[0].unit);
    let height =
        if same { format!("height ({})", format::unit(curves[0].unit)) } else { "height (SI)".to_owned() };
    let mut heading = vec!["Record".to_owned()];
    heading.extend(several.then(|| "Channel".to_owned()));
    for whose in ["Measured", "Predicted"] {
        heading.extend(["peak (Hz)", &height, "damping (%)"].map(|what| format!("{whose} {what}")));
    }
    heading.push("Remarks".to_owned());
    let note = "Resonances and their damping ratios: of the linear resonance that fits the points above 1/√3 of the peak best. Only what \
                falls to half of its power on one side at least is a peak. A joint that slips bends its peaks: their damping is an \
                equivalent value, which changes with the level.";
    let label = "Damping of each peak".to_owned();
    vec![Block::Table(Table { label, heading, rows }), Block::Note(note.to_owned())]
}

/// Every steady record with its response.
fn steady_table(curves: &[Curve]) -> Option<Block> {
    let steady = || curves.iter().filter(|curve| curve.source == Source::Steady);
    let rows = steady().flat_map(|curve| {
        curve.points.iter().map(move |point| {
            let predicted = point.predicted.last().copied().flatten();
            let change = predicted.and_then(|one| format::change(point.measured.size, one.size));
            let degrees = |response: Option<Response>| {
                response.and_then(|one| one.phase).map_or(f64::NAN, f64::to_degrees)
            };
            vec![
                Cell::text(prose(&curve.channel)),
                Cell::Number(point.frequency, 2),
                Cell::text(format::engineering(point.level, curve.drive.1)),
                Cell::text(format!("{}\u{a0}{}", scientific(point.measured.size), format::unit(curve.unit))),
                Cell::text(change.unwrap_or_else(|| format::ABSENT.to_owned())),
                Cell::Number(degrees(Some(point.measured)), 1),
                Cell::Number(degrees(predicted), 1),
            ]
        })
    });
    let rows: Vec<Vec<Cell>> = rows.take(ROWS).collect();
    let heading = [
        "Channel",
        "Frequency (Hz)",
        "Level of what drives",
        "Response, measured",
        "Predicted beside it",
        "Phase, measured (°)",
        "Phase, predicted (°)",
    ];
    (!rows.is_empty()).then(|| {
        Block::Table(Table {
            label: "First harmonic of steady records".to_owned(),
            heading: heading.map(str::to_owned).to_vec(),
            rows,
        })
    })
}
