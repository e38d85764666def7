//! Compliances of a structure at the harmonics of a set, as they act on real coefficients.

use nalgebra::Complex;

use crate::harmonic::HarmonicError;
use crate::harmonic::newton::system::Operating;
use crate::system::{Compliance, Receptance, Rows};

/// Compliances at one harmonic: row-major, a column per contact and one for the excitation.
#[derive(Debug, Clone, Default)]
struct Level {
    order: usize,
    value: Vec<[f64; 2]>,
    by_frequency: Vec<[f64; 2]>,
    by_self_excitation: Vec<[f64; 2]>,
}

/// Compliances at several harmonics.
#[derive(Debug)]
pub(crate) struct Transfer {
    buffer: Compliance,
    rows: Rows,
    columns: usize,
    levels: Vec<Level>,
    /// Ω and ζ of the last evaluation.
    key: Option<(f64, f64)>,
}

/// Which derivative of the compliances.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Of {
    Value,
    ByFrequency,
    BySelfExcitation,
}

impl Transfer {
    pub fn new(receptance: &Receptance, rows: Rows, orders: impl Iterator<Item = usize>) -> Self {
        let buffer = receptance.compliance(rows);
        let count = buffer.value.nrows() * buffer.value.ncols();
        let level = |order| Level {
            order,
            value: vec![[0.0; 2]; count],
            by_frequency: vec![[0.0; 2]; count],
            by_self_excitation: vec![[0.0; 2]; count],
        };
        Self { columns: buffer.value.ncols(), buffer, rows, levels: orders.map(level).collect(), key: None }
    }

    /// Evaluates all harmonics, unless they belong to these numbers already.
    pub fn evaluate(&mut self, receptance: &mut Receptance, at: &Operating) -> Result<(), HarmonicError> {
        let key = (at.angular_frequency, at.self_excitation);
        if self.key == Some(key) {
            return Ok(());
        }
        self.key = None;
        for level in &mut self.levels {
            level.evaluate(receptance, self.rows, at, &mut self.buffer)?;
        }
        self.key = Some(key);
        Ok(())
    }

    /// Replaces the harmonics by `order` alone, and evaluates it.
    pub fn evaluate_one(
        &mut self,
        receptance: &mut Receptance,
        at: &Operating,
        order: usize,
    ) -> Result<(), HarmonicError> {
        if self.levels.iter().any(|level| level.order != order) {
            self.levels.iter_mut().for_each(|level| level.order = order);
            self.key = None;
        }
        self.evaluate(receptance, at)
    }

    /// Number of contacts, and one for the excitation.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Compliance at the `k`-th harmonic.
    pub fn get(&self, k: usize, of: Of, row: usize, column: usize) -> [f64; 2] {
        let level = &self.levels[k];
        let place = row * self.columns + column;
        match of {
            Of::Value => level.value[place],
            Of::ByFrequency => level.by_frequency[place],
            Of::BySelfExcitation => level.by_self_excitation[place],
        }
    }
}

impl Level {
    fn evaluate(
        &mut self,
        receptance: &mut Receptance,
        rows: Rows,
        at: &Operating,
        buffer: &mut Compliance,
    ) -> Result<(), HarmonicError> {
        let (h, speed, zeta) = (self.order as f64, at.angular_frequency, at.self_excitation);
        let damping = Complex::new(0.0, h * speed);
        let inertia = Complex::new(-h * h * speed * speed, -2.0 * zeta * h * speed * speed);
        let inertia_by_frequency = Complex::new(-2.0 * h * h * speed, -4.0 * zeta * h * speed);
        let damping_by_frequency = Complex::new(0.0, h);
        let inertia_by_self_excitation = Complex::new(0.0, -2.0 * h * speed * speed);
        receptance.evaluate(damping, inertia, rows, buffer)?;
        let columns = buffer.value.ncols();
        for i in 0..buffer.value.nrows() {
            for j in 0..columns {
                let (by_damping, by_inertia) = (buffer.by_damping[(i, j)], buffer.by_inertia[(i, j)]);
                let parts = |x: Complex<f64>| [x.re, x.im];
                let place = i * columns + j;
                self.value[place] = parts(buffer.value[(i, j)]);
                self.by_frequency[place] =
                    parts(by_damping * damping_by_frequency + by_inertia * inertia_by_frequency);
                self.by_self_excitation[place] = parts(by_inertia * inertia_by_self_excitation);
            }
        }
        Ok(())
    }
}

/// Adds `factor · compliance · signal` of one harmonic to `target`: with `x = Re[(c − i s) e^{iθ}]` the
/// compliance `a + i b` makes `(a c + b s, a s − b c)` of `(c, s)`. The bias has one coefficient.
pub(crate) fn add_product(compliance: [f64; 2], signal: &[f64], factor: f64, target: &mut [f64]) {
    let [a, b] = compliance.map(|part| factor * part);
    match (signal, target) {
        ([c, s], [x, y]) => {
            *x += a * c + b * s;
            *y += a * s - b * c;
        }
        ([bias], [x]) => *x += a * bias,
        _ => {}
    }
}
