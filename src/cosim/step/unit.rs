//! A slave with its connections: the sources of its inputs, and buffers for their values.

use super::signals::Signals;
use crate::cosim::slave::{Abilities, Severity, Slave, SlaveError, Stepped};

/// Where the value of an input at the end of a step comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cosim) enum SignalSource {
    /// A slave that has stepped already.
    Computed,
    /// Extrapolation of the source from earlier values.
    Extrapolated,
    /// An unknown of the iteration.
    Assumed(usize),
}

/// How an input is given that is to run from one value to another.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::cosim) enum Given {
    /// The value at the end.
    End,
    /// The value at the middle.
    Middle,
    /// The value at the beginning and its derivative.
    Ramp,
}

/// Copies what is mostly a single number, for which a call of `memcpy` would take longer than all the rest.
#[inline]
pub(in crate::cosim) fn copy_few(to: &mut [f64], from: &[f64]) {
    match (to, from) {
        ([to], [from]) => *to = *from,
        (to, from) => to.copy_from_slice(from),
    }
}

/// A connected input.
#[derive(Debug, Clone, Copy)]
pub(in crate::cosim) struct Channel {
    /// Position in the slave's table.
    pub input: usize,
    /// The signal that feeds it.
    pub source: usize,
    pub factor: f64,
    pub offset: f64,
    pub origin: SignalSource,
    pub given: Given,
    /// A step begins where the last one ended, also where the source has come to another value than expected since: a
    /// contact moved there and back at the beginning of the step would slip.
    pub continued: bool,
}

impl Channel {
    pub fn of(&self, source: f64) -> f64 {
        self.factor * source + self.offset
    }
}

/// What is the same for all slaves in a step.
#[derive(Debug, Clone, Copy)]
pub(in crate::cosim) struct Frame<'a> {
    pub time: f64,
    pub step: f64,
    /// Inputs are held at their value for the end of the step, as in the plain algorithms.
    pub plain: bool,
    /// Go back to the beginning of the step first.
    pub restore: bool,
    pub signals: &'a Signals,
    pub assumed: &'a [f64],
}

/// Outputs that depend at once on an input that is given at the middle of the step.
#[derive(Debug)]
struct AtOnce {
    /// By directional derivatives; otherwise by a step with the inputs of the end.
    derived: bool,
    /// Positions in `outputs`, and in the slave's table.
    places: Vec<usize>,
    outputs: Vec<usize>,
    found: Vec<f64>,
}

/// Where a slave's state at the beginning of a step is kept, and where it is while a step is only tried for outputs.
pub(in crate::cosim) const BEGINNING: usize = 0;
const TRIAL: usize = 1;

#[derive(Debug)]
pub(in crate::cosim) struct Unit {
    pub slave: Box<dyn Slave>,
    pub abilities: Abilities,
    pub channels: Vec<Channel>,
    /// Index of its first signal.
    pub first: usize,
    /// What is read, by position in the table.
    pub output_positions: Vec<usize>,
    pub outputs: Vec<f64>,
    /// Inputs at both ends of the step.
    pub begin: Vec<f64>,
    pub end: Vec<f64>,
    /// What they came to in the last step.
    pub reached: Vec<f64>,
    /// What was set.
    pub values: Vec<f64>,
    /// Real outputs that feed others: in the table, and in `outputs`.
    coupled: Vec<usize>,
    pub coupled_places: Vec<usize>,
    change: Vec<f64>,
    input_positions: Vec<usize>,
    ramp_positions: Vec<usize>,
    slopes: Vec<f64>,
    /// Change of the inputs of which the change of the outputs is asked for.
    pub direction: Vec<f64>,
    at_once: Option<AtOnce>,
    pub outcome: Result<Stepped, SlaveError>,
}

