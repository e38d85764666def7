//! The figures of a comparison as a whole: error of each stage, and frequency against amplitude.

use serde_json::{Value, json};
use stickslip::diagnose::Comparison;

use crate::comparison::summary::{Levels, Summary};
use crate::figure::{self, BLACK, Figures, Style};
use crate::format::Scale;

/// How a measurement is drawn wherever it appears.
pub const MEASURED: Style = Style { colour: BLACK, dash: "solid", symbol: "circle-open" };

/// A channel's name as prose: `normal_load` becomes `normal load`.
pub fn prose(name: &str) -> String {
    name.replace('_', " ")
}

/// What [`Summary::errors`] are, in words.
pub fn error_name(summary: &Summary) -> String {
    match &summary.common {
        Some(common) => format!("RMS error of {}", prose(&common.name)),
        None => "normalised error".to_owned(),
    }
}

/// A waterfall from the first stage's error through what each further stage changes to the rest. `None`
/// with fewer than two stages, or when a stage has no finite error.
pub fn waterfall(figures: &mut Figures, comparison: &Comparison, summary: &Summary) -> Option<usize> {
    let names: Vec<String> = comparison.stages.iter().map(|stage| stage.name.clone()).collect();
    waterfall_of(figures, &names, &summary.errors, &summary.scale, &error_name(summary), None)
}

/// As [`waterfall`], of the `errors` of the stages called `names`, with what the noise alone would leave.
pub fn waterfall_of(
    figures: &mut Figures,
    names: &[String],
    errors: &[f64],
    scale: &Scale,
    name: &str,
    floor: Option<f64>,
) -> Option<usize> {
    if errors.len() < 2 || errors.iter().any(|error| !error.is_finite()) {
        return None;
    }
    let changes = errors.windows(2).map(|pair| pair[1] - pair[0]);
    let values: Vec<f64> = [errors[0]].into_iter().chain(changes).chain([errors[errors.len() - 1]]).collect();
    let text: Vec<String> = values
        .iter()
        .enumerate()
        .map(|(row, &value)| {
            let whole = row == 0 || row + 1 == values.len();
            if whole { scale.number(value) } else { scale.signed(value) }
        })
        .collect();
    let rows = (0..values.len()).map(|row| match names.get(row) {
        Some(stage) => wrapped(&format!("{}  {stage}", row + 1), 20),
        None => "remaining".to_owned(),
    });
    // A change begins where the error of the stage before it ends.
    let whole = |row: usize| row == 0 || row == errors.len();
    let base = (0..values.len()).map(|row| if whole(row) { 0.0 } else { errors[row - 1] * scale.factor });
    let colours = (0..values.len()).map(|row| match values[row] {
        _ if whole(row) => "#5a6572",
        value if value > 0.0 => "#D55E00",
        _ => "#009E73",
    });
    let rows: Vec<String> = rows.collect();
    let trace = json!({
        "type": "bar", "orientation": "h", "y": rows, "text": text, "base": base.collect::<Vec<_>>(),
        "x": figures.column(values.iter().map(|value| value * scale.factor)),
        "textposition": "none", "showlegend": false, "hoverinfo": "text",
        "marker": { "color": colours.collect::<Vec<_>>() },
    });
    let mut layout = figure::single(&scale.label(name), "");
    layout["yaxis"]["autorange"] = json!("reversed");
    layout["yaxis"]["showgrid"] = json!(false);
    layout["yaxis"]["ticks"] = json!("");
    // Otherwise plotly thins the labels of a category axis as it does numbers.
    layout["yaxis"]["nticks"] = json!(0);
    // Numbers to the right of their bars, where there is always room: plotly puts that of a falling bar
    // to its left, over the labels.
    layout["annotations"] = annotations(errors, &rows, &text, scale);
    let top = errors.iter().fold(0.0_f64, |top, &error| top.max(error)) * scale.factor;
    layout["xaxis"]["range"] = if top > 0.0 { json!([0.0, 1.22 * top]) } else { json!([0, 1]) };
    if let Some(floor) = floor {
        let x = floor * scale.factor;
        layout["shapes"] = json!([{
            "type": "line", "xref": "x", "yref": "paper", "x0": x, "x1": x, "y0": 0, "y1": 1,
            "line": { "color": BLACK, "width": 1.5, "dash": "dot" },
        }]);
    }
    Some(figures.add(vec![trace], layout))
}

