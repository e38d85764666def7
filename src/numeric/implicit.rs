//! The force behind a series spring, one step at a time.

const MAX_STEP_ITERATIONS: usize = 80;

/// Safeguarded Newton iteration for `T = law(u − a T)`: the residual `T − law` grows with `T`, hence
/// its sign brackets the root.
pub(crate) struct Implicit {
    /// The force to try next.
    pub force: f64,
    low: f64,
    high: f64,
    last_defect: f64,
    iterations: usize,
}

impl Implicit {
    pub fn new(force: f64) -> Self {
        Self { force, low: f64::NEG_INFINITY, high: f64::INFINITY, last_defect: f64::INFINITY, iterations: 0 }
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
        let bracketed = self.low.is_finite() && self.high.is_finite();
        // Newton's steps may go back and forth between a steep and a flat branch and hardly approach the root.
        let slow = bracketed && defect.abs() > 0.5 * self.last_defect.abs();
        self.last_defect = defect;
        self.force = if newton > self.low && newton < self.high && !slow {
            newton
        } else if bracketed {
            0.5 * (self.low + self.high)
        } else {
            answer
        };
        false
    }
}

#[cfg(test)]
mod tests {
    use super::Implicit;

    #[test]
    fn a_kink_between_a_steep_and_a_flat_branch_is_solved() {
        // T = law(u − T) with a law that saturates within a short way of a reversal: Newton's steps from either
        // side land on the other.
        for stiffness in [0.5, 3.0, 10.0, 1e3] {
            for total in [-1.0, 0.1, 1.0, 2.7, 30.0] {
                let law = |u: f64| (stiffness * u).tanh();
                let mut implicit = Implicit::new(-1.0);
                let mut rounds = 0;
                loop {
                    let answer = law(total - implicit.force);
                    let slope = stiffness * (1.0 - answer * answer);
                    rounds += 1;
                    if implicit.accept(answer, 1.0 + slope, 1.0, 1e-13) {
                        break;
                    }
                }
                assert!((implicit.force - law(total - implicit.force)).abs() < 1e-13);
                assert!(rounds < 60, "{stiffness} {total}: {rounds}");
            }
        }
    }
}
