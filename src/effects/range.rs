//! The range of a parameter in a fit.

use crate::vocabulary::Scale;

/// Bounds and starting values of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// Smallest value, legal itself.
    pub lower: f64,
    /// Largest value, legal itself.
    pub upper: f64,
    /// How a fit steps.
    pub scale: Scale,
    /// Values to start from, each in a fit of its own; both signs where both are possible. The parameters of
    /// an effect have equally many.
    pub starts: Vec<f64>,
}

/// A range from zero to `upper` with starts at fractions of it.
pub(super) fn from_zero(upper: f64, fractions: &[f64]) -> Range {
    Range { lower: 0.0, upper, scale: Scale::Linear, starts: fractions.iter().map(|s| s * upper).collect() }
}

/// A range `±size` with starts at `±fraction·size`.
pub(super) fn both_signs(size: f64, fraction: f64) -> Range {
    Range { lower: -size, upper: size, scale: Scale::Linear, starts: vec![fraction * size, -fraction * size] }
}

/// A range of magnitudes from `lower` to `upper`, both above zero.
pub(super) fn magnitudes(lower: f64, upper: f64, starts: &[f64]) -> Range {
    Range { lower, upper, scale: Scale::Logarithmic, starts: starts.to_vec() }
}
