//! The integrator: checks, step-size control, beginnings.

use super::motion::{ContactMotion, Motion};
use super::plant::Plant;
use super::step::{Span, StepSolver};
use super::tangent::Tangent;
use super::trial::Trial;
use super::{IntegrationError, Ramp, Settings, SystemError};
use crate::contact::Inputs;
use crate::system::System;

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

/// Integrates a [`System`] in time; see the [module](crate::time) for equations and method.
///
/// It holds the system and buffers, never the state: any number of [`Motion`]s may take turns, and
/// [`Integrator::advance`] depends on its arguments alone. Nothing allocates in a step.
///
/// Inputs are one [`Ramp`] each over the communication step: the forces on the driven ports, then, in the order of the
/// system's elements, the normal load of every law and every force from outside.
///
/// ```
/// use std::sync::Arc;
/// use stickslip::contact::Jenkins;
/// use stickslip::time::{Integrator, Ramp, Settings};
/// use stickslip::system::{Core, Element, Port, System};
///
/// let law = Arc::new(Jenkins::new(30.0, 0.4)?);
/// let system = System {
///     core: Core::Modal { angular_frequency: vec![5.0], damping_ratio: vec![0.01] },
///     shortening: vec![],
///     ports: vec![Port::linear("mass", vec![(0, 0.7)])],
///     elements: vec![Element::Law { port: 0, law, normal_load: 2.0 }],
///     driven: vec![0],
///     sensors: vec![0],
/// };
/// let mut integrator = Integrator::new(&system)?;
/// let inputs = [Ramp::held(5.0), Ramp::held(2.0)];
/// let mut motion = integrator.rest(&inputs)?;
/// integrator.advance(&mut motion, 0.1, &inputs, &Settings::default())?;
/// assert!(motion.contact(0).force > 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Integrator {
    pub(super) solver: StepSolver,
    largest_step: f64,
    smallest_step: f64,
}

impl Integrator {
    /// An integrator of `system`.
    ///
    /// # Errors
    /// [`SystemError`] where lists differ in length, a number is not finite, a frequency, damping ratio, stiffness or
    /// flexibility is negative, a matrix is not symmetric to 1e-9 of its largest entry, or mass is missing.
    pub fn new(system: &System) -> Result<Self, SystemError> {
        let plant = Plant::new(system)?;
        let positive = || plant.angular_frequency.iter().copied().filter(|&omega| omega > 0.0);
        let lowest = positive().fold(f64::INFINITY, f64::min);
        let highest = positive().fold(0.0, f64::max);
        Ok(Self {
            solver: StepSolver::new(plant),
            largest_step: if lowest.is_finite() { LARGEST_ANGLE / lowest } else { f64::INFINITY },
            smallest_step: if highest > 0.0 { SMALLEST_ANGLE / highest } else { 0.0 },
        })
    }

    /// The inputs under which nothing acts but the constant normal loads of the laws.
    pub fn held_inputs(&self) -> Vec<Ramp> {
        let plant = &self.solver.plant;
        let mut inputs = vec![Ramp::held(0.0); plant.inputs()];
        plant.contacts.iter().for_each(|contact| inputs[contact.input] = Ramp::held(contact.normal_load));
        inputs
    }

    /// The longest step (s) that is ever taken under control of the error.
    pub(crate) fn longest_controlled_step(&self) -> f64 {
        self.largest_step
    }

    /// Length of a motion's flat state.
    pub(crate) fn state_len(&self) -> usize {
        let plant = &self.solver.plant;
        Motion::len_for(plant.size(), plant.memory_len, plant.contacts.len())
    }

    /// The system at rest without any force, and laws that remember nothing but the normal loads at the start of
    /// `inputs`.
    ///
    /// # Errors
    /// [`IntegrationError`] where `inputs` are illegal.
    pub fn rest(&mut self, inputs: &[Ramp]) -> Result<Motion, IntegrationError> {
        self.check_inputs(1.0, inputs, &Settings::default())?;
        let mut motion = self.empty();
        self.attach(&mut motion, inputs, &[]);
        Ok(motion)
    }

    /// The system with displacements and velocities of its coordinates. Every law carries its part of `forces` (N), cut
    /// to its limit, and none where the list ends.
    ///
    /// # Errors
    /// [`IntegrationError`] where a list does not have one finite entry per coordinate, or `inputs` are illegal.
    pub fn moving(
        &mut self,
        displacement: &[f64],
        velocity: &[f64],
        inputs: &[Ramp],
        forces: &[f64],
    ) -> Result<Motion, IntegrationError> {
        self.check_inputs(1.0, inputs, &Settings::default())?;
        for list in [displacement, velocity] {
            let (expected, found) = (self.solver.plant.size(), list.len());
            if expected != found {
                return Err(IntegrationError::MotionLength { expected, found });
            }
            if let Some(index) = list.iter().position(|value| !value.is_finite()) {
                return Err(IntegrationError::MotionNotFinite { index });
            }
        }
        let mut motion = self.empty();
        let (q, v) = motion.modal_mut();
        q.copy_from_slice(&self.solver.plant.inward(displacement));
        v.copy_from_slice(&self.solver.plant.inward(velocity));
        self.attach(&mut motion, inputs, forces);
        Ok(motion)
    }

