//! A slave with its connections: the sources of its inputs, and buffers for their values.

use super::course::Course;
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
    /// Where its slope at the end of a step comes from, if it runs along a cubic.
    pub slope: Option<SignalSource>,
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

/// Parts of a step in which a slave that takes no cubics follows one: the error of straight pieces is a hundredth then.
const PARTS: u32 = 10;

/// In how many parts a slave steps.
fn parts(abilities: &Abilities, channels: &[Channel]) -> u32 {
    let follows = |given: Given| match given {
        Given::Ramp => abilities.input_derivative_order < 3,
        Given::Middle => true,
        Given::End => false,
    };
    let mut curved = channels.iter().filter(|channel| channel.slope.is_some());
    if abilities.variable_step && curved.any(|channel| follows(channel.given)) { PARTS } else { 1 }
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
pub(super) struct AtOnce {
    /// By directional derivatives; otherwise by a step with the inputs of the end.
    pub(super) derived: bool,
    /// Positions in `outputs`, and in the slave's table.
    pub(super) places: Vec<usize>,
    pub(super) outputs: Vec<usize>,
    pub(super) found: Vec<f64>,
}

/// Where a slave's state at the beginning of a step is kept, and where it is while a step is only tried for outputs.
pub(in crate::cosim) const BEGINNING: usize = 0;
pub(super) const TRIAL: usize = 1;

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
    pub(super) coupled: Vec<usize>,
    pub coupled_places: Vec<usize>,
    change: Vec<f64>,
    pub(super) input_positions: Vec<usize>,
    pub(super) ramp_positions: Vec<usize>,
    /// Derivatives of those, of the orders that are given.
    pub(super) slopes: [Vec<f64>; 3],
    /// How each input runs over the step, as a cubic of the fraction of it.
    pub(super) courses: Vec<Course>,
    /// First derivatives of the Real outputs that feed others, if they are asked for.
    pub slopes_out: Vec<f64>,
    /// Change of the inputs of which the change of the outputs is asked for, and of their slopes at the end.
    pub direction: Vec<f64>,
    pub turning: Vec<f64>,
    /// Parts of a step in which a slave that knows no cubics follows them.
    pub(super) parts: u32,
    pub(super) at_once: Option<AtOnce>,
    pub outcome: Result<Stepped, SlaveError>,
}

impl Unit {
    /// `read` is what is read, by position, and whether it feeds another as a Real.
    pub fn new(
        slave: Box<dyn Slave>,
        mut channels: Vec<Channel>,
        first: usize,
        read: &[(usize, bool)],
        curved: bool,
    ) -> Self {
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
        let parts = parts(&abilities, &channels);
        if parts == 1 && abilities.input_derivative_order < 3 {
            // It runs straight.
            let ramps = channels.iter_mut().filter(|channel| channel.given == Given::Ramp);
            ramps.for_each(|channel| channel.slope = None);
        }
        let zeros = || vec![0.0; channels.len()];
        let ramps = channels.iter().filter(|channel| channel.given == Given::Ramp);
        let ramp_positions: Vec<usize> = ramps.map(|channel| channel.input).collect();
        let told = curved && abilities.output_derivative_order > 0 && !slave.has_corners();
        Self {
            slopes_out: if told { vec![0.0; coupled_places.len()] } else { Vec::new() },
            courses: vec![Course::default(); channels.len()],
            parts,
            turning: zeros(),
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
            slopes: std::array::from_fn(|_| vec![0.0; ramp_positions.len()]),
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
        format!("{}.{}", self.slave.name(), row.map_or("", |name| &**name))
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
    pub(super) fn no_number(&self, what: &str, value: f64) -> SlaveError {
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

    /// Changes of the outputs that feed others where the inputs change by `direction` at the end of the step, and their
    /// slopes there by `turning`, and changes of the slopes of those outputs, each at its place. A slope of an output is
    /// taken to follow the slopes of inputs as the value does the values: what passes through the motion is left out.
    pub fn derive(&mut self, change: &mut [f64], turn: &mut [f64], step: f64) -> Result<(), SlaveError> {
        if self.coupled.is_empty() || self.input_positions.is_empty() {
            return Ok(());
        }
        let curved = self.courses.iter().any(Course::is_curved);
        let turning = if curved { &self.turning[..] } else { &[] };
        let (outputs, inputs) = (&self.coupled, &self.input_positions);
        self.slave.end_derivative(outputs, inputs, &self.direction, turning, &mut self.change)?;
        for (place, value) in self.coupled_places.iter().zip(&self.change) {
            change[*place] = *value;
        }
        if self.slopes_out.is_empty() {
            return Ok(());
        }
        self.slave.end_derivative(outputs, inputs, &self.turning, &[], &mut self.change)?;
        for (place, value) in self.coupled_places.iter().zip(&self.change) {
            turn[*place] = value / step;
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
            for (place, value) in self.coupled_places.iter().zip(&self.change) {
                derivatives[self.first + place] = *value;
            }
            self.check_slopes(&self.change)?;
        }
        Ok(())
    }

    /// Takes the step as done.
    pub fn accept(&mut self) {
        copy_few(&mut self.reached, &self.end);
    }

    /// Both ends of what input `channel` ran through in the last step.
    pub fn taken(&self, channel: usize, plain: bool) -> [f64; 2] {
        if plain || self.parts == 1 && self.channels[channel].given != Given::Ramp {
            return [self.values[channel]; 2];
        }
        [self.begin[channel], self.end[channel]]
    }
}
