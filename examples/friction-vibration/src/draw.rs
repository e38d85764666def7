//! From curves to lines and tables of the page.

use stickslip::harmonic::{Curve, Point};
use stickslip_report::contact_loop;
use stickslip_report::document::{Axis, Block, Cell, Line, Panel, Plot, Stroke, Table, palette};

use crate::Failure;
use crate::system::System;

/// A curve of `value` over frequency.
pub fn over_frequency(
    name: impl Into<String>,
    curve: &Curve,
    stroke: Stroke,
    value: impl Fn(&Point) -> f64,
) -> Line {
    Line {
        name: name.into(),
        x: curve.points.iter().map(|point| point.angular_frequency).collect(),
        y: curve.points.iter().map(value).collect(),
        stroke,
    }
}

/// One of several ordered lines.
pub fn ordered(index: usize, count: usize) -> Stroke {
    Stroke::solid(palette(index, count))
}

/// A plot with one panel.
pub fn plot(caption: impl Into<String>, half: bool, x: Axis, y: Axis, lines: Vec<Line>) -> Plot {
    Plot { caption: caption.into(), half, x, panels: vec![Panel { y, lines }] }
}

/// The abscissa of a response.
pub fn frequency() -> Axis {
    Axis::new("frequency", "rad/s")
}

/// The contact's loop at a point.
pub fn hysteresis(name: String, system: &System, point: &Point, stroke: Stroke) -> Result<Line, Failure> {
    let law = system.law()?;
    let series = point.contacts.first().map_or(&[][..], |contact| &contact.displacement);
    let (x, y) = contact_loop(&law, system.normal_load, point.angular_frequency, series)
        .ok_or_else(|| Failure::from("the contact did not become periodic"))?;
    Ok(Line { name, x, y, stroke })
}

/// Equivalent stiffness of the contact (N/m).
pub fn equivalent_stiffness(point: &Point) -> f64 {
    point.contacts.first().map_or(f64::NAN, |contact| contact.equivalent_stiffness)
}

/// A table.
pub fn table<const N: usize>(label: &str, heading: [&str; N], rows: Vec<[Cell; N]>) -> Block {
    Block::Table(Table {
        label: label.to_owned(),
        heading: heading.map(str::to_owned).to_vec(),
        rows: rows.into_iter().map(Vec::from).collect(),
    })
}
