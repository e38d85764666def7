//! Values exchanged between slaves: now, at the end of the step, and extrapolated from the past.

/// All variables that are read, in the order of the units that own them.
#[derive(Debug, Default)]
pub(in crate::cosim) struct Signals {
    /// At the beginning of the step.
    pub now: Vec<f64>,
    /// At its end, as far as slaves have stepped.
    pub next: Vec<f64>,
    /// At its end, as expected at its beginning.
    pub predicted: Vec<f64>,
    /// First and second derivative with respect to time at the beginning, where the slave gives them.
    pub derivatives: [Vec<f64>; 2],
    /// The derivatives have been read.
    pub derived: bool,
    /// Which derivatives the slave gives: 0, 1 or 2.
    pub derivative_order: Vec<u32>,
    /// Real: the others are not continued.
    pub real: Vec<bool>,
    /// At the two communication points before.
    past: [Vec<f64>; 2],
    /// The last two steps (s), the last one first.
    spans: [f64; 2],
    /// How many of them are known.
    known: usize,
    /// First derivatives at the beginning of the step and, as far as slaves have stepped, at its end, of the signals that
    /// inputs follow by them.
    pub slopes: [Vec<f64>; 2],
    /// Those at the beginning of the step before.
    past_slopes: Vec<f64>,
    /// They have been read at the beginning of this step.
    pub sloped: bool,
    /// Largest magnitude so far.
    pub peak: Vec<f64>,
}

impl Signals {
    pub fn new(real: Vec<bool>, derivative_order: Vec<u32>) -> Self {
        let zeros = || vec![0.0; real.len()];
        Self {
            now: zeros(),
            next: zeros(),
            predicted: zeros(),
            derivatives: [zeros(), zeros()],
            derivative_order,
            derived: false,
            past: [zeros(), zeros()],
            spans: [0.0; 2],
            known: 0,
            slopes: [zeros(), zeros()],
            past_slopes: zeros(),
            sloped: false,
            peak: zeros(),
            real,
        }
    }

    /// The initial values.
    pub fn begin(&mut self, values: &[f64]) {
        self.now.copy_from_slice(values);
        self.next.copy_from_slice(values);
        self.known = 0;
        for (peak, value) in self.peak.iter_mut().zip(values) {
            *peak = value.abs();
        }
    }

    /// Expects the values `step` (s) later, by a polynomial of `order` as far as enough is known for it.
    pub fn predict(&mut self, order: u32, step: f64) {
        if order == 0 {
            self.predicted.copy_from_slice(&self.now);
            return;
        }
        for index in 0..self.now.len() {
            self.predicted[index] = self.expected(index, order, step);
        }
    }

    fn expected(&self, index: usize, order: u32, step: f64) -> f64 {
        let now = self.now[index];
        if !self.real[index] {
            return now;
        }
        let given = if self.derived { self.derivative_order[index] } else { 0 };
        let [h1, h2] = self.spans;
        let before = self.past[0][index];
        if given > 0 {
            let first = self.derivatives[0][index];
            let second = match (order, given, self.known) {
                (2.., 2.., _) => self.derivatives[1][index],
                // The parabola through the value before as well.
                (2.., 1, 1..) => 2.0 * (before - now + first * h1) / (h1 * h1),
                _ => 0.0,
            };
            return now + step * (first + 0.5 * step * second);
        }
        if self.known == 0 {
            return now;
        }
        let slope = (now - before) / h1;
        if order == 1 || self.known == 1 {
            return now + step * slope;
        }
        let curvature = (slope - (before - self.past[1][index]) / h2) / (h1 + h2);
        now + step * (slope + (step + h1) * curvature)
    }

    /// The slope at the end of the step of `step` (s), as expected at its beginning.
    pub fn expected_slope(&self, index: usize, step: f64) -> f64 {
        let now = self.slopes[0][index];
        if self.known == 0 { now } else { now + step / self.spans[0] * (now - self.past_slopes[index]) }
    }

    /// Takes a rejected first step for what it tells of the sizes to come: what begins at zero has none.
    pub fn size_up(&mut self) {
        if self.known == 0 {
            for (peak, value) in self.peak.iter_mut().zip(&self.next) {
                *peak = peak.max(value.abs());
            }
        }
    }

    /// Takes the step of length `step` (s) as done.
    pub fn accept(&mut self, step: f64) {
        let [last, before] = &mut self.past;
        std::mem::swap(last, before);
        std::mem::swap(last, &mut self.now);
        self.now.copy_from_slice(&self.next);
        self.spans = [step, self.spans[0]];
        self.known = (self.known + 1).min(2);
        let [begin, end] = &mut self.slopes;
        std::mem::swap(&mut self.past_slopes, begin);
        begin.copy_from_slice(end);
        for (peak, value) in self.peak.iter_mut().zip(&self.now) {
            *peak = peak.max(value.abs());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn after(times: &[f64], value: impl Fn(f64) -> f64, given: u32) -> Signals {
        let mut signals = Signals::new(vec![true], vec![given]);
        signals.begin(&[value(times[0])]);
        for pair in times.windows(2) {
            signals.next[0] = value(pair[1]);
            signals.accept(pair[1] - pair[0]);
        }
        signals
    }

    #[test]
    fn polynomials_are_continued_exactly_over_unequal_steps() {
        let line = |t: f64| 2.0 - 3.0 * t;
        let parabola = |t: f64| 1.0 - 2.0 * t + 0.7 * t * t;
        let mut signals = after(&[0.1, 0.4], line, 0);
        signals.predict(1, 0.7);
        assert!((signals.predicted[0] - line(1.1)).abs() < 1e-14);
        let mut signals = after(&[0.1, 0.4, 0.5], parabola, 0);
        signals.predict(2, 0.7);
        assert!((signals.predicted[0] - parabola(1.2)).abs() < 1e-14);
        let mut signals = after(&[0.1, 0.4], parabola, 1);
        signals.derived = true;
        signals.derivatives[0][0] = -2.0 + 1.4 * 0.4;
        signals.predict(2, 0.7);
        assert!((signals.predicted[0] - parabola(1.1)).abs() < 1e-14);
    }
}
