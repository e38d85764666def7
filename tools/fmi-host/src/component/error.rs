//! Why a function of an FMU fails.

use std::ffi::NulError;

use crate::binding::Status;

/// Why an FMU's library does not do what it should.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// It cannot be loaded, or a function is missing.
    #[error("the library cannot be used: {}", with_reason(.0))]
    Load(#[from] libloading::Error),
    /// It is damaged, or for another kind of computer.
    #[error("{0}")]
    Damaged(String),
    /// A name with a zero byte.
    #[error("{0}")]
    Name(#[from] NulError),
    /// `fmi2Instantiate` returned NULL.
    #[error("the FMU refuses to be instantiated")]
    Instantiate,
    /// A function returned a status other than OK or warning.
    #[error("{function} returned {status:?}")]
    Call {
        /// The function.
        function: &'static str,
        /// What it returned.
        status: Status,
    },
    /// As many values as value references are needed.
    #[error("{references} value references, but {values} values")]
    Lengths {
        /// Number of value references.
        references: usize,
        /// Number of values.
        values: usize,
    },
    /// The library lacks a function, which is allowed where the model description does not promise it.
    #[error("the library has no function {0}")]
    Missing(&'static str),
    /// A saved state of another slave: its library would take it for one of its own.
    #[error("the saved state belongs to another slave")]
    ForeignState,
}

/// An error with what the system says of it.
fn with_reason(error: &dyn std::error::Error) -> String {
    error.source().map_or_else(|| error.to_string(), |reason| format!("{error}: {reason}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn why_a_library_cannot_be_loaded_is_told() {
        // SAFETY: there is none, so nothing of it runs.
        let missing = unsafe { libloading::Library::new("/there/is/no/library.so") }.map(drop);
        let said = Error::from(missing.unwrap_err()).to_string();
        assert!(said.contains("/there/is/no/library.so"), "{said}");
    }
}
