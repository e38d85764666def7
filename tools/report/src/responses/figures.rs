//! The figures of response curves.

use stickslip::harmonic::{Contacting, Point};

use super::{ResponseCurve, Responses, trust};
use crate::branches::{most_moving, stable_and_unstable};
use crate::document::{Axis, Line, Panel, Plot, Scaling, Stroke, palette};

/// Loops drawn at most.
const LOOPS: usize = 12;

/// Amplitude of every node over frequency and, with several forces, over the force.
pub fn amplitudes(responses: &Responses) -> Vec<Plot> {
    let nodes = most_moving(responses.nodes().len(), responses.points());
    let mut plots = Vec::new();
    for &node in &nodes {
        let name = &responses.nodes()[node];
        let mut caption = format!("Largest displacement of {name} over a period.");
        if any_unstable(responses) {
            caption.push_str(" Dashed: unstable.");
        }
        if nodes.len() < responses.nodes().len() {
            caption
                .push_str(&format!(" Of {} nodes those that move most are drawn.", responses.nodes().len()));
        }
        let y = Axis::new(format!("displacement of {name}"), "m").scaled(Scaling::Either);
        let value = |_: &ResponseCurve, point: &Point| number(point.amplitude.get(node).copied());
        plots.push(plot(responses, caption, nodes.len() > 1, vec![(y, &value)]));
    }
    if responses.held.is_none() && responses.curves.len() > 1 {
        for &node in &nodes {
            let name = &responses.nodes()[node];
            let caption = format!("The same divided by the force: what is linear falls on one line. {name}.");
            let y = Axis::new(format!("{name} over force"), "m/N").scaled(Scaling::Either);
            let value =
                |_: &ResponseCurve, point: &Point| number(point.amplitude.get(node).copied()) / point.level;
            plots.push(plot(responses, caption, nodes.len() > 1, vec![(y, &value)]));
        }
    }
    plots
}

/// Response over force, and force, of a held response.
pub fn force(responses: &Responses) -> Vec<Plot> {
    let Some(held) = &responses.held else { return Vec::new() };
    let unit = ["m/N", "m/s/N", "m/s^2/N"][held.derivative.min(2)];
    let over = Axis::new(format!("{} over force", held.quantity()), unit).scaled(Scaling::Either);
    let caption = format!(
        "First harmonic of {} divided by the force that holds it; below, that force. A peak is a resonance.",
        held.name()
    );
    let ratio = |one: &ResponseCurve, point: &Point| one.level / point.level;
    let level = |_: &ResponseCurve, point: &Point| point.level;
    vec![plot(responses, caption, false, vec![(over, &ratio), (Axis::new("force", "N"), &level)])]
}

/// Energy, equivalent stiffness and time in stick of the model's contact.
pub fn contact(responses: &Responses) -> Vec<Plot> {
    let losses = &responses.losses;
    if losses.contact == 0 {
        return Vec::new();
    }
    let dissipated = |point: &Point| losses.of_contact(point);
    let mut plots = vec![energy(responses, "Energy that the contact takes per cycle", &dissipated)];
    let of = |point: &Point, value: fn(&Contacting) -> f64| number(losses.contact(point).map(value));
    let stiffness =
        |_: &ResponseCurve, point: &Point| of(point, |contact: &Contacting| contact.equivalent_stiffness);
    let stick = |_: &ResponseCurve, point: &Point| {
        of(point, |contact: &Contacting| contact.stick_fraction.unwrap_or(f64::NAN))
    };
    let y = Axis::new("equivalent stiffness", "N/m").scaled(Scaling::Either);
    let mut panels: Vec<(Axis, Value)> = vec![(y, &stiffness)];
    let mut caption = "Slope of the contact’s loop from tip to tip.".to_owned();
    let has_stick = |point: &Point| losses.contact(point).is_some_and(|one| one.stick_fraction.is_some());
    if responses.points().any(has_stick) {
        panels.push((Axis::new("stick fraction", "1"), &stick));
        caption.push_str(" Below, the fraction of the period in stick.");
    }
    plots.push(plot(responses, caption, true, panels));
    plots
}

/// Energy that nonlinearities of the structure itself take, where they take any.
pub fn structure(responses: &Responses) -> Vec<Plot> {
    if !responses.structure_takes_energy() {
        return Vec::new();
    }
    let caption = "Energy that the structure’s own nonlinearities (drag) take per cycle, besides the contact and the \
                   linear dampers";
    vec![energy(responses, caption, &|point| responses.losses.of_structure(point))]
}

