//! The variational equation of piecewise-linear laws: regimes of constant stiffness.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::budget::Budget;
use super::signal::{evaluate, root, turning_points};
use crate::numeric::exponential::{PRODUCTS, exponential, norm, squarings};
use crate::time::exact::elements::{Branch, Element, Memory, elements};
use crate::time::exact::system::System;
use crate::time::{LoadedContact, OscillatorError};

/// Phases (rad) closer than this are the same: rounding of a few periods.
const SAME_PHASE: f64 = 1e-14;

/// One contact along its periodic displacement.
pub(super) struct Path<'a> {
    contact: usize,
    coefficients: &'a [f64],
    turns: Vec<f64>,
    /// Place of the first turn's memory among those of all contacts.
    first_slot: usize,
    elements: Vec<Element>,
    memory: Vec<Memory>,
    /// The turn at which each slider last came to rest; none if it never slipped.
    slot: Vec<Option<usize>>,
}

/// What changes at an instant: the tangent of a contact, and the memory of a turning point.
struct Change {
    phase: f64,
    contact: usize,
    stiffness: f64,
    /// Stiffness that each remembered displacement takes part in.
    weights: Vec<(usize, f64)>,
    /// Memory that takes on the displacement at this instant.
    remembered: Option<usize>,
}

pub(super) fn monodromy(
    system: &System,
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
    angular_frequency: f64,
    budget: Budget,
) -> Result<DMatrix<f64>, OscillatorError> {
    let all = elements(contacts)?;
    let mut changes: Vec<Change> = Vec::new();
    let mut slots = 0;
    let (mut stiffness, mut weights) = (vec![0.0; contacts.len()], vec![Vec::new(); contacts.len()]);
    for (contact, coefficients) in displacement.iter().enumerate() {
        let elements = all.iter().filter(|element| element.contact == contact).copied().collect();
        let mut path = Path::new(contact, coefficients, slots, elements);
        slots += path.turns.len();
        path.settle();
        (stiffness[contact], weights[contact]) = path.tangent();
        path.run(0.0, TAU, &mut Some(&mut changes));
    }
    changes.sort_by(|a, b| a.phase.total_cmp(&b.phase));
    // Turning points at which no slider comes to rest are remembered by none.
    let mut place = vec![None; slots];
    let mut used = 0;
    for slot in changes.iter().filter_map(|change| change.remembered) {
        place[slot] = Some(used);
        used += 1;
    }
    let compact = |weights: &mut Vec<(usize, f64)>| {
        weights.retain_mut(|(slot, _)| place[*slot].map(|place| *slot = place).is_some());
    };
    weights.iter_mut().for_each(compact);
    for change in &mut changes {
        compact(&mut change.weights);
        change.remembered = change.remembered.and_then(|slot| place[slot]);
    }
    let size = 2 * system.size + used;
    let (map, rate) = (DMatrix::identity(size, size), system.fastest());
    let mut walk = Walk { system, rate, map, stiffness, weights, budget };
    let mut phase = 0.0;
    for change in changes {
        walk.advance((change.phase - phase) / angular_frequency)?;
        phase = change.phase;
        walk.change(change);
    }
    walk.advance((TAU - phase) / angular_frequency)?;
    Ok(walk.map)
}

/// Stiffness of every contact (N/m) where no slider changes its branch all along the period; `None` where one does.
pub(super) fn constant_stiffness(
    contacts: &[LoadedContact],
    displacement: &[&[f64]],
) -> Result<Option<Vec<f64>>, OscillatorError> {
    let all = elements(contacts)?;
    let mut stiffness = Vec::with_capacity(contacts.len());
    for (contact, coefficients) in displacement.iter().enumerate() {
        let elements = all.iter().filter(|element| element.contact == contact).copied().collect();
        let mut path = Path::new(contact, coefficients, 0, elements);
        let mut changes = Vec::new();
        path.settle();
        stiffness.push(path.tangent().0);
        path.run(0.0, TAU, &mut Some(&mut changes));
        if !changes.is_empty() {
            return Ok(None);
        }
    }
    Ok(Some(stiffness))
}

