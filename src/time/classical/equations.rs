//! The equations of motion of a system in equal steps: accelerations of its modes and ports.

use nalgebra::{Matrix2, Vector2};

use super::{Buffers, ClassicalSteps, SteppedMotion};
use crate::time::plant::{ModalPort, dot};

impl ClassicalSteps {
    /// Displacements (m) and velocities (m/s) of all ports where `motion` is.
    pub fn motions_of_ports(&mut self, motion: &SteppedMotion, out: &mut Vec<(f64, f64)>) {
        let mut buffers = std::mem::take(&mut self.buffers);
        buffers.q.copy_from_slice(&motion.displacement);
        buffers.v.copy_from_slice(&motion.velocity);
        self.look(&mut buffers);
        out.clone_from(&buffers.motions);
        self.buffers = buffers;
    }

    /// Accelerations (m/s²) of all ports where `motion` is, under a force (N) on the driven ports and forces from `outside`.
    pub fn accelerations_of_ports(
        &mut self,
        motion: &SteppedMotion,
        force: f64,
        outside: &[f64],
        out: &mut Vec<f64>,
    ) {
        let mut buffers = std::mem::take(&mut self.buffers);
        buffers.outside.clear();
        buffers.outside.extend(outside);
        buffers.q.copy_from_slice(&motion.displacement);
        buffers.v.copy_from_slice(&motion.velocity);
        let mut modal = std::mem::take(&mut buffers.rates[0][1]);
        self.accelerations(&motion.memory, force, &mut buffers, &mut modal);
        out.clear();
        let quadratic = dot(&buffers.pull_rate, &buffers.v);
        out.extend(
            self.ports.iter().map(|port| port.along(&modal, &buffers.pull) - port.shortening * quadratic),
        );
        buffers.rates[0][1] = modal;
        self.buffers = buffers;
    }

    /// Displacements and velocities of all ports at `q` and `v`, and G q, G v.
    pub(super) fn look(&self, buffers: &mut Buffers) {
        let Buffers { q, v, pull, pull_rate, motions, .. } = buffers;
        if !self.shortening.is_empty() {
            let size = q.len();
            for (i, row) in self.shortening.chunks_exact(size).enumerate() {
                (pull[i], pull_rate[i]) = (dot(row, q), dot(row, v));
            }
        }
        motions.iter_mut().zip(&self.ports).for_each(|(motion, port)| *motion = port.motion(q, v, pull));
    }

    pub(super) fn accelerations(&self, memory: &[f64], force: f64, buffers: &mut Buffers, out: &mut [f64]) {
        self.look(buffers);
        self.forces(memory, buffers);
        let Buffers { q, v, pull, pull_rate, forces, .. } = buffers;
        for (i, out) in out.iter_mut().enumerate() {
            let omega = self.angular_frequency[i];
            let own = omega * omega * q[i] + 2.0 * self.damping_ratio[i] * omega * v[i];
            *out = force * self.driven[i] - own;
        }
        for (port, force) in self.ports.iter().zip(forces.iter()).filter(|(_, force)| **force != 0.0) {
            port.push(-force, pull, out);
        }
        let Some((places, mass)) = &self.inertia else { return };
        // ü = J q̈ − γ q̇ᵀG q̇, and q̈ = r − Jᵀ M ü.
        let ports = places.map(|place| &self.ports[place]);
        let quadratic = dot(pull_rate, v);
        let free = ports.map(|port| port.along(out, pull) - port.shortening * quadratic);
        let yielding = Matrix2::from_fn(|i, j| ports[i].across(ports[j], pull));
        let whole = Matrix2::identity() + yielding * mass;
        let moved = whole.lu().solve(&Vector2::from(free)).unwrap_or(Vector2::repeat(f64::NAN));
        let inertial = mass * moved;
        ports.iter().zip(inertial.iter()).for_each(|(port, force)| port.push(-force, pull, out));
    }
}

impl ModalPort {
    /// Adds what a force (N) at the port does to the modes; `pull` is G q.
    fn push(&self, force: f64, pull: &[f64], out: &mut [f64]) {
        for ((out, b), g) in out.iter_mut().zip(&self.row).zip(pull) {
            *out += force * (b - self.shortening * g);
        }
    }

    /// `J J'ᵀ` with another port.
    fn across(&self, other: &Self, pull: &[f64]) -> f64 {
        let lever = |port: &Self, i: usize| port.row[i] - port.shortening * pull[i];
        (0..pull.len()).map(|i| lever(self, i) * lever(other, i)).sum()
    }
}
