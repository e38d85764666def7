//! From forces at the ports to the modes, and from the modes to the ports.

use super::{Balance, mean_square};
use crate::harmonic::HarmonicError;
use crate::harmonic::newton::system::Operating;
use crate::numeric::fourier::multiplication;

impl Balance {
    /// Writes the displacements of all ports and the weights for the modal coefficients.
    pub fn weigh(&mut self) {
        let (modes, unknowns) = (self.modes(), self.residual.len());
        self.moved.fill(0.0);
        for port in &self.ports {
            let (rows, moved) = (port.rows.clone(), &mut self.moved[port.rows.clone()]);
            for i in 0..modes {
                let b = port.shape[i];
                if port.shortening == 0.0 {
                    for (k, moved) in moved.iter_mut().take(self.count).enumerate() {
                        let place = k * modes + i;
                        self.matrices.weights.as_mut_slice()[place * unknowns + rows.start + k] = b;
                        *moved += b * self.q[place];
                    }
                    continue;
                }
                // w_i = b_i − γ (G q)_i, and u = ½ Σ (w_i + b_i) q_i.
                self.shape.fill(0.0);
                self.shape[0] = b;
                let row = &self.system.shortening[i * modes..(i + 1) * modes];
                for (s, q) in self.shape.iter_mut().zip(self.q.chunks_exact(modes)) {
                    *s -= port.shortening * row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>();
                }
                let block = &mut self.block[..rows.len() * self.count];
                multiplication(&self.shape, self.harmonics, rows.len(), block);
                for (k, column) in block.chunks_exact(rows.len()).enumerate() {
                    let place = k * modes + i;
                    let weights = &mut self.matrices.weights.as_mut_slice()[place * unknowns..][rows.clone()];
                    weights.copy_from_slice(column);
                    let q = 0.5 * self.q[place];
                    moved.iter_mut().zip(column).for_each(|(u, w)| *u += w * q);
                    moved[k] += b * q;
                }
            }
        }
    }

    /// Projection of the stacked forces, `P[T w_i]` and the rest, with the weights of the last evaluation.
    pub(super) fn project(&self, forces: &[f64], out: &mut [f64]) {
        let modes = self.modes();
        for (place, column) in self.matrices.weights.as_slice().chunks_exact(forces.len()).enumerate() {
            let terms = forces.iter().zip(column).zip(&self.mean_squares);
            let sum: f64 = terms.map(|((t, w), mean_square)| mean_square * t * w).sum();
            out[place] = sum / mean_square(place / modes);
        }
    }

    /// q under the forces of the last evaluation, and the weights.
    pub(super) fn respond(&mut self, at: &Operating) -> Result<(), HarmonicError> {
        let modes = self.modes();
        self.tension.fill(0.0);
        for port in self.ports.iter().filter(|port| port.shortening != 0.0) {
            let forces = &self.forces[port.rows.clone()];
            self.tension.iter_mut().zip(forces).for_each(|(t, force)| *t += port.shortening * force);
        }
        let singular = HarmonicError::InvalidInput("the modal equations are singular at this frequency");
        if !self.equations.set(at, &self.tension) {
            return Err(singular);
        }
        for (k, right) in self.right.chunks_exact_mut(modes).enumerate() {
            let excitation = at.level * self.waveform[k] + at.parameter * self.second[k];
            right.iter_mut().zip(&self.system.driven).for_each(|(r, e)| *r = excitation * e);
            for port in &self.ports {
                let force = self.forces[port.rows.start + k];
                right.iter_mut().zip(&port.shape).for_each(|(r, b)| *r -= force * b);
            }
        }
        if !self.equations.solve(&self.right, &mut self.q) {
            return Err(singular);
        }
        self.weigh();
        Ok(())
    }
}
