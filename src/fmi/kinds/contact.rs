//! A contact whose displacement and normal load are prescribed from outside.

use super::LoadRule;
use super::slip::SlipFraction;
use crate::contact::{ContactLaw, Inputs, Response, StateSensitivity, Tangents};
use crate::fmi::Behaviour;
use crate::fmi::continuous::{self, ContinuousForm, ContinuousTime, Instant};
use crate::fmi::description::{DependencyKind, Description, Experiment, Variable};
use crate::fmi::lines::{Derivatives, Lines, parts};
use crate::model::{Contact, Model};
use crate::time::Ramp;
use crate::vocabulary as v;
use std::ops::Range;

// Rows of the table.
const DISPLACEMENT: usize = 0;
const VELOCITY: usize = 1;
const NORMAL_LOAD: usize = 2;
const FORCE: usize = 3;
const DISSIPATED_ENERGY: usize = 4;
const SLIP_STATE: usize = 5;
const SLIP_FRACTION: usize = 6;
const PARAMETERS: usize = 7;

/// Inputs and outputs of a contact, followed by `parameters`.
pub(super) fn describe(model: &Model, contact: &Contact, parameters: Vec<Variable>) -> Description {
    let (name, summary) = (contact.law.kind.fmu_name, contact.law.kind.summary);
    let joint = model.changes().joint;
    let rate_dependent = joint.damping != 0.0 || joint.weakening.is_some();
    let mut inputs = vec![DISPLACEMENT, NORMAL_LOAD];
    if rate_dependent {
        inputs.insert(1, VELOCITY);
    }
    let on = || inputs.iter().map(|input| (*input, DependencyKind::Dependent));
    // A velocity slides nothing but by the friction that it weakens.
    let slides = || on().filter(|(input, _)| *input != VELOCITY || joint.weakening.is_some());
    let initially = || inputs.iter().copied().chain(PARAMETERS..PARAMETERS + parameters.len());
    let mut variables = vec![
        Variable::input(&v::DISPLACEMENT, 0.0),
        Variable::input(&v::VELOCITY, 0.0),
        Variable::input(&v::NORMAL_LOAD, contact.normal_load),
        Variable::output(&v::FORCE).depends(on(), initially()),
        Variable::output(&v::DISSIPATED_ENERGY).depends(on(), initially()),
        Variable::output(&v::SLIP_STATE).integer().depends(slides(), initially()),
        Variable::output(&v::SLIP_FRACTION).discrete().depends(slides(), initially()),
    ];
    variables.extend(parameters);
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description {
        name,
        summary,
        experiment,
        variables,
        continuous: ContinuousForm::default(),
        model: model.to_toml(),
    }
}

/// Inputs: displacement, velocity, normal load.
const INPUTS: usize = 3;

/// Part of the way on which a contact shows how it leaves.
const AHEAD: f64 = 1e-9;

/// How the inputs went over the last step, or go over the one under way.
#[derive(Debug)]
struct Way {
    lines: Lines,
    load: LoadRule,
}

impl Way {
    /// What acts at the start.
    fn starts(&self) -> Inputs {
        self.acting(|line| line.start)
    }

    /// What acts at the end.
    fn ends(&self) -> Inputs {
        self.acting(|line| line.end)
    }

    fn acting(&self, of: impl Fn(&Ramp) -> f64) -> Inputs {
        self.reached(|input| of(&self.lines.all[input]))
    }

    /// What acts where the inputs have reached `values`.
    #[inline]
    fn reached(&self, values: impl Fn(usize) -> f64) -> Inputs {
        Inputs {
            displacement: values(DISPLACEMENT),
            velocity: values(VELOCITY),
            normal_load: self.load.acting(values(NORMAL_LOAD)),
        }
    }

    /// What acts at a fraction of the way.
    fn at(&self, fraction: f64) -> Inputs {
        let at = self.acting(|line| line.at(fraction));
        Inputs { normal_load: at.normal_load.max(0.0), ..at }
    }

    /// Where the displacement turns round on the way; `None` if it is straight. (An iterator that is empty costs a
    /// quarter of a step.)
    fn turns(&self) -> Option<impl Iterator<Item = f64> + use<>> {
        let line = &self.lines.all[DISPLACEMENT];
        (line.bow != 0.0 || line.skew != 0.0).then(|| line.turns())
    }

    /// The change of what acts with that of the lines in `direction`.
    fn change(&self, direction: &[Ramp], of: impl Fn(&Ramp) -> f64) -> Inputs {
        let change = |input: usize| of(&self.lines.change(input, &direction[input]));
        Inputs {
            displacement: change(DISPLACEMENT),
            velocity: change(VELOCITY),
            normal_load: self.load.gain() * change(NORMAL_LOAD),
        }
    }
}

