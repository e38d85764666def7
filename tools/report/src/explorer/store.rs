//! Columns of numbers in two bytes each, as text.

use serde_json::{Value, json};

/// The code of a number that is not finite.
const GAP: u16 = u16::MAX;
/// The largest code of a number.
const TOP: f64 = (u16::MAX - 1) as f64;
/// Numbers that deviate from an even grid by less than this fraction of their range are stored as one.
const EVEN: f64 = 1e-6;

/// The columns of a page. A page shows a thousand or two of pixels: 65 534 steps over the range of a column
/// are more than it can draw, and take a fifth of the room of digits.
#[derive(Debug, Default)]
pub struct Store {
    columns: Vec<Value>,
    known: std::collections::HashMap<(u64, usize), usize>,
}

impl Store {
    /// Stores `factor` times the values at `kept` (NaN beyond their end), and returns the column's number; the
    /// same numbers again get the same column.
    pub fn scaled(&mut self, values: &[f64], kept: &[usize], factor: f64) -> usize {
        let picked: Vec<f64> =
            kept.iter().map(|&index| values.get(index).map_or(f64::NAN, |value| value * factor)).collect();
        let key = (hash(&picked), picked.len());
        if let Some(&column) = self.known.get(&key) {
            return column;
        }
        self.columns.push(column(&picked));
        self.known.insert(key, self.columns.len() - 1);
        self.columns.len() - 1
    }

    /// All columns: `{"from", "step", "count"}` where they are evenly spaced, otherwise `{"from", "step",
    /// "codes"}` with 16-bit little-endian integers in base 64, of which the largest stands for a gap.
    pub fn into_columns(self) -> Vec<Value> {
        self.columns
    }
}

fn hash(values: &[f64]) -> u64 {
    use std::hash::{DefaultHasher, Hash as _, Hasher as _};
    // Without keys of its own: the same on every run.
    let mut hasher = DefaultHasher::new();
    values.iter().for_each(|value| value.to_bits().hash(&mut hasher));
    hasher.finish()
}

fn column(values: &[f64]) -> Value {
    let finite = || values.iter().copied().filter(|value| value.is_finite());
    let low = finite().fold(f64::INFINITY, f64::min);
    let high = finite().fold(f64::NEG_INFINITY, f64::max);
    if let Some(step) = even_step(values, high - low) {
        return json!({ "from": values[0], "step": step, "count": values.len() });
    }
    let step = if high > low { (high - low) / TOP } else { 0.0 };
    let code = |value: &f64| match value {
        value if !value.is_finite() => GAP,
        _ if step == 0.0 => 0,
        value => ((value - low) / step).round().clamp(0.0, TOP) as u16,
    };
    let bytes: Vec<u8> = values.iter().map(code).flat_map(u16::to_le_bytes).collect();
    json!({ "from": if low.is_finite() { low } else { 0.0 }, "step": step, "codes": base64(&bytes) })
}

fn even_step(values: &[f64], range: f64) -> Option<f64> {
    let steps = values.len().checked_sub(1).filter(|steps| *steps > 0)?;
    let step = (values[steps] - values[0]) / steps as f64;
    let even = |(index, value): (usize, &f64)| {
        (value - (values[0] + index as f64 * step)).abs() <= EVEN * range.abs()
    };
    (range > 0.0 && values.iter().enumerate().all(even)).then_some(step)
}

/// RFC 4648.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let word = chunk.iter().chain([&0; 2]).take(3).fold(0_u32, |word, &byte| word << 8 | u32::from(byte));
        for place in 0..4 {
            match place <= chunk.len() {
                true => text.push(char::from(DIGITS[(word >> (18 - 6 * place) & 63) as usize])),
                false => text.push('='),
            }
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        // RFC 4648, section 10.
        for (text, code) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(base64(text.as_bytes()), code);
        }
    }

    #[test]
    fn an_even_grid_is_two_numbers_and_equal_columns_are_one() {
        let mut store = Store::default();
        let (time, wild) = ([0.0, 0.1, 0.2, 0.3], [1.0, f64::NAN, -1.0, 7.0]);
        let kept = [0, 1, 2, 3];
        assert_eq!(store.scaled(&time, &kept, 1e3), 0);
        assert_eq!(store.scaled(&wild, &kept, 1.0), 1);
        assert_eq!(store.scaled(&wild, &kept, 1.0), 1);
        let columns = store.into_columns();
        assert_eq!(columns[0]["count"], 4);
        // −1 is code 0, 7 the largest (65534), 1 a quarter of it, rounded up; bytes are little-endian.
        assert_eq!(columns[1]["codes"], base64(&[0, 0x40, 0xff, 0xff, 0, 0, 0xfe, 0xff]));
    }
}
