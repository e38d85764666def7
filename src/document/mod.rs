//! TOML files with positions: tables whose keys are checked, and errors with byte ranges.
//!
//! The model file and the dataset file are both read through [`Table`]. Every error carries the byte
//! range it is about, so that whoever holds the file's name can point at the line.

mod suggestion;

pub use suggestion::{nearest, suggestion};

use std::fmt;
use std::ops::Range;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use crate::vocabulary::Quantity;

/// What is wrong with a TOML text, and where.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DocumentError {
    /// What is wrong, in one sentence.
    pub message: String,
    /// Bytes of the text it is about; `None` where something is missing from the file as a whole.
    pub span: Option<Range<usize>>,
    /// What would be right, if there is more to say.
    pub help: Option<String>,
}

impl DocumentError {
    /// An error at `span` without help.
    pub fn new(message: impl Into<String>, span: Option<Range<usize>>) -> Self {
        DocumentError { message: message.into(), span, help: None }
    }

    /// The same error with `help`.
    pub fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for DocumentError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(&self.message)?;
        match &self.help {
            Some(help) => write!(formatter, " ({help})"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for DocumentError {}

/// A parsed TOML text.
#[derive(Debug)]
pub struct Document<'i>(Spanned<DeTable<'i>>);

impl<'i> Document<'i> {
    /// Parses `text`; a byte order mark at its start is skipped.
    ///
    /// # Errors
    /// The first place that is not TOML.
    pub fn parse(text: &'i str) -> Result<Self, DocumentError> {
        DeTable::parse(text).map(Document).map_err(|error| {
            let message = error.message().lines().collect::<Vec<_>>().join(", ");
            DocumentError::new(format!("not TOML: {message}"), error.span())
        })
    }

    /// The table at the top of the file.
    pub fn root(&self) -> Table<'_> {
        Table { entries: self.0.get_ref(), span: None, name: String::new() }
    }
}

/// One table of a [`Document`].
#[derive(Debug, Clone)]
pub struct Table<'a> {
    entries: &'a DeTable<'a>,
    span: Option<Range<usize>>,
    name: String,
}

/// A value and the bytes it stands at.
#[derive(Debug, Clone, PartialEq)]
pub struct Located<T> {
    /// The value.
    pub value: T,
    /// Its bytes.
    pub span: Range<usize>,
}

impl<T> Located<T> {
    /// An error about this value.
    pub fn error(&self, message: impl Into<String>) -> DocumentError {
        DocumentError::new(message, Some(self.span.clone()))
    }
}

/// One number or an array of them.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// `key = 0.003`
    One(f64),
    /// `key = [0.003, 0.004]`
    Many(Vec<f64>),
}

impl<'a> Table<'a> {
    /// How a message names the table: `[contact]`, or `the file` for the root.
    pub fn title(&self) -> String {
        if self.name.is_empty() { "the file".to_owned() } else { format!("[{}]", self.name) }
    }

    /// Bytes of the table's header; `None` for the root.
    pub fn span(&self) -> Option<Range<usize>> {
        self.span.clone()
    }