impl<'a> Path<'a> {
    pub fn new(contact: usize, coefficients: &'a [f64], first_slot: usize, elements: Vec<Element>) -> Self {
        let turns = turning_points(coefficients);
        let slot = vec![None; elements.len()];
        Self { contact, coefficients, turns, first_slot, elements, memory: vec![], slot }
    }

    /// Phases of a period at which a slider begins to slip, or leaves or enters its play.
    pub fn jumps(mut self) -> Vec<f64> {
        let mut changes = Vec::new();
        self.settle();
        self.run(0.0, TAU, &mut Some(&mut changes));
        changes.iter().filter(|change| change.remembered.is_none()).map(|change| change.phase).collect()
    }

    fn displacement(&self, phase: f64) -> f64 {
        evaluate(self.coefficients, phase).0
    }

    /// Loads a contact without history to the displacement of the largest magnitude, from where the motion is
    /// periodic, and carries it to phase zero.
    fn settle(&mut self) {
        let farthest = |a: &f64, b: &f64| self.displacement(*a).abs().total_cmp(&self.displacement(*b).abs());
        let start = self.turns.iter().copied().max_by(farthest).unwrap_or(0.0);
        let u = self.displacement(start);
        self.memory = self.elements.iter().map(|element| element.start(0.0, u, 0.0)).collect();
        self.run(start, 2.0 * TAU, &mut None);
    }

    /// Carries the contact from one phase to another and notes what changes. A turning point at the end belongs
    /// to it, one at the start does not: phase zero comes round again at the end of the period.
    fn run(&mut self, from: f64, to: f64, changes: &mut Option<&mut Vec<Change>>) {
        let mut phase = from;
        let mut turn = from / TAU;
        loop {
            // The next turning point after `phase`, whichever period it lies in.
            let period = turn.floor();
            let next = self.turns.iter().enumerate().find_map(|(k, t)| {
                let at = t + period * TAU;
                (at > phase + SAME_PHASE).then_some((k, at))
            });
            let Some((k, at)) = next else {
                turn = period + 1.0;
                if turn * TAU > to {
                    self.stretch(phase, to, changes);
                    return;
                }
                if self.turns.is_empty() {
                    self.stretch(phase, to, changes);
                    return;
                }
                continue;
            };
            if at > to + SAME_PHASE {
                self.stretch(phase, to, changes);
                return;
            }
            self.stretch(phase, at, changes);
            self.turn(k, at, changes);
            if at >= to - SAME_PHASE {
                return;
            }
            phase = at;
        }
    }

    /// Carries the contact along a stretch without turning point.
    fn stretch(&mut self, from: f64, to: f64, changes: &mut Option<&mut Vec<Change>>) {
        let (start, end) = (self.displacement(from), self.displacement(to));
        let mut phase = from;
        loop {
            let rising = end > start;
            let edge = if rising {
                self.memory.iter().map(|m| m.upper_edge).fold(f64::INFINITY, f64::min)
            } else {
                self.memory.iter().map(|m| m.lower_edge).fold(f64::NEG_INFINITY, f64::max)
            };
            if end == start || if rising { edge >= end } else { edge <= end } {
                return;
            }
            if (edge - self.displacement(phase)) * (end - start) > 0.0 {
                phase = root(|phase| self.displacement(phase) - edge, phase, to);
            }
            for (element, memory) in self.elements.iter().zip(&mut self.memory) {
                if rising && memory.upper_edge <= edge {
                    element.rise(memory, edge);
                } else if !rising && memory.lower_edge >= edge {
                    element.fall(memory, edge);
                }
            }
            self.note(phase, None, changes);
        }
    }

