//! A curve as SVG inside a page.

use std::fmt::Write as _;

const WIDTH: f64 = 420.0;
const HEIGHT: f64 = 300.0;
const MARGIN: f64 = 44.0;

/// `y` over `x` with the ends of both axes named; `None` where there is nothing to draw.
pub fn curve(x: &[f64], y: &[f64], [horizontal, vertical]: [&str; 2]) -> Option<String> {
    let ((left, right), (low, high)) = (range(x)?, range(y)?);
    let across = |value: f64| MARGIN + (value - left) / (right - left) * (WIDTH - 2.0 * MARGIN);
    let down = |value: f64| HEIGHT - MARGIN - (value - low) / (high - low) * (HEIGHT - 2.0 * MARGIN);
    let mut points = String::new();
    for (x, y) in x.iter().zip(y) {
        let _ = write!(points, "{:.1},{:.1} ", across(*x), down(*y));
    }
    let (bottom, end) = (HEIGHT - MARGIN, WIDTH - MARGIN);
    let label = |x: f64, y: f64, anchor: &str, text: &str| {
        format!("<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{text}</text>\n")
    };
    let mut svg = format!(
        "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" width=\"{WIDTH}\" font-size=\"12\" role=\"img\" aria-label=\"{vertical} over \
         {horizontal}\">\n<rect x=\"{MARGIN}\" y=\"{MARGIN}\" width=\"{}\" height=\"{}\" fill=\"none\" stroke=\"#999\"/>\n\
         <polyline points=\"{}\" fill=\"none\" stroke=\"#2166ac\" stroke-width=\"1.5\"/>\n",
        WIDTH - 2.0 * MARGIN,
        HEIGHT - 2.0 * MARGIN,
        points.trim_end(),
    );
    svg += &label(MARGIN, bottom + 16.0, "start", &short(left));
    svg += &label(end, bottom + 16.0, "end", &short(right));
    svg += &label(WIDTH / 2.0, bottom + 32.0, "middle", horizontal);
    svg += &label(MARGIN, MARGIN - 6.0, "start", &format!("{vertical}: {} to {}", short(low), short(high)));
    svg += "</svg>\n";
    Some(svg)
}

/// Least and largest; `None` where they are one.
fn range(values: &[f64]) -> Option<(f64, f64)> {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (largest - least > 0.0 && (largest - least).is_finite()).then_some((least, largest))
}

fn short(value: f64) -> String {
    if value == 0.0 { "0".to_owned() } else { format!("{value:.3e}") }
}
