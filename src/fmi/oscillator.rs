//! Masses and springs with a frictional contact, or without.

use super::Behaviour;
use super::description::{DependencyKind, Description, Experiment, Variable};
use crate::contact::Tangents;
use crate::model::{Contact, Model, Oscillator};
use crate::time::{Drive, Followed, MOST_STEPPED, Ramp, SampledIntegrator};
use crate::vocabulary::{self as v, Quantity};

use std::borrow::Cow;

/// Tolerance that the integrator's longest step meets; the error falls with the square of the step.
const TOLERANCE_OF_LONGEST: f64 = 3e-4;
/// The longest step is divided by this at most.
const FINEST: f64 = 1000.0;
/// Most steps within a communication step.
const MOST_STEPS: f64 = 1e7;
/// Contacts and numbers of their memory that effects may add to a structure: a cubic spring and drag. Room is kept for
/// them, so that a parameter may go through zero.
const ADDED: (usize, usize) = (2, 2);

/// Outputs of the contact: force, dissipated energy, slip state.
const OF_CONTACT: usize = 3;

/// Inputs and outputs of an oscillator, followed by `parameters`.
pub(super) fn describe(
    model: &Model,
    oscillator: &Oscillator,
    contact: Option<&Contact>,
    parameters: Vec<Variable>,
) -> Description {
    let masses = &oscillator.masses;
    let inputs = masses.len() + usize::from(contact.is_some());
    let outputs = 3 * masses.len() + if contact.is_some() { OF_CONTACT } else { 0 };
    let first_parameter = inputs + outputs;
    // All inputs run to their values within the step, and whatever they move moves everything.
    let on = || (0..inputs).map(|index| (index, DependencyKind::Dependent));
    let at = |quantity: &Quantity, name: &str| -> Cow<'static, str> {
        Cow::Owned(format!("{}:{name}", quantity.name))
    };
    let mut variables: Vec<Variable> = masses
        .iter()
        .map(|mass| Variable {
            name: at(&v::EXCITATION, &mass.name),
            description: Cow::Owned(format!("Force of the exciter on mass {}", mass.name)),
            ..Variable::input(&v::EXCITATION, 0.0)
        })
        .collect();
    if let Some(contact) = contact {
        let load = masses.len();
        variables.extend([
            Variable::input(&v::NORMAL_LOAD, contact.normal_load),
            Variable::output(&v::FORCE).depends(on(), []),
            Variable::output(&v::DISSIPATED_ENERGY).depends(on(), []),
            Variable::output(&v::SLIP_STATE).integer().depends(on(), [load]),
        ]);
    }
    for mass in masses {
        let motions = [
            (&v::DISPLACEMENT, "Displacement"),
            (&v::VELOCITY, "Velocity"),
            (&v::ACCELERATION, "Acceleration"),
        ];
        for (order, (quantity, noun)) in motions.into_iter().enumerate() {
            // At rest the excitation accelerates, and nothing has moved yet.
            let accelerated = (0..masses.len()).chain(first_parameter..first_parameter + parameters.len());
            let initially = accelerated.filter(|_| order == 2);
            let row = Variable {
                name: at(quantity, &mass.name),
                description: Cow::Owned(format!("{noun} of mass {}", mass.name)),
                ..Variable::output(quantity)
            };
            variables.push(row.depends(on(), initially));
        }
    }
    variables.extend(parameters);
    let (name, summary) = match contact {
        Some(_) => ("FrictionOscillator", "Masses and springs with a friction contact"),
        None => ("Oscillator", "Masses and springs"),
    };
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description { name, summary, experiment, variables, model: model.to_toml() }
}

