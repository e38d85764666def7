//! Records that begin from rest, of sines that grow in two ramps and are held after each: nothing tells the noise but the
//! cycles that repeat while a level is held.

use crate::motion::path::{Path, Tread};
use crate::records::random::Random;

/// Level over the yield displacement, and frequency (Hz), of each record.
pub const PLAN: [(f64, f64); 8] =
    [(0.8, 1.0), (1.6, 1.0), (3.0, 1.0), (6.0, 1.0), (6.0, 0.2), (6.0, 5.0), (3.0, 5.0), (4.5, 1.0)];

/// Periods of a record.
pub const PERIODS: f64 = 9.0;
/// Samples of a period.
pub const SAMPLES: usize = 140;
/// Slip of the record that slips most, over the yield displacement.
pub const TRAVEL: f64 = 120.0;

/// A sine that grows within a period to a part of its level, is held for three periods, grows within another to all of it,
/// and is held for four.
pub fn path(frequency: f64, random: &mut Random) -> Path {
    let part = random.between(0.4, 0.7);
    let period = 1.0 / frequency;
    let treads = vec![
        Tread { begins: 0.0, lasts: period, rises: part },
        Tread { begins: 4.0 * period, lasts: period, rises: 1.0 - part },
    ];
    Path::Treads { frequency, phase: random.phase(), treads }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cycles_repeat_while_a_level_is_held_and_only_then() {
        let path = path(2.0, &mut Random::new(5));
        let changes = |period: usize| {
            let change = |index: usize| {
                let time = 0.5 * (period as f64 + index as f64 / 50.0);
                (path.at(time + 0.5) - path.at(time)).abs()
            };
            (0..50).map(change).fold(0.0_f64, f64::max)
        };
        let repeats: Vec<bool> = (0..PERIODS as usize - 1).map(|period| changes(period) < 1e-12).collect();
        assert_eq!(repeats, [false, true, true, false, false, true, true, true]);
        assert_eq!(path.at(0.0), 0.0);
    }
}
