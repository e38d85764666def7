//! Laws, settings and an exact oscillator shared by the tests of time integration.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, Inputs, Response, SlipState, StateTangents, Tangents};
use stickslip::system::ModalBeam;
use stickslip::time::{ContactMotion, Integrator, Motion, Ramp, Settings};

/// A linear spring as a contact law.
#[derive(Debug, Clone, Copy)]
pub struct Spring(pub f64);

impl ContactLaw for Spring {
    fn state_len(&self) -> usize {
        1
    }
    fn set_state(&self, displacement: f64, _: f64, _: f64, state: &mut [f64]) {
        state[0] = displacement;
    }
    fn step(&self, _: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        next[0] = inputs.displacement;
        Response {
            force: self.0 * inputs.displacement,
            tangents: Tangents { displacement: self.0, ..Tangents::default() },
            dissipated_energy: 0.0,
            slip_state: SlipState::Stick,
        }
    }
    fn state_tangents(&self, _: &[f64], _: Inputs, _: &mut StateTangents) {}
    fn limit(&self, _: f64) -> f64 {
        f64::INFINITY
    }
}

/// Held inputs: the force of the exciter (N), and the normal load or the contact force (N).
pub fn held(excitation: f64, contact: f64) -> [Ramp; 2] {
    [Ramp::held(excitation), Ramp::held(contact)]
}

/// An integrator of `beam` with a contact of this law and constant normal load (N).
pub fn supported(beam: &ModalBeam, law: impl ContactLaw + 'static, normal_load: f64) -> Integrator {
    supported_by(beam, Arc::new(law), normal_load)
}

/// As [`supported`], of a law that is shared.
pub fn supported_by(beam: &ModalBeam, law: Arc<dyn ContactLaw>, normal_load: f64) -> Integrator {
    Integrator::new(&beam.system(Some((law, normal_load))).unwrap()).unwrap()
}

/// An integrator of `beam` under a contact force from outside.
pub fn loaded(beam: &ModalBeam) -> Integrator {
    Integrator::new(&beam.system(None).unwrap()).unwrap()
}

/// At rest under the constant normal load.
pub fn rest(integrator: &mut Integrator) -> Motion {
    let inputs = integrator.held_inputs();
    integrator.rest(&inputs).unwrap()
}

/// The law at the beam's end, or the force there.
pub fn at_end(motion: &Motion) -> ContactMotion {
    motion.contact(0)
}

pub fn tolerance(tolerance: f64) -> Settings {
    Settings { tolerance, ..Settings::default() }
}

/// One mode with Jenkins' element, solved phase by phase in closed form: the oracle. It shares
/// nothing with the integrator.
#[derive(Debug, Clone)]
pub struct ExactJenkins {
    pub omega: f64,
    pub zeta: f64,
    pub shape: f64,
    pub stiffness: f64,
    pub limit: f64,
    pub q: f64,
    pub v: f64,
    pub slider: f64,
    pub dissipated: f64,
    /// 0 in stick, else the direction of slip.
    pub slipping: f64,
}

impl ExactJenkins {
    pub fn force(&self) -> f64 {
        if self.slipping == 0.0 {
            self.stiffness * (self.shape * self.q - self.slider)
        } else {
            self.slipping * self.limit
        }
    }

    /// State after `t` of the present phase, under the modal force `p`.
    fn phase(&self, p: f64, t: f64) -> (f64, f64) {
        let stuck = self.slipping == 0.0;
        let square = self.omega * self.omega + if stuck { self.shape.powi(2) * self.stiffness } else { 0.0 };
        let load = if stuck {
            p + self.shape * self.stiffness * self.slider
        } else {
            p - self.shape * self.slipping * self.limit
        };
        let (rest, decay) = (load / square, self.zeta * self.omega);
        let damped = (square - decay * decay).sqrt();
        let (s, c) = (damped * t).sin_cos();
        let (x, e) = (self.q - rest, (-decay * t).exp());
        (
            rest + e * (x * c + (self.v + decay * x) / damped * s),
            e * (self.v * c - (square * x + decay * self.v) / damped * s),
        )
    }

    /// Positive once the phase is over.
    fn over(&self, (q, v): (f64, f64)) -> f64 {
        if self.slipping == 0.0 {
            (self.stiffness * (self.shape * q - self.slider)).abs() - self.limit
        } else {
            -self.slipping * self.shape * v
        }
    }

    /// Advances by `duration` under the constant modal force `p`.
    pub fn advance(&mut self, p: f64, mut duration: f64) {
        while duration > 0.0 {
            let scan = (duration / 2e-5).ceil() as usize;
            let event = (1..=scan)
                .map(|i| duration * i as f64 / scan as f64)
                .find(|&t| self.over(self.phase(p, t)) > 0.0);
            let end = event.map_or(duration, |hit| {
                let (mut a, mut b) = (hit - duration / scan as f64, hit);
                for _ in 0..100 {
                    let middle = 0.5 * (a + b);
                    if self.over(self.phase(p, middle)) > 0.0 { b = middle } else { a = middle }
                }
                b
            });
            let (q, v) = self.phase(p, end);
            if self.slipping != 0.0 {
                let travel = self.shape * (q - self.q);
                self.slider += travel;
                self.dissipated += self.limit * travel.abs();
            }
            (self.q, self.v) = (q, v);
            if event.is_some() {
                self.slipping = if self.slipping == 0.0 { (self.shape * v).signum() } else { 0.0 };
                if self.slipping == 0.0 {
                    // Exactly at the limit: back off by rounding, so that stick does not end at once.
                    let force = self.stiffness * (self.shape * q - self.slider);
                    self.slider += (force - force.signum() * self.limit) / self.stiffness;
                }
            }
            duration -= end;
        }
    }
}
