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
    /// Pairs of each mode by the `q₀` and `v₀` of itself or, where damping couples modes, of all, mode by mode. Empty where forces
    /// follow displacements.
    free: Vec<[[f64; 2]; 2]>,
    coupled: bool,
    /// Pairs of each mode by the force of an input at the start, the middle and the end, input by input. Empty as the former.
    forced: Vec<[[f64; 2]; 3]>,
    /// Those forces (N), in the direction of an input: laws and outside forces act against their ports.
    pub forces: Vec<[f64; 3]>,
    /// Pairs of each mode by the force of each law or outside force that grows on a straight line by so much at the end, and that
    /// lies above one by so much at the middle: force by force.
    line: Vec<[f64; 2]>,
    bow: Vec<[f64; 2]>,
    /// Pairs of the ports of all laws and outside forces by the force of each that grows on a straight line: force by force.
    ports: Vec<[f64; 2]>,
    /// How the port of each answers to its own.
    pub answers: Vec<Answer>,
    /// By how much the force of each law would rise (N) if it went on as it begins.
    pub rises: Vec<f64>,
}

impl EqualSteps {
    /// Of no length yet.
    pub fn new(plant: &Plant) -> Self {
        Self {
            step: f64::NAN,
            free: Vec::new(),
            coupled: !plant.damping.is_empty() && !plant.follows_displacement(),
            forced: Vec::new(),
            forces: vec![[0.0; 3]; plant.inputs()],
            line: Vec::new(),
            bow: Vec::new(),
            ports: Vec::new(),
            answers: vec![Answer::NONE; plant.contacts.len()],
            rises: vec![0.0; plant.contacts.len()],
        }
    }

    /// Writes `q` and `v` of all modes at the end by those at the start and by the forces, where nothing else acts.
    pub fn end(&self, [q0, v0]: [&[f64]; 2], [q, v]: [&mut [f64]; 2]) {
        let n = q0.len();
        for (i, (q, v)) in q.iter_mut().zip(v.iter_mut()).enumerate() {
            let own = if self.coupled { 0..n } else { i..i + 1 };
            let mut sum = [0.0; 2];
            for (by, (q0, v0)) in self.free[i * own.len()..].iter().zip(q0[own.clone()].iter().zip(&v0[own]))
            {
                sum = [0, 1].map(|part| sum[part] + by[0][part] * q0 + by[1][part] * v0);
            }
            [*q, *v] = sum;
        }
        for (input, forces) in self.forces.iter().enumerate() {
            // Of many inputs most are not used.
            if *forces == [0.0; 3] {
                continue;
            }
            for ((q, v), by) in q.iter_mut().zip(v.iter_mut()).zip(&self.forced[input * n..][..n]) {
                let [by_q, by_v] = weighed(by, forces);
                *q += by_q;
                *v += by_v;
            }
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
        let columns = Columns::new(plant, propagator, self.coupled);
        (self.free, self.forced) = (Vec::new(), Vec::new());
        if !plant.follows_displacement() {
            self.free = (0..plant.size()).flat_map(|i| columns.free(plant, i)).collect();
            for port in &plant.driven {
                self.forced.extend(columns.forced(&plant.ports[*port].row, 1.0));
            }
        }
        (self.line, self.bow) = (Vec::new(), Vec::new());
        for contact in &plant.contacts {
            let own = columns.forced(&plant.ports[contact.port].row, -1.0);
            self.bow.extend(own.iter().map(|[_, middle, _]| middle));
            let line = |[_, middle, end]: &[[f64; 2]; 3]| [0, 1].map(|part| 0.5 * middle[part] + end[part]);
            self.line.extend(own.iter().map(line));
            if !plant.follows_displacement() {
                self.forced.extend(own);
            }
        }
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

/// `q` and `v` of all modes at the end by the unit of what they depend on: `q₀`, `v₀`, `p₀` and the forcing at the middle and at the
/// end.
enum Columns<'a> {
    /// Of each mode by its own.
    Own(&'a [Row]),
    /// By those of all modes, list by list and mode by mode.
    All(Vec<Vec<[f64; 2]>>),
}

impl<'a> Columns<'a> {
    fn new(plant: &Plant, propagator: &'a Propagator, coupled: bool) -> Self {
        if coupled {
            Self::All((0..5 * plant.size()).map(|column| damped(plant, propagator, column)).collect())
        } else {
            Self::Own(propagator.node(END))
        }
    }

    /// Pairs of mode `i` by `q₀` and `v₀`.
    fn free(&self, plant: &Plant, i: usize) -> Vec<[[f64; 2]; 2]> {
        let all = match self {
            Self::Own(rows) => return vec![[rows[i][0], rows[i][1]]],
            Self::All(all) => all,
        };
        let n = plant.size();
        let by = |j: usize| {
            // Damping between modes is a force, at the start too.
            let [lost_q, lost_v] = sum(&all[2 * n..3 * n], i, &plant.damping[j * n..][..n]);
            let [q, v] = all[n + j][i];
            [all[j][i], [q - lost_q, v - lost_v]]
        };
        (0..n).map(by).collect()
    }

    /// Pairs of all modes by a force along a port or against it, of `sign`, at the start, the middle and the end.
    fn forced(&self, port: &[f64], sign: f64) -> Vec<[[f64; 2]; 3]> {
        let n = port.len();
        let of = |i: usize| match self {
            Self::Own(rows) => [2, 3, 4].map(|list| rows[i][list].map(|by| sign * port[i] * by)),
            Self::All(all) => [2, 3, 4].map(|list| sum(&all[list * n..][..n], i, port).map(|by| sign * by)),
        };
        (0..n).map(of).collect()
    }
}

/// The pair of mode `i` by all of `columns`, so much of each.
fn sum(columns: &[Vec<[f64; 2]>], i: usize, by: &[f64]) -> [f64; 2] {
    let terms = columns.iter().zip(by);
    terms.fold([0.0; 2], |[q, v], (column, by)| [q + column[i][0] * by, v + column[i][1] * by])
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

/// One of [`Columns::All`]: damping between modes is a force, of which `p₀` holds the share at the start.
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
