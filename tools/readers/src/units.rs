//! Units as FMI 2.0 and SSP 1.0 define them: exponents of the base units, a factor and an offset.

use std::f64::consts::TAU;

use stickslip::data::unit_size;
use thiserror::Error;

use crate::error::InputError;
use crate::xml::{Element, XmlFile};

/// Names of the base units, in the order of [`Unit::exponents`].
pub const BASE_UNITS: [&str; 8] = ["kg", "m", "s", "A", "K", "mol", "cd", "rad"];

/// A unit. A value in it is `factor · value + offset` in base units.
#[derive(Debug, Clone, PartialEq)]
pub struct Unit {
    /// Its name.
    pub name: String,
    /// Exponents of [`BASE_UNITS`]; absent where only the name is known.
    pub exponents: Option<[i32; 8]>,
    /// Base units in one of it.
    pub factor: f64,
    /// Its zero in base units.
    pub offset: f64,
}

/// Values of one unit turned into values of another: `factor · value + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Linear {
    /// Factor.
    pub factor: f64,
    /// Offset, in the unit of the result.
    pub offset: f64,
}

impl Linear {
    /// What changes nothing.
    pub const IDENTITY: Self = Self { factor: 1.0, offset: 0.0 };

    /// `self`, then `next`.
    pub fn then(self, next: Self) -> Self {
        Self { factor: next.factor * self.factor, offset: next.factor * self.offset + next.offset }
    }

    /// Of a value.
    pub fn apply(self, value: f64) -> f64 {
        self.factor * value + self.offset
    }
}

/// Two units between which nothing converts.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum UnitMismatch {
    /// One is a length and the other a time, so to speak.
    #[error("`{from}` cannot be converted to `{to}`: they measure different things")]
    Dimension {
        /// The unit there is.
        from: String,
        /// The unit there should be.
        to: String,
    },
    /// Different names, of which at least one is not defined by base units.
    #[error(
        "`{from}` cannot be converted to `{to}`: `{unknown}` is no unit that is known here or defined in the files"
    )]
    Undefined {
        /// The one that is not defined.
        unknown: String,
        /// The unit there is.
        from: String,
        /// The unit there should be.
        to: String,
    },
}

impl Unit {
    /// A unit of which only the name is known.
    pub fn named(name: &str) -> Self {
        Self { name: name.to_owned(), exponents: None, factor: 1.0, offset: 0.0 }
    }

    /// The unit that engineers call so (`mm`, `kN`, `N/mm`, `Hz`), if there is one.
    ///
    /// ```
    /// use stickslip_readers::units::Unit;
    /// let (stiffness, si) = (Unit::common("N/mm").unwrap(), Unit::common("N/m").unwrap());
    /// assert_eq!(stiffness.conversion(&si)?.apply(2.0), 2000.0);
    /// assert!(Unit::common("furlong").is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn common(name: &str) -> Option<Self> {
        let ([length, mass, time, mut angle], mut factor) = unit_size(name)?;
        // FMI counts a frequency in hertz as 1/s, without the angle.
        if name.ends_with("Hz") && angle == 1 {
            (angle, factor) = (0, factor / TAU);
        }
        let exponents = Some([mass, length, time, 0, 0, 0, 0, angle]);
        Some(Self { name: name.to_owned(), exponents, factor, offset: 0.0 })
    }

    /// The same, as commonly defined where only the name is known.
    fn defined(&self) -> Self {
        if self.exponents.is_some() { self.clone() } else { Self::common(&self.name).unwrap_or(self.clone()) }
    }

    /// How values of this unit become values of `to`.
    ///
    /// # Errors
    /// Units of different dimensions, or of different names without definitions.
    pub fn conversion(&self, to: &Unit) -> Result<Linear, UnitMismatch> {
        // One name is one unit, whatever it is.
        if self.name == to.name && (self.exponents.is_none() || to.exponents.is_none()) {
            return Ok(Linear::IDENTITY);
        }
        let (own, to) = (self.defined(), to.defined());
        let (from, target) = (own.name, to.name);
        match (own.exponents, to.exponents) {
            // Two files may define one name with factors that differ in the last digit.
            (Some(dimension), Some(other))
                if dimension == other && own.factor == to.factor && own.offset == to.offset =>
            {
                Ok(Linear::IDENTITY)
            }
            (Some(dimension), Some(other)) if dimension == other => {
                Ok(Linear { factor: own.factor / to.factor, offset: (own.offset - to.offset) / to.factor })
            }
            (Some(_), Some(_)) => Err(UnitMismatch::Dimension { from, to: target }),
            (None, _) => Err(UnitMismatch::Undefined { unknown: from.clone(), from, to: target }),
            (_, None) => Err(UnitMismatch::Undefined { unknown: target.clone(), from, to: target }),
        }
    }
}

