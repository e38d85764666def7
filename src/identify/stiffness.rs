//! Stiffness of the pin rig's contact from measured natural frequencies, with intervals that say how much of it they tell.

use std::f64::consts::TAU;

use nalgebra::{DMatrix, DVector};

use crate::fit::{Difference, FitError, Interval, Options, Parameter, Scale, fit};
use crate::system::{PinRig, PinRigModes, StructureError};

/// Bounds of the search, as factors of the rig's own values: far beyond what frequencies can tell.
const STIFFNESS: f64 = 1e3;
const MODULUS: f64 = 1.5;
/// Standard deviations from the middle of 95 % to its ends.
const TWO_SIDED_95: f64 = 1.96;
/// Modes beside the beam's own among which those are searched: pendulum, bounce.
const OTHERS: usize = 4;

/// A number with its interval at 95 %.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The value of the best fit.
    pub value: f64,
    /// `None` where the frequencies do not determine it at all.
    pub interval: Option<Interval>,
}

/// Stiffness of a contact that sticks.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactStiffness {
    /// Young's modulus of the beam (Pa).
    pub youngs_modulus: Estimate,
    /// k_t (N/m) at the rig's lever.
    pub tangential: Estimate,
    /// k_t r² (N m/rad): what the frequencies see of k_t, whatever the lever.
    pub rotational: Estimate,
    /// k_n (N/m). The frequencies hardly see it: its interval is what is known, the value is not.
    pub normal: Estimate,
    /// Natural frequencies of the fitted rig (Hz).
    pub frequencies: Vec<f64>,
}

/// What is measured, and how well.
#[derive(Debug, Clone, PartialEq)]
pub struct MeasuredFrequencies {
    /// The first natural frequencies of the beam's own modes (Hz), at least three.
    pub frequencies: Vec<f64>,
    /// Standard deviation of each, as a fraction.
    pub deviation: f64,
    /// Standard deviation of Young's modulus about that of the rig, as a fraction.
    pub modulus_deviation: f64,
}

/// The first `count` natural frequencies (Hz) of the rig's modes that are the beam's own.
///
/// # Errors
/// As [`PinRigModes::new`].
pub fn beam_frequencies(rig: &PinRig, count: usize) -> Result<Vec<f64>, StructureError> {
    let modes = PinRigModes::new(rig, count + OTHERS)?;
    let own = modes.beam_modes();
    Ok(own.into_iter().take(count).map(|mode| modes.angular_frequency()[mode] / TAU).collect())
}

/// Young's modulus, k_t and k_n of the rig from `measured` frequencies, from the values of `rig` on.
///
/// # Errors
/// Fewer than three frequencies, deviations that are not positive, a rig without modes.
pub fn contact_stiffness(
    rig: &PinRig,
    measured: &MeasuredFrequencies,
) -> Result<ContactStiffness, FitError<StructureError>> {
    let MeasuredFrequencies { frequencies, deviation, modulus_deviation } = measured;
    let count = frequencies.len();
    let positive = |value: &f64| *value > 0.0 && value.is_finite();
    if count < 3 || !frequencies.iter().chain([deviation, modulus_deviation]).all(positive) {
        return Err(FitError::InvalidInput("three positive frequencies and positive deviations are needed"));
    }
    let modulus = rig.beam.youngs_modulus;
    let residual = |values: &[f64], out: &mut [f64]| {
        let found = beam_frequencies(&with(rig, values), count)?;
        // A mode that is lost to the mass on its string is as far away as can be.
        let relative = |(k, f): (usize, &f64)| found.get(k).map_or(-1.0, |found| found / f - 1.0) / deviation;
        out.iter_mut().zip(frequencies.iter().enumerate().map(relative)).for_each(|(out, r)| *out = r);
        out[count] = (values[0] / modulus - 1.0) / modulus_deviation;
        Ok(())
    };
    let parameter = |start: f64, factor: f64| Parameter {
        start,
        lower: start / factor,
        upper: start * factor,
        scale: Scale::Logarithmic,
    };
    let [tangential, normal] = rig.stuck_stiffness;
    let parameters =
        [parameter(modulus, MODULUS), parameter(tangential, STIFFNESS), parameter(normal, STIFFNESS)];
    let options = Options { difference: Difference::Central, difference_step: 1e-4, ..Options::default() };
    let found = fit(residual, count + 1, &parameters, &options)?;
    let deviations = deviations(&found.jacobian, &found.parameters);
    let estimate = |k: usize, factor: f64| {
        let value = found.parameters[k];
        let Parameter { lower, upper, .. } = parameters[k];
        let interval = deviations[k].filter(|_| !found.uncertainty.at_bound[k]).map(|deviation| {
            let away = (TWO_SIDED_95 * deviation).exp();
            Interval { low: factor * (value / away).max(lower), high: factor * (value * away).min(upper) }
        });
        Estimate { value: factor * value, interval }
    };
    let lever = rig.beam.offset * rig.beam.offset;
    Ok(ContactStiffness {
        youngs_modulus: estimate(0, 1.0),
        tangential: estimate(1, 1.0),
        rotational: estimate(1, lever),
        normal: estimate(2, 1.0),
        frequencies: beam_frequencies(&with(rig, &found.parameters), count)
            .map_err(|error| FitError::NoStart { first: Some(error) })?,
    })
}

/// Standard deviations of the logarithms of `parameters`, of residuals that are measured in their own; `None` where nothing
/// is determined. The few residuals left over tell less of the noise than its own deviation.
fn deviations(jacobian: &[f64], parameters: &[f64]) -> [Option<f64>; 3] {
    if jacobian.is_empty() {
        return [None; 3];
    }
    let by = DMatrix::from_row_slice(jacobian.len() / 3, 3, jacobian);
    let by = by * DMatrix::from_diagonal(&DVector::from_column_slice(parameters));
    let covariance = (by.transpose() * by).try_inverse();
    std::array::from_fn(|k| {
        let deviation = covariance.as_ref()?[(k, k)].sqrt();
        deviation.is_finite().then_some(deviation)
    })
}

/// The rig with another modulus, k_t and k_n.
fn with(rig: &PinRig, values: &[f64]) -> PinRig {
    let mut rig = rig.clone();
    rig.beam.youngs_modulus = values[0];
    rig.stuck_stiffness = [values[1], values[2]];
    rig
}
