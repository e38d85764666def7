//! The significance of a lower sum of squares for few values: Fisher's F-test and Akaike's criterion.

use crate::fit::student_quantile;

/// Sums of squares of a model and of one with more parameters, fitted to the same values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Nested {
    /// Number of values.
    pub values: usize,
    /// Parameters before and after.
    pub parameters: [usize; 2],
    /// Sums of squared residuals before and after.
    pub squares: [f64; 2],
}

impl Nested {
    /// Values less parameters of the larger model.
    pub fn freedom(&self) -> usize {
        self.values.saturating_sub(self.parameters[1])
    }

    /// F: the fall per parameter over what remains per degree of freedom.
    pub fn ratio(&self) -> Option<f64> {
        let added = self.parameters[1].checked_sub(self.parameters[0]).filter(|added| *added > 0)?;
        let rest = self.squares[1] / self.freedom() as f64;
        let ratio = (self.squares[0] - self.squares[1]) / added as f64 / rest;
        (self.freedom() > 0 && ratio.is_finite()).then_some(ratio.max(0.0))
    }

    /// Probability of an F at least as large by chance, for white noise and a step not selected among many; for
    /// one or two parameters more.
    pub fn p_value(&self) -> Option<f64> {
        let (ratio, freedom) = (self.ratio()?, self.freedom());
        match self.parameters[1] - self.parameters[0] {
            1 => Some(outside(ratio.sqrt(), freedom)),
            2 => Some((1.0 + 2.0 * ratio / freedom as f64).powf(-0.5 * freedom as f64)),
            _ => None,
        }
    }

    /// F and AICc in words.
    pub fn words(&self) -> String {
        let mut text = match (self.ratio(), self.p_value()) {
            (Some(ratio), Some(p_value)) => format!(
                "F = {ratio:.1} with {} and {} degrees of freedom: the probability that chance explains the gain is {}, \
                 and higher for the best of several candidates",
                self.parameters[1] - self.parameters[0],
                self.freedom(),
                if p_value < 0.01 { "less than 1 %".to_owned() } else { format!("{:.0} %", 100.0 * p_value) }
            ),
            _ => "Too few values for an F-test".to_owned(),
        };
        match self.criterion() {
            Some(change) if change < 0.0 => {
                text += &format!("; AICc falls by {:.1}, which supports the step", -change)
            }
            Some(change) => text += &format!("; AICc rises by {change:.1}, which does not support the step"),
            None => text += "; too few values for AICc",
        }
        text
    }

    /// Change of Akaike's criterion with the correction for few values (AICc); the variance counts as a
    /// parameter. Negative speaks for the larger model. `None` where the values are too few for it.
    pub fn criterion(&self) -> Option<f64> {
        let of = |which: usize| -> Option<f64> {
            let (n, k) = (self.values as f64, (self.parameters[which] + 1) as f64);
            let left = n - k - 1.0;
            (left > 0.0 && self.squares[which] > 0.0)
                .then(|| n * (self.squares[which] / n).ln() + 2.0 * k + 2.0 * k * (k + 1.0) / left)
        };
        Some(of(1)? - of(0)?)
    }
}

/// Probability that Student's t exceeds `t` in size.
fn outside(t: f64, freedom: usize) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        // A smaller probability outside belongs to a larger value.
        if student_quantile(1.0 - 0.5 * middle, freedom) > t { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn p_values_are_those_of_the_tables_of_f() {
        // F(1, 5) at 5 % is 6.608, F(2, 4) at 5 % is 6.944.
        let one = Nested { values: 8, parameters: [2, 3], squares: [1.0 + 6.608 / 5.0, 1.0] };
        assert!((one.p_value().unwrap() - 0.05).abs() < 1e-4, "{:?}", one.p_value());
        let two = Nested { values: 8, parameters: [2, 4], squares: [1.0 + 2.0 * 6.944 / 4.0, 1.0] };
        assert!((two.p_value().unwrap() - 0.05).abs() < 1e-4, "{:?}", two.p_value());
    }

    #[test]
    fn a_parameter_that_lowers_nothing_worsens_the_criterion_and_has_no_evidence() {
        let idle = Nested { values: 8, parameters: [2, 3], squares: [1.0, 1.0] };
        assert_eq!(idle.ratio(), Some(0.0));
        assert!(idle.p_value().unwrap() > 0.99 && idle.criterion().unwrap() > 0.0);
        let full = Nested { values: 4, parameters: [2, 3], squares: [1.0, 0.5] };
        assert_eq!(full.criterion(), None);
    }
}
