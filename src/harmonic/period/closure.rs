//! The state that reproduces itself over a period, by Newton's method on marched periods.

use crate::numeric::elimination::solve_ranked;

/// Where a pivot of `1 − monodromy` (scaled) counts as zero: the memory does not fade.
const UNFADING: f64 = 1e-9;

/// `(1 − M) δ = end − start` for the state at the start of a period and its derivatives, M being the monodromy matrix.
#[derive(Debug, Clone, Default)]
pub(super) struct Closure {
    system: Vec<f64>,
    /// A row for each part of the state: its change, then that of its derivatives by the inputs.
    solution: Vec<f64>,
    pivots: Vec<usize>,
    rank: usize,
    inputs: usize,
}

/// States at the start and at the end of a marched period, with their derivatives: a row for each part, by the inputs
/// and then by the state at the start.
pub(super) struct Marched<'a> {
    pub start: &'a [f64],
    pub end: &'a [f64],
    pub start_sensitivity: &'a [f64],
    pub end_sensitivity: &'a [f64],
}

impl Closure {
    /// Solves for the changes, measured by `scale`, the sizes of the state's parts over the period, of which zeros become
    /// one. Returns the largest change of the state in these sizes.
    pub fn solve(&mut self, marched: &Marched, inputs: usize, scale: &mut [f64]) -> f64 {
        let n = scale.len();
        let (columns, right) = (inputs + n, inputs + 1);
        let width = n + right;
        self.inputs = inputs;
        self.system.resize(n * width, 0.0);
        self.solution.resize(n * right, 0.0);
        self.pivots.resize(n, 0);
        for scale in scale.iter_mut().filter(|scale| **scale == 0.0) {
            *scale = 1.0;
        }
        for i in 0..n {
            let begin = &marched.start_sensitivity[i * columns..(i + 1) * columns];
            let end = &marched.end_sensitivity[i * columns..(i + 1) * columns];
            let row = &mut self.system[i * width..(i + 1) * width];
            for k in 0..n {
                let identity = f64::from(u8::from(i == k));
                row[k] = identity - end[inputs + k] * scale[k] / scale[i];
            }
            row[n] = (marched.end[i] - marched.start[i]) / scale[i];
            for m in 0..inputs {
                row[n + 1 + m] = (end[m] - begin[m]) / scale[i];
            }
        }
        self.hold_conserved(n, width);
        self.rank = solve_ranked(&mut self.system, &mut self.pivots, right, UNFADING, &mut self.solution);
        let changes = self.solution.chunks_exact(right).map(|row| row[0].abs());
        let largest = changes.fold(0.0, f64::max);
        for (row, scale) in self.solution.chunks_exact_mut(right).zip(scale) {
            row.iter_mut().for_each(|x| *x *= *scale);
        }
        largest
    }

    /// Takes the memory that a period leaves exactly as it was out of the linear system: what a stuck slider or an
    /// unstressed length remembers is kept, not traded against the rest of the state, which elimination by the largest
    /// pivot would be free to do.
    fn hold_conserved(&mut self, n: usize, width: usize) {
        for i in 0..n {
            if self.system[i * width..i * width + n].iter().all(|x| x.abs() <= UNFADING) {
                self.system[i * width..(i + 1) * width].fill(0.0);
                (0..n).for_each(|k| self.system[k * width + i] = 0.0);
            }
        }
    }

    /// Whether a part of the state is found, and not left as it is because it does not fade.
    pub fn is_found(&self, part: usize) -> bool {
        self.pivots[..self.rank].contains(&part)
    }

    /// Changes of the state's parts, each with those of its derivatives by the inputs.
    pub fn changes(&self) -> std::slice::ChunksExact<'_, f64> {
        self.solution.chunks_exact(self.inputs + 1)
    }

    /// Largest change to first order of forces whose derivatives by the state at the start are given; NaN where there is
    /// one.
    pub fn force_change<'f>(&self, by_start: impl Iterator<Item = &'f [f64]>) -> f64 {
        let mut largest = 0.0_f64;
        for row in by_start {
            let change: f64 = row.iter().zip(self.changes()).map(|(d, change)| d * change[0]).sum();
            // `max` would drop a NaN.
            if change.is_nan() {
                return f64::NAN;
            }
            largest = largest.max(change.abs());
        }
        largest
    }

    /// Newton's step on the state at the start and, with `derivatives`, on its sensitivity.
    pub fn correct(&self, start: &mut [f64], sensitivity: &mut [f64], derivatives: bool) {
        let columns = self.inputs + start.len();
        for (i, changes) in self.changes().enumerate() {
            start[i] += changes[0];
            if derivatives {
                let row = &mut sensitivity[i * columns..];
                row.iter_mut().zip(&changes[1..]).for_each(|(s, d)| *s += d);
            }
        }
    }
}

/// Adds `weight` times `source` to `target`.
pub(super) fn add_scaled(target: &mut [f64], weight: f64, source: &[f64]) {
    if weight != 0.0 {
        target.iter_mut().zip(source).for_each(|(t, s)| *t += weight * s);
    }
}
