//! A law at one node of a step, and how its port answers to it.

use super::contact_point::{ContactPoint, EXACT};
use super::plant::{Plant, add_product};
use super::propagator::{END, MIDDLE, Propagator, Row, weighed};
use crate::contact::{Inputs, Response, SlipState};

/// Most sweeps where laws act on each other; each gains two digits or more.
pub(crate) const SWEEPS: usize = 12;
/// Residual of a force in an equal step, relative.
pub(crate) const PRECISION: f64 = 1e-12;
/// Rounds in which the damping between modes settles: each gains two digits or more.
const ROUNDS: usize = 10;

/// A law or an outside force at one node.
#[derive(Debug, Clone, Copy)]
pub(crate) struct NodeContact {
    pub force: f64,
    pub tangent: f64,
    pub load_tangent: f64,
    pub slip_state: SlipState,
    /// Energy taken since the start of the step (J).
    pub energy: f64,
    pub normal_load: f64,
    /// u (m).
    pub displacement: f64,
    /// u + a T (m) and its derivative (m/s): what the modes alone give.
    pub geometric_displacement: f64,
    pub geometric_velocity: f64,
}

/// How a port answers to a law's unit force against it, by displacement (m/N) and velocity (m/(s N)), and how precisely
/// the force is sought, as [`ContactPoint::precision`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct Answer {
    pub yielding: f64,
    pub slowing: f64,
    pub precision: f64,
}

impl Answer {
    pub const NONE: Self = Self { yielding: 0.0, slowing: 0.0, precision: EXACT };
}

impl NodeContact {
    pub const REST: Self = Self {
        force: 0.0,
        tangent: 0.0,
        load_tangent: 0.0,
        slip_state: SlipState::Stick,
        energy: 0.0,
        normal_load: 0.0,
        displacement: 0.0,
        geometric_displacement: 0.0,
        geometric_velocity: 0.0,
    };

    /// u̇ (m/s) for a normal load that changes at `load_rate` (N/s), `flexibility` a (m/N).
    pub fn velocity(&self, flexibility: f64, load_rate: f64) -> f64 {
        if flexibility == 0.0 {
            return self.geometric_velocity;
        }
        (self.geometric_velocity - flexibility * self.load_tangent * load_rate)
            / (1.0 + flexibility * self.tangent)
    }

    /// What the law is asked, under a normal load (N), behind a flexibility of its port (m/N), where the structure yields
    /// to it and slows down as `answer` tells.
    pub fn point(&self, normal_load: f64, flexibility: f64, answer: Answer) -> ContactPoint {
        ContactPoint {
            displacement: self.geometric_displacement + answer.yielding * self.force,
            velocity: self.geometric_velocity,
            flexibility: flexibility + answer.yielding,
            series: flexibility,
            slowing: answer.slowing,
            tangent: self.tangent,
            normal_load,
            guess: self.force,
            precision: answer.precision,
        }
    }

    pub fn store(&mut self, response: Response, displacement: f64, load: f64) {
        self.force = response.force;
        self.tangent = response.tangents.displacement;
        self.load_tangent = response.tangents.normal_load;
        self.energy = response.dissipated_energy;
        self.slip_state = response.slip_state;
        self.normal_load = load;
        self.displacement = displacement;
    }

    /// What a law takes over at the middle of a step.
    pub fn inputs(&self) -> Inputs {
        Inputs {
            displacement: self.displacement,
            velocity: self.geometric_velocity,
            normal_load: self.normal_load,
        }
    }
}

/// Coefficients of equal steps.
#[derive(Debug, Clone)]
pub(crate) struct EqualSteps {
    /// Their length (s).
    pub step: f64,
    /// Under damping that couples modes: `q`, `v` and `p` of each mode at the end by all modes' `q₀`, `v₀`, `p₀` and forcing
    /// at the middle and at the end. Empty without.
    coupled: Vec<Vec<[f64; 3]>>,
    /// How the ports of laws answer at the end to a force that grows on a straight line.
    pub answers: Vec<Answer>,
    /// `q`, `v` and `p` of the modes at the end by a port's unit force at the middle, and at the end.
    pub pushed: Vec<Vec<[[f64; 2]; 3]>>,
}

impl EqualSteps {
    /// For so many laws and outside forces; of no length yet.
    pub fn new(contacts: usize) -> Self {
        Self {
            step: f64::NAN,
            coupled: Vec::new(),
            answers: vec![Answer::NONE; contacts],
            pushed: vec![Vec::new(); contacts],
        }
    }

