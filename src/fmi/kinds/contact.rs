//! A contact whose displacement and normal load are prescribed from outside.

use super::LoadRule;
use super::slip::SlipFraction;
use crate::contact::{AnyLaw, ContactLaw, Inputs, Response, StateSensitivity, Tangents};
use crate::fmi::continuous::{self, ContinuousForm, ContinuousTime, Instant};
use crate::fmi::description::{DependencyKind, Description, Experiment, Variable};
use crate::fmi::lines::{self, Derivatives, Lines};
use crate::fmi::{Asked, Behaviour};
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

impl LoadRule {
    /// What acts where the inputs have reached `values`.
    #[inline]
    fn inputs(&self, values: impl Fn(usize) -> f64) -> Inputs {
        Inputs {
            displacement: values(DISPLACEMENT),
            velocity: values(VELOCITY),
            normal_load: self.acting(values(NORMAL_LOAD)),
        }
    }
}

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
        self.load.inputs(|input| of(&self.lines.all[input]))
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

/// By its bits, which are compared sooner.
#[inline]
fn is_second(state: &[f64]) -> bool {
    state[0].to_bits() == SECOND.to_bits()
}

/// What was the memory before the last step is the memory now.
#[inline]
fn turn_over(state: &mut [f64]) {
    state[0] = if is_second(state) { FIRST } else { SECOND };
}

/// Numbers of a state whose memory has `memory`.
#[inline]
fn length(memory: usize) -> usize {
    1 + 2 * memory + lines::length(INPUTS)
}

/// Places of the memory now and before the last step in a state whose memory has `memory` numbers.
#[inline]
fn halves(state: &[f64], memory: usize) -> (Range<usize>, Range<usize>) {
    let (first, second) = (1..1 + memory, 1 + memory..1 + 2 * memory);
    if is_second(state) { (second, first) } else { (first, second) }
}

/// The memory now, that before the last step, and that step's lines.
#[inline]
fn split(state: &mut [f64], memory: usize) -> (&mut [f64], &mut [f64], &mut [f64]) {
    let (halves, lines) = state.split_at_mut(1 + 2 * memory);
    let second = is_second(halves);
    let (first, other) = halves[1..].split_at_mut(memory);
    if second { (other, first, lines) } else { (first, other, lines) }
}

/// What makes of a contact's inputs and law its table.
#[derive(Debug)]
struct Rules {
    load: LoadRule,
    slip: SlipFraction,
}

/// A step over which all inputs run straight from where they had ended: from the memory, of `memory` numbers, that is kept
/// to the new one; the lines are read where they are asked for. False, and nothing done, if the law's `step` is `None`.
#[inline(always)]
fn run_straight(
    step_of_law: impl FnOnce(&[f64], Inputs, &mut [f64]) -> Option<Response>,
    memory: usize,
    rules: &Rules,
    state: &mut [f64],
    row: &mut [f64; PARAMETERS],
    step: f64,
) -> bool {
    // Asked once: where the number is known, every place is then known to be there.
    let state = &mut state[..length(memory)];
    let (memory, next, lines) = split(state, memory);
    let Some(response) = step_of_law(memory, rules.load.inputs(|input| row[input]), next) else {
        return false;
    };
    Lines::run_on(lines, [row[DISPLACEMENT], row[VELOCITY], row[NORMAL_LOAD]], step);
    turn_over(state);
    row[DISSIPATED_ENERGY] += response.dissipated_energy;
    write_outputs(&response, rules.slip, row);
    true
}

/// The law. The state is which half of it is the law's memory now, that and the memory before the last step, and that
/// step's lines.
#[derive(Debug)]
pub(super) struct ContactBehaviour {
    law: AnyLaw,
    rules: Rules,
    /// Made where it is first needed: most instances never do.
    room: Option<Box<Room>>,
}

/// Room for what is not straight, and for derivatives.
#[derive(Debug)]
struct Room {
    next: Vec<f64>,
    sensitivity: StateSensitivity,
    way: Way,
}

impl Room {
    /// One step of `law` in place.
    fn advance(&mut self, law: &dyn ContactLaw, memory: &mut [f64], inputs: Inputs) -> Response {
        let response = law.step(memory, inputs, &mut self.next);
        memory.copy_from_slice(&self.next);
        response
    }
}