/// The units that the elements `Unit` of `list` define.
///
/// # Errors
/// A unit without a name, or with something else than numbers; a factor of zero.
pub fn read_units<'e>(
    file: &XmlFile,
    list: impl IntoIterator<Item = &'e Element>,
) -> Result<Vec<Unit>, InputError> {
    list.into_iter()
        .map(|element| {
            let name = file.required(element, "name")?.to_owned();
            let Some(base) = element.child("BaseUnit") else { return Ok(Unit::named(&name)) };
            let mut exponents = [0; 8];
            for (exponent, unit) in exponents.iter_mut().zip(BASE_UNITS) {
                *exponent = file.number(base, unit)?.unwrap_or(0);
            }
            let factor = file.number(base, "factor")?.unwrap_or(1.0);
            if factor == 0.0 {
                return Err(file.value_error(base, "factor", "a number other than zero"));
            }
            let offset = file.number(base, "offset")?.unwrap_or(0.0);
            Ok(Unit { name, exponents: Some(exponents), factor, offset })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn unit(name: &str, exponents: [i32; 8], factor: f64, offset: f64) -> Unit {
        Unit { name: name.to_owned(), exponents: Some(exponents), factor, offset }
    }

    #[test]
    fn values_keep_their_meaning_and_there_and_back_is_the_identity() {
        let kelvin = [0, 0, 0, 0, 1, 0, 0, 0];
        let celsius = unit("degC", kelvin, 1.0, 273.15);
        let fahrenheit = unit("degF", kelvin, 5.0 / 9.0, 459.67 * 5.0 / 9.0);
        let there = celsius.conversion(&fahrenheit).unwrap();
        assert!((there.apply(100.0) - 212.0).abs() < 1e-10);
        assert!((there.apply(-40.0) + 40.0).abs() < 1e-10);
        let back = there.then(fahrenheit.conversion(&celsius).unwrap());
        assert!((back.factor - 1.0).abs() < 1e-15 && back.offset.abs() < 1e-12);
    }

    #[test]
    fn names_that_engineers_use_need_no_definition() {
        let factor = |from: &str, to: &Unit| Unit::named(from).conversion(to).unwrap().factor;
        let metre = unit("m", [0, 1, 0, 0, 0, 0, 0, 0], 1.0, 0.0);
        assert_eq!(factor("mm", &metre), 1e-3);
        assert!((factor("um", &Unit::named("mm")) - 1e-3).abs() < 1e-18);
        assert_eq!(factor("N/mm", &unit("N/m", [1, 0, -2, 0, 0, 0, 0, 0], 1.0, 0.0)), 1e3);
        assert!((factor("kHz", &unit("Hz", [0, 0, -1, 0, 0, 0, 0, 0], 1.0, 0.0)) - 1e3).abs() < 1e-9);
        assert!(
            (factor("deg", &unit("rad", [0, 0, 0, 0, 0, 0, 0, 1], 1.0, 0.0)) - TAU / 360.0).abs() < 1e-15
        );
    }

    #[test]
    fn different_dimensions_do_not_convert() {
        let metre = unit("m", [0, 1, 0, 0, 0, 0, 0, 0], 1.0, 0.0);
        let second = unit("s", [0, 0, 1, 0, 0, 0, 0, 0], 1.0, 0.0);
        assert!(matches!(metre.conversion(&second), Err(UnitMismatch::Dimension { .. })));
        let unknown = metre.conversion(&Unit::named("inch"));
        assert!(matches!(unknown, Err(UnitMismatch::Undefined { unknown, .. }) if unknown == "inch"));
        assert_eq!(Unit::named("inch").conversion(&Unit::named("inch")), Ok(Linear::IDENTITY));
    }
}
