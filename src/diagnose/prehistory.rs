//! What happened to a contact before its record began: one unknown number, and a choice of stories that it
//! belongs to.
//!
//! A force at the first sample is the whole state of one slider, but not of many, and not of a contact that
//! was half-way through an unloading. What was repeated before the record began was most likely the motion
//! of the record itself: the second story runs once through its first period, around an unknown centre.

use crate::contact::{ContactLaw, Inputs};
use crate::identify::{Parameter, Scale};

/// The story before a record, with what it needs to know of the motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Prehistory {
    kind: Kind,
    /// Samples of the first period, or of the whole record where it does not repeat.
    cycle: usize,
    /// The period (samples), not always whole.
    period: Option<f64>,
    /// Half of the range of the motion (m), and its middle.
    reach: f64,
    middle: f64,
    /// The nuisance's bounds.
    lower: f64,
    upper: f64,
}

/// The stories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// From rest along the virgin curve to a force; the unknown is its share of the limit.
    Virgin,
    /// From rest at an unknown displacement through the motion of one period.
    Cycle,
}

/// Candidates of the search before the refinement: the error has several minima in the unknown when the
/// record starts with small loops.
const CANDIDATES: usize = 13;
/// Golden-section steps after that; each shrinks the bracket by 0.618.
const REFINEMENTS: usize = 12;
/// Share of a record by which its start is judged: long enough to see it, and no longer, since a contact
/// that slips forgets it.
const TELLING_SHARE: f64 = 0.25;

impl Prehistory {
    /// The stories in the order of trial; the later must be better to be chosen.
    pub const KINDS: [Kind; 2] = [Kind::Virgin, Kind::Cycle];

    /// For a record of this `displacement` (m).
    pub fn new(displacement: &[f64]) -> Self {
        let range = displacement
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(*u), high.max(*u)));
        let count = displacement.len();
        let period = super::periods::period(displacement);
        let cycle = period.map_or(count, |period| (period.round() as usize).min(count));
        Self {
            kind: Kind::Virgin,
            cycle,
            period,
            reach: 0.5 * (range.1 - range.0),
            middle: 0.5 * (range.1 + range.0),
            lower: -1.0,
            upper: 1.0,
        }
    }

    /// The motion's period (samples), where it has one.
    pub fn period(&self) -> Option<f64> {
        self.period
    }

    /// Samples that tell the start of a record of `count`.
    pub fn telling(&self, count: usize) -> usize {
        ((count as f64 * TELLING_SHARE) as usize).max(2).min(count)
    }

    /// Takes up a story; `law` and `load` (N) say how far a centre may lie outside the motion.
    pub fn choose(&mut self, kind: Kind, law: &dyn ContactLaw, load: f64) {
        self.kind = kind;
        (self.lower, self.upper) = match kind {
            Kind::Virgin => (-1.0, 1.0),
            Kind::Cycle => {
                // Farther out every slider has slipped, and the centre is forgotten.
                let slack = 2.0 * self.reach + yield_displacement(law, load);
                (self.middle - slack, self.middle + slack)
            }
        };
    }

    /// The unknown, starting at `value`.
    pub fn parameter(&self, value: f64) -> Parameter {
        Parameter { start: value, lower: self.lower, upper: self.upper, scale: Scale::Linear }
    }

    /// The unknown with the least `misfit`: a coarse search and a golden section.
    pub fn search(&self, misfit: &mut impl FnMut(f64) -> f64) -> f64 {
        let spacing = (self.upper - self.lower) / (CANDIDATES - 1) as f64;
        let best = (0..CANDIDATES)
            .map(|index| self.lower + spacing * index as f64)
            .map(|value| (misfit(value), value))
            .min_by(|left, right| left.0.total_cmp(&right.0))
            .map_or(0.0, |(_, value)| value);
        golden_section((best - spacing).max(self.lower), (best + spacing).min(self.upper), misfit)
    }

    /// Puts the state before the first sample into `state`; `next` is room of the same length.
    pub fn start(
        &self,
        law: &dyn ContactLaw,
        inputs: &impl Fn(usize) -> Inputs,
        value: f64,
        state: &mut [f64],
        next: &mut [f64],
    ) {
        let first = inputs(0);
        match self.kind {
            Kind::Virgin => {
                let force = value * law.limit(first.normal_load);
                law.set_state(first.displacement, first.normal_load, force, state);
            }
            Kind::Cycle => {
                law.set_state(value, first.normal_load, 0.0, state);
                for index in 0..self.cycle {
                    law.step(state, inputs(index), next);
                    state.copy_from_slice(next);
                }
                law.restart(state);
            }
        }
    }
}

/// Displacement (m) at which a virgin contact reaches its limit in stick.
fn yield_displacement(law: &dyn ContactLaw, load: f64) -> f64 {
    let limit = law.limit(load);
    let mut state = vec![0.0; law.state_len()];
    let mut next = state.clone();
    law.set_state(0.0, load, 0.0, &mut state);
    let inputs = Inputs { displacement: 0.0, velocity: 0.0, normal_load: load };
    let stiffness = law.step(&state, inputs, &mut next).tangents.displacement;
    if stiffness > 0.0 { limit / stiffness } else { 0.0 }
}

fn golden_section(mut low: f64, mut high: f64, cost: &mut impl FnMut(f64) -> f64) -> f64 {
    let ratio = (5.0_f64.sqrt() - 1.0) / 2.0;
    let mut inner = [high - ratio * (high - low), low + ratio * (high - low)];
    let mut costs = [cost(inner[0]), cost(inner[1])];
    for _ in 0..REFINEMENTS {
        if costs[0] <= costs[1] {
            high = inner[1];
            inner = [high - ratio * (high - low), inner[0]];
            costs = [cost(inner[0]), costs[0]];
        } else {
            low = inner[0];
            inner = [inner[1], low + ratio * (high - low)];
            costs = [costs[1], cost(inner[1])];
        }
    }
    if costs[0] <= costs[1] { inner[0] } else { inner[1] }
}