    /// The table's keys with their places, in the file's order.
    pub fn keys(&self) -> Vec<Located<&'a str>> {
        let mut keys: Vec<_> = self
            .entries
            .keys()
            .map(|key| Located { value: key.get_ref().as_ref(), span: key.span() })
            .collect();
        keys.sort_by_key(|key| key.span.start);
        keys
    }

    /// Refuses keys that are not in `legal`.
    ///
    /// # Errors
    /// The first unknown key, with the nearest legal one and the list of all.
    pub fn allow(&self, legal: &[&str]) -> Result<(), DocumentError> {
        match self.keys().into_iter().find(|key| !legal.contains(&key.value)) {
            None => Ok(()),
            Some(key) => Err(key
                .error(format!("unknown key `{}` in {}", key.value, self.title()))
                .with_help(suggestion(key.value, legal, "keys"))),
        }
    }

    /// An error about a missing `key`, at the table's header.
    pub fn missing(&self, key: &str) -> DocumentError {
        DocumentError::new(format!("`{key}` is missing from {}", self.title()), self.span())
    }

    fn entry(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.entries.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
    }

    /// The bytes of `key`'s value, if it is there.
    pub fn span_of(&self, key: &str) -> Option<Range<usize>> {
        self.entry(key).map(Spanned::span)
    }

    fn wrong_type(&self, key: &str, wanted: &str, value: &Spanned<DeValue<'_>>) -> DocumentError {
        let message = format!("`{key}` must be {wanted}, not {}", described(value.get_ref()));
        DocumentError::new(message, Some(value.span()))
    }

    /// The string at `key`, if the key is there.
    ///
    /// # Errors
    /// A value that is not a string.
    pub fn string(&self, key: &str) -> Result<Option<Located<&'a str>>, DocumentError> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) => Ok(Some(Located { value: text, span: value.span() })),
            None => Err(self.wrong_type(key, "a string", value)),
        }
    }

    /// The string at `key`.
    ///
    /// # Errors
    /// A missing key, or a value that is not a string.
    pub fn required_string(&self, key: &str) -> Result<Located<&'a str>, DocumentError> {
        self.string(key)?.ok_or_else(|| self.missing(key))
    }

    /// The one of `choices` that the string at `key` names, if the key is there.
    ///
    /// # Errors
    /// A value that is not a string or names none of them; the help lists them.
    pub fn choice<T: Copy>(
        &self,
        key: &str,
        choices: &[(&str, T)],
    ) -> Result<Option<Located<T>>, DocumentError> {
        let Some(text) = self.string(key)? else { return Ok(None) };
        match choices.iter().find(|(name, _)| *name == text.value) {
            Some(&(_, value)) => Ok(Some(Located { value, span: text.span })),
            None => {
                let names: Vec<_> = choices.iter().map(|(name, _)| *name).collect();
                Err(text
                    .error(format!("unknown {key} \"{}\"", text.value))
                    .with_help(suggestion(text.value, &names, "values")))
            }
        }
    }

    /// The strings of the array at `key`, if the key is there.
    ///
    /// # Errors
    /// A value that is not an array of strings.
    pub fn strings(&self, key: &str) -> Result<Option<Vec<Located<&'a str>>>, DocumentError> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        let wrong = |value| self.wrong_type(key, "an array of strings", value);
        let array = value.get_ref().as_array().ok_or_else(|| wrong(value))?;
        let text = |element: &'a Spanned<DeValue<'a>>| match element.get_ref().as_str() {
            Some(text) => Ok(Located { value: text, span: element.span() }),
            None => Err(wrong(element)),
        };
        array.iter().map(text).collect::<Result<_, _>>().map(Some)
    }

    /// The boolean at `key`, if the key is there.
    ///
    /// # Errors
    /// A value that is neither `true` nor `false`.
    pub fn boolean(&self, key: &str) -> Result<Option<Located<bool>>, DocumentError> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::Boolean(flag) => Ok(Some(Located { value: *flag, span: value.span() })),
            _ => Err(self.wrong_type(key, "`true` or `false`", value)),
        }
    }

    /// The finite number at `key`, if the key is there; integers count as numbers.
    ///
    /// # Errors
    /// A value that is not a number, or not a finite one.
    pub fn number(&self, key: &str) -> Result<Option<Located<f64>>, DocumentError> {
        self.entry(key).map(|value| finite(key, value)).transpose()
    }

    /// The finite number at `key`.
    ///
    /// # Errors
    /// A missing key, a value that is not a number, or not a finite one.
    pub fn required_number(&self, key: &str) -> Result<Located<f64>, DocumentError> {
        self.number(key)?.ok_or_else(|| self.missing(key))
    }

    /// The value of `quantity` at the key of its name; its unit goes into the message of a missing key.
    ///
    /// # Errors
    /// As [`Table::required_number`]. Bounds are not checked here.
    pub fn quantity(&self, quantity: &Quantity) -> Result<f64, DocumentError> {
        match self.number(quantity.name)? {
            Some(number) => Ok(number.value),
            None => {
                let unit = if quantity.unit == "1" { "plain number" } else { quantity.unit };
                Err(self.missing(quantity.name).with_help(format!("{} [{unit}]", quantity.description)))
            }
        }
    }

    /// The number or the array of numbers at `key`, if the key is there.
    ///
    /// # Errors
    /// Anything that is neither a finite number nor an array of finite numbers.
    pub fn number_or_numbers(&self, key: &str) -> Result<Option<Numbers>, DocumentError> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        match value.get_ref().as_array() {
            None => Ok(Some(Numbers::One(finite(key, value)?.value))),
            Some(array) => {
                let number = |element| finite(key, element).map(|located| located.value);
                Ok(Some(Numbers::Many(array.iter().map(number).collect::<Result<_, _>>()?)))
            }
        }
    }

    /// The table at `key`, if the key is there.
    ///
    /// # Errors
    /// A value that is not a table.
    pub fn table(&self, key: &str) -> Result<Option<Table<'a>>, DocumentError> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        let wrong = || {
            let message =
                format!("`{key}` must be a table [{}], not {}", self.child(key), described(value.get_ref()));
            DocumentError::new(message, Some(value.span()))
        };
        let entries = value.get_ref().as_table().ok_or_else(wrong)?;
        Ok(Some(Table { entries, span: Some(value.span()), name: self.child(key) }))
    }

    /// The array of tables at `key`; `None` when the key is absent.
    ///
    /// # Errors
    /// A value that is not an array of tables.
    pub fn tables(&self, key: &str) -> Result<Option<Vec<Table<'a>>>, DocumentError> {
        let Some(value) = self.entry(key) else { return Ok(None) };
        let wrong = |value: &Spanned<DeValue<'_>>| {
            let kind = described(value.get_ref());
            let message = format!("`{key}` must be an array of tables [[{}]], not {kind}", self.child(key));
            DocumentError::new(message, Some(value.span()))
        };
        let array = value.get_ref().as_array().ok_or_else(|| wrong(value))?;
        let table = |element: &'a Spanned<DeValue<'a>>| match element.get_ref().as_table() {
            Some(entries) => Ok(Table { entries, span: Some(element.span()), name: self.child(key) }),
            None => Err(wrong(element)),
        };
        array.iter().map(table).collect::<Result<_, _>>().map(Some)
    }

    fn child(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_owned() } else { format!("{}.{key}", self.name) }
    }

    /// The bytes of what `path` leads to (`beam.point_mass.2.mass`, elements counted from 1), or of
    /// the last part of the path that is there.
    pub fn locate(&self, path: &str) -> Option<Range<usize>> {
        let mut parts = path.split('.');
        let mut value = self.entry(parts.next()?)?;
        for part in parts {
            let next = match value.get_ref() {
                DeValue::Table(table) => {
                    table.iter().find(|(name, _)| name.get_ref() == part).map(|(_, value)| value)
                }
                DeValue::Array(array) => {
                    part.parse::<usize>().ok().and_then(|number| array.get(number.checked_sub(1)?))
                }
                _ => None,
            };
            match next {
                Some(next) => value = next,
                None => break,
            }
        }
        Some(value.span())
    }
}

fn described(value: &DeValue<'_>) -> &'static str {
    match value {
        DeValue::String(_) => "a string",
        DeValue::Integer(_) | DeValue::Float(_) => "a number",
        DeValue::Boolean(_) => "a boolean",
        DeValue::Datetime(_) => "a date",
        DeValue::Array(_) => "an array",
        DeValue::Table(_) => "a table",
    }
}

fn finite(key: &str, value: &Spanned<DeValue<'_>>) -> Result<Located<f64>, DocumentError> {
    let number = match value.get_ref() {
        DeValue::Float(float) => float.as_str().parse().ok(),
        // Decimal integers go straight to f64: they may be larger than an i64.
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|integer| integer as f64)
        }
        _ => None,
    };
    match number {
        Some(number) if f64::is_finite(number) => Ok(Located { value: number, span: value.span() }),
        Some(_) => Err(DocumentError::new(format!("`{key}` must be a finite number"), Some(value.span()))),
        None => {
            let message = format!("`{key}` must be a number, not {}", described(value.get_ref()));
            Err(DocumentError::new(message, Some(value.span())))
        }
    }
}
