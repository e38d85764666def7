//! The integrator of the modal beam: checks, step-size control, outputs.

use super::change::{BeamChange, BeamInputChange};
use super::motion::BeamMotion;
use super::step::{Span, StepSolver};
use super::trial::Trial;
use super::{BeamError, BeamInputs, Contact, IntegrationError, Ramp, Settings};
use crate::contact::{ContactLaw, Inputs, SlipState};
use crate::system::ModalBeam;

/// Part of the tolerance that one step may use, so that their sum over some cycles stays near it.
const STEP_SHARE: f64 = 0.2;
/// Largest step, in radians of the lowest mode: the nodes of a step must see every reversal.
const LARGEST_ANGLE: f64 = 0.4;
/// Step tried first from a state that has no suggestion, in radians of the lowest mode.
const FIRST_ANGLE: f64 = 0.1;
/// An event does not cut a step shorter than this part of it: what happens twice within so short a
/// time is rounding.
const SHORTEST_CUT: f64 = 1e-5;
/// Smallest step, in radians of the highest mode.
const SMALLEST_ANGLE: f64 = 1e-9;

/// Integrates a [`ModalBeam`] in time; see the [module](crate::time) for equations and method.
///
/// It holds the beam and buffers, never the state: any number of [`BeamMotion`]s may take turns, and
/// [`BeamIntegrator::advance`] depends on its arguments alone. After the first call with a contact law
/// nothing allocates.
///
/// ```
/// use stickslip::contact::Jenkins;
/// use stickslip::time::{BeamInputs, BeamIntegrator, Contact, Ramp, Settings};
/// use stickslip::system::ModalBeam;
///
/// let beam = ModalBeam {
///     angular_frequency: vec![330.0],
///     damping_ratio: vec![0.003],
///     contact_shape: vec![0.057],
///     excitation_shape: vec![1.2],
///     shortening: vec![20.0],
///     axial_flexibility: 1.5e-8,
///     stretching_stiffness: 0.0,
///     string_stiffness: 0.0,
///     string_stretch: vec![],
///     quadratic_damping: 0.0,
///     sensors: vec![],
///     contact_points: vec![],
/// };
/// let law = Jenkins::new(7.9e6, 0.6)?;
/// let mut integrator = BeamIntegrator::new(&beam)?;
/// let mut motion = integrator.rest(Some((&law, 150.0)));
/// let inputs = BeamInputs {
///     excitation: Ramp::held(5.0),
///     contact: Contact::Friction { law: &law, normal_load: Ramp::held(150.0) },
///     at_points: &[],
/// };
/// integrator.advance(&mut motion, 1e-3, &inputs, &Settings::default())?;
/// assert!(motion.contact_force() > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct BeamIntegrator {
    pub(super) solver: StepSolver,
    largest_step: f64,
    smallest_step: f64,
}

/// What a sensor reads.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct SensorReading {
    /// Transverse displacement (m).
    pub displacement: f64,
    /// Transverse velocity (m/s).
    pub velocity: f64,
    /// Transverse acceleration (m/s²), from the equation of motion at this instant.
    pub acceleration: f64,
}

/// Outputs at one instant; see [`BeamIntegrator::outputs`].
#[derive(Debug, Clone, PartialEq)]
pub struct BeamOutputs {
    /// Relative tangential displacement u at the contact (m).
    pub displacement: f64,
    /// Its rate (m/s).
    pub velocity: f64,
    /// Restoring contact force T (N).
    pub contact_force: f64,
    /// Stick, slip or separated; always stick under an external force.
    pub slip_state: SlipState,
    /// Energy dissipated in the contact since the start (J).
    pub dissipated_energy: f64,
    /// One reading per sensor of the beam.
    pub sensors: Vec<SensorReading>,
}

