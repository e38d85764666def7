//! Energy residuals, step by step.

use super::power::{Ends, EnergyResidual, PowerConnection, works};
use super::signals::Signals;
use super::system::{Port, System};
use super::unit::Unit;

/// A connected input: its unit and its place among the unit's channels.
type Place = (usize, usize);

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
pub(super) struct Energy {
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
        let mut worst = (0.0_f64, 0);
        for (index, (bond, tried)) in self.bonds.iter().zip(&mut self.tried).enumerate() {
            let ends = |(unit, channel): Place| {
                let unit: &Unit = &units[unit];
                let source = unit.channels[channel].source;
                Ends {
                    given: [signals.now[source], signals.next[source]],
                    taken: unit.taken(channel, plain),
                    travel: unit.end[channel] - unit.reached[channel],
                    factor: unit.channels[channel].factor,
                }
            };
            let [taker, giver] =
                works(ends(bond.force), bond.displacement.map(ends), bond.velocity.map(ends), step);
            *tried = [giver - taker, taker.abs().max(giver.abs())];
            let power = bond.peak.max(tried[1] / step);
            let residual = tried[0].abs() / step / power;
            if power > 0.0 && residual > worst.0 {
                worst = (residual, index);
            }
        }
        worst
    }

    /// Takes the step measured last as done.
    pub fn accept(&mut self, step: f64) {
        for ((bond, [residual, exchanged]), sums) in
            self.bonds.iter_mut().zip(&self.tried).zip(&mut self.residuals)
        {
            bond.peak = bond.peak.max(exchanged / step);
            sums.sum += residual;
            sums.magnitude += residual.abs();
            sums.largest = sums.largest.max(residual.abs());
            sums.exchanged += exchanged;
            sums.last = *residual;
        }
    }
}
