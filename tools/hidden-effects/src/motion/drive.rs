//! What the test machine does with a bare contact in one record, and the records of an experiment.

use std::f64::consts::TAU;

use crate::motion::path::Path;
use crate::motion::{moving, ramped};
use crate::records::random::Random;
use crate::records::record::Regime;

/// How the records of an experiment move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Drive {
    /// Sines of one level and one frequency each.
    Stationary,
    /// Ramps with holds, sweeps, sines that grow and fall, small cycles on a large motion: hardly a cycle is
    /// like the one before.
    Moving,
    /// The same, and nobody has looked at the noise: neither repeats nor the dataset tell it.
    MovingUntold,
    /// Sines that grow from rest in ramps and are held after each: cycles repeat while a level is held.
    Ramped,
}

/// Samples of a stationary record over three periods, the last instant included.
const SAMPLES: usize = 1201;
const PERIODS: f64 = 3.0;
/// Level over the yield displacement, frequency (Hz) and regime of each stationary record.
const PLAN: [(f64, f64, Regime); 8] = [
    (0.8, 1.0, Regime::FromRest),
    (1.6, 1.0, Regime::UnknownInitialState),
    (3.0, 1.0, Regime::FromRest),
    (6.0, 1.0, Regime::UnknownInitialState),
    (6.0, 0.2, Regime::UnknownInitialState),
    (6.0, 5.0, Regime::UnknownInitialState),
    (3.0, 5.0, Regime::UnknownInitialState),
    (4.5, 1.0, Regime::FromRest),
];

/// The motion of one record.
#[derive(Clone)]
pub struct Motion {
    /// Largest displacement (m).
    pub amplitude: f64,
    /// Frequency (Hz) of what goes with the motion: what the normal direction does is a multiple of it.
    pub pace: f64,
    /// How the record begins.
    pub regime: Regime,
    /// Stretch of the sliders at the start, over the yield displacement; `None`: cut out of a longer motion.
    pub stretch: Option<f64>,
    /// Phases of the normal load and of a disturbance.
    pub phases: [f64; 2],
    /// Number of samples.
    pub samples: usize,
    /// Time between them (s).
    pub period: f64,
    path: Path,
}

impl Drive {
    /// Whether its records are not stationary.
    pub fn is_moving(self) -> bool {
        matches!(self, Drive::Moving | Drive::MovingUntold)
    }

    /// What a case's name ends with. Stationary records are not told: most names are older than the word.
    pub fn suffix(self) -> &'static str {
        match self {
            Drive::Stationary => "",
            Drive::Moving => "-moving",
            Drive::MovingUntold => "-moving-untold",
            Drive::Ramped => "-ramped",
        }
    }

    /// The records of an experiment whose contact yields at `yield_displacement` (m).
    pub fn motions(self, yield_displacement: f64, random: &mut Random) -> Vec<Motion> {
        match self {
            Drive::Stationary => {
                PLAN.map(|plan| stationary(plan, yield_displacement, &mut random.fork())).to_vec()
            }
            Drive::Moving | Drive::MovingUntold => {
                moving::PLAN.map(|plan| in_motion(plan, yield_displacement, &mut random.fork())).to_vec()
            }
            Drive::Ramped => {
                ramped::PLAN.map(|plan| in_ramps(plan, yield_displacement, &mut random.fork())).to_vec()
            }
        }
    }

    /// Slip of the record that slips most, over the yield displacement.
    pub fn travel(self) -> f64 {
        match self {
            Drive::Stationary => 55.0,
            Drive::Moving | Drive::MovingUntold => moving::TRAVEL,
            Drive::Ramped => ramped::TRAVEL,
        }
    }
}

fn stationary(
    (level, frequency, regime): (f64, f64, Regime),
    yield_displacement: f64,
    random: &mut Random,
) -> Motion {
    let amplitude = level * random.about_one(0.1) * yield_displacement;
    let turned = if random.unit() < 0.5 { 0.0 } else { TAU / 2.0 };
    let phase = if regime == Regime::FromRest { turned } else { random.phase() };
    let (stretch, phases) = beginning(regime, random);
    Motion {
        amplitude,
        pace: frequency,
        regime,
        stretch,
        phases,
        samples: SAMPLES,
        period: PERIODS / frequency / (SAMPLES - 1) as f64,
        path: Path::Sine { frequency, phase },
    }
}

fn in_motion(
    (level, course, regime): (f64, moving::Course, Regime),
    yield_displacement: f64,
    random: &mut Random,
) -> Motion {
    let amplitude = level * random.about_one(0.1) * yield_displacement;
    let (stretch, phases) = beginning(regime, random);
    let course = course.draw(random);
    Motion {
        amplitude,
        pace: course.pace,
        regime,
        stretch,
        phases,
        // None beyond the end of the last ramp.
        samples: (course.duration * course.rate).floor() as usize + 1,
        period: 1.0 / course.rate,
        path: course.path,
    }
}