    /// Writes `q`, `v` and `p` of all modes at the end by `by`: `q₀`, `v₀`, `p₀` and the forcing at the middle and at the
    /// end; `rows` are the propagator's.
    pub fn end(&self, rows: &[Row], by: [&[f64]; 5], [q, v, p]: [&mut [f64]; 3]) {
        if self.coupled.is_empty() {
            for (i, row) in rows.iter().enumerate() {
                let by = by.map(|list| list[i]);
                ([q[i], v[i]], p[i]) = (weighed(row, by), by[4]);
            }
            return;
        }
        for (((q, v), p), factors) in q.iter_mut().zip(v).zip(p).zip(&self.coupled) {
            let (mut sums, mut factors) = ([-0.0; 3], factors.iter());
            for list in by {
                for (by, factors) in list.iter().zip(&mut factors) {
                    sums.iter_mut().zip(factors).for_each(|(sum, factor)| *sum += factor * by);
                }
            }
            [*q, *v, *p] = sums;
        }
    }

    /// Fills the rest from the coefficients of this step.
    pub fn fill(&mut self, plant: &Plant, propagator: &Propagator) {
        self.coupled.clear();
        let n = plant.size();
        if !plant.damping.is_empty() && !plant.follows_displacement() {
            let columns: Vec<[Vec<f64>; 3]> =
                (0..5 * n).map(|column| damped(plant, propagator, column)).collect();
            let of_mode = |i: usize| columns.iter().map(|[q, v, p]| [q[i], v[i], p[i]]).collect();
            self.coupled.extend((0..n).map(of_mode));
        }
        let zero = vec![0.0; n];
        for (e, contact) in plant.contacts.iter().enumerate() {
            let row = &plant.ports[contact.port].row;
            let [middle, end] = [[row, &zero], [&zero, row]].map(|[middle, end]| {
                let [mut q, mut v, mut p] = [zero.clone(), zero.clone(), zero.clone()];
                let by: [&[f64]; 5] = [&zero, &zero, &zero, middle, end];
                self.end(propagator.node(END), by, [&mut q, &mut v, &mut p]);
                (0..n).map(|i| [q[i], v[i], p[i]]).collect::<Vec<_>>()
            });
            let both = middle.iter().zip(&end).map(|(a, b)| [0, 1, 2].map(|part| [a[part], b[part]]));
            self.pushed[e] = both.collect();
            let terms = |part: usize| {
                let terms = row.iter().zip(&self.pushed[e]);
                terms.map(|(b, by)| b * (0.5 * by[part][0] + by[part][1])).sum::<f64>().max(0.0)
            };
            self.answers[e] = Answer { yielding: terms(0), slowing: terms(1), precision: PRECISION };
        }
    }
}

/// `q`, `v` and `p` at the end by the unit in `column` of what they depend on, the damping between modes included.
fn damped(plant: &Plant, propagator: &Propagator, column: usize) -> [Vec<f64>; 3] {
    let n = plant.size();
    let mut by: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; n]);
    by[column / n][column % n] = 1.0;
    let forcing = [by[3].clone(), by[4].clone()];
    let mut velocity = [by[1].clone(), by[1].clone()];
    let mut end = [vec![0.0; n], vec![0.0; n], forcing[1].clone()];
    for _ in 0..ROUNDS {
        for (node, velocity) in velocity.iter().enumerate() {
            let mut lost = vec![0.0; n];
            add_product(&plant.damping, velocity, &mut lost);
            let left = forcing[node].iter().zip(lost).map(|(p, lost)| p - lost);
            by[3 + node] = left.collect();
        }
        let at = |(i, row): (usize, &Row)| weighed(row, std::array::from_fn::<_, 5, _>(|list| by[list][i]));
        for (velocity, node) in velocity.iter_mut().zip([MIDDLE, END]) {
            (end[0], *velocity) =
                propagator.node(node).iter().enumerate().map(at).map(|[q, v]| (q, v)).unzip();
        }
        (end[1], end[2]) = (velocity[1].clone(), by[4].clone());
    }
    end
}

/// How far the middle of a parabola lies above the straight line if it rises by so much less at its end than at its start,
/// over the step.
pub(crate) fn bow(less: f64) -> f64 {
    0.125 * less
}