    /// Displacements of the system's coordinates, those of resonators' masses behind the others.
    pub fn displacement(&self, motion: &Motion) -> Vec<f64> {
        self.solver.plant.outward(motion.modal_displacement())
    }

    /// Velocities of the same.
    pub fn velocity(&self, motion: &Motion) -> Vec<f64> {
        self.solver.plant.outward(motion.modal_velocity())
    }

    fn empty(&self) -> Motion {
        let plant = &self.solver.plant;
        Motion::zero(plant.size(), plant.memory_len, plant.contacts.len())
    }

    /// Sets the laws to carry `forces` (N) where the modes put them.
    fn attach(&mut self, motion: &mut Motion, inputs: &[Ramp], forces: &[f64]) {
        let solver = &mut self.solver;
        solver.load(motion);
        solver.geometry(0);
        for (e, contact) in solver.plant.contacts.iter().enumerate() {
            let Some(law) = contact.law.as_deref() else { continue };
            let normal_load = inputs[contact.input].start;
            let at = solver.nodes[e][0];
            let flexibility = solver.plant.ports[contact.port].flexibility;
            let mut force = forces.get(e).copied().unwrap_or(0.0);
            // The second pass puts a force that the first one cut where the flexibility then holds it.
            for _ in 0..2 {
                let displacement = at.geometric_displacement - flexibility * force;
                let memory = &mut motion.memory_mut()[contact.memory.clone()];
                law.set_state(displacement, normal_load, force, memory);
                let inputs = Inputs { displacement, velocity: at.geometric_velocity, normal_load };
                let response = law.step(memory, inputs, &mut solver.memory_next[contact.memory.clone()]);
                force = response.force;
                let attached = ContactMotion {
                    force,
                    tangent: response.tangents.displacement,
                    load_tangent: response.tangents.normal_load,
                    displacement,
                    normal_load,
                    slip_state: response.slip_state,
                    dissipated_energy: 0.0,
                };
                motion.set_contact(e, &attached);
            }
        }
    }

