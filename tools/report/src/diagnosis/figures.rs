//! The figures of a diagnosis: the fall of the error, the gain of the candidates, and how alike they are.

use serde_json::{Value, json};
use stickslip::diagnose::{Candidate, Diagnosis};

use super::words;
use crate::figure::{self, Captioned, Figures, LAST};
use crate::format::{self, Scale};
use crate::plots;

/// Candidates drawn at most.
const CANDIDATES: usize = 20;
/// Gain below which a candidate is not drawn.
const WORST: f64 = -0.34;

/// From the model as given to what remains with the effects, and the noise.
pub fn waterfall(figures: &mut Figures, diagnosis: &Diagnosis) -> Option<Captioned> {
    let stages = &diagnosis.comparison.stages;
    let errors: Vec<f64> = stages.iter().map(|stage| stage.error).collect();
    let names: Vec<String> = stages.iter().map(|stage| stage.name.clone()).collect();
    let scale = Scale::of(errors.iter().copied().chain(diagnosis.error.noise_floor), "1");
    let floor = diagnosis.error.noise_floor;
    let figure =
        plots::waterfall_of(figures, &names, &errors, &scale, "normalised error, all records", floor)?;
    let noise = match floor {
        Some(floor) => format!(" Dotted: the error that noise alone would cause, {}.", format::error(floor)),
        None => " The error that noise alone would cause is unknown.".to_owned(),
    };
    let caption = format!(
        "From the error of the model as given to what remains. Green lowers the error, orange raises it.{noise}"
    );
    Some(Captioned { figure, caption, half: false })
}

/// Gain of each candidate with its standard error.
pub fn ranking(figures: &mut Figures, candidates: &[Candidate]) -> Option<(Captioned, usize)> {
    // A candidate that makes it far worse would press the others together.
    let drawn = |one: &&Candidate| one.failure.is_none() && one.gain_fraction > WORST;
    let fitted: Vec<&Candidate> = candidates.iter().filter(drawn).take(CANDIDATES).collect();
    if fitted.is_empty() {
        return None;
    }
    let spread = |one: &&Candidate| {
        let spread = 100.0 * (one.gain_fraction / one.gain_z).abs();
        if spread.is_finite() { spread } else { 0.0 }
    };
    let names: Vec<String> = fitted.iter().map(|one| figure::text(&words::candidate(one))).collect();
    let gains: Vec<f64> = fitted.iter().map(|one| 100.0 * one.gain_fraction).collect();
    let z: Vec<String> =
        fitted.iter().map(|one| format!("z = {}", format::significant(one.gain_z, 2))).collect();
    let low = gains.iter().copied().fold(0.0, f64::min);
    let trace = json!({
        "type": "scatter", "mode": "markers", "y": names, "x": gains, "text": z, "hoverinfo": "x+y+text",
        "marker": { "color": LAST, "size": 9 }, "showlegend": false,
        "error_x": { "type": "data", "array": fitted.iter().map(spread).collect::<Vec<_>>(), "color": LAST, "thickness": 1.5 },
    });
    let mut layout = figure::single("squared error removed (%)", "");
    layout["yaxis"]["autorange"] = json!("reversed");
    layout["yaxis"]["ticks"] = json!("");
    layout["yaxis"]["nticks"] = json!(0);
    layout["xaxis"]["zerolinecolor"] = json!("#000000");
    layout["xaxis"]["range"] = json!([low - 5.0, 105.0]);
    let caption = "Fraction of the squared error of the training records that each candidate removes when the whole model is \
                   refitted with it. A point right of the line lowers the error; where the bar reaches the line the gain is \
                   not significant. Candidates that raise the error by more than a third are \
                   only in the table."
        .to_owned();
    let height = 96 + 26 * fitted.len();
    Some((Captioned { figure: figures.add(vec![trace], layout), caption, half: false }, height))
}

/// Correlation of the candidates' sensitivities, as a map.
pub fn confounding(figures: &mut Figures, diagnosis: &Diagnosis) -> Option<(Captioned, usize)> {
    let mut ids: Vec<&str> = Vec::new();
    // In the order of the ranking, so that those that matter are in a corner.
    let ranked = diagnosis.candidates.iter().flat_map(|one| one.effects.iter().copied());
    let pairs = diagnosis.confounding.iter().flat_map(|one| one.effects);
    for id in ranked.chain(pairs) {
        let known = diagnosis.confounding.iter().any(|one| one.effects.contains(&id));
        if known && !ids.contains(&id) {
            ids.push(id);
        }
    }
    if ids.len() < 2 {
        return None;
    }
    let of = |a: &str, b: &str| -> Value {
        let pair = diagnosis.confounding.iter().find(|one| {
            (one.effects[0] == a && one.effects[1] == b) || (one.effects[0] == b && one.effects[1] == a)
        });
        match pair {
            _ if a == b => json!(null),
            Some(one) if one.correlation.is_finite() => {
                json!((one.correlation.abs() * 100.0).round() / 100.0)
            }
            _ => json!(null),
        }
    };
    let rows: Vec<Vec<Value>> = ids.iter().map(|a| ids.iter().map(|b| of(a, b)).collect()).collect();
    let names: Vec<String> = ids.iter().map(|id| figure::text(&words::title(id))).collect();
    let trace = json!({
        "type": "heatmap", "x": names, "y": names, "z": rows, "zmin": 0, "zmax": 1, "xgap": 1, "ygap": 1,
        "colorscale": [[0, "#f4f6f8"], [0.5, "#9ecae9"], [0.9, "#0072B2"], [0.9, "#D55E00"], [1, "#8c2d04"]],
        "texttemplate": "%{z:.2f}", "textfont": { "size": 10 }, "hovertemplate": "%{y}, %{x}: %{z:.2f}<extra></extra>",
        "showscale": false, "colorbar": { "thickness": 12, "title": { "text": "|ρ|" }, "tickvals": [0, 0.5, 0.9, 1] },
    });
    let mut layout = figure::single("", "");
    for axis in ["xaxis", "yaxis"] {
        layout[axis]["showgrid"] = json!(false);
        layout[axis]["ticks"] = json!("");
        layout[axis]["nticks"] = json!(0);
        layout[axis]["title"] = json!({ "text": "" });
    }
    layout["xaxis"]["tickangle"] = json!(-90);
    layout["yaxis"]["autorange"] = json!("reversed");
    let caption = "How similar two candidates are in these data: correlation of their changes of the prediction, after the \
                   model’s own parameters are refitted. Above 0.9 (orange) these data cannot distinguish the two."
        .to_owned();
    let height = 230 + 24 * ids.len();
    Some((Captioned { figure: figures.add(vec![trace], layout), caption, half: false }, height))
}
