//! Features of a residual, as numbers: the input of signatures.

/// Features of the measurements and of the residual of the refitted model. `None` where the records at hand
/// cannot show it. Fractions and correlations are plain numbers.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Features {
    /// Fraction of the stroke over which the measured force stays near zero after each reversal.
    pub plateau_fraction: Option<f64>,
    /// Slope of the measured force in slip over its slope in stick.
    pub slip_slope_fraction: Option<f64>,
    /// How gradually slip sets in: fall of the slope from the lower half of the rise to the upper half, as a
    /// fraction of it; near zero for a sharp corner.
    pub corner_fraction: Option<f64>,
    /// Difference of the upper and lower plateau of the loop over their mean.
    pub loop_asymmetry: Option<f64>,
    /// Relative change of the loop's height per metre of slip within records (1/m).
    pub height_per_slip: Option<f64>,
    /// Relative change of the loop's height from the slowest to the fastest record.
    pub height_by_speed: Option<f64>,
    /// Correlation of the loop's height with the measured normal load.
    pub height_by_load: Option<f64>,
    /// Correlation of the residual with the relative velocity.
    pub residual_by_velocity: Option<f64>,
    /// Correlation of the residual with the cube of the relative displacement, the linear part removed.
    pub residual_by_cube: Option<f64>,
    /// Mean of the residual over its root mean square.
    pub residual_mean: Option<f64>,
    /// Correlation of the residual with the time derivative of the measurement.
    pub residual_by_rate: Option<f64>,
    /// Correlation of the residual with the measurement itself.
    pub residual_by_value: Option<f64>,
    /// Fraction of the residual's power in even harmonics.
    pub even_harmonics: Option<f64>,
    /// Exponent `d ln ζ/d ln A` of the residual damping against amplitude.
    pub damping_exponent: Option<f64>,
    /// Relative change of the resonance's frequency from the lowest to the highest level that the model does not show.
    pub frequency_by_level: Option<f64>,
    /// Relative error of the resonance's frequency that is the same at every level.
    pub frequency_error: Option<f64>,
    /// Correlation of the residual of the normal force with the normal velocity.
    pub normal_residual_by_velocity: Option<f64>,
    /// Correlation of the residual of the normal force with the cube of the normal displacement.
    pub normal_residual_by_cube: Option<f64>,
}
