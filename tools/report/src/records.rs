//! The figures of one time record: overlay, residual, hysteresis loop, residual against the state.

use serde_json::json;
use stickslip::diagnose::Comparison;
use stickslip::measure::{Channel, Record};

use crate::decimate::{keep_extremes, worst_cycles};
use crate::figure::{self, Figures, Style};
use crate::format::{self, Scale};
use crate::plots::{MEASURED, prose};
use crate::summary;

/// A figure and the sentence that explains it.
#[derive(Debug, Clone, PartialEq)]
pub struct Captioned {
    /// Number of the figure in [`Figures`].
    pub figure: usize,
    /// What is drawn, for the caption.
    pub caption: String,
    /// Takes half the page's width where there is room.
    pub half: bool,
}

/// A prediction as it is drawn beside the measurement.
struct Drawn<'a> {
    name: String,
    style: Style,
    predicted: &'a [f64],
    residual: Vec<f64>,
}

/// Cycles that a hysteresis loop shows of a long record.
const LOOP_CYCLES: usize = 3;

/// All figures of record `index`, for each compared channel, with at most about `limit` points a line.
pub fn figures(figures: &mut Figures, comparison: &Comparison, index: usize, limit: usize) -> Vec<Captioned> {
    let record = &comparison.records[index];
    let mut all = Vec::new();
    for (name, _) in summary::compared_channels(comparison, index) {
        let Some(measured) = summary::channel(record, &name) else { continue };
        let drawn = drawn(comparison, index, measured);
        if !drawn.is_empty() && !measured.values.is_empty() {
            channel_figures(figures, record, measured, &drawn, limit, &mut all);
        }
    }
    all
}

/// First and last stage, as far as they predict the channel.
fn drawn<'a>(comparison: &'a Comparison, index: usize, measured: &Channel) -> Vec<Drawn<'a>> {
    let count = comparison.stages.len();
    let ends = comparison.stages.iter().enumerate().filter(|(stage, _)| *stage == 0 || stage + 1 == count);
    ends.filter_map(|(stage_index, stage)| {
        let result = summary::prediction(stage, index, &measured.name)?;
        let residual: Vec<f64> = result.predicted.iter().zip(&measured.values).map(|(p, m)| p - m).collect();
        (!residual.is_empty()).then(|| Drawn {
            name: format!("{}  {}", stage_index + 1, stage.name),
            style: figure::style(stage_index, count),
            predicted: &result.predicted,
            residual,
        })
    })
    .collect()
}

fn channel_figures(
    figures: &mut Figures,
    record: &Record,
    measured: &Channel,
    drawn: &[Drawn],
    limit: usize,
    all: &mut Vec<Captioned>,
) {
    let length = measured.values.len();
    let mut lines: Vec<&[f64]> = vec![&measured.values];
    lines.extend(drawn.iter().map(|one| one.predicted));
    lines.extend(drawn.last().map(|one| &one.residual[..]));
    let kept = keep_extremes(&lines, length, limit);
    let thinned = if kept.len() < length {
        format!(
            " {} of {} samples are drawn, among them the extremes of every stretch.",
            kept.len(),
            format::count(length, "sample").trim_end_matches(" samples")
        )
    } else {
        String::new()
    };
    let value = Scale::of(measured.values.iter().copied(), measured.unit);
    let residual = Scale::of(drawn.iter().flat_map(|one| one.residual.iter().copied()), measured.unit);
    let residuals: Vec<usize> =
        drawn.iter().map(|one| figures.column(picked(&one.residual, &kept, residual.factor))).collect();
    let name = prose(&measured.name);

    // Over time: values above, residual below.
    let index_axis: Vec<f64> = (0..length).map(|sample| sample as f64).collect();
    let time = summary::channel(record, "time");
    let times = time.map_or(&index_axis, |channel| &channel.values);
    let clock = time.map_or(Scale { factor: 1.0, unit: String::new(), decimals: 0 }, |channel| {
        Scale::of(channel.values.iter().copied(), channel.unit)
    });
    let x = figures.column(picked(times, &kept, clock.factor));
    let y = figures.column(picked(&measured.values, &kept, value.factor));
    let mut traces = vec![figure::line("measured", x, y, MEASURED, 2.0, "")];
    for one in drawn {
        let y = figures.column(picked(one.predicted, &kept, value.factor));
        traces.push(figure::line(&one.name, x, y, one.style, 1.5, ""));
    }
    for (one, &y) in drawn.iter().zip(&residuals) {
        let style = Style { dash: "solid", ..one.style };
        traces.push(figure::line(&one.name, x, y, style, 1.0, "2"));
    }
    let layout = figure::stacked(
        &clock.label(if time.is_some() { "time" } else { "sample" }),
        &value.label(&format::shorten(&name, 24)),
        &residual.label("residual"),
    );
    let caption = format!("{} against time; below, predicted minus measured.{thinned}", sentence_case(&name));
    all.push(Captioned { figure: figures.add(traces, layout), caption, half: false });

    if measured.name == "force" {
        if let Some(displacement) = summary::channel(record, "displacement") {
            all.push(hysteresis(figures, times, displacement, measured, drawn, limit));
        }
        for (cause, caption) in causes(record, times) {
            let scale = Scale::of(cause.values.iter().copied(), cause.unit);
            let x = figures.column(picked(&cause.values, &kept, scale.factor));
            let traces = drawn.iter().zip(&residuals).map(|(one, &y)| {
                figure::points(&one.name, x, y, Style { symbol: "circle", ..one.style }, 3.0, 0.45)
            });
            let mut layout = figure::single(&scale.label(&prose(&cause.name)), &residual.label("residual"));
            layout["showlegend"] = json!(true);
            layout["legend"]["itemsizing"] = json!("constant");
            let traces = traces.collect();
            all.push(Captioned { figure: figures.add(traces, layout), caption, half: true });
        }
    }
}

