//! The inputs of a model over a step: straight lines or cubics, which the state remembers.

use crate::time::Ramp;

/// How an input is given for a step.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Given {
    /// By its end: it runs there from where it had ended.
    Runs,
    /// By a value that it keeps.
    Held,
    /// By its beginning and its derivatives.
    Sloped,
}

/// Inputs over the last step, or over the one under way.
#[derive(Debug, Clone)]
pub(super) struct Lines {
    /// Whether inputs without a derivative run from their previous values to those set, or are held.
    run: bool,
    pub all: Vec<Ramp>,
    given: Vec<Given>,
    /// What each is taken to have come from where its rate is asked for: its start, or the end of the step before where
    /// it is held. Values held one after the other stand for an input that runs, whose rate is that of their differences.
    from: Vec<f64>,
    /// Length of the step (s); 0 before the first.
    pub step: f64,
    /// Whether one of them began elsewhere than where it had ended.
    pub jumped: bool,
}

/// Numbers of the step, and of each line: its start, its end, how it is bent, how it was given, what it came from.
const OF_STEP: usize = 2;
const PER_LINE: usize = 6;
/// Which of a line's are its start and its end.
const START: usize = 0;
const END: usize = 1;
/// In the place of whether a line jumped: all ran straight from where they had ended, which is all that their other numbers
/// would say.
const STRAIGHT: f64 = 2.0;

/// Derivatives of an input with respect to time: the first, the second, the third.
pub(super) type Derivatives = [f64; 3];

/// Parts of a contact's state: its memory now and before the last step, each of `memory` numbers, and that step's lines.
pub(super) fn parts(state: &mut [f64], memory: usize) -> (&mut [f64], &mut [f64], &mut [f64]) {
    let (now, rest) = state.split_at_mut(memory);
    let (before, lines) = rest.split_at_mut(memory);
    (now, before, lines)
}

/// Numbers that a state has of so many lines.
pub(super) const fn length(inputs: usize) -> usize {
    OF_STEP + PER_LINE * inputs
}

impl Lines {
    /// So many inputs, which `run` to their values or are held.
    pub fn new(inputs: usize, run: bool) -> Self {
        let mut lines = Self {
            run,
            all: vec![Ramp::held(0.0); inputs],
            given: vec![Given::Held; inputs],
            from: vec![0.0; inputs],
            step: 0.0,
            jumped: false,
        };
        lines.hold(&vec![0.0; inputs]);
        lines
    }

    /// Numbers that a state has of them.
    pub fn state_len(&self) -> usize {
        length(self.all.len())
    }

    /// Held at `values`, before the first step.
    pub fn hold(&mut self, values: &[f64]) {
        self.all.iter_mut().zip(values).for_each(|(line, value)| *line = Ramp::held(*value));
        self.from.iter_mut().zip(values).for_each(|(from, value)| *from = *value);
        self.given.fill(Given::Held);
        (self.step, self.jumped) = (0.0, false);
    }

    /// Takes over what a state has.
    pub fn read(&mut self, state: &[f64]) {
        let straight = state[1] == STRAIGHT;
        (self.step, self.jumped) = (state[0], state[1] != 0.0 && !straight);
        let lines = self.all.iter_mut().zip(&mut self.given).zip(&mut self.from);
        for (((line, given), from), saved) in lines.zip(state[OF_STEP..].chunks_exact(PER_LINE)) {
            if straight {
                (*line, *given, *from) = (Ramp::line(saved[START], saved[END]), Given::Runs, saved[START]);
                continue;
            }
            *line = Ramp { start: saved[0], end: saved[1], bow: saved[2], skew: saved[3] };
            *given = [Given::Runs, Given::Held, Given::Sloped][saved[4].clamp(0.0, 2.0) as usize];
            *from = saved[5];
        }
    }

    /// Writes them to a state.
    pub fn write(&self, state: &mut [f64]) {
        state[..OF_STEP].copy_from_slice(&[self.step, f64::from(u8::from(self.jumped))]);
        let lines = self.all.iter().zip(&self.given).zip(&self.from);
        for (((line, given), from), saved) in lines.zip(state[OF_STEP..].chunks_exact_mut(PER_LINE)) {
            let Ramp { start, end, bow, skew } = *line;
            saved.copy_from_slice(&[start, end, bow, skew, f64::from(*given as u8), *from]);
        }
    }