/// The physics of an oscillator.
pub(super) fn behaviour(model: &Model, oscillator: &Oscillator) -> Result<Box<dyn Behaviour>, String> {
    let masses = oscillator.masses.len();
    if masses > MOST_STEPPED {
        return Err(format!("{masses} masses are too many for an FMU; {MOST_STEPPED} is the limit"));
    }
    let system = model.system().map_err(|error| error.to_string())?;
    let structure = system.linear_part();
    let normal_load = model.contact.as_ref().map_or(0.0, |contact| contact.normal_load);
    let own = usize::from(model.contact.is_some());
    let joint = model.changes().joint;
    let mut stiffness = vec![0.0; structure.contacts.len()];
    let laws: Vec<_> = system.laws().map(|(_, law, _)| law.clone()).collect();
    let memory: usize = laws.iter().take(own).map(|law| law.state_len()).sum();
    if let Some(contact) = &model.contact {
        stiffness[0] = contact.tangential_stiffness + joint.residual_stiffness.max(0.0);
    }
    let longest =
        SampledIntegrator::longest_step(&structure, &stiffness).map_err(|error| error.to_string())?;
    let drives: Vec<_> = (0..masses).map(|mass| vec![(mass, 1.0)]).collect();
    let integrator =
        SampledIntegrator::new(&structure, laws, &drives, longest).map_err(|error| error.to_string())?;
    let inputs = masses + own;
    let core = 2 * structure.size + 2 * (own + ADDED.0) + memory + ADDED.1;
    Ok(Box::new(OscillatorBehaviour {
        longest,
        inputs,
        masses,
        has_contact: own == 1,
        core,
        load: (normal_load, joint.load_gain.unwrap_or(1.0)),
        lines: vec![Ramp::held(0.0); inputs],
        drives: vec![Drive::default(); masses],
        drive_changes: vec![Drive::default(); masses],
        loads: vec![0.0; structure.contacts.len()],
        load_changes: vec![0.0; structure.contacts.len()],
        accelerations: vec![0.0; structure.size],
        jerk: vec![0.0; structure.size],
        trial: Vec::new(),
        row: Vec::new(),
        followed: Followed::default(),
        directions: Vec::new(),
        integrator,
    }))
}

/// Numbers of each contact's tangents: ∂T/∂u, ∂T/∂v, ∂T/∂N.
const TANGENTS: usize = 3;

/// Integrator and work space.
///
/// The state is that of the integrator with room for what effects may add to it, now and before the last step; the
/// inputs' lines over that step, and which of them began anew; its length (s), 0 before the first; whether the load
/// jumped at its beginning; the energy (J) dissipated in it; and the tangents of the contacts at its end.
#[derive(Debug)]
struct OscillatorBehaviour {
    integrator: SampledIntegrator,
    longest: f64,
    inputs: usize,
    masses: usize,
    has_contact: bool,
    /// Room for the state of the integrator.
    core: usize,
    /// Constant normal load (N), and the fraction of the input's difference from it that reaches the contact.
    load: (f64, f64),
    lines: Vec<Ramp>,
    drives: Vec<Drive>,
    drive_changes: Vec<Drive>,
    loads: Vec<f64>,
    load_changes: Vec<f64>,
    accelerations: Vec<f64>,
    jerk: Vec<f64>,
    trial: Vec<f64>,
    row: Vec<f64>,
    followed: Followed,
    directions: Vec<Ramp>,
}

/// What the state has behind those of the integrator.
struct LastStep<'a> {
    starts: &'a [f64],
    ends: &'a [f64],
    anew: &'a [f64],
    step: f64,
    jumped: bool,
    dissipated: f64,
    tangents: &'a [[f64; TANGENTS]],
}

/// Without the last digits, in which the lengths of equal communication steps differ from each other: the operators of
/// a step need not be computed again for those.
fn rounded(step: f64) -> f64 {
    const DIGITS: u64 = 0xfff;
    f64::from_bits((step.to_bits() + DIGITS / 2) & !DIGITS)
}

impl OscillatorBehaviour {
    fn set_load(&mut self, input: f64) {
        let (constant, gain) = self.load;
        if let Some(load) = self.loads.first_mut().filter(|_| self.has_contact) {
            *load = constant + gain * (input - constant);
        }
    }

