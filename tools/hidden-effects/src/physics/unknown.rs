//! Physics of a contact outside the catalogue, and what it remembers.

/// Physics outside the catalogue.
#[derive(Debug, Clone, PartialEq)]
pub enum Unknown {
    /// limit · (1 + share · sin(u/length)): a surface that is not alike everywhere.
    PositionDependentFriction {
        /// Fraction of the limit (1).
        share: f64,
        /// Length over which the phase grows by one (m).
        length: f64,
    },
    /// limit · (1 + share · ln(1 + θ/dwell)), θ̇ = 1 − |ż| θ/length: contacts that grow in rest and are
    /// renewed by slip (rate and state).
    DwellStrengthening {
        /// Fraction of the limit per e-fold (1).
        share: f64,
        /// Time from which growth is logarithmic (s).
        dwell: f64,
        /// Slip that renews the contacts (m).
        length: f64,
    },
    /// limit · (1 + share · (1 − exp(−t/time))), t since the last slip: contacts that grow in stick and are as they were
    /// with the first slip.
    StickAgeing {
        /// Fraction of the limit (1).
        share: f64,
        /// Time constant (s).
        time: f64,
    },
    /// A second, higher limit once the motion since its reversal exceeds a distance: a ratchet.
    SecondLimit {
        /// Fraction of the limit that is added (1).
        share: f64,
        /// Distance since the reversal (m).
        distance: f64,
    },
    /// A damper that remembers, like a derivative of order one half: relaxing springs, one per decade.
    MemoryDamping {
        /// Stiffness of each relaxing spring (N/m).
        stiffness: f64,
        /// Their relaxation times (s).
        times: Vec<f64>,
    },
    /// A damper whose force grows with |v|^exponent.
    PowerLawDamping {
        /// Force at 1 m/s (N).
        coefficient: f64,
        /// Between 0 (dry friction) and 1 (viscous).
        exponent: f64,
    },
    /// limit · (1 + share · (1 − exp(−t/time))): a drift with time, whether it slips or not.
    TimeDrift {
        /// Fraction of the limit (1).
        share: f64,
        /// Time constant (s).
        time: f64,
    },
    /// stiffness · (1 + share · (1 − exp(−t/time))): a drift with time of the stiffness in stick.
    StiffnessDrift {
        /// Fraction of the stiffness (1).
        share: f64,
        /// Time constant (s).
        time: f64,
    },
}

/// What such physics remembers.
#[derive(Debug, Default)]
pub struct Memory {
    /// θ of rate and state, or the time since the last slip (s).
    age: f64,
    /// Displacement at the last reversal (m).
    pub reversal: f64,
    /// Forces of the relaxing springs (N).
    relaxing: Vec<f64>,
}

/// One step of a contact.
#[derive(Debug, Clone, Copy)]
pub struct Moved {
    /// Change of the displacement (m).
    pub change: f64,
    /// Part of it that was slip (m).
    pub slipped: f64,
    /// s.
    pub duration: f64,
}

impl Unknown {
    /// Nothing remembered.
    pub fn memory(&self) -> Memory {
        let relaxing = match self {
            Unknown::MemoryDamping { times, .. } => vec![0.0; times.len()],
            _ => Vec::new(),
        };
        Memory { relaxing, ..Memory::default() }
    }

    /// By what the limit is multiplied at `displacement` (m), `time` (s) after the record's start.
    pub fn on_limit(&self, memory: &Memory, displacement: f64, time: f64) -> f64 {
        match self {
            Unknown::PositionDependentFriction { share, length } => {
                1.0 + share * (displacement / length).sin()
            }
            Unknown::DwellStrengthening { share, dwell, .. } => 1.0 + share * (1.0 + memory.age / dwell).ln(),
            Unknown::StickAgeing { share, time } => 1.0 + share * (1.0 - (-memory.age / time).exp()),
            Unknown::SecondLimit { share, distance } => {
                let travelled = (displacement - memory.reversal).abs();
                1.0 + share * (0.5 + 0.5 * (20.0 * (travelled / distance - 1.0)).tanh())
            }
            Unknown::TimeDrift { share, time: constant } => drifted(*share, time, *constant),
            _ => 1.0,
        }
    }

    /// By what the stiffness is multiplied, `time` (s) after the record's start.
    pub fn on_stiffness(&self, time: f64) -> f64 {
        match self {
            Unknown::StiffnessDrift { share, time: constant } => drifted(*share, time, *constant),
            _ => 1.0,
        }
    }

