//! A contact in two directions whose motion is prescribed from outside.

mod carried;

use super::slip::SlipFraction;
use crate::contact::{SlipSlap, SlipSlapInputs, SlipSlapResponse, SlipSlapWork};
use crate::fmi::continuous::{self, ContinuousForm, ContinuousTime, Instant};
use crate::fmi::description::{DependencyKind, Description, Experiment, Variable};
use crate::fmi::lines::{Lines, parts};
use crate::fmi::{Asked, Behaviour};
use crate::model::{Contact, Model};
use crate::time::Ramp;
use crate::vocabulary as v;
use carried::Carried;

// Rows of the table.
const DISPLACEMENT: usize = 0;
const VELOCITY: usize = 1;
const OPENING: usize = 2;
const OPENING_VELOCITY: usize = 3;
/// Number of inputs, and row of the first output.
const INPUTS: usize = 4;
const FORCE: usize = 4;
const OPENING_FORCE: usize = 5;
const NORMAL_FORCE: usize = 6;
const SEPARATION: usize = 7;
const DISSIPATED_ENERGY: usize = 8;
const IMPACT_ENERGY: usize = 9;
const SLIP_STATE: usize = 10;
const SLIP_FRACTION: usize = 11;
const PARAMETERS: usize = 12;

/// Part of the way on which a contact shows how it leaves.
const AHEAD: f64 = 1e-9;
/// Two cubics turn round twice each.
const MOST_TURNS: usize = 4;

/// Inputs and outputs of the contact, followed by `parameters`.
pub(super) fn describe(model: &Model, _contact: &Contact, parameters: Vec<Variable>) -> Description {
    let joint = model.changes().joint;
    let rate_dependent = joint.damping != 0.0 || joint.weakening.is_some();
    let all: Vec<usize> = (0..INPUTS).filter(|input| *input != VELOCITY || rate_dependent).collect();
    let of_parameters = || PARAMETERS..PARAMETERS + parameters.len();
    let output = |quantity, on: &[usize]| {
        let dependent = on.iter().map(|input| (*input, DependencyKind::Dependent));
        Variable::output(quantity).depends(dependent, on.iter().copied().chain(of_parameters()))
    };
    let normal = [OPENING, OPENING_VELOCITY];
    let mut variables = vec![
        Variable::input(&v::DISPLACEMENT, 0.0),
        Variable::input(&v::VELOCITY, 0.0),
        Variable::input(&v::OPENING, 0.0),
        Variable::input(&v::OPENING_VELOCITY, 0.0),
        output(&v::FORCE, &all),
        output(&v::OPENING_FORCE, &normal),
        output(&v::NORMAL_FORCE, &normal),
        output(&v::SEPARATION, &[OPENING]),
        output(&v::DISSIPATED_ENERGY, &all),
        output(&v::IMPACT_ENERGY, &normal),
        output(&v::SLIP_STATE, &all).integer(),
        output(&v::SLIP_FRACTION, &all).discrete(),
    ];
    variables.extend(parameters);
    let experiment = Experiment { start: 0.0, stop: 1.0, tolerance: 1e-6, step: 1e-4 };
    Description {
        name: "SlipSlapContact",
        summary: "Contact in two directions: friction under the normal force that the normal motion makes",
        experiment,
        variables,
        continuous: ContinuousForm::default(),
        model: model.to_toml(),
    }
}

/// The contact and room for one step. The state is the contact's now and before the last step, and that step's lines.
#[derive(Debug)]
pub(super) struct SlipSlapBehaviour {
    contact: SlipSlap,
    slip: SlipFraction,
    next: Vec<f64>,
    work: SlipSlapWork,
    carried: Carried,
    lines: Lines,
}

impl SlipSlapBehaviour {
    pub(super) fn new(model: &Model) -> Result<Self, String> {
        let contact = model.slip_slap().map_err(|error| error.to_string())?;
        let contact = contact.ok_or("the contact has no normal law")?;
        Ok(Self {
            slip: SlipFraction::new(&**contact.law(), contact.normal().preload()),
            next: vec![0.0; contact.state_len()],
            contact,
            work: SlipSlapWork::default(),
            carried: Carried::default(),
            lines: Lines::new(INPUTS, true),
        })
    }

    /// What acts where the lines are as `of` says.
    fn acting(&self, of: impl Fn(&Ramp) -> f64) -> SlipSlapInputs {
        inputs(|input| of(&self.lines.all[input]))
    }

    fn starts(&self) -> SlipSlapInputs {
        self.acting(|line| line.start)
    }

    fn ends(&self) -> SlipSlapInputs {
        self.acting(|line| line.end)
    }

