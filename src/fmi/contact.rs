//! A contact whose displacement and normal load are prescribed from outside.

use super::description::{DependencyKind, Description, Experiment, Variable};
use super::lines::{Derivatives, Lines, parts};
use super::slip::SlipFraction;
use super::{Behaviour, LoadRule};
use crate::contact::{ContactLaw, Inputs, Response, StateSensitivity, Tangents};
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
    let initially = || inputs.iter().copied().chain(PARAMETERS..PARAMETERS + parameters.len());
    let mut variables = vec![
        Variable::input(&v::DISPLACEMENT, 0.0),
        Variable::input(&v::VELOCITY, 0.0),
        Variable::input(&v::NORMAL_LOAD, contact.normal_load),
        Variable::output(&v::FORCE).depends(on(), initially()),
        Variable::output(&v::DISSIPATED_ENERGY).depends(on(), initially()),
        Variable::output(&v::SLIP_STATE).integer().depends(on(), initially()),
        Variable::output(&v::SLIP_FRACTION).discrete().depends(on(), initially()),
    ];
    variables.extend(parameters);
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-3 };
    Description { name, summary, experiment, variables, model: model.to_toml() }
}

/// Inputs: displacement, velocity, normal load.
const INPUTS: usize = 3;

/// Part of the way on which a contact shows how it leaves.
const AHEAD: f64 = 1e-9;

/// The law and room for one step. The state is the law's memory now and before the last step, and that step's lines.
#[derive(Debug)]
pub(super) struct ContactBehaviour {
    law: Box<dyn ContactLaw>,
    load: LoadRule,
    slip: SlipFraction,
    next: Vec<f64>,
    sensitivity: StateSensitivity,
    lines: Lines,
}

impl ContactBehaviour {
    pub(super) fn new(model: &Model) -> Result<Self, String> {
        let law = model.law_of_any_values().map_err(|error| error.to_string())?;
        let law = law.ok_or("a contact model needs a contact")?;
        let next = vec![0.0; law.state_len()];
        let lines = Lines::new(INPUTS, true);
        let slip = SlipFraction::new(&*law, model.contact.map_or(0.0, |contact| contact.normal_load));
        let sensitivity = StateSensitivity::default();
        Ok(Self { law, load: LoadRule::new(model), slip, next, sensitivity, lines })
    }

    /// What acts at the start of the lines.
    fn starts(&self) -> Inputs {
        self.acting(|line| line.start)
    }

    /// What acts at their end.
    fn ends(&self) -> Inputs {
        self.acting(|line| line.end)
    }

    fn acting(&self, of: impl Fn(&Ramp) -> f64) -> Inputs {
        Inputs {
            displacement: of(&self.lines.all[DISPLACEMENT]),
            velocity: of(&self.lines.all[VELOCITY]),
            normal_load: self.load.acting(of(&self.lines.all[NORMAL_LOAD])),
        }
    }

    /// What acts at a fraction of them.
    fn at(&self, fraction: f64) -> Inputs {
        let at = self.acting(|line| line.at(fraction));
        Inputs { normal_load: at.normal_load.max(0.0), ..at }
    }

    /// Where the displacement turns round on the way, if it does.
    fn turns(&self) -> impl Iterator<Item = f64> + use<> {
        let line = self.lines.all[DISPLACEMENT];
        let curved = line.bow != 0.0 || line.skew != 0.0;
        curved.then(|| line.turns()).into_iter().flatten()
    }

    /// One step of the law in place.
    fn advance(&mut self, memory: &mut [f64], inputs: Inputs) -> Response {
        let response = self.law.step(memory, inputs, &mut self.next);
        memory.copy_from_slice(&self.next);
        response
    }

    /// Goes back to before the last step.
    fn go_back(&mut self, state: &[f64]) {
        let (before, lines) = state[self.next.len()..].split_at(self.next.len());
        self.sensitivity.begin(before);
        self.lines.read(lines);
    }
}

fn write_outputs(response: &Response, slip: SlipFraction, values: &mut [f64]) {
    values[FORCE] = response.force;
    values[SLIP_STATE] = f64::from(response.slip_state as i32);
    values[SLIP_FRACTION] = slip.of(response.tangents.displacement, response.slip_state);
}

