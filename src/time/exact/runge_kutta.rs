//! The classical Runge–Kutta scheme with fixed steps on the rate form of sliders, as the time domain solution
//! of the friction-vibration study (section 3.2) has it: the plainest way, kept for comparison.

use std::f64::consts::TAU;

use super::elements::{Element, elements};
use super::system::{System, dot};
use super::{Excitation, OscillatorError};
use crate::contact::LoadedContact;
use crate::system::LinearStructure;

/// A structure with piecewise-linear contacts whose sliders obey `ż = u̇` at the limit and outwards, `ż = 0`
/// otherwise, in steps of constant length.
///
/// Corners lie within steps, so that the fourth order of the scheme is lost: the error falls with the
/// second power of the step.
#[derive(Debug, Clone)]
pub struct RungeKutta {
    system: System,
    elements: Vec<Element>,
}

/// One period of a motion that started from rest.
#[derive(Debug, Clone, PartialEq)]
pub struct Transient {
    /// Largest magnitude of every output's displacement in this period, at the ends of steps (m).
    pub amplitude: Vec<f64>,
    /// Area of every contact's loop in this period (J); the loop need not close.
    pub dissipated_energy: Vec<f64>,
}

/// Displacements, velocities and slider positions, or their rates.
type Numbers = Vec<f64>;

impl RungeKutta {
    /// The scheme for `structure` with `contacts` in the same order.
    ///
    /// # Errors
    /// As [`OscillatorFlow::new`](super::OscillatorFlow::new).
    pub fn new(structure: &LinearStructure, contacts: &[LoadedContact]) -> Result<Self, OscillatorError> {
        let system = System::new(structure)?;
        let (expected, found) = (system.contacts.len(), contacts.len());
        if expected != found {
            return Err(OscillatorError::Length { name: "contacts", expected, found });
        }
        Ok(Self { elements: elements(contacts)?, system })
    }

    /// Periods one to `periods` of the motion from rest under a periodic `excitation`, in `steps` steps each.
    ///
    /// # Errors
    /// An excitation without period, no steps, a motion beyond all numbers.
    pub fn from_rest(
        &self,
        excitation: &Excitation,
        periods: usize,
        steps: usize,
    ) -> Result<Vec<Transient>, OscillatorError> {
        excitation.check()?;
        let Excitation::Periodic { angular_frequency, .. } = excitation else {
            return Err(OscillatorError::Input { name: "excitation frequency", value: 0.0 });
        };
        if steps == 0 {
            return Err(OscillatorError::Input { name: "steps", value: 0.0 });
        }
        let h = TAU / angular_frequency / steps as f64;
        let n = self.system.size;
        let force: Vec<f64> = (0..=2 * steps).map(|k| excitation.value(0.5 * h * k as f64)).collect();
        let mut y = vec![0.0; 2 * n + self.elements.len()];
        let mut rates: [Numbers; 4] = std::array::from_fn(|_| y.clone());
        let (mut stage, mut contact) = (y.clone(), vec![0.0; self.system.contacts.len()]);
        let mut out = Vec::with_capacity(periods);
        for period in 0..periods {
            let mut record = Transient {
                amplitude: vec![0.0; self.system.outputs.len()],
                dissipated_energy: vec![0.0; contact.len()],
            };
            for k in 0..steps {
                self.forces(&y, &mut contact);
                let before = self.contact_displacements(&y);
                let forces_before = contact.clone();
                for (i, (fraction, at)) in [(0.0, 0), (0.5, 1), (0.5, 1), (1.0, 2)].into_iter().enumerate() {
                    for (place, stage) in stage.iter_mut().enumerate() {
                        *stage = y[place] + if i > 0 { fraction * h * rates[i - 1][place] } else { 0.0 };
                    }
                    self.rate(&stage, force[2 * k + at], &mut contact, &mut rates[i]);
                }
                for (place, y) in y.iter_mut().enumerate() {
                    let [a, b, c, d] = std::array::from_fn(|i| rates[i][place]);
                    *y += h / 6.0 * (a + 2.0 * b + 2.0 * c + d);
                }
                self.return_to_limits(&mut y);
                self.forces(&y, &mut contact);
                let after = self.contact_displacements(&y);
                for (c, energy) in record.dissipated_energy.iter_mut().enumerate() {
                    *energy += 0.5 * (forces_before[c] + contact[c]) * (after[c] - before[c]);
                }
                for (amplitude, row) in record.amplitude.iter_mut().zip(&self.system.outputs) {
                    *amplitude = amplitude.max(dot(row, &y[..n]).abs());
                }
            }
            if !y.iter().all(|y| y.is_finite()) {
                return Err(OscillatorError::Diverged {
                    time: (period + 1) as f64 * TAU / angular_frequency,
                });
            }
            out.push(record);
        }
        Ok(out)
    }

    fn contact_displacements(&self, y: &[f64]) -> Vec<f64> {
        self.system.contacts.iter().map(|row| dot(row, &y[..self.system.size])).collect()
    }

    /// Contact forces at `y`.
    fn forces(&self, y: &[f64], out: &mut [f64]) {
        let n = self.system.size;
        out.fill(0.0);
        for (element, z) in self.elements.iter().zip(&y[2 * n..]) {
            let u = dot(&self.system.contacts[element.contact], &y[..n]);
            out[element.contact] += element.slider.step(*z, u).0;
        }
    }

    /// Rates of all numbers at `y`.
    fn rate(&self, y: &[f64], force: f64, contact: &mut [f64], out: &mut [f64]) {
        let n = self.system.size;
        self.forces(y, contact);
        let (x, v) = (&y[..n], &y[n..2 * n]);
        let (velocity, rest) = out.split_at_mut(n);
        velocity.copy_from_slice(v);
        let (acceleration, sliders) = rest.split_at_mut(n);
        self.system.accelerate(x, v, contact, force, acceleration);
        for ((element, z), rate) in self.elements.iter().zip(&y[2 * n..]).zip(sliders) {
            let row = &self.system.contacts[element.contact];
            let (u, speed) = (dot(row, x), dot(row, v));
            let force = element.slider.step(*z, u).0;
            let outwards = (force >= element.slider.upper_limit && speed > 0.0)
                || (force <= -element.slider.lower_limit && speed < 0.0);
            *rate = if outwards { speed } else { 0.0 };
        }
    }

    /// A step across a corner overshoots the limit: the slider then follows.
    fn return_to_limits(&self, y: &mut [f64]) {
        let n = self.system.size;
        for (k, element) in self.elements.iter().enumerate() {
            let u = dot(&self.system.contacts[element.contact], &y[..n]);
            y[2 * n + k] = element.slider.step(y[2 * n + k], u).1;
        }
    }
}
