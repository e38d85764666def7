//! Compliances as sums over the undamped modes.

use nalgebra::Complex;

use super::compliance::{Compliance, Rows, Singular};
use crate::system::Row;
use crate::system::linear::{LinearStructure, dense};

/// Largest structure whose modes are computed for the modal way: preparing it grows with the cube.
const MOST_MODAL: usize = 300;

/// Smallest ratio of two squared natural frequencies: the lower is known to rounding of the higher.
const WIDEST_SPREAD: f64 = 1e-8;

/// A structure in its own modal coordinates.
#[derive(Debug, Clone)]
pub(super) struct Modal {
    /// ωᵣ².
    square: Vec<f64>,
    /// cᵣ = φᵣᵀ C φᵣ.
    rate: Vec<f64>,
    /// Participation of the modes in the contacts, then in the outputs, one point after the other.
    points: Vec<f64>,
    /// Participation of the modes in the excitation.
    excitation: Vec<f64>,
    contacts: usize,
    /// Of each mode the flexibility and its derivatives by the two factors, real and imaginary parts apart.
    flexibility: Vec<[f64; 6]>,
}

impl Modal {
    /// The modes, if there are not too many and they diagonalise the damping.
    pub(super) fn new(structure: &LinearStructure) -> Option<Self> {
        let size = structure.size;
        if size > MOST_MODAL {
            return None;
        }
        let modes = structure.natural_modes().ok()?;
        let square: Vec<f64> = modes.angular_frequency.iter().map(|omega| omega * omega).collect();
        let highest = square.last()?;
        if square.iter().any(|square| *square > 0.0 && *square < WIDEST_SPREAD * highest) {
            return None;
        }
        let damping = modes.shapes.tr_mul(&(dense(size, &structure.damping) * &modes.shapes));
        let rounding = 8.0 * f64::EPSILON * size as f64 * damping.amax();
        let off_diagonal =
            (0..size).flat_map(|j| (0..j).map(move |i| (i, j))).any(|place| damping[place].abs() > rounding);
        if off_diagonal {
            return None;
        }
        let participation = |row: &Row| -> Vec<f64> {
            let factor = |mode| row.iter().map(|(i, factor)| factor * modes.shapes[(*i, mode)]).sum();
            (0..size).map(factor).collect()
        };
        let outputs = structure.outputs.iter().map(|output| &output.row);
        Some(Self {
            square,
            rate: damping.diagonal().iter().copied().collect(),
            points: structure.contacts.iter().chain(outputs).flat_map(participation).collect(),
            excitation: participation(&structure.excitation),
            contacts: structure.contacts.len(),
            flexibility: vec![[0.0; 6]; size],
        })
    }

    pub(super) fn evaluate(
        &mut self,
        damping: Complex<f64>,
        inertia: Complex<f64>,
        rows: Rows,
        out: &mut Compliance,
    ) -> Result<(), Singular> {
        self.invert(damping, inertia)?;
        let modes = self.square.len();
        let contacts = self.contacts;
        for (p, point) in self.points.chunks_exact(modes).enumerate() {
            if p == contacts && rows == Rows::Contacts {
                break;
            }
            // Among the contacts the compliances are symmetric.
            let known = if p < contacts { p } else { 0 };
            for k in 0..known {
                out.value[(p, k)] = out.value[(k, p)];
                out.by_damping[(p, k)] = out.by_damping[(k, p)];
                out.by_inertia[(p, k)] = out.by_inertia[(k, p)];
            }
            for k in known..=contacts {
                let force = if k < contacts { &self.points[k * modes..][..modes] } else { &self.excitation };
                let sum = weighted_sum(point, force, &self.flexibility);
                out.value[(p, k)] = Complex::new(sum[0], sum[1]);
                out.by_damping[(p, k)] = Complex::new(sum[2], sum[3]);
                out.by_inertia[(p, k)] = Complex::new(sum[4], sum[5]);
            }
        }
        Ok(())
    }

    /// 1/dᵣ with dᵣ = ωᵣ² + damping · cᵣ + inertia, and its derivatives −cᵣ/dᵣ² and −1/dᵣ².
    fn invert(&mut self, damping: Complex<f64>, inertia: Complex<f64>) -> Result<(), Singular> {
        let (damping_size, inertia_size) = (damping.norm(), inertia.norm());
        let modes = self.square.iter().zip(&self.rate).zip(&mut self.flexibility);
        for ((square, rate), flexibility) in modes {
            let stiffness = damping * rate + inertia + square;
            let norm = stiffness.norm_sqr();
            let terms = square + damping_size * rate.abs() + inertia_size;
            let rounding = 4.0 * f64::EPSILON * terms;
            if norm <= rounding * rounding {
                return Err(Singular);
            }
            let inverse = stiffness.conj() / norm;
            let by_inertia = -(inverse * inverse);
            *flexibility = [
                inverse.re,
                inverse.im,
                rate * by_inertia.re,
                rate * by_inertia.im,
                by_inertia.re,
                by_inertia.im,
            ];
        }
        Ok(())
    }
}

fn weighted_sum(point: &[f64], force: &[f64], flexibility: &[[f64; 6]]) -> [f64; 6] {
    let mut sum = [0.0; 6];
    for ((b, e), flexibility) in point.iter().zip(force).zip(flexibility) {
        let weight = b * e;
        for (sum, part) in sum.iter_mut().zip(flexibility) {
            *sum += weight * part;
        }
    }
    sum
}
