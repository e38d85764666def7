//! Counting outcomes.

use crate::scoring::run::Outcome;
use crate::scoring::score::Score;
use crate::scoring::truth::Class;
use crate::scoring::wilson;

/// Test error over the noise up to which a model counts as improved to the noise.
const NEAR: f64 = 1.15;
/// The noise that was added.
pub const ADDED: fn(&Score) -> Option<f64> = |score| score.test_error_over_noise;
/// The noise floor that the diagnosis reports.
pub const FLOOR: fn(&Score) -> Option<f64> = |score| score.test_error_over_floor;

/// Figures of a set of cases.
pub struct Figures<'a> {
    /// The cases.
    pub outcomes: Vec<&'a Outcome>,
}

impl<'a> Figures<'a> {
    /// Those of `outcomes` that `keep` keeps.
    pub fn of(outcomes: &'a [Outcome], keep: impl Fn(&Outcome) -> bool) -> Self {
        Self { outcomes: outcomes.iter().filter(|outcome| keep(outcome)).collect() }
    }

    /// Those of a class.
    pub fn class(&self, class: Class) -> impl Iterator<Item = &'a Outcome> {
        self.outcomes.iter().copied().filter(move |outcome| outcome.truth.class() == class)
    }

    /// Points and cases of a class.
    pub fn right(&self, class: Class) -> (f64, usize) {
        let points = self.class(class).map(|outcome| outcome.score.right).sum();
        (points, self.class(class).count())
    }

    /// Cases of a class in which something was named that is not there, and cases.
    pub fn named_falsely(&self, class: Class) -> (f64, usize) {
        (
            self.class(class).filter(|outcome| outcome.score.named_falsely).count() as f64,
            self.class(class).count(),
        )
    }

    /// Parameters whose interval holds the true value, and intervals told.
    pub fn coverage(&self) -> (f64, usize) {
        let told = self.outcomes.iter().flat_map(|outcome| &outcome.score.covered);
        told.fold((0.0, 0), |(hits, trials), (_, holds)| (hits + f64::from(*holds), trials + 1))
    }

    /// Errors on test records over the noise that `of` takes, rising.
    pub fn test_errors(&self, of: fn(&Score) -> Option<f64>) -> Vec<f64> {
        let mut ratios: Vec<f64> = self.outcomes.iter().filter_map(|outcome| of(&outcome.score)).collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    }

    /// Those near the noise, and how many there are.
    pub fn test_error_near(&self, of: fn(&Score) -> Option<f64>) -> (f64, usize) {
        let ratios = self.test_errors(of);
        (ratios.iter().filter(|ratio| **ratio <= NEAR).count() as f64, ratios.len())
    }

    /// Seconds, rising.
    pub fn seconds(&self) -> Vec<f64> {
        let mut seconds: Vec<f64> = self.outcomes.iter().map(|outcome| outcome.diagnosis.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        seconds
    }

    /// The columns of a breakdown.
    pub fn row(&self) -> [String; 8] {
        let median = |values: &[f64]| values.get(values.len() / 2).map(|value| format!("{value:.3}"));
        [
            share(self.right(Class::Single)),
            share(self.right(Class::Pair)),
            share(self.named_falsely(Class::Null)),
            share(self.right(Class::Outside)),
            share(self.named_falsely(Class::Outside)),
            share(self.coverage()),
            median(&self.test_errors(ADDED)).unwrap_or_else(|| "–".to_owned()),
            self.seconds()
                .get(self.outcomes.len() / 2)
                .map_or("–".to_owned(), |value| format!("{value:.1}")),
        ]
    }
}

/// A share in percent of how many.
pub fn share((hits, trials): (f64, usize)) -> String {
    if trials == 0 { "–".to_owned() } else { format!("{:.0} % of {trials}", 100.0 * hits / trials as f64) }
}

/// A share with its interval.
pub fn told((hits, trials): (f64, usize)) -> String {
    let (low, high) = wilson::interval(hits, trials);
    let percent = |value: f64| format!("{:.1}", 100.0 * value);
    if trials == 0 {
        return "–".to_owned();
    }
    format!(
        "{} % ({hits} of {trials}; {} … {} %)",
        percent(hits / trials as f64),
        percent(low),
        percent(high)
    )
}

/// Full strength and noise of at most 3 %: what the contract's figures are about.
pub fn is_clear(outcome: &Outcome) -> bool {
    outcome.truth.strength == "full" && outcome.truth.noise <= 0.0301
}
