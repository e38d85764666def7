//! The balance of a structure with its contacts, as equations for Newton's method.
//!
//! An [`assembly`] says what is balanced. A linear structure is condensed to its contacts by receptance
//! ([`condensed`], with [`transfer`]); a beam whose end moves inwards as it bends is solved mode by mode under the
//! force of its contact ([`beam`], with [`modal`]). Contacts may depend on a parameter ([`variation`]).

pub(crate) mod assembly;
pub(crate) mod beam;
pub(crate) mod condensed;
pub(crate) mod modal;
pub(crate) mod transfer;
pub(crate) mod variation;
