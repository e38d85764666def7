//! The figures of both forces.

use std::f64::consts::TAU;

use stickslip::data::Record;
use stickslip::harmonic::fourier::value;
use stickslip::rig::Slap;

use super::{SlipSlapReport, level};
use crate::document::{Axis, Line, Panel, Plot, Stroke, palette};

/// Steps of a period.
const STEPS: usize = 720;

impl SlipSlapReport<'_> {
    /// S over ξ (figure 6, left).
    pub(super) fn tangential(&self) -> Plot {
        Plot {
            caption: format!(
                "Tangential force over the tangential displacement at every level, as identified{}.",
                self.beside()
            ),
            half: true,
            x: Axis::new("tangential displacement", "m"),
            panels: vec![Panel {
                y: Axis::new("tangential force", "N"),
                lines: self.over_displacement(0, ["displacement", "force"], 1.0),
            }],
        }
    }

    /// N over η (figure 6, right).
    pub(super) fn normal(&self) -> Plot {
        let warning = match self.is_unidentified("normal_displacement") {
            true => " The displacement is not identified; the force is.",
            false => "",
        };
        Plot {
            caption: format!(
                "Normal force, less the preload, over the normal displacement, both positive upwards{}.{warning}",
                self.beside()
            ),
            half: true,
            x: Axis::new("normal displacement", "m"),
            panels: vec![Panel {
                y: Axis::new("normal force", "N"),
                lines: self.over_displacement(1, ["normal_displacement", "normal_load"], -1.0),
            }],
        }
    }

    /// What is drawn beside the identified curves.
    fn beside(&self) -> &'static str {
        if self.truth.is_empty() { "" } else { " (grey: the truth of the simulation)" }
    }

    /// Force over displacement in a direction, means left out; the truth of these channels has this sign.
    fn over_displacement(&self, direction: usize, channels: [&str; 2], sign: f64) -> Vec<Line> {
        let count = self.found.records.len();
        let truth = self.truth.iter().filter_map(|truth| of_channels(truth, channels, sign));
        let stroke = Stroke { width: 3.0, ..Stroke::solid("#c8c8c8") };
        let truth = truth.map(|[x, y]| Line { name: "truth".to_owned(), x, y, stroke: stroke.clone() });
        let mut lines: Vec<Line> = truth.collect();
        for (k, (record, periods)) in self.periods().enumerate() {
            let period = periods[direction];
            let [x, y] = [&period.displacement, &period.force].map(|one| over_period(one));
            lines.push(Line { name: level(record), x, y, stroke: Stroke::solid(palette(k, count)) });
        }
        lines
    }

    /// S over the period.
    pub(super) fn tangential_history(&self) -> Plot {
        self.history(0, "Tangential force over a period.", "tangential force", 0.0)
    }

    /// N_c over the period.
    pub(super) fn normal_history(&self) -> Plot {
        let caption =
            "Force that presses the pin on its support over a period: at zero it would part from it.";
        self.history(1, caption, "normal force", self.found.preload)
    }

    /// A force over the period; one that lacks of `preload` where there is one.
    fn history(&self, direction: usize, caption: &str, name: &str, preload: f64) -> Plot {
        let count = self.found.records.len();
        let sign = if direction == 0 { 1.0 } else { -1.0 };
        let line = |(k, (record, periods)): (usize, (&_, [&stickslip::identify::ContactPeriod; 2]))| Line {
            name: level(record),
            x: (0..=STEPS).map(|step| step as f64 / STEPS as f64).collect(),
            y: over_period(&periods[direction].force).iter().map(|force| preload + sign * force).collect(),
            stroke: Stroke::solid(palette(k, count)),
        };
        Plot {
            caption: caption.to_owned(),
            half: true,
            x: Axis::new("time over period", "1"),
            panels: vec![Panel {
                y: Axis::new(name, "N"),
                lines: self.periods().enumerate().map(line).collect(),
            }],
        }
    }
}

/// Normal force and distance of a pin that slaps.
pub(super) fn slap(slap: &Slap) -> Plot {
    let line = |y: &[f64]| {
        vec![Line {
            name: "model".to_owned(),
            x: slap.time.clone(),
            y: y.to_vec(),
            stroke: Stroke { width: 1.0, ..Stroke::default() },
        }]
    };
    Plot {
        caption:
            "The slap in time, from rest: force that presses the pin on its support; below, its distance from there."
                .to_owned(),
        half: false,
        x: Axis::new("time", "s"),
        panels: vec![
            Panel { y: Axis::new("normal force", "N"), lines: line(&slap.normal_force) },
            Panel { y: Axis::new("distance", "m"), lines: line(&slap.separation) },
        ],
    }
}

/// The signal without its mean over a period, the first value again at the end.
pub(super) fn over_period(coefficients: &[f64]) -> Vec<f64> {
    let mean = coefficients.first().copied().unwrap_or(0.0);
    (0..=STEPS).map(|k| value(coefficients, TAU * k as f64 / STEPS as f64) - mean).collect()
}

/// Two channels of a record without their means.
fn of_channels(record: &Record, names: [&str; 2], sign: f64) -> Option<[Vec<f64>; 2]> {
    let [x, y] = names.map(|name| record.channel(name).map(|channel| channel.values.as_slice()));
    let without_mean = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| sign * (value - mean)).collect()
    };
    Some([without_mean(x?), without_mean(y?)])
}
