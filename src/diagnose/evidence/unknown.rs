//! What a fit may change, each with what is thought of it before the data are seen.

use crate::diagnose::assumptions::Assumptions;
use crate::diagnose::candidates::Brought;
use crate::model::{Model, ModelParameter};
use crate::vocabulary::Scale;

/// How a coordinate, normal with mean 0 and deviation 1 beforehand, becomes a value.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Measure {
    /// `centre + spread · y`.
    Linear,
    /// `centre · exp(spread · y)`.
    Logarithmic,
    /// `1 / (spread · y)`: neutral at infinity.
    Inverse,
}

/// A number with its prior.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct Coordinate {
    measure: Measure,
    centre: f64,
    spread: f64,
    /// Bounds of the value: what physics allows.
    lower: f64,
    upper: f64,
}

/// Coordinates beyond this many prior deviations are not looked at, logarithms and others.
const FARTHEST: [f64; 2] = [15.0, 100.0];

impl Coordinate {
    /// Evenly between two bounds, about.
    pub fn between(lower: f64, upper: f64) -> Self {
        let half = 0.5 * (upper - lower);
        let spread = if half > 0.0 { half } else { 1.0 };
        Self { measure: Measure::Linear, centre: 0.5 * (lower + upper), spread, lower, upper }
    }

    /// Of a parameter that the model has already, around its value.
    pub fn of_base(parameter: &ModelParameter, assumed: &Assumptions) -> Self {
        let value = parameter.value;
        let path = parameter.path.as_str();
        let structural = path == "beam.youngs_modulus"
            || path.contains("mass")
            || path.contains("stiffness") && !path.starts_with("contact");
        let spread = if structural { assumed.structure_guess } else { assumed.parameter_guess };
        let least = parameter.quantity.min.unwrap_or(parameter.lower.min(0.0));
        let upper = parameter.quantity.max.unwrap_or(f64::INFINITY);
        match parameter.scale {
            Scale::Logarithmic if value > 0.0 => {
                let lower = least.max(1e-3 * value);
                Self { measure: Measure::Logarithmic, centre: value, spread, lower, upper }
            }
            _ => {
                let range = parameter.upper - parameter.lower;
                let size = if value != 0.0 {
                    value.abs()
                } else if range.is_finite() {
                    range
                } else {
                    1.0
                };
                Self { measure: Measure::Linear, centre: value, spread: spread * size, lower: least, upper }
            }
        }
    }

    /// Of the first number that a candidate brings, where `size` from neutral is one prior deviation.
    pub fn of_first(brought: &Brought, size: f64) -> Self {
        let neutral = brought.neutral.unwrap_or(0.0);
        let lower = brought.quantity.min.unwrap_or(f64::NEG_INFINITY);
        let mut upper = brought.quantity.max.unwrap_or(f64::INFINITY);
        if brought.quantity.open && upper == neutral {
            upper = brought.range.upper;
        }
        if neutral.is_infinite() {
            // Beyond, it is as good as rigid.
            let upper = upper.min(1e4 / size);
            Self { measure: Measure::Inverse, centre: 0.0, spread: size, lower, upper }
        } else {
            Self { measure: Measure::Linear, centre: neutral, spread: size, lower, upper }
        }
    }

    /// Of another number that a candidate brings.
    pub fn of_second(brought: &Brought, assumed: &Assumptions) -> Self {
        let Brought { quantity, range, .. } = brought;
        let centre = range.starts[0];
        if centre <= 0.0 {
            return Self::between(range.lower, range.upper);
        }
        let lower = quantity.min.unwrap_or(0.0).max(1e-2 * range.lower);
        let upper = quantity.max.unwrap_or(f64::INFINITY);
        Self { measure: Measure::Logarithmic, centre, spread: assumed.magnitude, lower, upper }
    }

    pub fn value(&self, y: f64) -> f64 {
        let value = match self.measure {
            Measure::Linear => self.centre + self.spread * y,
            Measure::Logarithmic => self.centre * (self.spread * y).exp(),
            Measure::Inverse => 1.0 / (self.spread * y),
        };
        value.clamp(self.lower, self.upper)
    }

    pub fn of(&self, value: f64) -> f64 {
        match self.measure {
            Measure::Linear => (value - self.centre) / self.spread,
            Measure::Logarithmic => (value / self.centre).ln() / self.spread,
            Measure::Inverse => 1.0 / (self.spread * value),
        }
    }

    /// How far the value at `y` would lie from that at 0, whatever the bounds; of an inverse one the value.
    pub fn distance(&self, y: f64) -> f64 {
        match self.measure {
            Measure::Linear => self.spread * y,
            Measure::Logarithmic => self.centre * ((self.spread * y).exp() - 1.0),
            Measure::Inverse => 1.0 / (self.spread * y),
        }
        .abs()
    }

    /// Bounds of the coordinate.
    pub fn bounds(&self) -> (f64, f64) {
        let (a, b) = match self.measure {
            Measure::Inverse => (self.of(self.upper), self.of(self.lower)),
            _ => (self.of(self.lower), self.of(self.upper)),
        };
        let a = if a.is_nan() { f64::NEG_INFINITY } else { a };
        let b = if b.is_nan() { f64::INFINITY } else { b };
        (a.max(-self.farthest()), b.min(self.farthest()))
    }

    /// Whether the value at `y` is one of the bounds.
    pub fn is_at_bound(&self, y: f64) -> bool {
        let value = self.value(y);
        value == self.lower || value == self.upper
    }

    /// How far from 0 a coordinate is looked at.
    pub fn farthest(&self) -> f64 {
        FARTHEST[usize::from(self.measure != Measure::Logarithmic)]
    }
}

/// An unknown shared by all records.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct Unknown {
    pub path: String,
    pub unit: &'static str,
    pub coordinate: Coordinate,
    /// The candidate that brought it.
    pub owner: Option<usize>,
}

impl Unknown {
    /// A parameter that the model has already.
    pub fn of(parameter: &ModelParameter, assumed: &Assumptions) -> Self {
        let coordinate = Coordinate::of_base(parameter, assumed);
        Self { coordinate, path: parameter.path.clone(), unit: parameter.quantity.unit, owner: None }
    }
}

/// What a refit of `model` may change of what it has.
pub(super) fn of_model(model: &Model, assumed: &Assumptions) -> Vec<Unknown> {
    let parameters = model.parameters();
    parameters.iter().filter(|parameter| parameter.free).map(|one| Unknown::of(one, assumed)).collect()
}