impl ContactBehaviour {
    pub(super) fn new(model: &Model) -> Result<Self, String> {
        let law = model.law_of_any_values().map_err(|error| error.to_string())?;
        let law = law.ok_or("a contact model needs a contact")?;
        let slip = SlipFraction::new(&*law, model.contact.map_or(0.0, |contact| contact.normal_load));
        Ok(Self { law, rules: Rules { load: LoadRule::new(model), slip }, room: None })
    }

    /// The law, the rules and the room.
    fn with_room(&mut self) -> (&dyn ContactLaw, &Rules, &mut Room) {
        let Self { law, rules, room } = self;
        let room = room.get_or_insert_with(|| {
            let way = Way { lines: Lines::new(INPUTS, true), load: rules.load };
            let next = vec![0.0; law.state_len()];
            Box::new(Room { next, sensitivity: StateSensitivity::default(), way })
        });
        (&**law, rules, room)
    }

    /// [`run_straight`] with any law, which is called.
    #[inline(never)]
    fn run_straight(
        &self,
        state: &mut [f64],
        row: &mut [f64; PARAMETERS],
        step: f64,
    ) -> Result<(), Box<str>> {
        let law = &*self.law;
        let step_of_law = |memory: &[f64], inputs, next: &mut [f64]| Some(law.step(memory, inputs, next));
        run_straight(step_of_law, law.state_len(), &self.rules, state, row, step);
        Ok(())
    }

    /// A step in which an input has a derivative: over its jump, and from turn to turn.
    #[inline(never)]
    fn run_along(
        &mut self,
        state: &mut [f64],
        values: &mut [f64; PARAMETERS],
        slopes: &[Option<Derivatives>],
        step: f64,
    ) -> Result<(), Box<str>> {
        let (law, rules, room) = self.with_room();
        let (memory, before, lines) = split(state, room.next.len());
        before.copy_from_slice(memory);
        room.way.lines.go_on(lines, &values[..INPUTS], slopes, step);
        room.way.lines.write(lines);
        if room.way.lines.jumped {
            values[DISSIPATED_ENERGY] += room.advance(law, memory, room.way.starts()).dissipated_energy;
        }
        if let Some(turns) = room.way.turns() {
            for fraction in turns {
                let at = room.way.at(fraction);
                values[DISSIPATED_ENERGY] += room.advance(law, memory, at).dissipated_energy;
            }
        }
        let response = room.advance(law, memory, room.way.ends());
        values[DISSIPATED_ENERGY] += response.dissipated_energy;
        values.iter_mut().zip(&room.way.lines.all).for_each(|(value, line)| *value = line.end);
        write_outputs(&response, rules.slip, values);
        Ok(())
    }

    /// The `change` of the force where all inputs ran straight from where they had ended, which are most steps: what was
    /// remembered before does not change, and the tangents of the step tell it. False, and nothing done, of another step.
    fn differentiate_straight(&mut self, state: &[f64], direction: &[Ramp], change: &mut [f64]) -> bool {
        let memory = self.law.state_len();
        let Some(ends) = Lines::straight_ends::<INPUTS>(&state[1 + 2 * memory..]) else { return false };
        let (_, before) = halves(state, memory);
        let (before, inputs) = (&state[before], self.rules.load.inputs(|input| ends[input]));
        let closed = match &self.law {
            AnyLaw::Jenkins(law) => law.step_closed(before, inputs, &mut [0.0; 3]),
            _ => None,
        };
        let response = closed.unwrap_or_else(|| {
            let (law, _, room) = self.with_room();
            law.step(before, inputs, &mut room.next)
        });
        let Tangents { displacement, velocity, normal_load } = response.tangents;
        change.fill(0.0);
        change[FORCE - INPUTS] = displacement * direction[DISPLACEMENT].end
            + velocity * direction[VELOCITY].end
            + normal_load * self.rules.load.gain() * direction[NORMAL_LOAD].end;
        true
    }

