//! A step of one slave: its inputs over it, in one piece or several, and its outputs at the end.

use super::course::Course;
use super::unit::{BEGINNING, Frame, Given, SignalSource, TRIAL, Unit};
use crate::cosim::slave::{SlaveError, Stepped};

impl Unit {
    /// Steps, and leaves in `outcome` how it went and in `outputs` the values at the end.
    pub fn advance(&mut self, frame: &Frame) {
        self.outcome = self.try_advance(frame);
    }

    fn try_advance(&mut self, frame: &Frame) -> Result<Stepped, SlaveError> {
        if frame.restore {
            self.slave.restore(BEGINNING)?;
        }
        self.run_inputs(frame);
        let tried = !frame.plain && self.at_once.as_ref().is_some_and(|at_once| !at_once.derived);
        let parts = if frame.plain { 1 } else { self.parts };
        let step = frame.step / f64::from(parts);
        for part in 0..parts {
            let time = frame.time + f64::from(part) * step;
            self.fill(frame.plain, step, [part, part + 1].map(|end| f64::from(end) / f64::from(parts)));
            if tried && part + 1 == parts {
                let stepped = self.try_outputs(time, step)?;
                if stepped != Stepped::Done {
                    return Ok(stepped);
                }
            }
            self.give(frame.plain)?;
            let stepped = self.slave.do_step(time, step)?;
            if stepped != Stepped::Done {
                return Ok(stepped);
            }
        }
        self.read_numbers()?;
        if !frame.plain {
            self.correct()?;
            self.read_slopes()?;
        }
        Ok(Stepped::Done)
    }

    /// Both ends of the inputs, and how they run from one to the other.
    fn run_inputs(&mut self, frame: &Frame) {
        let Frame { signals, assumed, step, .. } = *frame;
        for (index, channel) in self.channels.iter().enumerate() {
            let end = match channel.origin {
                SignalSource::Computed => channel.of(signals.next[channel.source]),
                SignalSource::Extrapolated => channel.of(signals.predicted[channel.source]),
                SignalSource::Assumed(unknown) => assumed[unknown],
            };
            let begin = match channel.continued {
                true => self.reached[index],
                false => channel.of(signals.now[channel.source]),
            };
            (self.begin[index], self.end[index]) = (begin, end);
            let slopes = channel.slope.filter(|_| signals.sloped).map(|source| {
                let end = match source {
                    SignalSource::Assumed(unknown) => assumed[unknown],
                    _ => channel.factor * signals.slopes[1][channel.source],
                };
                [step * channel.factor * signals.slopes[0][channel.source], step * end]
            });
            self.courses[index] = Course::new([begin, end], slopes);
        }
    }

    /// What is set for the part of a step between two fractions of it, of `step` (s).
    fn fill(&mut self, plain: bool, step: f64, [from, to]: [f64; 2]) {
        let mut ramps = 0;
        for (index, channel) in self.channels.iter().enumerate() {
            let course = &self.courses[index];
            self.values[index] = match channel.given {
                _ if plain => self.end[index],
                Given::End => course.at(to),
                Given::Middle => course.mean(from, to),
                Given::Ramp => {
                    let derivatives = match self.parts {
                        1 => course.derivatives(step),
                        _ => [(course.at(to) - course.at(from)) / step, 0.0, 0.0],
                    };
                    for (slopes, derivative) in self.slopes.iter_mut().zip(derivatives) {
                        slopes[ramps] = derivative;
                    }
                    ramps += 1;
                    course.at(from)
                }
            };
        }
    }

    /// Sets the values, and the derivatives of those that run.
    fn give(&mut self, plain: bool) -> Result<(), SlaveError> {
        if !self.values.is_empty() {
            self.slave.set(&self.input_positions, &self.values)?;
        }
        if plain || self.ramp_positions.is_empty() {
            return Ok(());
        }
        let curved = self.parts == 1 && self.abilities.input_derivative_order >= 3;
        let curved = curved && self.courses.iter().any(Course::is_curved);
        for (order, slopes) in (1..=if curved { 3 } else { 1 }).zip(&self.slopes) {
            self.slave.set_input_derivatives(&self.ramp_positions, order, slopes)?;
        }
        Ok(())
    }

    /// Reads the slopes at this instant of the outputs that feed others, if they are asked for.
    pub fn read_slopes(&mut self) -> Result<(), SlaveError> {
        if self.slopes_out.is_empty() {
            return Ok(());
        }
        self.slave.output_derivatives(&self.coupled, 1, &mut self.slopes_out)?;
        self.check_slopes(&self.slopes_out)
    }

    pub(super) fn check_slopes(&self, slopes: &[f64]) -> Result<(), SlaveError> {
        let Some(place) = slopes.iter().position(|slope| !slope.is_finite()) else { return Ok(()) };
        let name = &self.slave.variables()[self.coupled[place]].name;
        Err(self.no_number(&format!("the derivative of the output `{name}`"), slopes[place]))
    }

    /// The outputs that depend at once on what is given at the middle, from a step that holds the values of the end.
    /// Its motion is off by the order of the step, and so is what the outputs owe to the motion by the second order.
    fn try_outputs(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        let Some(at_once) = &mut self.at_once else { return Ok(Stepped::Done) };
        self.slave.save(TRIAL)?;
        self.slave.set(&self.input_positions, &self.end)?;
        let stepped = self.slave.do_step(time, step)?;
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
}