impl Behaviour for ContactBehaviour {
    fn state_len(&self) -> usize {
        2 * self.law.state_len() + self.lines.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.lines.hold(&values[..INPUTS]);
        let at = self.ends();
        let (memory, before, lines) = parts(state, self.next.len());
        self.law.set_state(0.0, at.normal_load, 0.0, memory);
        before.copy_from_slice(memory);
        self.lines.write(lines);
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
        let (memory, before, lines) = parts(state, self.next.len());
        before.copy_from_slice(memory);
        self.lines.read(lines);
        self.lines.go_on(&values[..INPUTS], slopes, step);
        self.lines.write(lines);
        if self.lines.jumped {
            values[DISSIPATED_ENERGY] += self.advance(memory, self.starts()).dissipated_energy;
        }
        for fraction in self.turns() {
            values[DISSIPATED_ENERGY] += self.advance(memory, self.at(fraction)).dissipated_energy;
        }
        let response = self.advance(memory, self.ends());
        values[DISSIPATED_ENERGY] += response.dissipated_energy;
        values.iter_mut().zip(&self.lines.all).for_each(|(value, line)| *value = line.end);
        write_outputs(&response, self.slip, values);
        Ok(())
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        self.go_back(state);
        rates.fill(0.0);
        let step = self.lines.step;
        if step == 0.0 {
            return Ok(());
        }
        let rate = |input: usize| self.lines.all[input].rise() / step;
        let (starts, ends) = (self.starts(), self.ends());
        let mut memory = std::mem::take(&mut self.sensitivity.memory);
        if self.lines.jumped {
            self.law.advance(&mut memory, starts);
        }
        let mut dissipated = 0.0;
        for fraction in self.turns() {
            dissipated += self.law.step(&memory, self.at(fraction), &mut self.next).dissipated_energy;
            memory.copy_from_slice(&self.next);
        }
        let response = self.law.step(&memory, ends, &mut self.next);
        self.sensitivity.memory = memory;
        let Tangents { displacement, velocity, normal_load } = response.tangents;
        rates[FORCE - INPUTS] = displacement * rate(DISPLACEMENT)
            + velocity * rate(VELOCITY)
            + normal_load * self.load.gain() * rate(NORMAL_LOAD);
        rates[DISSIPATED_ENERGY - INPUTS] = (dissipated + response.dissipated_energy) / step;
        Ok(())
    }

    fn sensitivity(
        &mut self,
        state: &[f64],
        direction: &[Ramp],
        _tolerance: f64,
        change: &mut [f64],
    ) -> Result<(), String> {
        self.go_back(state);
        let by = |of: &dyn Fn(&Ramp) -> f64| {
            let change = |input: usize| of(&self.lines.change(input, &direction[input]));
            Inputs {
                displacement: change(DISPLACEMENT),
                velocity: change(VELOCITY),
                normal_load: self.load.gain() * change(NORMAL_LOAD),
            }
        };
        let (at_start, at_end) = (by(&|line| line.start), by(&|line| line.end));
        let turns: [Option<(Inputs, Inputs)>; 2] = {
            let mut turns = self.turns().map(|fraction| (self.at(fraction), by(&|line| line.at(fraction))));
            [turns.next(), turns.next()]
        };
        let (starts, ends) = (self.starts(), self.ends());
        let (law, carried) = (&*self.law, &mut self.sensitivity);
        let mut dissipated = 0.0;
        if self.lines.step == 0.0 {
            carried.rest(law, ends.normal_load, at_end.normal_load);
        } else if self.lines.jumped {
            dissipated += carried.step(law, starts, at_start).dissipated_energy;
        } else if self.lines.begin_anew() {
            // A jump that was none still changes: in the direction in which the contact then went.
            let ahead = |start: f64, end: f64| start + AHEAD * (end - start);
            let inputs = Inputs {
                displacement: ahead(starts.displacement, ends.displacement),
                velocity: ahead(starts.velocity, ends.velocity),
                normal_load: ahead(starts.normal_load, ends.normal_load),
            };
            dissipated += carried.step(law, inputs, at_start).dissipated_energy;
        }
        for (inputs, by) in turns.into_iter().flatten() {
            dissipated += carried.step(law, inputs, by).dissipated_energy;
        }
        let end = carried.step(law, ends, at_end);
        change.fill(0.0);
        change[FORCE - INPUTS] = end.force;
        change[DISSIPATED_ENERGY - INPUTS] = dissipated + end.dissipated_energy;
        Ok(())
    }
}
