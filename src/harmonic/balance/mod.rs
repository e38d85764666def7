//! The balance of a system with its elements, as equations for Newton's method.
//!
//! An [`assembly`] says what is balanced: a system under its excitation. Where its ports are linear it is [`condensed`] to
//! them by receptance ([`transfer`]); where one shortens with the motion, or has a flexibility in series, it keeps its
//! [`modal`] coordinates. In both a law is [`attached`] to the unknowns of its port, and [`equivalent`] linearisation
//! gives a start. A system may depend on a parameter
//! ([`varied`]).

pub(crate) mod assembly;
pub(crate) mod attached;
pub(crate) mod condensed;
mod equivalent;
pub(crate) mod modal;
pub(crate) mod transfer;
pub(crate) mod varied;

use super::newton::system::PeriodicSystem;
use super::{CurveSettings, HarmonicError};
use assembly::Assembly;
use condensed::Condensed;
use modal::Balance;

/// The equations of an assembly.
pub(crate) fn balance_of(
    assembly: &Assembly,
    settings: &CurveSettings,
) -> Result<Box<dyn PeriodicSystem>, HarmonicError> {
    assembly.check()?;
    settings.check()?;
    assembly.check_excitation(settings)?;
    if assembly.is_condensed() {
        return Ok(Box::new(Condensed::new(assembly, settings, 0.0)?));
    }
    Ok(Box::new(Balance::new(assembly, settings.harmonics, settings.method)?))
}
