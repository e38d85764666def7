//! The page of responses at one frequency, or of a resonance, over a parameter of the model or the force.

use stickslip::harmonic::{Curve, Ending, Point};

use crate::branches::{most_moving, rows, stable_and_unstable};
use crate::document::{
    Axis, Block, Cell, Document, Line, Panel, Plot, Scaling, Section, Table, document_html, palette,
};
use crate::responses::FrequencyUnit;
use crate::{Settings, format};

/// Rows of the table at most; the files have all points.
const ROWS: usize = 15;
/// Error estimates below this are rounding.
const ROUNDING: f64 = 1e-15;

/// Responses over a parameter, and what was asked for.
#[derive(Debug, Clone)]
pub struct ParameterReport<'a> {
    /// What responds.
    pub title: String,
    /// The parameter's path.
    pub path: &'a str,
    /// Its SI unit.
    pub parameter_unit: &'static str,
    /// Its first and last value.
    pub range: [f64; 2],
    /// The unit that people read frequencies in.
    pub unit: FrequencyUnit,
    /// Frequency of the excitation (rad/s); of a resonance where its search began.
    pub angular_frequency: f64,
    /// Amplitude of the excitation (N), unless it is what varies.
    pub force: Option<f64>,
    /// The resonance that is followed, as `peak:m1`; else the frequency stays.
    pub tracked: Option<&'a str>,
    /// What was found.
    pub curve: &'a Curve,
}

/// One self-contained HTML page of the curve.
pub fn parameter_html(report: &ParameterReport, settings: &Settings) -> String {
    document_html(&report.document(), settings)
}

