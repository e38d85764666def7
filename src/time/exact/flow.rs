//! The exact motion of a lumped oscillator with piecewise-linear contacts, from event to event.

use super::elements::{Element, Memory, elements};
use super::events::{Event, edges, first_event};
use super::passage::{Passage, RULE, widen};
use super::polynomial::{self, DEGREE, Series};
use super::system::{System, dot};
use super::{Excitation, OscillatorError};
use crate::contact::LoadedContact;
use crate::system::LinearStructure;

/// Moves a [`LinearStructure`] with piecewise-linear contacts under constant normal loads, exactly.
///
/// Between events the system is linear; its motion is summed as a Taylor series that ends at rounding.
/// Events (a limit or an edge of the play reached, slip ended by a reversal) are roots of such series:
/// all of them are isolated by the variations of Bernstein's coefficients, so that two events within a
/// step are both seen, and then located to rounding.
///
/// ```
/// use stickslip::contact::Jenkins;
/// use stickslip::time::{Excitation, LoadedContact, OscillatorFlow};
/// use stickslip::system::{LinearStructure, Output};
///
/// let row = vec![(0, 1.0)];
/// let structure = LinearStructure {
///     size: 1,
///     mass: vec![(0, 0, 1.0)],
///     damping: vec![(0, 0, 0.02)],
///     stiffness: vec![(0, 0, 1.0)],
///     contacts: vec![row.clone()],
///     excitation: row.clone(),
///     outputs: vec![Output { name: "mass".into(), row }],
/// };
/// let law = Jenkins::new(2.0, 0.3)?;
/// let mut flow = OscillatorFlow::new(&structure, &[LoadedContact { law: &law, normal_load: 1.0 }])?;
/// let mut motion = flow.rest();
/// let passage = flow.advance(&mut motion, 20.0, &Excitation::cosine(0.9, 1.0))?;
/// let taken = passage.total_dissipated_energy() + passage.viscous_energy + flow.energy(&motion);
/// assert!((taken - passage.work).abs() < 1e-12 * passage.work);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct OscillatorFlow {
    pub(super) system: System,
    pub(super) elements: Vec<Element>,
    step_limit: usize,
    series: Vec<f64>,
    force: Series,
    /// Stiffness and constant of every contact's force on the present branches.
    stiffness: Vec<f64>,
    constant: Vec<f64>,
    /// Constants of a disturbance's contact forces.
    varied: Vec<f64>,
    x: Vec<f64>,
    v: Vec<f64>,
}

/// State of a lumped oscillator with piecewise-linear contacts: a value, to be copied at will.
#[derive(Debug, Clone, PartialEq)]
pub struct OscillatorMotion {
    /// Time (s).
    pub(super) time: f64,
    pub(super) x: Vec<f64>,
    pub(super) v: Vec<f64>,
    pub(super) memory: Vec<Memory>,
    /// Contacts whose velocity is zero at this very instant: a reversal was located here.
    turning: Vec<bool>,
}

impl OscillatorMotion {
    /// Time (s).
    pub fn time(&self) -> f64 {
        self.time
    }
}

/// Derivatives of a motion by its start: columns of displacement, velocity and slider positions.
#[derive(Debug, Clone)]
pub(super) struct Variation {
    pub columns: Vec<Vec<f64>>,
}

impl OscillatorFlow {
    /// The flow of `structure`, whose contacts are `contacts` in the same order.
    ///
    /// # Errors
    /// A structure without mass somewhere or with entries out of place, a list of contacts of another
    /// length, a law that is not piecewise linear.
    pub fn new(structure: &LinearStructure, contacts: &[LoadedContact]) -> Result<Self, OscillatorError> {
        let system = System::new(structure)?;
        let count = system.contacts.len();
        if contacts.len() != count {
            return Err(OscillatorError::Length { name: "contacts", expected: count, found: contacts.len() });
        }
        let size = system.size;
        Ok(Self {
            series: system.series(),
            system,
            elements: elements(contacts)?,
            step_limit: 1_000_000,
            force: [0.0; DEGREE + 1],
            stiffness: vec![0.0; count],
            constant: vec![0.0; count],
            varied: vec![0.0; count],
            x: vec![0.0; size],
            v: vec![0.0; size],
        })
    }

