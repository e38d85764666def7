//! The behaviour of a model with a structure: a system whose ports are driven from outside.

use super::slip::SlipFraction;
use super::{LoadRule, MOST_STEPS, count_steps};
use crate::fmi::continuous::{self, ContinuousTime, Instant};
use crate::fmi::lines::Lines;
use crate::fmi::{Asked, Behaviour};
use crate::system::{Element, System};
use crate::time::{Integrator, Motion, OutputRates, Outputs, Ramp, Settings, Steps, Tangent};

/// Tolerances the integrator takes; a simulation's is moved to the nearest.
const TOLERANCES: (f64, f64) = (1e-13, 0.1);
/// Numbers of a motion that effects may add: those of a cubic spring, of drag and of a hanging mass. Room is kept for them, so that a
/// parameter may go through zero.
const ADDED: usize = 16;

/// How the rows of a table follow from a system, whose inputs they are, in the same order, but for what effects add.
///
/// The outputs are force, dissipated energy, slip state and slip fraction of the system's first law, if it is a contact; displacement
/// and velocity of its port, if that is shown; and displacement, velocity and acceleration of every sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Table {
    /// Number of inputs.
    pub inputs: usize,
    /// Which input is the normal load of a contact.
    pub load: Option<usize>,
    /// Whether the motion of the first law or outside force is an output.
    pub shows_port: bool,
    /// Whether inputs without a derivative run from their previous values to those set, or are held.
    pub runs: bool,
    /// The longest of equal steps (s), where the steps are not under control of their error.
    pub longest: Option<f64>,
}

/// Which output of a contact is its slip state.
const SLIP_STATE: usize = 2;

/// Integrator and work space.
///
/// The state is the motion now and the motion before the last step, each with its room; the energy (J) dissipated in that
/// step; its lines.
#[derive(Debug)]
pub(super) struct DrivenSystem {
    integrator: Integrator,
    table: Table,
    load: LoadRule,
    /// Of the first law, if there is one.
    slip: Option<SlipFraction>,
    /// Room for a motion.
    room: usize,
    motion: Motion,
    before: Motion,
    /// Inputs of the table over a step.
    lines: Lines,
    /// What acts on the system.
    acting: Vec<Ramp>,
    by: Vec<Ramp>,
    outputs: Outputs,
    /// Number of sensors.
    sensors: usize,
    rates: OutputRates,
    tangent: Tangent,
    /// The outputs as they stand in the table.
    row: Vec<f64>,
}

/// Tolerance that the longest of equal steps meets; the error falls with the square of the step.
const TOLERANCE_OF_LONGEST: f64 = 3e-4;
/// The longest step is divided by this at most.
const FINEST: f64 = 1000.0;

impl Table {
    /// The steps within a communication step of `step` (s).
    fn steps(&self, step: f64, tolerance: f64, integrator: &Integrator) -> Result<Steps, String> {
        let finer = (TOLERANCE_OF_LONGEST / tolerance).sqrt().clamp(1.0, FINEST);
        let longest = self.longest.map_or(integrator.longest_controlled_step(), |longest| longest / finer);
        let count = count_steps(step, longest)?;
        if self.longest.is_some() {
            return Ok(Steps::Equal(count));
        }
        let tolerance = tolerance.clamp(TOLERANCES.0, TOLERANCES.1);
        Ok(Steps::Controlled(Settings { tolerance, step_limit: MOST_STEPS }))
    }
}

impl DrivenSystem {
    /// `own` of the system's elements are not added by effects.
    pub fn new(system: &System, own: usize, table: Table, load: LoadRule) -> Result<Self, String> {
        let mut integrator = Integrator::new(system).map_err(|error| error.to_string())?;
        let mut plain = system.clone();
        plain.elements.truncate(own);
        let room = Integrator::new(&plain).map_err(|error| error.to_string())?.state_len() + ADDED;
        let held = vec![Ramp::held(0.0); integrator.held_inputs().len()];
        let motion = integrator.rest(&held).map_err(|error| error.to_string())?;
        let slip = system.elements.iter().find_map(|element| match element {
            Element::Law { law, .. } => Some(SlipFraction::new(&**law, load.constant)),
            _ => None,
        });
        Ok(Self {
            slip,
            lines: Lines::new(table.inputs, table.runs),
            by: held.clone(),
            acting: held,
            before: motion.clone(),
            integrator,
            table,
            load,
            room,
            motion,
            outputs: Outputs::default(),
            sensors: system.sensors.len(),
            rates: OutputRates::default(),
            tangent: Tangent::default(),
            row: Vec::new(),
        })
    }