    fn set_load_change(&mut self, change: f64) {
        if let Some(load) = self.load_changes.first_mut().filter(|_| self.has_contact) {
            *load = self.load.1 * change;
        }
    }

    fn last<'a>(&self, state: &'a [f64]) -> LastStep<'a> {
        let (starts, rest) = state[2 * self.core..].split_at(self.inputs);
        let (ends, rest) = rest.split_at(self.inputs);
        let (anew, rest) = rest.split_at(self.inputs);
        LastStep {
            starts,
            ends,
            anew,
            step: rest[0],
            jumped: rest[1] != 0.0,
            dissipated: rest[2],
            tangents: rest[3..].as_chunks().0,
        }
    }

    /// Writes to `state` that the motion in `self.trial` was reached by `self.lines`.
    fn store(&self, state: &mut [f64], slopes: &[Option<f64>], step: f64, jumped: bool, dissipated: f64) {
        let (now, rest) = state.split_at_mut(self.core);
        let (before, last) = rest.split_at_mut(self.core);
        before.copy_from_slice(now);
        now.copy_from_slice(&self.trial);
        let (starts, rest) = last.split_at_mut(self.inputs);
        let (ends, rest) = rest.split_at_mut(self.inputs);
        let (anew, rest) = rest.split_at_mut(self.inputs);
        anew.fill(0.0);
        for (anew, _) in anew.iter_mut().zip(slopes).filter(|(_, slope)| slope.is_some()) {
            *anew = 1.0;
        }
        for ((start, end), line) in starts.iter_mut().zip(ends).zip(&self.lines) {
            (*start, *end) = (line.start, line.end);
        }
        rest[..3].copy_from_slice(&[step, f64::from(u8::from(jumped)), dissipated]);
        for (row, response) in rest[3..].chunks_exact_mut(TANGENTS).zip(self.integrator.responses()) {
            let Tangents { displacement, velocity, normal_load } = response.tangents;
            row.copy_from_slice(&[displacement, velocity, normal_load]);
        }
    }

    /// Writes the outputs of the state in `self.trial` at the ends of `self.lines`.
    fn write_outputs(&mut self, values: &mut [f64], dissipated: f64) -> Result<(), String> {
        let state = &self.trial[..self.integrator.state_len()];
        self.row.clear();
        self.row.extend(self.lines[..self.masses].iter().map(|line| line.end));
        self.integrator.acceleration(state, &self.row, &mut self.accelerations);
        self.row.clear();
        if self.has_contact {
            let slip_state = self.integrator.responses()[0].slip_state;
            let force = self.integrator.contact_forces(state)[0];
            self.row.extend([force, dissipated, f64::from(slip_state as i32)]);
        }
        for mass in 0..self.masses {
            let (x, v) = (self.integrator.displacement(state)[mass], self.integrator.velocity(state)[mass]);
            self.row.extend([x, v, self.accelerations[mass]]);
        }
        if !self.row.iter().all(|value| value.is_finite()) {
            return Err("an output is not a finite number".to_owned());
        }
        values[self.inputs..self.inputs + self.row.len()].copy_from_slice(&self.row);
        for (value, line) in values.iter_mut().zip(&self.lines) {
            *value = line.end;
        }
        Ok(())
    }

    /// Number of steps inside a communication step of `step` (s), which are set.
    fn divide(&mut self, step: f64, tolerance: f64) -> Result<usize, String> {
        let finer = (TOLERANCE_OF_LONGEST / tolerance).sqrt().clamp(1.0, FINEST);
        let count = (step * finer / self.longest).ceil().max(1.0);
        if count > MOST_STEPS {
            return Err(format!("a communication step of {step} s is too long for a motion this fast"));
        }
        self.integrator.set_step(rounded(step / count)).map_err(|error| error.to_string())?;
        Ok(count as usize)
    }

    /// Sets drives and load for step `k` of `count` along `self.lines`.
    fn set_drives(&mut self, k: usize, count: usize) {
        let (from, to) = (k as f64 / count as f64, (k + 1) as f64 / count as f64);
        for (line, drive) in self.lines.iter().zip(&mut self.drives) {
            *drive = Drive::line(between(line, from), between(line, to));
        }
        self.set_load(between(&self.lines[self.inputs - 1], to));
    }
}