impl Unit {
    /// `read` is what is read, by position, and whether it feeds another as a Real.
    pub fn new(slave: Box<dyn Slave>, channels: Vec<Channel>, first: usize, read: &[(usize, bool)]) -> Self {
        let abilities = slave.abilities();
        let output_positions: Vec<usize> = read.iter().map(|(position, _)| *position).collect();
        let coupled_places: Vec<usize> = (0..read.len()).filter(|place| read[*place].1).collect();
        let depends = |output: usize, input: usize| {
            slave.variables()[output].depends_on.as_ref().is_none_or(|inputs| inputs.contains(&input))
        };
        let middle = || channels.iter().filter(|channel| channel.given == Given::Middle);
        let touched = |output: &usize| middle().any(|channel| depends(*output, channel.input));
        let places: Vec<usize> =
            coupled_places.iter().copied().filter(|place| touched(&output_positions[*place])).collect();
        let able = abilities.directional_derivatives || abilities.saves_state;
        let at_once = (able && !places.is_empty()).then(|| AtOnce {
            derived: abilities.directional_derivatives,
            outputs: places.iter().map(|place| output_positions[*place]).collect(),
            found: vec![0.0; places.len()],
            places,
        });
        let zeros = || vec![0.0; channels.len()];
        let ramps = channels.iter().filter(|channel| channel.given == Given::Ramp);
        let ramp_positions: Vec<usize> = ramps.map(|channel| channel.input).collect();
        Self {
            abilities,
            first,
            coupled: coupled_places.iter().map(|place| output_positions[*place]).collect(),
            change: vec![0.0; coupled_places.len()],
            coupled_places,
            outputs: vec![0.0; output_positions.len()],
            output_positions,
            begin: zeros(),
            reached: zeros(),
            end: zeros(),
            values: zeros(),
            direction: zeros(),
            input_positions: channels.iter().map(|channel| channel.input).collect(),
            slopes: vec![0.0; ramp_positions.len()],
            ramp_positions,
            channels,
            at_once,
            outcome: Ok(Stepped::Done),
            slave,
        }
    }

    /// The full name of the output at `place` of what is read.
    pub fn output_name(&self, place: usize) -> String {
        let row = self.output_positions.get(place).map(|position| &self.slave.variables()[*position].name);
        format!("{}.{}", self.slave.name(), row.map_or("", String::as_str))
    }

    /// Steps, and leaves in `outcome` how it went and in `outputs` the values at the end.
    pub fn advance(&mut self, frame: &Frame) {
        self.outcome = self.try_advance(frame);
    }

    fn try_advance(&mut self, frame: &Frame) -> Result<Stepped, SlaveError> {
        if frame.restore {
            self.slave.restore(BEGINNING)?;
        }
        self.fill(frame);
        let at_once = !frame.plain && self.at_once.as_ref().is_some_and(|at_once| !at_once.derived);
        if at_once {
            let stepped = self.try_outputs(frame)?;
            if stepped != Stepped::Done {
                return Ok(stepped);
            }
        }
        if !self.values.is_empty() {
            self.slave.set(&self.input_positions, &self.values)?;
        }
        if !frame.plain && !self.slopes.is_empty() {
            self.slave.set_input_derivatives(&self.ramp_positions, &self.slopes)?;
        }
        let stepped = self.slave.do_step(frame.time, frame.step)?;
        if stepped != Stepped::Done {
            return Ok(stepped);
        }
        self.read_numbers()?;
        if !frame.plain {
            self.correct()?;
        }
        Ok(stepped)
    }

    /// Inputs at both ends of the step, and how they are given.
    fn fill(&mut self, frame: &Frame) {
        let mut ramps = 0;
        for (index, channel) in self.channels.iter().enumerate() {
            let end = match channel.origin {
                SignalSource::Computed => channel.of(frame.signals.next[channel.source]),
                SignalSource::Extrapolated => channel.of(frame.signals.predicted[channel.source]),
                SignalSource::Assumed(unknown) => frame.assumed[unknown],
            };
            self.end[index] = end;
            if frame.plain {
                self.values[index] = end;
                continue;
            }
            let begin = match channel.continued {
                true => self.reached[index],
                false => channel.of(frame.signals.now[channel.source]),
            };
            self.begin[index] = begin;
            self.values[index] = match channel.given {
                Given::End => end,
                Given::Middle => 0.5 * (begin + end),
                Given::Ramp => {
                    self.slopes[ramps] = (end - begin) / frame.step;
                    ramps += 1;
                    begin
                }
            };
        }
    }

    /// The outputs that depend at once on what is given at the middle, from a step that holds the values of the end.
    /// Its motion is off by the order of the step, and so is what the outputs owe to the motion by the second order.
    fn try_outputs(&mut self, frame: &Frame) -> Result<Stepped, SlaveError> {
        let Some(at_once) = &mut self.at_once else { return Ok(Stepped::Done) };
        self.slave.save(TRIAL)?;
        self.slave.set(&self.input_positions, &self.end)?;
        let stepped = self.slave.do_step(frame.time, frame.step)?;
        if stepped == Stepped::Done {
            self.slave.get(&at_once.outputs, &mut at_once.found)?;
            self.slave.restore(TRIAL)?;
        }
        Ok(stepped)
    }

