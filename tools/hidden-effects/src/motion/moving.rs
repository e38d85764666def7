//! Records that are not stationary: what test machines do beside sines of one level.

use crate::motion::path::{self, Path};
use crate::records::random::Random;
use crate::records::record::Regime;

/// Level over the yield displacement, course and regime of each record.
pub const PLAN: [(f64, Course, Regime); 8] = [
    (0.8, Course::LinearSweep, Regime::FromRest),
    (1.6, Course::Fade, Regime::UnknownInitialState),
    (3.0, Course::Steps, Regime::FromRest),
    (6.0, Course::Ramps, Regime::UnknownInitialState),
    (6.0, Course::Ride, Regime::UnknownInitialState),
    (6.0, Course::LogarithmicSweep, Regime::UnknownInitialState),
    (3.0, Course::LinearSweep, Regime::UnknownInitialState),
    (4.5, Course::Swell, Regime::FromRest),
];

/// Slip of the record that slips most, over the yield displacement: the logarithmic sweep.
pub const TRAVEL: f64 = 110.0;

/// What kind of path a record takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Course {
    /// The frequency grows or falls evenly.
    LinearSweep,
    /// The frequency grows or falls by the same factor in the same time.
    LogarithmicSweep,
    /// Ramps of one speed to levels that grow from step to step, each held.
    Steps,
    /// Ramps of different speeds between the two ends, some held, one interrupted on its way.
    Ramps,
    /// A sine whose amplitude grows or falls exponentially.
    Fade,
    /// A sine whose amplitude grows from nothing and falls to nothing.
    Swell,
    /// Small cycles on a slow large motion.
    Ride,
}

/// A path with its numbers drawn.
pub struct Drawn {
    /// The path.
    pub path: Path,
    /// Duration of the record (s).
    pub duration: f64,
    /// Samples per second, a hundred and more for the fastest cycle.
    pub rate: f64,
    /// Frequency (Hz) of what goes with the motion.
    pub pace: f64,
}

impl Course {
    /// Draws the numbers of a path.
    pub fn draw(self, random: &mut Random) -> Drawn {
        match self {
            Course::LinearSweep | Course::LogarithmicSweep => {
                let ends = [random.between(0.4, 0.6), random.between(4.5, 5.5)];
                let [from, to] = if random.unit() < 0.5 { ends } else { [ends[1], ends[0]] };
                let duration = 3.0;
                let path = Path::Sweep {
                    from,
                    to,
                    duration,
                    logarithmic: self == Course::LogarithmicSweep,
                    phase: random.phase(),
                };
                Drawn { path, duration, rate: 600.0, pace: ends[1] }
            }
            Course::Steps => steps(random),
            Course::Ramps => ramps(random),
            Course::Fade => {
                let (frequency, duration) = (random.between(1.0, 2.0), 5.0);
                let fade = random.between(0.15, 0.3);
                let [from, to] = if random.unit() < 0.5 { [fade, 1.0] } else { [1.0, fade] };
                let path = Path::Fade { frequency, phase: random.phase(), from, to, duration };
                Drawn { path, duration, rate: 250.0, pace: frequency }
            }
            Course::Swell => {
                let (frequency, duration) = (random.between(0.8, 1.2), 6.0);
                let peak = random.between(0.4, 0.6) * duration;
                let path = Path::Swell { frequency, phase: random.phase(), peak, duration };
                Drawn { path, duration, rate: 250.0, pace: frequency }
            }
            Course::Ride => {
                let slow = random.between(0.2, 0.3);
                let fast = slow * random.between(7.0, 11.0);
                let path = Path::Ride {
                    frequencies: [slow, fast],
                    phases: [random.phase(), random.phase()],
                    small: random.between(0.12, 0.2),
                };
                Drawn { path, duration: 2.0 / slow, rate: 300.0, pace: 1.0 }
            }
        }
    }
}

/// Samples per second of ramps.
const RAMP_RATE: f64 = 200.0;
const RAMP_PACE: f64 = 0.5;

fn steps(random: &mut Random) -> Drawn {
    let sign = random.sign();
    let levels = [1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 0.0].map(|level| sign * level / 3.0);
    let speed = random.between(1.5, 2.5);
    // At rest at first, longer than the machine takes to set itself in motion.
    let mut places = vec![(0.0, 0.0), (random.between(0.1, 0.3), 0.0)];
    for level in levels {
        let (time, place) = places[places.len() - 1];
        let there = time + (level - place).abs() / speed;
        places.extend([(there, level), (there + random.between(0.2, 0.5), level)]);
    }
    from_places(&places, random)
}

fn ramps(random: &mut Random) -> Drawn {
    let sign = random.sign();
    let interrupted = 1 + (random.unit() * 4.0) as usize;
    // On the way from one end before the record begins.
    let mut places = vec![(-random.between(0.3, 0.7), -sign)];
    for leg in 0..6 {
        let (time, place) = places[places.len() - 1];
        let (end, lasts) = (-place, random.magnitude(0.5, 2.0));
        if leg == interrupted {
            // Beyond the middle it slips, whatever the ramp before has left behind.
            let way = random.between(0.6, 0.8);
            let held = time + way * lasts;
            let on = held + random.between(0.2, 1.0);
            let there = place + way * (end - place);
            places.extend([(held, there), (on, there), (on + (1.0 - way) * lasts, end)]);
        } else {
            places.push((time + lasts, end));
        }
        if random.unit() < 0.5 {
            let (there, _) = places[places.len() - 1];
            places.push((there + random.between(0.2, 1.0), end));
        }
    }
    from_places(&places, random)
}

fn from_places(places: &[(f64, f64)], random: &mut Random) -> Drawn {
    Drawn {
        path: path::ramps(places, random.between(0.03, 0.06)),
        duration: places[places.len() - 1].0,
        rate: RAMP_RATE,
        pace: RAMP_PACE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Speed and change of speed by differences.
    fn speeds(path: &Path, duration: f64) -> Vec<f64> {
        let step = 1e-4;
        let count = (duration / step) as usize;
        (0..count)
            .map(|index| {
                let time = index as f64 * step;
                (path.at(time + step) - path.at(time)) / step
            })
            .collect()
    }

    #[test]
    fn steps_hold_still_and_all_move_at_one_speed() {
        let drawn = Course::Steps.draw(&mut Random::new(7));
        let speeds = speeds(&drawn.path, drawn.duration);
        let fastest = speeds.iter().fold(0.0_f64, |fastest, speed| fastest.max(speed.abs()));
        let share = |near: f64| {
            let count = speeds.iter().filter(|speed| (speed.abs() - near).abs() < 1e-6 * fastest).count();
            count as f64 / speeds.len() as f64
        };
        let (still, moving) = (share(0.0), share(fastest));
        assert!(still > 0.15 && moving > 0.4 && still + moving > 0.85, "{still} {moving}");
    }

    #[test]
    fn ramps_have_several_speeds_and_an_acceleration_that_ends() {
        let drawn = Course::Ramps.draw(&mut Random::new(7));
        let speeds = speeds(&drawn.path, drawn.duration);
        let jump = speeds.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
        // The fastest leg takes half a second for two levels and turns within thirty milliseconds.
        assert!(jump < 8.0 / 0.03 * 1e-4 * 1.01, "{jump}");
        let mut distinct: Vec<i64> =
            speeds.iter().map(|speed| (100.0 * speed.abs()).round() as i64).collect();
        distinct.sort_unstable();
        let held = distinct.chunk_by(|a, b| a == b).filter(|alike| alike.len() > 1000).count();
        assert!(held >= 4, "{held}");
    }
}