/// Exact at both ends.
fn between(line: &Ramp, share: f64) -> f64 {
    line.start * (1.0 - share) + line.end * share
}

const UNBOUNDED: &str = "the motion grows without bound";

impl Behaviour for OscillatorBehaviour {
    fn state_len(&self) -> usize {
        2 * self.core + 3 * self.inputs + 3 + TANGENTS * (usize::from(self.has_contact) + ADDED.0)
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.trial.clear();
        self.trial.resize(self.core, 0.0);
        for (line, value) in self.lines.iter_mut().zip(&*values) {
            *line = Ramp::held(*value);
        }
        self.set_load(values[self.inputs - 1]);
        let length = self.integrator.state_len();
        self.integrator.rest(&self.loads, &mut self.trial[..length]);
        self.integrator.settle(&mut self.trial[..length], &self.loads);
        self.write_outputs(values, 0.0)?;
        self.store(state, &[], 0.0, false, 0.0);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        slopes: &[Option<f64>],
        step: f64,
        tolerance: f64,
    ) -> Result<(), String> {
        self.trial.clear();
        self.trial.extend_from_slice(&state[..self.core]);
        let ended = &state[2 * self.core + self.inputs..];
        for ((line, value), ended) in self.lines.iter_mut().zip(&*values).zip(ended) {
            *line = Ramp { start: *ended, end: *value };
        }
        let mut jumped = false;
        for (input, slope) in slopes.iter().enumerate() {
            if let Some(slope) = slope {
                let line = &mut self.lines[input];
                jumped |= input == self.masses && line.start != values[input];
                *line = Ramp::with_slope(values[input], *slope, step);
            }
        }
        let count = self.divide(step, tolerance)?;
        let length = self.integrator.state_len();
        let mut dissipated = 0.0;
        if jumped {
            self.set_load(self.lines[self.masses].start);
            self.integrator.settle(&mut self.trial[..length], &self.loads);
            dissipated += self.integrator.responses()[0].dissipated_energy;
        }
        for k in 0..count {
            self.set_drives(k, count);
            if !self.integrator.step(&mut self.trial[..length], &self.drives, &self.loads) {
                return Err(UNBOUNDED.to_owned());
            }
            if self.has_contact {
                dissipated += self.integrator.responses()[0].dissipated_energy;
            }
        }
        let before = if self.has_contact { values[self.inputs + 1] } else { 0.0 };
        self.write_outputs(values, before + dissipated)?;
        self.store(state, slopes, step, jumped, dissipated);
        Ok(())
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let last = self.last(state);
        let (n, contacts) = (self.accelerations.len(), self.loads.len());
        let per_second = if last.step > 0.0 { 1.0 / last.step } else { 0.0 };
        let rate = |input: usize| (last.ends[input] - last.starts[input]) * per_second;
        self.integrator.acceleration(state, &last.ends[..self.masses], &mut self.accelerations);
        self.load_changes.fill(0.0);
        if let Some(load) = self.load_changes.first_mut().filter(|_| self.has_contact) {
            *load = self.load.1 * rate(self.masses);
        }
        // The motion one derivative on: velocities, accelerations, rates of the contact forces.
        let velocity = &state[n..2 * n];
        self.trial.clear();
        self.trial.extend_from_slice(velocity);
        self.trial.extend_from_slice(&self.accelerations);
        self.trial.resize(2 * n + contacts, 0.0);
        let motion = (velocity, &self.accelerations[..]);
        let force_rates = &mut self.trial[2 * n..];
        self.integrator.force_rates(last.tangents, motion, &self.load_changes, force_rates);
        let row = if self.has_contact { OF_CONTACT } else { 0 };
        if self.has_contact {
            rates[..OF_CONTACT].copy_from_slice(&[force_rates[0], last.dissipated * per_second, 0.0]);
        }
        self.row.clear();
        self.row.extend((0..self.masses).map(rate));
        self.integrator.acceleration(&self.trial, &self.row, &mut self.jerk);
        let motion = velocity.iter().zip(&self.accelerations).zip(&self.jerk);
        for (rates, ((v, a), jerk)) in rates[row..].chunks_exact_mut(3).zip(motion) {
            rates.copy_from_slice(&[*v, *a, *jerk]);
        }
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        direction: &[Ramp],
        tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        let last = self.last(state);
        let (step, jumped) = (last.step, last.jumped);
        // A line that went on from the previous one has a fixed start.
        self.directions.clear();
        self.directions.extend(
            direction
                .iter()
                .zip(last.anew)
                .map(|(line, anew)| Ramp { start: anew * line.start, end: line.end }),
        );
        for ((line, start), end) in self.lines.iter_mut().zip(last.starts).zip(last.ends) {
            *line = Ramp { start: *start, end: *end };
        }
        let length = self.integrator.state_len();
        self.trial.clear();
        let mut followed = std::mem::take(&mut self.followed);
        if step == 0.0 {
            // At rest whatever acts: only accelerations answer.
            self.trial.extend_from_slice(&state[..self.core]);
            self.integrator.begin_change(&self.trial[..length], &mut followed);
        } else {
            self.trial.extend_from_slice(&state[self.core..2 * self.core]);
            self.integrator.begin_change(&self.trial[..length], &mut followed);
            let directions = std::mem::take(&mut self.directions);
            self.follow(&mut followed, &directions, (step, jumped), tolerance)?;
            self.directions = directions;
        }
        self.write_changes(&followed, direction, change);
        self.followed = followed;
        Ok(())
    }
}

