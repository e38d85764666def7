//! What the harmonics left out would change.

use nalgebra::Complex;

use super::{Acting, Balance};
use crate::harmonic::Point;
use crate::harmonic::newton::system::{Operating, PeriodicSystem};

impl Balance {
    /// Whether a contact has two directions, or masses move with ports.
    pub(super) fn has_two_directions(&self) -> bool {
        let two = |acting: &Acting| matches!(acting, Acting::SlipSlap { .. } | Acting::Inertia { .. });
        self.acting.iter().any(two)
    }

    /// Estimated error of the nodes from harmonics above H, as a fraction of the amplitude of the node it is
    /// largest at.
    ///
    /// What the contact's force would move the modes by above H is added, and so is
    /// what that motion, at the contact, changes below through the balance's Jacobian. The shortening of the
    /// harmonics above H, of second order, is left out.
    pub(super) fn left_out(
        &mut self,
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> f64 {
        if self.has_two_directions() {
            return f64::NAN; // not estimated: a point says that it is not resolved
        }
        if !self.has_contact() {
            return 0.0;
        }
        // From the first harmonic alone nothing would be seen of the third.
        let response = self.beyond(at, 2 * self.harmonics + 2);
        let orders = self.harmonics + 1..;
        let beyond: Vec<(usize, &[Complex<f64>])> = orders.zip(response.chunks_exact(self.modes())).collect();
        let displaced = |shape: &[f64], modes: &[Complex<f64>]| -> Complex<f64> {
            shape.iter().zip(modes).map(|(phi, q)| q * phi).sum()
        };
        let mut change = vec![0.0; self.unknowns()];
        for (order, modes) in beyond.iter().filter(|(order, _)| 2 * order < self.wide) {
            let moved = displaced(&self.ports[0].shape, modes);
            (change[2 * order - 1], change[2 * order]) = (moved.re, -moved.im);
        }
        solve(&mut change);
        let mut below = vec![Vec::new(); self.nodes()];
        self.nodes_along(&change, &[0.0; 4], &mut below);
        let mut worst = 0.0_f64;
        for (node, (changes, amplitude)) in below.iter().zip(&point.amplitude).enumerate() {
            let shape = &self.system.observed[node];
            let kept = changes[0].abs() + changes[1..].chunks_exact(2).map(|c| c[0].hypot(c[1])).sum::<f64>();
            let added: f64 = beyond.iter().map(|(_, modes)| displaced(shape, modes).norm()).sum();
            if *amplitude > 0.0 {
                worst = worst.max((kept + added) / amplitude);
            }
        }
        worst
    }
}
