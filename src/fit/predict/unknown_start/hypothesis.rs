//! What happened to a contact before its record began: hypotheses of its initial state, each with one unknown number.
//!
//! A force at the first sample is the whole state of one slider, but not of many, and not of a contact that
//! was half-way through an unloading. What was repeated before the record began was most likely the motion
//! of the record itself: the second hypothesis runs once through its first period, around an unknown centre.

use crate::contact::{ContactLaw, Inputs};
use crate::fit::least_squares::{Parameter, Scale};

/// A hypothesis of the state at the first sample, with what it needs to know of the motion.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct InitialState {
    hypothesis: Hypothesis,
    /// Samples of the first period, or of the whole record where it does not repeat.
    cycle: usize,
    /// Half of the range of the motion (m), and its middle.
    reach: f64,
    middle: f64,
    /// The nuisance's bounds.
    lower: f64,
    upper: f64,
}

/// What may have happened.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Hypothesis {
    /// From rest along the first loading curve to a force; the unknown says where it lies between the least and the largest
    /// that the contact can carry there.
    FirstLoading,
    /// From rest at an unknown displacement through the motion of one period.
    Cycle,
    /// Slipping, then moved back by an unknown distance: the motion before the record was larger than its own, or
    /// does not repeat. Above zero it came from a larger displacement.
    Unloading,
}

/// The hypotheses in the order of trial; the later must be better to be chosen.
pub(super) const HYPOTHESES: [Hypothesis; 3] =
    [Hypothesis::FirstLoading, Hypothesis::Cycle, Hypothesis::Unloading];

/// Candidates of the search before the refinement: the error has several minima in the unknown when the
/// record starts with small loops, and half as many fall beside the best of motions that decay.
const CANDIDATES: usize = 25;
/// Yield displacements that a contact may have moved back: one that yields by and by is then at its limit again.
const RETURN: f64 = 4.0;
/// A force (N) that no contact carries.
const FAR: f64 = 1e100;
/// Halvings of a metre down to the smallest gap that is looked for (m).
const FINEST: i32 = 40;
/// Golden-section steps after that; each shrinks the bracket by 0.618.
const REFINEMENTS: usize = 12;
/// Fraction of a record by which its start is judged: long enough to see it, and no longer, since a contact
/// that slips forgets it.
const TELLING: f64 = 0.25;
/// Samples, and periods, that always tell the start, which is one number.
const ENOUGH: [usize; 2] = [20_000, 8];