impl BeamIntegrator {
    /// An integrator of `beam`.
    ///
    /// # Errors
    /// [`BeamError`] where lists differ in length, a number is not finite, a frequency, damping ratio
    /// or flexibility is negative, or `shortening` is not symmetric to 1e-9 of its largest entry.
    pub fn new(beam: &ModalBeam) -> Result<Self, BeamError> {
        check_beam(beam)?;
        let positive = || beam.angular_frequency.iter().copied().filter(|&omega| omega > 0.0);
        let lowest = positive().fold(f64::INFINITY, f64::min);
        let highest = positive().fold(0.0, f64::max);
        Ok(Self {
            solver: StepSolver::new(beam),
            largest_step: if lowest.is_finite() { LARGEST_ANGLE / lowest } else { f64::INFINITY },
            smallest_step: if highest > 0.0 { SMALLEST_ANGLE / highest } else { 0.0 },
        })
    }

    /// The beam.
    pub fn beam(&self) -> &ModalBeam {
        &self.solver.beam
    }

    /// The beam at rest without any force, and a contact that remembers nothing: `friction` is the
    /// law and the normal load (N), `None` for an external contact force.
    pub fn rest(&mut self, friction: Option<(&dyn ContactLaw, f64)>) -> BeamMotion {
        let mut motion = self.empty(friction.map_or(0, |(law, _)| law.state_len()));
        if let Some((law, normal_load)) = friction {
            self.attach(&mut motion, law, normal_load, 0.0);
        }
        motion
    }

    /// The beam with modal displacements `q` (m √kg) and velocities `v` (m √kg/s). `friction` is the
    /// law, the normal load (N) and the force (N) the contact carries at the start, cut to its limit.
    ///
    /// # Errors
    /// [`BeamError`] where `q` or `v` does not have one finite entry per mode.
    pub fn moving(
        &mut self,
        q: &[f64],
        v: &[f64],
        friction: Option<(&dyn ContactLaw, f64, f64)>,
    ) -> Result<BeamMotion, BeamError> {
        let modes = self.beam().angular_frequency.len();
        check_list("modal displacement", q, modes, f64::is_finite)?;
        check_list("modal velocity", v, modes, f64::is_finite)?;
        let mut motion = self.empty(friction.map_or(0, |(law, ..)| law.state_len()));
        motion.modal_displacement_mut().copy_from_slice(q);
        motion.modal_velocity_mut().copy_from_slice(v);
        if let Some((law, normal_load, force)) = friction {
            self.attach(&mut motion, law, normal_load, force);
        }
        Ok(motion)
    }

    fn empty(&self, contact_len: usize) -> BeamMotion {
        BeamMotion::zero(self.beam().angular_frequency.len(), contact_len)
    }

    /// Sets the contact of `motion` to carry `force` (N) where the modes put it.
    fn attach(&mut self, motion: &mut BeamMotion, law: &dyn ContactLaw, normal_load: f64, force: f64) {
        self.solver.reserve_contact(law.state_len());
        self.solver.load(motion);
        self.solver.geometry(0);
        let geometric = self.solver.nodes[0].geometric_displacement;
        let flexibility = self.beam().axial_flexibility;
        let (mut force, mut displacement) = (force, geometric);
        // The second pass puts a force that the first one cut where the axial spring then holds it.
        for _ in 0..2 {
            displacement = geometric - flexibility * force;
            law.set_state(displacement, normal_load, force, motion.contact_state_mut());
            let inputs = Inputs { displacement, velocity: 0.0, normal_load };
            let response = law.step(motion.contact_state(), inputs, &mut self.solver.contact);
            force = response.force;
            motion.set_tangent(response.tangents.displacement);
            motion.set_load_tangent(response.tangents.normal_load);
            motion.set_slip_state(f64::from(response.slip_state as i32));
        }
        motion.set_contact_force(force);
        motion.set_displacement(displacement);
        motion.set_normal_load(normal_load);
    }

