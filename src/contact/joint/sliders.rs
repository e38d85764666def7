//! Sliders in parallel whose limits may differ by direction: the fast step of a joint.

use super::look::{Look, Path};
use crate::contact::{ContactLaw, ParallelSliders, Slider, StateTangents};

/// Before the slider positions in the state: displacement (m) and load (N) at the end of the last step.
const SHARED: usize = 2;

/// Jenkins elements side by side. Everything that one step of all of them needs stands in plain arrays.
///
/// Its state is `[w, L, z₁ … zₙ]`. The load may be any number that scales all limits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sliders {
    /// kᵢ (N/m).
    stiffness: Vec<f64>,
    /// μᵢ/kᵢ (m/N): stretch at the limit, by load.
    stretch: Vec<f64>,
    /// Σ kᵢ (N/m).
    whole: f64,
    /// Limits over μᵢ L, against positive and against negative slip.
    up: f64,
    down: f64,
    parallel: ParallelSliders,
}

/// How the stretch of all springs follows from a step.
#[derive(Clone, Copy)]
struct Start {
    /// What the slider positions have moved by before contact, in the step in which it closes; else zero.
    shift: f64,
    /// Load (N) from which the limit runs, at least zero.
    load: f64,
    /// Displacement (m) at that instant.
    displacement: f64,
    closing: Option<Closing>,
}

/// Derivatives of the stretch in the step in which the contact closes.
#[derive(Clone, Copy)]
struct Closing {
    by_displacement: f64,
    by_load: f64,
    by_start_load: f64,
}

/// A slider that moves in a step.
struct Slipping {
    /// ±1.
    sign: f64,
    /// How far (m), above zero.
    slipped: f64,
    /// Limit over μᵢ L.
    side: f64,
}

impl Sliders {
    /// The elements of `parallel`, with limits `1 ± asymmetry` times theirs.
    pub fn new(parallel: ParallelSliders, asymmetry: f64) -> Self {
        let (stiffness, friction): (Vec<f64>, Vec<f64>) = parallel.elements().unzip();
        let stretch =
            friction.iter().zip(&stiffness).map(|(friction, stiffness)| friction / stiffness).collect();
        let whole = parallel.tangential_stiffness();
        Self { stiffness, stretch, whole, up: 1.0 + asymmetry, down: 1.0 - asymmetry, parallel }
    }

    pub fn state_len(&self) -> usize {
        SHARED + self.stiffness.len()
    }

    /// Largest force (N) in either direction.
    pub fn limit(&self, load: f64) -> f64 {
        self.up.max(self.down) * self.parallel.limit(load)
    }

    /// Writes the state that carries `force` (N), or as much of it as the limit allows; returns that.
    pub fn set_state(&self, displacement: f64, load: f64, force: f64, state: &mut [f64]) -> f64 {
        let side = if force < 0.0 { self.down } else { self.up };
        self.parallel.set_state(displacement, side * load, force, state);
        state[1] = load;
        let limit = side * self.parallel.limit(load);
        force.clamp(-limit, limit)
    }

    fn start(state: &[f64], displacement: f64, load: f64) -> Start {
        if state[1] > 0.0 {
            return Start { shift: 0.0, load: state[1], displacement: state[0], closing: None };
        }
        Self::closing(state, displacement, load)
    }

    /// Where contact closes on the way, the sliders rest from the displacement at that instant on.
    #[cold]
    fn closing(state: &[f64], displacement: f64, load: f64) -> Start {
        let (change, travel) = (load - state[1], displacement - state[0]);
        let closed = load / change;
        let shift = (1.0 - closed) * travel;
        let closing = Closing {
            by_displacement: closed,
            by_load: -travel * (state[1] / change) / change,
            by_start_load: travel * (closed / change),
        };
        Start { shift, load: 0.0, displacement: state[0] + shift, closing: Some(closing) }
    }

    /// One step in place; the force (N).
    pub fn advance(&self, state: &mut [f64], displacement: f64, load: f64) -> f64 {
        if load <= 0.0 {
            state.fill(displacement);
            state[1] = load;
            return 0.0;
        }
        if state[1] <= 0.0 {
            let shift = Self::start(state, displacement, load).shift;
            state[SHARED..].iter_mut().for_each(|slider| *slider += shift);
        }
        state[0] = displacement;
        state[1] = load;
        let (above, below) = (self.up * load, -self.down * load);
        let sliders = &mut state[SHARED..];
        if let ([slider], [stiffness], [stretch]) = (&mut *sliders, &*self.stiffness, &*self.stretch) {
            let total = displacement - *slider;
            let cut = within(total, below * stretch, above * stretch);
            *slider += total - cut;
            return stiffness * cut;
        }
        // Two sums side by side: one alone would wait for itself.
        let mut sums = [0.0; LANES];
        let mut sliders = sliders.chunks_exact_mut(LANES);
        let mut stiffnesses = self.stiffness.chunks_exact(LANES);
        let mut stretches = self.stretch.chunks_exact(LANES);
        for ((sliders, stiffnesses), stretches) in (&mut sliders).zip(&mut stiffnesses).zip(&mut stretches) {
            for lane in 0..LANES {
                let total = displacement - sliders[lane];
                let cut = within(total, below * stretches[lane], above * stretches[lane]);
                sliders[lane] += total - cut;
                sums[lane] += stiffnesses[lane] * cut;
            }
        }
        let rest =
            sliders.into_remainder().iter_mut().zip(stiffnesses.remainder()).zip(stretches.remainder());
        for (((slider, stiffness), stretch), sum) in rest.zip(&mut sums) {
            let total = displacement - *slider;
            let cut = within(total, below * stretch, above * stretch);
            *slider += total - cut;
            *sum += stiffness * cut;
        }
        sums.iter().sum()
    }

