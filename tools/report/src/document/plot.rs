//! Plots of lines over a common abscissa, in one panel or two.

use serde_json::{Value, json};

use crate::decimate::keep_extremes;
use crate::figure::{self, Figures};
use crate::format::Scale;

/// Points a line is drawn with at most, about.
const POINTS: usize = 2_000;

/// A figure: one panel, or two above each other.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Plot {
    /// What is drawn.
    pub caption: String,
    /// Takes half the page's width where there is room.
    pub half: bool,
    /// The abscissa of all panels.
    pub x: Axis,
    /// One panel, or two, the second below and smaller.
    pub panels: Vec<Panel>,
}

/// Lines that share an ordinate.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Panel {
    /// The ordinate.
    pub y: Axis,
    /// The lines, the last on top.
    pub lines: Vec<Line>,
}

/// What an axis shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Axis {
    /// Quantity.
    pub name: String,
    /// Its SI unit, `1` for a plain number; prefixes are put before it as the values need.
    pub unit: &'static str,
    /// Linear or logarithmic.
    pub scaling: Scaling,
}

/// How an axis is divided.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Scaling {
    /// Linear.
    #[default]
    Linear,
    /// Logarithmic.
    Logarithmic,
    /// Linear, with buttons to change to logarithmic; on an ordinate only.
    Either,
}

impl Axis {
    /// A linear axis.
    pub fn new(name: impl Into<String>, unit: &'static str) -> Self {
        Self { name: name.into(), unit, scaling: Scaling::Linear }
    }

    /// The same axis, divided otherwise.
    pub fn scaled(self, scaling: Scaling) -> Self {
        Self { scaling, ..self }
    }

    fn layout(&self, scale: &Scale) -> Value {
        let mut axis = figure::axis(&scale.label(&self.name));
        if self.scaling == Scaling::Logarithmic {
            logarithmic(&mut axis);
        }
        axis
    }

    fn scale<'a>(&self, values: impl Iterator<Item = &'a f64>) -> Scale {
        // Prefixes change by thousands while a logarithmic axis shows several of them at once.
        match self.scaling {
            Scaling::Logarithmic => Scale { factor: 1.0, unit: crate::format::unit(self.unit), decimals: 2 },
            _ => Scale::of(values.copied(), self.unit),
        }
    }
}

/// A line of a plot.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Line {
    /// Its name in the legend; lines of the same name share an entry and are switched together.
    pub name: String,
    /// Abscissae (SI). A value that is not finite interrupts the line.
    pub x: Vec<f64>,
    /// Ordinates (SI), as many.
    pub y: Vec<f64>,
    /// How it is drawn.
    pub stroke: Stroke,
}

/// How a line is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct Stroke {
    /// Colour as `#rrggbb`.
    pub colour: String,
    /// `solid`, `dash`, `dot` ..., or `none` for points alone.
    pub dash: &'static str,
    /// Symbol of the points, none where empty.
    pub symbol: &'static str,
    /// Width (px).
    pub width: f64,
    /// What the stroke means, e.g. `unstable`; empty for the usual.
    pub note: &'static str,
}

impl Default for Stroke {
    fn default() -> Self {
        Self::solid(figure::LAST)
    }
}

impl Stroke {
    /// A full line.
    pub fn solid(colour: impl Into<String>) -> Self {
        Self { colour: colour.into(), dash: "solid", symbol: "", width: 1.75, note: "" }
    }

    /// A dashed line.
    pub fn dashed(colour: impl Into<String>) -> Self {
        Self { dash: "dash", ..Self::solid(colour) }
    }

    /// Points that no line joins.
    pub fn points(colour: impl Into<String>, symbol: &'static str) -> Self {
        Self { dash: "none", symbol, ..Self::solid(colour) }
    }
}