impl OscillatorBehaviour {
    /// Goes the last step again with a change of its inputs.
    fn follow(
        &mut self,
        followed: &mut Followed,
        direction: &[Ramp],
        (step, jumped): (f64, bool),
        tolerance: f64,
    ) -> Result<(), String> {
        let count = self.divide(step, tolerance)?;
        let length = self.integrator.state_len();
        if jumped {
            self.set_load(self.lines[self.masses].start);
            self.set_load_change(direction[self.masses].start);
            let (state, loads) = (&mut self.trial[..length], &self.loads);
            self.integrator.settle_change(state, loads, &self.load_changes, followed);
        }
        for k in 0..count {
            self.set_drives(k, count);
            let (from, to) = (k as f64 / count as f64, (k + 1) as f64 / count as f64);
            for (line, drive) in direction.iter().zip(&mut self.drive_changes) {
                *drive = Drive::line(between(line, from), between(line, to));
            }
            self.set_load_change(between(&direction[self.inputs - 1], to));
            let (drives, loads) =
                ((&*self.drives, &*self.drive_changes), (&*self.loads, &*self.load_changes));
            if !self.integrator.step_change(&mut self.trial[..length], drives, loads, followed) {
                return Err(UNBOUNDED.to_owned());
            }
        }
        Ok(())
    }

    fn write_changes(&mut self, followed: &Followed, direction: &[Ramp], change: &mut [f64]) {
        let n = self.accelerations.len();
        self.trial.clear();
        self.trial.extend_from_slice(&followed.motion);
        self.trial.extend_from_slice(&followed.force);
        self.row.clear();
        self.row.extend(direction[..self.masses].iter().map(|line| line.end));
        self.integrator.acceleration(&self.trial, &self.row, &mut self.accelerations);
        let mut row = 0;
        if self.has_contact {
            change[..OF_CONTACT].copy_from_slice(&[followed.force[0], followed.dissipated_energy[0], 0.0]);
            row = OF_CONTACT;
        }
        for mass in 0..self.masses {
            let motion = [followed.motion[mass], followed.motion[n + mass], self.accelerations[mass]];
            change[row..row + 3].copy_from_slice(&motion);
            row += 3;
        }
    }
}
