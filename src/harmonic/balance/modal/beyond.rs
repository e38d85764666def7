//! The response in harmonics above those balanced.

use nalgebra::Complex;

use super::Balance;
use crate::harmonic::newton::system::Operating;
use crate::harmonic::period::Cycle;
use crate::numeric::HarmonicSet;

/// Harmonics of `w_i` that carry the contact's force from one harmonic to another: the motion is slow and smooth.
const CARRYING: usize = 8;

impl Balance {
    /// Response of every mode to the contact's force in harmonics H + 1 to `highest`, at the last evaluation, as
    /// `c − i s`: harmonic after harmonic, all modes of each.
    ///
    /// That the contact feels this motion in turn is left out; what hangs there does.
    pub fn beyond(&mut self, at: &Operating, highest: usize) -> Vec<Complex<f64>> {
        let (modes, harmonics) = (self.modes(), self.harmonics);
        let contact = match self.contact_mut() {
            Some(contact) if highest > harmonics => contact,
            _ => return vec![Complex::new(0.0, 0.0); modes * highest.saturating_sub(harmonics)],
        };
        let carrying = CARRYING.min(harmonics);
        let set = HarmonicSet::full(highest + carrying);
        let mut force = vec![0.0; set.len()];
        contact.cycle.force_on(set, &mut force);
        // ŵ of harmonic 0, then half of c − i s.
        let arms: Vec<Vec<Complex<f64>>> = (0..modes).map(|mode| self.arm(mode, carrying)).collect();
        self.hang_on(&mut force, at, |mode| arms[mode][0].re);
        let force = |order: usize| Complex::new(force[2 * order - 1], -force[2 * order]);
        let mut response = Vec::with_capacity(modes * (highest - harmonics));
        for order in harmonics + 1..=highest {
            let speed = order as f64 * at.angular_frequency;
            for (mode, arm) in arms.iter().enumerate() {
                let carried =
                    (1..=carrying).map(|m| arm[m] * force(order - m) + arm[m].conj() * force(order + m));
                let acting = arm[0] * force(order) + carried.sum::<Complex<f64>>();
                response.push(-acting / self.system.dynamic_stiffness(mode, speed));
            }
        }
        response
    }

    /// Adds to the coefficients of the contact's force what hangs there makes of it, the modes having the levers `arm`.
    fn hang_on(&self, force: &mut [f64], at: &Operating, arm: impl Fn(usize) -> f64) {
        if self.hung().next().is_none() {
            return;
        }
        for (place, pair) in force[1..].chunks_exact_mut(2).enumerate() {
            let (order, first) = (place + 1, 2 * place + 1);
            let hung = self.hung_stiffness(at, order);
            let of_law = Complex::new(pair[0], -pair[1]);
            let speed = order as f64 * at.angular_frequency;
            // Of what the harmonics balanced move the contact by; above them its own force moves the modes.
            let mut moved = Complex::new(0.0, 0.0);
            if first + 1 < self.wide {
                moved = Complex::new(self.moved[first], -self.moved[first + 1]);
            }
            let mut yields = Complex::from(self.ports[0].flexibility);
            if order > self.harmonics {
                let modes = 0..self.modes();
                let of_modes =
                    modes.map(|mode| arm(mode).powi(2) / self.system.dynamic_stiffness(mode, speed));
                yields += of_modes.sum::<Complex<f64>>();
            }
            let all = (of_law + hung * moved) / (1.0 + hung * yields);
            (pair[0], pair[1]) = (all.re, -all.im);
        }
    }

    /// Harmonics `0..=highest` of `w_i`, the contact's lever on a mode.
    fn arm(&self, mode: usize, highest: usize) -> Vec<Complex<f64>> {
        let modes = self.modes();
        let row = &self.system.shortening[mode * modes..(mode + 1) * modes];
        let turned = |place: usize| -> f64 {
            let q = &self.q[place * modes..(place + 1) * modes];
            -self.ports[0].shortening * row.iter().zip(q).map(|(g, q)| g * q).sum::<f64>()
        };
        let mean = Complex::new(self.ports[0].shape[mode] + turned(0), 0.0);
        let harmonic = |order: usize| Complex::new(0.5 * turned(2 * order - 1), -0.5 * turned(2 * order));
        std::iter::once(mean).chain((1..=highest).map(harmonic)).collect()
    }

    /// Coefficients of the displacement (m) up to harmonic `highest` where the modes have the values `shape`, of
    /// which those above H come from `beyond`.
    pub fn output_with(&self, shape: &[f64], beyond: &[Complex<f64>]) -> Vec<f64> {
        let mut coefficients = self.displacement_along(shape);
        for modes in beyond.chunks_exact(shape.len()) {
            let moved: Complex<f64> = modes.iter().zip(shape).map(|(q, phi)| q * phi).sum();
            coefficients.extend([moved.re, -moved.im]);
        }
        coefficients
    }
}
