//! Columns as they stand in a file, before anything is known of their meaning.

/// A column; what is no number is NaN.
pub(super) struct RawColumn {
    pub heading: String,
    /// What stands below the heading, in a row of units, or in the properties of the channel.
    pub unit: Option<String>,
    pub values: Vec<f64>,
    /// Cells that hold words, and the first of them with its line.
    pub words: usize,
    pub first_word: Option<(String, u64)>,
    /// The first number with signs between thousands, with its line.
    pub grouped: Option<(String, u64)>,
    /// Cells of the form 12:30:00.5, read as seconds of the day.
    pub clock: bool,
}

impl RawColumn {
    pub fn new(heading: &str, unit: Option<String>, values: Vec<f64>) -> Self {
        Self {
            heading: heading.to_owned(),
            unit,
            values,
            words: 0,
            first_word: None,
            grouped: None,
            clock: false,
        }
    }
}

/// Columns of the same length: a record, or several.
pub(super) struct RawTable {
    /// The part of the file that it stands in; empty where the file has no parts.
    pub name: String,
    pub columns: Vec<RawColumn>,
}
