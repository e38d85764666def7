//! Energy residuals, step by step.

use super::signals::Signals;
use super::unit::{Channel, Unit};
use crate::cosim::system::power::{Ends, EnergyResidual, works};
use crate::cosim::system::{Port, PowerConnection, System};

/// A connected input: its unit and its place among the unit's channels, with what of the channel never changes.
#[derive(Debug, Clone, Copy)]
pub(in crate::cosim) struct Place {
    unit: usize,
    channel: usize,
    source: usize,
    factor: f64,
    offset: f64,
}

impl Place {
    pub fn new((unit, number): (usize, usize), channel: &Channel) -> Self {
        let Channel { source, factor, offset, .. } = *channel;
        Self { unit, channel: number, source, factor, offset }
    }

    /// The value that the input has from its source at the end of the step, and the one that it was given for it.
    pub fn ended(&self, units: &[Unit], signals: &Signals) -> (f64, f64) {
        let value = self.factor * signals.next[self.source] + self.offset;
        (value, units[self.unit].end[self.channel])
    }

    fn ends(&self, units: &[Unit], signals: &Signals, plain: bool) -> Ends {
        Ends {
            given: [signals.now[self.source], signals.next[self.source]],
            taken: units[self.unit].taken(self.channel, plain),
            travel: 0.0,
            factor: self.factor,
        }
    }
}

/// Energy that a coupling adds, over what passes: above, it is unstable. One whose amplitudes are off by a third or more,
/// but bounded, comes close.
const EXPLODED: f64 = 0.5;

#[derive(Debug)]
struct Bond {
    force: Place,
    displacement: Option<Place>,
    velocity: Option<Place>,
    /// Largest power so far (W).
    peak: f64,
}

/// The power connections of a running system.
#[derive(Debug, Default)]
pub(in crate::cosim) struct Energy {
    bonds: Vec<Bond>,
    pub residuals: Vec<EnergyResidual>,
    /// Work of the last step, not yet accepted: residual and exchange (J).
    tried: Vec<[f64; 2]>,
}

impl Energy {
    /// `place` finds the input at a port.
    pub fn new(system: &System, power: &[PowerConnection], place: impl Fn(Port) -> Option<Place>) -> Self {
        let mut energy = Self::default();
        for connection in power {
            let motion = connection.displacement.or(connection.velocity);
            let (Some(force), Some(motion)) = (place(connection.force), motion) else { continue };
            energy.bonds.push(Bond {
                force,
                displacement: connection.displacement.and_then(&place),
                velocity: connection.velocity.and_then(&place),
                peak: 0.0,
            });
            energy.residuals.push(EnergyResidual {
                force: system.full_name(connection.force),
                motion: system.full_name(motion),
                sum: 0.0,
                magnitude: 0.0,
                largest: 0.0,
                exchanged: 0.0,
                last: 0.0,
            });
        }
        energy.tried = vec![[0.0; 2]; energy.bonds.len()];
        energy
    }

    /// Accounts for a step of `step` (s) that is done but not accepted: the largest residual power over the
    /// largest power so far, and which power connection has it.
    pub fn measure(&mut self, units: &[Unit], signals: &Signals, plain: bool, step: f64) -> (f64, usize) {
        let (mut worst, per_second) = ((0.0, 0), 1.0 / step);
        for (index, (bond, tried)) in self.bonds.iter().zip(&mut self.tried).enumerate() {
            let ends = |place: &Place| place.ends(units, signals, plain);
            let displacement = bond.displacement.as_ref().map(|place| {
                let unit = &units[place.unit];
                Ends { travel: unit.end[place.channel] - unit.reached[place.channel], ..ends(place) }
            });
            let [taker, giver] =
                works(ends(&bond.force), displacement, bond.velocity.as_ref().map(ends), step);
            *tried = [giver - taker, taker.abs().max(giver.abs())];
            let (power, residual) = (bond.peak.max(tried[1] * per_second), tried[0].abs() * per_second);
            // Divisions take longer than all the rest.
            if residual > worst.0 * power {
                worst = (residual / power, index);
            }
        }
        worst
    }

    /// A power connection that has itself added more than half of the energy that passed.
    pub fn exploded(&self) -> Option<&EnergyResidual> {
        self.residuals.iter().find(|sums| sums.sum > EXPLODED * sums.exchanged)
    }

    /// Takes the step measured last as done.
    pub fn accept(&mut self, step: f64) {
        let per_second = 1.0 / step;
        for ((bond, [residual, exchanged]), sums) in
            self.bonds.iter_mut().zip(&self.tried).zip(&mut self.residuals)
        {
            bond.peak = bond.peak.max(exchanged * per_second);
            sums.sum += residual;
            sums.magnitude += residual.abs();
            sums.largest = sums.largest.max(residual.abs());
            sums.exchanged += exchanged;
            sums.last = *residual;
        }
    }
}
