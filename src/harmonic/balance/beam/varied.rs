//! A contact on the beam that depends on the model's parameter.

use crate::contact::{ContactLaw, LoadedContact};
use crate::harmonic::balance::variation::Rebuild;

/// The contact as it is made of the parameter's value.
pub(super) struct Varied<'a> {
    pub rebuild: Rebuild<'a>,
    /// The law of the last value, with its normal load.
    pub built: Option<(Box<dyn ContactLaw>, f64)>,
    /// That value; NaN after a failure.
    pub value: f64,
    /// Least size of the parameter, by which steps of it are measured.
    pub least: f64,
    /// ∂force/∂parameter at fixed displacement.
    pub by_parameter: Vec<f64>,
}

impl std::fmt::Debug for Varied<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Varied").field("value", &self.value).finish_non_exhaustive()
    }
}

/// The contact there is.
pub(super) fn attached<'l>(
    given: &'l Option<LoadedContact>,
    varied: &'l Option<Varied>,
) -> Option<(&'l dyn ContactLaw, f64)> {
    match varied.as_ref().and_then(|varied| varied.built.as_ref()) {
        Some((law, normal_load)) => Some((law.as_ref(), *normal_load)),
        None => given.as_ref().map(|contact| (contact.law, contact.normal_load)),
    }
}