/// The numbers of a waterfall, each at the right end of its bar.
fn annotations(errors: &[f64], rows: &[String], text: &[String], scale: &Scale) -> Value {
    let right = |row: usize| match row {
        0 => errors[0],
        row if row == errors.len() => errors[row - 1],
        row => errors[row - 1].max(errors[row]),
    };
    let all = (0..rows.len()).map(|row| {
        json!({
            "x": right(row) * scale.factor, "y": rows[row], "text": text[row],
            "xanchor": "left", "xshift": 3, "showarrow": false,
        })
    });
    all.collect()
}

/// `name` broken into lines of about `width` characters for a tick label, three at most.
fn wrapped(name: &str, width: usize) -> String {
    let mut lines: Vec<String> = Vec::new();
    for word in name.split(' ') {
        match lines.last_mut() {
            Some(line) if line.chars().count() + word.chars().count() < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.to_owned()),
        }
    }
    if lines.len() > 3 {
        lines.truncate(3);
        lines[2].push('…');
    }
    lines
        .iter()
        .map(|line| figure::text(&crate::format::shorten(line, width + 6)))
        .collect::<Vec<_>>()
        .join("<br>")
}

/// Measured markers and every stage's line against amplitude, residuals below.
pub fn backbone(figures: &mut Figures, comparison: &Comparison, levels: &Levels) -> usize {
    let amplitude = Scale::of(levels.amplitude.iter().copied(), levels.amplitude_unit);
    let value = Scale::of(levels.measured.iter().copied(), levels.unit);
    let residual = levels.residual_scale();
    let x = figures.column(levels.amplitude.iter().map(|a| a * amplitude.factor));
    let y = figures.column(levels.measured.iter().map(|v| v * value.factor));
    let count = comparison.stages.len();
    let mut traces = Vec::with_capacity(2 * count + 1);
    let mut below = Vec::with_capacity(count);
    for (index, stage) in comparison.stages.iter().enumerate() {
        let predicted = &levels.predicted[index];
        if predicted.iter().all(|value| !value.is_finite()) {
            continue;
        }
        let style = figure::style(index, count);
        let width = if index + 1 == count { 2.5 } else { 1.75 };
        let name = format!("{}  {}", index + 1, stage.name);
        let column = figures.column(predicted.iter().map(|v| v * value.factor));
        traces.push(with_markers(figure::line(&name, x, column, style, width, ""), style));
        let rest = (0..predicted.len()).map(|level| levels.residual(index, level) * residual.factor);
        let column = figures.column(rest);
        below.push(with_markers(figure::line(&name, x, column, style, width, "2"), style));
    }
    let mut measured = figure::points("measured", x, y, MEASURED, 10.0, 1.0);
    measured["marker"]["line"] = json!({ "width": 2 });
    // Drawn on top, named first.
    measured["legendrank"] = json!(1);
    traces.push(measured);
    traces.append(&mut below);
    let name = prose(&levels.channel);
    let layout =
        figure::stacked(&amplitude.label(levels.over), &value.label(&name), &residual.label("residual"));
    figures.add(traces, layout)
}

/// A line with a small marker at every point, since a level is a separate test and lines only lead the
/// eye.
fn with_markers(mut trace: Value, style: Style) -> Value {
    trace["mode"] = json!("lines+markers");
    trace["marker"] = json!({ "color": style.colour, "symbol": style.symbol, "size": 6 });
    trace
}
