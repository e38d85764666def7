//! Contacts that depend on a parameter: made anew for each value, differentiated by differences.

use crate::contact::ContactLaw;
use crate::harmonic::HarmonicError;

/// Makes a contact of the value of the model's parameter.
pub(crate) type Rebuild<'a> = Box<dyn FnMut(f64) -> Result<(Box<dyn ContactLaw>, f64), HarmonicError> + 'a>;

/// Writes a force at a value of the parameter.
pub(crate) type ForceAt<'f> = dyn FnMut(f64, &mut Vec<f64>) -> Result<(), HarmonicError> + 'f;

/// Writes the change of a force with the parameter; `force` writes that at a value, last of all at `parameter`.
/// Steps take the parameter for no smaller than `least`.
///
/// Forces have kinks where a contact begins to slip, which a response reaches just there. A difference across
/// one is no derivative of either side, so the step shrinks until none is in sight.
pub(crate) fn differentiate(
    parameter: f64,
    least: f64,
    by: &mut [f64],
    force: &mut ForceAt,
) -> Result<(), HarmonicError> {
    const LONGEST: f64 = 1e-5;
    const SHORTEST: f64 = 1e-9;
    /// Second difference over first that is a kink's, and what rounding makes of the force.
    const KINK: f64 = 1e-3;
    const ROUNDING: f64 = 1e-13;
    let size = parameter.abs().max(least);
    let size = if size > 0.0 { size } else { 1.0 };
    let mut step = LONGEST * size;
    let [mut above, mut below, mut here] = [const { Vec::new() }; 3];
    loop {
        force(parameter + step, &mut above)?;
        force(parameter - step, &mut below)?;
        force(parameter, &mut here)?;
        let (mut change, mut bend, mut largest) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (((by, above), below), here) in by.iter_mut().zip(&above).zip(&below).zip(&here) {
            change = change.max((above - below).abs());
            bend = bend.max((above - 2.0 * here + below).abs());
            largest = largest.max(here.abs());
            *by = (above - below) / (2.0 * step);
        }
        if bend <= KINK * change + ROUNDING * largest || step <= SHORTEST * size {
            return Ok(());
        }
        step *= 0.1;
    }
}