impl InitialState {
    /// For a record of this `displacement` (m), which repeats after `period` samples, not always whole ones.
    pub fn new(displacement: &[f64], period: Option<f64>) -> Self {
        let range = displacement
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), u| (low.min(*u), high.max(*u)));
        let count = displacement.len();
        let cycle = period.map_or(count, |period| (period.round() as usize).min(count));
        Self {
            hypothesis: Hypothesis::FirstLoading,
            cycle,
            reach: 0.5 * (range.1 - range.0),
            middle: 0.5 * (range.1 + range.0),
            lower: -1.0,
            upper: 1.0,
        }
    }

    /// Samples that tell the start of a record of `count`.
    pub fn telling(&self, count: usize) -> usize {
        let [samples, periods] = ENOUGH;
        ((count as f64 * TELLING) as usize).min(samples.max(periods * self.cycle)).max(2).min(count)
    }

    /// Takes up a hypothesis; `law` and `load` (N) say how far a centre may lie outside the motion.
    pub fn choose(&mut self, hypothesis: Hypothesis, law: &dyn ContactLaw, load: f64) {
        self.hypothesis = hypothesis;
        (self.lower, self.upper) = match hypothesis {
            Hypothesis::FirstLoading => (-1.0, 1.0),
            Hypothesis::Cycle => {
                // Farther out every slider has slipped, and the centre is forgotten.
                let slack = 2.0 * self.reach + yield_displacement(law, load);
                (self.middle - slack, self.middle + slack)
            }
            Hypothesis::Unloading => {
                let back = RETURN * yield_displacement(law, load);
                (-back, back)
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

    /// Puts the state before the first sample into `state`.
    pub fn put(
        &self,
        law: &dyn ContactLaw,
        inputs: &impl Fn(usize) -> Inputs,
        value: f64,
        state: &mut [f64],
    ) {
        let first = inputs(0);
        match self.hypothesis {
            Hypothesis::FirstLoading => {
                let [least, largest] = [-FAR, FAR].map(|force| {
                    law.set_state(first.displacement, first.normal_load, force, state);
                    law.advance(state, Inputs { velocity: 0.0, ..first })
                });
                let force = 0.5 * ((1.0 - value) * least + (1.0 + value) * largest);
                law.set_state(first.displacement, first.normal_load, force, state);
            }
            Hypothesis::Cycle => {
                law.set_state(value, first.normal_load, 0.0, state);
                for index in 0..self.cycle {
                    law.advance(state, inputs(index));
                }
                law.restart(state);
            }
            Hypothesis::Unloading => {
                law.set_state(first.displacement + value, first.normal_load, value.signum() * FAR, state);
                law.advance(state, Inputs { velocity: 0.0, ..first });
                law.restart(state);
            }
        }
    }
}

/// Displacement (m) at which a contact from rest reaches its limit in stick, to a factor of two of a gap in series.
fn yield_displacement(law: &dyn ContactLaw, load: f64) -> f64 {
    let limit = law.limit(load);
    let mut state = vec![0.0; law.state_len()];
    let mut next = state.clone();
    law.set_state(0.0, load, 0.0, &mut state);
    let mut stiffness = |displacement| {
        let inputs = Inputs { displacement, velocity: 0.0, normal_load: load };
        law.step(&state, inputs, &mut next).tangents.displacement
    };
    // In the middle of a gap nothing resists.
    let ways = std::iter::once(0.0).chain((0..FINEST).rev().map(|halvings| 0.5_f64.powi(halvings)));
    let resisted = ways.map(|way| (way, stiffness(way))).find(|(_, stiffness)| *stiffness > 0.0);
    resisted.map_or(0.0, |(way, stiffness)| way + limit / stiffness)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{Jenkins, Joint, JointChanges};
    use std::f64::consts::TAU;

    /// Every force between the contact's two limits can be the first of a record: springs beside the slider and
    /// unequal limits included.
    #[test]
    fn first_loading_reaches_every_force_and_no_value_twice() {
        let changes = JointChanges { residual_stiffness: 2e5, asymmetry: 0.3, ..JointChanges::default() };
        let law = Joint::new(Jenkins::new(2e6, 0.5).unwrap(), changes).unwrap();
        let first = Inputs { displacement: 3e-4, velocity: 0.0, normal_load: 100.0 };
        let mut initial = InitialState::new(&[3e-4; 20], None);
        initial.choose(Hypothesis::FirstLoading, &law, 100.0);
        let (mut state, mut next) = (vec![0.0; law.state_len()], vec![0.0; law.state_len()]);
        let mut force = |value| {
            initial.put(&law, &|_| first, value, &mut state);
            law.step(&state, first, &mut next).force
        };
        let spring = 2e5 * 3e-4;
        assert!((force(1.0) - (spring + 1.3 * 50.0)).abs() < 1e-9, "{}", force(1.0));
        assert!((force(-1.0) - (spring - 0.7 * 50.0)).abs() < 1e-9, "{}", force(-1.0));
        let steps: Vec<f64> = (0..=20).map(|k| force(f64::from(k) / 10.0 - 1.0)).collect();
        assert!(steps.windows(2).all(|pair| (pair[1] - pair[0] - 5.0).abs() < 1e-9), "{steps:?}");
    }

    /// With a gap in series the force alone does not tell the state: within the gap it is zero everywhere.
    #[test]
    fn a_contact_with_a_gap_may_start_anywhere_in_it() {
        let changes = JointChanges { half_gap: 1e-4, ..JointChanges::default() };
        let law = Joint::new(Jenkins::new(2e6, 0.5).unwrap(), changes).unwrap();
        let mut initial = InitialState::new(&[0.0; 20], None);
        initial.choose(Hypothesis::Unloading, &law, 100.0);
        let inputs = |displacement| Inputs { displacement, velocity: 0.0, normal_load: 100.0 };
        let (mut state, mut next) = (vec![0.0; law.state_len()], vec![0.0; law.state_len()]);
        // It slipped at 50 N, 25 µm of its spring away, and came back: then a way on through the rest of the gap.
        for (back, onward) in [(30e-6, 5e-6), (100e-6, 75e-6), (200e-6, 175e-6)] {
            assert!((initial.lower..initial.upper).contains(&back));
            initial.put(&law, &|_| inputs(0.0), back, &mut state);
            let force =
                |displacement: f64, next: &mut [f64]| law.step(&state, inputs(displacement), next).force;
            assert!(force(0.99 * onward, &mut next).abs() < 1e-9, "{back}");
            assert!((force(onward + 1e-5, &mut next) - 20.0).abs() < 1e-6, "{back}");
        }
    }

    #[test]
    fn a_contact_that_slipped_and_moved_back_carries_what_is_left() {
        let law = Jenkins::new(2e6, 0.5).unwrap();
        let first = Inputs { displacement: 1e-4, velocity: 0.0, normal_load: 100.0 };
        let mut initial = InitialState::new(&[1e-4; 20], None);
        initial.choose(Hypothesis::Unloading, &law, 100.0);
        let (mut state, mut next) = (vec![0.0; law.state_len()], vec![0.0; law.state_len()]);
        for (back, expected) in [(1e-5, 30.0), (-1e-5, -30.0), (4e-5, -30.0), (8e-5, -50.0)] {
            initial.put(&law, &|_| first, back, &mut state);
            let force = law.step(&state, first, &mut next).force;
            assert!((force - expected).abs() < 1e-9, "{back}: {force}");
        }
    }

    /// Many sliders, some of which never let go, remember a past of larger loops.
    #[test]
    fn the_best_unknown_is_found_whatever_the_past_of_a_motion_that_decays() {
        let changes = JointChanges { spread: 0.95, ..JointChanges::default() };
        let law = Joint::new(Jenkins::new(7e6, 0.62).unwrap(), changes).unwrap();
        let mut random = fastrand::Rng::with_seed(5);
        let mut worst = 0.0_f64;
        for _ in 0..24 {
            let (turn, decay) = (0.04 + 0.04 * random.f64(), 1.0 + 2.0 * random.f64());
            let (size, phase) = (1e-5 + 2e-5 * random.f64(), TAU * random.f64());
            let inputs = |index: i32| Inputs {
                displacement: size
                    * (-decay * 1e-3 * f64::from(index)).exp()
                    * (phase + turn * f64::from(index)).sin(),
                velocity: 0.0,
                normal_load: 150.0,
            };
            let mut state = vec![0.0; law.state_len()];
            law.set_state(0.0, 150.0, 0.0, &mut state);
            for index in -600..0 {
                law.advance(&mut state, inputs(index));
            }
            let force: Vec<f64> = (0..300).map(|index| law.advance(&mut state, inputs(index))).collect();
            let places: Vec<f64> = (0..1200).map(|index| inputs(index).displacement).collect();
            let mut initial = InitialState::new(&places, Some(TAU / turn));
            for hypothesis in HYPOTHESES {
                initial.choose(hypothesis, &law, 150.0);
                let misfit = |value: f64| {
                    let mut state = vec![0.0; law.state_len()];
                    initial.put(&law, &|index| inputs(index as i32), value, &mut state);
                    let square = |(index, f): (usize, &f64)| {
                        (law.advance(&mut state, inputs(index as i32)) - f).powi(2)
                    };
                    force.iter().enumerate().map(square).sum::<f64>()
                };
                let found = misfit(initial.search(&mut |value| misfit(value)));
                let place = |k: i32| initial.lower + (initial.upper - initial.lower) * f64::from(k) / 150.0;
                let least = (0..=150).map(|k| misfit(place(k))).fold(f64::INFINITY, f64::min);
                // A hundredth of the force.
                let relevant = 1e-4 * force.iter().map(|f| f * f).sum::<f64>();
                worst = worst.max((found - least) / relevant);
            }
        }
        assert!(worst < 1.0, "{worst}");
    }
}
