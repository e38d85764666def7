//! What the published way shows: nonlinear modes, their coordinates, and how they follow acceleration and forces.

use stickslip::identify::{PublishedSlipSlap, SlipSlapRecord};

use super::{SlipSlapReport, level};
use crate::document::{Axis, Block, Cell, Line, Panel, Plot, Stroke, Table, palette};
use crate::identification::{half, over_period, points, table};

/// Steps of a period, and points of a measured one.
const STEPS: usize = 360;
const POINTS: usize = 120;

impl SlipSlapReport<'_> {
    /// The section's blocks; none where the published way gave nothing.
    pub(super) fn published(&self) -> Vec<Block> {
        let found: Vec<(&SlipSlapRecord, &PublishedSlipSlap)> = self
            .found
            .records
            .iter()
            .filter_map(|record| Some((record, record.published.as_ref()?)))
            .collect();
        let Some(largest) = found.iter().max_by(|a, b| a.0.accelerations[0].total_cmp(&b.0.accelerations[0]))
        else {
            return Vec::new();
        };
        let mut blocks = Vec::new();
        if found.iter().any(|(_, published)| !published.trusted()) {
            let text = "The forces of the published way are not to be trusted here: see the warnings above. Its normal displacement \
                        is an echo of the normal stiffness that was assumed.";
            blocks.push(Block::Warning(text.to_owned()));
        }
        let forces = [0, 1].map(|direction| self.forces(largest, direction));
        let plots = [shapes(largest), coordinates(largest), acceleration(largest)].into_iter().chain(forces);
        blocks.push(Block::Table(mode_table(&found)));
        blocks.push(Block::Plots(plots.collect()));
        blocks
    }

    /// A published force beside the inverted one.
    fn forces(&self, (record, published): &(&SlipSlapRecord, &PublishedSlipSlap), direction: usize) -> Plot {
        let inverted = self.periods().find(|(other, _)| other.name == record.name);
        let inverted = inverted.map_or(&[][..], |(_, periods)| &periods[direction].force);
        let without_mean = |force: &[f64]| {
            let mut force = force.to_vec();
            force.iter_mut().take(1).for_each(|mean| *mean = 0.0);
            force
        };
        let name = ["Tangential", "Normal"][direction];
        half(
            format!(
                "{name} force at {}, means left out: inverted (line), and by the published way (dashed).",
                level(record)
            ),
            Axis::new("force", "N"),
            vec![
                over_period("inverted", &without_mean(inverted), STEPS, Stroke::solid("#000000")),
                over_period(
                    "published way",
                    &without_mean(&published.forces[direction]),
                    STEPS,
                    Stroke::dashed("#D55E00"),
                ),
            ],
        )
    }
}

/// Both nonlinear modes, their largest deflections 1.
fn shapes((record, published): &(&SlipSlapRecord, &PublishedSlipSlap)) -> Plot {
    let line = |(k, name): (usize, &str)| {
        let shape = &published.modes[k].shape;
        let largest = shape.iter().map(|[_, y]| *y).max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
        let scaled: Vec<[f64; 2]> = shape.iter().map(|[x, y]| [*x, y / largest]).collect();
        points(name, &scaled, Stroke::solid(palette(k, 2)))
    };
    Plot {
        caption: format!(
            "Nonlinear modes of both harmonics at {}, their largest deflections 1.",
            level(record)
        ),
        half: true,
        x: Axis::new("position", "m"),
        panels: vec![Panel {
            y: Axis::new("shape", "1"),
            lines: ["first harmonic", "third harmonic"]
                .into_iter()
                .enumerate()
                .map(line)
                .collect::<Vec<Line>>(),
        }],
    }
}

/// The coordinates over a period (figure 4).
fn coordinates((record, published): &(&SlipSlapRecord, &PublishedSlipSlap)) -> Plot {
    let line = |(k, name): (usize, &str)| {
        over_period(name, &published.modes[k].coordinate, STEPS, Stroke::solid(palette(k, 2)))
    };
    half(
        format!("Coordinates of the nonlinear modes at {}.", level(record)),
        Axis::new("coordinate", "m.kg^0.5"),
        ["first harmonic", "third harmonic"].into_iter().enumerate().map(line).collect(),
    )
}

/// The acceleration at the excitation, measured and of both modes (figure 5).
fn acceleration((record, published): &(&SlipSlapRecord, &PublishedSlipSlap)) -> Plot {
    let [measured, reconstructed] = &published.acceleration;
    half(
        format!(
            "Acceleration nearest to the excitation at {}: measured (points), and by both nonlinear modes (line).",
            level(record)
        ),
        Axis::new("acceleration", "m/s^2"),
        vec![
            over_period("measured", measured, POINTS, Stroke::points("#000000", "circle-open")),
            over_period("nonlinear modes", reconstructed, STEPS, Stroke::solid("#D55E00")),
        ],
    )
}

/// Parts of the linear modes, phases, what the projection sees of the normal direction, and how far its forces are off.
fn mode_table(found: &[(&SlipSlapRecord, &PublishedSlipSlap)]) -> Table {
    let heading = [
        "Level",
        "phases differ by (°)",
        "η/φ of mode 1 (%)",
        "η/φ of mode 3 (%)",
        "S differs by (%)",
        "N differs by (%)",
        "η per k_n (%/%)",
    ];
    let row = |(record, published): &(&SlipSlapRecord, &PublishedSlipSlap)| {
        let scatter = published.modes.iter().map(|mode| mode.phase_scatter).fold(0.0, f64::max);
        let ratio = |k: usize| Cell::Number(100.0 * published.modes[k].normal_ratio.abs(), 2);
        vec![
            Cell::text(level(record)),
            Cell::Number(scatter.to_degrees(), 1),
            ratio(0),
            ratio(1),
            Cell::Number(100.0 * published.difference[0], 0),
            Cell::Number(100.0 * published.difference[1], 0),
            Cell::Number(published.echo, 2),
        ]
    };
    table("Nonlinear modes", &heading, found.iter().map(row).collect())
}
