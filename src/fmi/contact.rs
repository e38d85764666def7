//! A contact whose displacement and normal load are prescribed from outside.

use super::description::{DependencyKind, Description, Experiment, Variable};
use super::{Behaviour, LoadRule};
use crate::contact::{Carried, ContactLaw, Inputs, Response, Tangents};
use crate::model::{Contact, Model};
use crate::time::Ramp;
use crate::vocabulary as v;

// Rows of the table.
const DISPLACEMENT: usize = 0;
const VELOCITY: usize = 1;
const NORMAL_LOAD: usize = 2;
const FORCE: usize = 3;
const DISSIPATED_ENERGY: usize = 4;
const SLIP_STATE: usize = 5;
const PARAMETERS: usize = 6;

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
    let initially = || inputs.iter().copied().chain(PARAMETERS..PARAMETERS + parameters.len());
    let mut variables = vec![
        Variable::input(&v::DISPLACEMENT, 0.0),
        Variable::input(&v::VELOCITY, 0.0),
        Variable::input(&v::NORMAL_LOAD, contact.normal_load),
        Variable::output(&v::FORCE).depends(on(), initially()),
        Variable::output(&v::DISSIPATED_ENERGY).depends(on(), initially()),
        Variable::output(&v::SLIP_STATE).integer().depends(on(), initially()),
    ];
    variables.extend(parameters);
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description { name, summary, experiment, variables, model: model.to_toml() }
}

/// Inputs: displacement, velocity, normal load.
const INPUTS: usize = 3;

// What the state has behind the law's memory, twice: now and as it was before the last step.
/// Inputs where the last step's straight line began.
const STARTS: usize = 0;
/// Inputs at its end.
const ENDS: usize = INPUTS;
/// Its length (s); 0 before the first step.
const STEP: usize = 2 * INPUTS;
/// Which inputs had a derivative, one bit each, and [`JUMPED`].
const FLAGS: usize = STEP + 1;
const LAST_STEP: usize = FLAGS + 1;

/// The flag of a step that began with a jump to the values set.
const JUMPED: u8 = 1 << INPUTS;

/// Part of the way on which a contact shows how it leaves.
const AHEAD: f64 = 1e-9;

/// The law and room for one step.
#[derive(Debug)]
pub(super) struct ContactBehaviour {
    law: Box<dyn ContactLaw>,
    load: LoadRule,
    next: Vec<f64>,
    carried: Carried,
}

/// The last step as the state tells it.
struct LastStep<'a> {
    /// The law's memory before it.
    before: &'a [f64],
    starts: [f64; INPUTS],
    ends: [f64; INPUTS],
    step: f64,
    flags: u8,
}

impl ContactBehaviour {
    pub(super) fn new(model: &Model) -> Result<Self, String> {
        let law = model.law_of_any_values().map_err(|error| error.to_string())?;
        let law = law.ok_or("a contact model needs a contact")?;
        let next = vec![0.0; law.state_len()];
        Ok(Self { law, load: LoadRule::new(model), next, carried: Carried::default() })
    }

    fn inputs(&self, values: &[f64]) -> Inputs {
        Inputs {
            displacement: values[DISPLACEMENT],
            velocity: values[VELOCITY],
            normal_load: self.load.acting(values[NORMAL_LOAD]),
        }
    }

    /// One step of the law in place.
    fn advance(&mut self, memory: &mut [f64], values: &[f64]) -> Response {
        let inputs = self.inputs(values);
        let response = self.law.step(memory, inputs, &mut self.next);
        memory.copy_from_slice(&self.next);
        response
    }

    fn last<'a>(&self, state: &'a [f64]) -> LastStep<'a> {
        let (before, last) = state[self.next.len()..].split_at(self.next.len());
        let three = |from: usize| std::array::from_fn(|i| last[from + i]);
        let (starts, ends) = (three(STARTS), three(ENDS));
        LastStep { before, starts, ends, step: last[STEP], flags: last[FLAGS] as u8 }
    }
}

fn write_outputs(response: &Response, values: &mut [f64]) {
    values[FORCE] = response.force;
    values[SLIP_STATE] = f64::from(response.slip_state as i32);
}