fn in_ramps((level, frequency): (f64, f64), yield_displacement: f64, random: &mut Random) -> Motion {
    let amplitude = level * random.about_one(0.1) * yield_displacement;
    let (stretch, phases) = beginning(Regime::FromRest, random);
    Motion {
        amplitude,
        pace: frequency,
        regime: Regime::FromRest,
        stretch,
        phases,
        samples: ramped::PERIODS as usize * ramped::SAMPLES + 1,
        period: 1.0 / frequency / ramped::SAMPLES as f64,
        path: ramped::path(frequency, random),
    }
}

/// What the contact remembers at the start of a record, and the phases of what goes with the motion.
fn beginning(regime: Regime, random: &mut Random) -> (Option<f64>, [f64; 2]) {
    let stretch = random.between(-0.95, 0.95);
    let steady = random.unit() < 0.25 && regime == Regime::UnknownInitialState;
    ((!steady).then_some(stretch), [random.phase(), random.phase()])
}

impl Motion {
    /// Displacement at a time, that before the record's start included (m).
    pub fn displacement(&self, time: f64) -> f64 {
        let wave = self.amplitude * self.path.at(time);
        if self.regime != Regime::FromRest || self.path.begins_at_rest() {
            return wave;
        }
        // Up to the full level within one and a half periods, without a jerk.
        let part = (2.0 * time * self.pace / PERIODS).clamp(0.0, 1.0);
        wave * part * part * (3.0 - 2.0 * part)
    }

    /// Times of the samples (s).
    pub fn times(&self) -> Vec<f64> {
        (0..self.samples).map(|index| index as f64 * self.period).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slip of one slider that yields at one, over the record.
    fn slip(motion: &Motion) -> f64 {
        let (mut slider, mut slipped) = (motion.displacement(0.0), 0.0);
        for time in motion.times() {
            let displacement = motion.displacement(time);
            let moved = slider.clamp(displacement - 1.0, displacement + 1.0);
            slipped += (moved - slider).abs();
            slider = moved;
        }
        slipped
    }

    fn every_motion(drive: Drive) -> impl Iterator<Item = Motion> {
        (1..20).flat_map(move |seed| drive.motions(1.0, &mut Random::new(seed)))
    }

    #[test]
    fn a_record_from_rest_begins_without_displacement_and_without_speed() {
        for motion in [Drive::Moving, Drive::Stationary, Drive::Ramped].into_iter().flat_map(every_motion) {
            if motion.regime == Regime::FromRest {
                assert_eq!([-1.0, -motion.period, 0.0].map(|time| motion.displacement(time)), [0.0; 3]);
                // Of the displacement that a constant speed would give, next to nothing.
                assert!(motion.displacement(1e-3 * motion.period).abs() < 1e-4 * motion.amplitude * 1e-3);
            }
        }
    }

    #[test]
    fn motions_reach_their_level_and_turn_without_a_jump() {
        for motion in [Drive::Moving, Drive::Ramped].into_iter().flat_map(every_motion) {
            let places: Vec<f64> = motion.times().iter().map(|time| motion.displacement(*time)).collect();
            let largest = places.iter().fold(0.0_f64, |largest, place| largest.max(place.abs()));
            // Two waves need not be at their largest together, nor a sine when its amplitude is.
            assert!((0.7..1.0 + 1e-9).contains(&(largest / motion.amplitude)), "{largest}");
            // A hundred samples and more for the fastest cycle.
            for pair in places.windows(2) {
                assert!((pair[1] - pair[0]).abs() < 0.07 * motion.amplitude);
            }
        }
    }

    #[test]
    fn records_hold_stick_partial_and_gross_slip_and_travel_as_far_as_said() {
        for drive in [Drive::Stationary, Drive::Moving, Drive::Ramped] {
            let mut furthest: f64 = 0.0;
            for seed in 1..20 {
                let slips: Vec<f64> = drive.motions(1.0, &mut Random::new(seed)).iter().map(slip).collect();
                assert!(slips[0] < 1e-9 && slips[1] > 0.5, "{slips:?}");
                assert!(slips.iter().filter(|slip| **slip > 15.0).count() >= 5, "{slips:?}");
                furthest = furthest.max(slips.into_iter().fold(0.0, f64::max));
            }
            assert!((0.8..1.4).contains(&(furthest / drive.travel())), "{furthest}");
        }
    }
}