impl ParameterReport<'_> {
    fn document(&self) -> Document {
        let points = &self.curve.points;
        let mut sections = Vec::new();
        let mut section = |id: &str, title: &str, blocks: Vec<Block>| {
            sections.push(Section { id: id.into(), title: title.into(), blocks });
        };
        if !points.is_empty() {
            section("response", "Response", vec![Block::Plots(vec![self.amplitudes()])]);
            section("contact", "Loss and error", vec![Block::Plots(vec![self.dissipation(), self.errors()])]);
            section("points", "Responses", vec![self.table()]);
        }
        Document {
            title: self.title.clone(),
            lead: self.lead(),
            warnings: self.warnings(),
            scope: format!(
                "{} from {} to {}, {}{}: {}.",
                self.path,
                self.value(self.range[0]),
                self.value(self.range[1]),
                self.where_followed(),
                self.force
                    .map_or(String::new(), |force| format!(" under {}", format::engineering(force, "N"))),
                format::count(points.len(), "response"),
            ),
            sections,
        }
    }

    fn where_followed(&self) -> String {
        match self.tracked.and_then(|tracked| tracked.split_once(':')) {
            Some(("phase", node)) => format!("at the phase resonance of {node}"),
            Some((_, node)) => format!("at the peak of {node}"),
            None => format!("at {}", self.unit.shown(self.angular_frequency)),
        }
    }

    fn value(&self, value: f64) -> String {
        format::engineering(value, self.parameter_unit)
    }

    /// The result in a sentence.
    fn lead(&self) -> String {
        let largest = self.curve.points.iter().flat_map(|point| {
            point.amplitude.iter().enumerate().map(move |(node, amplitude)| (point, node, *amplitude))
        });
        let Some((point, node, amplitude)) = largest.max_by(|a, b| a.2.total_cmp(&b.2)) else {
            return "No response was found.".to_owned();
        };
        format!(
            "The largest displacement is that of {}: {} at {} = {}.",
            self.curve.nodes.get(node).map_or("", String::as_str),
            format::engineering(amplitude, "m"),
            self.path,
            self.value(point.parameter)
        )
    }

    fn warnings(&self) -> Vec<String> {
        let last = self.curve.points.last().map_or(f64::NAN, |point| point.parameter);
        let reached = format!("at {} = {}", self.path, self.value(last));
        match self.curve.ending {
            Ending::Complete => Vec::new(),
            Ending::Interrupted => vec![format!("Interrupted {reached}.")],
            Ending::Returned => vec![format!("The curve turned back and left the range {reached}.")],
            Ending::Stuck => {
                vec![format!("The curve ends {reached}: its steps became too small or too many.")]
            }
        }
    }

    fn amplitudes(&self) -> Plot {
        let nodes = most_moving(self.curve.nodes.len(), self.curve.points.iter());
        let lines = nodes.iter().enumerate().flat_map(|(index, node)| {
            let amplitude = |point: &Point| point.amplitude.get(*node).copied().unwrap_or(f64::NAN);
            self.lines(&self.curve.nodes[*node], &palette(index, nodes.len()), amplitude)
        });
        let y = Axis::new("displacement", "m").scaled(Scaling::Either);
        let unstable = self.curve.points.iter().any(|point| point.stable == Some(false));
        let note = if unstable { " Dashed: unstable." } else { "" };
        let mut caption = format!("Largest displacement of each node over a period.{note}");
        let mut panels = vec![Panel { y, lines: lines.collect() }];
        if self.tracked.is_some() {
            caption.push_str(" Below, the frequency of the resonance.");
            let y = Axis::new("frequency", self.unit.name());
            let frequency = |point: &Point| self.unit.of(point.angular_frequency);
            panels.push(Panel { y, lines: self.lines("resonance", &palette(0, 1), frequency) });
        }
        self.plot(caption, false, panels)
    }

    fn dissipation(&self) -> Plot {
        let y = Axis::new("loss per cycle", "J").scaled(Scaling::Either);
        let lines = self.lines("contacts", &palette(0, 1), Point::dissipated_energy);
        self.plot("Energy that the contacts take per cycle.".to_owned(), true, vec![Panel { y, lines }])
    }

    fn errors(&self) -> Plot {
        let y = Axis::new("error estimate", "1").scaled(Scaling::Logarithmic);
        // What is rounding has no place on a logarithmic axis.
        let estimate =
            |point: &Point| Some(point.error_estimate).filter(|e| *e > ROUNDING).unwrap_or(f64::NAN);
        let lines = self.lines("estimate", &palette(0, 1), estimate);
        let caption = "Estimated truncation error of the displacements, as fraction of the amplitude.";
        self.plot(caption.to_owned(), true, vec![Panel { y, lines }])
    }

    fn lines(&self, name: &str, colour: &str, value: impl Fn(&Point) -> f64) -> Vec<Line> {
        let point = |point: &Point| (point.parameter, value(point), point.stable == Some(false));
        stable_and_unstable(name, colour, &self.curve.points.iter().map(point).collect::<Vec<_>>())
    }

    fn plot(&self, caption: String, half: bool, panels: Vec<Panel>) -> Plot {
        Plot { caption, half, x: Axis::new(self.path, self.parameter_unit), panels }
    }

    fn table(&self) -> Block {
        let mut heading = vec![self.path.to_owned()];
        heading.extend(self.tracked.map(|_| format!("Frequency ({})", self.unit.name())));
        heading.extend(self.curve.nodes.iter().map(|node| format!("Amplitude of {node}")));
        heading.extend(["Stable".to_owned(), "Error estimate".to_owned()]);
        let rows = rows(&self.curve.points, ROWS).map(|point| {
            let mut row = vec![Cell::text(self.value(point.parameter))];
            let frequency = self.unit.of(point.angular_frequency);
            row.extend(self.tracked.map(|_| Cell::text(format::significant(frequency, 6))));
            row.extend(point.amplitude.iter().map(|a| Cell::text(format::engineering(*a, "m"))));
            row.push(match point.stable {
                Some(true) => Cell::text("yes"),
                Some(false) => Cell::Marked("no".to_owned()),
                None => Cell::text(format::ABSENT),
            });
            row.push(Cell::Scientific(point.error_estimate));
            row
        });
        Block::Table(Table { label: "Responses".into(), rows: rows.collect(), heading })
    }
}
