//! From a motion of the modes to the unknowns.

use nalgebra::Complex;

use super::{Acting, Balance};
use crate::harmonic::modal_system::ModalPort;
use crate::harmonic::newton::system::{Operating, PeriodicSystem};

impl Balance {
    /// The unknowns that belong to such coefficients and a force of the contact (N) in a motion of the fundamental
    /// `angular_frequency` (rad/s); what hangs at the contact pulls as it does there.
    pub fn unknowns_of(
        &mut self,
        modal_coefficients: &[f64],
        force: &[f64],
        angular_frequency: f64,
    ) -> Vec<f64> {
        let (modes, count) = (self.modes(), self.count);
        for (i, mode) in modal_coefficients.chunks_exact(count).enumerate() {
            mode.iter().enumerate().for_each(|(k, value)| self.q[k * modes + i] = *value);
        }
        self.displace();
        self.unknowns_under(force, angular_frequency)
    }

    /// The unknowns under a force of the contact: its displacement once the flexibility has yielded, and what the
    /// modes give of the others.
    fn unknowns_under(&self, force: &[f64], angular_frequency: f64) -> Vec<f64> {
        let flexibility = self.ports[0].flexibility;
        let contact = self.displacement().iter().zip(force).map(|(u, force)| u - flexibility * force);
        let mut unknowns: Vec<f64> = contact.chain(self.moved[self.wide..].iter().copied()).collect();
        let at = Operating::forced(angular_frequency, 0.0);
        self.scale(&mut unknowns, |hung| 1.0 / (1.0 + flexibility * hung), &at);
        if self.series != 0.0 {
            unknowns.iter_mut().zip(force).for_each(|(x, force)| *x += self.series * force);
        }
        unknowns
    }

    /// The contact's displacement (m) behind its flexibility and in front of it, for the unknowns `x` and its law's force
    /// (N).
    pub fn either_side(&self, x: &[f64], force: &[f64]) -> [Vec<f64>; 2] {
        let flexibility = self.ports[0].flexibility;
        let by = |compliance: f64| -> Vec<f64> {
            let none = compliance == 0.0;
            let moved = |(x, force): (&f64, &f64)| if none { *x } else { x + compliance * force };
            x[..self.wide].iter().zip(force).map(moved).collect()
        };
        [by(-self.series), by(flexibility - self.series)]
    }

    /// Multiplies the contact's harmonics by a factor that depends on the dynamic stiffness (N/m) of what hangs there.
    pub(super) fn scale(
        &self,
        coefficients: &mut [f64],
        factor: impl Fn(Complex<f64>) -> Complex<f64>,
        at: &Operating,
    ) {
        if self.hung().next().is_none() {
            return;
        }
        for (place, pair) in coefficients[1..self.wide].chunks_exact_mut(2).enumerate() {
            let scaled = factor(self.hung_stiffness(at, place + 1)) * Complex::new(pair[0], -pair[1]);
            (pair[0], pair[1]) = (scaled.re, -scaled.im);
        }
    }

    /// The unknowns `x` as those of `finer`, the balance of the same system with more harmonics.
    pub fn refined(&self, x: &[f64], finer: &Self) -> Vec<f64> {
        let mut refined = vec![0.0; finer.unknowns()];
        for (port, fine) in self.ports.iter().zip(&finer.ports) {
            let first = fine.rows.start;
            refined[first..first + port.rows.len()].copy_from_slice(&x[port.rows.clone()]);
        }
        refined
    }

    /// The unknowns of the displacement and the contact force last evaluated, as [`Self::unknowns_of`].
    pub fn start(&self, angular_frequency: f64) -> Vec<f64> {
        self.unknowns_under(self.force(), angular_frequency)
    }

    /// Number of [`Self::expanded_coefficients`].
    pub fn expanded_len(&self) -> usize {
        let hung = self.acting.iter().filter(|acting| matches!(acting, Acting::Resonator(_))).count();
        self.count * (self.modes() + hung)
    }

    /// Coefficients of every mode and, behind them, of every resonator's coordinate in the system's
    /// [`expanded`](crate::system::System::expanded) form, at the last evaluation.
    pub fn expanded_coefficients(&self, at: &Operating) -> Vec<f64> {
        let mut all = self.modal_coefficients();
        for acting in &self.acting {
            let Acting::Resonator(hung) = acting else { continue };
            all.extend(hung.coordinate(at, &self.behind[hung.rows.clone()], self.harmonics));
        }
        all
    }

    /// Names and displacements (m), by the modes of the last evaluation, of all ports to which this balance or one of
    /// another system may be condensed besides the contact's.
    pub fn at_ports(&self) -> Vec<(String, Vec<f64>)> {
        let contact = &self.ports[0];
        let straight = self.displacement_along(&contact.shape);
        let shorter = |(straight, u): (&f64, &f64)| {
            if contact.shortening == 0.0 { 0.0 } else { (straight - u) / contact.shortening }
        };
        let shortening: Vec<f64> = straight.iter().zip(self.displacement()).map(shorter).collect();
        let displaced = |port: &ModalPort| {
            let linear = self.displacement_along(&port.shape);
            linear.iter().zip(&shortening).map(|(u, h)| u - port.shortening * h).collect()
        };
        self.all_ports.iter().map(|(name, port)| (name.clone(), displaced(port))).collect()
    }
}
