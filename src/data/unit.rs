//! Units of CSV columns: from what an engineer writes in brackets to SI.
//!
//! A unit is a product of symbols with exponents: `m/s^2`, `mm/s²`, `N.m/rad`, `kN`, `1/s`, `%`.
//! Division holds for the next symbol only. Angles count as a dimension of their own, so that a
//! frequency may be given in Hz or in rad/s (1 Hz = 2π rad/s) but not in 1/s, which could mean either.

use std::f64::consts::PI;

use thiserror::Error;

use crate::vocabulary::Quantity;

/// Exponents of length, mass, time and angle.
type Dimension = [i32; 4];

const STANDARD_GRAVITY: f64 = 9.80665;

/// Symbols that take the prefixes below: name, dimension, size in m, kg, s and rad. Lengths, times and angles take none
/// above kilo, and `g` as an acceleration none above one: `Grad` is no thousand million radians, it is German for a degree.
const PREFIXED: &[(&str, Dimension, f64)] = &[
    ("m", [1, 0, 0, 0], 1.0),
    ("s", [0, 0, 1, 0], 1.0),
    ("N", [1, 1, -2, 0], 1.0),
    ("Hz", [0, 0, -1, 1], 2.0 * PI),
    ("Pa", [-1, 1, -2, 0], 1.0),
    ("J", [2, 1, -2, 0], 1.0),
    ("rad", [0, 0, 0, 1], 1.0),
];

/// Symbols that take none.
const PLAIN: &[(&str, Dimension, f64)] = &[
    ("1", [0; 4], 1.0),
    ("-", [0; 4], 1.0),
    ("%", [0; 4], 0.01),
    ("°", [0, 0, 0, 1], PI / 180.0),
    ("deg", [0, 0, 0, 1], PI / 180.0),
    ("rpm", [0, 0, -1, 1], 2.0 * PI / 60.0),
    ("min", [0, 0, 1, 0], 60.0),
    ("in", [1, 0, 0, 0], 0.0254),
    ("lbf", [1, 1, -2, 0], 4.4482216152605),
    ("kip", [1, 1, -2, 0], 4448.2216152605),
];

/// Both code points in use for micro, and the letter that stands in for them.
const PREFIXES: &[(&str, f64)] = &[
    ("n", 1e-9),
    ("u", 1e-6),
    ("\u{b5}", 1e-6),
    ("\u{3bc}", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
];

/// Why a unit was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum UnitError {
    /// A symbol that is no unit.
    #[error("`{symbol}` is not a unit; {quantity} is given in {expected}")]
    Unknown {
        /// The symbol as written.
        symbol: String,
        /// Name of the quantity.
        quantity: &'static str,
        /// Units that would do.
        expected: String,
    },
    /// A unit of something else.
    #[error("`{unit}` does not measure {quantity}, which is given in {expected}")]
    Dimension {
        /// The unit as written.
        unit: String,
        /// Name of the quantity.
        quantity: &'static str,
        /// Units that would do.
        expected: String,
    },
}

/// The factor that turns a number in `unit` into the SI unit of `quantity`.
///
/// `g` is the standard acceleration of free fall where an acceleration is wanted and the gram elsewhere.
///
/// # Errors
/// A symbol that is no unit, or a unit of another dimension; both name the units that would do.
///
/// ```
/// use stickslip::data::unit_factor;
/// use stickslip::vocabulary::{ACCELERATION, DISPLACEMENT};
///
/// assert_eq!(unit_factor("mm", &DISPLACEMENT), Ok(1e-3));
/// assert_eq!(unit_factor("g", &ACCELERATION), Ok(9.80665));
/// assert!(unit_factor("N", &DISPLACEMENT).is_err());
/// ```
pub fn unit_factor(unit: &str, quantity: &Quantity) -> Result<f64, UnitError> {
    let unknown = |symbol: &str| UnitError::Unknown {
        symbol: symbol.to_owned(),
        quantity: quantity.name,
        expected: expected(quantity),
    };
    let (wanted, wanted_size) = parse(quantity.unit, Gram::Mass).map_err(unknown)?;
    // What is a unit in neither reading is none.
    let by_mass = parse(unit, Gram::Mass).map_err(unknown)?;
    for (dimension, size) in parse(unit, Gram::Acceleration).into_iter().chain([by_mass]) {
        let factor = size / wanted_size;
        if dimension == wanted && factor.is_normal() {
            return Ok(factor);
        }
    }
    Err(UnitError::Dimension { unit: unit.to_owned(), quantity: quantity.name, expected: expected(quantity) })
}

