//! A page of sections with text, tables and plots, from which both response curves and studies are made.

mod json;
mod page;
mod plot;

pub use json::document_json;
pub use page::document_html;
pub(crate) use page::section;
pub use plot::{Axis, Line, Panel, Plot, Scaling, Stroke, palette};

use crate::format;

/// What a page holds, before it is drawn. Text and names are escaped wherever they appear.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Document {
    /// Title of the page.
    pub title: String,
    /// The result in one sentence.
    pub lead: String,
    /// What a reader must know beside it.
    pub warnings: Vec<String>,
    /// What was computed, in small print.
    pub scope: String,
    /// The sections.
    pub sections: Vec<Section>,
}

/// A section of a page.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Section {
    /// Identifier in the page, of letters, digits and hyphens.
    pub id: String,
    /// Heading.
    pub title: String,
    /// What it holds, in order.
    pub blocks: Vec<Block>,
}

/// A part of a section.
#[derive(Debug, Clone, PartialEq)]
pub enum Block {
    /// A paragraph.
    Text(String),
    /// A paragraph in small print.
    Note(String),
    /// A paragraph that must not be overlooked.
    Warning(String),
    /// A table.
    Table(Table),
    /// Plots, those of half width side by side.
    Plots(Vec<Plot>),
}

/// A table whose first column heads the rows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Table {
    /// What it shows, for readers who cannot see it.
    pub label: String,
    /// Heading of every column.
    pub heading: Vec<String>,
    /// Rows of as many cells as the heading has.
    pub rows: Vec<Vec<Cell>>,
}

/// A cell of a table.
#[derive(Debug, Clone, PartialEq)]
pub enum Cell {
    /// Text that may be broken into lines.
    Text(String),
    /// Text that is marked as something to look at.
    Marked(String),
    /// A number with so many decimals; – where it is not finite.
    Number(f64, usize),
    /// A small number of any size, as 1.2×10⁻⁷; – where it is not finite.
    Scientific(f64),
    /// A count.
    Count(usize),
}

impl Cell {
    /// Text.
    pub fn text(text: impl Into<String>) -> Self {
        Cell::Text(text.into())
    }

    /// As it is printed.
    pub fn shown(&self) -> String {
        match self {
            Cell::Text(text) | Cell::Marked(text) => text.clone(),
            Cell::Number(value, _) if !value.is_finite() => format::ABSENT.to_owned(),
            Cell::Number(value, decimals) => {
                format::Scale { factor: 1.0, unit: String::new(), decimals: *decimals }.number(*value)
            }
            Cell::Scientific(value) => scientific(*value),
            Cell::Count(count) => count.to_string(),
        }
    }

    fn is_number(&self) -> bool {
        !matches!(self, Cell::Text(_) | Cell::Marked(_))
    }
}

/// `value` with two significant digits: 1.2×10⁻⁷, or 0.012 where that reads as well.
pub fn scientific(value: f64) -> String {
    if !value.is_finite() {
        return format::ABSENT.to_owned();
    }
    if value == 0.0 || (1e-3..1e3).contains(&value.abs()) {
        return format::significant(value, 2);
    }
    let text = format!("{value:.1e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let mantissa = mantissa.trim_end_matches(".0").replace('-', "−");
    format!("{mantissa}×10{}", format::superscript(exponent.parse().unwrap_or(0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_numbers_keep_their_size() {
        assert_eq!(scientific(1.24e-7), "1.2×10⁻⁷");
        assert_eq!(scientific(1e-12), "1×10⁻¹²");
        assert_eq!(scientific(0.0123), "0.012");
        assert_eq!(scientific(-2.5e4), "−2.5×10⁴");
        assert_eq!(scientific(f64::NAN), format::ABSENT);
        assert_eq!(Cell::Number(f64::INFINITY, 3).shown(), format::ABSENT);
    }
}
