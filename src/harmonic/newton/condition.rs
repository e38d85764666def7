//! Conditions that stand beside the balance: a held response, a phase, a value, a place along a curve.

use super::problem::{Condition, ConditionRow, Seen};
use super::system::{Operating, PeriodicSystem, Scalar};

/// `|(i k Ω)^d X_k| = amplitude` for harmonic `k` of an output: displacement (d = 0), velocity (1) or
/// acceleration (2) held, as a controlled shaker does.
#[derive(Debug, Clone)]
pub(crate) struct HeldAmplitude {
    /// Which output.
    pub node: usize,
    /// k; 0 holds the bias (with d = 0).
    pub order: usize,
    /// d.
    pub derivative: usize,
    /// Amplitude held (m/s^d), positive.
    pub amplitude: f64,
}

impl HeldAmplitude {
    /// The condition with its buffers.
    pub fn new(node: usize, order: usize, derivative: usize, amplitude: f64) -> Self {
        Self { node, order, derivative, amplitude }
    }
}

impl Condition for HeldAmplitude {
    /// Half of `(a/amplitude)² − 1`, which is smooth where the response vanishes.
    fn evaluate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        _x: &[f64],
        at: &Operating,
        row: &mut ConditionRow,
    ) -> f64 {
        let value = system.output(self.node, self.order);
        let speed = self.order as f64 * at.angular_frequency;
        let factor = (speed.powi(self.derivative as i32) / self.amplitude).powi(2);
        let parts = if self.order == 0 { 1 } else { 2 };
        let squares: f64 = value[..parts].iter().map(|value| factor * value * value).sum();
        let mut weights = [0.0; 2];
        weights.iter_mut().zip(&value[..parts]).for_each(|(weight, value)| *weight = factor * value);
        row.seen.push(Seen { node: self.node, order: self.order, weights });
        row.by_scalars[Scalar::AngularFrequency.index()] +=
            self.derivative as f64 * squares / at.angular_frequency;
        0.5 * (squares - 1.0)
    }
}

/// Two harmonics of an output keep the ratio of two amplitudes: what remains of both being held where they may grow together.
#[derive(Debug, Clone)]
pub(crate) struct HeldRatio {
    /// Which output.
    pub node: usize,
    /// Which harmonics, at least 1.
    pub orders: [usize; 2],
    /// Their displacements (m) stand to each other as these.
    pub amplitudes: [f64; 2],
}

impl Condition for HeldRatio {
    /// The logarithm of the ratio over that of the amplitudes.
    fn evaluate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        _x: &[f64],
        _at: &Operating,
        row: &mut ConditionRow,
    ) -> f64 {
        let mut logarithms = [0.0; 2];
        for (k, sign) in [-1.0, 1.0].into_iter().enumerate() {
            let value = system.output(self.node, self.orders[k]);
            let square: f64 = value.iter().map(|part| part * part).sum();
            logarithms[k] = 0.5 * (square / self.amplitudes[k].powi(2)).ln();
            let weights = value.map(|part| sign * part / square);
            row.seen.push(Seen { node: self.node, order: self.orders[k], weights });
        }
        logarithms[1] - logarithms[0]
    }
}

/// Harmonic `order` of an output's displacement is `lag` (rad) behind that of the excitation.
///
/// A quarter period is phase resonance. The sine of the difference is made zero: half a period more would
/// do as well, and the start decides.
#[derive(Debug, Clone)]
pub(crate) struct Phase {
    /// Which output.
    pub node: usize,
    /// Which harmonic, at least 1.
    pub order: usize,
    /// Direction wanted: cosine and sine part of a unit vector.
    direction: [f64; 2],
}

impl Phase {
    /// Quarter period behind the excitation's coefficients `[cosine, sine]` of that harmonic.
    pub fn quarter(node: usize, order: usize, excitation: [f64; 2]) -> Self {
        Self::behind(node, order, excitation, std::f64::consts::FRAC_PI_2)
    }

    /// `lag` (rad) behind the excitation's coefficients `[cosine, sine]` of that harmonic.
    pub fn behind(node: usize, order: usize, excitation: [f64; 2], lag: f64) -> Self {
        let size = excitation[0].hypot(excitation[1]);
        let (sin, cos) = lag.sin_cos();
        let [c, s] = excitation.map(|part| if size > 0.0 { part / size } else { 0.0 });
        let direction = [c * cos - s * sin, c * sin + s * cos];
        Self { node, order, direction }
    }
}

impl Condition for Phase {
    fn evaluate(
        &mut self,
        system: &mut dyn PeriodicSystem,
        _x: &[f64],
        _at: &Operating,
        row: &mut ConditionRow,
    ) -> f64 {
        let [c, s] = system.output(self.node, self.order);
        let size = c.hypot(s);
        if size == 0.0 {
            return 1.0;
        }
        let across = (c * self.direction[1] - s * self.direction[0]) / size;
        let weights =
            [(self.direction[1] - across * c / size) / size, (-self.direction[0] - across * s / size) / size];
        row.seen.push(Seen { node: self.node, order: self.order, weights });
        across
    }
}

/// A scalar has a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Value {
    /// Which.
    pub scalar: Scalar,
    /// Its value.
    pub value: f64,
}

impl Condition for Value {
    fn evaluate(
        &mut self,
        _system: &mut dyn PeriodicSystem,
        _x: &[f64],
        at: &Operating,
        row: &mut ConditionRow,
    ) -> f64 {
        let size = if self.value == 0.0 { 1.0 } else { self.value.abs() };
        row.by_scalars[self.scalar.index()] = 1.0 / size;
        (at.get(self.scalar) - self.value) / size
    }
}

/// A place along a curve: `unknowns · x + scalars · (the scalars) = target`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct ArcLength {
    /// Weights of the unknowns.
    pub unknowns: Vec<f64>,
    /// Weights of the scalars.
    pub scalars: [f64; 4],
    /// Where.
    pub target: f64,
}

impl ArcLength {
    /// The left side at `x` and `at`.
    pub fn at(&self, x: &[f64], at: &Operating) -> f64 {
        let unknowns: f64 = self.unknowns.iter().zip(x).map(|(w, x)| w * x).sum();
        let scalars: f64 = self.scalars.iter().zip(at.scalars()).map(|(w, s)| w * s).sum();
        unknowns + scalars
    }
}

impl Condition for ArcLength {
    fn evaluate(
        &mut self,
        _system: &mut dyn PeriodicSystem,
        x: &[f64],
        at: &Operating,
        row: &mut ConditionRow,
    ) -> f64 {
        row.by_unknowns.copy_from_slice(&self.unknowns);
        row.by_scalars = self.scalars;
        self.at(x, at) - self.target
    }
}
