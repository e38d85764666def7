//! The figures of response curves.

use stickslip::harmonic::{Contacting, Point};

use super::{ResponseCurve, Responses, trust};
use crate::document::{Axis, Line, Panel, Plot, Scaling, Stroke, palette};

/// Nodes that have figures of their own; the files hold all.
const NODES: usize = 8;
/// Loops drawn at most.
const LOOPS: usize = 12;

/// Amplitude of every node over frequency and, with several forces, over the force.
pub fn amplitudes(responses: &Responses) -> Vec<Plot> {
    let nodes = shown_nodes(responses);
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

/// The nodes with the largest amplitudes, in their own order.
fn shown_nodes(responses: &Responses) -> Vec<usize> {
    let count = responses.nodes().len();
    let mut nodes: Vec<usize> = (0..count).collect();
    if count > NODES {
        let largest = |node: &usize| {
            responses.points().filter_map(|point| point.amplitude.get(*node)).fold(0.0_f64, |a, &b| a.max(b))
        };
        nodes.sort_by(|a, b| largest(b).total_cmp(&largest(a)));
        nodes.truncate(NODES);
        nodes.sort_unstable();
    }
    nodes
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
    if !losses.contact {
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

/// Force against displacement of the contacts at the peaks.
pub fn loops(responses: &Responses) -> Vec<Plot> {
    let all: Vec<_> = responses.curves.iter().flat_map(|one| &one.loops).collect();
    if all.is_empty() {
        return Vec::new();
    }
    let step = all.len().div_ceil(LOOPS);
    let shown: Vec<_> = all.iter().step_by(step).collect();
    let lines = shown.iter().enumerate().map(|(index, one)| Line {
        name: one.name.clone(),
        x: one.displacement.clone(),
        y: one.force.clone(),
        stroke: Stroke::solid(palette(index, shown.len())),
    });
    let mut caption =
        "Restoring force of the contact against its displacement over one period at the peaks, \
                       by the contact law along the displacement found."
            .to_owned();
    if step > 1 {
        caption.push_str(&format!(" {} of {} loops are drawn.", shown.len(), all.len()));
    }
    vec![Plot {
        caption,
        half: false,
        x: Axis::new("displacement of the contact", "m"),
        panels: vec![Panel { y: Axis::new("force", "N"), lines: lines.collect() }],
    }]
}

/// What a panel shows at a point of a curve (SI).
type Value<'a> = &'a dyn Fn(&ResponseCurve, &Point) -> f64;

/// A figure over frequency with every curve in every panel.
fn plot(responses: &Responses, caption: String, half: bool, panels: Vec<(Axis, Value)>) -> Plot {
    let panel = |(y, value): (Axis, Value)| {
        let count = responses.curves.len();
        let lines = responses
            .curves
            .iter()
            .enumerate()
            .flat_map(|(index, one)| branches(responses, one, &palette(index, count), value));
        Panel { y, lines: lines.collect() }
    };
    let x = Axis::new("frequency", responses.unit.name());
    Plot { caption, half, x, panels: panels.into_iter().map(panel).collect() }
}

/// A curve as a full line where it is stable and a dashed one where it is not.
fn branches(responses: &Responses, one: &ResponseCurve, colour: &str, value: Value) -> Vec<Line> {
    let points = &one.curve.points;
    let at = |index: usize| (responses.unit.of(points[index].angular_frequency), value(one, &points[index]));
    let mut lines = Vec::new();
    for unstable in [false, true] {
        let belongs = |index: usize| {
            let ends = &points[index..points.len().min(index + 2)];
            ends.iter().any(|point| point.stable == Some(false)) == unstable
        };
        let (mut x, mut y): (Vec<f64>, Vec<f64>) = (Vec::new(), Vec::new());
        let mut open = false;
        // Pieces between neighbours; both kinds of line share the points where one becomes the other.
        for index in 0..points.len().saturating_sub(1) {
            if !belongs(index) {
                open = false;
                continue;
            }
            if !open {
                if !x.is_empty() {
                    x.push(f64::NAN);
                    y.push(f64::NAN);
                }
                let (start, height) = at(index);
                x.push(start);
                y.push(height);
            }
            open = true;
            let (end, height) = at(index + 1);
            x.push(end);
            y.push(height);
        }
        if !x.is_empty() {
            let stroke = if unstable {
                Stroke { note: "unstable", ..Stroke::dashed(colour) }
            } else {
                Stroke::solid(colour)
            };
            lines.push(Line { name: responses.level(one), x, y, stroke });
        }
    }
    lines
}

fn any_unstable(responses: &Responses) -> bool {
    responses.points().any(|point| point.stable == Some(false))
}

fn number(value: Option<f64>) -> f64 {
    value.unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use stickslip::harmonic::{Curve, Ending};

    use super::*;

    fn point(angular_frequency: f64, stable: bool) -> Point {
        Point {
            angular_frequency,
            level: 1.0,
            amplitude: vec![angular_frequency],
            nodes: vec![vec![0.0, angular_frequency, 0.0]],
            contacts: Vec::new(),
            work: 1.0,
            stable: Some(stable),
            undecided: None,
            error_estimate: 0.0,
            resolved: true,
            harmonics: 1,
            iterations: 1,
        }
    }

    #[test]
    fn stable_and_unstable_branches_meet_and_cover_the_curve_once() {
        let stable = [true, true, false, false, true, true, true, false];
        let points: Vec<Point> = stable.iter().enumerate().map(|(i, &s)| point(i as f64, s)).collect();
        let curve = Curve {
            nodes: vec!["a".into()],
            points,
            peaks: Vec::new(),
            folds: Vec::new(),
            ending: Ending::Complete,
        };
        let one = ResponseCurve {
            level: 1.0,
            curve,
            phase_resonances: Vec::new(),
            loops: Vec::new(),
            failure: None,
            seconds: 0.0,
        };
        let responses = Responses {
            title: String::new(),
            unit: super::super::FrequencyUnit::RadiansPerSecond,
            range: (0.0, 7.0),
            held: None,
            harmonics: 1,
            tolerance: None,
            stability: true,
            losses: super::super::Losses::default(),
            curves: vec![one],
            seconds: 0.0,
        };
        let value = |_: &ResponseCurve, point: &Point| point.amplitude[0];
        let lines = branches(&responses, &responses.curves[0], "#000000", &value);
        assert_eq!(lines.len(), 2);
        let length = |line: &Line| -> f64 {
            line.x.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| step.is_finite()).sum()
        };
        assert_eq!((length(&lines[0]), length(&lines[1])), (3.0, 4.0));
        assert_eq!((lines[0].stroke.dash, lines[1].stroke.dash), ("solid", "dash"));
        assert_eq!(lines[0].x.iter().filter(|x| x.is_nan()).count(), 1);
    }
}