/// Which half of a state is the memory now, in the state's first place: a step writes the other half and goes over to it.
const FIRST: f64 = 0.0;
const SECOND: f64 = 1.0;

/// Places of the memory now and before the last step in a state whose memory has `memory` numbers.
fn halves(state: &[f64], memory: usize) -> (Range<usize>, Range<usize>) {
    let (first, second) = (1..1 + memory, 1 + memory..1 + 2 * memory);
    if state[0] == SECOND { (second, first) } else { (first, second) }
}

/// The memory now, that before the last step, and that step's lines.
fn split(state: &mut [f64], memory: usize) -> (&mut [f64], &mut [f64], &mut [f64]) {
    let second = state[0] == SECOND;
    let (first, other, lines) = parts(&mut state[1..], memory);
    if second { (other, first, lines) } else { (first, other, lines) }
}

/// The law and room for one step. The state is which half of it is the law's memory now, that and the memory before the last
/// step, and that step's lines.
#[derive(Debug)]
pub(super) struct ContactBehaviour {
    law: Box<dyn ContactLaw>,
    slip: SlipFraction,
    next: Vec<f64>,
    sensitivity: StateSensitivity,
    way: Way,
}

impl ContactBehaviour {
    pub(super) fn new(model: &Model) -> Result<Self, String> {
        let law = model.law_of_any_values().map_err(|error| error.to_string())?;
        let law = law.ok_or("a contact model needs a contact")?;
        let next = vec![0.0; law.state_len()];
        let way = Way { lines: Lines::new(INPUTS, true), load: LoadRule::new(model) };
        let slip = SlipFraction::new(&*law, model.contact.map_or(0.0, |contact| contact.normal_load));
        Ok(Self { law, slip, next, sensitivity: StateSensitivity::default(), way })
    }

    /// One step of the law in place.
    fn advance(&mut self, memory: &mut [f64], inputs: Inputs) -> Response {
        let response = self.law.step(memory, inputs, &mut self.next);
        memory.copy_from_slice(&self.next);
        response
    }

    /// Goes back to before the last step.
    fn go_back(&mut self, state: &[f64]) {
        let (_, before) = halves(state, self.next.len());
        self.sensitivity.begin(&state[before]);
        self.way.lines.read(&state[1 + 2 * self.next.len()..]);
    }
}

#[inline]
fn write_outputs(response: &Response, slip: SlipFraction, values: &mut [f64]) {
    values[FORCE] = response.force;
    values[SLIP_STATE] = f64::from(response.slip_state as i32);
    values[SLIP_FRACTION] = slip.of(response.tangents.displacement, response.slip_state);
}

impl ContinuousTime for ContactBehaviour {
    fn indicators(&self) -> usize {
        continuous::OF_CONTACT
    }

    fn look(
        &mut self,
        state: &[f64],
        accepted: &[f64],
        values: &mut [f64],
        at: Instant<'_>,
    ) -> Result<(), String> {
        self.way.lines.hold(&values[..INPUTS]);
        let inputs = self.way.ends();
        let (memory, _) = halves(state, self.next.len());
        let response = self.law.step(&state[memory], inputs, &mut self.next);
        values[DISSIPATED_ENERGY] = accepted[DISSIPATED_ENERGY] + response.dissipated_energy;
        write_outputs(&response, self.slip, values);
        let moved = [DISPLACEMENT, NORMAL_LOAD].iter().any(|input| values[*input] != accepted[*input]);
        continuous::keep_slip(moved, SLIP_STATE, values, accepted);
        continuous::indicators(inputs.velocity, values[SLIP_STATE], inputs.normal_load, at.indicators);
        Ok(())
    }

    fn accept(&mut self, state: &mut [f64], values: &[f64], _continuous: &[f64]) -> Result<(), String> {
        self.way.lines.hold(&values[..INPUTS]);
        let (memory, before, lines) = split(state, self.next.len());
        before.copy_from_slice(memory);
        self.way.lines.write(lines);
        let inputs = self.way.ends();
        self.advance(memory, inputs);
        Ok(())
    }
}

