//! The measured inputs and motions of a steady record as Fourier coefficients.

use nalgebra::Complex;

use crate::numeric::excited_harmonics;
use crate::numeric::fourier;

/// Largest fraction of an input (root-mean-square, of an excitation without its mean) that may lie outside the harmonics
/// kept: more is not noise.
const UNREPRESENTED: f64 = 0.1;

/// Displacement coefficients (m) of a measured time derivative of the order `order`, zero where the measurement shows
/// noise alone.
pub(super) fn displacement(
    values: &[f64],
    order: usize,
    periods: usize,
    harmonics: usize,
    angular_frequency: f64,
) -> Vec<f64> {
    let measured = fourier::from_samples(values, periods, harmonics);
    let mut moved = vec![0.0; measured.len()];
    for harmonic in excited_harmonics(values, periods) {
        if harmonic == 0 || harmonic > harmonics {
            continue;
        }
        let mut value = Complex::new(measured[2 * harmonic - 1], -measured[2 * harmonic]);
        for _ in 0..order {
            value /= Complex::new(0.0, harmonic as f64 * angular_frequency);
        }
        (moved[2 * harmonic - 1], moved[2 * harmonic]) = (value.re, -value.im);
    }
    moved
}

/// Coefficients of the harmonics that stand out of the noise of an input: of all others of the excitation a lightly
/// damped mode would make more than there is.
pub(super) fn input(
    name: &str,
    values: &[f64],
    periods: usize,
    harmonics: usize,
) -> Result<Vec<f64>, String> {
    let mut coefficients = fourier::from_samples(values, periods, harmonics);
    check_represented(name, values, periods, &coefficients)?;
    let excited = excited_harmonics(values, periods);
    for (place, coefficient) in coefficients.iter_mut().enumerate() {
        if !excited.contains(&place.div_ceil(2)) {
            *coefficient = 0.0;
        }
    }
    Ok(coefficients)
}

/// Refuses an input with a good part beyond the harmonics kept, as a wide multisine has or a record that
/// does not hold whole periods: the response to the rest of it would not be the response to it. Of a load its mean is
/// a part.
fn check_represented(name: &str, values: &[f64], periods: usize, kept: &[f64]) -> Result<(), String> {
    let mean = if name == "excitation" { kept[0] } else { 0.0 };
    let mean_square = values.iter().map(|f| (f - mean).powi(2)).sum::<f64>() / values.len() as f64;
    let represented = (kept[0] - mean).powi(2) + 0.5 * kept[1..].iter().map(|f| f * f).sum::<f64>();
    let share = (1.0 - represented / mean_square).max(0.0).sqrt();
    if share <= UNREPRESENTED {
        return Ok(());
    }
    Err(format!(
        "{:.0} % of `{name}` lies beyond harmonic {} of the period found ({periods} of it in the \
         record); a steady record holds whole periods, and of few harmonics",
        100.0 * share,
        kept.len() / 2
    ))
}
