//! The variational equation of piecewise-linear laws: regimes of constant stiffness.

use std::f64::consts::TAU;

use nalgebra::DMatrix;

use super::signal::{evaluate, root, turning_points};
use crate::integrate::oscillator::elements::{Branch, Element, Memory, elements};
use crate::integrate::oscillator::system::{System, dot};
use crate::integrate::{LoadedContact, OscillatorError};

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
    let mut walk = Walk {
        system,
        columns: unit_columns(2 * system.size + used),
        series: system.series(),
        constant: vec![0.0; contacts.len()],
        stiffness,
        weights,
    };
    let mut phase = 0.0;
    for change in changes {
        walk.advance((change.phase - phase) / angular_frequency);
        phase = change.phase;
        walk.change(change);
    }
    walk.advance((TAU - phase) / angular_frequency);
    Ok(as_matrix(&walk.columns))
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

    /// Loads the virgin contact to the displacement of the largest magnitude, from where the motion is
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

    /// Stiffness of the contact now, and the shares of it that hang on remembered displacements.
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

/// Disturbances on their way through a period.
struct Walk<'a> {
    system: &'a System,
    /// Displacement, velocity, remembered displacements.
    columns: Vec<Vec<f64>>,
    series: Vec<f64>,
    constant: Vec<f64>,
    stiffness: Vec<f64>,
    weights: Vec<Vec<(usize, f64)>>,
}

impl Walk<'_> {
    fn advance(&mut self, duration: f64) {
        if duration <= 0.0 {
            return;
        }
        let n = self.system.size;
        let longest = self.system.longest_step(&self.stiffness, 0.0);
        let steps = (duration / longest).ceil().max(1.0);
        for column in &mut self.columns {
            let (moving, memory) = column.split_at_mut(2 * n);
            let (x, v) = moving.split_at_mut(n);
            for (constant, weights) in self.constant.iter_mut().zip(&self.weights) {
                *constant = -weights.iter().map(|(slot, weight)| weight * memory[*slot]).sum::<f64>();
            }
            let h = duration / steps;
            for _ in 0..steps as usize {
                let forces = (self.stiffness.as_slice(), self.constant.as_slice());
                self.system.expand(h, x, v, forces, None, &mut self.series);
                self.system.at(&self.series, h, 1.0, x, v);
            }
        }
    }

    fn change(&mut self, change: Change) {
        let n = self.system.size;
        if let Some(slot) = change.remembered {
            let row = &self.system.contacts[change.contact];
            for column in &mut self.columns {
                column[2 * n + slot] = dot(row, &column[..n]);
            }
        }
        self.stiffness[change.contact] = change.stiffness;
        self.weights[change.contact] = change.weights;
    }
}

/// Disturbances of displacement and velocity as columns of a square matrix with `memory` more rows.
fn unit_columns(size: usize) -> Vec<Vec<f64>> {
    (0..size).map(|k| (0..size).map(|i| if i == k { 1.0 } else { 0.0 }).collect()).collect()
}

fn as_matrix(columns: &[Vec<f64>]) -> DMatrix<f64> {
    DMatrix::from_fn(columns.len(), columns.len(), |i, j| columns[j][i])
}
