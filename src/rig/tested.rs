//! What a test gives.

use crate::data::Record;

/// A record as it is shown, and the truth beside it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tested {
    /// As a laboratory would take it.
    pub record: Record,
    /// The contact's own `displacement`, `velocity` and `force` at the same times, without any fault of the sensors; `None` of a
    /// beam without a contact.
    pub contact: Option<Record>,
}
