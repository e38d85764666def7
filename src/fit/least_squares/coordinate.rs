//! Parameters as coordinates of size one.

use super::options::Parameter;
use crate::vocabulary::Scale;

/// One parameter's coordinate `y`, zero at the parameter's start and about one across its range.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Coordinate {
    scale: Scale,
    start: f64,
    unit: f64,
    pub lower: f64,
    pub upper: f64,
    value_lower: f64,
    value_upper: f64,
}

impl Coordinate {
    /// The coordinate of `parameter`, or what is wrong with it.
    pub fn new(parameter: &Parameter) -> Result<Self, &'static str> {
        let Parameter { start, lower, upper, scale } = *parameter;
        if !start.is_finite() {
            return Err("the start is not finite");
        }
        if lower.is_nan()
            || upper.is_nan()
            || lower > upper
            || lower == f64::INFINITY
            || upper == -f64::INFINITY
        {
            return Err("the lower bound is not below the upper");
        }
        let start = start.clamp(lower, upper);
        if scale == Scale::Logarithmic && !(lower > 0.0 && start > 0.0) {
            return Err("a logarithmic parameter needs a positive lower bound");
        }
        let unit = match scale {
            Scale::Logarithmic => 1.0,
            Scale::Linear if (upper - lower).is_finite() && upper > lower => upper - lower,
            Scale::Linear if start != 0.0 => start.abs(),
            Scale::Linear => 1.0,
        };
        let mut coordinate =
            Self { scale, start, unit, lower, upper, value_lower: lower, value_upper: upper };
        coordinate.lower = coordinate.coordinate_of(lower);
        coordinate.upper = coordinate.coordinate_of(upper);
        Ok(coordinate)
    }

    /// The parameter's value; never outside the bounds, whatever the rounding.
    pub fn value(self, y: f64) -> f64 {
        let value = match self.scale {
            Scale::Linear => self.start + self.unit * y,
            Scale::Logarithmic => self.start * y.exp(),
        };
        value.clamp(self.value_lower, self.value_upper)
    }

    fn coordinate_of(self, value: f64) -> f64 {
        match self.scale {
            Scale::Linear => (value - self.start) / self.unit,
            Scale::Logarithmic => (value / self.start).ln(),
        }
    }

    /// ∂value/∂y.
    pub fn slope(self, y: f64) -> f64 {
        match self.scale {
            Scale::Linear => self.unit,
            Scale::Logarithmic => self.value(y),
        }
    }

    pub fn held(self) -> bool {
        self.lower >= self.upper
    }

    /// The point a fraction `t` in [0, 1] of the way between the bounds, or within a unit of the start.
    pub fn spread(self, t: f64) -> f64 {
        let (low, high) = (self.lower.max(-1e3), self.upper.min(1e3));
        let low = if self.lower.is_finite() { low } else { (-1.0_f64).min(high - 1.0) };
        let high = if self.upper.is_finite() { high } else { 1.0_f64.max(low + 1.0) };
        low + t * (high - low)
    }
}
