//! A law at one node of a step, and how its port answers to it.

use super::contact_point::{Answered, ContactPoint, EXACT};
use crate::contact::{Inputs, SlipState};

/// A law or an outside force at one node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeContact {
    pub force: f64,
    pub tangent: f64,
    pub load_tangent: f64,
    /// ∂force/∂velocity (N s/m).
    pub damping: f64,
    /// The velocity (m/s) that the law was asked with last.
    pub velocity: f64,
    pub slip_state: SlipState,
    /// Energy taken since the start of the step (J).
    pub energy: f64,
    pub normal_load: f64,
    /// u (m), as the law was asked last, or as a communication step begins.
    pub displacement: f64,
    /// u + a T (m) and its derivative (m/s): what the modes alone give.
    pub geometric_displacement: f64,
    pub geometric_velocity: f64,
    /// The same displacement and u where the step began (m).
    pub began: [f64; 2],
}

/// How a port answers to a law's unit force against it, by displacement (m/N) and velocity (m/(s N)), and how precisely
/// the force is sought, as [`ContactPoint::precision`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer {
    pub yielding: f64,
    pub slowing: f64,
    pub precision: f64,
    /// The node from where the law goes on in a straight line to where its force is sought first.
    pub from: Option<usize>,
}

impl Answer {
    pub const NONE: Self = Self { yielding: 0.0, slowing: 0.0, precision: EXACT, from: None };
}

impl NodeContact {
    pub const REST: Self = Self {
        force: 0.0,
        tangent: 0.0,
        load_tangent: 0.0,
        damping: 0.0,
        velocity: 0.0,
        slip_state: SlipState::Stick,
        energy: 0.0,
        normal_load: 0.0,
        displacement: 0.0,
        geometric_displacement: 0.0,
        geometric_velocity: 0.0,
        began: [0.0; 2],
    };

    /// u̇ (m/s) for a normal load that changes at `load_rate` (N/s), `flexibility` a (m/N).
    pub fn own_velocity(&self, flexibility: f64, load_rate: f64) -> f64 {
        if flexibility == 0.0 {
            return self.geometric_velocity;
        }
        (self.geometric_velocity - flexibility * self.load_tangent * load_rate)
            / (1.0 + flexibility * self.tangent)
    }

    /// A step begins here.
    pub fn begin(&mut self) {
        self.began = [self.geometric_displacement, self.displacement];
    }

    /// What the law is asked, under a normal load (N), behind a flexibility of its port (m/N) of which its velocity feels
    /// the part `series`, where the structure yields to it and slows down as `answer` tells.
    pub fn point(&self, normal_load: f64, flexibility: f64, series: f64, answer: Answer) -> ContactPoint {
        ContactPoint {
            displacement: self.geometric_displacement + answer.yielding * self.force,
            velocity: self.geometric_velocity,
            flexibility: flexibility + answer.yielding,
            series,
            began: self.began,
            slowing: answer.slowing,
            tangent: self.tangent,
            falls: self.damping < 0.0,
            normal_load,
            placed: self.force,
            guess: self.force,
            precision: answer.precision,
        }
    }

    /// The force at `point` of a law that goes on in a straight line from where it was asked last.
    pub fn going_on(&self, point: &ContactPoint) -> f64 {
        let by_load = self.load_tangent * (point.normal_load - self.normal_load);
        let force = self.force + self.tangent * (point.displacement - self.displacement) + by_load;
        force / (1.0 + self.tangent.max(0.0) * point.flexibility)
    }

    pub fn store(&mut self, Answered { response, displacement, velocity }: Answered, load: f64) {
        self.force = response.force;
        self.tangent = response.tangents.displacement;
        self.load_tangent = response.tangents.normal_load;
        self.damping = response.tangents.velocity;
        self.velocity = velocity;
        self.energy = response.dissipated_energy;
        self.slip_state = response.slip_state;
        self.normal_load = load;
        self.displacement = displacement;
    }

    /// What a law takes over at the middle of a step.
    pub fn inputs(&self) -> Inputs {
        Inputs { displacement: self.displacement, velocity: self.velocity, normal_load: self.normal_load }
    }
}
