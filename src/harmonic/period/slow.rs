//! Where a state ends that is carried over a period again and again, and forgets slowly along one direction.
//!
//! A law that slips gradually has one number that forgets, in small motions, by nearly the same factor in every period. Where
//! two changes point the same way, the place at which they would vanish is foretold (the secant method, Aitken's extrapolation
//! where no place was left out). Where the change hardly differs from period to period, a longer step tells how it does.

/// Part of a change that may point elsewhere than the one before for its end to be foretold.
const ASTRAY: f64 = 0.1;
/// Least part by which a change differs from the one before, so that the difference is no rounding; and the step that is taken
/// instead, as a part of the size.
const TOLD: f64 = 1e-6;
const STEP: f64 = 0.1;

/// The last period: the state at its begin, and its change.
#[derive(Debug, Default)]
pub(super) struct SlowEnd {
    before: Option<(Vec<f64>, Vec<f64>)>,
    /// Whether a place was foretold since, so that the period after it did not go on where the one before ended.
    leapt: bool,
}

impl SlowEnd {
    /// Takes the period that led from `begin` to `state`, and puts `state` ahead where it can tell where that leads. Numbers
    /// count in units of `sizes`; those of size zero do not.
    pub fn look_ahead(&mut self, begin: &[f64], state: &mut [f64], sizes: &[f64]) {
        let change: Vec<f64> = state.iter().zip(begin).map(|(end, begin)| end - begin).collect();
        let ahead = self.before.as_ref().and_then(|before| self.ahead(before, (begin, &change), sizes));
        self.leapt = ahead.is_some();
        if let Some(ahead) = ahead {
            state.iter_mut().zip(begin).zip(&change).for_each(|((to, from), by)| *to = from + ahead * by);
        }
        self.before = Some((begin.to_vec(), change));
    }

    /// How many of this period's changes it is from its begin to where they vanish.
    fn ahead(
        &self,
        (begin_before, before): &(Vec<f64>, Vec<f64>),
        (begin, change): (&[f64], &[f64]),
        sizes: &[f64],
    ) -> Option<f64> {
        let weigh = |a: &[f64], b: &[f64]| -> f64 {
            let terms = a.iter().zip(b).zip(sizes).filter(|(_, size)| **size > 0.0);
            terms.map(|((a, b), size)| a / size * (b / size)).sum()
        };
        let square = weigh(before, before);
        let own = weigh(change, change);
        if square == 0.0 || own == 0.0 {
            return None;
        }
        let factor = weigh(change, before) / square;
        let astray: Vec<f64> = change.iter().zip(before).map(|(x, b)| x - factor * b).collect();
        if weigh(&astray, &astray) > ASTRAY * ASTRAY * own || (factor < 0.0 && !self.leapt) {
            return None;
        }
        let way: Vec<f64> = begin.iter().zip(begin_before).map(|(to, from)| to - from).collect();
        let way = weigh(&way, before) / square;
        // The change falls by `1 − factor` over so many changes.
        let rest = way / (1.0 - factor);
        let told = (1.0 - factor).abs() > TOLD && rest > 0.0;
        Some(if told { rest } else { STEP / own.sqrt() })
    }
}
