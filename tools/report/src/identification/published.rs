//! What the published way shows of an identification: the responses of the levels, the beam's modes at each amplitude, their
//! coordinates, and how two of them follow the measured acceleration and the contact's force.

use std::f64::consts::TAU;

use stickslip::harmonic::fourier::value;
use stickslip::identify::{ContactRecord, Level, Published};

use super::IdentificationReport;
use super::tables::table;
use crate::document::{Axis, Block, Cell, Line, Panel, Plot, Stroke, Table, palette};
use crate::format;

/// Steps of a period, and points of a measured one.
const STEPS: usize = 360;
const POINTS: usize = 72;

impl IdentificationReport<'_> {
    /// The section's blocks; none where the published way gave nothing.
    pub(super) fn published(&self) -> Vec<Block> {
        let found: Vec<(&ContactRecord, &Published)> = self
            .found
            .records
            .iter()
            .filter_map(|record| Some((record, record.published.as_ref()?)))
            .collect();
        let Some(largest) = found.iter().max_by(|a, b| a.0.amplitude.total_cmp(&b.0.amplitude)) else {
            return Vec::new();
        };
        let plots = vec![shapes(&found), coordinates(largest), acceleration(largest), self.forces(largest)];
        vec![Block::Table(mode_table(&found)), Block::Plots(plots)]
    }

    /// The published force beside the inverted one.
    fn forces(&self, (record, published): &(&ContactRecord, &Published)) -> Plot {
        let inverted = self.periods().find(|(other, _)| other.name == record.name);
        let inverted = inverted.map_or(&[][..], |(_, period)| &period.force[1..]);
        let without_mean =
            |force: &[f64]| std::iter::once(0.0).chain(force.iter().copied()).collect::<Vec<_>>();
        half(
            format!(
                "Contact’s force at {}, means left out: inverted (line), and balanced in two modes (dashed).",
                level(record)
            ),
            Axis::new("force", "N"),
            vec![
                over_period("inverted", &without_mean(inverted), STEPS, Stroke::solid("#000000")),
                over_period(
                    "two modes",
                    &without_mean(&published.force[1..]),
                    STEPS,
                    Stroke::dashed("#D55E00"),
                ),
            ],
        )
    }

    /// Acceleration over force under held response, measured and fitted (figure 3 of the paper).
    pub(super) fn held_responses(&self) -> Option<Plot> {
        let held: Vec<&Level> = self.found.levels.iter().filter(|level| level.peak.is_some()).collect();
        let mut lines = Vec::new();
        for (k, level) in held.iter().enumerate() {
            let (name, colour) =
                (format!("{} m/s²", format::significant(level.amplitude, 3)), palette(k, held.len()));
            let single = [[level.frequency, level.peak?]];
            let measured = level.response.as_ref().map_or(&single[..], |response| &response.measured);
            lines.push(points(&name, measured, Stroke::points(&colour, "circle-open")));
            if let Some(response) = &level.response {
                lines.push(points(&name, &response.fitted, Stroke::solid(&colour)));
            }
        }
        (!lines.is_empty()).then(|| Plot {
            caption: "Acceleration over force at the excitation with the response held: measured (points; one at the resonance where \
                      no band was recorded) and fitted (lines)."
                .into(),
            half: true,
            x: Axis::new("frequency", "Hz"),
            panels: vec![Panel { y: Axis::new("acceleration over force", "1/kg"), lines }],
        })
    }
}

/// The first mode at every amplitude, one at the excitation's side of the beam.
fn shapes(found: &[(&ContactRecord, &Published)]) -> Plot {
    let line = |(k, (record, published)): (usize, &(&ContactRecord, &Published))| {
        let shape = published.modes.first().map_or(&[][..], |mode| &mode.shape);
        let largest = shape.iter().map(|[_, y]| *y).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
        let scaled: Vec<[f64; 2]> = shape.iter().map(|[x, y]| [*x, y / largest]).collect();
        points(&level(record), &scaled, Stroke::solid(palette(k, found.len())))
    };
    Plot {
        caption: "First mode of the beam at every amplitude, its largest deflection 1: the rotational stiffness at the end falls.".into(),
        half: true,
        x: Axis::new("position", "m"),
        panels: vec![Panel { y: Axis::new("shape", "1"), lines: found.iter().enumerate().map(line).collect() }],
    }
}

