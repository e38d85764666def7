//! The page of a nonlinear mode: frequency, damping and shape over the amplitude.

use std::f64::consts::TAU;

use stickslip::harmonic::{ModePoint, NonlinearMode};

use crate::branches::most_moving;
use crate::document::{
    Axis, Block, Cell, Document, Line, Panel, Plot, Scaling, Section, Stroke, Table, document_html, palette,
};
use crate::{Settings, format};

/// Rows of the table at most; the files have all points.
const ROWS: usize = 15;

/// A nonlinear mode, and what was asked for.
#[derive(Debug, Clone)]
pub struct ModeReport<'a> {
    /// What vibrates.
    pub title: String,
    /// Names of the nodes.
    pub nodes: &'a [String],
    /// Place of the node whose first harmonic is the amplitude.
    pub node: usize,
    /// Number of amplitudes asked for.
    pub asked: usize,
    /// Harmonics of the vibration.
    pub harmonics: usize,
    /// What was found.
    pub mode: &'a NonlinearMode,
}

/// One self-contained HTML page of the mode.
pub fn mode_html(report: &ModeReport, settings: &Settings) -> String {
    document_html(&report.document(), settings)
}

impl ModeReport<'_> {
    fn document(&self) -> Document {
        let node = self.node_name();
        let mut sections = Vec::new();
        let mut section = |id: &str, title: &str, blocks: Vec<Block>| {
            sections.push(Section { id: id.into(), title: title.into(), blocks });
        };
        if !self.mode.points.is_empty() {
            section("backbone", "Frequency and damping", vec![Block::Plots(vec![self.backbone()])]);
            let mut plots = vec![self.dissipation()];
            plots.extend((self.nodes.len() > 1).then(|| self.shape()));
            section("contact", "Loss and shape", vec![Block::Plots(plots)]);
            section("points", "Vibrations", vec![self.table()]);
        }
        Document {
            title: self.title.clone(),
            lead: self.lead(),
            warnings: self.warnings(),
            scope: format!(
                "{} of the first harmonic of {node}, {} of {} found; {}.",
                format::count(self.asked, "amplitude"),
                self.mode.points.len(),
                self.asked,
                format::count(self.harmonics, "harmonic"),
            ),
            sections,
        }
    }

    fn node_name(&self) -> &str {
        self.nodes.get(self.node).map_or("", String::as_str)
    }

    /// The result in a sentence.
    fn lead(&self) -> String {
        let [first, .., last] = self.mode.points.as_slice() else {
            return "Fewer than two vibrations were found.".to_owned();
        };
        let ratios = || self.mode.points.iter().map(|point| 100.0 * point.damping_ratio);
        format!(
            "From {} to {} of {} the frequency goes from {} to {}; the damping ratio is {}\u{a0}% to {}\u{a0}%.",
            format::engineering(first.amplitude, "m"),
            format::engineering(last.amplitude, "m"),
            self.node_name(),
            hertz(first.angular_frequency),
            hertz(last.angular_frequency),
            format::significant(ratios().fold(f64::INFINITY, f64::min), 3),
            format::significant(ratios().fold(f64::NEG_INFINITY, f64::max), 3),
        )
    }

    fn warnings(&self) -> Vec<String> {
        let reached = self.mode.points.last().map_or_else(
            || "before the first amplitude".to_owned(),
            |point| format!("at {}", format::engineering(point.amplitude, "m")),
        );
        match &self.mode.lost {
            Some(error) => {
                vec![format!(
                    "The mode ends {reached}: no vibration of the next amplitude was found ({error})."
                )]
            }
            None if self.mode.points.len() < self.asked => vec![format!("Interrupted {reached}.")],
            None => Vec::new(),
        }
    }

    /// Frequency over the amplitude, and below the damping ratio.
    fn backbone(&self) -> Plot {
        let frequency = self.line("nonlinear mode", |point| point.angular_frequency / TAU);
        let linear = Line {
            name: "contact as it is at rest".into(),
            y: vec![self.mode.angular_frequency / TAU; frequency.x.len()],
            x: frequency.x.clone(),
            stroke: Stroke { width: 1.25, ..Stroke::dashed("#5a6572") },
        };
        let damping = self.line("nonlinear mode", |point| point.damping_ratio);
        self.plot(
            "Frequency of the free vibration; below, its damping ratio. Dashed: the frequency with the contact as it is at rest.",
            false,
            vec![
                Panel { y: Axis::new("frequency", "Hz"), lines: vec![linear, frequency] },
                Panel { y: Axis::new("damping ratio", "1"), lines: vec![damping] },
            ],
        )
    }

    /// Energy lost in contacts per cycle.
    fn dissipation(&self) -> Plot {
        let y = Axis::new("loss per cycle", "J").scaled(Scaling::Either);
        let lines = vec![self.line("contacts", |point| point.dissipated_energy)];
        self.plot("Energy that the contacts take per cycle.", true, vec![Panel { y, lines }])
    }

    /// How far the nodes move for an amplitude of one.
    fn shape(&self) -> Plot {
        let shown = most_moving(self.nodes.len(), self.mode.points.iter().map(|point| &point.point));
        let lines = shown.iter().enumerate().map(|(index, node)| {
            let moved = |point: &ModePoint| {
                point.point.amplitude.get(*node).map_or(f64::NAN, |a| a / point.amplitude)
            };
            let stroke = Stroke::solid(palette(index, shown.len()));
            Line { stroke, ..self.line(&self.nodes[*node], moved) }
        });
        let y = Axis::new("displacement over amplitude", "1");
        self.plot(
            "Shape: the largest displacement of each node over a period, divided by the amplitude.",
            true,
            vec![Panel { y, lines: lines.collect() }],
        )
    }

    fn plot(&self, caption: &str, half: bool, panels: Vec<Panel>) -> Plot {
        let x = Axis::new(format!("amplitude of {}", self.node_name()), "m").scaled(Scaling::Logarithmic);
        Plot { caption: caption.to_owned(), half, x, panels }
    }

    fn line(&self, name: &str, value: impl Fn(&ModePoint) -> f64) -> Line {
        let points = &self.mode.points;
        Line {
            name: name.to_owned(),
            x: points.iter().map(|point| point.amplitude).collect(),
            y: points.iter().map(value).collect(),
            ..Line::default()
        }
    }

    fn table(&self) -> Block {
        let heading =
            ["Amplitude", "Frequency (Hz)", "Damping ratio (%)", "Loss per cycle", "Error estimate"];
        let rows = crate::branches::rows(&self.mode.points, ROWS).map(|point| {
            vec![
                Cell::text(format::engineering(point.amplitude, "m")),
                Cell::text(format::significant(point.angular_frequency / TAU, 6)),
                Cell::text(format::significant(100.0 * point.damping_ratio, 4)),
                Cell::text(format::engineering(point.dissipated_energy, "J")),
                Cell::Scientific(point.point.error_estimate),
            ]
        });
        Block::Table(Table {
            label: "Vibrations".into(),
            heading: heading.map(str::to_owned).to_vec(),
            rows: rows.collect(),
        })
    }
}

fn hertz(angular_frequency: f64) -> String {
    format!("{}\u{a0}Hz", format::significant(angular_frequency / TAU, 6))
}
