//! Beams, laws and an exact oscillator shared by the tests of time integration.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, Inputs, Response, SlipState, StateTangents, Tangents};
use stickslip::system::{ModalBeam, Sensor};
use stickslip::time::{ContactMotion, Integrator, Motion, Ramp, Settings};

/// A beam with one mode.
pub fn one_mode(omega: f64, zeta: f64, contact: f64, excitation: f64, flexibility: f64) -> ModalBeam {
    ModalBeam {
        angular_frequency: vec![omega],
        damping_ratio: vec![zeta],
        contact_shape: vec![contact],
        excitation_shape: vec![excitation],
        shortening: vec![0.0],
        axial_flexibility: flexibility,
        stretching_stiffness: 0.0,
        string_stiffness: 0.0,
        string_stretch: Vec::new(),
        quadratic_damping: 0.0,
        sensors: vec![Sensor { position: 0.0, shape: vec![1.0] }],
        contact_points: vec![],
    }
}

/// The analytic modes of a clamped–pinned steel beam, 600 × 40 × 5 mm, pin radius 6 mm.
pub fn steel_beam(modes: usize, zeta: f64) -> ModalBeam {
    let (length, area, radius) = (0.6, 0.04 * 0.005, 0.006);
    let (modulus, density) = (197e9, 7850.0);
    let inertia = 0.04 * 0.005_f64.powi(3) / 12.0;
    let shapes: Vec<Shape> = (1..=modes).map(|n| Shape::new(n, length, density * area)).collect();
    let sensor = |x: f64| Sensor { position: x, shape: shapes.iter().map(|s| s.at(x).0).collect() };
    let points = 4000;
    let slopes: Vec<Vec<f64>> = shapes
        .iter()
        .map(|s| (0..=points).map(|i| s.at(length * i as f64 / points as f64).1).collect())
        .collect();
    let simpson = |a: &[f64], b: &[f64]| -> f64 {
        let weight = |i: usize| if i == 0 || i == points { 1.0 } else { 2.0 + 2.0 * (i % 2) as f64 };
        (0..=points).map(|i| weight(i) * a[i] * b[i]).sum::<f64>() * length / (3 * points) as f64
    };
    let shortening = (0..modes * modes).map(|ij| simpson(&slopes[ij / modes], &slopes[ij % modes])).collect();
    ModalBeam {
        angular_frequency: shapes
            .iter()
            .map(|s| s.wave_number.powi(2) * (modulus * inertia / (density * area)).sqrt())
            .collect(),
        damping_ratio: vec![zeta; modes],
        contact_shape: shapes.iter().map(|s| radius * s.at(length).1).collect(),
        excitation_shape: shapes.iter().map(|s| s.at(0.55).0).collect(),
        shortening,
        axial_flexibility: length / (modulus * area),
        stretching_stiffness: 0.0,
        string_stiffness: 0.0,
        string_stretch: Vec::new(),
        quadratic_damping: 0.0,
        sensors: vec![sensor(0.55), sensor(0.3), sensor(0.1)],
        contact_points: vec![],
    }
}

/// A clamped–pinned mode, written so that nothing cancels for high modes.
struct Shape {
    wave_number: f64,
    /// 1 − σ
    rest: f64,
    scale: f64,
}

impl Shape {
    fn new(number: usize, length: f64, mass_per_length: f64) -> Self {
        // tan y = tanh y
        let mut y = (number as f64 + 0.25) * std::f64::consts::PI;
        for _ in 0..50 {
            y = (number as f64) * std::f64::consts::PI + y.tanh().atan();
        }
        let small = (-2.0 * y).exp();
        let rest = (-(-y).exp() + y.cos() * 2.0 * small / (1.0 + small)) / (y.sinh() - y.sin());
        Self { wave_number: y / length, rest, scale: 1.0 / (mass_per_length * length).sqrt() }
    }

    /// Value and slope.
    fn at(&self, position: f64) -> (f64, f64) {
        let x = self.wave_number * position;
        let (growing, falling) = (0.5 * self.rest * x.exp(), (1.0 - 0.5 * self.rest) * (-x).exp());
        let sigma = 1.0 - self.rest;
        let value = growing + falling - x.cos() + sigma * x.sin();
        let slope = growing - falling + x.sin() + sigma * x.cos();
        (self.scale * value, self.scale * self.wave_number * slope)
    }
}

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