/// Force against displacement over the cycles where the last prediction errs most.
fn hysteresis(
    figures: &mut Figures,
    times: &[f64],
    displacement: &Channel,
    force: &Channel,
    drawn: &[Drawn],
    limit: usize,
) -> Captioned {
    let residual = drawn.last().map_or(&[][..], |one| &one.residual);
    let (range, stride) = worst_cycles(&displacement.values, residual, LOOP_CYCLES, limit);
    let shown: Vec<usize> = range.clone().step_by(stride).collect();
    let across = Scale::of(shown.iter().map(|&i| displacement.values[i]), displacement.unit);
    let up = Scale::of(force.values.iter().copied(), force.unit);
    let x = figures.column(picked(&displacement.values, &shown, across.factor));
    let y = figures.column(picked(&force.values, &shown, up.factor));
    let mut traces = vec![figure::line("measured", x, y, MEASURED, 2.0, "")];
    for one in drawn {
        let y = figures.column(picked(one.predicted, &shown, up.factor));
        traces.push(figure::line(&one.name, x, y, one.style, 1.75, ""));
    }
    let layout = figure::single(&across.label(&prose(&displacement.name)), &up.label(&prose(&force.name)));
    let mut caption = "Hysteresis loop".to_owned();
    if range.len() < displacement.values.len() {
        let at = |sample: usize| times.get(sample).copied().unwrap_or(f64::NAN);
        caption.push_str(&format!(
            ": the cycles with the largest residual, from {} to {}",
            format::engineering(at(range.start), "s"),
            format::engineering(at(range.end - 1), "s")
        ));
    }
    if stride > 1 {
        caption.push_str(&format!("; one sample in {stride} is drawn"));
    }
    caption.push('.');
    Captioned { figure: figures.add(traces, layout), caption, half: true }
}

/// What a residual of the contact force is drawn against, with captions: displacement, velocity
/// (differences where it was not measured), normal load.
fn causes(record: &Record, times: &[f64]) -> Vec<(Channel, String)> {
    let mut found = Vec::new();
    let take = |name: &str| summary::channel(record, name).cloned();
    let displacement = take("displacement");
    if let Some(channel) = &displacement {
        found.push((channel.clone(), "Residual against displacement.".to_owned()));
    }
    if let Some(channel) = take("velocity") {
        found.push((channel, "Residual against velocity.".to_owned()));
    } else if let (Some(channel), true) = (&displacement, summary::channel(record, "time").is_some()) {
        let values = differences(&channel.values, times);
        let velocity = Channel { name: "velocity".to_owned(), unit: "m/s", values, noise: None };
        found.push((
            velocity,
            "Residual against velocity (central differences of the displacement).".to_owned(),
        ));
    }
    if let Some(channel) = take("normal_load") {
        found.push((channel, "Residual against normal load.".to_owned()));
    }
    found
}

/// Central differences, one-sided at the ends.
fn differences(values: &[f64], times: &[f64]) -> Vec<f64> {
    let length = values.len().min(times.len());
    (0..length)
        .map(|i| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(length - 1));
            (values[after] - values[before]) / (times[after] - times[before])
        })
        .collect()
}

/// The values at `indices`, scaled; NaN beyond the end.
fn picked(values: &[f64], indices: &[usize], factor: f64) -> Vec<f64> {
    indices.iter().map(|&i| values.get(i).map_or(f64::NAN, |value| value * factor)).collect()
}

fn sentence_case(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn central_differences_are_exact_for_a_parabola() {
        let times: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.01).collect();
        let values: Vec<f64> = times.iter().map(|t| 3.0 * t * t).collect();
        let velocity = differences(&values, &times);
        for i in 1..49 {
            assert!((velocity[i] - 6.0 * times[i]).abs() < 1e-12);
        }
    }
}