    /// Writes to `state` that all inputs are held at `values`, before the first step.
    pub fn write_held(state: &mut [f64], values: &[f64]) {
        state.fill(0.0);
        for (value, saved) in values.iter().zip(state[OF_STEP..].as_chunks_mut::<PER_LINE>().0) {
            *saved = [*value, *value, 0.0, 0.0, f64::from(Given::Held as u8), *value];
        }
    }

    /// Those of the next step, of `step` (s), after those that a state has of the `last`, with `values` set and
    /// derivatives in `slopes`, which is empty if there is none.
    pub fn go_on(&mut self, last: &[f64], values: &[f64], slopes: &[Option<Derivatives>], step: f64) {
        (self.step, self.jumped) = (step, false);
        let lines = self.all.iter_mut().zip(&mut self.given).zip(&mut self.from);
        let given = values.iter().zip(last[OF_STEP..].chunks_exact(PER_LINE));
        for (input, (((line, given), from), (value, last))) in lines.zip(given).enumerate() {
            let (value, slope) = (*value, slopes.get(input).copied().flatten());
            let ended = last[END];
            (*given, *line) = match slope {
                Some(slopes) => (Given::Sloped, Ramp::with_derivatives(value, slopes, step)),
                None if self.run => (Given::Runs, Ramp::line(ended, value)),
                None => (Given::Held, Ramp::held(value)),
            };
            *from = if slope.is_some() { line.start } else { ended };
            self.jumped |= line.start != ended;
        }
    }

    /// Writes to `state`, and only there, that all inputs have run straight from where they had ended to `values` in `step`
    /// (s): what most steps do, so that it takes no more than it must.
    #[inline]
    pub fn run_on<const INPUTS: usize>(state: &mut [f64], values: [f64; INPUTS], step: f64) {
        let Some((of_step, of_lines)) = state.split_first_chunk_mut::<OF_STEP>() else { return };
        *of_step = [step, STRAIGHT];
        let Some(saved) = of_lines.as_chunks_mut::<PER_LINE>().0.first_chunk_mut::<INPUTS>() else { return };
        for (saved, value) in saved.iter_mut().zip(values) {
            saved[START] = saved[END];
            saved[END] = value;
        }
    }

    /// The ends of all inputs in a state, if they ran there straight from where they had ended.
    #[inline]
    pub fn straight_ends<const INPUTS: usize>(state: &[f64]) -> Option<[f64; INPUTS]> {
        let (of_step, of_lines) = state.split_first_chunk::<OF_STEP>()?;
        let saved = of_lines.as_chunks::<PER_LINE>().0.first_chunk::<INPUTS>()?;
        (of_step[1] == STRAIGHT).then(|| saved.each_ref().map(|saved| saved[END]))
    }

    /// Whether a line began at a value set for the step.
    pub fn begin_anew(&self) -> bool {
        self.given.iter().any(|given| *given != Given::Runs)
    }

    /// How an input runs over the step.
    pub fn along(&self, input: usize) -> Ramp {
        self.all[input]
    }

    /// How a line changes with the `change` of an input: one that went on from the previous one has a fixed start.
    pub fn change(&self, input: usize, change: &Ramp) -> Ramp {
        Ramp { start: if self.given[input] == Given::Runs { 0.0 } else { change.start }, ..*change }
    }

    /// How an input goes on beyond the end of the step for as long again.
    pub fn beyond(&self, input: usize) -> Ramp {
        let line = &self.all[input];
        Ramp::line(line.end, line.end + Ramp { start: self.from[input], ..*line }.rise())
    }

    /// How [`Lines::beyond`] changes with the `change` of an input.
    pub fn beyond_changed(&self, input: usize, change: &Ramp) -> Ramp {
        // Where a held input came from is over.
        let start = if self.given[input] == Given::Sloped { change.start } else { 0.0 };
        Ramp::line(change.end, change.end + Ramp { start, ..*change }.rise())
    }
}
