//! The residual and its derivatives.

use super::{Condensed, compliance_derivative, span};
use crate::harmonic::HarmonicError;
use crate::harmonic::balance::transfer::{Of, Transfer, add_product};
use crate::harmonic::newton::system::{Operating, Scalar};
use crate::harmonic::period::Cycle;
use crate::system::Rows;

impl Condensed {
    /// Rounding of the compliances at `at`, seen where the frequency changes by a few units in its last place.
    /// Measured anew where the frequency is another.
    pub(super) fn rounding_about(&mut self, at: &Operating) -> f64 {
        const NEAR: f64 = 0.05;
        const PROBES: usize = 3;
        const SAFETY: f64 = 8.0;
        let speed = at.angular_frequency;
        if let Some((about, rounding)) = self.rounding
            && (speed - about).abs() <= NEAR * about
        {
            return rounding;
        }
        let mut probe = Transfer::new(&self.receptance, Rows::Contacts, self.orders.iter().map(|(h, _)| *h));
        let mut first: Vec<[f64; 2]> = Vec::new();
        let (mut change, mut largest) = (0.0_f64, 0.0_f64);
        for k in 0..=PROBES {
            let at = Operating { angular_frequency: speed * (1.0 + 2.0 * k as f64 * f64::EPSILON), ..*at };
            if probe.evaluate(&mut self.receptance, &at).is_err() {
                return 0.0;
            }
            let p = self.contacts.len();
            let places = (0..self.orders.len())
                .flat_map(|k| (0..p).flat_map(move |i| (0..=p).map(move |j| (k, i, j))));
            let values = places.map(|(k, i, j)| probe.get(k, Of::Value, i, j));
            if k == 0 {
                first = values.collect();
                largest = first.iter().fold(0.0, |m, [re, im]| m.max(re.hypot(*im)));
            } else {
                let moved = values.zip(&first).map(|(a, b)| (a[0] - b[0]).hypot(a[1] - b[1]));
                change = moved.fold(change, f64::max);
            }
        }
        let rounding = if largest > 0.0 { SAFETY * change / largest } else { 0.0 };
        self.rounding = Some((speed, rounding));
        rounding
    }

    pub(super) fn carry(&mut self, x: &[f64], at: &Operating) -> Result<(), HarmonicError> {
        let mut parts = self.contacts.iter_mut().zip(x.chunks_exact(self.set.len()));
        parts.try_for_each(|(contact, u)| contact.evaluate(at.angular_frequency, u))
    }

    /// Residual; returns the size of its terms.
    pub(super) fn balance(&mut self, x: &[f64], at: &Operating) -> f64 {
        let (p, width) = (self.contacts.len(), self.set.len());
        self.residual.copy_from_slice(x);
        let mut scale = x.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for i in 0..p {
            for (k, (order, place)) in self.orders.iter().enumerate() {
                let span = span(*order, *place);
                let mut sum = [0.0; 2];
                let sum = &mut sum[..span.len()];
                let compliance = self.at_contacts.get(k, Of::Value, i, p);
                add_product(compliance, &self.excitation[span.clone()], -at.level, sum);
                scale = sum.iter().fold(scale, |m, x| m.max(x.abs()));
                for (j, contact) in self.contacts.iter().enumerate() {
                    let compliance = self.at_contacts.get(k, Of::Value, i, j);
                    add_product(compliance, &contact.cycle.force()[span.clone()], 1.0, sum);
                }
                let target = &mut self.residual[i * width + span.start..i * width + span.end];
                target.iter_mut().zip(sum.iter()).for_each(|(r, s)| *r += s);
            }
        }
        scale
    }

    pub(super) fn differentiate(&mut self) {
        let (p, width) = (self.contacts.len(), self.set.len());
        let unknowns = p * width;
        for (j, contact) in self.contacts.iter().enumerate() {
            let columns = contact.cycle.jacobian().as_slice().chunks_exact(width);
            for (n, source) in columns.enumerate() {
                let column = j * width + n;
                let target = &mut self.jacobian.as_mut_slice()[column * unknowns..(column + 1) * unknowns];
                target.fill(0.0);
                for i in 0..p {
                    for (k, (order, place)) in self.orders.iter().enumerate() {
                        let end = place + if *order == 0 { 1 } else { 2 };
                        let compliance = self.at_contacts.get(k, Of::Value, i, j);
                        let into = &mut target[i * width + place..i * width + end];
                        add_product(compliance, &source[*place..end], 1.0, into);
                    }
                }
                target[column] += 1.0;
            }
        }
    }

    pub(super) fn differentiate_by(&mut self, scalar: Scalar, at: &Operating) {
        let (p, width) = (self.contacts.len(), self.set.len());
        let target = &mut self.by[scalar.index()];
        target.fill(0.0);
        for i in 0..p {
            for (k, (order, place)) in self.orders.iter().enumerate() {
                let span = span(*order, *place);
                let into = &mut target[i * width + span.start..i * width + span.end];
                if scalar == Scalar::Level {
                    let compliance = self.at_contacts.get(k, Of::Value, i, p);
                    add_product(compliance, &self.excitation[span], -1.0, into);
                    continue;
                }
                let contacts = self.contacts.iter().filter(|_| scalar == Scalar::AngularFrequency);
                for (j, contact) in contacts.enumerate() {
                    let compliance = self.at_contacts.get(k, Of::Value, i, j);
                    add_product(compliance, &contact.cycle.by_frequency()[span.clone()], 1.0, into);
                }
                let Some(of) = compliance_derivative(scalar) else { continue };
                let compliance = self.at_contacts.get(k, of, i, p);
                add_product(compliance, &self.excitation[span.clone()], -at.level, into);
                for (j, contact) in self.contacts.iter().enumerate() {
                    let compliance = self.at_contacts.get(k, of, i, j);
                    add_product(compliance, &contact.cycle.force()[span.clone()], 1.0, into);
                }
            }
        }
    }
}
