//! Why there is no diagnosis.

use crate::fit::compare::RefitError;

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DiagnoseError {
    /// An id that the catalogue does not have.
    #[error("there is no effect `{0}`")]
    UnknownEffect(String),
    /// The model as it is could not be refitted.
    #[error("{0}")]
    Refit(#[from] RefitError),
}