/// An energy per cycle, and its fraction of the work.
fn energy(responses: &Responses, what: &str, of: &dyn Fn(&Point) -> f64) -> Plot {
    let taken = |_: &ResponseCurve, point: &Point| of(point);
    let fraction =
        |_: &ResponseCurve, point: &Point| if point.work > 0.0 { of(point) / point.work } else { f64::NAN };
    let y = Axis::new("energy per cycle", "J").scaled(Scaling::Either);
    let caption = format!("{what}; below, as fraction of the work of the excitation.");
    plot(responses, caption, true, vec![(y, &taken), (Axis::new("fraction of the work", "1"), &fraction)])
}

/// Estimated error on a logarithmic axis; unresolved points are marked.
pub fn errors(responses: &Responses) -> Vec<Plot> {
    // A point without any error in sight (linear, or in stick) has no place on a logarithmic axis.
    let estimate = |_: &ResponseCurve, point: &Point| {
        if point.error_estimate > 0.0 { point.error_estimate.max(1e-17) } else { f64::NAN }
    };
    let y = Axis::new("error estimate", "1").scaled(Scaling::Logarithmic);
    let caption = "Estimated truncation error of the displacements, as fraction of the amplitude.".to_owned();
    let mut plot = plot(responses, caption, false, vec![(y, &estimate)]);
    if plot.panels[0].lines.iter().all(|line| line.y.iter().all(|value| !value.is_finite())) {
        return Vec::new();
    }
    let unresolved: Vec<&Point> =
        responses.points().filter(|point| trust::error(point) == trust::Error::Unresolved).collect();
    if !unresolved.is_empty() {
        plot.panels[0].lines.push(Line {
            name: "unresolved".into(),
            x: unresolved.iter().map(|point| responses.unit.of(point.angular_frequency)).collect(),
            y: unresolved.iter().map(|point| estimate(&responses.curves[0], point)).collect(),
            stroke: Stroke::points("#D55E00", "x"),
        });
    }
    let (from, to) = (responses.unit.of(responses.range.0), responses.unit.of(responses.range.1));
    plot.panels[0].lines.push(Line {
        name: if responses.tolerance.is_some() { "tolerance".into() } else { "limit of the resolved".into() },
        x: vec![from, to],
        y: vec![responses.limit(); 2],
        stroke: Stroke { dash: "dot", width: 1.25, ..Stroke::solid("#5a6572") },
    });
    vec![plot]
}

/// Force against displacement of the contacts at the peaks, the normal direction of those that have one beside it.
pub fn loops(responses: &Responses) -> Vec<Plot> {
    [false, true].into_iter().filter_map(|is_normal| loops_along(responses, is_normal)).collect()
}

fn loops_along(responses: &Responses, is_normal: bool) -> Option<Plot> {
    let all = responses.curves.iter().flat_map(|one| &one.loops);
    let all: Vec<_> = all.filter(|one| one.is_normal == is_normal).collect();
    if all.is_empty() {
        return None;
    }
    let step = all.len().div_ceil(LOOPS);
    let shown: Vec<_> = all.iter().step_by(step).collect();
    let lines = shown.iter().enumerate().map(|(index, one)| Line {
        name: one.name.clone(),
        x: one.displacement.clone(),
        y: one.force.clone(),
        stroke: Stroke::solid(palette(index, shown.len())),
    });
    let (what, axis) = if is_normal {
        (
            "Normal force of the contact, the load at rest taken off, against its opening",
            "opening of the contact",
        )
    } else {
        ("Restoring force of the contact against its displacement", "displacement of the contact")
    };
    let mut caption =
        format!("{what} over one period at the peaks, by the contact law along the displacement found.");
    if step > 1 {
        caption.push_str(&format!(" {} of {} loops are drawn.", shown.len(), all.len()));
    }
    Some(Plot {
        caption,
        half: false,
        x: Axis::new(axis, "m"),
        panels: vec![Panel { y: Axis::new("force", "N"), lines: lines.collect() }],
    })
}

/// What a panel shows at a point of a curve (SI).
type Value<'a> = &'a dyn Fn(&ResponseCurve, &Point) -> f64;

/// A figure over frequency with every curve in every panel.
fn plot(responses: &Responses, caption: String, half: bool, panels: Vec<(Axis, Value)>) -> Plot {
    let panel = |(y, value): (Axis, Value)| {
        let count = responses.curves.len();
        let lines = responses.curves.iter().enumerate().flat_map(|(index, one)| {
            let at = |point: &Point| {
                (responses.unit.of(point.angular_frequency), value(one, point), point.stable == Some(false))
            };
            let points: Vec<_> = one.curve.points.iter().map(at).collect();
            stable_and_unstable(&responses.level(one), &palette(index, count), &points)
        });
        Panel { y, lines: lines.collect() }
    };
    let x = Axis::new("frequency", responses.unit.name());
    Plot { caption, half, x, panels: panels.into_iter().map(panel).collect() }
}

fn any_unstable(responses: &Responses) -> bool {
    responses.points().any(|point| point.stable == Some(false))
}

fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}
