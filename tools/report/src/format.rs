//! Numbers, units and names as people read them.

/// A non-finite number, or one that is absent.
pub const ABSENT: &str = "–";

/// SI prefixes from pico to giga as (power of ten, symbol).
const PREFIXES: [(i32, &str); 8] =
    [(-12, "p"), (-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G")];

/// `unit` in typographic form: `m/s^2` becomes `m/s²`, `N.m/rad` becomes `N·m/rad`, `1` vanishes.
pub fn unit(unit: &str) -> String {
    if unit == "1" {
        return String::new();
    }
    unit.replace("^2", "²").replace("^3", "³").replace("^4", "⁴").replace('.', "·")
}

/// Whether an SI prefix may be put before `unit`: its first factor is a plain, unpowered unit without
/// a prefix of its own (`kg`), and not a reciprocal.
fn takes_prefix(unit: &str) -> bool {
    let end = unit.find(|c: char| !c.is_ascii_alphabetic()).unwrap_or(unit.len());
    let powered = unit[end..].starts_with('^');
    !powered && ["m", "s", "N", "Pa", "J", "W", "Hz", "V", "A"].contains(&&unit[..end])
}

/// The multiple of three at or below the decimal exponent of `value`; 0 for zero and non-numbers.
fn engineering_exponent(value: f64) -> i32 {
    if value == 0.0 || !value.is_finite() {
        return 0;
    }
    // A relative half in the fourth digit: 999.96 is printed as 1.000 of the next prefix.
    let exponent = (value.abs() * 1.00005).log10().floor() as i32;
    exponent.div_euclid(3) * 3
}

/// Powers of ten from here on are written as such.
const LONGEST: i32 = 12;

/// `value` with `digits` significant digits and without trailing zeros; as 1e300 where it would be long.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let exponent = value.abs().log10().floor() as i32;
    if exponent >= LONGEST && value.is_finite() {
        let text = format!("{value:.*e}", digits.max(1) as usize - 1);
        let (mantissa, power) = text.split_once('e').unwrap_or((&text, "0"));
        let mantissa = match mantissa.contains('.') {
            true => mantissa.trim_end_matches('0').trim_end_matches('.'),
            false => mantissa,
        };
        return minus(&format!("{mantissa}e{power}"));
    }
    let decimals = (digits - 1 - exponent).clamp(0, 17) as usize;
    let text = format!("{value:.decimals$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    minus(text)
}

/// `value` with `digits` significant digits, trailing zeros kept, so that a column lines up.
pub fn fixed(value: f64, digits: i32) -> String {
    if !value.is_finite() {
        return ABSENT.to_owned();
    }
    let exponent = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    minus(&format!("{value:.*}", (digits - 1 - exponent).clamp(0, 17) as usize))
}

/// A typographic minus sign in place of the hyphen.
fn minus(text: &str) -> String {
    text.strip_prefix('-').map_or_else(|| text.to_owned(), |rest| format!("−{rest}"))
}

/// Sizes below, in a unit that fits the values beside them, are rounding.
const ROUNDING: f64 = 1e-6;

/// Significant digits, where nothing asks for more, and at most.
const DIGITS: i32 = 4;
const MOST_DIGITS: i32 = 12;

/// Significant digits that tell the ends of an interval apart, by two digits of its width.
pub fn digits_between(low: f64, high: f64) -> i32 {
    let digits = (low.abs().max(high.abs()) / (high - low).abs()).log10().ceil();
    if digits.is_finite() { (digits as i32 + 2).clamp(DIGITS, MOST_DIGITS) } else { DIGITS }
}

/// `value` in engineering format with four significant digits: 5.54e6 N/m is `5.54 MN/m`, 8.7e4 1/m
/// is `87×10³ 1/m`.
pub fn engineering(value: f64, raw_unit: &str) -> String {
    engineering_to(DIGITS, value, raw_unit)
}

/// The same with so many significant digits.
pub fn engineering_to(digits: i32, value: f64, raw_unit: &str) -> String {
    if !value.is_finite() {
        return ABSENT.to_owned();
    }
    let plain = raw_unit == "1" || !takes_prefix(raw_unit);
    let small = plain && (1e-3..1e5).contains(&value.abs());
    let exponent = if small { 0 } else { engineering_exponent(value) };
    let number = significant(value / 10f64.powi(exponent), digits);
    let shown_unit = unit(raw_unit);
    if exponent == 0 {
        return join(&number, &shown_unit);
    }
    match PREFIXES.iter().find(|(power, _)| *power == exponent && !plain) {
        Some((_, prefix)) => format!("{number}\u{a0}{prefix}{shown_unit}"),
        None => join(&format!("{number}×10{}", superscript(exponent)), &shown_unit),
    }
}

fn join(number: &str, unit: &str) -> String {
    if unit.is_empty() { number.to_owned() } else { format!("{number}\u{a0}{unit}") }
}

pub fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32('⁰' as u32 + (digit as u32 - '0' as u32)).unwrap_or(digit),
        })
        .collect()
}