    /// What acts where the inputs run as `along` says of the lines.
    fn act(&mut self, along: fn(&Lines, usize) -> Ramp) {
        for (input, acting) in self.acting.iter_mut().enumerate().take(self.lines.all.len()) {
            let line = along(&self.lines, input);
            *acting = if self.table.load == Some(input) { self.load.along(&line) } else { line };
        }
    }

    /// What the changes in `direction` of the inputs change of what acts, as `along` says of the lines.
    fn act_by(&mut self, direction: &[Ramp], along: fn(&Lines, usize, &Ramp) -> Ramp) {
        for (input, (by, change)) in self.by.iter_mut().zip(direction).take(self.table.inputs).enumerate() {
            let Ramp { start, end, bow, skew } = along(&self.lines, input, change);
            let gain = if self.table.load == Some(input) { self.load.gain() } else { 1.0 };
            *by = Ramp { start: gain * start, end: gain * end, bow: gain * bow, skew: gain * skew };
        }
    }

    /// Takes over the motion `now` of a state.
    fn read(motion: &mut Motion, state: &[f64]) -> Result<(), String> {
        if motion.read_state(&state[..motion.state_len()]) { Ok(()) } else { Err(wrong_length()) }
    }

    /// Reads the lines of the last step; returns the energy (J) dissipated in it.
    fn read_last(&mut self, state: &[f64]) -> f64 {
        let last = &state[2 * self.room..];
        self.lines.read(&last[1..]);
        last[0]
    }

    /// What the inputs go on like beyond the end of the lines: their rates last so long (s).
    fn lasting(&self) -> f64 {
        if self.lines.step > 0.0 { self.lines.step } else { f64::INFINITY }
    }

    /// Outputs of the motion at the end of the lines, written to `values` with those ends.
    fn write_outputs(&mut self, values: &mut [f64]) -> Result<(), String> {
        self.act(Lines::beyond);
        let lasting = self.lasting();
        let read = self.integrator.outputs(&self.motion, lasting, &self.acting, &mut self.outputs);
        read.map_err(|error| error.to_string())?;
        self.row.clear();
        let contact = self.outputs.contacts.first();
        if let Some(contact) = contact.filter(|_| self.table.load.is_some()) {
            let slip = self.slip.map_or(0.0, |slip| slip.of(contact.tangent, contact.slip_state));
            let state = f64::from(contact.slip_state as i32);
            self.row.extend([contact.force, contact.dissipated_energy, state, slip]);
        }
        if let Some(contact) = contact.filter(|_| self.table.shows_port) {
            self.row.extend([contact.displacement, contact.velocity]);
        }
        for sensor in &self.outputs.sensors {
            self.row.extend([sensor.displacement, sensor.velocity, sensor.acceleration]);
        }
        if !self.row.iter().all(|value| value.is_finite()) {
            return Err("an output is not a finite number".to_owned());
        }
        let (inputs, outputs) = values.split_at_mut(self.lines.all.len());
        outputs[..self.row.len()].copy_from_slice(&self.row);
        for (value, line) in inputs.iter_mut().zip(&self.lines.all) {
            *value = line.end;
        }
        Ok(())
    }

    /// Writes to `state` that the present motion was reached along the lines, with so much energy (J) dissipated.
    fn store(&self, state: &mut [f64], dissipated: f64) -> Result<(), String> {
        let (now, rest) = state.split_at_mut(self.room);
        let (before, last) = rest.split_at_mut(self.room);
        before.copy_from_slice(now);
        last[0] = dissipated;
        self.lines.write(&mut last[1..]);
        now.fill(0.0);
        let length = self.motion.state_len();
        if self.motion.write_state(&mut now[..length]) { Ok(()) } else { Err(wrong_length()) }
    }

    /// The motion with these modes, its contacts taken there from where `state` has them, under the inputs in `values`.
    fn settle(&mut self, state: &[f64], values: &[f64], modes: &[f64]) -> Result<(), String> {
        self.lines.hold(&values[..self.table.inputs]);
        self.act(Lines::along);
        Self::read(&mut self.motion, state)?;
        self.motion.modal_state_mut().copy_from_slice(modes);
        self.integrator.settle(&mut self.motion, &self.acting).map_err(|error| error.to_string())
    }

    /// Energy (J) that the contact has taken since the start.
    fn dissipated(&self) -> f64 {
        if self.motion.contacts() == 0 { 0.0 } else { self.motion.contact(0).dissipated_energy }
    }
}

impl ContinuousTime for DrivenSystem {
    fn modes(&self) -> usize {
        self.motion.modes()
    }

    fn indicators(&self) -> usize {
        if self.table.load.is_some() { continuous::OF_CONTACT } else { 0 }
    }

