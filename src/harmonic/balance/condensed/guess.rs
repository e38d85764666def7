//! Starting points by equivalent linearisation of every contact.

use nalgebra::{Complex, DMatrix, DVector};

use super::{Condensed, span};
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::equivalent::{Equivalent, settle};
use crate::harmonic::balance::transfer::{Of, add_product};
use crate::harmonic::newton::system::Operating;
use crate::harmonic::period::Cycle;

impl Condensed {
    /// Response of the structure with the contacts linearised at the amplitude that results; starts from
    /// the contacts under a motion too small to slip.
    pub(super) fn linearised(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError> {
        if self.contacts.is_empty() {
            return Ok(());
        }
        self.at_contacts.evaluate(&mut self.receptance, at)?;
        self.at = *at;
        self.respond(at, &vec![Equivalent::default(); self.contacts.len()], x);
        let size = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        if size == 0.0 {
            return Ok(());
        }
        let small: Vec<f64> = x.iter().map(|x| 1e-7 * x).collect();
        settle(self.measure(at, &small)?, |contacts| {
            self.respond(at, contacts, x);
            self.measure(at, x)
        })?;
        self.forget_all();
        Ok(())
    }

    fn forget_all(&mut self) {
        self.contacts.iter_mut().for_each(|contact| contact.cycle.forget());
    }

    /// Springs and dampers nearest to what the contacts do under `x`.
    fn measure(&mut self, at: &Operating, x: &[f64]) -> Result<Vec<Equivalent>, HarmonicError> {
        self.forget_all();
        self.carry(x, at)?;
        let orders = &self.orders;
        let parts = self.contacts.iter().zip(x.chunks_exact(self.set.len()));
        let equivalents = parts.map(|(contact, u)| {
            let force = contact.cycle.force();
            let coefficients = orders.iter().filter(|(order, _)| *order > 0);
            let pair = |values: &[f64], place: usize| [values[place], values[place + 1]];
            let harmonics = coefficients.map(|(order, place)| (*order, pair(force, *place), pair(u, *place)));
            Equivalent::nearest(at.angular_frequency, harmonics)
        });
        Ok(equivalents.collect())
    }

    /// `(1 + H_cc S) u = level H_ce f`, harmonic by harmonic.
    fn respond(&self, at: &Operating, contacts: &[Equivalent], x: &mut [f64]) {
        let (p, width) = (self.contacts.len(), self.set.len());
        x.fill(0.0);
        for (k, (order, place)) in self.orders.iter().enumerate() {
            let span = span(*order, *place);
            let force = &self.excitation[span.clone()];
            if force.iter().all(|f| *f == 0.0) {
                continue;
            }
            let speed = *order as f64 * at.angular_frequency;
            let complex = |[re, im]: [f64; 2]| Complex::new(re, im);
            let matrix = DMatrix::from_fn(p, p, |i, j| {
                let own = if i == j { 1.0 } else { 0.0 };
                complex(self.at_contacts.get(k, Of::Value, i, j)) * contacts[j].dynamic(speed) + own
            });
            let free = DVector::from_fn(p, |i, _| {
                let mut moved = [0.0; 2];
                let compliance = self.at_contacts.get(k, Of::Value, i, p);
                add_product(compliance, force, at.level, &mut moved[..span.len()]);
                Complex::new(moved[0], -moved[1])
            });
            let Some(u) = matrix.lu().solve(&free) else { continue };
            for (i, u) in u.iter().enumerate().filter(|(_, u)| u.re.is_finite() && u.im.is_finite()) {
                let parts = [u.re, -u.im];
                let into = &mut x[i * width + span.start..i * width + span.end];
                into.copy_from_slice(&parts[..span.len()]);
            }
        }
    }
}
