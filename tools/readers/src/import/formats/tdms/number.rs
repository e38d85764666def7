//! Numbers of a TDMS file, in either order of their bytes.

/// The order of the bytes of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Order {
    Little,
    Big,
}

/// What a value is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// Whole, of so many bytes.
    Signed(usize),
    Unsigned(usize),
    Single,
    Double,
    /// Words, each as long as it likes.
    Text,
    /// Seconds since 1904 and their 2⁶⁴th parts.
    Stamp,
    /// No number, of so many bytes.
    Other(usize),
}

impl Kind {
    /// The kind that a file numbers so.
    pub fn new(code: u32) -> Result<Self, String> {
        Ok(match code {
            0 => Self::Other(0),
            1..=4 => Self::Signed(1 << (code - 1)),
            5..=8 => Self::Unsigned(1 << (code - 5)),
            9 | 0x19 => Self::Single,
            10 | 0x1A => Self::Double,
            0x20 => Self::Text,
            0x21 => Self::Other(1),
            0x44 => Self::Stamp,
            0x0008_000C => Self::Other(8),
            0x0010_000D => Self::Other(16),
            _ => return Err(format!("it holds values of a kind that is not known ({code})")),
        })
    }

    /// Bytes of a value; of words none are known beforehand.
    pub fn size(self) -> usize {
        match self {
            Self::Signed(size) | Self::Unsigned(size) | Self::Other(size) => size,
            Self::Single => 4,
            Self::Double => 8,
            Self::Text => 0,
            Self::Stamp => 16,
        }
    }

    /// Whether values of the kind are numbers.
    pub fn is_number(self) -> bool {
        !matches!(self, Self::Text | Self::Other(_))
    }

    /// The number that `bytes` are, as many as a value has; NaN for what is none.
    pub fn number(self, bytes: &[u8], order: Order) -> f64 {
        let bits = |bytes: &[u8]| match order {
            Order::Little => bytes.iter().rev().fold(0u64, |sum, byte| sum << 8 | u64::from(*byte)),
            Order::Big => bytes.iter().fold(0u64, |sum, byte| sum << 8 | u64::from(*byte)),
        };
        match self {
            Self::Signed(size) => {
                let above = 64 - 8 * size as u32;
                ((bits(bytes) << above) as i64 >> above) as f64
            }
            Self::Unsigned(_) => bits(bytes) as f64,
            Self::Single => f64::from(f32::from_bits(bits(bytes) as u32)),
            Self::Double => f64::from_bits(bits(bytes)),
            Self::Stamp => {
                let (first, second) = bytes.split_at(8);
                let (seconds, parts) = match order {
                    Order::Little => (second, first),
                    Order::Big => (first, second),
                };
                bits(seconds) as i64 as f64 + bits(parts) as f64 / 2.0_f64.powi(64)
            }
            Self::Text | Self::Other(_) => f64::NAN,
        }
    }
}