    /// Most steps of one call of [`OscillatorFlow::advance`], a million unless set. Events that follow
    /// each other without end (chatter) then end in an error instead of never.
    pub fn set_step_limit(&mut self, limit: usize) {
        self.step_limit = limit;
    }

    /// At rest without any force, at time 0; the contacts remember nothing.
    pub fn rest(&self) -> OscillatorMotion {
        let n = self.system.size;
        self.begin(0.0, vec![0.0; n], vec![0.0; n], |_| 0.0)
    }

    /// A motion at `time` (s) with displacements (m), velocities (m/s) and slider positions (m) given. A
    /// slider whose force would be beyond its limit follows.
    ///
    /// # Errors
    /// Lists of another length than the structure and its sliders ask for, numbers that are not finite.
    pub fn motion(
        &self,
        time: f64,
        displacement: &[f64],
        velocity: &[f64],
        sliders: &[f64],
    ) -> Result<OscillatorMotion, OscillatorError> {
        let (n, m) = (self.system.size, self.elements.len());
        for (name, list, expected) in
            [("displacement", displacement, n), ("velocity", velocity, n), ("sliders", sliders, m)]
        {
            if list.len() != expected {
                return Err(OscillatorError::Length { name, expected, found: list.len() });
            }
            if let Some(value) = list.iter().find(|value| !value.is_finite()) {
                return Err(OscillatorError::Input { name, value: *value });
            }
        }
        if !time.is_finite() {
            return Err(OscillatorError::Input { name: "time", value: time });
        }
        let (x, v) = (self.system.inward(displacement), self.system.inward(velocity));
        Ok(self.begin(time, x, v, |k| sliders[k]))
    }

    pub(super) fn begin(
        &self,
        time: f64,
        x: Vec<f64>,
        v: Vec<f64>,
        position: impl Fn(usize) -> f64,
    ) -> OscillatorMotion {
        let start = |(k, element): (usize, &Element)| {
            let b = &self.system.contacts[element.contact];
            element.start(position(k), dot(b, &x), dot(b, &v))
        };
        let memory = self.elements.iter().enumerate().map(start).collect();
        OscillatorMotion { time, x, v, memory, turning: vec![false; self.system.contacts.len()] }
    }

    /// Displacements of the degrees of freedom (m).
    pub fn displacement(&self, motion: &OscillatorMotion) -> Vec<f64> {
        self.system.outward(&motion.x)
    }

    /// Velocities of the degrees of freedom (m/s).
    pub fn velocity(&self, motion: &OscillatorMotion) -> Vec<f64> {
        self.system.outward(&motion.v)
    }

    /// Slider positions (m), contact after contact.
    pub fn sliders(&self, motion: &OscillatorMotion) -> Vec<f64> {
        let position = |(element, memory): (&Element, &Memory)| {
            element.position(memory, dot(&self.system.contacts[element.contact], &motion.x))
        };
        self.elements.iter().zip(&motion.memory).map(position).collect()
    }

    /// Restoring force of every contact (N).
    pub fn contact_forces(&self, motion: &OscillatorMotion) -> Vec<f64> {
        let mut forces = vec![0.0; self.system.contacts.len()];
        for (element, memory) in self.elements.iter().zip(&motion.memory) {
            let (stiffness, constant) = element.force(memory);
            let u = dot(&self.system.contacts[element.contact], &motion.x);
            forces[element.contact] += stiffness * u + constant;
        }
        forces
    }

    /// Kinetic energy, and what springs of the structure and of the contacts store (J).
    pub fn energy(&self, motion: &OscillatorMotion) -> f64 {
        let stored = |(element, memory): (&Element, &Memory)| {
            element.energy(memory, dot(&self.system.contacts[element.contact], &motion.x))
        };
        let contacts: f64 = self.elements.iter().zip(&motion.memory).map(stored).sum();
        self.system.energy(&motion.x, &motion.v) + contacts
    }