    fn read(&mut self, state: &[f64], continuous: &mut [f64]) -> Result<(), String> {
        Self::read(&mut self.motion, state)?;
        continuous.copy_from_slice(self.motion.modal_state());
        Ok(())
    }

    fn look(
        &mut self,
        state: &[f64],
        accepted: &[f64],
        values: &mut [f64],
        at: Instant<'_>,
    ) -> Result<(), String> {
        self.settle(state, values, at.continuous)?;
        self.write_outputs(values)?;
        at.accelerations.copy_from_slice(self.integrator.modal_accelerations());
        if let (Some(load), Some(contact)) = (self.table.load, self.outputs.contacts.first()) {
            let inputs = self.table.inputs;
            let moved = values[..inputs] != accepted[..inputs]
                || accepted.get(values.len()..values.len() + at.continuous.len()) != Some(at.continuous);
            continuous::keep_slip(moved, inputs + SLIP_STATE, values, accepted);
            let normal_load = self.load.acting(values[load]);
            continuous::indicators(contact.velocity, values[inputs + SLIP_STATE], normal_load, at.indicators);
        }
        Ok(())
    }

    fn accept(&mut self, state: &mut [f64], values: &[f64], continuous: &[f64]) -> Result<(), String> {
        self.settle(state, values, continuous)?;
        self.store(state, 0.0)
    }
}

impl Behaviour for DrivenSystem {
    fn state_len(&self) -> usize {
        2 * self.room + 1 + self.lines.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.lines.hold(values);
        self.act(Lines::along);
        self.motion = self.integrator.rest(&self.acting).map_err(|error| error.to_string())?;
        self.write_outputs(values)?;
        self.store(state, 0.0)
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        asked: &Asked,
        step: f64,
    ) -> Result<(), Box<str>> {
        Self::read(&mut self.motion, state)?;
        self.lines.go_on(&state[2 * self.room + 1..], values, &asked.slopes, step);
        self.act(Lines::along);
        let dissipated = self.dissipated();
        let steps = self.table.steps(step, asked.tolerance, &self.integrator)?;
        let gone = self.integrator.go(&mut self.motion, step, &self.acting, steps);
        gone.map_err(|error| error.to_string())?;
        let dissipated = self.dissipated() - dissipated;
        self.write_outputs(values)?;
        Ok(self.store(state, dissipated)?)
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let dissipated = self.read_last(state);
        let lasting = self.lasting();
        let mean_power = dissipated / lasting;
        Self::read(&mut self.motion, state)?;
        self.act(Lines::beyond);
        let found = self.integrator.output_rates(&self.motion, lasting, &self.acting, &mut self.rates);
        found.map_err(|error| error.to_string())?;
        self.row.clear();
        if let Some([displacement, velocity, force]) = self.rates.contacts.first() {
            if self.table.load.is_some() {
                self.row.extend([*force, mean_power, 0.0, 0.0]);
            }
            if self.table.shows_port {
                self.row.extend([*displacement, *velocity]);
            }
        }
        self.row.extend(self.rates.sensors.iter().flatten());
        rates.copy_from_slice(&self.row);
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        _unknowns: &[u32],
        direction: &[Ramp],
        tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        self.read_last(state);
        let duration = (self.lines.step > 0.0).then_some(self.lines.step);
        // Before the first step there is no motion before it.
        let from = if duration.is_some() { &state[self.room..] } else { state };
        Self::read(&mut self.before, from)?;
        self.act(Lines::along);
        self.act_by(direction, Lines::change);
        let steps = self.table.steps(self.lines.step, tolerance, &self.integrator)?;
        let with = (&mut self.tangent, &self.by[..]);
        let followed = self.integrator.follow(&self.before, duration, &self.acting, steps, with);
        followed.map_err(|error| error.to_string())?;
        if let Some(duration) = duration {
            // Rates are those beyond the end, as in the outputs.
            self.act(Lines::beyond);
            self.act_by(direction, Lines::beyond_changed);
            self.integrator.show(&mut self.tangent, duration, &self.acting, &self.by);
        }
        self.row.clear();
        if let Some(contact) = self.tangent.contacts.first() {
            if self.table.load.is_some() {
                self.row.extend([contact.force, contact.dissipated_energy, 0.0, 0.0]);
            }
            if self.table.shows_port {
                self.row.extend([contact.displacement, contact.velocity]);
            }
        }
        // Of the system: outputs are not there yet in an instance into which a state was restored.
        for sensor in 0..self.sensors {
            self.row.extend(self.integrator.sensor_change(&self.tangent, sensor));
        }
        change.copy_from_slice(&self.row);
        Ok(())
    }
}

/// Lengths come from the same motion; a difference would be a fault here.
fn wrong_length() -> String {
    "the state has another length than the system's motion".to_owned()
}