    /// Where on the way one of the displacements turns round, in order; beyond the end where it does not.
    fn turns(&self) -> [f64; MOST_TURNS] {
        let mut turns = [f64::INFINITY; MOST_TURNS];
        let lines = [DISPLACEMENT, OPENING].map(|input| self.lines.all[input]);
        let curved = lines.iter().filter(|line| line.bow != 0.0 || line.skew != 0.0);
        for (place, turn) in turns.iter_mut().zip(curved.flat_map(|line| line.turns())) {
            *place = turn;
        }
        turns.sort_by(f64::total_cmp);
        turns
    }

    /// One step of the contact in place.
    fn advance(&mut self, now: &mut [f64], inputs: SlipSlapInputs) -> SlipSlapResponse {
        let response = self.contact.step(now, inputs, &mut self.next, &mut self.work);
        now.copy_from_slice(&self.next);
        response
    }

    /// Goes back to before the last step.
    fn go_back(&mut self, state: &[f64]) {
        let (before, lines) = state[self.next.len()..].split_at(self.next.len());
        self.carried.begin(before);
        self.lines.read(lines);
    }

    fn write_outputs(&self, response: &SlipSlapResponse, values: &mut [f64]) {
        values[FORCE] = response.force[0];
        values[OPENING_FORCE] = response.force[1];
        values[NORMAL_FORCE] = response.normal_force;
        values[SEPARATION] = response.separation;
        values[SLIP_STATE] = f64::from(response.slip_state as i32);
        values[SLIP_FRACTION] = self.slip.of(response.by_displacement[0][0], response.slip_state);
    }

    /// How the lines' places `of` change with their `direction`.
    fn change(&self, direction: &[Ramp], of: impl Fn(&Ramp) -> f64) -> SlipSlapInputs {
        inputs(|input| of(&self.lines.change(input, &direction[input])))
    }

    /// Where the last step was divided before its end, and how that changes with the `direction` of the lines.
    fn before_the_end(&self, direction: &[Ramp]) -> impl Iterator<Item = (SlipSlapInputs, SlipSlapInputs)> {
        let at_start = || self.change(direction, |line| line.start);
        let start = if self.lines.step == 0.0 {
            None
        } else if self.lines.jumped {
            Some((self.starts(), at_start()))
        } else if self.lines.begin_anew() {
            // A jump that was none still changes: in the direction in which the contact then went.
            let ahead = self.acting(|line| line.start + AHEAD * (line.end - line.start));
            Some((ahead, at_start()))
        } else {
            None
        };
        let turns = self.turns().into_iter().filter(|turn| *turn < 1.0 && self.lines.step > 0.0);
        let at =
            |turn: f64| (self.acting(|line| line.at(turn)), self.change(direction, |line| line.at(turn)));
        start.into_iter().chain(turns.map(at))
    }

    /// Rates (1/s) of the outputs that follow the motion at the end of a step, from `rates` of the inputs.
    fn rates_of(&self, response: &SlipSlapResponse, by: SlipSlapInputs, rates: &mut [f64]) {
        let force = |row: usize| along(response, row, by);
        rates[FORCE - INPUTS] = force(0);
        rates[OPENING_FORCE - INPUTS] = force(1);
        rates[NORMAL_FORCE - INPUTS] = -force(1);
        rates[SEPARATION - INPUTS] = if response.separation > 0.0 { by.displacement[1] } else { 0.0 };
    }
}

/// The inputs of a step from those of the table.
fn inputs(of: impl Fn(usize) -> f64) -> SlipSlapInputs {
    SlipSlapInputs {
        displacement: [of(DISPLACEMENT), of(OPENING)],
        velocity: [of(VELOCITY), of(OPENING_VELOCITY)],
    }
}

/// Change of force `row` by a change of the inputs, at fixed state.
fn along(response: &SlipSlapResponse, row: usize, by: SlipSlapInputs) -> f64 {
    let sum = |tangents: &[f64; 2], by: [f64; 2]| tangents[0] * by[0] + tangents[1] * by[1];
    sum(&response.by_displacement[row], by.displacement) + sum(&response.by_velocity[row], by.velocity)
}