/// Colour of `index` among `count` ordered things, from blue through green to orange, dark enough on white.
pub fn palette(index: usize, count: usize) -> String {
    const ANCHORS: [[f64; 3]; 5] = [
        [48.0, 32.0, 110.0],
        [0.0, 103.0, 178.0],
        [0.0, 150.0, 120.0],
        [200.0, 140.0, 0.0],
        [205.0, 70.0, 20.0],
    ];
    if count < 2 {
        return figure::LAST.to_owned();
    }
    let place = index.min(count - 1) as f64 / (count - 1) as f64 * (ANCHORS.len() - 1) as f64;
    let left = (place as usize).min(ANCHORS.len() - 2);
    let fraction = place - left as f64;
    let mix =
        |k: usize| (ANCHORS[left][k] + fraction * (ANCHORS[left + 1][k] - ANCHORS[left][k])).round() as u8;
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

impl Plot {
    /// Stores the figure and returns its number and its height (px).
    pub(super) fn draw(&self, figures: &mut Figures) -> (usize, usize) {
        let lines = || self.panels.iter().flat_map(|panel| &panel.lines);
        let across = self.x.scale(lines().flat_map(|line| &line.x));
        let mut layout = match &self.panels[..] {
            [_, _, ..] => figure::stacked("", "", ""),
            _ => figure::single("", ""),
        };
        let anchor = layout["xaxis"]["anchor"].clone();
        layout["xaxis"] = self.x.layout(&across);
        if !anchor.is_null() {
            layout["xaxis"]["anchor"] = anchor;
        }
        let mut traces = Vec::new();
        let mut named: Vec<(&str, &str)> = Vec::new();
        for (index, panel) in self.panels.iter().take(2).enumerate() {
            let suffix = if index == 0 { "" } else { "2" };
            let up = panel.y.scale(panel.lines.iter().flat_map(|line| &line.y));
            let axis = format!("yaxis{suffix}");
            let domain = layout[&axis]["domain"].clone();
            layout[&axis] = panel.y.layout(&up);
            if !domain.is_null() {
                layout[&axis]["domain"] = domain;
            }
            for line in &panel.lines {
                let first = !named.contains(&(&line.name, line.stroke.note));
                if first {
                    named.push((&line.name, line.stroke.note));
                }
                traces.push(trace(figures, line, (&across, &up), suffix, first));
            }
        }
        if self.panels.iter().any(|panel| panel.y.scaling == Scaling::Either) {
            // The page's script puts the buttons below the figure.
            layout["meta"] = json!({ "switchable": true });
        }
        // A name for a single line says what the caption says already.
        layout["showlegend"] = json!(named.len() > 1);
        let height = if self.panels.len() > 1 { 480 } else { 368 };
        (figures.add(traces, layout), height + 14 * named.len().saturating_sub(6).min(12))
    }
}

fn trace(
    figures: &mut Figures,
    line: &Line,
    (across, up): (&Scale, &Scale),
    axis: &str,
    first: bool,
) -> Value {
    let length = line.x.len().min(line.y.len());
    let kept = keep_gaps(line, keep_extremes(&[&line.y[..length]], length, POINTS));
    let x = figures.column(kept.iter().map(|&i| line.x[i] * across.factor));
    let y = figures.column(kept.iter().map(|&i| line.y[i] * up.factor));
    let Stroke { colour, dash, symbol, width, note } = &line.stroke;
    let name = if note.is_empty() { line.name.clone() } else { format!("{}, {note}", line.name) };
    let mode = match (*dash, symbol.is_empty()) {
        ("none", _) => "markers",
        (_, true) => "lines",
        (_, false) => "lines+markers",
    };
    let mut trace = json!({
        "type": "scatter", "mode": mode, "name": figure::text(&name), "x": x, "y": y,
        "xaxis": "x", "yaxis": format!("y{axis}"), "showlegend": first, "legendgroup": figure::text(&line.name),
    });
    if mode != "markers" {
        trace["line"] = json!({ "color": colour, "dash": dash, "width": width });
    }
    if mode != "lines" {
        trace["marker"] = json!({ "color": colour, "symbol": symbol, "size": 7 });
    }
    trace
}

/// Thinning must not join what a gap separates.
fn keep_gaps(line: &Line, mut kept: Vec<usize>) -> Vec<usize> {
    let length = line.x.len().min(line.y.len());
    if kept.len() < length {
        kept.extend((0..length).filter(|&i| !(line.x[i].is_finite() && line.y[i].is_finite())));
        kept.sort_unstable();
        kept.dedup();
    }
    kept
}

fn logarithmic(axis: &mut Value) {
    axis["type"] = json!("log");
    axis["dtick"] = json!("D1");
    axis["exponentformat"] = json!("power");
    // Digits between the powers would crowd an axis of many decades.
    axis["dtick"] = json!(1);
    axis["minor"] = json!({ "ticks": "outside", "ticklen": 3, "showgrid": false, "dtick": "D1" });
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_of_levels_differ() {
        for count in 2..=12 {
            let mut all: Vec<String> = (0..count).map(|index| palette(index, count)).collect();
            all.sort();
            all.dedup();
            assert_eq!(all.len(), count);
        }
    }

    #[test]
    fn thinning_keeps_the_gaps_of_a_line() {
        let mut line =
            Line { x: (0..9_000).map(f64::from).collect(), y: vec![1.0; 9_000], ..Line::default() };
        line.y[4_321] = f64::NAN;
        let kept = keep_gaps(&line, keep_extremes(&[&line.y], 9_000, POINTS));
        assert!(kept.contains(&4_321) && kept.len() < 2_100);
    }
}
