//! From forces at the ports to the modes, and from the modes to the ports.

use super::{Balance, mean_square, sized};
use crate::harmonic::HarmonicError;
use crate::harmonic::newton::system::Operating;

impl Balance {
    /// Makes the displacements of all ports from the modal coefficients, `u = b·q − γ ½ qᵀG q`.
    pub fn displace(&mut self) {
        let modes = self.modes();
        if self.ports.iter().any(|port| port.shortening != 0.0) {
            self.shorten();
        }
        self.moved.fill(0.0);
        for port in &self.ports {
            let moved = &mut self.moved[port.rows.clone()];
            for (moved, q) in moved.iter_mut().zip(self.q.chunks_exact(modes)) {
                *moved = port.shape.iter().zip(q).map(|(b, q)| b * q).sum();
            }
            if port.shortening != 0.0 {
                moved.iter_mut().zip(&self.shorter).for_each(|(u, shorter)| *u -= port.shortening * shorter);
            }
        }
    }

    /// Makes `½ qᵀG q`.
    fn shorten(&mut self) {
        let modes = self.modes();
        self.shorter.fill(0.0);
        for i in 0..modes {
            let row = &self.system.shortening[i * modes..(i + 1) * modes];
            let both = self.shape.iter_mut().zip(&mut self.mode);
            for ((turned, own), q) in both.zip(self.q.chunks_exact(modes)) {
                *turned = 0.5 * row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>();
                *own = q[i];
            }
            self.product.set_signal(&self.shape, self.wide / 2, self.harmonics);
            self.product.add_product(&self.mode, &mut self.shorter);
        }
    }

    /// Makes the weights W, multiplication by `w_i = b_i − γ (G q)_i` for every port.
    pub(super) fn weigh(&mut self) {
        let (modes, unknowns) = (self.modes(), self.residual.len());
        sized(&mut self.matrices.weights, unknowns, self.q.len());
        for port in &self.ports {
            for i in 0..modes {
                let columns =
                    self.matrices.weights.as_mut_slice()[i * unknowns..].chunks_mut(modes * unknowns);
                let columns = columns.map(|column| &mut column[port.rows.clone()]);
                let b = port.shape[i];
                if port.shortening == 0.0 {
                    for (k, column) in columns.enumerate() {
                        column.fill(0.0);
                        column[k] = b;
                    }
                    continue;
                }
                let row = &self.system.shortening[i * modes..(i + 1) * modes];
                for (weight, q) in self.shape.iter_mut().zip(self.q.chunks_exact(modes)) {
                    *weight = -port.shortening * row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>();
                }
                self.shape[0] += b;
                self.product.set_signal(&self.shape, port.rows.len() / 2, self.harmonics);
                self.product.write(columns);
            }
        }
    }

    /// Projection of the stacked forces, `P[T w_i]` and the rest, with the weights made last.
    pub(super) fn project(&self, forces: &[f64], out: &mut [f64]) {
        let modes = self.modes();
        for (place, column) in self.matrices.weights.as_slice().chunks_exact(forces.len()).enumerate() {
            let terms = forces.iter().zip(column).zip(&self.mean_squares);
            let sum: f64 = terms.map(|((t, w), mean_square)| mean_square * t * w).sum();
            out[place] = sum / mean_square(place / modes);
        }
    }

    /// q under the forces of the last evaluation, and the displacements.
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
        self.displace();
        Ok(())
    }
}