    /// Moves the laws at once to where the modes of `motion` now are, after those were changed by hand.
    pub(crate) fn settle(&mut self, motion: &mut Motion, inputs: &[Ramp]) -> Result<(), IntegrationError> {
        self.begin(motion, 1.0, inputs, &Settings::default())?;
        if !self.solver.settle() {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        self.solver.unload(motion);
        Ok(())
    }

    /// Moves the system's coordinates at once to such displacements, and the laws to where these put them; its velocities stay.
    #[cfg(feature = "analysis")]
    pub(crate) fn displace(
        &mut self,
        motion: &mut Motion,
        displacement: &[f64],
        inputs: &[Ramp],
    ) -> Result<(), IntegrationError> {
        let moved = self.solver.plant.inward(displacement);
        motion.modal_mut().0.copy_from_slice(&moved);
        self.settle(motion, inputs)
    }

    /// Accelerations of the modes of the motion that [`Integrator::outputs`] was asked for last.
    pub(crate) fn modal_accelerations(&self) -> &[f64] {
        self.solver.accelerations()
    }

    /// Advances `motion` by `duration` (s) under `inputs`; returns the number of steps that took.
    ///
    /// # Errors
    /// [`IntegrationError`]; `motion` is then unchanged.
    pub fn advance(
        &mut self,
        motion: &mut Motion,
        duration: f64,
        inputs: &[Ramp],
        settings: &Settings,
    ) -> Result<usize, IntegrationError> {
        self.begin(motion, duration, inputs, settings)?;
        if duration > self.largest_step * settings.step_limit as f64 {
            return Err(IntegrationError::TooManySteps { limit: settings.step_limit, time: 0.0 });
        }
        let mut suggested = self.first_step(motion);
        let steps = self.run(duration, settings, &mut suggested, None)?;
        self.solver.unload(motion);
        motion.set_suggested_step(suggested.min(f64::MAX));
        Ok(steps)
    }

    /// Checks everything and takes `motion` and `inputs` over.
    pub(super) fn begin(
        &mut self,
        motion: &Motion,
        duration: f64,
        inputs: &[Ramp],
        settings: &Settings,
    ) -> Result<(), IntegrationError> {
        self.check_inputs(duration, inputs, settings)?;
        self.check_motion(motion)?;
        self.solver.ramps.copy_from_slice(inputs);
        self.solver.load(motion);
        Ok(())
    }

    /// The step tried first from `motion` (s).
    pub(super) fn first_step(&self, motion: &Motion) -> f64 {
        let suggested = motion.suggested_step();
        if suggested > 0.0 { suggested } else { FIRST_ANGLE / LARGEST_ANGLE * self.largest_step }
    }

    /// The steps of one communication step; `tangent` goes along with a change of the inputs.
    pub(super) fn run(
        &mut self,
        duration: f64,
        settings: &Settings,
        suggested: &mut f64,
        mut tangent: Option<(&mut Tangent, &[Ramp])>,
    ) -> Result<usize, IntegrationError> {
        let smallest = self.smallest_step.max(1e-14 * duration);
        let mut span = Span { step: 0.0, from: 0.0, to: 0.0, duration };
        if let Some((tangent, _)) = &mut tangent {
            tangent.before_jump(&self.solver);
        }
        if !self.solver.prepare(&span) {
            return Err(IntegrationError::StepTooSmall { time: 0.0, step: 0.0 });
        }
        if let Some((tangent, by)) = &mut tangent {
            tangent.jump(&self.solver, by);
        }
        let (mut time, mut steps) = (0.0, 0);
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
                    if !self.take(&span, &mut tangent) {
                        return Err(IntegrationError::StepTooSmall { time, step });
                    }
                    *suggested = suggest(*suggested, step, error);
                    (shortened, uncut) = (None, 0.0);
                    steps += 1;
                    if last {
                        return Ok(steps);
                    }
                    time += step;
                    span.from = span.to;
                }
                failed => {
                    *suggested = shortened_after(failed, step);
                    (shortened, uncut) = (None, 0.0);
                    if *suggested < smallest {
                        return Err(IntegrationError::StepTooSmall { time, step: *suggested });
                    }
                }
            }
        }
        Err(IntegrationError::TooManySteps { limit: settings.step_limit, time })
    }

    /// Takes over the step tried, with `tangent` through it. False where a law fails.
    fn take(&mut self, span: &Span, tangent: &mut Option<(&mut Tangent, &[Ramp])>) -> bool {
        if let Some((tangent, by)) = tangent {
            tangent.through(&self.solver, span, by);
        }
        let taken = self.solver.commit(span);
        if let (true, Some((tangent, by))) = (taken, tangent) {
            tangent.arrive(&self.solver, span.to, by);
        }
        taken
    }

    fn check_motion(&self, motion: &Motion) -> Result<(), IntegrationError> {
        let (plant, expected) = (&self.solver.plant, self.state_len());
        let fits = motion.modes() == plant.size() && motion.contacts() == plant.contacts.len();
        if !fits || motion.state_len() != expected {
            return Err(IntegrationError::MotionLength { expected, found: motion.state_len() });
        }
        match motion.state().iter().position(|value| !value.is_finite()) {
            Some(index) => Err(IntegrationError::MotionNotFinite { index }),
            None => Ok(()),
        }
    }

    pub(super) fn check_duration(&self, duration: f64) -> Result<(), IntegrationError> {
        let legal = duration.is_finite() && duration > 0.0;
        if legal { Ok(()) } else { Err(IntegrationError::Input { name: "duration", value: duration }) }
    }

    fn check_inputs(
        &self,
        duration: f64,
        inputs: &[Ramp],
        settings: &Settings,
    ) -> Result<(), IntegrationError> {
        let illegal = |name, value| Err(IntegrationError::Input { name, value });
        self.check_duration(duration)?;
        if !(1e-13..=0.1).contains(&settings.tolerance) {
            return illegal("tolerance", settings.tolerance);
        }
        let plant = &self.solver.plant;
        let (expected, found) = (plant.inputs(), inputs.len());
        if expected != found {
            return Err(IntegrationError::Inputs { expected, found });
        }
        let contacts = plant.contacts.iter();
        let contacts =
            contacts.map(|contact| if contact.law.is_some() { "normal_load" } else { "contact_force" });
        let names = plant.driven.iter().map(|_| "excitation").chain(contacts);
        for (name, ramp) in names.zip(inputs) {
            if let Some(value) = [ramp.start, ramp.end].into_iter().find(|value| !value.is_finite()) {
                return illegal(name, value);
            }
        }
        Ok(())
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

/// Step tried after one of `step` (s) that failed.
fn shortened_after(failed: Trial, step: f64) -> f64 {
    match failed {
        Trial::Done { error, .. } => (0.9 * error.powf(-0.2)).clamp(0.1, 0.9) * step,
        Trial::Diverged => 0.4 * step,
    }
}

/// Step suggested after one of `step` (s) with this error relative to the tolerance. A step cut short
/// by an event or by the end has an error too small to tell much; then the old suggestion stands.
fn suggest(suggested: f64, step: f64, error: f64) -> f64 {
    let factor = 0.9 * error.max(1e-30).powf(-0.2);
    if factor < 4.0 { factor * step } else { suggested.max(4.0 * step) }
}