/// One prefix and one number of decimals for many values of a unit, so that a column lines up and an
/// axis reads in µm rather than in 10⁻⁶ m.
#[derive(Debug, Clone, PartialEq)]
pub struct Scale {
    /// What a value in SI is multiplied by.
    pub factor: f64,
    /// The unit after scaling, in typographic form; empty for a plain number.
    pub unit: String,
    /// Decimals to print.
    pub decimals: usize,
}

impl Scale {
    /// The scale for `values` in `raw_unit`, with decimals to resolve the smallest size that matters
    /// (a hundredth of the largest, or the smallest itself) to two digits.
    pub fn of(values: impl IntoIterator<Item = f64>, raw_unit: &str) -> Self {
        let (mut largest, mut smallest) = (0.0_f64, f64::INFINITY);
        for size in values.into_iter().map(f64::abs).filter(|size| size.is_finite() && *size > 0.0) {
            largest = largest.max(size);
            smallest = smallest.min(size);
        }
        if largest == 0.0 {
            return Self { factor: 1.0, unit: unit(raw_unit), decimals: 2 };
        }
        let mut exponent = if takes_prefix(raw_unit) { engineering_exponent(largest) } else { 0 };
        // 0.52 Hz reads better than 520 mHz, and 1 800 N better than 1.8 kN.
        if (0.01..1e4).contains(&largest) && raw_unit != "m" {
            exponent = 0;
        }
        let prefix = PREFIXES.iter().find(|(power, _)| *power == exponent);
        let (exponent, prefix) = prefix.map_or((0, ""), |&(power, prefix)| (power, prefix));
        let factor = 10f64.powi(-exponent);
        let resolved = smallest.max(largest * 1e-2) * factor;
        let decimals = (1 - resolved.log10().floor() as i32).clamp(0, 9) as usize;
        Self { factor, unit: format!("{prefix}{}", unit(raw_unit)), decimals }
    }

    /// `value` (SI) as a bare number in the scaled unit.
    pub fn number(&self, value: f64) -> String {
        if !value.is_finite() {
            return ABSENT.to_owned();
        }
        let text = format!("{:.*}", self.decimals, value * self.factor);
        // Where others are large, a small number is small, and not zero.
        if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
            let is_rounding = (value * self.factor).abs() < ROUNDING;
            return if is_rounding {
                text.trim_start_matches('-').to_owned()
            } else {
                significant(value * self.factor, 2)
            };
        }
        minus(&text)
    }

    /// As [`Scale::number`], with a plus sign before positive numbers.
    pub fn signed(&self, value: f64) -> String {
        let text = self.number(value);
        let zero = text.chars().all(|c| c == '0' || c == '.');
        if value > 0.0 && value.is_finite() && !zero { format!("+{text}") } else { text }
    }

    /// `value` (SI) with the scaled unit behind it.
    pub fn with_unit(&self, value: f64) -> String {
        if value.is_finite() { join(&self.number(value), &self.unit) } else { ABSENT.to_owned() }
    }

    /// `name (unit)`, or `name` alone for a plain number.
    pub fn label(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name} ({})", self.unit) }
    }
}

/// A dimensionless error with three significant digits.
pub fn error(value: f64) -> String {
    if !value.is_finite() {
        return ABSENT.to_owned();
    }
    let exponent = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if exponent < -4 {
        return engineering(value, "1");
    }
    format!("{:.*}", (2 - exponent).clamp(0, 6) as usize, value)
}

