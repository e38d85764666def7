//! Coefficients of equal steps: all that moves a linear plant are the forces at its ports.

use super::node::Answer;
use super::plant::{Contact, Plant, add_product};
use super::propagator::{END, MIDDLE, Propagator, Row, weighed};

/// Most sweeps where laws act on each other; each gains two digits or more.
pub(crate) const SWEEPS: usize = 12;
/// Residual of a force in an equal step, relative.
pub(crate) const PRECISION: f64 = 1e-12;
/// Rounds in which the damping between modes settles: each gains two digits or more.
const ROUNDS: usize = 10;

/// Equal steps: their coefficients and the forces in the present one. Pairs are of displacement and velocity at the end.
#[derive(Debug, Clone)]
pub(crate) struct EqualSteps {
    /// Their length (s).
    pub step: f64,
    /// Pairs of each mode, mode by mode, by the `numbers`.
    factors: Vec<[f64; 2]>,
    /// Three forces of each input (N), and `q₀` and `v₀` of the mode itself or, where damping couples modes, of all.
    numbers: Vec<f64>,
    coupled: bool,
    /// Pairs of each mode by the force of each law or outside force where that grows on a straight line, and where it is but a
    /// bow above one: force by force.
    line: Vec<[f64; 2]>,
    bow: Vec<[f64; 2]>,
    /// Pairs of the port of each by the former.
    ports: Vec<[f64; 2]>,
    /// How the port of each answers to its own.
    pub answers: Vec<Answer>,
    /// By how much the force of each law would rise (N) if it went on as it begins.
    pub rises: Vec<f64>,
}

impl EqualSteps {
    /// Of no length yet.
    pub fn new(plant: &Plant) -> Self {
        let coupled = !plant.damping.is_empty() && !plant.follows_displacement();
        let free = if coupled { 2 * plant.size() } else { 2 };
        Self {
            step: f64::NAN,
            factors: Vec::new(),
            numbers: vec![0.0; 3 * plant.inputs() + free],
            coupled,
            line: Vec::new(),
            bow: Vec::new(),
            ports: Vec::new(),
            answers: vec![Answer::NONE; plant.contacts.len()],
            rises: vec![0.0; plant.contacts.len()],
        }
    }

    /// The force of an input (N) along its port at the start, the middle and the end.
    pub fn force(&mut self, input: usize) -> &mut [f64] {
        &mut self.numbers[3 * input..][..3]
    }

    /// Writes `q` and `v` of all modes at the end by those at the start and by the forces, where nothing else acts.
    pub fn end(&mut self, [q0, v0]: [&[f64]; 2], [q, v]: [&mut [f64]; 2]) {
        let n = q0.len();
        let free = self.numbers.len() - if self.coupled { 2 * n } else { 2 };
        if self.coupled {
            self.numbers[free..][..n].copy_from_slice(q0);
            self.numbers[free + n..].copy_from_slice(v0);
        }
        let rows = self.factors.chunks_exact(self.numbers.len());
        for (i, (row, (q, v))) in rows.zip(q.iter_mut().zip(v)).enumerate() {
            if !self.coupled {
                self.numbers[free..].copy_from_slice(&[q0[i], v0[i]]);
            }
            [*q, *v] = weighed(row, &self.numbers);
        }
    }

    /// Moves `q` and `v` of all modes at the end as the force of law or outside force `e` does that grows on a straight line to
    /// be larger by so much (N).
    pub fn shift(&self, e: usize, by: f64, end: [&mut [f64]; 2]) {
        move_by(&self.line, e, by, end);
    }

    /// The same of a force that is as at both ends, and so much (N) above the straight line at the middle.
    pub fn bend(&self, e: usize, by: f64, end: [&mut [f64]; 2]) {
        move_by(&self.bow, e, by, end);
    }

    /// How displacement and velocity of all ports of laws and outside forces move as [`EqualSteps::shift`] moves the modes.
    pub fn shift_of_ports(&self, e: usize) -> &[[f64; 2]] {
        let count = self.answers.len();
        &self.ports[e * count..][..count]
    }

    /// Fills the coefficients from those of this step.
    pub fn fill(&mut self, plant: &Plant, propagator: &Propagator) {
        let (n, columns) = (plant.size(), Columns::new(plant, propagator, self.coupled));
        let driven = plant.driven.iter().map(|port| (*port, 1.0));
        let against = plant.contacts.iter().map(|contact| (contact.port, -1.0));
        let along = |(port, sign): (usize, f64)| plant.ports[port].row.iter().map(|b| sign * b).collect();
        let rows: Vec<Vec<f64>> = driven.chain(against).map(along).collect();
        let own = |i: usize| if self.coupled { 0..n } else { i..i + 1 };
        // Damping between modes is a force, at the start too.
        let lost = |i: usize, j: usize| {
            if self.coupled { columns.sum(i, 2, &plant.damping[j * n..][..n]) } else { [0.0; 2] }
        };
        let factors = |i: usize| {
            let forced = rows.iter().flat_map(|row| [2, 3, 4].map(|list| columns.sum(i, list, row)));
            let displaced = own(i).map(|j| columns.of[j][i]);
            let moving = own(i).map(|j| [0, 1].map(|part| columns.of[n + j][i][part] - lost(i, j)[part]));
            forced.chain(displaced).chain(moving).collect::<Vec<_>>()
        };
        self.factors = (0..n).flat_map(factors).collect();
        let of_laws = || rows[plant.driven.len()..].iter().flat_map(|row| (0..n).map(move |i| (i, row)));
        self.bow = of_laws().map(|(i, row)| columns.sum(i, 3, row)).collect();
        let ends = of_laws().map(|(i, row)| columns.sum(i, 4, row));
        let line = |(middle, end): (&[f64; 2], [f64; 2])| [0, 1].map(|part| 0.5 * middle[part] + end[part]);
        self.line = self.bow.iter().zip(ends).map(line).collect();
        self.fill_ports(plant);
    }