/// The modal coordinates over a period (figure 4).
fn coordinates((record, published): &(&ContactRecord, &Published)) -> Plot {
    let line = |(k, mode): (usize, &stickslip::identify::AmplitudeMode)| {
        over_period(
            &format!("mode {}", k + 1),
            &mode.coordinate,
            STEPS,
            Stroke::solid(palette(k, published.modes.len())),
        )
    };
    half(
        format!(
            "Modal coordinates at {}, from the accelerations by the pseudo-inverse of the shapes.",
            level(record)
        ),
        Axis::new("coordinate", "m.kg^0.5"),
        published.modes.iter().enumerate().map(line).collect(),
    )
}

/// The acceleration at the excitation, measured and of two modes (figure 5).
fn acceleration((record, published): &(&ContactRecord, &Published)) -> Plot {
    let [measured, reconstructed] = &published.acceleration;
    half(
        format!(
            "Acceleration nearest to the excitation at {}: measured (points), and by two modes (line).",
            level(record)
        ),
        Axis::new("acceleration", "m/s^2"),
        vec![
            over_period("measured", measured, POINTS, Stroke::points("#000000", "circle-open")),
            over_period("two modes", reconstructed, STEPS, Stroke::solid("#D55E00")),
        ],
    )
}

/// Stiffness and modes at every amplitude, the conditioning of equation 7, and what the force differs by.
fn mode_table(found: &[(&ContactRecord, &Published)]) -> Table {
    let modes = found.iter().map(|(_, published)| published.modes.len()).max().unwrap_or(0);
    let heading: Vec<String> = ["Record", "k_θ (N·m/rad)"]
        .map(str::to_owned)
        .into_iter()
        .chain((1..=modes).map(|k| format!("f{k} (Hz)")))
        .chain(["conditioning", "force differs by (%)"].map(str::to_owned))
        .collect();
    let row = |(record, published): &(&ContactRecord, &Published)| {
        let frequency = |k: usize| published.modes.get(k).map_or(f64::NAN, |mode| mode.frequency);
        [Cell::text(record.name.clone()), Cell::Number(published.rotational_stiffness, 2)]
            .into_iter()
            .chain((0..modes).map(|k| Cell::Number(frequency(k), 3)))
            .chain([Cell::Number(published.conditioning, 2), Cell::Number(100.0 * published.difference, 1)])
            .collect()
    };
    let heading: Vec<&str> = heading.iter().map(String::as_str).collect();
    table("Modes at every amplitude", &heading, found.iter().map(row).collect())
}

fn level(record: &ContactRecord) -> String {
    format!("{} m/s²", format::significant(record.amplitude, 3))
}

pub(crate) fn half(caption: String, y: Axis, lines: Vec<Line>) -> Plot {
    Plot { caption, half: true, x: Axis::new("time over period", "1"), panels: vec![Panel { y, lines }] }
}

pub(crate) fn over_period(name: &str, coefficients: &[f64], steps: usize, stroke: Stroke) -> Line {
    let at = |k: usize| k as f64 / steps as f64;
    Line {
        name: name.to_owned(),
        x: (0..=steps).map(at).collect(),
        y: (0..=steps).map(|k| value(coefficients, TAU * at(k))).collect(),
        stroke,
    }
}

pub(crate) fn points(name: &str, values: &[[f64; 2]], stroke: Stroke) -> Line {
    Line {
        name: name.to_owned(),
        x: values.iter().map(|[x, _]| *x).collect(),
        y: values.iter().map(|[_, y]| *y).collect(),
        stroke,
    }
}
