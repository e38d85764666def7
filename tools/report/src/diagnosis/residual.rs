//! What the residual looks like: pictures, words and arrays.

use maud::{Markup, html};
use serde_json::{Value, json};
use stickslip::diagnose::{Diagnosis, Verdict};
use stickslip::fit::residual::{Hint, Shape};

use super::page::list;
use crate::figure::{self, Captioned, Figures, LAST};
use crate::format::{self, Scale};
use crate::page::figure_element;
use crate::plots::prose;

/// Shapes that are told in words at most.
const TOLD: usize = 6;

/// Whether something is left that a picture may explain.
fn is_open(diagnosis: &Diagnosis) -> bool {
    !matches!(diagnosis.verdict, Verdict::EffectFound | Verdict::NothingMissing)
        && !diagnosis.residual.shapes.is_empty()
}

/// The section with a picture of each shape.
pub fn section(drawn: &mut Figures, diagnosis: &Diagnosis) -> Markup {
    let first = diagnosis.residual.shapes.iter().max_by(|a, b| a.fraction.total_cmp(&b.fraction));
    let channel = first.map_or("", |shape| shape.channel.as_str());
    let shown = diagnosis.residual.shapes.iter().filter(|one| one.channel == channel || one.fraction > 0.0);
    html! {
        @if is_open(diagnosis) {
            section id="residual" {
                h2 { "Residual" }
                p.text {
                    "What the refitted model lacks, measured minus predicted, over all records: its mean with a band of one standard "
                    "deviation of the samples, and the fraction of its variance that the mean of the other records predicts. The "
                    "fractions overlap, since displacement, velocity and phase belong to one motion. A residual that "
                    "depends on displacement points to something that is fixed in space; on velocity, to a damping or a "
                    "sliding law; on load, to a pressure; on time, to something that changes; on the way since a reversal or "
                    "on its place, to memory. The refitted parameters have absorbed a part of what is missing: the shapes "
                    "are hints."
                }
                (list(&hints(diagnosis)))
                div.figures {
                    @for shape in shown { (figure_element(&picture(drawn, shape), "height:320px")) }
                }
            }
        }
    }
}

fn picture(drawn: &mut Figures, shape: &Shape) -> Captioned {
    let (x, y) =
        (Scale::of(shape.x.iter().copied(), shape.x_unit), Scale::of(shape.mean.iter().copied(), shape.unit));
    let places = || shape.x.iter().map(|value| value * x.factor);
    let edge = |sign: f64| {
        let values = shape.mean.iter().zip(&shape.deviation);
        values.map(move |(mean, deviation)| (mean + sign * deviation) * y.factor).collect::<Vec<f64>>()
    };
    let upper = edge(1.0).into_iter().rev();
    let (around, band) = (
        drawn.column(places().chain(places().collect::<Vec<_>>().into_iter().rev())),
        drawn.column(edge(-1.0).into_iter().chain(upper)),
    );
    let (line, mean) =
        (drawn.column(places()), drawn.column(shape.mean.iter().map(|value| value * y.factor)));
    let traces = vec![
        json!({ "type": "scatter", "mode": "lines", "x": around, "y": band, "fill": "toself", "fillcolor": "#0072B222",
                "line": { "width": 0 }, "hoverinfo": "skip", "showlegend": false }),
        json!({ "type": "scatter", "mode": "lines+markers", "x": line, "y": mean, "showlegend": false,
                "line": { "color": LAST, "width": 2.5 }, "marker": { "size": 5 } }),
    ];
    let lacks = format!("measured − predicted {}", format::shorten(&prose(&shape.channel), 24));
    let layout = figure::single(&x.label(shape.against), &y.label(&lacks));
    let caption = format!("Against {}: {}.", shape.against, fraction(shape));
    Captioned { figure: drawn.add(traces, layout), caption, half: true }
}

/// `43 % of the residual's variance`.
fn fraction(shape: &Shape) -> String {
    if shape.fraction > 0.0 {
        format!("{} % of the variance", format::significant(100.0 * shape.fraction, 2))
    } else {
        "no more than chance".to_owned()
    }
}