/// Change from `before` to `after` in per cent with a sign; `None` without a finite, non-zero base.
pub fn change(before: f64, after: f64) -> Option<String> {
    let percent = (after - before) / before.abs() * 100.0;
    if !percent.is_finite() {
        return None;
    }
    let text = if percent.abs() < 10.0 { format!("{percent:+.1}") } else { format!("{percent:+.0}") };
    Some(format!("{}\u{a0}%", if percent < 0.0 { minus(&text) } else { text }))
}

/// `singular` or its plural, after the count.
pub fn count(number: usize, singular: &str) -> String {
    format!("{number} {singular}{}", if number == 1 { "" } else { "s" })
}

/// `text` cut to `limit` characters, the last one an ellipsis.
pub fn shorten(text: &str, limit: usize) -> String {
    if text.chars().count() <= limit {
        return text.to_owned();
    }
    text.chars().take(limit.saturating_sub(1)).chain(['…']).collect()
}

/// `text` without characters that steer a terminal or reorder text: control characters and the
/// bidirectional overrides become `�`.
pub fn printable(text: &str) -> String {
    text.chars()
        .map(|c| match c {
            '\t' | '\n' | '\r' => ' ',
            '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '\u{fffd}',
            c if c.is_control() => '\u{fffd}',
            c => c,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_number_is_written_as_a_power_of_ten() {
        assert_eq!(significant(1e300, 6), "1e300");
        assert_eq!(significant(-1.25e15, 6), "−1.25e15");
        assert_eq!(significant(123456.0, 6), "123456");
    }

    #[test]
    fn engineering_format_keeps_the_value_and_uses_multiples_of_three() {
        assert_eq!(engineering(5.54e6, "N/m"), "5.54\u{a0}MN/m");
        assert_eq!(engineering(162.0, "N"), "162\u{a0}N");
        assert_eq!(engineering(2.3e-3, "m"), "2.3\u{a0}mm");
        assert_eq!(engineering(0.47, "1"), "0.47");
        assert_eq!(engineering(8.7e4, "1/m"), "87000\u{a0}1/m");
        assert_eq!(engineering(8.7e5, "1/m"), "870×10³\u{a0}1/m");
        assert_eq!(engineering(-1.97e11, "Pa"), "−197\u{a0}GPa");
        assert_eq!(engineering(7850.0, "kg/m^3"), "7850\u{a0}kg/m³");
        assert_eq!(engineering(4.2e-10, "m^4"), "420×10⁻¹²\u{a0}m⁴");
        assert_eq!(engineering(999.999, "N"), "1\u{a0}kN");
        assert_eq!(engineering(0.0, "N"), "0\u{a0}N");
        assert_eq!(engineering(f64::NAN, "N"), ABSENT);
    }

    #[test]
    fn a_scale_prints_a_column_in_one_unit_and_resolves_its_smallest_entry() {
        let scale = Scale::of([1.80, 0.82, 0.15, 0.10], "Hz");
        assert_eq!(
            (scale.with_unit(1.80), scale.with_unit(0.1)),
            ("1.80\u{a0}Hz".into(), "0.10\u{a0}Hz".into())
        );
        let scale = Scale::of([12e-6, 3e-6], "m");
        assert_eq!(scale.label("displacement"), "displacement (µm)");
        assert_eq!(scale.number(12e-6), "12.0");
        assert_eq!(Scale::of([1.0], "Hz").signed(-1e-9), "0.0");
        // Beside large ones a small number is small, and not zero.
        assert_eq!(Scale::of([30.5], "N").number(2.5e-4), "0.00025");
        assert_eq!(Scale::of([1.0], "Hz").signed(0.3), "+0.3");
        assert_eq!(Scale::of([], "N").number(f64::NAN), ABSENT);
    }

    #[test]
    fn change_is_relative_to_the_value_before() {
        assert_eq!(change(2.0, 1.0).unwrap(), "−50\u{a0}%");
        assert_eq!(change(1.0, 1.086).unwrap(), "+8.6\u{a0}%");
        assert_eq!(change(0.0, 1.0), None);
    }

    #[test]
    fn nothing_printable_can_steer_a_terminal() {
        assert_eq!(printable("a\u{1b}[31mb\u{202e}c\nd"), "a\u{fffd}[31mb\u{fffd}c d");
    }
}
