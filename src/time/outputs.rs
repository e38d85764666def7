//! What a system shows at an instant, and how fast that changes.

use super::integrator::Integrator;
use super::plant::{add_product, dot};
use super::step::{Span, StepSolver};
use super::{IntegrationError, Motion, Ramp, Settings};
use crate::contact::{Inputs, SlipState};

/// How far ahead the slope of a law's tangent is sought, in radians of the highest mode.
const AHEAD: f64 = 1e-5;

/// What a sensor reads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorReading {
    /// Displacement (m).
    pub displacement: f64,
    /// Velocity (m/s).
    pub velocity: f64,
    /// Acceleration (m/s²), from the equation of motion at this instant.
    pub acceleration: f64,
}

/// A law or a force from outside at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactReading {
    /// Displacement u of the port (m).
    pub displacement: f64,
    /// Its rate (m/s).
    pub velocity: f64,
    /// Restoring force T (N).
    pub force: f64,
    /// Tangent of the law (N/m); 0 under a force from outside.
    pub tangent: f64,
    /// Stick, slip or separated; always stick under a force from outside.
    pub slip_state: SlipState,
    /// Energy taken since the start (J).
    pub dissipated_energy: f64,
}

/// Outputs at one instant; see [`Integrator::outputs`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Outputs {
    /// One reading per law and outside force, in the order of the system's elements.
    pub contacts: Vec<ContactReading>,
    /// One reading per sensor of the system.
    pub sensors: Vec<SensorReading>,
}

/// Derivatives with respect to time of [`Outputs`].
#[derive(Debug, Clone, Default)]
pub(crate) struct OutputRates {
    /// Of each contact's displacement (m/s), velocity (m/s²) and force (N/s).
    pub contacts: Vec<[f64; 3]>,
    /// Of each sensor's displacement (m/s), velocity (m/s²) and acceleration (m/s³).
    pub sensors: Vec<[f64; 3]>,
    jerk: Vec<f64>,
    /// G q̇.
    turning: Vec<f64>,
}

impl Integrator {
    /// Outputs of `motion` under the inputs of this instant: the starts of the ramps, and their rates over `duration`
    /// (s; infinite for held inputs). `motion` is not changed: a normal load that jumps is answered as the next step
    /// will answer it.
    ///
    /// # Errors
    /// [`IntegrationError`] where an input is illegal or the motion belongs to another system.
    pub fn outputs(
        &mut self,
        motion: &Motion,
        duration: f64,
        inputs: &[Ramp],
        out: &mut Outputs,
    ) -> Result<(), IntegrationError> {
        let span = self.at_instant(motion, duration, inputs)?;
        let solver = &self.solver;
        out.contacts.clear();
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let (at, rate) = (&solver.nodes[e][0], span.rate(inputs[contact.input]));
            let flexibility = solver.plant.ports[contact.port].flexibility;
            let velocity = match contact.law {
                None => at.geometric_velocity - flexibility * rate,
                Some(_) => at.own_velocity(flexibility, rate),
            };
            out.contacts.push(ContactReading {
                displacement: at.geometric_displacement - flexibility * at.force,
                velocity,
                force: at.force,
                tangent: at.tangent,
                slip_state: at.slip_state,
                dissipated_energy: solver.dissipated_energy[e],
            });
        }
        out.sensors.clear();
        for sensor in &solver.plant.sensors {
            let row = &solver.plant.ports[*sensor].row;
            out.sensors.push(SensorReading {
                displacement: dot(row, &solver.q[0]),
                velocity: dot(row, &solver.v[0]),
                acceleration: dot(row, solver.accelerations()),
            });
        }
        Ok(())
    }

    /// What a sensor reads of the motion that was taken up, or advanced, last: its displacement (m) differentiated `order`
    /// times; of accelerations after [`Integrator::force_end`] where steps are equal.
    #[cfg(feature = "analysis")]
    pub(crate) fn sensor(&self, sensor: usize, order: usize) -> f64 {
        let StepSolver { plant, q, v, forcing, .. } = &self.solver;
        let row = &plant.ports[plant.sensors[sensor]].row;
        match order {
            0 => dot(row, &q[0]),
            1 => dot(row, &v[0]),
            _ => {
                let modes = plant.angular_frequency.iter().zip(&plant.damping_ratio);
                let motion = q[0].iter().zip(&v[0]).zip(&forcing[0]);
                let terms = row.iter().zip(modes).zip(motion).map(|((b, (omega, zeta)), ((q, v), p))| {
                    b * (p - 2.0 * zeta * omega * v - omega * omega * q)
                });
                terms.sum()
            }
        }
    }

    /// Derivatives of the outputs of `motion`; the arguments are as those of [`Integrator::outputs`].
    pub(crate) fn output_rates(
        &mut self,
        motion: &Motion,
        duration: f64,
        inputs: &[Ramp],
        out: &mut OutputRates,
    ) -> Result<(), IntegrationError> {
        let span = self.at_instant(motion, duration, inputs)?;
        let solver = &mut self.solver;
        out.turning.resize(solver.plant.size(), 0.0);
        solver.plant.shorten(&solver.v[0], &mut out.turning);
        out.contacts.clear();
        for e in 0..solver.plant.contacts.len() {
            out.contacts.push(contact_rates(solver, &span, e, &out.turning));
        }
        modal_jerk(solver, &span, out);
        out.sensors.clear();
        for sensor in &solver.plant.sensors {
            let (row, v, a) = (&solver.plant.ports[*sensor].row, &solver.v[0], solver.accelerations());
            out.sensors.push([dot(row, v), dot(row, a), dot(row, &out.jerk)]);
        }
        Ok(())
    }

    /// Takes over `motion` and computes everything at its instant.
    fn at_instant(
        &mut self,
        motion: &Motion,
        duration: f64,
        inputs: &[Ramp],
    ) -> Result<Span, IntegrationError> {
        if duration.is_nan() {
            return Err(IntegrationError::Input { name: "duration", value: duration });
        }
        self.begin(motion, duration.min(1.0), inputs, &Settings::default())?;
        if !self.solver.prepare(&Span::START) {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        self.solver.accelerate();
        Ok(Span { duration, ..Span::START })
    }
}

