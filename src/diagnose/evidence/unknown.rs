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
    /// `centre + spread · sinh y`: what is large is known by its order of magnitude.
    Stretched,
    /// `1 / (spread · sinh y)`: the same, neutral at infinity.
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

/// Coordinates beyond this many prior deviations are not looked at, those that grow like exponentials and others.
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
        // What an effect brought is none of it: an effect that was added before was measured, not drawn.
        let structural = !path.starts_with("contact.")
            && !path.starts_with("effect.")
            && (path == "beam.youngs_modulus" || path.contains("mass") || path.contains("stiffness"));
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

    /// Of the first number that a candidate brings, where `size` from neutral is one prior deviation. How much more there may be
    /// is known by its order of magnitude: `size` comes from a model that lacks it.
    pub fn of_first(brought: &Brought, size: f64) -> Self {
        let size = size / 1.0_f64.sinh();
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
            Self { measure: Measure::Stretched, centre: neutral, spread: size, lower, upper }
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
            Measure::Stretched => self.centre + self.spread * y.sinh(),
            Measure::Inverse => 1.0 / (self.spread * y.sinh()),
        };
        value.clamp(self.lower, self.upper)
    }

    pub fn of(&self, value: f64) -> f64 {
        match self.measure {
            Measure::Linear => (value - self.centre) / self.spread,
            Measure::Logarithmic => (value / self.centre).ln() / self.spread,
            Measure::Stretched => ((value - self.centre) / self.spread).asinh(),
            Measure::Inverse => (1.0 / (self.spread * value)).asinh(),
        }
    }

    /// Where the value is a `multiple` as far from that at 0, or its inverse from none, as it is at `y`.
    pub fn times(&self, y: f64, multiple: f64) -> f64 {
        match self.measure {
            Measure::Stretched | Measure::Inverse => (multiple * y.sinh()).asinh(),
            Measure::Linear | Measure::Logarithmic => multiple * y,
        }
    }

    /// How far the value at `y` would lie from that at 0, whatever the bounds; of an inverse one the value.
    pub fn distance(&self, y: f64) -> f64 {
        match self.measure {
            Measure::Linear => self.spread * y,
            Measure::Logarithmic => self.centre * ((self.spread * y).exp() - 1.0),
            Measure::Stretched => self.spread * y.sinh(),
            Measure::Inverse => 1.0 / (self.spread * y.sinh()),
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
        FARTHEST[usize::from(self.measure == Measure::Linear)]
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

#[cfg(test)]
mod tests {
    use super::*;

    fn stretched(measure: Measure, spread: f64) -> Coordinate {
        Coordinate { measure, centre: 0.0, spread, lower: f64::NEG_INFINITY, upper: f64::INFINITY }
    }

    #[test]
    fn what_an_effect_brought_is_known_no_better_than_a_contact() {
        let model = Model::parse(
            "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n[[mass]]\nname = \"m1\"\nmass = 1.0\n[[spring]]\n\
             between = [\"ground\", \"m1\"]\nstiffness = 4e3\ndamping = 1.0\n[contact]\nat = \"m1\"\nlaw = \"jenkins\"\n\
             tangential_stiffness = 2e3\nfriction_coefficient = 0.3\nnormal_load = 10.0\n[[effect]]\n\
             id = \"residual_stiffness\"\nresidual_stiffness = 200.0\n",
        )
        .unwrap();
        let assumed = Assumptions::default();
        let spread = |path: &str| {
            let parameters = model.parameters();
            Coordinate::of_base(parameters.iter().find(|one| one.path == path).unwrap(), &assumed).spread
        };
        assert_eq!(spread("spring.1.stiffness"), assumed.structure_guess);
        assert_eq!(spread("contact.tangential_stiffness"), assumed.parameter_guess);
        assert_eq!(spread("effect.1.residual_stiffness"), 200.0 * assumed.parameter_guess);
    }

    #[test]
    fn every_value_has_its_coordinate() {
        for measure in [Measure::Linear, Measure::Logarithmic, Measure::Stretched, Measure::Inverse] {
            let centre = if measure == Measure::Logarithmic { 2.0 } else { 0.0 };
            let coordinate = Coordinate { centre, ..stretched(measure, 0.3) };
            for y in [-7.0, -1.0, 0.2, 3.0, 12.0] {
                assert!((coordinate.of(coordinate.value(y)) - y).abs() < 1e-9, "{measure:?} {y}");
            }
        }
    }

    #[test]
    fn a_small_amount_counts_by_its_size_and_a_large_one_by_its_order_of_magnitude() {
        let coordinate = stretched(Measure::Stretched, 2.0);
        assert!((coordinate.value(0.01) / 0.02 - 1.0).abs() < 1e-4);
        let decade = coordinate.of(2e4) - coordinate.of(2e3);
        assert!((decade - 10.0_f64.ln()).abs() < 1e-4, "{decade}");
    }

    #[test]
    fn a_multiple_is_one_of_the_amount() {
        let amount = stretched(Measure::Stretched, 2.0);
        assert!((amount.value(amount.times(-3.0, 0.1)) / amount.value(-3.0) - 0.1).abs() < 1e-12);
        let inverse = stretched(Measure::Inverse, 2.0);
        assert!((inverse.value(inverse.times(3.0, 10.0)) / inverse.value(3.0) - 0.1).abs() < 1e-12);
    }
}