    /// Outputs to the inputs at the end, where they were given at the middle.
    fn correct(&mut self) -> Result<(), SlaveError> {
        let Some(at_once) = &mut self.at_once else { return Ok(()) };
        if at_once.derived {
            for ((direction, end), value) in self.direction.iter_mut().zip(&self.end).zip(&self.values) {
                *direction = end - value;
            }
            self.slave.directional_derivative(
                &at_once.outputs,
                &self.input_positions,
                &self.direction,
                &mut at_once.found,
            )?;
        }
        for (place, found) in at_once.places.iter().zip(&at_once.found) {
            if at_once.derived {
                self.outputs[*place] += found;
            } else {
                self.outputs[*place] = *found;
            }
        }
        Ok(())
    }

    /// Reads the outputs, which must be numbers, and finite where they feed others.
    pub fn read_numbers(&mut self) -> Result<(), SlaveError> {
        self.read()?;
        let fits = self.outputs.iter().all(|value| value.is_finite());
        if fits { Ok(()) } else { self.refuse_numbers() }
    }

    #[cold]
    fn refuse_numbers(&self) -> Result<(), SlaveError> {
        let wrong = |place: &usize| match self.coupled_places.contains(place) {
            true => !self.outputs[*place].is_finite(),
            false => self.outputs[*place].is_nan(),
        };
        let Some(place) = (0..self.outputs.len()).find(wrong) else { return Ok(()) };
        let row = &self.slave.variables()[self.output_positions[place]];
        Err(self.no_number(&format!("the output `{}`", row.name), self.outputs[place]))
    }

    /// That `what` has no value to go on with.
    #[cold]
    fn no_number(&self, what: &str, value: f64) -> SlaveError {
        let message = format!("{what} is {value}, with which the simulation cannot go on");
        SlaveError { slave: self.slave.name().to_owned(), message, severity: Severity::Slave }
    }

    pub fn read(&mut self) -> Result<(), SlaveError> {
        if self.outputs.is_empty() {
            return Ok(());
        }
        self.slave.get(&self.output_positions, &mut self.outputs)
    }

    /// Sets the inputs for the outputs before the first step, from signals and assumptions.
    pub fn settle(
        &mut self,
        signals: &Signals,
        assumed: &[f64],
        origins: &[SignalSource],
    ) -> Result<(), SlaveError> {
        for ((channel, origin), value) in self.channels.iter().zip(origins).zip(&mut self.values) {
            *value = match origin {
                SignalSource::Assumed(unknown) => assumed[*unknown],
                _ => channel.of(signals.next[channel.source]),
            };
        }
        if !self.values.is_empty() {
            self.slave.set(&self.input_positions, &self.values)?;
        }
        self.read()
    }

    /// Change of the outputs that feed others where the inputs change by `direction`, at their places in `change`.
    pub fn derive(&mut self, change: &mut [f64]) -> Result<(), SlaveError> {
        if self.coupled.is_empty() || self.input_positions.is_empty() {
            return Ok(());
        }
        let (inputs, direction) = (&self.input_positions, &self.direction);
        self.slave.end_derivative(&self.coupled, inputs, direction, &mut self.change)?;
        for (place, value) in self.coupled_places.iter().zip(&self.change) {
            change[*place] = *value;
        }
        Ok(())
    }

    /// Reads the derivatives of the outputs that feed others, of orders 1 up to `order`, at their places.
    pub fn read_derivatives(
        &mut self,
        order: u32,
        derivatives: &mut [Vec<f64>; 2],
    ) -> Result<(), SlaveError> {
        let order = order.min(self.abilities.output_derivative_order).min(2);
        if self.coupled.is_empty() {
            return Ok(());
        }
        for (order, derivatives) in (1..=order).zip(derivatives) {
            self.slave.output_derivatives(&self.coupled, order, &mut self.change)?;
            for ((place, position), value) in self.coupled_places.iter().zip(&self.coupled).zip(&self.change)
            {
                if !value.is_finite() {
                    let name = &self.slave.variables()[*position].name;
                    return Err(self.no_number(&format!("the derivative of the output `{name}`"), *value));
                }
                derivatives[self.first + place] = *value;
            }
        }
        Ok(())
    }

    /// Takes the step as done.
    pub fn accept(&mut self) {
        copy_few(&mut self.reached, &self.end);
    }

    /// Both ends of what input `channel` ran through in the last step.
    pub fn taken(&self, channel: usize, plain: bool) -> [f64; 2] {
        if plain || self.channels[channel].given != Given::Ramp {
            return [self.values[channel]; 2];
        }
        [self.begin[channel], self.end[channel]]
    }
}
