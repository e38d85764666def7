//! Figures for plotly.js. A trace names the columns of its `x` and `y` by number; the page's script
//! puts the values in, so that a column that several figures draw is in the file once.

use serde_json::{Value, json};

use crate::format;

/// Colours of Okabe and Ito, which people with all common forms of colour blindness can distinguish.
pub const BLACK: &str = "#000000";
pub const FIRST: &str = "#E69F00";
pub const LAST: &str = "#0072B2";
const BETWEEN: [&str; 4] = ["#56B4E9", "#009E73", "#CC79A7", "#D55E00"];
const DASHES: [&str; 4] = ["dot", "dashdot", "longdash", "longdashdot"];
const SYMBOLS: [&str; 4] = ["square", "diamond", "triangle-up", "x"];

/// How a stage is drawn wherever it appears.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Style {
    pub colour: &'static str,
    pub dash: &'static str,
    pub symbol: &'static str,
}

/// The style of stage `index` of `count`: the last is the blue full line, the first the orange dashes.
pub fn style(index: usize, count: usize) -> Style {
    if index + 1 == count {
        Style { colour: LAST, dash: "solid", symbol: "circle" }
    } else if index == 0 {
        Style { colour: FIRST, dash: "dash", symbol: "triangle-down" }
    } else {
        let turn = (index - 1) % 4;
        // The second round pairs the colours with other dashes.
        let dash = (turn + (index - 1) / 4) % 4;
        Style { colour: BETWEEN[turn], dash: DASHES[dash], symbol: SYMBOLS[dash] }
    }
}

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

/// All figures of a page and the columns they draw.
#[derive(Debug, Default)]
pub struct Figures {
    columns: Vec<Vec<Value>>,
    figures: Vec<Value>,
    /// What the views of the residual draw, if the page has them.
    pub explorer: Option<Value>,
}

impl Figures {
    /// Stores values, rounded to six significant digits, and returns the column's number.
    pub fn column(&mut self, values: impl IntoIterator<Item = f64>) -> usize {
        self.columns.push(values.into_iter().map(rounded).collect());
        self.columns.len() - 1
    }

    /// Stores a figure and returns its number.
    pub fn add(&mut self, traces: Vec<Value>, layout: Value) -> usize {
        self.figures.push(json!({ "data": traces, "layout": layout }));
        self.figures.len() - 1
    }

    /// Everything as JSON that may stand inside a `<script>` element: `<`, `>` and `&` are written as
    /// escapes, so that no name from a file can end the element.
    pub fn to_json(&self) -> String {
        let text = json!({ "columns": self.columns, "figures": self.figures, "explorer": self.explorer })
            .to_string();
        let mut safe = String::with_capacity(text.len() + 64);
        for c in text.chars() {
            match c {
                '<' | '>' | '&' | '\u{2028}' | '\u{2029}' => safe.push_str(&format!("\\u{:04x}", c as u32)),
                c => safe.push(c),
            }
        }
        safe
    }
}

fn rounded(value: f64) -> Value {
    // Non-finite numbers become null, which leaves a gap in the line.
    let short = format!("{value:.5e}").parse::<f64>().unwrap_or(f64::NAN);
    if short == short.trunc() && short.abs() < 1e6 { json!(short as i64) } else { json!(short) }
}

/// A name as plotly shows it: its text may hold tags such as links, so their brackets are escaped.
pub fn text(name: &str) -> String {
    let name = format::shorten(&format::printable(name), 44);
    name.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// A line of a stage or of the measurement. `axis` is `""` for the first panel, `"2"` for the second.
pub fn line(name: &str, x: usize, y: usize, style: Style, width: f64, axis: &str) -> Value {
    json!({
        "type": "scatter", "mode": "lines", "name": text(name), "x": x, "y": y,
        "xaxis": "x", "yaxis": format!("y{axis}"), "showlegend": axis.is_empty(), "legendgroup": text(name),
        "line": { "color": style.colour, "dash": style.dash, "width": width },
    })
}

/// Points of a stage or of the measurement.
pub fn points(name: &str, x: usize, y: usize, style: Style, size: f64, opacity: f64) -> Value {
    json!({
        "type": "scatter", "mode": "markers", "name": text(name), "x": x, "y": y,
        "marker": { "color": style.colour, "symbol": style.symbol, "size": size, "opacity": opacity },
    })
}

/// Grid, ticks and title of an axis.
pub fn axis(title: &str) -> Value {
    json!({
        "title": { "text": text(title), "standoff": 8 }, "automargin": true, "hoverformat": ".5~g",
        "gridcolor": "#e3e6ea", "zerolinecolor": "#aab2bd", "zerolinewidth": 1,
        "showline": true, "linecolor": "#5a6572", "ticks": "outside", "tickcolor": "#5a6572", "ticklen": 4,
        "nticks": 8, "exponentformat": "power",
    })
}

/// The layout of a figure with one panel.
pub fn single(x: &str, y: &str) -> Value {
    let mut layout = base();
    layout["xaxis"] = axis(x);
    layout["yaxis"] = axis(y);
    layout
}

/// The layout of a figure with a panel for values above one for residuals, over a common abscissa.
pub fn stacked(x: &str, y: &str, residual: &str) -> Value {
    let mut layout = single(x, y);
    layout["yaxis"]["domain"] = json!([0.40, 1.0]);
    layout["yaxis2"] = axis(residual);
    layout["yaxis2"]["domain"] = json!([0.0, 0.32]);
    layout["xaxis"]["anchor"] = json!("y2");
    layout
}

fn base() -> Value {
    json!({
        "autosize": true, "paper_bgcolor": "#ffffff", "plot_bgcolor": "#ffffff", "hovermode": "closest",
        "font": { "family": "system-ui, sans-serif", "size": 13, "color": "#1d2530" },
        "margin": { "l": 56, "r": 40, "t": 12, "b": 48 }, "modebar": { "orientation": "v", "bgcolor": "#ffffff" },
        "legend": { "orientation": "h", "x": 0, "xanchor": "left", "y": 1.02, "yanchor": "bottom" },
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_six_digits_and_gaps_become_null() {
        let mut figures = Figures::default();
        figures.column([1.234_567_89e-5, f64::NAN, f64::INFINITY, 3.0]);
        assert!(figures.to_json().contains("[[0.0000123457,null,null,3]]"), "{}", figures.to_json());
    }

    #[test]
    fn no_name_can_end_the_script_element_or_become_a_link() {
        let mut figures = Figures::default();
        figures.add(vec![points("</script><a href='x'>", 0, 0, style(0, 1), 4.0, 1.0)], single("<b>", "y"));
        // Even a string that did not come through `text`.
        figures.add(vec![json!({ "name": "</script>" })], json!({ "title": "<!--" }));
        let text = figures.to_json();
        assert!(!text.contains('<') && !text.contains('>'), "{text}");
        let back: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(back["figures"][0]["data"][0]["name"], "&lt;/script&gt;&lt;a href='x'&gt;");
    }

    #[test]
    fn stages_are_drawn_differently() {
        for count in 2..=14 {
            let styles: Vec<_> = (0..count).map(|index| style(index, count)).collect();
            for (index, one) in styles.iter().enumerate() {
                assert!(!styles[..index].contains(one), "stage {index} of {count}");
            }
        }
    }
}
