//! Couplings whose power is not known, watched without units: what inputs were given for the ends of steps against what
//! their sources then had.

use super::energy::Place;
use super::signals::Signals;
use super::unit::Unit;
use crate::cosim::system::{Port, System, Unwatched};

/// Fewer steps show nothing.
const SHOWN_AFTER: u32 = 50;

/// An input of such a coupling.
#[derive(Debug)]
struct Watched {
    place: Place,
    name: String,
    /// Of the values at the ends of steps: how many, their mean, the sum of squared distances from it.
    count: u32,
    mean: f64,
    spread: f64,
    /// Sum of the squared differences between the given values and those.
    missed: f64,
}

impl Watched {
    fn accept(&mut self, units: &[Unit], signals: &Signals) {
        let (value, given) = self.place.ended(units, signals);
        self.count = self.count.saturating_add(1);
        let distance = value - self.mean;
        self.mean += distance / f64::from(self.count);
        self.spread += distance * (value - self.mean);
        self.missed += (value - given).powi(2);
    }

    /// Root mean square of what was missed, over the standard deviation of the values.
    fn mismatch(&self) -> f64 {
        if self.count < SHOWN_AFTER || self.missed == 0.0 { 0.0 } else { (self.missed / self.spread).sqrt() }
    }
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
            Some(Watched { place, name, count: 0, mean: 0.0, spread: 0.0, missed: 0.0 })
        };
        let couplings = system.unwatched_couplings().into_iter();
        let couplings =
            couplings.map(|(coupling, inputs)| (coupling, inputs.iter().filter_map(watched).collect()));
        Self { couplings: couplings.collect() }
    }

    /// Takes the step tried last as done.
    pub fn accept(&mut self, units: &[Unit], signals: &Signals) {
        let inputs = self.couplings.iter_mut().flat_map(|(_, inputs)| inputs);
        inputs.for_each(|input| input.accept(units, signals));
    }

    /// The couplings, each with the input that was missed by most.
    pub fn found(&self) -> Vec<Unwatched> {
        let found = self.couplings.iter().map(|(coupling, inputs)| {
            let worst = inputs.iter().max_by(|one, other| one.mismatch().total_cmp(&other.mismatch()));
            let (input, mismatch) =
                worst.map_or_else(Default::default, |input| (input.name.clone(), input.mismatch()));
            Unwatched { input, mismatch, ..coupling.clone() }
        });
        found.collect()
    }
}
