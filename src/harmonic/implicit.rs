//! The force behind a series spring, one step at a time.

const MAX_STEP_ITERATIONS: usize = 80;

/// Safeguarded Newton iteration for `T = law(u − a T)`: the residual `T − law` grows with `T`, hence
/// its sign brackets the root.
pub(crate) struct Implicit {
    /// The force to try next.
    pub force: f64,
    low: f64,
    high: f64,
    iterations: usize,
}

impl Implicit {
    pub fn new(force: f64) -> Self {
        Self { force, low: f64::NEG_INFINITY, high: f64::INFINITY, iterations: 0 }
    }

    /// Takes the law's answer at the current force; true when it is good enough.
    pub fn accept(&mut self, answer: f64, gradient: f64, compliance: f64, tolerance: f64) -> bool {
        let defect = self.force - answer;
        self.iterations += 1;
        if compliance == 0.0 || defect.abs() <= tolerance || self.iterations > MAX_STEP_ITERATIONS {
            return true;
        }
        if defect.is_nan() {
            return true; // The caller sees the NaN in the force and starts again elsewhere.
        }
        if defect > 0.0 {
            self.high = self.force;
        } else {
            self.low = self.force;
        }
        let newton = self.force - defect / gradient;
        self.force = if newton > self.low && newton < self.high {
            newton
        } else if self.low.is_finite() && self.high.is_finite() {
            0.5 * (self.low + self.high)
        } else {
            answer
        };
        false
    }
}