    /// Moves `motion` by `duration` (s) under `excitation`.
    ///
    /// # Errors
    /// Illegal numbers; more steps than the limit; a motion that grows beyond all numbers. `motion` is
    /// then unchanged.
    pub fn advance(
        &mut self,
        motion: &mut OscillatorMotion,
        duration: f64,
        excitation: &Excitation,
    ) -> Result<Passage, OscillatorError> {
        excitation.check()?;
        if !(duration >= 0.0 && duration.is_finite()) {
            return Err(OscillatorError::Input { name: "duration", value: duration });
        }
        if motion.x.len() != self.system.size || motion.memory.len() != self.elements.len() {
            let (expected, found) = (self.system.size, motion.x.len());
            return Err(OscillatorError::Length { name: "motion", expected, found });
        }
        let mut moved = motion.clone();
        let passage = self.run(&mut moved, duration, excitation, None)?;
        *motion = moved;
        Ok(passage)
    }

    pub(super) fn run(
        &mut self,
        motion: &mut OscillatorMotion,
        duration: f64,
        excitation: &Excitation,
        mut variation: Option<&mut Variation>,
    ) -> Result<Passage, OscillatorError> {
        let (outputs, contacts) = (self.system.outputs.len(), self.system.contacts.len());
        let mut passage = Passage::new(outputs, contacts, self.elements.len());
        let end = motion.time + duration;
        self.branches(motion);
        while motion.time < end {
            if passage.steps == self.step_limit {
                return Err(OscillatorError::TooManySteps { limit: self.step_limit, time: motion.time });
            }
            passage.steps += 1;
            let longest = self.system.longest_step(&self.stiffness, excitation.fastest());
            let corner = excitation.until_corner(motion.time);
            let remaining = end - motion.time;
            let h = longest.min(corner).min(remaining);
            let (fraction, event) = self.step(motion, h, excitation, &mut passage, variation.as_deref_mut());
            // Where the whole of what remains was done, rounding must not leave a last sliver.
            motion.time = if fraction == 1.0 && h == remaining { end } else { motion.time + fraction * h };
            if !motion.x.iter().chain(&motion.v).all(|value| value.is_finite()) {
                return Err(OscillatorError::Diverged { time: motion.time });
            }
            motion.turning.fill(false);
            if let Some((contact, event)) = event {
                self.switch(motion, contact, event, variation.as_deref_mut());
                passage.events += 1;
                self.branches(motion);
            }
        }
        if let Some(variation) = variation {
            self.follow(motion, variation, |_| true);
        }
        Ok(passage)
    }

    /// Stiffness and constant of every contact's force on the branches of `motion`.
    fn branches(&mut self, motion: &OscillatorMotion) {
        self.stiffness.fill(0.0);
        self.constant.fill(0.0);
        for (element, memory) in self.elements.iter().zip(&motion.memory) {
            let (stiffness, constant) = element.force(memory);
            self.stiffness[element.contact] += stiffness;
            self.constant[element.contact] += constant;
        }
    }

