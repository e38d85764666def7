//! Which entry of a model cannot be what it is, and why.

use std::fmt;

/// Why a parameter, or another entry of a model, cannot be what it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ParameterError {
    /// Path of the entry, elements of arrays counted from 1: `beam.point_mass.2.mass`.
    pub path: String,
    /// What is wrong, in one sentence.
    pub message: String,
    /// What would be right, if there is more to say.
    pub help: Option<String>,
}

impl ParameterError {
    pub(super) fn new(path: impl Into<String>, message: impl Into<String>) -> Self {
        ParameterError { path: path.into(), message: message.into(), help: None }
    }

    pub(super) fn with_help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

impl fmt::Display for ParameterError {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{}: {}", self.path, self.message)?;
        match &self.help {
            Some(help) => write!(formatter, " ({help})"),
            None => Ok(()),
        }
    }
}

impl std::error::Error for ParameterError {}
