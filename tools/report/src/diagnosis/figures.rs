//! The figures of a diagnosis: the fall of the error, and the gain of the candidates.

use serde_json::json;
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

/// Gain of each candidate that was fitted: filled where the evidence speaks for it.
pub fn ranking(figures: &mut Figures, candidates: &[Candidate]) -> Option<(Captioned, usize)> {
    // A candidate that makes it far worse would press the others together.
    let drawn = |one: &&Candidate| words::was_fitted(one) && one.gain_fraction > WORST;
    let fitted: Vec<&Candidate> = candidates.iter().filter(drawn).take(CANDIDATES).collect();
    if fitted.is_empty() {
        return None;
    }
    let names: Vec<String> = fitted.iter().map(|one| figure::text(&words::candidate(one))).collect();
    let gains: Vec<f64> = fitted.iter().map(|one| 100.0 * one.gain_fraction).collect();
    let z: Vec<String> =
        fitted.iter().map(|one| format!("z = {}", format::significant(one.gain_z, 2))).collect();
    let symbols: Vec<&str> =
        fitted.iter().map(|one| if one.gain_z > 0.0 { "circle" } else { "circle-open" }).collect();
    let low = gains.iter().copied().fold(0.0, f64::min);
    let trace = json!({
        "type": "scatter", "mode": "markers", "y": names, "x": gains, "text": z, "hoverinfo": "x+y+text",
        "marker": { "color": LAST, "size": 9, "symbol": symbols }, "showlegend": false,
    });
    let mut layout = figure::single("squared error removed (%)", "");
    layout["yaxis"]["autorange"] = json!("reversed");
    layout["yaxis"]["ticks"] = json!("");
    layout["yaxis"]["nticks"] = json!(0);
    layout["xaxis"]["zerolinecolor"] = json!("#000000");
    layout["xaxis"]["range"] = json!([low - 5.0, 105.0]);
    let caption = "Fraction of the squared error of the training records that each candidate removes when the whole model is \
                   refitted with it. A point right of the line lowers the error. Filled: the evidence speaks for the effect (z above \
                   zero). Candidates that raise the error by more than a third, and those that were not fitted, are only in the \
                   table."
        .to_owned();
    let height = 96 + 26 * fitted.len();
    Some((Captioned { figure: figures.add(vec![trace], layout), caption, half: false }, height))
}