/// Rates of displacement, velocity and force; `turning` is G q̇. Of a law `u̇ (1 + a T_u) = u̇_geo − a T_N Ṅ`, its
/// derivative, and `Ṫ = T_u u̇ + T_v ü + T_N Ṅ`.
fn contact_rates(solver: &mut StepSolver, span: &Span, e: usize, turning: &[f64]) -> [f64; 3] {
    let (contact, node) = (&solver.plant.contacts[e], solver.nodes[e][0]);
    let port = &solver.plant.ports[contact.port];
    let rate = span.rate(solver.ramps[contact.input]);
    let geometric_acceleration =
        port.along(&solver.v_end, &solver.pull) - port.shortening * dot(turning, &solver.v[0]);
    let flexibility = port.flexibility;
    let Some(law) = contact.law.as_deref() else {
        return [node.geometric_velocity - flexibility * rate, geometric_acceleration, rate];
    };
    let velocity = node.own_velocity(flexibility, rate);
    // No law knows how its tangents change: a look at them a moment later.
    let highest = solver.plant.angular_frequency.iter().copied().fold(0.0, f64::max);
    let ahead = AHEAD / if highest > 0.0 { highest } else { 1.0 };
    let place = contact.memory.clone();
    // The rate of the force on a straight line from here, and what the law says there.
    let mut later = |time: f64| {
        let inputs = Inputs {
            displacement: node.displacement + time * velocity,
            velocity: if contact.series == 0.0 { node.geometric_velocity } else { velocity },
            normal_load: node.normal_load + time * rate,
        };
        let response =
            law.step(&solver.memory[place.clone()], inputs, &mut solver.memory_next[place.clone()]);
        let t = response.tangents;
        (t.displacement * velocity + t.normal_load * rate, response)
    };
    let ((soon, response), (then, _)) = (later(ahead), later(2.0 * ahead));
    let same = response.slip_state == node.slip_state && response.slip_state != SlipState::Separated;
    let bend = if same { (then - soon) / ahead } else { 0.0 };
    let slope = 1.0 + flexibility * node.tangent;
    let acceleration = (geometric_acceleration - flexibility * bend) / slope;
    let followed = if contact.series == 0.0 { geometric_acceleration } else { acceleration };
    let force = node.tangent * velocity + response.tangents.velocity * followed + node.load_tangent * rate;
    [velocity, acceleration, force]
}

/// `q⃛ = ṗ − 2ζω q̈ − ω² q̇` with `p = − Σ F (b − γ G q)` over all ports and `ṗ` its rate.
fn modal_jerk(solver: &StepSolver, span: &Span, out: &mut OutputRates) {
    let plant = &solver.plant;
    let (q, v, a) = (&solver.q[0], &solver.v[0], solver.accelerations());
    out.jerk.clear();
    out.jerk.resize(plant.size(), 0.0);
    // By a force and its rate at a port.
    let (jerk, turning) = (&mut out.jerk, &out.turning);
    let mut push = |port: usize, force: f64, rate: f64| {
        let port = &plant.ports[port];
        let parts = port.row.iter().zip(&solver.pull).zip(turning);
        for (jerk, ((b, g), turning)) in jerk.iter_mut().zip(parts) {
            *jerk -= rate * (b - port.shortening * g) - force * port.shortening * turning;
        }
    };
    for (port, ramp) in plant.driven.iter().zip(&solver.ramps) {
        push(*port, 0.0, -span.rate(*ramp));
    }
    for ((contact, at), rates) in plant.contacts.iter().zip(&solver.nodes).zip(&out.contacts) {
        push(contact.port, at[0].force, rates[2]);
    }
    for springs in &plant.springs {
        let motion = springs.ports.map(|port| plant.ports[port].motion(q, v, &solver.pull));
        let forces = springs.forces(motion.map(|(displacement, _)| displacement));
        let rates = springs.forces(motion.map(|(_, velocity)| velocity));
        for ((port, force), rate) in springs.ports.iter().zip(forces).zip(rates) {
            push(*port, force, rate);
        }
    }
    if !plant.damping.is_empty() {
        // No longer needed: G q̇.
        out.turning.fill(0.0);
        add_product(&plant.damping, a, &mut out.turning);
        out.jerk.iter_mut().zip(&out.turning).for_each(|(jerk, lost)| *jerk -= lost);
    }
    for (i, jerk) in out.jerk.iter_mut().enumerate() {
        let (omega, zeta) = (plant.angular_frequency[i], plant.damping_ratio[i]);
        *jerk -= 2.0 * zeta * omega * a[i] + omega * omega * v[i];
    }
}