impl Behaviour for ContactBehaviour {
    fn state_len(&self) -> usize {
        1 + 2 * self.law.state_len() + self.way.lines.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.way.lines.hold(&values[..INPUTS]);
        let at = self.way.ends();
        let (memory, before, lines) = split(state, self.next.len());
        self.law.set_state(0.0, at.normal_load, 0.0, memory);
        before.copy_from_slice(memory);
        self.way.lines.write(lines);
        let response = self.advance(memory, at);
        values[DISSIPATED_ENERGY] = response.dissipated_energy;
        write_outputs(&response, self.slip, values);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        slopes: &[Option<Derivatives>],
        step: f64,
        _tolerance: f64,
    ) -> Result<(), String> {
        let (memory, before, lines) = split(state, self.next.len());
        if slopes.is_empty()
            && let Some(row) = values.first_chunk_mut::<PARAMETERS>()
        {
            // Straight from the memory that is kept to the new one; the lines are read where they are asked for.
            Lines::run_on(lines, [row[DISPLACEMENT], row[VELOCITY], row[NORMAL_LOAD]], step);
            let response = self.law.step(memory, self.way.reached(|input| row[input]), before);
            state[0] = if state[0] == SECOND { FIRST } else { SECOND };
            row[DISSIPATED_ENERGY] += response.dissipated_energy;
            write_outputs(&response, self.slip, row);
            return Ok(());
        }
        before.copy_from_slice(memory);
        self.way.lines.go_on(lines, &values[..INPUTS], slopes, step);
        self.way.lines.write(lines);
        if self.way.lines.jumped {
            values[DISSIPATED_ENERGY] += self.advance(memory, self.way.starts()).dissipated_energy;
        }
        if let Some(turns) = self.way.turns() {
            for fraction in turns {
                values[DISSIPATED_ENERGY] += self.advance(memory, self.way.at(fraction)).dissipated_energy;
            }
        }
        let response = self.advance(memory, self.way.ends());
        values[DISSIPATED_ENERGY] += response.dissipated_energy;
        values.iter_mut().zip(&self.way.lines.all).for_each(|(value, line)| *value = line.end);
        write_outputs(&response, self.slip, values);
        Ok(())
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        self.go_back(state);
        rates.fill(0.0);
        let step = self.way.lines.step;
        if step == 0.0 {
            return Ok(());
        }
        let rate = |input: usize| self.way.lines.all[input].rise() / step;
        let (starts, ends) = (self.way.starts(), self.way.ends());
        let mut memory = std::mem::take(&mut self.sensitivity.memory);
        if self.way.lines.jumped {
            self.law.advance(&mut memory, starts);
        }
        let mut dissipated = 0.0;
        for fraction in self.way.turns().into_iter().flatten() {
            dissipated += self.law.step(&memory, self.way.at(fraction), &mut self.next).dissipated_energy;
            memory.copy_from_slice(&self.next);
        }
        let response = self.law.step(&memory, ends, &mut self.next);
        self.sensitivity.memory = memory;
        let Tangents { displacement, velocity, normal_load } = response.tangents;
        rates[FORCE - INPUTS] = displacement * rate(DISPLACEMENT)
            + velocity * rate(VELOCITY)
            + normal_load * self.way.load.gain() * rate(NORMAL_LOAD);
        rates[DISSIPATED_ENERGY - INPUTS] = (dissipated + response.dissipated_energy) / step;
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        unknowns: &[u32],
        direction: &[Ramp],
        _tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        self.go_back(state);
        let Self { law, sensitivity: carried, way, .. } = self;
        let law = &**law;
        // A derivative of the energy costs several steps.
        let energy = unknowns.contains(&(DISSIPATED_ENERGY as u32));
        let mut dissipated = 0.0;
        let mut pass = |inputs, by| {
            if energy {
                dissipated += carried.step(law, inputs, by).dissipated_energy;
            } else {
                carried.carry(law, inputs, by);
            }
        };
        if way.lines.jumped {
            pass(way.starts(), way.change(direction, |line| line.start));
        } else if way.lines.step > 0.0 && way.lines.begin_anew() {
            // A jump that was none still changes: in the direction in which the contact then went.
            let ahead = way.acting(|line| line.start + AHEAD * (line.end - line.start));
            pass(ahead, way.change(direction, |line| line.start));
        }
        if let Some(turns) = way.turns() {
            for fraction in turns {
                pass(way.at(fraction), way.change(direction, |line| line.at(fraction)));
            }
        }
        let (ends, by) = (way.ends(), way.change(direction, |line| line.end));
        if way.lines.step == 0.0 {
            carried.rest(law, ends.normal_load, by.normal_load);
        }
        change.fill(0.0);
        if energy {
            let end = carried.look(law, ends, by);
            change[FORCE - INPUTS] = end.force;
            change[DISSIPATED_ENERGY - INPUTS] = dissipated + end.dissipated_energy;
        } else {
            change[FORCE - INPUTS] = carried.force(law, ends, by);
        }
        Ok(())
    }
}
