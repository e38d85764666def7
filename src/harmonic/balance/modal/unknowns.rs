//! From a motion of the modes to the unknowns.

use super::Balance;
use crate::harmonic::modal_system::ModalPort;
use crate::harmonic::newton::system::PeriodicSystem;

impl Balance {
    /// The unknowns that belong to such coefficients and a contact force.
    pub fn unknowns_of(&mut self, modal_coefficients: &[f64], force: &[f64]) -> Vec<f64> {
        let (modes, count) = (self.modes(), self.count);
        for (i, mode) in modal_coefficients.chunks_exact(count).enumerate() {
            mode.iter().enumerate().for_each(|(k, value)| self.q[k * modes + i] = *value);
        }
        self.weigh();
        self.unknowns_under(force)
    }

    /// The unknowns under a force on the contact: its displacement once the series spring has yielded, and what the
    /// modes give of the others.
    fn unknowns_under(&self, force: &[f64]) -> Vec<f64> {
        let series = self.ports[0].flexibility;
        let contact = self.displacement().iter().zip(force).map(|(u, force)| u - series * force);
        contact.chain(self.moved[self.wide..].iter().copied()).collect()
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

    /// The unknowns of the displacement and the contact force last evaluated.
    pub fn start(&self) -> Vec<f64> {
        self.unknowns_under(self.force())
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
