//! The paper's way: motion expanded in a few modes of the beam at that amplitude, and its equation 3 balanced.

use nalgebra::{DMatrix, DVector};

use super::inversion::{Bending, Structure};
use super::{IdentificationError, SteadyMotion};
use crate::numeric::fourier::coefficient_count;
use crate::system::{Beam, ModalBeam};

/// A record in modal coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Expansion {
    /// Coefficients of each modal coordinate (m √kg).
    pub modes: Vec<Vec<f64>>,
    /// Largest over smallest singular value of the mode shapes at the sensors.
    pub conditioning: f64,
    /// Accelerations that the modes do not follow, as a fraction of the measured ones.
    pub unexplained: f64,
    /// Coefficients of the restoring force of the contact (N).
    pub force: Vec<f64>,
}

/// Expands `motion` in the first modes of `beam` (as many as it says; its rotational spring stands for the contact at this
/// amplitude) by the pseudo-inverse of equation 7, and balances equation 3 for `harmonics` of the contact's force.
///
/// Simpler than [`invert`](super::invert), and less exact: the modes left out carry a part of what a moment at the end does,
/// and the sensors do not see their own errors.
///
/// # Errors
/// More modes than sensors; channels that are not those of the beam's sensors; shapes that the sensors do not tell apart.
pub fn expand(
    beam: &Beam,
    motion: &SteadyMotion,
    harmonics: usize,
) -> Result<Expansion, IdentificationError> {
    let fail = |message: String| IdentificationError::Failed(message);
    let plain = Beam { static_correction: false, ..beam.clone() };
    let modal = ModalBeam::new(&plain).map_err(|error| fail(error.to_string()))?;
    let (sensors, count) = (modal.sensors.len(), modal.angular_frequency.len());
    if count > sensors {
        return Err(fail(format!("{sensors} sensors do not tell {count} modes")));
    }
    let structure = Structure::from(&modal);
    let bending = Bending::new(&structure, motion, harmonics)?;
    let shapes = DMatrix::from_fn(sensors, count, |k, i| modal.sensors[k].shape[i]);
    let svd = shapes.clone().svd(true, true);
    let conditioning = svd.singular_values.max() / svd.singular_values.min();
    let kept = coefficient_count(bending.kept);
    let (mut modes, mut left, mut all) = (vec![vec![0.0; kept]; count], 0.0, 0.0);
    for k in 1..kept {
        let of = |sensor: usize| motion.accelerations[sensor].get(k).copied().unwrap_or(0.0);
        let measured = DVector::from_fn(sensors, |sensor, _| of(sensor));
        let found = svd.solve(&measured, 1e-12).map_err(|why| fail(why.to_owned()))?;
        left += (&measured - &shapes * &found).norm_squared();
        all += measured.norm_squared();
        // Twice integrated.
        let omega = k.div_ceil(2) as f64 * motion.angular_frequency;
        modes.iter_mut().zip(found.iter()).for_each(|(mode, a)| mode[k] = -a / (omega * omega));
    }
    let force = balanced(&bending, &modal, beam, &modes, harmonics)?;
    Ok(Expansion { modes, conditioning, unexplained: (left / all).sqrt(), force })
}

/// The force that balances equation 3 of every mode, by least squares.
fn balanced(
    bending: &Bending,
    modal: &ModalBeam,
    beam: &Beam,
    modes: &[Vec<f64>],
    harmonics: usize,
) -> Result<Vec<f64>, IdentificationError> {
    let count = coefficient_count(harmonics);
    let slopes = bending.slopes(modes);
    let unit = |k: usize| {
        let mut force = vec![0.0; count];
        force[k] = 1.0;
        bending.modal_forces(&bending.structure.directions[0], &bending.samples(&force), &slopes).concat()
    };
    let own: Vec<Vec<f64>> = (0..count).map(unit).collect();
    let spring = beam.rotational_stiffness / (beam.offset * beam.offset);
    let mut excitation = bending.motion.excitation.clone();
    excitation.resize(modes[0].len(), 0.0);
    let mut right = Vec::new();
    for (i, mode) in modes.iter().enumerate() {
        let (natural, damping) = (modal.angular_frequency[i], modal.damping_ratio[i]);
        for k in 0..mode.len() {
            let omega = k.div_ceil(2) as f64 * bending.motion.angular_frequency;
            // The derivative of a cosine is a sine behind it, and the other way round.
            let velocity = match k {
                0 => 0.0,
                k if k % 2 == 1 => omega * mode[k + 1],
                k => -omega * mode[k - 1],
            };
            let bent: f64 = modes.iter().zip(&modal.contact_shape).map(|(q, c)| c * q[k]).sum();
            let inertia = (natural * natural - omega * omega) * mode[k] + 2.0 * damping * natural * velocity;
            let known =
                inertia - modal.excitation_shape[i] * excitation[k] - spring * modal.contact_shape[i] * bent;
            // Means are not measured.
            right.push(if k == 0 { 0.0 } else { known });
        }
    }
    let rows = right.len() / modes.len();
    let matrix =
        DMatrix::from_fn(
            right.len(),
            count,
            |row, k| {
                if row.is_multiple_of(rows) { 0.0 } else { own[k][row] }
            },
        );
    // The mean force is told by nothing here.
    let inner = matrix.columns(1, count - 1).into_owned();
    let found = inner
        .svd(true, true)
        .solve(&DVector::from_vec(right), 1e-12)
        .map_err(|why| IdentificationError::Failed(why.to_owned()))?;
    Ok(std::iter::once(0.0).chain(found.iter().copied()).collect())
}