/// Exponents of length, mass, time and angle of `unit`, and its size in m, kg, s and rad; `g` is the gram. `None` for what
/// is no unit.
///
/// ```
/// use stickslip::data::unit_size;
///
/// assert_eq!(unit_size("kN/mm"), Some(([0, 1, -2, 0], 1e6)));
/// assert_eq!(unit_size("furlong"), None);
/// ```
pub fn unit_size(unit: &str) -> Option<([i32; 4], f64)> {
    parse(unit, Gram::Mass).ok()
}

fn expected(quantity: &Quantity) -> String {
    match quantity.unit {
        "m" => "m, mm, µm",
        "s" => "s, ms, µs",
        "N" => "N, mN, kN",
        "m/s" => "m/s, mm/s",
        "m/s^2" => "m/s^2, mm/s^2, g",
        "Hz" => "Hz, kHz, rad/s",
        "1" => "1, %",
        other => other,
    }
    .to_owned()
}

/// What `g` stands for.
#[derive(Clone, Copy, PartialEq)]
enum Gram {
    Mass,
    Acceleration,
}

/// Dimension and size of `unit`, or the symbol that is no unit.
fn parse(unit: &str, gram: Gram) -> Result<(Dimension, f64), &str> {
    let mut dimension = [0; 4];
    let mut size = 1.0;
    for (index, quotient) in unit.trim().split('/').enumerate() {
        let product = |letter: char| letter.is_whitespace() || "*.·⋅".contains(letter);
        for (place, factor) in quotient.trim().split(product).enumerate() {
            let (symbol, exponent) = split_exponent(factor).ok_or(factor)?;
            let (base, base_size) = symbol_size(symbol, gram).ok_or(symbol)?;
            let sign = if index > 0 && place == 0 { -1 } else { 1 };
            for (total, part) in dimension.iter_mut().zip(base) {
                *total += sign * exponent * part;
            }
            size *= base_size.powi(sign * exponent);
        }
    }
    Ok((dimension, size))
}

/// `s^2`, `s2`, `s²` and `s^-2` are a symbol and an exponent of one digit; `None` is malformed.
fn split_exponent(factor: &str) -> Option<(&str, i32)> {
    if factor == "1" || factor == "-" {
        return Some((factor, 1));
    }
    let end = factor.find(|letter: char| letter.is_ascii_digit() || "^-²³".contains(letter));
    let (symbol, exponent) = factor.split_at(end.unwrap_or(factor.len()));
    let exponent = match exponent {
        "" => 1,
        "²" => 2,
        "³" => 3,
        digits => {
            let digits = digits.strip_prefix('^').unwrap_or(digits);
            let number: i32 = digits.parse().ok()?;
            (1..=9).contains(&number.unsigned_abs()).then_some(number)?
        }
    };
    Some((symbol, exponent))
}

