//! Poles from frequency responses: the least-squares complex-frequency method (Guillaume et al. 2003, one exciter).
//!
//! Every response is a fraction of two polynomials in `z = e^{iωΔt}` with the denominator in common. Poles that stay where
//! they are while the order grows are the structure's.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};

use super::{FrequencyResponse, IdentificationError};

/// Changes of frequency and damping ratio from one order to the next that a pole of the structure may make.
const SAME_FREQUENCY: f64 = 0.005;
const SAME_DAMPING: f64 = 0.3;
/// Orders in a row that a pole must last.
const LASTS: usize = 4;

/// A mode of the linear structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Pole {
    /// Natural frequency (Hz).
    pub frequency: f64,
    /// Damping ratio (1).
    pub damping_ratio: f64,
    /// Residue of every response in the unit of response over force times 1/s: the mode's shape, complex.
    pub residues: Vec<Complex<f64>>,
}

/// The poles in `band` (Hz) that denominators of up to `order` agree on, the lowest first.
///
/// # Errors
/// Responses with different lines, fewer lines than unknowns, no pole that lasts.
pub fn poles(
    responses: &[FrequencyResponse],
    band: [f64; 2],
    order: usize,
) -> Result<Vec<Pole>, IdentificationError> {
    let fail = |message: &str| Err(IdentificationError::Failed(message.to_owned()));
    let Some(first) = responses.first() else { return fail("there is no frequency response") };
    if responses.iter().any(|response| response.frequencies != first.frequencies) {
        return fail("the frequency responses have different lines");
    }
    let inside = |k: &usize| (band[0]..=band[1]).contains(&first.frequencies[*k]);
    let lines: Vec<usize> = (0..first.frequencies.len()).filter(inside).collect();
    if lines.len() < 2 * order || order < 2 + LASTS {
        return fail("the band has fewer lines than the poles need: longer segments or a lower order");
    }
    // The band is the whole circle's half: what lies outside it is left to the numerator.
    let turn = std::f64::consts::PI / (band[1] - band[0]);
    let z: Vec<Complex<f64>> =
        lines.iter().map(|k| Complex::from_polar(1.0, turn * (first.frequencies[*k] - band[0]))).collect();
    let mut lasting: Vec<(Complex<f64>, usize)> = Vec::new();
    for denominator in 2..=order {
        let found: Vec<Complex<f64>> = roots(responses, &lines, &z, denominator)?
            .into_iter()
            .map(|root| {
                let log = root.ln();
                // Decay per second and angular frequency.
                Complex::new(log.re / turn, log.im / turn + band[0]) * TAU
            })
            .filter(|pole| pole.re < 0.0 && (band[0]..=band[1]).contains(&(pole.im / TAU)))
            .collect();
        let age = |pole: &Complex<f64>| {
            lasting
                .iter()
                .filter(|(known, _)| is_same(*known, *pole))
                .map(|(_, age)| age + 1)
                .max()
                .unwrap_or(0)
        };
        lasting = found.iter().map(|pole| (*pole, age(pole))).collect();
    }
    let mut stable: Vec<Complex<f64>> =
        lasting.into_iter().filter(|(_, age)| *age >= LASTS).map(|(pole, _)| pole).collect();
    stable.sort_by(|a, b| a.norm().total_cmp(&b.norm()));
    if stable.is_empty() {
        return fail("no pole lasts while the order grows: the responses show no resonance in the band");
    }
    let residues: Vec<Vec<Complex<f64>>> =
        responses.iter().map(|response| residues(response, &lines, &stable)).collect::<Result<_, _>>()?;
    let pole = |(k, pole): (usize, &Complex<f64>)| Pole {
        frequency: pole.norm() / TAU,
        damping_ratio: -pole.re / pole.norm(),
        residues: residues.iter().map(|of| of[k]).collect(),
    };
    Ok(stable.iter().enumerate().map(pole).collect())
}

fn is_same(a: Complex<f64>, b: Complex<f64>) -> bool {
    let (ratio_a, ratio_b) = (-a.re / a.norm(), -b.re / b.norm());
    (a.norm() / b.norm() - 1.0).abs() < SAME_FREQUENCY && (ratio_a - ratio_b).abs() < SAME_DAMPING * ratio_b
}

/// Roots of the denominator of `order` that fits all responses best; complex coefficients, since the band does not begin at
/// zero.
fn roots(
    responses: &[FrequencyResponse],
    lines: &[usize],
    z: &[Complex<f64>],
    order: usize,
) -> Result<Vec<Complex<f64>>, IdentificationError> {
    let count = order + 1;
    let power = |i: usize, k: usize| z[i].powu(k as u32);
    let basis = DMatrix::from_fn(z.len(), count, power);
    let mut reduced = DMatrix::<Complex<f64>>::zeros(count, count);
    for response in responses {
        let weights: Vec<f64> = weights(response, lines);
        let numerator = DMatrix::from_fn(z.len(), count, |i, k| basis[(i, k)] * Complex::from(weights[i]));
        let denominator = DMatrix::from_fn(z.len(), count, |i, k| -response.h1[lines[i]] * numerator[(i, k)]);
        let (r, s) = (numerator.adjoint() * &numerator, numerator.adjoint() * &denominator);
        let solved = r
            .lu()
            .solve(&s)
            .ok_or_else(|| IdentificationError::Failed("the lines tell no poles".to_owned()))?;
        reduced += denominator.adjoint() * &denominator - s.adjoint() * solved;
    }
    // The highest coefficient is one.
    let square = reduced.view((0, 0), (order, order)).into_owned();
    let right = -reduced.view((0, order), (order, 1)).into_owned();
    let found = square
        .lu()
        .solve(&right)
        .ok_or_else(|| IdentificationError::Failed("the lines tell no poles".to_owned()))?;
    let companion = DMatrix::from_fn(order, order, |i, k| {
        let below = if i == k + 1 { 1.0 } else { 0.0 };
        if k + 1 == order { -found[(i, 0)] } else { Complex::from(below) }
    });
    let eigenvalues = companion.schur().eigenvalues();
    Ok(eigenvalues.map(|values: DVector<Complex<f64>>| values.as_slice().to_vec()).unwrap_or_default())
}

