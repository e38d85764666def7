//! Errors of a law's parameters.

use std::fmt;
use std::ops::Bound;

use crate::vocabulary::{FRICTION_COEFFICIENT, Quantity, TANGENTIAL_STIFFNESS};

/// The values a parameter may take, an interval with open, closed or absent ends.
///
/// ```
/// use stickslip::contact::Bounds;
/// assert!(Bounds::NOT_NEGATIVE.contain(0.0) && !Bounds::POSITIVE.contain(0.0));
/// assert_eq!(Bounds::from_zero_to_below(1.0).to_string(), "a finite number, at least 0, below 1");
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Lower end.
    pub lower: Bound<f64>,
    /// Upper end.
    pub upper: Bound<f64>,
}

impl Bounds {
    /// Finite and strictly above zero.
    pub const POSITIVE: Self = Self { lower: Bound::Excluded(0.0), upper: Bound::Unbounded };

    /// Finite and at least zero.
    pub const NOT_NEGATIVE: Self = Self { lower: Bound::Included(0.0), upper: Bound::Unbounded };

    /// Finite.
    pub const FINITE: Self = Self { lower: Bound::Unbounded, upper: Bound::Unbounded };

    /// From 0, included, to `upper`, excluded.
    pub fn from_zero_to_below(upper: f64) -> Self {
        Self { lower: Bound::Included(0.0), upper: Bound::Excluded(upper) }
    }

    /// `value` is finite and lies between the ends; NaN never does.
    pub fn contain(&self, value: f64) -> bool {
        let above = match self.lower {
            Bound::Included(lower) => value >= lower,
            Bound::Excluded(lower) => value > lower,
            Bound::Unbounded => true,
        };
        let below = match self.upper {
            Bound::Included(upper) => value <= upper,
            Bound::Excluded(upper) => value < upper,
            Bound::Unbounded => true,
        };
        value.is_finite() && above && below
    }
}

impl fmt::Display for Bounds {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a finite number")?;
        match self.lower {
            Bound::Included(lower) => write!(f, ", at least {lower}")?,
            Bound::Excluded(lower) => write!(f, ", above {lower}")?,
            Bound::Unbounded => {}
        }
        match self.upper {
            Bound::Included(upper) => write!(f, ", at most {upper}"),
            Bound::Excluded(upper) => write!(f, ", below {upper}"),
            Bound::Unbounded => Ok(()),
        }
    }
}

/// A contact law cannot be made from these parameters.
///
/// ```
/// use stickslip::contact::Jenkins;
/// let refused = Jenkins::new(-1.0, 0.5).unwrap_err().to_string();
/// assert_eq!(refused, "tangential_stiffness is -1 N/m; it must be a finite number, above 0");
/// ```
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LawError {
    /// One parameter is outside its bounds, infinite or not a number.
    #[error("{parameter} is {value}{}; it must be {bounds}", spaced(unit))]
    OutOfBounds {
        /// Name of the parameter, as in [`crate::vocabulary`] where it has an entry.
        parameter: &'static str,
        /// The value that was given.
        value: f64,
        /// SI unit of the value and of the bounds.
        unit: &'static str,
        /// What is allowed.
        bounds: Bounds,
    },
    /// The law and the parameter do not go together.
    #[error("the law slips gradually by itself and takes no {parameter}")]
    Combination {
        /// Name of the parameter.
        parameter: &'static str,
    },
    /// Hardening of a normal direction that hardens by its own law.
    #[error("Hertz' law hardens by itself and takes no normal_cubic_stiffness")]
    Hardening,
}

/// The unit as it follows a number; a plain number's `1` is left out.
fn spaced(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" {unit}") }
}

/// `value` if it is within `bounds`.
pub(super) fn checked(
    parameter: &'static str,
    unit: &'static str,
    value: f64,
    bounds: Bounds,
) -> Result<f64, LawError> {
    if bounds.contain(value) {
        Ok(value)
    } else {
        Err(LawError::OutOfBounds { parameter, value, unit, bounds })
    }
}

/// Stiffness and coefficient of friction, both finite and above zero.
pub(super) fn checked_pair(stiffness: f64, friction: f64) -> Result<(f64, f64), LawError> {
    let checked_one =
        |quantity: &Quantity, value| checked(quantity.name, quantity.unit, value, Bounds::POSITIVE);
    Ok((checked_one(&TANGENTIAL_STIFFNESS, stiffness)?, checked_one(&FRICTION_COEFFICIENT, friction)?))
}
