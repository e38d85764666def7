//! Paths of a prescribed motion: a displacement over the record's level, of time. A path has a past: what a late
//! sensor shows first, and what a contact remembers that was in motion before its record.

use std::f64::consts::TAU;

/// Displacement over the level, of time.
#[derive(Debug, Clone)]
pub enum Path {
    /// One frequency, one level.
    Sine {
        /// Hz.
        frequency: f64,
        /// At the start (rad).
        phase: f64,
    },
    /// From one frequency to another.
    Sweep {
        /// Frequency at the start and before it (Hz).
        from: f64,
        /// Frequency at the end (Hz).
        to: f64,
        /// Time between them (s).
        duration: f64,
        /// By equal factors in equal times, instead of equal differences.
        logarithmic: bool,
        /// At the start (rad).
        phase: f64,
    },
    /// Straight lines with rounded corners; [`ramps`] makes them.
    Ramps {
        /// Where it is held before the first corner.
        first: f64,
        /// Where the speed changes.
        corners: Vec<Corner>,
        /// Time that a change of speed takes (s).
        rounding: f64,
    },
    /// A sine whose amplitude changes exponentially.
    Fade {
        /// Hz.
        frequency: f64,
        /// At the start (rad).
        phase: f64,
        /// Fraction of the level at the start.
        from: f64,
        /// Fraction of the level at the end.
        to: f64,
        /// Time between them (s).
        duration: f64,
    },
    /// A sine whose amplitude grows from nothing and falls to nothing.
    Swell {
        /// Hz.
        frequency: f64,
        /// At the start (rad).
        phase: f64,
        /// When it has grown to the level (s).
        peak: f64,
        /// When nothing is left of it (s).
        duration: f64,
    },
    /// A sine whose amplitude grows from nothing in steps.
    Treads {
        /// Hz.
        frequency: f64,
        /// At the start (rad).
        phase: f64,
        /// The steps.
        treads: Vec<Tread>,
    },
    /// Small cycles on a slow motion.
    Ride {
        /// Of the slow motion and of the cycles (Hz).
        frequencies: [f64; 2],
        /// Of the two at the start (rad).
        phases: [f64; 2],
        /// Fraction of the cycles in the level.
        small: f64,
    },
}

/// A step of an amplitude.
#[derive(Debug, Clone)]
pub struct Tread {
    /// When (s).
    pub begins: f64,
    /// How long it takes (s).
    pub lasts: f64,
    /// By how much.
    pub rises: f64,
}

/// Where the speed of a ramp changes.
#[derive(Debug, Clone)]
pub struct Corner {
    /// When (s).
    time: f64,
    /// By how much (1/s).
    change: f64,
}

impl Path {
    /// Displacement over the level at a time (s), negative before the record begins.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Path::Sine { frequency, phase } => (TAU * frequency * time + phase).sin(),
            Path::Sweep { from, to, duration, logarithmic, phase } => {
                let cycles = if time <= 0.0 {
                    from * time
                } else if *logarithmic {
                    let growth = (to / from).ln() / duration;
                    from * (growth * time).exp_m1() / growth
                } else {
                    from * time + 0.5 * (to - from) * time * time / duration
                };
                (TAU * cycles + phase).sin()
            }
            Path::Ramps { first, corners, rounding } => {
                let turns = corners.iter().map(|corner| corner.change * ramp(time - corner.time, *rounding));
                first + turns.sum::<f64>()
            }
            Path::Fade { frequency, phase, from, to, duration } => {
                let level = from * (to / from).powf(time / duration);
                level * (TAU * frequency * time + phase).sin()
            }
            Path::Swell { frequency, phase, peak, duration } => {
                let part = if time < *peak { time / peak } else { (duration - time) / (duration - peak) };
                let part = part.clamp(0.0, 1.0);
                part * part * (3.0 - 2.0 * part) * (TAU * frequency * time + phase).sin()
            }
            Path::Treads { frequency, phase, treads } => {
                let level = treads.iter().map(|tread| {
                    let part = ((time - tread.begins) / tread.lasts).clamp(0.0, 1.0);
                    tread.rises * part * part * (3.0 - 2.0 * part)
                });
                level.sum::<f64>() * (TAU * frequency * time + phase).sin()
            }
            Path::Ride { frequencies, phases, small } => {
                let wave = |index: usize| (TAU * frequencies[index] * time + phases[index]).sin();
                (1.0 - small) * wave(0) + small * wave(1)
            }
        }
    }

    /// Whether it begins with no displacement and no speed by itself.
    pub fn begins_at_rest(&self) -> bool {
        matches!(self, Path::Ramps { .. } | Path::Swell { .. } | Path::Treads { .. })
    }
}

/// Straight lines through places at times, (s, 1), rounded where they meet: no machine has infinite acceleration.
pub fn ramps(places: &[(f64, f64)], rounding: f64) -> Path {
    let mut speed = 0.0;
    let mut corners = Vec::new();
    for pair in places.windows(2) {
        let [(time, place), (then, there)] = [pair[0], pair[1]];
        let next = (there - place) / (then - time);
        corners.push(Corner { time, change: next - speed });
        speed = next;
    }
    Path::Ramps { first: places[0].1, corners, rounding }
}

/// Zero before zero and the time itself after it, the corner between them rounded over a time.
fn ramp(time: f64, rounding: f64) -> f64 {
    let into = time + 0.5 * rounding;
    if into <= 0.0 {
        0.0
    } else if into >= rounding {
        time
    } else {
        0.5 * into * into / rounding
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sweeps_begin_and_end_at_their_frequencies() {
        for logarithmic in [false, true] {
            let (from, to, duration) = (0.5, 5.0, 3.0);
            let at = |phase: f64, time: f64| Path::Sweep { from, to, duration, logarithmic, phase }.at(time);
            // The angle's rate from the sine and the cosine.
            let frequency = |time: f64| {
                let angle = |time: f64| at(0.0, time).atan2(at(TAU / 4.0, time));
                (angle(time + 1e-5) - angle(time - 1e-5)).rem_euclid(TAU) / (TAU * 2e-5)
            };
            assert!((frequency(-0.3) - from).abs() < 1e-6);
            assert!((frequency(2e-5) - from).abs() < 1e-3);
            assert!((frequency(duration) - to).abs() < 1e-3);
            let middle = if logarithmic { (from * to).sqrt() } else { 0.5 * (from + to) };
            assert!((frequency(0.5 * duration) - middle).abs() < 1e-3);
        }
    }
}
