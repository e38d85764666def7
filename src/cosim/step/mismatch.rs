//! Couplings whose power is not known, watched without units: what inputs were given for the ends of steps against what
//! their sources then had.

use super::energy::Place;
use super::signals::Signals;
use super::unit::Unit;
use crate::cosim::system::{Port, System, Unwatched};

/// Fewer steps show nothing.
const SHOWN_AFTER: u32 = 50;

/// Part of a signal's largest value below which it counts as one that rests: far above the tolerance of a repeated step.
const AT_REST: f64 = 1e-4;

/// What was seen of an input at the ends of steps.
#[derive(Debug, Default)]
struct Seen {
    count: u32,
    /// Mean of its source's values, and the sum of squared distances from it.
    mean: f64,
    spread: f64,
    largest: f64,
    /// Sum of the squared differences between the given values and those.
    missed: f64,
}

impl Seen {
    /// Its source had `value` where it was given another.
    fn add(&mut self, value: f64, given: f64) {
        self.count = self.count.saturating_add(1);
        let distance = value - self.mean;
        self.mean += distance / f64::from(self.count);
        self.spread += distance * (value - self.mean);
        self.largest = self.largest.max(value.abs());
        self.missed += (value - given).powi(2);
    }

    /// Root mean square of what was missed, over the standard deviation of the values.
    fn mismatch(&self) -> f64 {
        if self.count < SHOWN_AFTER || self.missed == 0.0 {
            return 0.0;
        }
        let rest = f64::from(self.count) * (AT_REST * self.largest).powi(2);
        (self.missed / (self.spread + rest)).sqrt()
    }
}

/// An input of such a coupling.
#[derive(Debug)]
struct Watched {
    place: Place,
    name: String,
    seen: Seen,
}

/// The couplings of a running system that no power connection watches.
#[derive(Debug, Default)]
pub(in crate::cosim) struct Mismatches {
    couplings: Vec<(Unwatched, Vec<Watched>)>,
}

impl Mismatches {
    /// `place` finds the input at a port.
    pub fn new(system: &System, place: impl Fn(Port) -> Option<Place>) -> Self {
        let watched = |port: &Port| {
            let (place, name) = (place(*port)?, system.full_name(*port));
            Some(Watched { place, name, seen: Seen::default() })
        };
        let couplings = system.unwatched_couplings().into_iter();
        let couplings =
            couplings.map(|(coupling, inputs)| (coupling, inputs.iter().filter_map(watched).collect()));
        Self { couplings: couplings.collect() }
    }

    /// Takes the step tried last as done.
    pub fn accept(&mut self, units: &[Unit], signals: &Signals) {
        let inputs = self.couplings.iter_mut().flat_map(|(_, inputs)| inputs);
        for Watched { place, seen, .. } in inputs {
            let (value, given) = place.ended(units, signals);
            seen.add(value, given);
        }
    }

    /// The couplings, each with the input that was missed by most.
    pub fn found(&self) -> Vec<Unwatched> {
        let found = self.couplings.iter().map(|(coupling, inputs)| {
            let mismatch = |input: &Watched| input.seen.mismatch();
            let worst = inputs.iter().max_by(|one, other| mismatch(one).total_cmp(&mismatch(other)));
            let (input, mismatch) =
                worst.map_or_else(Default::default, |input| (input.name.clone(), mismatch(input)));
            Unwatched { input, mismatch, ..coupling.clone() }
        });
        found.collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mismatch(values: impl Fn(f64) -> (f64, f64)) -> f64 {
        let mut seen = Seen::default();
        (0..200).map(|k| values(f64::from(k))).for_each(|(value, given)| seen.add(value, given));
        seen.mismatch()
    }

    #[test]
    fn what_rests_is_resolved_and_what_is_missed_by_its_own_size_is_not() {
        let rounding = |k: f64| 1e-9 * (7.0 * k).sin();
        assert!(mismatch(|k| (1.65 + rounding(k), 1.65 + rounding(k + 1.0))) < 1e-4);
        assert_eq!(mismatch(|_| (1.0, 1.0)), 0.0);
        // Given too late by a third of a radian.
        let found = mismatch(|k| (k.sin(), (k - 0.33).sin()));
        assert!((found - 2.0 * 0.165_f64.sin()).abs() < 0.01, "{found}");
        assert!(mismatch(|k| (k.sin(), -k.sin())) > 1.9);
    }
}
