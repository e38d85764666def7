//! The way of a displacement from turning point to turning point, and what sliders have on it.

use super::integrals::{Piece, Source};
use crate::contact::Slider;
use crate::harmonic::period::CycleSummary;
use crate::harmonic::period::motion::{Motion, Turning};

/// The turning points in the order they are met, from the largest magnitude on; the last is the first, a
/// period (half a period of an odd motion) later.
#[derive(Debug, Default)]
pub(in crate::harmonic::period) struct Path {
    pub points: Vec<Turning>,
    /// The last point's displacement in terms of the first's: −1 over half a period.
    pub sign: f64,
}

/// What is needed to sum up a period.
#[derive(Debug, Default)]
pub(super) struct Record {
    /// Total force at the path's points but the last (N).
    pub force: Vec<f64>,
    /// Energy dissipated on the path (J).
    pub dissipated_energy: f64,
    /// Phases between which a slider slides or is apart.
    pub loose: Vec<(f64, f64)>,
}

/// A slider's limits as distances from its position.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reach {
    pub slider: Slider,
    /// Largest and smallest u − z.
    pub above: f64,
    pub below: f64,
}

/// Where on its polyline a slider is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Region {
    Below,
    Play,
    Above,
}

impl Path {
    /// From the turning points of one period of `motion`; of the full period if the contact is not `odd`.
    pub fn set(&mut self, turnings: &[Turning], motion: &Motion, odd: bool) {
        self.points.clear();
        self.points.extend_from_slice(turnings);
        self.sign = if motion.is_odd() { -1.0 } else { 1.0 };
        let later = |t: &Turning, sign: f64, by: f64| Turning { phase: t.phase + by, value: sign * t.value };
        if motion.is_odd() && !odd {
            self.points.extend(turnings.iter().map(|t| later(t, -1.0, std::f64::consts::PI)));
            self.sign = 1.0;
        }
        let period = if self.sign < 0.0 { std::f64::consts::PI } else { std::f64::consts::TAU };
        let mut first = 0;
        for (i, point) in self.points.iter().enumerate() {
            if point.value.abs() > self.points[first].value.abs() {
                first = i;
            }
        }
        let (sign, count) = (self.sign, self.points.len());
        self.points.iter_mut().take(first).for_each(|point| *point = later(point, sign, period));
        if count > 0 {
            self.points.rotate_left(first);
            self.points.push(later(&self.points[0], sign, period));
        }
    }

    /// Fraction of a period the path runs through.
    pub fn fraction(&self) -> f64 {
        if self.sign < 0.0 { 0.5 } else { 1.0 }
    }

    /// The source that point `index` is.
    pub(super) fn source(&self, index: usize) -> Source {
        if index + 1 == self.points.len() {
            Source { index: 0, sign: self.sign }
        } else {
            Source { index, sign: 1.0 }
        }
    }
}

impl Reach {
    /// The slider behind a spring of its own of `compliance` (m/N).
    pub fn behind(slider: &Slider, compliance: f64) -> Self {
        let slider =
            Slider { stiffness: slider.stiffness / (1.0 + compliance * slider.stiffness), ..*slider };
        Self {
            slider,
            above: slider.play_above + slider.upper_limit / slider.stiffness,
            below: slider.play_below - slider.lower_limit / slider.stiffness,
        }
    }

    /// The slider's position nearest to `position` that holds at `displacement` (m).
    pub fn follow(&self, position: f64, displacement: f64) -> f64 {
        let (low, high) = (displacement - self.above, displacement - self.below);
        if position < low {
            low
        } else if position > high {
            high
        } else {
            position
        }
    }

    /// Region at `displacement` from which the slider moves on, up or down.
    pub fn region(&self, position: f64, displacement: f64, rising: bool) -> Region {
        let stretch = displacement - position;
        let Slider { play_below, play_above, .. } = self.slider;
        if play_below == play_above {
            return Region::Above;
        }
        let (above, below) = if rising {
            (stretch >= play_above, stretch < play_below)
        } else {
            (stretch > play_above, stretch <= play_below)
        };
        if above {
            Region::Above
        } else if below {
            Region::Below
        } else {
            Region::Play
        }
    }

    /// The force in a region.
    pub(super) fn piece(&self, region: Region, position: f64) -> Piece {
        let stiffness = self.slider.stiffness;
        match region {
            Region::Play => Piece::NONE,
            Region::Above => Piece { stiffness, constant: -stiffness * (position + self.slider.play_above) },
            Region::Below => Piece { stiffness, constant: -stiffness * (position + self.slider.play_below) },
        }
    }

    /// The next region on the way, and the end of this one relative to the position.
    pub fn next(&self, region: Region, rising: bool) -> Option<(Region, f64)> {
        match (region, rising) {
            (Region::Below, true) => Some((Region::Play, self.slider.play_below)),
            (Region::Play, true) => Some((Region::Above, self.slider.play_above)),
            (Region::Above, false) if self.slider.play_below < self.slider.play_above => {
                Some((Region::Play, self.slider.play_above))
            }
            (Region::Play, false) => Some((Region::Below, self.slider.play_below)),
            _ => None,
        }
    }
}

impl Record {
    pub fn clear(&mut self, points: usize) {
        self.force.clear();
        self.force.resize(points.saturating_sub(1), 0.0);
        self.dissipated_energy = 0.0;
        self.loose.clear();
    }

    /// Sums up a period behind a spring of `compliance` (m/N); `apart` where there is no contact at all.
    pub fn summary(&mut self, path: &Path, compliance: f64, apart: bool) -> CycleSummary {
        self.loose.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut loose = 0.0;
        let mut covered = f64::NEG_INFINITY;
        for (from, to) in &self.loose {
            loose += (to - from.max(covered)).max(0.0);
            covered = covered.max(*to);
        }
        let period = path.fraction() * std::f64::consts::TAU;
        let stick_fraction = if apart { 0.0 } else { (1.0 - loose / period).clamp(0.0, 1.0) };
        CycleSummary {
            dissipated_energy: self.dissipated_energy / path.fraction(),
            equivalent_stiffness: tip_stiffness(path, &self.force, compliance),
            stick_fraction: Some(stick_fraction),
        }
    }
}

/// Slope between the extreme displacements of the contact, from the forces at the path's points.
pub(in crate::harmonic::period) fn tip_stiffness(path: &Path, force: &[f64], compliance: f64) -> f64 {
    let points = path.points.iter().zip(force).map(|(point, force)| (point.value, *force));
    let by_value = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0);
    let (Some(mut low), Some(mut high)) = (points.clone().min_by(by_value), points.max_by(by_value)) else {
        return f64::NAN;
    };
    if path.sign < 0.0 {
        let tip = if high.0 >= -low.0 { high } else { (-low.0, -low.1) };
        (low, high) = ((-tip.0, -tip.1), tip);
    }
    let force = high.1 - low.1;
    force / (high.0 - low.0 - compliance * force)
}