    /// Moves to the end of a step of `h` or to its first event. Returns the fraction done and the event.
    fn step(
        &mut self,
        motion: &mut OscillatorMotion,
        h: f64,
        excitation: &Excitation,
        passage: &mut Passage,
        variation: Option<&mut Variation>,
    ) -> (f64, Option<(usize, Event)>) {
        excitation.expand(motion.time, h, &mut self.force);
        let contact_forces = (self.stiffness.as_slice(), self.constant.as_slice());
        self.system.expand(h, &motion.x, &motion.v, contact_forces, Some(&self.force), &mut self.series);
        let (mut fraction, mut first) = (1.0, None);
        for (contact, row) in self.system.contacts.iter().enumerate() {
            let u = self.system.project(&self.series, row);
            if let Some((at, event)) =
                first_event(&u, contact, motion.turning[contact], (&motion.memory, &self.elements))
                && (at < fraction || first.is_none())
            {
                (fraction, first) = (at, Some((contact, event)));
            }
        }
        for (contact, row) in self.system.contacts.iter().enumerate() {
            let u = self.system.project(&self.series, row);
            widen(&mut passage.contact_range[contact], &u, fraction);
            let travel = polynomial::value(&u, fraction) - u[0];
            let mut slips = false;
            for (k, element) in self.elements.iter().enumerate().filter(|(_, e)| e.contact == contact) {
                let sign = motion.memory[k].slip();
                if sign != 0.0 {
                    let limit =
                        if sign > 0.0 { element.slider.upper_limit } else { element.slider.lower_limit };
                    passage.dissipated_energy[contact] += (limit * sign * travel).max(0.0);
                    passage.slipped[k] |= travel != 0.0;
                    slips = true;
                }
            }
            if slips {
                passage.slip_time[contact] += fraction * h;
            }
        }
        for (range, row) in passage.output_range.iter_mut().zip(&self.system.outputs) {
            widen(range, &self.system.project(&self.series, row), fraction);
        }
        for (node, weight) in RULE {
            self.system.at(&self.series, h, fraction * node, &mut self.x, &mut self.v);
            let weight = weight * fraction * h;
            let force = polynomial::value(&self.force, fraction * node);
            passage.work += weight * force * dot(&self.system.excitation, &self.v);
            passage.viscous_energy += weight * self.system.viscous_power(&self.v);
        }
        self.system.at(&self.series, h, fraction, &mut motion.x, &mut motion.v);
        if let Some(variation) = variation {
            self.vary(motion, fraction * h, variation);
        }
        (fraction, first)
    }

    /// Moves disturbances along with a step of `duration` on the present branches.
    fn vary(&mut self, motion: &OscillatorMotion, duration: f64, variation: &mut Variation) {
        if duration <= 0.0 {
            return;
        }
        let n = self.system.size;
        for column in &mut variation.columns {
            let (moving, sliders) = column.split_at_mut(2 * n);
            let (x, v) = moving.split_at_mut(n);
            self.varied.fill(0.0);
            for ((element, memory), slider) in self.elements.iter().zip(&motion.memory).zip(sliders) {
                self.varied[element.contact] -= element.force(memory).0 * *slider;
            }
            let contact_forces = (self.stiffness.as_slice(), self.varied.as_slice());
            self.system.expand(duration, x, v, contact_forces, None, &mut self.series);
            self.system.at(&self.series, duration, 1.0, x, v);
        }
    }

    /// The sliders that slip and are `wanted` follow the displacement; so do their disturbances.
    ///
    /// Forces are continuous at every event, so displacement and velocity have no jump in their
    /// derivatives; slip begins with whatever the slider was disturbed by forgotten, and ends at zero
    /// velocity, where a shift of the instant moves nothing.
    fn follow(&self, motion: &OscillatorMotion, variation: &mut Variation, wanted: impl Fn(usize) -> bool) {
        let n = self.system.size;
        for column in &mut variation.columns {
            for (k, (element, memory)) in self.elements.iter().zip(&motion.memory).enumerate() {
                if memory.slip() != 0.0 && wanted(element.contact) {
                    column[2 * n + k] = dot(&self.system.contacts[element.contact], &column[..n]);
                }
            }
        }
    }

    fn switch(
        &self,
        motion: &mut OscillatorMotion,
        contact: usize,
        event: Event,
        variation: Option<&mut Variation>,
    ) {
        let u = dot(&self.system.contacts[contact], &motion.x);
        if event == Event::Turn {
            if let Some(variation) = variation {
                self.follow(motion, variation, |c| c == contact);
            }
            motion.turning[contact] = true;
        }
        let of_contact = |element: &Element| element.contact == contact;
        let edge = edges(contact, &motion.memory, &self.elements);
        for (element, memory) in self.elements.iter().zip(&mut motion.memory).filter(|(e, _)| of_contact(e)) {
            match event {
                Event::Rise if memory.upper_edge <= edge.1.max(u) => element.rise(memory, u),
                Event::Fall if memory.lower_edge >= edge.0.min(u) => element.fall(memory, u),
                Event::Turn => element.turn(memory, u),
                _ => {}
            }
        }
    }
}
