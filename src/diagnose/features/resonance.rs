//! The structure's resonance record by record: the stiffness and the damping that fit each record alone.
//!
//! A fit of the structure's springs and dampers to one record, with the contact fixed, gives the frequency of its
//! resonance and its damping. The dependence of these numbers on the level is what the model lacks.

use rayon::prelude::*;

use crate::diagnose::evidence::alone;
use crate::diagnose::measurements::magnitudes::drive_rate;
use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::effects::Features;
use crate::fit::predict::derivative_order;
use crate::model::Model;

/// Fewest records that can show a dependence on the level.
const FEWEST: usize = 4;
/// Ratio of the largest level to the smallest below which there is but one.
const LEVELS: f64 = 1.5;
/// Correlation with the level from which a change counts as one.
const FOLLOWS: f64 = 0.8;
/// Fraction of the variation that a power of the level must take.
const EXPLAINS: f64 = 0.8;

/// What a record alone asks for.
#[derive(Debug, Clone, Copy)]
struct Seen {
    /// Displacement of the first sensor (m), root mean square.
    level: f64,
    /// Of the lowest mode with the contact in stick (rad/s).
    angular_frequency: f64,
    damping_ratio: f64,
}

/// Fills what the records seen show beside the model refitted without effects; `given` is the model as given.
pub(super) fn fill(
    bench: &WeightedDataset,
    seen: &[usize],
    given: &Model,
    base: &Model,
    found: &mut Features,
) {
    let points: Vec<Seen> = seen.par_iter().filter_map(|record| of_record(bench, base, *record)).collect();
    let Some((given, _)) = lowest_mode(given) else { return };
    summarise(&points, given, found);
}

/// The structure that `record` alone asks for.
fn of_record(bench: &WeightedDataset, model: &Model, record: usize) -> Option<Seen> {
    let of_structure = |path: &str, value: f64| {
        let spring = path.starts_with("spring.") && value > 0.0;
        spring || path == "beam.youngs_modulus" || path.starts_with("beam.damping_ratio")
    };
    // A table says itself where the resonance lies, and has no level of its own.
    if bench.lanes[record].record.regime.is_table() {
        return None;
    }
    let fitted = alone(bench, model, record, of_structure).ok()?;
    let (angular_frequency, damping_ratio) = lowest_mode(&fitted)?;
    let lane = &bench.lanes[record];
    let (name, range) = lane.channels.first()?;
    let order = derivative_order(lane.record.channel(name)?) as i32;
    let level = 1.0 / (lane.scales[range.start] * drive_rate(lane.record)?.powi(order));
    Some(Seen { level, angular_frequency, damping_ratio })
}

/// Part of the largest response of a mode to the excitation below which a mode is not seen.
const SEEN: f64 = 1e-2;

/// Angular frequency (rad/s) and damping ratio of the lowest mode that the excitation moves with the contact in stick: the
/// pendulum that presses a pin hangs below the beam and is none.
fn lowest_mode(model: &Model) -> Option<(f64, f64)> {
    let stiffness = model.contact.map_or(0.0, |contact| contact.tangential_stiffness);
    let structure = model.system().ok()?.stuck_part(stiffness);
    let modes = structure.natural_modes().ok()?;
    let moved = |mode: usize| {
        let shape = modes.shapes.column(mode);
        structure.excitation.iter().map(|(i, part)| part * shape[*i]).sum::<f64>().powi(2)
    };
    let count = modes.angular_frequency.len();
    let largest = (0..count).map(moved).fold(0.0, f64::max);
    let mode = (0..count).find(|mode| moved(*mode) >= SEEN * largest)?;
    let angular_frequency = modes.angular_frequency[mode];
    let shape = modes.shapes.column(mode);
    let damping: f64 = structure.damping.iter().map(|(i, j, value)| value * shape[*i] * shape[*j]).sum();
    (angular_frequency > 0.0).then(|| (angular_frequency, damping / (2.0 * angular_frequency)))
}

/// What the points say beside a model with its resonance at `given` (rad/s).
fn summarise(points: &[Seen], given: f64, found: &mut Features) {
    let levels = || points.iter().map(|point| point.level);
    let (low, high) = (levels().fold(f64::INFINITY, f64::min), levels().fold(0.0, f64::max));
    if points.len() < FEWEST {
        return;
    }
    let errors: Vec<f64> = points.iter().map(|point| point.angular_frequency / given - 1.0).collect();
    let (mean, deviation) = mean_and_deviation(&errors);
    if mean.abs() > 2.0 * deviation {
        found.frequency_error = Some(mean);
    }
    if high < LEVELS * low {
        return;
    }
    let line = Line::through(levels().zip(errors.iter().copied()));
    if line.explained.sqrt() > FOLLOWS {
        found.frequency_by_level = Some(line.slope * (high - low) / (1.0 + mean));
    }
    // ζ = ζ₀ + b Aᵖ with the power that takes most of the variation.
    let power = |tenths: i32| {
        let exponent = f64::from(tenths) / 10.0;
        let point = |point: &Seen| ((point.level / high).powf(exponent), point.damping_ratio);
        (exponent, Line::through(points.iter().map(point)))
    };
    let best = (1..=30).map(power).max_by(|a, b| a.1.explained.total_cmp(&b.1.explained));
    found.damping_exponent =
        best.filter(|(_, line)| line.slope > 0.0 && line.explained > EXPLAINS).map(|(exponent, _)| exponent);
}