    fn turn(&mut self, k: usize, phase: f64, changes: &mut Option<&mut Vec<Change>>) {
        let u = self.displacement(phase);
        let mut rested = false;
        for ((element, memory), slot) in self.elements.iter().zip(&mut self.memory).zip(&mut self.slot) {
            if memory.slip() != 0.0 {
                element.turn(memory, u);
                *slot = Some(self.first_slot + k);
                rested = true;
            }
        }
        if rested {
            self.note(phase, Some(self.first_slot + k), changes);
        }
    }

    fn note(&self, phase: f64, remembered: Option<usize>, changes: &mut Option<&mut Vec<Change>>) {
        if let Some(changes) = changes {
            let (stiffness, weights) = self.tangent();
            changes.push(Change { phase, contact: self.contact, stiffness, weights, remembered });
        }
    }

    /// Stiffness of the contact now, and the parts of it that depend on remembered displacements.
    fn tangent(&self) -> (f64, Vec<(usize, f64)>) {
        let mut stiffness = 0.0;
        let mut weights = vec![0.0; self.turns.len()];
        for ((element, memory), slot) in self.elements.iter().zip(&self.memory).zip(&self.slot) {
            if matches!(memory.branch, Branch::Above | Branch::Below) {
                stiffness += element.slider.stiffness;
                if let Some(slot) = slot {
                    weights[slot - self.first_slot] += element.slider.stiffness;
                }
            }
        }
        let weights = weights.into_iter().enumerate().filter(|(_, weight)| *weight != 0.0);
        (stiffness, weights.map(|(k, weight)| (self.first_slot + k, weight)).collect())
    }
}

/// Disturbances on their way through a period: displacements times `rate`, velocities, remembered displacements times
/// `rate`, so that all are velocities.
struct Walk<'a> {
    system: &'a System,
    rate: f64,
    map: DMatrix<f64>,
    stiffness: Vec<f64>,
    weights: Vec<Vec<(usize, f64)>>,
    budget: Budget,
}

impl Walk<'_> {
    /// `d/dt` of the disturbances in the regime now.
    fn generator(&self) -> DMatrix<f64> {
        let (n, size) = (self.system.size, self.map.nrows());
        let mut out = DMatrix::zeros(size, size);
        let (stiffness, damping) = self.system.matrices();
        for i in 0..n {
            out[(i, n + i)] = self.rate;
            for j in 0..n {
                out[(n + i, j)] = -stiffness[i * n + j] / self.rate;
                out[(n + i, n + j)] = -damping[i * n + j];
            }
        }
        for ((b, stiffness), weights) in self.system.contacts.iter().zip(&self.stiffness).zip(&self.weights) {
            for (i, along) in b.iter().enumerate().filter(|(_, along)| **along != 0.0) {
                for (j, b) in b.iter().enumerate() {
                    out[(n + i, j)] -= along * stiffness * b / self.rate;
                }
                for (slot, weight) in weights {
                    out[(n + i, 2 * n + slot)] += along * weight / self.rate;
                }
            }
        }
        out
    }

    fn advance(&mut self, duration: f64) -> Result<(), OscillatorError> {
        if duration <= 0.0 {
            return Ok(());
        }
        let generator = self.generator() * duration;
        let (size, norm) = (self.map.nrows() as f64, norm(&generator));
        if !norm.is_finite() {
            return Err(OscillatorError::Diverged { time: duration });
        }
        let products = PRODUCTS as f64 + f64::from(squarings(norm)) + 1.0;
        self.budget.spend(products * size.powi(3), duration)?;
        self.map = exponential(generator, norm) * &self.map;
        Ok(())
    }

    fn change(&mut self, change: Change) {
        let n = self.system.size;
        if let Some(slot) = change.remembered {
            let row = DMatrix::from_row_slice(1, n, &self.system.contacts[change.contact]);
            let moved = row * self.map.rows(0, n);
            self.map.row_mut(2 * n + slot).copy_from(&moved.row(0));
        }
        self.stiffness[change.contact] = change.stiffness;
        self.weights[change.contact] = change.weights;
    }
}