    /// Force (N) and its slope (N/m) after a step.
    pub fn force(&self, state: &[f64], displacement: f64, load: f64) -> (f64, f64) {
        if load <= 0.0 {
            return (0.0, 0.0);
        }
        let start = Self::start(state, displacement, load);
        let moved = displacement - start.shift;
        let (above, below) = (self.up * load, -self.down * load);
        let (mut force, mut slope) = (0.0, 0.0);
        for ((slider, stiffness), stretch) in state[SHARED..].iter().zip(&self.stiffness).zip(&self.stretch) {
            let total = moved - slider;
            let cut = within(total, below * stretch, above * stretch);
            force += stiffness * cut;
            slope += if cut == total { *stiffness } else { 0.0 };
        }
        (force, slope * start.closing.map_or(1.0, |closing| closing.by_displacement))
    }

    /// Mean distance the sliders slip in a step, each counted with its stiffness.
    pub fn path(&self, state: &[f64], displacement: f64, load: f64) -> Path {
        let mut path = Path::default();
        if load > 0.0 {
            let start = Self::start(state, displacement, load);
            for index in 0..self.stiffness.len() {
                if let Some(slip) = self.slip(index, &start, state, displacement, load) {
                    self.add_path(&mut path, index, &slip, &start);
                }
            }
        }
        path
    }

    fn add_path(&self, path: &mut Path, index: usize, slip: &Slipping, start: &Start) {
        let fraction = self.stiffness[index] / self.whole;
        let (by_displacement, by_load) =
            start.closing.map_or((1.0, 0.0), |closing| (closing.by_displacement, closing.by_load));
        path.length += fraction * slip.slipped;
        path.by_displacement += fraction * slip.sign * by_displacement;
        path.by_load += fraction * (slip.sign * by_load - slip.side * self.stretch[index]);
    }

    fn slip(
        &self,
        index: usize,
        start: &Start,
        state: &[f64],
        displacement: f64,
        load: f64,
    ) -> Option<Slipping> {
        let total = (displacement - start.shift) - state[SHARED + index];
        let (sign, side) = if total < 0.0 { (-1.0, self.down) } else { (1.0, self.up) };
        let slipped = sign * total - side * load * self.stretch[index];
        (slipped > 0.0).then_some(Slipping { sign, slipped, side })
    }

    /// Everything about a step but the next state.
    pub fn look(&self, state: &[f64], displacement: f64, load: f64) -> Look {
        let mut look = Look::default();
        if load <= 0.0 {
            look.dissipated_energy =
                if state[1] > 0.0 { self.lift_off(state, displacement, load) } else { 0.0 };
            return look;
        }
        let start = Self::start(state, displacement, load);
        let (by_displacement, by_load) =
            start.closing.map_or((1.0, 0.0), |closing| (closing.by_displacement, closing.by_load));
        for (index, &stiffness) in self.stiffness.iter().enumerate() {
            match self.slip(index, &start, state, displacement, load) {
                None => {
                    look.force += stiffness * ((displacement - start.shift) - state[SHARED + index]);
                    look.by_displacement += stiffness * by_displacement;
                    look.by_load += stiffness * by_load;
                }
                Some(slip) => {
                    let limit = slip.side * stiffness * self.stretch[index];
                    look.force += slip.sign * limit * load;
                    look.by_load += slip.sign * limit;
                    look.slips = true;
                    self.add_path(&mut look.path, index, &slip, &start);
                    look.dissipated_energy +=
                        limit * self.mean_load(index, &slip, &start, state, load) * slip.slipped;
                }
            }
        }
        look
    }

    /// Mean load (N) while the slider slips. Displacement and load run linearly within a step: slip begins
    /// where the stuck stretch crosses its limit, and lasts.
    fn mean_load(&self, index: usize, slip: &Slipping, start: &Start, state: &[f64], load: f64) -> f64 {
        let before = start.displacement - start.shift - state[SHARED + index];
        let margin = (slip.side * start.load * self.stretch[index] - slip.sign * before).max(0.0);
        let stuck = margin / (margin + slip.slipped);
        load + 0.5 * (1.0 - stuck) * (start.load - load)
    }

