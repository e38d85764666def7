//! Derivatives with respect to time, and with respect to inputs, of what the beam integrator puts out.

use super::beam::{BeamIntegrator, check_inputs};
use super::change::{BeamChange, BeamInputChange};
use super::step::{Span, StepSolver};
use super::{BeamInputs, BeamMotion, Contact, IntegrationError, Ramp, Settings};
use crate::contact::{Inputs, SlipState};

/// How far ahead the slope of a contact's tangent is sought, in radians of the highest mode.
const AHEAD: f64 = 1e-5;

/// Derivatives with respect to time of what [`BeamIntegrator::outputs`] gives.
#[derive(Debug, Clone, Default)]
pub(crate) struct BeamRates {
    /// Of the contact's displacement (m/s) and velocity (m/s²).
    pub displacement: f64,
    pub velocity: f64,
    /// Of the contact force (N/s).
    pub contact_force: f64,
    /// Of each sensor's displacement (m/s), velocity (m/s²) and acceleration (m/s³).
    pub sensors: Vec<[f64; 3]>,
    jerk: Vec<f64>,
    product: Vec<f64>,
}

/// A contact's rates: of displacement, velocity and force.
type ContactRates = [f64; 3];

impl BeamIntegrator {
    /// Derivatives of the outputs of `motion`; the arguments are as those of [`BeamIntegrator::outputs`].
    pub(crate) fn output_rates(
        &mut self,
        motion: &BeamMotion,
        duration: f64,
        inputs: &BeamInputs,
        out: &mut BeamRates,
    ) -> Result<(), IntegrationError> {
        check_inputs(duration.min(1.0), inputs, &Settings::default())?;
        self.check_motion(motion, inputs)?;
        self.solver.load(motion);
        let span = Span { inputs, step: 0.0, from: 0.0, to: 0.0, load_rate: 0.0 };
        if !self.solver.prepare(&span) {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        self.solver.accelerate();
        let solver = &mut self.solver;
        let rate = |ramp: Ramp| if ramp.start == ramp.end { 0.0 } else { (ramp.end - ramp.start) / duration };
        let turning = times(&solver.beam.shortening, &solver.v[0], &mut out.product);
        let geometric_acceleration =
            dot(&solver.direction, solver.accelerations()) - dot(turning, &solver.v[0]);
        let rates = match inputs.contact {
            Contact::Force(force) => {
                let velocity = solver.nodes[0].geometric_velocity;
                let rate = rate(force);
                [velocity - solver.beam.axial_flexibility * rate, geometric_acceleration, rate]
            }
            Contact::Friction { normal_load, .. } => {
                contact_rates(solver, &inputs.contact, geometric_acceleration, rate(normal_load))
            }
        };
        [out.displacement, out.velocity, out.contact_force] = rates;
        modal_jerk(solver, rate(inputs.excitation), inputs.at_points.iter().map(|ramp| rate(*ramp)), out);
        out.sensors.clear();
        for sensor in &solver.beam.sensors {
            let (v, a) = (&solver.v[0], solver.accelerations());
            out.sensors.push([dot(&sensor.shape, v), dot(&sensor.shape, a), dot(&sensor.shape, &out.jerk)]);
        }
        Ok(())
    }

    /// The step of [`BeamIntegrator::advance`] from `motion`, which stays, with the change of the inputs `by`; `change`
    /// becomes that of the end. Without a `duration` it is that of `motion` itself, at rest with a contact that
    /// remembers nothing. Returns the changes of the contact's displacement and velocity.
    pub(crate) fn follow(
        &mut self,
        motion: &BeamMotion,
        duration: Option<f64>,
        inputs: &BeamInputs,
        settings: &Settings,
        (change, by): (&mut BeamChange, &BeamInputChange),
    ) -> Result<(f64, f64), IntegrationError> {
        check_inputs(duration.unwrap_or(1.0), inputs, settings)?;
        self.check_motion(motion, inputs)?;
        self.solver.load(motion);
        change.begin(&self.solver, motion);
        let Some(duration) = duration else {
            let span = Span { inputs, step: 0.0, from: 0.0, to: 0.0, load_rate: 0.0 };
            if let Contact::Friction { law, normal_load } = inputs.contact {
                change.begin_at_rest(law, normal_load.start, by.contact.start);
            }
            if !self.solver.prepare(&span) {
                return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
            }
            change.arrive(&self.solver, &inputs.contact, 0.0, by);
            return Ok(change.outputs(&self.solver, &inputs.contact, 0.0, 0.0));
        };
        let mut suggested = self.first_step(motion);
        self.run(duration, inputs, settings, &mut suggested, Some((change, by)))?;
        let load_rate = match inputs.contact {
            Contact::Friction { normal_load, .. } => (normal_load.end - normal_load.start) / duration,
            Contact::Force(_) => 0.0,
        };
        let rate_change = (by.contact.end - by.contact.start) / duration;
        Ok(change.outputs(&self.solver, &inputs.contact, load_rate, rate_change))
    }
}

/// `u̇ (1 + a T_u) = u̇_geo − a T_N Ṅ`, its derivative, and `Ṫ = T_u u̇ + T_v ü + T_N Ṅ`.
fn contact_rates(
    solver: &mut StepSolver,
    contact: &Contact,
    geometric_acceleration: f64,
    load_rate: f64,
) -> ContactRates {
    let Contact::Friction { law, .. } = contact else { return [0.0; 3] };
    let (flexibility, node) = (solver.beam.axial_flexibility, solver.nodes[0]);
    let velocity = node.velocity(flexibility, load_rate);
    // No law knows how its tangents change: a look at them a moment later.
    let highest = solver.beam.angular_frequency.iter().copied().fold(0.0, f64::max);
    let ahead = AHEAD / if highest > 0.0 { highest } else { 1.0 };
    // The rate of the force on a straight line from here, and what the law says there.
    let mut later = |time: f64| {
        let inputs = Inputs {
            displacement: node.displacement + time * velocity,
            velocity,
            normal_load: node.normal_load + time * load_rate,
        };
        let response = law.step(&solver.contact, inputs, &mut solver.contact_next);
        let t = response.tangents;
        (t.displacement * velocity + t.normal_load * load_rate, response)
    };
    let ((soon, response), (then, _)) = (later(ahead), later(2.0 * ahead));
    let same = response.slip_state == node.slip_state && response.slip_state != SlipState::Separated;
    let bend = if same { (then - soon) / ahead } else { 0.0 };
    let slope = 1.0 + flexibility * node.tangent;
    let acceleration = (geometric_acceleration - flexibility * bend) / slope;
    let force =
        node.tangent * velocity + response.tangents.velocity * acceleration + node.load_tangent * load_rate;
    [velocity, acceleration, force]
}

/// `q⃛ = ṗ − 2ζω q̈ − ω² q̇` with `ṗ` the rate of the forcing; `out.product` holds `G q̇`.
fn modal_jerk(
    solver: &StepSolver,
    excitation_rate: f64,
    force_rates: impl Iterator<Item = f64>,
    out: &mut BeamRates,
) {
    let (beam, acceleration) = (&solver.beam, solver.accelerations());
    let (q, v) = (&solver.q[0], &solver.v[0]);
    let mut excitation_rate = excitation_rate;
    if beam.quadratic_damping != 0.0 {
        let (speed, rate) = (dot(&beam.excitation_shape, v), dot(&beam.excitation_shape, acceleration));
        excitation_rate -= 2.0 * beam.quadratic_damping * speed.abs() * rate;
    }
    let stretching = beam.stretching_stiffness;
    let turning = &out.product;
    let (mut tension, mut tension_rate, mut shortening_rate) = (0.0, 0.0, 0.0);
    if beam.pulls_along() {
        for i in 0..q.len() {
            tension += stretching * (beam.contact_shape[i] - solver.direction[i]) * q[i];
            shortening_rate += turning[i] * q[i];
        }
        tension -= beam.string_pull(q);
        tension_rate = 2.0 * stretching * shortening_rate - beam.string_pull(v);
    }
    let force = solver.nodes[0].force;
    out.jerk.resize(q.len(), 0.0);
    beam.push(excitation_rate, force_rates, &mut out.jerk);
    for (i, jerk) in out.jerk.iter_mut().enumerate() {
        let (omega, zeta) = (beam.angular_frequency[i], beam.damping_ratio[i]);
        *jerk = *jerk - out.contact_force * solver.direction[i] + (force - tension) * turning[i]
            - tension_rate * (beam.contact_shape[i] - solver.direction[i])
            - 2.0 * zeta * omega * acceleration[i]
            - omega * omega * v[i];
    }
    for (jerk, s) in out.jerk.iter_mut().zip(&beam.string_stretch) {
        *jerk += beam.string_stiffness * shortening_rate * s;
    }
}

/// `G x`, G symmetric, in `out`.
fn times<'o>(matrix: &[f64], x: &[f64], out: &'o mut Vec<f64>) -> &'o [f64] {
    out.clear();
    out.extend(matrix.chunks_exact(x.len()).map(|row| dot(row, x)));
    out
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