fn mean_and_deviation(values: &[f64]) -> (f64, f64) {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt())
}

/// The straight line nearest to points.
struct Line {
    slope: f64,
    /// Fraction of the variance that it takes; 0 where nothing varies.
    explained: f64,
}

impl Line {
    fn through(points: impl Iterator<Item = (f64, f64)> + Clone) -> Self {
        let count = points.clone().count().max(1) as f64;
        let (x, y) = points.clone().fold((0.0, 0.0), |(x, y), point| (x + point.0, y + point.1));
        let (x, y) = (x / count, y / count);
        let (xx, xy, yy) = points.fold((0.0, 0.0, 0.0), |(xx, xy, yy), point| {
            let (dx, dy) = (point.0 - x, point.1 - y);
            (xx + dx * dx, xy + dx * dy, yy + dy * dy)
        });
        let varies = xx > 0.0 && yy > 0.0;
        Self {
            slope: if xx > 0.0 { xy / xx } else { 0.0 },
            explained: if varies { xy * xy / (xx * yy) } else { 0.0 },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(shift: impl Fn(f64) -> f64, damping: impl Fn(f64) -> f64) -> Vec<Seen> {
        let levels = [0.1, 0.25, 0.4, 0.7, 1.0, 0.55];
        let seen = |level: f64| Seen {
            level: 1e-4 * level,
            angular_frequency: 300.0 * (1.0 + shift(level)),
            damping_ratio: 4e-3 * (1.0 + damping(level)),
        };
        levels.into_iter().map(seen).collect()
    }

    fn features(points: &[Seen]) -> Features {
        let mut found = Features::default();
        summarise(points, 300.0, &mut found);
        found
    }

    #[test]
    fn a_shift_that_grows_with_the_level_is_one_by_level() {
        for (sign, power) in [(1.0, 1), (1.0, 2), (-1.0, 2), (-1.0, 1)] {
            let found = features(&points(|level| sign * 0.03 * level.powi(power), |_| 0.0));
            let change = found.frequency_by_level.expect("it follows the level");
            assert!((change / (sign * 0.03) - 1.0).abs() < 0.15, "{change}");
            assert_eq!(found.frequency_error, None);
        }
    }

    #[test]
    fn a_shift_that_is_the_same_at_every_level_is_an_error_of_the_model() {
        // Scatter that follows no level.
        let found = features(&points(|level| -0.02 + 2e-4 * (50.0 * level).sin(), |_| 0.0));
        assert!((found.frequency_error.unwrap() + 0.02).abs() < 5e-4);
        assert_eq!(found.frequency_by_level, None);
    }

    #[test]
    fn the_exponent_is_that_of_the_power_by_which_the_damping_grows() {
        for exponent in [0.5, 1.0, 2.0] {
            let found = features(&points(|_| 0.0, |level: f64| 2.0 * level.powf(exponent)));
            assert!((found.damping_exponent.unwrap() - exponent).abs() < 0.05);
        }
        // A damping that falls, or does neither, has no such exponent.
        assert_eq!(features(&points(|_| 0.0, |level| -level)).damping_exponent, None);
        assert_eq!(features(&points(|_| 0.0, |level| 0.1 * (50.0 * level).sin())).damping_exponent, None);
    }

    #[test]
    fn one_level_and_few_records_show_nothing_of_the_level() {
        let mut same = points(|level| level, |level| level);
        same.iter_mut().for_each(|point| point.level = 1e-4);
        assert_eq!(features(&same).frequency_by_level, None);
        assert_eq!(features(&points(|level| level, |level| level)[..3]), Features::default());
    }

    #[test]
    fn the_lowest_mode_is_that_of_a_mass_between_its_springs() {
        let model = Model::parse(
            r#"
            schema = "stickslip.model/1"
            kind = "oscillator"
            mass = [{ name = "m1", mass = 2.0 }]
            spring = [{ between = ["ground", "m1"], stiffness = 11.0, damping = 0.6 }]
            contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
            "#,
        )
        .unwrap();
        let (angular_frequency, damping_ratio) = lowest_mode(&model).unwrap();
        assert!((angular_frequency - 3.0).abs() < 1e-12);
        // c/(2 m ω)
        assert!((damping_ratio - 0.05).abs() < 1e-12);
    }
}