    /// Energy (J) dissipated on the way to the instant without load, where the springs give up all stretch.
    #[cold]
    fn lift_off(&self, state: &[f64], displacement: f64, load: f64) -> f64 {
        let (before, start) = (state[0], state[1]);
        let instant = before + start / (start - load) * (displacement - before);
        let mut energy = 0.0;
        for (index, stiffness) in self.stiffness.iter().enumerate() {
            let slider = state[SHARED + index];
            let (sign, side) = if instant < slider { (-1.0, self.down) } else { (1.0, self.up) };
            let slipped = sign * (instant - slider);
            let reach = side * self.stretch[index];
            let margin = (reach * start - sign * (before - slider)).max(0.0);
            if slipped > 0.0 {
                energy += 0.5 * stiffness * reach * (start * (slipped / (margin + slipped))) * slipped;
            }
        }
        energy
    }

    /// Derivatives of a step with respect to the state, in the block that begins at `offset`; those of the
    /// path stand in the row before `offset` that `path_row` names.
    pub fn partials(
        &self,
        state: &[f64],
        displacement: f64,
        load: f64,
        out: &mut StateTangents,
        (offset, path_row): (usize, usize),
    ) {
        let n = out.force_by_state.len();
        out.next_by_displacement[offset] = 1.0;
        out.next_by_normal_load[offset + 1] = 1.0;
        if load <= 0.0 {
            out.next_by_displacement[offset + SHARED..].fill(1.0);
            return;
        }
        let start = Self::start(state, displacement, load);
        let (w, l) = (offset, offset + 1);
        for (index, &stiffness) in self.stiffness.iter().enumerate() {
            let row = offset + SHARED + index;
            // Derivatives of the stretch by the start's displacement, its load and the slider.
            let by_start = match start.closing {
                None => [(w, 0.0), (l, 0.0), (row, -1.0)],
                Some(closing) => {
                    [(w, 1.0 - closing.by_displacement), (l, closing.by_start_load), (row, -1.0)]
                }
            };
            match self.slip(index, &start, state, displacement, load) {
                None => {
                    for (column, by) in by_start {
                        out.force_by_state[column] += stiffness * by;
                        out.next_by_state[row * n + column] = -by;
                    }
                    if let Some(closing) = start.closing {
                        out.next_by_displacement[row] = 1.0 - closing.by_displacement;
                        out.next_by_normal_load[row] = -closing.by_load;
                    }
                }
                Some(slip) => {
                    let fraction = slip.sign * stiffness / self.whole;
                    for (column, by) in by_start {
                        out.next_by_state[path_row * n + column] += fraction * by;
                    }
                    out.next_by_displacement[row] = 1.0;
                    out.next_by_normal_load[row] = -slip.sign * slip.side * self.stretch[index];
                }
            }
        }
    }

    /// Whether the contact is closed before and after a step.
    pub fn stay_closed(&self, state: &[f64], load: f64) -> bool {
        state[1] > 0.0 && load > 0.0
    }

    /// Derivatives of force and path by the state's number `place`, in a step in which the contact stays closed.
    pub fn by_place(&self, place: usize, state: &[f64], displacement: f64, load: f64) -> (f64, f64) {
        let Some(index) = place.checked_sub(SHARED) else { return (0.0, 0.0) };
        let start = Start { shift: 0.0, load: state[1], displacement: state[0], closing: None };
        match self.slip(index, &start, state, displacement, load) {
            None => (-self.stiffness[index], 0.0),
            Some(slip) => (0.0, -slip.sign * self.stiffness[index] / self.whole),
        }
    }

    /// Energy (J) kept in the springs.
    pub fn stored_energy(&self, state: &[f64]) -> f64 {
        self.parallel.stored_energy_at(state[0], &state[SHARED..])
    }

    /// Number of sliders.
    pub fn len(&self) -> usize {
        self.stiffness.len()
    }

    /// The sliders under a constant load above zero, each with play `half_gap` in series.
    pub fn pieces(&self, load: f64, half_gap: f64, out: &mut Vec<Slider>) {
        for (stiffness, stretch) in self.stiffness.iter().zip(&self.stretch) {
            let limit = stiffness * stretch * load;
            out.push(Slider {
                stiffness: *stiffness,
                play_below: -half_gap,
                play_above: half_gap,
                lower_limit: self.down * limit,
                upper_limit: self.up * limit,
            });
        }
    }
}

const LANES: usize = 4;

/// `value` within `[lower, upper]`; NaN stays NaN. Written so that it becomes two instructions.
#[inline(always)]
fn within(value: f64, lower: f64, upper: f64) -> f64 {
    let value = if upper < value { upper } else { value };
    if lower > value { lower } else { value }
}