    /// As [`ContactBehaviour::with_room`], gone back to before the last step.
    fn go_back(&mut self, state: &[f64]) -> (&dyn ContactLaw, &mut Room) {
        let (law, _, room) = self.with_room();
        let memory = room.next.len();
        let (_, before) = halves(state, memory);
        room.sensitivity.begin(&state[before]);
        room.way.lines.read(&state[1 + 2 * memory..]);
        (law, room)
    }
}

#[inline(always)]
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
        let (law, rules, room) = self.with_room();
        let inputs = rules.load.inputs(|input| values[input]);
        let (memory, _) = halves(state, room.next.len());
        let response = law.step(&state[memory], inputs, &mut room.next);
        values[DISSIPATED_ENERGY] = accepted[DISSIPATED_ENERGY] + response.dissipated_energy;
        write_outputs(&response, rules.slip, values);
        let moved = [DISPLACEMENT, NORMAL_LOAD].iter().any(|input| values[*input] != accepted[*input]);
        continuous::keep_slip(moved, SLIP_STATE, values, accepted);
        continuous::indicators(inputs.velocity, values[SLIP_STATE], inputs.normal_load, at.indicators);
        Ok(())
    }

    fn accept(&mut self, state: &mut [f64], values: &[f64], _continuous: &[f64]) -> Result<(), String> {
        let (memory, next, lines) = split(state, self.law.state_len());
        Lines::write_held(lines, &values[..INPUTS]);
        self.law.step(memory, self.rules.load.inputs(|input| values[input]), next);
        turn_over(state);
        Ok(())
    }
}

impl Behaviour for ContactBehaviour {
    fn state_len(&self) -> usize {
        length(self.law.state_len())
    }

    fn start(&mut self, state: &mut [f64], values: &mut [f64]) -> Result<(), String> {
        let at = self.rules.load.inputs(|input| values[input]);
        let (memory, before, lines) = split(state, self.law.state_len());
        Lines::write_held(lines, &values[..INPUTS]);
        self.law.set_state(0.0, at.normal_load, 0.0, before);
        let response = self.law.step(before, at, memory);
        values[DISSIPATED_ENERGY] = response.dissipated_energy;
        write_outputs(&response, self.rules.slip, values);
        Ok(())
    }

    fn step(
        &mut self,
        state: &mut [f64],
        values: &mut [f64],
        asked: &Asked,
        step: f64,
    ) -> Result<(), Box<str>> {
        let row = values.first_chunk_mut().expect("a row for each input and output");
        if !asked.slopes.is_empty() {
            return self.run_along(state, row, &asked.slopes, step);
        }
        if let AnyLaw::Jenkins(law) = &self.law {
            let step_of_law =
                |memory: &[f64], inputs, next: &mut [f64]| law.step_closed(memory, inputs, next);
            if run_straight(step_of_law, law.state_len(), &self.rules, state, row, step) {
                return Ok(());
            }
        }
        self.run_straight(state, row, step)
    }

    fn output_rates(&mut self, state: &[f64], rates: &mut [f64]) -> Result<(), String> {
        let (law, Room { next, sensitivity, way }) = self.go_back(state);
        rates.fill(0.0);
        let step = way.lines.step;
        if step == 0.0 {
            return Ok(());
        }
        let rate = |input: usize| way.lines.all[input].rise() / step;
        let memory = &mut sensitivity.memory;
        if way.lines.jumped {
            law.advance(memory, way.starts());
        }
        let mut dissipated = 0.0;
        for fraction in way.turns().into_iter().flatten() {
            dissipated += law.step(memory, way.at(fraction), next).dissipated_energy;
            memory.copy_from_slice(next);
        }
        let response = law.step(memory, way.ends(), next);
        let Tangents { displacement, velocity, normal_load } = response.tangents;
        rates[FORCE - INPUTS] = displacement * rate(DISPLACEMENT)
            + velocity * rate(VELOCITY)
            + normal_load * way.load.gain() * rate(NORMAL_LOAD);
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
        // A derivative of the energy costs several steps.
        let energy = unknowns.contains(&(DISSIPATED_ENERGY as u32));
        if !energy && self.differentiate_straight(state, direction, change) {
            return Ok(());
        }
        let (law, Room { sensitivity: carried, way, .. }) = self.go_back(state);
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