fn symbol_size(symbol: &str, gram: Gram) -> Option<(Dimension, f64)> {
    let gram = match gram {
        Gram::Mass => ("g", [0, 1, 0, 0], 1e-3),
        Gram::Acceleration => ("g", [1, 0, -2, 0], STANDARD_GRAVITY),
    };
    let prefixed = || PREFIXED.iter().copied().chain([gram]);
    let whole = PLAIN.iter().copied().chain(prefixed()).find(|(name, ..)| *name == symbol);
    if let Some((_, dimension, size)) = whole {
        return Some((dimension, size));
    }
    let largest = |dimension: Dimension| match dimension {
        [1, 0, 0, 0] | [0, 0, 1, 0] | [0, 0, 0, 1] => 1e3,
        [1, 0, -2, 0] => 1.0,
        _ => f64::INFINITY,
    };
    PREFIXES.iter().find_map(|(prefix, factor)| {
        let rest = symbol.strip_prefix(prefix)?;
        let (_, dimension, size) = prefixed().find(|(name, ..)| *name == rest)?;
        (*factor <= largest(dimension)).then_some((dimension, factor * size))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vocabulary as v;

    fn factor(unit: &str, quantity: &Quantity) -> f64 {
        unit_factor(unit, quantity).unwrap_or_else(|error| panic!("{error}"))
    }

    fn close(left: f64, right: f64) -> bool {
        (left / right - 1.0).abs() < 4.0 * f64::EPSILON
    }

    #[test]
    fn si_units_of_the_vocabulary_convert_to_themselves_exactly() {
        for quantity in v::ALL {
            assert_eq!(unit_factor(quantity.unit, quantity), Ok(1.0), "{}", quantity.name);
        }
    }

    #[test]
    fn common_units_have_their_sizes() {
        for (unit, quantity, size) in [
            ("mm", &v::DISPLACEMENT, 1e-3),
            ("um", &v::DISPLACEMENT, 1e-6),
            ("nm", &v::DISPLACEMENT, 1e-9),
            ("in", &v::DISPLACEMENT, 0.0254),
            ("kN", &v::FORCE, 1e3),
            ("mN", &v::FORCE, 1e-3),
            ("MN", &v::FORCE, 1e6),
            ("kip", &v::FORCE, 4448.2216152605),
            ("kg m/s^2", &v::FORCE, 1.0),
            ("ms", &v::TIME, 1e-3),
            ("min", &v::TIME, 60.0),
            ("mm/s", &v::VELOCITY, 1e-3),
            ("m/s²", &v::ACCELERATION, 1.0),
            ("m/s2", &v::ACCELERATION, 1.0),
            ("m s^-2", &v::ACCELERATION, 1.0),
            ("mm/s/s", &v::ACCELERATION, 1e-3),
            ("g", &v::ACCELERATION, 9.80665),
            ("mg", &v::ACCELERATION, 9.80665e-3),
            ("g", &v::MASS, 1e-3),
            ("kHz", &v::FREQUENCY, 1e3),
            ("rpm", &v::FREQUENCY, 1.0 / 60.0),
            ("rad/s", &v::FREQUENCY, 0.5 / PI),
            ("%", &v::DAMPING_RATIO, 0.01),
            ("-", &v::DAMPING_RATIO, 1.0),
            ("GPa", &v::YOUNGS_MODULUS, 1e9),
            ("N/mm", &v::TANGENTIAL_STIFFNESS, 1e3),
            ("N·m/rad", &v::ROTATIONAL_STIFFNESS, 1.0),
        ] {
            assert!(close(factor(unit, quantity), size), "{unit}: {}", factor(unit, quantity));
        }
    }

    #[test]
    fn both_micro_signs_and_the_letter_u_are_the_same_prefix() {
        for base in ["m", "s", "N"] {
            let quantity = match base {
                "m" => &v::DISPLACEMENT,
                "s" => &v::TIME,
                _ => &v::FORCE,
            };
            for micro in ["u", "\u{b5}", "\u{3bc}"] {
                assert_eq!(factor(&format!("{micro}{base}"), quantity), 1e-6);
            }
        }
    }

    #[test]
    fn the_size_of_a_quotient_is_the_quotient_of_the_sizes() {
        for length in ["m", "mm", "km", "in"] {
            for time in ["s", "ms", "min"] {
                let quotient = factor(length, &v::DISPLACEMENT) / factor(time, &v::TIME);
                assert!(close(factor(&format!("{length}/{time}"), &v::VELOCITY), quotient));
                let twice = quotient / factor(time, &v::TIME);
                assert!(close(factor(&format!("{length}/{time}^2"), &v::ACCELERATION), twice));
                assert!(close(factor(&format!("{length}/{time}/{time}"), &v::ACCELERATION), twice));
                assert!(close(factor(&format!("{length} {time}^-2"), &v::ACCELERATION), twice));
            }
        }
    }

    #[test]
    fn a_unit_of_something_else_is_refused_with_those_that_would_do() {
        for (unit, quantity) in [
            ("N", &v::DISPLACEMENT),
            ("m/s", &v::ACCELERATION),
            ("m", &v::TIME),
            ("1/s", &v::FREQUENCY),
            ("kg", &v::FORCE),
            ("kg", &v::ACCELERATION),
            ("s", &v::DAMPING_RATIO),
        ] {
            let error = unit_factor(unit, quantity).unwrap_err();
            assert!(matches!(error, UnitError::Dimension { .. }), "{error}");
            assert!(error.to_string().contains(quantity.unit), "{error}");
        }
    }

    #[test]
    fn what_is_no_unit_is_refused() {
        for unit in [
            "", " ", "MM", "Mm", "Grad", "Gs", "furlong", "m^", "m^0", "m^99", "m//s", "/s", "^2", "m-", "²",
            "m\u{0}", "mmm",
        ] {
            let error = unit_factor(unit, &v::DISPLACEMENT).unwrap_err();
            assert!(matches!(error, UnitError::Unknown { .. }), "{unit}: {error}");
        }
        let endless = "km^9 ".repeat(50);
        let error =
            unit_factor(&format!("{endless}/ {}", endless.trim().replace(' ', "/")), &v::DISPLACEMENT);
        assert!(error.is_err());
    }
}