/// What the residual depends on, and what it may come from, in sentences; of shapes that which predicts most first.
pub fn told(diagnosis: &Diagnosis) -> Vec<String> {
    if !is_open(diagnosis) {
        return Vec::new();
    }
    let mut shapes: Vec<&Shape> = diagnosis.residual.shapes.iter().filter(|one| one.fraction > 0.0).collect();
    shapes.sort_by(|a, b| b.fraction.total_cmp(&a.fraction));
    let one = |shape: &&Shape| {
        format!("`{}` against {}: {} of the residual there", shape.channel, shape.against, fraction(shape))
    };
    let mut all: Vec<String> = shapes.iter().take(TOLD).map(one).collect();
    if all.is_empty() {
        all.push(
            "nothing that was measured predicts the residual: it depends on none of it, or in no simple way"
                .to_owned(),
        );
    }
    all.extend(hints(diagnosis));
    all
}

fn hints(diagnosis: &Diagnosis) -> Vec<String> {
    diagnosis.residual.hints.iter().map(hint).collect()
}

/// Faults of the measurement, whatever the verdict.
pub fn warnings(diagnosis: &Diagnosis) -> Vec<String> {
    if is_open(diagnosis) {
        return Vec::new();
    }
    let faults = diagnosis.residual.hints.iter().filter(|hint| hint.is_of_the_measurement());
    faults.map(|one| format!("The verdict says nothing of the measurement itself: {}", hint(one))).collect()
}

/// A hint with its reason.
fn hint(hint: &Hint) -> String {
    let percent = |fraction: f64| format!("{} %", format::significant(100.0 * fraction, 2));
    match hint {
        Hint::Hum(line) => format!(
            "Hum: `{}` holds a line at {} Hz with an amplitude of {}, in {} of {} records; it is no harmonic of the excitation.",
            line.channel,
            format::significant(line.frequency, 4),
            format::engineering(short(line.amplitude), line.unit),
            line.records[0],
            line.records[1]
        ),
        Hint::Clipping { channel: (name, unit), levels, fraction } => {
            let levels: Vec<String> =
                levels.iter().map(|level| format::engineering(short(*level), unit)).collect();
            format!(
                "Clipping: `{name}` is held at {} in {} of its samples, although it is noisy elsewhere.",
                levels.join(" and "),
                percent(*fraction)
            )
        }
        Hint::DropOuts { channel, count, samples, zero } => format!(
            "Drop-outs: `{channel}` {} in {count} places ({samples} samples), far from what is predicted there.",
            if *zero { "reads zero" } else { "does not change" }
        ),
        Hint::Drift { channel, change } => format!(
            "Drift: `{channel}`, measured over predicted, {} by {} from the first half of the records to the second.",
            if *change > 0.0 { "rises" } else { "falls" },
            percent(change.abs())
        ),
        Hint::DriftOverRecords { channel, change } => format!(
            "Drift: `{channel}`, measured over predicted, {} by {} from the first record to the last, in their order; a \
             dependence on what else changes in that order would look the same.",
            if *change > 0.0 { "rises" } else { "falls" },
            percent(change.abs())
        ),
        Hint::Memory { channel, against, fraction } => format!(
            "Memory: nothing predicts the residual of `{channel}` better than the {against} ({} of its variance).",
            percent(*fraction)
        ),
    }
}

/// Three digits.
fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// Arrays of all shapes, and the hints.
pub fn to_json(diagnosis: &Diagnosis) -> Value {
    let shape = |one: &Shape| {
        json!({
            "channel": one.channel, "unit": one.unit, "against": one.against, "x_unit": one.x_unit,
            "x": one.x, "mean": one.mean, "deviation": one.deviation, "variance_share": one.fraction,
        })
    };
    let told = |one: &Hint| {
        let mut told = json!({ "kind": one.id(), "text": hint(one) });
        if let Hint::Hum(line) = one {
            told["frequency"] = json!(line.frequency);
            told["amplitude"] = json!(line.amplitude);
            told["unit"] = json!(line.unit);
        }
        told
    };
    json!({
        "shapes": diagnosis.residual.shapes.iter().map(shape).collect::<Vec<_>>(),
        "hints": diagnosis.residual.hints.iter().map(told).collect::<Vec<_>>(),
    })
}