    /// Adds its own force and that force's slope when the displacement changes by `change` (m) in `duration` (s).
    pub fn add_force(
        &self,
        memory: &Memory,
        change: f64,
        duration: f64,
        (force, slope): (&mut f64, &mut f64),
    ) {
        match self {
            Unknown::MemoryDamping { stiffness, times } => {
                for (relaxing, time) in memory.relaxing.iter().zip(times) {
                    let kept = (-duration / time).exp();
                    *force += kept * relaxing + stiffness * change * kept.sqrt();
                    *slope += stiffness * kept.sqrt();
                }
            }
            Unknown::PowerLawDamping { coefficient, exponent } if change != 0.0 => {
                let own = coefficient * (change.abs() / duration).powf(*exponent) * change.signum();
                *force += own;
                *slope += own / change;
            }
            _ => {}
        }
    }

    /// Remembers a step.
    pub fn remember(&self, memory: &mut Memory, moved: Moved) {
        let Moved { change, slipped, duration } = moved;
        match self {
            Unknown::DwellStrengthening { length, .. } => {
                memory.age = (memory.age + duration) / (1.0 + slipped / length);
            }
            Unknown::StickAgeing { .. } => {
                memory.age = if slipped > 0.0 { 0.0 } else { memory.age + duration };
            }
            Unknown::MemoryDamping { stiffness, times } => {
                for (relaxing, time) in memory.relaxing.iter_mut().zip(times) {
                    let kept = (-duration / time).exp();
                    *relaxing = kept * *relaxing + stiffness * change * kept.sqrt();
                }
            }
            _ => {}
        }
    }
}

fn drifted(share: f64, time: f64, constant: f64) -> f64 {
    1.0 + share * (1.0 - (-time.max(0.0) / constant).exp())
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::physics::contact::Contact;
    use crate::physics::contact::tests::{LOAD, assert_close, cycle, jenkins};
    use crate::physics::joint::Joint;

    fn hiding(unknown: Unknown) -> Joint {
        Joint { unknown: Some(unknown), ..jenkins() }
    }

    #[test]
    fn a_limit_that_ages_is_met_once_after_each_rest() {
        let joint = hiding(Unknown::StickAgeing { share: 0.4, time: 0.1 });
        let mut contact = Contact::at_rest(&joint, 0.0);
        // Held for a second at half the force, then pushed until it slips, and on.
        for index in 1..=1000 {
            contact.advance(5e-6, LOAD, 1e-3, 1e-3 * f64::from(index));
        }
        let forces: Vec<f64> = (1..=4000)
            .map(|index| contact.advance(5e-6 + 1e-8 * f64::from(index), LOAD, 1e-6, 1.0))
            .collect();
        let largest = forces.iter().fold(0.0_f64, |largest, force| largest.max(*force));
        assert_close(largest, 50.0 * 1.4, 1e-3);
        assert_close(forces[3999], 50.0, 1e-4);
    }

    #[test]
    fn power_law_damping_loses_the_integral_of_its_power() {
        let (coefficient, reach) = (3.0, 4e-5_f64);
        let joint = Joint {
            unknown: Some(Unknown::PowerLawDamping { coefficient, exponent: 0.3 }),
            ..Joint::jenkins(5e6, 0.0)
        };
        // ∮ c |v|^1.3 dt over a second, v = ω U cos ωt; the mean of |cos|^1.3 by many points.
        let count = 100_000;
        let mean = (0..count)
            .map(|i| (TAU * (f64::from(i) + 0.5) / f64::from(count)).cos().abs().powf(1.3))
            .sum::<f64>()
            / f64::from(count);
        assert_close(cycle(&joint, reach).0, coefficient * (TAU * reach).powf(1.3) * mean, 1e-4);
    }

    #[test]
    fn a_stiffness_that_drifts_turns_the_sticking_line() {
        let joint = hiding(Unknown::StiffnessDrift { share: 0.3, time: 2.0 });
        let slope = |time: f64| {
            let mut contact = Contact::at_rest(&joint, 0.0);
            contact.advance(1e-6, LOAD, 1e-3, time) / 1e-6
        };
        assert_close(slope(0.0), 5e6, 1e-12);
        assert_close(slope(2.0), 5e6 * (1.0 + 0.3 * (1.0 - (-1.0_f64).exp())), 1e-12);
        assert_close(slope(-3.0), 5e6, 1e-12);
        // The limit stays.
        assert_close(Contact::at_rest(&joint, 0.0).advance(1e-3, LOAD, 1e-3, 9.0), 50.0, 1e-12);
    }
}
