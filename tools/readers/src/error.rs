//! Errors of files, and their messages.

use std::fmt;
use std::ops::Range;
use std::path::PathBuf;

use annotate_snippets::renderer::DecorStyle;
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use stickslip::data::{ChannelNameError, UnitError};
use stickslip::document::DocumentError;
use thiserror::Error;

use crate::archive::ArchiveProblem;
use crate::ssp::SspProblem;
use crate::xml::XmlProblem;

/// One thing wrong with one file.
#[derive(Debug, Clone, PartialEq)]
pub struct InputError {
    /// The file.
    pub path: PathBuf,
    /// The line it is about; `None` when it is about the file as a whole.
    pub excerpt: Option<Excerpt>,
    /// What is wrong.
    pub problem: Box<Problem>,
}

/// A line of a file, and the part of it that is wrong.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Excerpt {
    /// Number of the line, from 1.
    pub line: usize,
    /// Number of the first wrong character in the line, from 1.
    pub column: usize,
    /// The line without its end, shortened if it is very long; empty where it cannot be shown.
    pub text: String,
    /// The bytes of `text` that are wrong.
    pub span: Range<usize>,
}

/// What can be wrong with a file.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum Problem {
    /// The operating system did not give us the file.
    #[error("cannot read {what}: {reason}")]
    Unreadable {
        /// `the file`, or the name of the file another one refers to.
        what: String,
        /// The system's reason.
        reason: String,
    },
    /// Bytes that are not UTF-8.
    #[error("the text is not UTF-8")]
    NotUtf8 {
        /// Which encoding it probably is.
        guess: &'static str,
    },
    /// An XML file whose declaration names an encoding that is not known.
    #[error("the encoding `{0}`, which the file declares, is not read")]
    Encoding(String),
    /// A TOML file that says something it must not.
    #[error("{}", .0.message)]
    Document(DocumentError),
    /// A CSV file without anything.
    #[error("the file is empty")]
    Empty,
    /// A CSV file with a header only.
    #[error("there is no row below the header")]
    NoRows,
    /// Columns are separated by something else than commas.
    #[error("columns are separated by {0}, not by commas")]
    Separator(&'static str),
    /// A header without its unit.
    #[error("column `{0}` has no unit")]
    NoUnit(String),
    /// A header that names no column.
    #[error("{0}")]
    Name(ChannelNameError),
    /// A unit that does not suit the column.
    #[error("{0}")]
    Unit(UnitError),
    /// Two columns of one name.
    #[error("column `{0}` is listed twice")]
    DuplicateColumn(String),
    /// A row with another number of fields than the header.
    #[error("the row and the header differ in length: {found} against {expected}")]
    Ragged {
        /// Number of columns.
        expected: usize,
        /// Number of fields in the row.
        found: usize,
    },
    /// A field that is no number.
    #[error("`{text}` in column `{column}` is not a number")]
    NotANumber {
        /// The column.
        column: String,
        /// The field.
        text: String,
    },
    /// NaN, infinity, or a number too large for 64 bits.
    #[error("`{text}` in column `{column}` is not a finite number")]
    NotFinite {
        /// The column.
        column: String,
        /// The field.
        text: String,
    },
    /// A number the quantity cannot have.
    #[error("`{text}` in column `{column}` is out of bounds: it must be {bounds}")]
    OutOfBounds {
        /// The column.
        column: String,
        /// The field.
        text: String,
        /// The bounds, in SI.
        bounds: String,
    },
    /// Time stamps that stand still or run back.
    #[error("time does not increase: {time} s after {previous} s")]
    TimeNotIncreasing {
        /// The stamp of the row before (s).
        previous: f64,
        /// The stamp of this row (s).
        time: f64,
    },
    /// A column that the regime, or the model, needs.
    #[error("column `{column}` is missing: {reason}")]
    MissingColumn {
        /// The column, with its unit.
        column: String,
        /// Who needs it.
        reason: String,
    },
    /// A normal load that pulls from beginning to end.
    #[error("column `normal_load` is below zero throughout: a load that presses counts as positive")]
    PullingLoad,
    /// A column that does not fit the model.
    #[error("column `{column}` does not fit the model: {reason}")]
    UnsuitableColumn {
        /// The column.
        column: String,
        /// Why.
        reason: String,
    },
    /// A record whose regime the model cannot have.
    #[error("{0}")]
    UnsuitableRegime(String),
    /// A table that cannot be imported.
    #[error("{message}")]
    Import {
        /// What is wrong.
        message: String,
        /// What to do.
        help: String,
    },
    /// A zip archive that is damaged or dangerous.
    #[error(transparent)]
    Archive(#[from] ArchiveProblem),
    /// An XML file that is none, or not of the kind it should be.
    #[error(transparent)]
    Xml(#[from] XmlProblem),
    /// A system structure that cannot be simulated.
    #[error(transparent)]
    Ssp(#[from] SspProblem),
}

impl Problem {
    /// What would be right, if there is more to say.
    pub fn help(&self) -> Option<String> {
        let help = match self {
            Problem::NotUtf8 { guess } => {
                format!("it looks like {guess}; save the file as UTF-8 (µ is then two bytes)")
            }
            Problem::Encoding(_) => {
                "UTF-8, UTF-16, ISO-8859-1 to -16, US-ASCII, Windows-125x and other encodings of the web are read".into()
            }
            Problem::Document(error) => return error.help.clone(),
            Problem::Import { help, .. } => help.clone(),
            Problem::Ssp(problem) => return problem.help(),
            Problem::Empty => {
                "the first line names the columns: `time [s],displacement [mm],force [N]`".into()
            }
            Problem::Separator(_) => "separate columns by commas and write decimals with a point".into(),
            Problem::NoUnit(name) => {
                let unit = stickslip::vocabulary::find(name.split(':').next().unwrap_or(name));
                format!("write the unit in brackets: `{name} [{}]`", unit.map_or("unit", |unit| unit.unit))
            }
            Problem::PullingLoad => "change the sign of the column".into(),
            Problem::Name(ChannelNameError::Quantity { help, .. }) => help.clone(),
            _ => return None,
        };
        Some(help)
    }
}

impl InputError {
    /// Number of the line, from 1, if the error is about a line.
    pub fn line(&self) -> Option<usize> {
        self.excerpt.as_ref().map(|excerpt| excerpt.line)
    }

    /// The text a user sees: `error: ...`, the file and line, and the line itself with the wrong part
    /// marked. `color` adds ANSI escapes.
    pub fn render(&self, color: bool) -> String {
        let renderer = if color { Renderer::styled() } else { Renderer::plain() };
        let renderer = renderer.decor_style(DecorStyle::Ascii);
        let path = self.path.display().to_string();
        let title = Level::ERROR.primary_title(shortened(self.problem.to_string()));
        let group = match &self.excerpt {
            None => Group::with_title(title).element(Origin::path(path)),
            Some(excerpt) if excerpt.text.is_empty() => Group::with_title(title)
                .element(Origin::path(path).line(excerpt.line).char_column(excerpt.column)),
            Some(excerpt) => title.element(
                Snippet::source(excerpt.text.as_str())
                    .line_start(excerpt.line)
                    .path(path)
                    .annotation(AnnotationKind::Primary.span(excerpt.span.clone())),
            ),
        };
        let group = match self.problem.help() {
            Some(help) => group.element(Level::HELP.message(shortened(help))),
            None => group,
        };
        renderer.render(&[group])
    }
}

/// Messages quote the file, and a file without line ends or commas is one endless word.
fn shortened(mut message: String) -> String {
    const LONGEST: usize = 2000;
    if let Some((end, _)) = message.char_indices().nth(LONGEST) {
        message.truncate(end);
        message.push('…');
    }
    message
}

/// One line, for logs; [`InputError::render`] is for users.
impl fmt::Display for InputError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}", self.path.display())?;
        if let Some(excerpt) = &self.excerpt {
            write!(formatter, ":{}:{}", excerpt.line, excerpt.column)?;
        }
        write!(formatter, ": {}", self.problem)
    }
}

impl std::error::Error for InputError {}
