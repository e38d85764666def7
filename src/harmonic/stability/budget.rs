//! How much may be computed for one point of a curve.

use crate::time::OscillatorError;

/// Multiplications, of which a processor does one to five thousand million a second. Counted rather than timed: the
/// same point has the same answer on every machine, whatever else it does.
#[derive(Debug, Clone, Copy)]
pub(super) struct Budget {
    left: f64,
}

impl Budget {
    /// As much as can be waited for at each of many points: half a second or so.
    pub fn of_a_point() -> Self {
        Self { left: 7e8 }
    }

    /// For those who ask for one motion and wait.
    pub fn unlimited() -> Self {
        Self { left: f64::INFINITY }
    }

    /// Whether there is so much left, asked before a stretch that ends at `time` (s).
    pub fn allow(&self, multiplications: f64, time: f64) -> Result<(), OscillatorError> {
        if multiplications <= self.left {
            return Ok(());
        }
        Err(OscillatorError::TooManySteps { limit: self.left.max(0.0) as usize, time })
    }

    /// Takes so much, if it is left.
    pub fn spend(&mut self, multiplications: f64, time: f64) -> Result<(), OscillatorError> {
        self.allow(multiplications, time)?;
        self.left -= multiplications;
        Ok(())
    }
}