/// One over the standard deviation of the response at each line.
fn weights(response: &FrequencyResponse, lines: &[usize]) -> Vec<f64> {
    let error = response.relative_error();
    let largest = response.h1.iter().map(|h| h.norm()).fold(0.0, f64::max);
    let deviation = |k: &usize| (error[*k] * response.h1[*k].norm()).max(1e-9 * largest);
    lines.iter().map(|k| 1.0 / deviation(k)).collect()
}

/// Residues of `poles` in a response, with a residual mass and a residual stiffness beside them.
fn residues(
    response: &FrequencyResponse,
    lines: &[usize],
    poles: &[Complex<f64>],
) -> Result<Vec<Complex<f64>>, IdentificationError> {
    let weights = weights(response, lines);
    let columns = 2 * poles.len() + 4;
    let i = Complex::new(0.0, 1.0);
    // Real unknowns: real and imaginary parts of residues, real and imaginary parts of both residuals.
    let entry = |line: usize, column: usize| {
        let s = i * TAU * response.frequencies[lines[line]];
        let part = if column.is_multiple_of(2) { Complex::from(1.0) } else { i };
        match poles.get(column / 2) {
            Some(pole) => part / (s - pole) + part.conj() / (s - pole.conj()),
            None if column < 2 * poles.len() + 2 => part,
            None => part / (s * s),
        }
    };
    let matrix = DMatrix::from_fn(2 * lines.len(), columns, |row, column| {
        let value = entry(row / 2, column) * weights[row / 2];
        if row.is_multiple_of(2) { value.re } else { value.im }
    });
    let right = DVector::from_fn(2 * lines.len(), |row, _| {
        let value = response.h1[lines[row / 2]] * weights[row / 2];
        if row.is_multiple_of(2) { value.re } else { value.im }
    });
    // Columns of one length: their units differ by ten orders.
    let lengths: Vec<f64> = matrix.column_iter().map(|column| column.norm().max(f64::MIN_POSITIVE)).collect();
    let scaled = DMatrix::from_fn(matrix.nrows(), columns, |r, c| matrix[(r, c)] / lengths[c]);
    let found = scaled
        .svd(true, true)
        .solve(&right, 1e-12)
        .map_err(|why| IdentificationError::Failed(why.to_owned()))?;
    Ok((0..poles.len())
        .map(|k| Complex::new(found[2 * k] / lengths[2 * k], found[2 * k + 1] / lengths[2 * k + 1]))
        .collect())
}

#[cfg(test)]
mod tests {
    use super::poles;
    use crate::identify::frequency_response_of;
    use std::f64::consts::TAU;

    /// Three modes excited by white noise, stepped exactly for a force held between samples, with noise on the responses.
    #[test]
    fn modes_of_random_structures_are_found() {
        let mut random = fastrand::Rng::with_seed(3);
        for _ in 0..5 {
            let modes: Vec<(f64, f64, [f64; 2])> = [52.0, 160.0, 330.0]
                .iter()
                .map(|f| {
                    let shape = [0.5 + random.f64(), -1.0 + 0.8 * random.f64()];
                    (f * (0.95 + 0.1 * random.f64()), 0.002 + 0.008 * random.f64(), shape)
                })
                .collect();
            let rate = 2048.0;
            let count = 1 << 17;
            let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
            let force: Vec<f64> = (0..count).map(|_| normal()).collect();
            let mut responses = vec![vec![0.0; count]; 2];
            for (frequency, damping, shape) in &modes {
                let omega = TAU * frequency;
                let (decay, turned) = (damping * omega, omega * (1.0 - damping * damping).sqrt());
                let (e, (sin, cos)) = ((-decay / rate).exp(), (turned / rate).sin_cos());
                let (mut q, mut v) = (0.0, 0.0);
                for k in 0..count {
                    let acceleration = force[k] - 2.0 * decay * v - omega * omega * q;
                    responses.iter_mut().zip(shape).for_each(|(r, s)| r[k] += s * acceleration);
                    let (rest, static_q) = (q - force[k] / (omega * omega), force[k] / (omega * omega));
                    let slope = (v + decay * rest) / turned;
                    q = static_q + e * (rest * cos + slope * sin);
                    v = e * (turned * (slope * cos - rest * sin) - decay * (rest * cos + slope * sin));
                }
            }
            for response in &mut responses {
                let size = (response.iter().map(|x| x * x).sum::<f64>() / count as f64).sqrt();
                response.iter_mut().for_each(|x| *x += 0.01 * size * normal());
            }
            let found: Vec<_> =
                responses.iter().map(|r| frequency_response_of(&force, r, rate, 8192).unwrap()).collect();
            let found = poles(&found, [20.0, 450.0], 30).unwrap();
            assert_eq!(found.len(), 3);
            for (found, (frequency, damping, shape)) in found.iter().zip(&modes) {
                assert!((found.frequency / frequency - 1.0).abs() < 1e-3);
                assert!((found.damping_ratio / damping - 1.0).abs() < 0.15);
                let ratio = found.residues[1] / found.residues[0];
                assert!((ratio.re / (shape[1] / shape[0]) - 1.0).abs() < 0.05);
            }
        }
    }
}
