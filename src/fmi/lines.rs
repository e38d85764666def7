//! The inputs of a model over a step: straight lines, which the state remembers.

use crate::time::Ramp;

/// Inputs over the last step, or over the one under way.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    /// Whether inputs without a derivative run from their previous values to those set, or are held.
    run: bool,
    pub all: Vec<Ramp>,
    /// Which of them began at a value set for the step.
    anew: Vec<bool>,
    /// Length of the step (s); 0 before the first.
    pub step: f64,
    /// Whether one of them began elsewhere than where it had ended.
    pub jumped: bool,
}

/// Numbers of the step, and of each line: its start, its end, whether it began anew.
const OF_STEP: usize = 2;
const PER_LINE: usize = 3;

impl Lines {
    /// So many inputs, which `run` to their values or are held.
    pub fn new(inputs: usize, run: bool) -> Self {
        let all = vec![Ramp::held(0.0); inputs];
        Self { run, all, anew: vec![true; inputs], step: 0.0, jumped: false }
    }

    /// Numbers that a state has of them.
    pub fn state_len(&self) -> usize {
        OF_STEP + PER_LINE * self.all.len()
    }

    /// Held at `values`, before the first step.
    pub fn hold(&mut self, values: &[f64]) {
        self.all.iter_mut().zip(values).for_each(|(line, value)| *line = Ramp::held(*value));
        self.anew.fill(true);
        (self.step, self.jumped) = (0.0, false);
    }

    /// Takes over what a state has.
    pub fn read(&mut self, state: &[f64]) {
        (self.step, self.jumped) = (state[0], state[1] != 0.0);
        let saved = state[OF_STEP..].chunks_exact(PER_LINE);
        for ((line, anew), saved) in self.all.iter_mut().zip(&mut self.anew).zip(saved) {
            *line = Ramp::line(saved[0], saved[1]);
            *anew = saved[2] != 0.0;
        }
    }

    /// Writes them to a state.
    pub fn write(&self, state: &mut [f64]) {
        state[..OF_STEP].copy_from_slice(&[self.step, f64::from(u8::from(self.jumped))]);
        let saved = state[OF_STEP..].chunks_exact_mut(PER_LINE);
        for ((saved, line), anew) in saved.zip(&self.all).zip(&self.anew) {
            saved.copy_from_slice(&[line.start, line.end, f64::from(u8::from(*anew))]);
        }
    }

    /// Those of the next step, of `step` (s), with `values` set and derivatives in `slopes`, which is empty if there is
    /// none.
    pub fn go_on(&mut self, values: &[f64], slopes: &[Option<f64>], step: f64) {
        (self.step, self.jumped) = (step, false);
        for (input, (line, anew)) in self.all.iter_mut().zip(&mut self.anew).enumerate() {
            let (value, slope) = (values[input], slopes.get(input).copied().flatten());
            *anew = slope.is_some() || !self.run;
            let ended = line.end;
            *line = match *anew {
                true => Ramp::with_slope(value, slope.unwrap_or(0.0), step),
                false => Ramp::line(ended, value),
            };
            self.jumped |= line.start != ended;
        }
    }

    /// Whether a line began at a value set for the step.
    pub fn begin_anew(&self) -> bool {
        self.anew.contains(&true)
    }

    /// How a line changes with the `change` of an input: one that went on from the previous one has a fixed start.
    pub fn change(&self, input: usize, change: &Ramp) -> Ramp {
        Ramp::line(if self.anew[input] { change.start } else { 0.0 }, change.end)
    }
}
