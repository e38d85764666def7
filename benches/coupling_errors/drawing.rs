//! Errors over communication steps, both logarithmic: small panels side by side.

use std::fmt::Write as _;

const COLOURS: [&str; 6] = ["#b2182b", "#ef8a62", "#762a83", "#1b7837", "#2166ac", "#67a9cf"];
const COLUMNS: usize = 4;
/// Of a panel without its labels.
const SIZE: [f64; 2] = [210.0, 170.0];
/// From one panel to the next.
const PITCH: [f64; 2] = [270.0, 230.0];
/// Decades of the steps (s) and of the errors.
const STEPS: [i32; 2] = [-6, -3];
const ERRORS: [i32; 2] = [-10, 1];

/// The errors of an algorithm; those that are no number are left out.
pub struct Curve {
    name: &'static str,
    points: Vec<[f64; 2]>,
}

impl Curve {
    pub fn new(name: &'static str, steps: &[f64], errors: &[f64]) -> Self {
        let points = steps.iter().zip(errors).filter(|(_, error)| error.is_finite());
        Self { name, points: points.map(|(step, error)| [*step, *error]).collect() }
    }
}

/// The errors of one signal.
pub struct Panel {
    pub title: String,
    pub curves: Vec<Curve>,
}

/// All panels, with a legend of the first one's curves above.
pub fn page(panels: &[Panel]) -> String {
    let rows = panels.len().div_ceil(COLUMNS);
    let [width, height] = [PITCH[0] * COLUMNS as f64 + 20.0, PITCH[1] * rows as f64 + 50.0];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" \
         font-size=\"10\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n\
         <text x=\"20\" y=\"16\">Relative error over the communication step H (s)</text>\n"
    );
    for (index, curve) in panels.iter().flat_map(|panel| panel.curves.iter().take(COLOURS.len())).enumerate()
    {
        if index == panels[0].curves.len() {
            break;
        }
        let (left, colour) = (20.0 + 190.0 * index as f64, COLOURS[index % COLOURS.len()]);
        let _ = writeln!(
            svg,
            "<path d=\"M{left} 29h18\" stroke=\"{colour}\" stroke-width=\"3\"/><text x=\"{}\" y=\"33\">{}</text>",
            left + 24.0,
            curve.name
        );
    }
    for (index, panel) in panels.iter().enumerate() {
        let corner = [45.0 + PITCH[0] * (index % COLUMNS) as f64, 70.0 + PITCH[1] * (index / COLUMNS) as f64];
        draw(&mut svg, panel, corner);
    }
    svg + "</svg>\n"
}

fn draw(svg: &mut String, panel: &Panel, [left, top]: [f64; 2]) {
    let along = |value: f64, [low, high]: [i32; 2]| {
        (value.log10() - f64::from(low)).clamp(0.0, f64::from(high - low)) / f64::from(high - low)
    };
    let x = |step: f64| left + SIZE[0] * along(step, STEPS);
    let y = |error: f64| top + SIZE[1] * (1.0 - along(error, ERRORS));
    let (right, bottom) = (left + SIZE[0], top + SIZE[1]);
    let _ =
        writeln!(svg, "<text x=\"{left}\" y=\"{}\" font-weight=\"bold\">{}</text>", top - 6.0, panel.title);
    for decade in ERRORS[0]..=ERRORS[1] {
        let at = y(10f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M{left} {at:.1}H{right}\" stroke=\"#ddd\"/><text x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\">1e{decade}</text>",
            left - 4.0,
            at + 3.5
        );
    }
    for decade in STEPS[0]..=STEPS[1] {
        let at = x(10f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M{at:.1} {top}V{bottom}\" stroke=\"#ddd\"/><text x=\"{at:.1}\" y=\"{}\" \
             text-anchor=\"middle\">1e{decade}</text>",
            bottom + 13.0
        );
    }
    for (curve, colour) in panel.curves.iter().zip(COLOURS.iter().cycle()) {
        let points: Vec<String> =
            curve.points.iter().map(|[step, error]| format!("{:.1},{:.1}", x(*step), y(*error))).collect();
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\"/>",
            points.join(" ")
        );
    }
}