    /// What the ports of laws and outside forces see of their forces, from what the modes do.
    fn fill_ports(&mut self, plant: &Plant) {
        let seen = |line: &[[f64; 2]], contact: &Contact| {
            let terms = line.iter().zip(&plant.ports[contact.port].row);
            terms.fold([0.0; 2], |[u, v], ([by_q, by_v], b)| [u + b * by_q, v + b * by_v])
        };
        let lines = self.line.chunks_exact(plant.size());
        self.ports =
            lines.flat_map(|line| plant.contacts.iter().map(move |contact| seen(line, contact))).collect();
        for (e, answer) in self.answers.iter_mut().enumerate() {
            let [yielding, slowing] = self.ports[e * plant.contacts.len() + e].map(|by| (-by).max(0.0));
            *answer = Answer { yielding, slowing, precision: PRECISION, from: None };
        }
    }
}

/// `q` and `v` of all modes at the end by the unit of what they depend on: lists of `q₀`, `v₀`, `p₀` and the forcing at the middle
/// and at the end, each mode by mode.
struct Columns {
    of: Vec<Vec<[f64; 2]>>,
    modes: usize,
}

impl Columns {
    fn new(plant: &Plant, propagator: &Propagator, coupled: bool) -> Self {
        let column = |column: usize| {
            if coupled { damped(plant, propagator, column) } else { alone(propagator, column) }
        };
        Self { of: (0..5 * plant.size()).map(column).collect(), modes: plant.size() }
    }

    /// The pair of mode `i` by what `by` holds of a list.
    fn sum(&self, i: usize, list: usize, by: &[f64]) -> [f64; 2] {
        let factors = self.of[list * self.modes..][..self.modes].iter().map(|column| column[i]);
        factors.zip(by).fold([0.0; 2], |[q, v], ([by_q, by_v], by)| [q + by_q * by, v + by_v * by])
    }
}

/// Adds `by` times the pairs of force `e` to `q` and `v` of the modes.
#[inline]
fn move_by(pairs: &[[f64; 2]], e: usize, by: f64, [q, v]: [&mut [f64]; 2]) {
    let pairs = &pairs[e * q.len()..];
    for ((q, v), [by_q, by_v]) in q.iter_mut().zip(v.iter_mut()).zip(pairs) {
        *q += by_q * by;
        *v += by_v * by;
    }
}

/// One of [`Columns`] where each mode moves by itself.
fn alone(propagator: &Propagator, column: usize) -> Vec<[f64; 2]> {
    let rows = propagator.node(END);
    let (list, mode) = (column / rows.len(), column % rows.len());
    rows.iter().enumerate().map(|(i, row)| if i == mode { row[list] } else { [0.0; 2] }).collect()
}

/// The same under the damping between modes, of which `p₀` holds the share at the start.
fn damped(plant: &Plant, propagator: &Propagator, column: usize) -> Vec<[f64; 2]> {
    let n = plant.size();
    let mut by: [Vec<f64>; 5] = std::array::from_fn(|_| vec![0.0; n]);
    by[column / n][column % n] = 1.0;
    let forcing = [by[3].clone(), by[4].clone()];
    let mut velocity = [by[1].clone(), by[1].clone()];
    let mut end = Vec::new();
    for _ in 0..ROUNDS {
        for (node, velocity) in velocity.iter().enumerate() {
            let mut lost = vec![0.0; n];
            add_product(&plant.damping, velocity, &mut lost);
            by[3 + node] = forcing[node].iter().zip(lost).map(|(p, lost)| p - lost).collect();
        }
        let at = |(i, row): (usize, &Row)| weighed(row, &by.each_ref().map(|list| list[i]));
        for (velocity, node) in velocity.iter_mut().zip([MIDDLE, END]) {
            end = propagator.node(node).iter().enumerate().map(at).collect();
            *velocity = end.iter().map(|[_, v]| *v).collect();
        }
    }
    end
}

/// How far the middle of a parabola lies above the straight line if it rises by so much less at its end than at its start,
/// over the step.
pub(crate) fn bow(less: f64) -> f64 {
    0.125 * less
}
