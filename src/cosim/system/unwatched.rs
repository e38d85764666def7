//! Couplings of two slaves between which no power connection is known, so that no energy residual shows that they explode.

use std::collections::BTreeSet;

use super::{Port, System};
use crate::cosim::slave::Kind;

/// The values that two slaves exchange are not resolved where inputs miss them by more than this part of their size.
const UNRESOLVED: f64 = 0.5;

/// Two slaves that feed each other, between which no power connection is known.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unwatched {
    /// Their names.
    pub slaves: [String; 2],
    /// All of their connected inputs have units, which do not tell one force and one motion.
    pub units: bool,
    /// Of the inputs of the two, as `slave.variable`, that which was given values for the ends of steps that missed those
    /// its source then had by most.
    pub input: String,
    /// Root mean square of that, over the standard deviation of those values; 0 before a number of steps.
    pub mismatch: f64,
}

impl Unwatched {
    /// Whether the steps are too long for the values that are exchanged.
    pub fn is_unresolved(&self) -> bool {
        self.mismatch > UNRESOLVED
    }
}

impl System {
    /// The couplings of two slaves without a power connection, each with its Real inputs.
    pub(in crate::cosim) fn unwatched_couplings(&self) -> Vec<(Unwatched, Vec<Port>)> {
        let power = self.power_connections();
        let watched = |pair: [usize; 2]| {
            let motion = |port: Option<Port>| port.is_some_and(|port| pair.contains(&port.slave));
            power.iter().any(|one| {
                pair.contains(&one.force.slave) && (motion(one.displacement) || motion(one.velocity))
            })
        };
        let joined = self.connections.iter().map(|connection| {
            let [one, other] = [connection.from.slave, connection.to.slave];
            [one.min(other), one.max(other)]
        });
        let pairs: BTreeSet<[usize; 2]> = joined.filter(|[one, other]| one != other).collect();
        let pairs = pairs.into_iter().filter(|pair| !watched(*pair));
        pairs.filter_map(|pair| self.coupling(pair)).collect()
    }

    /// The two slaves with what they give each other, if both do.
    fn coupling(&self, [one, other]: [usize; 2]) -> Option<(Unwatched, Vec<Port>)> {
        let inputs = |from: usize, to: usize| {
            let between = self.connections.iter().filter(move |connection| {
                let ends = [connection.from, connection.to].map(|port| self.variable(port).kind);
                (connection.from.slave, connection.to.slave) == (from, to) && ends == [Kind::Real; 2]
            });
            between.map(|connection| connection.to).collect::<Vec<_>>()
        };
        let (there, back) = (inputs(one, other), inputs(other, one));
        if there.is_empty() || back.is_empty() {
            return None;
        }
        let inputs = [there, back].concat();
        let slaves = [one, other].map(|slave| self.slaves[slave].name().to_owned());
        let units = inputs
            .iter()
            .all(|port| self.variable(*port).unit.as_deref().is_some_and(|unit| !unit.is_empty()));
        Some((Unwatched { slaves, units, ..Unwatched::default() }, inputs))
    }
}