impl Behaviour for ContactBehaviour {
    fn state_len(&self) -> usize {
        2 * self.law.state_len() + LAST_STEP
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        let (memory, rest) = state.split_at_mut(self.next.len());
        let (before, last) = rest.split_at_mut(self.next.len());
        self.law.set_state(0.0, self.load.acting(values[NORMAL_LOAD]), 0.0, memory);
        before.copy_from_slice(memory);
        last.fill(0.0);
        last[STARTS..ENDS].copy_from_slice(&values[..INPUTS]);
        last[ENDS..STEP].copy_from_slice(&values[..INPUTS]);
        let response = self.advance(memory, values);
        values[DISSIPATED_ENERGY] = response.dissipated_energy;
        write_outputs(&response, values);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        slopes: &[Option<f64>],
        step: f64,
        _tolerance: f64,
    ) -> Result<(), String> {
        let (memory, rest) = state.split_at_mut(self.next.len());
        let (before, last) = rest.split_at_mut(self.next.len());
        before.copy_from_slice(memory);
        // Each line begins where the last one ended, unless the input comes with its derivative.
        last.copy_within(ENDS..STEP, STARTS);
        let mut flags = 0;
        for (input, slope) in slopes.iter().enumerate() {
            if let Some(slope) = slope {
                flags |= 1 << input;
                if last[STARTS + input] != values[input] {
                    flags |= JUMPED;
                }
                last[STARTS + input] = values[input];
                values[input] += slope * step;
            }
        }
        if flags & JUMPED != 0 {
            values[DISSIPATED_ENERGY] += self.advance(memory, &last[STARTS..ENDS]).dissipated_energy;
        }
        last[ENDS..STEP].copy_from_slice(&values[..INPUTS]);
        last[STEP] = step;
        last[FLAGS] = f64::from(flags);
        let response = self.advance(memory, values);
        values[DISSIPATED_ENERGY] += response.dissipated_energy;
        write_outputs(&response, values);
        Ok(())
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let last = self.last(state);
        rates.fill(0.0);
        if last.step == 0.0 {
            return Ok(());
        }
        let rate = |input: usize| (last.ends[input] - last.starts[input]) / last.step;
        let (starts, ends) = (self.inputs(&last.starts), self.inputs(&last.ends));
        self.carried.begin(last.before);
        let memory = &mut self.carried.memory;
        if last.flags & JUMPED != 0 {
            self.law.advance(memory, starts);
        }
        let response = self.law.step(memory, ends, &mut self.next);
        let Tangents { displacement, velocity, normal_load } = response.tangents;
        rates[FORCE - INPUTS] = displacement * rate(DISPLACEMENT)
            + velocity * rate(VELOCITY)
            + normal_load * self.load.gain() * rate(NORMAL_LOAD);
        rates[DISSIPATED_ENERGY - INPUTS] = response.dissipated_energy / last.step;
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        direction: &[Ramp],
        _tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        let last = self.last(state);
        let by = |change: &dyn Fn(usize) -> f64| Inputs {
            displacement: change(DISPLACEMENT),
            velocity: change(VELOCITY),
            normal_load: self.load.gain() * change(NORMAL_LOAD),
        };
        let begins_anew = |input: usize| last.flags & (1 << input) != 0;
        let at_start = by(&|input| if begins_anew(input) { direction[input].start } else { 0.0 });
        let at_end = by(&|input| direction[input].end);
        let (starts, ends) = (self.inputs(&last.starts), self.inputs(&last.ends));
        let (law, carried) = (&*self.law, &mut self.carried);
        let mut dissipated = 0.0;
        carried.begin(last.before);
        if last.step == 0.0 {
            carried.rest(law, ends.normal_load, at_end.normal_load);
        } else if last.flags & JUMPED != 0 {
            dissipated += carried.step(law, starts, at_start).dissipated_energy;
        } else if last.flags != 0 {
            // A jump that was none still changes: in the direction in which the contact then went.
            let ahead = |start: f64, end: f64| start + AHEAD * (end - start);
            let inputs = Inputs {
                displacement: ahead(starts.displacement, ends.displacement),
                velocity: ahead(starts.velocity, ends.velocity),
                normal_load: ahead(starts.normal_load, ends.normal_load),
            };
            dissipated += carried.step(law, inputs, at_start).dissipated_energy;
        }
        let end = carried.step(law, ends, at_end);
        change.fill(0.0);
        change[FORCE - INPUTS] = end.force;
        change[DISSIPATED_ENERGY - INPUTS] = dissipated + end.dissipated_energy;
        Ok(())
    }
}