    /// Advances `motion` by `duration` (s) under `inputs`.
    ///
    /// # Errors
    /// [`IntegrationError`]; `motion` is then unchanged.
    pub fn advance(
        &mut self,
        motion: &mut BeamMotion,
        duration: f64,
        inputs: &BeamInputs,
        settings: &Settings,
    ) -> Result<(), IntegrationError> {
        check_inputs(duration, inputs, settings)?;
        self.check_motion(motion, inputs)?;
        self.solver.load(motion);
        let mut suggested = self.first_step(motion);
        self.run(duration, inputs, settings, &mut suggested, None)?;
        self.solver.unload(motion, matches!(inputs.contact, Contact::Friction { .. }));
        motion.set_suggested_step(suggested.min(f64::MAX));
        Ok(())
    }

    /// The step tried first from `motion` (s).
    pub(super) fn first_step(&self, motion: &BeamMotion) -> f64 {
        let suggested = motion.suggested_step();
        if suggested > 0.0 { suggested } else { FIRST_ANGLE / LARGEST_ANGLE * self.largest_step }
    }

    /// The steps of one communication step; `following` goes along with a change of the inputs.
    pub(super) fn run(
        &mut self,
        duration: f64,
        inputs: &BeamInputs,
        settings: &Settings,
        suggested: &mut f64,
        mut following: Option<(&mut BeamChange, &BeamInputChange)>,
    ) -> Result<(), IntegrationError> {
        let load_rate = match inputs.contact {
            Contact::Friction { normal_load: load, .. } => (load.end - load.start) / duration,
            Contact::Force(_) => 0.0,
        };
        let smallest = self.smallest_step.max(1e-14 * duration);
        let mut span = Span { inputs, step: 0.0, from: 0.0, to: 0.0, load_rate };
        let load_before = self.solver.nodes[0].normal_load;
        if !self.solver.prepare(&span) {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        if let Some((change, by)) = &mut following {
            let jumped = self.solver.nodes[0].normal_load != load_before;
            change.jump(&self.solver, &inputs.contact, by, jumped);
        }
        let mut time = 0.0;
        // A step cut short at an event, and how long it was at first.
        let (mut shortened, mut uncut) = (None, 0.0_f64);
        for _ in 0..settings.step_limit {
            let remaining = duration - time;
            let (step, last) = match shortened {
                Some(step) if step < remaining => (step, false),
                _ => choose(duration, remaining, suggested.min(self.largest_step)),
            };
            span.step = step;
            span.to = if last { 1.0 } else { (time + step) / duration };
            match self.solver.attempt(&span, STEP_SHARE * settings.tolerance) {
                Trial::Done { event: Some(fraction), .. }
                    if fraction * step >= smallest.max(SHORTEST_CUT * uncut) =>
                {
                    uncut = uncut.max(step);
                    shortened = Some(fraction * step);
                }
                Trial::Done { error, .. } if error <= 1.0 => {
                    if let Some((change, by)) = &mut following {
                        change.through(&self.solver, &span, by);
                    }
                    if !self.solver.commit(&span) {
                        return Err(IntegrationError::StepTooSmall { time, step });
                    }
                    if let Some((change, by)) = &mut following {
                        change.arrive(&self.solver, &inputs.contact, span.to, by);
                    }
                    *suggested = suggest(*suggested, step, error);
                    (shortened, uncut) = (None, 0.0);
                    if last {
                        return Ok(());
                    }
                    time += step;
                    span.from = span.to;
                }
                failed => {
                    let factor = match failed {
                        Trial::Done { error, .. } => (0.9 * error.powf(-0.2)).clamp(0.1, 0.9),
                        Trial::Diverged => 0.4,
                    };
                    *suggested = factor * step;
                    (shortened, uncut) = (None, 0.0);
                    if *suggested < smallest {
                        return Err(IntegrationError::StepTooSmall { time, step: *suggested });
                    }
                }
            }
        }
        Err(IntegrationError::TooManySteps { limit: settings.step_limit, time })
    }

    /// Outputs of `motion` under the inputs of this instant: the starts of the ramps, and their rates
    /// over `duration` (s; infinite for held inputs). `motion` is not changed: a normal load that
    /// jumps is answered as the next step will answer it.
    ///
    /// # Errors
    /// [`IntegrationError`] where an input is not finite or the motion belongs to another beam.
    pub fn outputs(
        &mut self,
        motion: &BeamMotion,
        duration: f64,
        inputs: &BeamInputs,
        out: &mut BeamOutputs,
    ) -> Result<(), IntegrationError> {
        if duration.is_nan() {
            return Err(IntegrationError::Input { name: "duration", value: duration });
        }
        check_inputs(duration.min(1.0), inputs, &Settings::default())?;
        self.check_motion(motion, inputs)?;
        let rate = |ramp: Ramp| if ramp.start == ramp.end { 0.0 } else { (ramp.end - ramp.start) / duration };
        self.solver.load(motion);
        let span = Span { inputs, step: 0.0, from: 0.0, to: 0.0, load_rate: 0.0 };
        if !self.solver.prepare(&span) {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        let contact = self.solver.nodes[0];
        let flexibility = self.beam().axial_flexibility;
        out.displacement = contact.geometric_displacement - flexibility * contact.force;
        out.velocity = match inputs.contact {
            Contact::Force(force) => contact.geometric_velocity - flexibility * rate(force),
            Contact::Friction { normal_load, .. } => contact.velocity(flexibility, rate(normal_load)),
        };
        out.contact_force = contact.force;
        out.slip_state = contact.slip_state;
        out.dissipated_energy = self.solver.dissipated_energy;
        self.read_sensors(&mut out.sensors);
        Ok(())
    }

    /// Room for the outputs of this beam.
    pub fn new_outputs(&self) -> BeamOutputs {
        BeamOutputs {
            displacement: 0.0,
            velocity: 0.0,
            contact_force: 0.0,
            slip_state: SlipState::Stick,
            dissipated_energy: 0.0,
            sensors: vec![SensorReading::default(); self.beam().sensors.len()],
        }
    }

    fn read_sensors(&mut self, readings: &mut Vec<SensorReading>) {
        self.solver.accelerate();
        let solver = &self.solver;
        readings.resize(solver.beam.sensors.len(), SensorReading::default());
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        for (reading, sensor) in readings.iter_mut().zip(&solver.beam.sensors) {
            reading.displacement = dot(&sensor.shape, &solver.q[0]);
            reading.velocity = dot(&sensor.shape, &solver.v[0]);
            reading.acceleration = dot(&sensor.shape, solver.accelerations());
        }
    }

    pub(super) fn check_motion(
        &mut self,
        motion: &BeamMotion,
        inputs: &BeamInputs,
    ) -> Result<(), IntegrationError> {
        let modes = self.beam().angular_frequency.len();
        let contact_len = match inputs.contact {
            Contact::Force(_) => motion.contact_state().len(),
            Contact::Friction { law, .. } => law.state_len(),
        };
        let expected = BeamMotion::len_for(modes, contact_len);
        if motion.modes() != modes || motion.state_len() != expected {
            return Err(IntegrationError::MotionLength { expected, found: motion.state_len() });
        }
        let (expected, found) = (self.beam().contact_points.len(), inputs.at_points.len());
        if expected != found {
            return Err(IntegrationError::ContactPoints { expected, found });
        }
        self.solver.reserve_contact(contact_len);
        match motion.state().iter().position(|value| !value.is_finite()) {
            Some(index) => Err(IntegrationError::MotionNotFinite { index }),
            None => Ok(()),
        }
    }
}

/// The next step towards the end of a communication step, and whether it reaches it. Steps are the
/// communication step divided by 1, 2, 3, 4, 6, 8, 12 ..., so that few different ones occur and the
/// coefficients computed for one serve the next.
fn choose(duration: f64, remaining: f64, wanted: f64) -> (f64, bool) {
    if remaining <= wanted * (1.0 + 1e-9) {
        return (remaining, true);
    }
    let parts = (duration / wanted).ceil().max(1.0);
    let power = 2f64.powf(parts.log2().floor());
    let parts = [power, 1.5 * power, 2.0 * power].into_iter().find(|&p| p >= parts).unwrap_or(2.0 * power);
    let step = duration / parts;
    if (remaining - step).abs() <= 1e-11 * step {
        (step, true)
    } else if remaining < step {
        (remaining, true)
    } else if remaining < 2.0 * step * (1.0 - 1e-9) {
        // Two halves rather than a step and a sliver.
        (0.5 * remaining, false)
    } else {
        (step, false)
    }
}

/// Step suggested after one of `step` (s) with this error relative to the tolerance. A step cut short
/// by an event or by the end has an error too small to tell much; then the old suggestion stands.
fn suggest(suggested: f64, step: f64, error: f64) -> f64 {
    let factor = 0.9 * error.max(1e-30).powf(-0.2);
    if factor < 4.0 { factor * step } else { suggested.max(4.0 * step) }
}

pub(super) fn check_inputs(
    duration: f64,
    inputs: &BeamInputs,
    settings: &Settings,
) -> Result<(), IntegrationError> {
    let illegal = |name, value| Err(IntegrationError::Input { name, value });
    if !(duration.is_finite() && duration > 0.0) {
        return illegal("duration", duration);
    }
    if !(1e-13..=0.1).contains(&settings.tolerance) {
        return illegal("tolerance", settings.tolerance);
    }
    let contact = match inputs.contact {
        Contact::Force(force) => ("contact_force", force),
        Contact::Friction { normal_load, .. } => ("normal_load", normal_load),
    };
    let at_points = inputs.at_points.iter().map(|force| ("force at a contact point", *force));
    for (name, ramp) in [("excitation", inputs.excitation), contact].into_iter().chain(at_points) {
        for value in [ramp.start, ramp.end] {
            if !value.is_finite() {
                return illegal(name, value);
            }
        }
    }
    Ok(())
}

fn check_beam(beam: &ModalBeam) -> Result<(), BeamError> {
    let modes = beam.angular_frequency.len();
    let positive = |value: f64| value.is_finite() && value >= 0.0;
    if modes == 0 {
        return Err(BeamError::Length { field: "angular_frequency", expected: 1, found: 0 });
    }
    check_list("angular_frequency", &beam.angular_frequency, modes, positive)?;
    check_list("damping_ratio", &beam.damping_ratio, modes, positive)?;
    check_list("contact_shape", &beam.contact_shape, modes, f64::is_finite)?;
    check_list("excitation_shape", &beam.excitation_shape, modes, f64::is_finite)?;
    check_list("shortening", &beam.shortening, modes * modes, f64::is_finite)?;
    let string = if beam.string_stiffness == 0.0 { beam.string_stretch.len() } else { modes };
    check_list("string_stretch", &beam.string_stretch, string, f64::is_finite)?;
    check_list("string_stiffness", &[beam.string_stiffness], 1, f64::is_finite)?;
    check_list("axial_flexibility", &[beam.axial_flexibility], 1, positive)?;
    for sensor in &beam.sensors {
        check_list("sensor shape", &sensor.shape, modes, f64::is_finite)?;
    }
    for point in &beam.contact_points {
        check_list("contact point's shape", &point.shape, modes, f64::is_finite)?;
    }
    let largest = beam.shortening.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
    for row in 0..modes {
        for column in 0..row {
            let (a, b) = (beam.shortening[row * modes + column], beam.shortening[column * modes + row]);
            if (a - b).abs() > 1e-9 * largest {
                return Err(BeamError::Asymmetric { row, column });
            }
        }
    }
    Ok(())
}

fn check_list(
    field: &'static str,
    values: &[f64],
    expected: usize,
    legal: impl Fn(f64) -> bool,
) -> Result<(), BeamError> {
    if values.len() != expected {
        return Err(BeamError::Length { field, expected, found: values.len() });
    }
    match values.iter().find(|&&value| !legal(value)) {
        Some(&value) => Err(BeamError::Value { field, value }),
        None => Ok(()),
    }
}
