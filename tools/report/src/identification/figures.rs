//! The figures of an identification.

use stickslip::identify::{ContactPeriod, ContactRecord, FrequencyResponse, Level, LinearRecord};

use super::{IdentificationReport, name_of, samples, under, words};
use crate::document::{Axis, Line, Panel, Plot, Scaling, Stroke, palette};

/// Points of an identified loop, and steps of a line.
const POINTS: usize = 72;
const STEPS: usize = 360;
/// Ranges of force in the map.
const RANGES: usize = 9;

/// What is drawn of a moment: displacement, velocity and force.
type Moment = [f64; 3];

impl IdentificationReport<'_> {
    /// Force over displacement, identified and by the best law.
    pub(super) fn loops(&self) -> Plot {
        self.over(0, Axis::new("displacement", "m"), "displacement")
    }

    /// Force over velocity.
    pub(super) fn over_velocity(&self) -> Plot {
        self.over(1, Axis::new("velocity", "m/s"), "velocity")
    }

    fn over(&self, place: usize, x: Axis, name: &str) -> Plot {
        let law = self.best().map_or(String::new(), |law| {
            format!(" Lines: {}, fitted to {}.", words::prose(name_of(law)), self.fitted_names())
        });
        Plot {
            caption: format!(
                "Force of the contact over its {name} at every level, as identified (points).{law}"
            ),
            half: true,
            x,
            panels: vec![Panel { y: Axis::new("force", "N"), lines: self.lines(|moment| moment[place]) }],
        }
    }

    fn fitted_names(&self) -> String {
        let names: Vec<&str> =
            self.found.fitted.iter().map(|k| self.found.records[*k].name.as_str()).collect();
        names.join(", ")
    }

    /// Identified points and the best law's line of every record.
    fn lines(&self, x: impl Fn(&Moment) -> f64) -> Vec<Line> {
        let count = self.found.records.len();
        let drawn =
            |k: usize, record: &ContactRecord, period: &ContactPeriod, steps: usize, stroke: Stroke| {
                let moments = samples(period, steps);
                Line {
                    name: self.level_name(k, record),
                    x: moments.iter().map(&x).collect(),
                    y: moments.iter().map(|moment| moment[2]).collect(),
                    stroke,
                }
            };
        let mut lines = Vec::new();
        for (k, (record, period)) in self.periods().enumerate() {
            let points = Stroke::points(palette(k, count), "circle-open");
            lines.push(drawn(k, record, period, POINTS, points));
        }
        for (k, (record, period)) in self.periods().enumerate() {
            if let Some(law) = self.best().and_then(|law| under(law, period)) {
                lines.push(drawn(k, record, &law, STEPS, Stroke::solid(palette(k, count))));
            }
        }
        lines
    }

    fn level_name(&self, k: usize, record: &ContactRecord) -> String {
        let fitted = if self.is_fitted(k) { ", fitted" } else { "" };
        format!("{} m/s²{fitted}", crate::format::significant(record.amplitude, 3))
    }

    /// The force-state map: force as colour over displacement and velocity.
    pub(super) fn map(&self) -> Plot {
        let moments: Vec<Moment> =
            self.periods().flat_map(|(_, period)| samples(period, STEPS / 2)).collect();
        let largest = moments.iter().map(|moment| moment[2].abs()).fold(f64::MIN_POSITIVE, f64::max);
        let width = 2.0 * largest / RANGES as f64;
        let range = |force: f64| (((force + largest) / width) as usize).min(RANGES - 1);
        let lines = (0..RANGES).map(|k| {
            let inside: Vec<&Moment> = moments.iter().filter(|moment| range(moment[2]) == k).collect();
            let low = -largest + k as f64 * width;
            let number = |force: f64| crate::format::significant(force, 3);
            Line {
                name: format!("{} … {} N", number(low), number(low + width)),
                x: inside.iter().map(|moment| moment[0]).collect(),
                y: inside.iter().map(|moment| moment[1]).collect(),
                stroke: Stroke::points(palette(k, RANGES), "circle"),
            }
        });
        Plot {
            caption: "Force-state map: the identified force (colour) over displacement and velocity of the contact.".into(),
            half: true,
            x: Axis::new("displacement", "m"),
            panels: vec![Panel { y: Axis::new("velocity", "m/s"), lines: lines.collect() }],
        }
    }

    /// Force over the phase, with its interval.
    pub(super) fn histories(&self) -> Plot {
        let count = self.found.records.len();
        let lines = self.periods().enumerate().map(|(k, (record, period))| {
            let largest = period.displacement[2].atan2(period.displacement[1]);
            let phase = |step: usize| std::f64::consts::TAU * step as f64 / STEPS as f64;
            let force = |step: usize| period.at((largest + phase(step)) / period.angular_frequency)[2];
            Line {
                name: self.level_name(k, record),
                x: (0..=STEPS).map(|step| step as f64 / STEPS as f64).collect(),
                y: (0..=STEPS).map(force).collect(),
                stroke: Stroke::solid(palette(k, count)),
            }
        });
        Plot {
            caption: "Identified force over a period from the largest displacement on; the table of the records has its intervals.".into(),
            half: true,
            x: Axis::new("time over period", "1"),
            panels: vec![Panel { y: Axis::new("force", "N"), lines: lines.collect() }],
        }
    }

    /// Errors of every law over the level.
    pub(super) fn errors(&self) -> Option<Plot> {
        let mut order: Vec<usize> = (0..self.found.records.len()).collect();
        order.sort_by(|a, b| self.found.records[*a].amplitude.total_cmp(&self.found.records[*b].amplitude));
        let count = self.found.laws.len();
        let lines = self.found.laws.iter().enumerate().map(|(k, law)| Line {
            name: words::prose(name_of(law)),
            x: order.iter().map(|record| self.found.records[*record].amplitude).collect(),
            y: order.iter().map(|record| law.errors[*record].unwrap_or(f64::NAN)).collect(),
            stroke: Stroke { symbol: "circle", ..Stroke::solid(palette(k, count)) },
        });
        (self.found.records.len() > 1).then(|| Plot {
            caption: format!(
                "Error of every law, fitted to {} and predicted elsewhere.",
                self.fitted_names()
            ),
            half: false,
            x: Axis::new("amplitude", "m/s^2"),
            panels: vec![Panel {
                y: Axis::new("error", "1").scaled(Scaling::Either),
                lines: lines.collect(),
            }],
        })
    }

    /// Frequency and stiffness over the amplitude, and the peak of the response.
    pub(super) fn backbones(&self) -> Vec<Plot> {
        let line = |value: &dyn Fn(&Level) -> Option<f64>| {
            let known = self.found.levels.iter().filter_map(|level| Some((level.amplitude, value(level)?)));
            let (x, y): (Vec<f64>, Vec<f64>) = known.unzip();
            let stroke = Stroke { symbol: "circle", ..Stroke::default() };
            Line { name: "measured".into(), x, y, stroke }
        };
        let plot = |caption: &str, panels: Vec<(Axis, Line)>| Plot {
            caption: caption.into(),
            half: true,
            x: Axis::new("amplitude", "m/s^2"),
            panels: panels.into_iter().map(|(y, line)| Panel { y, lines: vec![line] }).collect(),
        };
        let peaks = line(&|level| level.peak);
        let mut plots = vec![plot(
            "First natural frequency over the amplitude; below, the rotational stiffness that gives the beam this frequency.",
            vec![
                (Axis::new("frequency", "Hz"), line(&|level| Some(level.frequency))),
                (Axis::new("stiffness", "N.m/rad"), line(&|level| level.rotational_stiffness.clone().ok())),
            ],
        )];
        if !peaks.x.is_empty() {
            let caption = "Acceleration over force at the resonance.";
            plots.push(plot(caption, vec![(Axis::new("peak", "1/kg"), peaks)]));
        }
        plots
    }

    /// Frequency responses and coherence of a random record.
    pub(super) fn responses(&self, record: &LinearRecord) -> Vec<Plot> {
        let count = record.responses.len();
        let highest = record.poles.last().map_or(f64::INFINITY, |pole| 1.3 * pole.frequency);
        let line = |k: usize, at: f64, response: &FrequencyResponse, value: &dyn Fn(usize) -> f64| {
            let shown = response.frequencies.iter().take_while(|f| **f < highest).count();
            Line {
                name: format!("x={at} m"),
                x: response.frequencies[..shown].to_vec(),
                y: (0..shown).map(value).collect(),
                stroke: Stroke::solid(palette(k, count)),
            }
        };
        let (mut sizes, mut coherences) = (Vec::new(), Vec::new());
        for (k, (at, response)) in record.responses.iter().enumerate() {
            sizes.push(line(k, *at, response, &|i| response.h1[i].norm()));
            let h2 = line(k, *at, response, &|i| response.h2[i].norm());
            sizes.push(Line { stroke: Stroke { note: "H2", ..Stroke::dashed(palette(k, count)) }, ..h2 });
            coherences.push(line(k, *at, response, &|i| response.coherence[i]));
        }
        vec![Plot {
            caption: format!(
                "Accelerance from {}: H1 (full) and H2 (dashed); below, the coherence.",
                record.name
            ),
            half: false,
            x: Axis::new("frequency", "Hz"),
            panels: vec![
                Panel {
                    y: Axis::new("acceleration over force", "1/kg").scaled(Scaling::Logarithmic),
                    lines: sizes,
                },
                Panel { y: Axis::new("coherence", "1"), lines: coherences },
            ],
        }]
    }
}