impl ContinuousTime for SlipSlapBehaviour {
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
        let inputs = inputs(|input| values[input]);
        let now = &state[..self.next.len()];
        let response = self.contact.step(now, inputs, &mut self.next, &mut self.work);
        values[DISSIPATED_ENERGY] = accepted[DISSIPATED_ENERGY] + response.friction_energy;
        values[IMPACT_ENERGY] = accepted[IMPACT_ENERGY] + response.impact_energy;
        self.write_outputs(&response, values);
        let moved =
            [DISPLACEMENT, OPENING, OPENING_VELOCITY].iter().any(|row| values[*row] != accepted[*row]);
        continuous::keep_slip(moved, SLIP_STATE, values, accepted);
        let pressed = continuous::pressed(response.normal_force, response.separation);
        continuous::indicators(inputs.velocity[0], values[SLIP_STATE], pressed, at.indicators);
        Ok(())
    }

    fn accept(&mut self, state: &mut [f64], values: &[f64], _continuous: &[f64]) -> Result<(), String> {
        self.lines.hold(&values[..INPUTS]);
        let inputs = self.ends();
        let (now, before, lines) = parts(state, self.next.len());
        before.copy_from_slice(now);
        self.lines.write(lines);
        self.advance(now, inputs);
        Ok(())
    }
}

impl Behaviour for SlipSlapBehaviour {
    fn state_len(&self) -> usize {
        2 * self.contact.state_len() + self.lines.state_len()
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        self.lines.hold(&values[..INPUTS]);
        let at = self.ends();
        let (now, before, lines) = parts(state, self.next.len());
        self.contact.set_state([0.0; 2], 0.0, now);
        before.copy_from_slice(now);
        self.lines.write(lines);
        let response = self.advance(now, at);
        values[DISSIPATED_ENERGY] = response.friction_energy;
        values[IMPACT_ENERGY] = response.impact_energy;
        self.write_outputs(&response, values);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        asked: &Asked,
        step: f64,
    ) -> Result<(), Box<str>> {
        let (now, before, lines) = parts(state, self.next.len());
        before.copy_from_slice(now);
        self.lines.go_on(lines, &values[..INPUTS], &asked.slopes, step);
        self.lines.write(lines);
        let mut lost = [0.0; 2];
        let mut add = |response: &SlipSlapResponse| {
            lost[0] += response.friction_energy;
            lost[1] += response.impact_energy;
        };
        if self.lines.jumped {
            add(&self.advance(now, self.starts()));
        }
        for turn in self.turns().into_iter().filter(|turn| *turn < 1.0) {
            add(&self.advance(now, self.acting(|line| line.at(turn))));
        }
        let response = self.advance(now, self.ends());
        add(&response);
        values[DISSIPATED_ENERGY] += lost[0];
        values[IMPACT_ENERGY] += lost[1];
        values.iter_mut().zip(&self.lines.all).for_each(|(value, line)| *value = line.end);
        self.write_outputs(&response, values);
        Ok(())
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        self.go_back(state);
        rates.fill(0.0);
        let step = self.lines.step;
        if step == 0.0 {
            return Ok(());
        }
        let mut now = std::mem::take(&mut self.carried.state);
        if self.lines.jumped {
            self.advance(&mut now, self.starts());
        }
        let mut lost = [0.0; 2];
        for turn in self.turns().into_iter().filter(|turn| *turn < 1.0) {
            let response = self.advance(&mut now, self.acting(|line| line.at(turn)));
            lost = [lost[0] + response.friction_energy, lost[1] + response.impact_energy];
        }
        let response = self.advance(&mut now, self.ends());
        self.carried.state = now;
        self.rates_of(&response, inputs(|input| self.lines.all[input].rise() / step), rates);
        rates[DISSIPATED_ENERGY - INPUTS] = (lost[0] + response.friction_energy) / step;
        rates[IMPACT_ENERGY - INPUTS] = (lost[1] + response.impact_energy) / step;
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
        // Derivatives of energies cost two steps more each time.
        let energy = [DISSIPATED_ENERGY, IMPACT_ENERGY].iter().any(|row| unknowns.contains(&(*row as u32)));
        let mut carried = std::mem::take(&mut self.carried);
        let mut lost = [0.0; 2];
        let mut lose = |carried: &mut Carried, inputs, by| {
            if energy {
                let more = carried.energies(&self.contact, inputs, by);
                lost = [lost[0] + more[0], lost[1] + more[1]];
            }
        };
        for (inputs, by) in self.before_the_end(direction) {
            lose(&mut carried, inputs, by);
            carried.step(&self.contact, inputs, by);
        }
        let (ends, by) = (self.ends(), self.change(direction, |line| line.end));
        lose(&mut carried, ends, by);
        let end = carried.look(&self.contact, ends);
        self.carried = carried;
        change.fill(0.0);
        self.rates_of(&end, by, change);
        change[FORCE - INPUTS] += self.carried.force_by_state;
        change[DISSIPATED_ENERGY - INPUTS] = lost[0];
        change[IMPACT_ENERGY - INPUTS] = lost[1];
        Ok(())
    }
}
