//! Types of FMI 3.0, as which numbers are passed.

/// How C passes a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Format {
    /// `fmi3Float64`.
    #[default]
    Float64,
    /// `fmi3Float32`.
    Float32,
    /// `fmi3Int8`.
    Int8,
    /// `fmi3UInt8`.
    UInt8,
    /// `fmi3Int16`.
    Int16,
    /// `fmi3UInt16`.
    UInt16,
    /// `fmi3Int32`.
    Int32,
    /// `fmi3UInt32`.
    UInt32,
    /// `fmi3Int64`, and enumerations.
    Int64,
    /// `fmi3UInt64`.
    UInt64,
    /// `fmi3Boolean`.
    Boolean,
}

impl Format {
    /// The type of the variable element `name`; `None` for texts, binary data and clocks.
    pub(crate) fn of_element(name: &str) -> Option<Self> {
        Some(match name {
            "Float64" => Self::Float64,
            "Float32" => Self::Float32,
            "Int8" => Self::Int8,
            "UInt8" => Self::UInt8,
            "Int16" => Self::Int16,
            "UInt16" => Self::UInt16,
            "Int32" => Self::Int32,
            "UInt32" => Self::UInt32,
            "Int64" | "Enumeration" => Self::Int64,
            "UInt64" => Self::UInt64,
            "Boolean" => Self::Boolean,
            _ => return None,
        })
    }

    /// The least and the largest whole number that it holds; `None` where it holds others, too.
    ///
    /// ```
    /// use stickslip_fmi_host::Format;
    /// assert_eq!(Format::Int8.range(), Some((-128.0, 127.0)));
    /// assert_eq!(Format::Float32.range(), None);
    /// ```
    pub fn range(self) -> Option<(f64, f64)> {
        /// The largest number of each kind that a double holds without rounding up.
        const I64: f64 = 9_223_372_036_854_774_784.0;
        const U64: f64 = 18_446_744_073_709_549_568.0;
        Some(match self {
            Self::Float64 | Self::Float32 | Self::Boolean => return None,
            Self::Int8 => (i8::MIN.into(), i8::MAX.into()),
            Self::UInt8 => (0.0, u8::MAX.into()),
            Self::Int16 => (i16::MIN.into(), i16::MAX.into()),
            Self::UInt16 => (0.0, u16::MAX.into()),
            Self::Int32 => (i32::MIN.into(), i32::MAX.into()),
            Self::UInt32 => (0.0, u32::MAX.into()),
            Self::Int64 => (-I64, I64),
            Self::UInt64 => (0.0, U64),
        })
    }

    /// Whether `value` can be passed as it is.
    ///
    /// ```
    /// use stickslip_fmi_host::Format;
    /// assert!(Format::UInt8.holds(255.0) && !Format::UInt8.holds(256.0) && !Format::UInt8.holds(0.5));
    /// ```
    pub fn holds(self, value: f64) -> bool {
        self.range()
            .is_none_or(|(least, largest)| value == value.trunc() && (least..=largest).contains(&value))
    }
}
