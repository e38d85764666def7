//! Features of the measurements and of the residual, as numbers. They explain a verdict and never decide it.
//!
//! `loops` reads the loops of a contact alone, `resonance` the stiffness and damping of a structure record by record.

mod correlation;
mod loops;
mod resonance;

use crate::data::Record;
use crate::diagnose::measurements::weighted_dataset::{Scored, WeightedDataset};
use crate::effects::Features;
use crate::fit::residual::reversals;
use crate::model::{Model, Structure};
pub(super) use correlation::Correlation;
use loops::Measured;

/// Of the training records `seen`, and of the residuals `scored` that the model `base`, refitted without effects, leaves
/// there; `given` is the model as given.
pub(super) fn of(bench: &WeightedDataset, scored: &[Scored], given: &Model, base: &Model) -> Features {
    let mut sums = ResidualSums::default();
    for scored in scored {
        let lane = &bench.lanes[scored.record];
        for (name, range) in &lane.channels {
            // Measured minus predicted: what the model lacks.
            let residual: Vec<f64> = scored.residuals[range.clone()].iter().map(|r| -r).collect();
            sums.add(lane.record, name, &residual, &lane.measured[range.clone()]);
        }
    }
    let mut found = sums.features();
    let seen: Vec<usize> = scored.iter().map(|one| one.record).collect();
    if matches!(base.structure, Structure::Prescribed) {
        let record = |index: &usize| -> &Record { bench.lanes[*index].record };
        let measured: Vec<Measured> = seen.iter().filter_map(|index| Measured::of(record(index))).collect();
        loops::fill(&measured, &mut found);
    } else {
        resonance::fill(bench, &seen, given, base, &mut found);
    }
    found
}

/// Sums over the residuals of all channels.
#[derive(Default)]
struct ResidualSums {
    by_value: Correlation,
    by_rate: Correlation,
    /// Of a tangential and of a normal force on the rate of the motion and on its cube.
    forces: [[Correlation; 2]; 2],
    /// Power of the even and of the odd harmonics.
    harmonics: [f64; 2],
    sum: f64,
    square: f64,
    count: f64,
}

impl ResidualSums {
    fn add(&mut self, record: &Record, name: &str, residual: &[f64], measured: &[f64]) {
        for (i, r) in residual.iter().enumerate() {
            self.sum += r;
            self.square += r * r;
            self.count += 1.0;
            self.by_value.add(*r, measured[i]);
            if i > 0 && i + 1 < measured.len() {
                self.by_rate.add(*r, measured[i + 1] - measured[i - 1]);
            }
        }
        let motion = |name: &str| record.channel(name).map(|channel| channel.values.as_slice());
        let [tangential, normal] = &mut self.forces;
        match name {
            "force" => {
                follow(residual, motion("displacement"), tangential);
                let (even, odd) = halves(residual, motion("displacement"));
                self.harmonics = [self.harmonics[0] + even, self.harmonics[1] + odd];
            }
            "normal_load" => follow(residual, motion("normal_displacement"), normal),
            _ => {}
        }
    }

    fn features(&self) -> Features {
        let [[by_velocity, by_cube], [normal_by_velocity, normal_by_cube]] = &self.forces;
        let ([even, odd], Self { sum, square, count, .. }) = (self.harmonics, self);
        Features {
            residual_mean: (*count > 0.0 && *square > 0.0).then(|| sum / count / (square / count).sqrt()),
            even_harmonics: (even + odd > 0.0).then(|| even / (even + odd)),
            residual_by_velocity: by_velocity.value(),
            residual_by_cube: by_cube.value(),
            residual_by_rate: self.by_rate.value(),
            residual_by_value: self.by_value.value(),
            normal_residual_by_velocity: normal_by_velocity.value(),
            normal_residual_by_cube: normal_by_cube.value(),
            ..Features::default()
        }
    }
}

/// Adds a residual against the rate of a motion, and against its cube with the linear part removed.
fn follow(residual: &[f64], motion: Option<&[f64]>, [rate, cube]: &mut [Correlation; 2]) {
    let Some(motion) = motion else { return };
    let power = |exponent: i32| motion.iter().map(|u| u.powi(exponent)).sum::<f64>();
    let linear = power(4) / power(2).max(f64::MIN_POSITIVE);
    for (i, r) in residual.iter().enumerate() {
        if i > 0 && i + 1 < motion.len() {
            rate.add(*r, motion[i + 1] - motion[i - 1]);
        }
        cube.add(*r, motion[i].powi(3) - linear * motion[i]);
    }
}

/// Power of the even and of the odd harmonics of a residual: half a period later the former are the same, the
/// latter opposite. Nothing where the motion's reversals are not evenly spaced.
fn halves(residual: &[f64], motion: Option<&[f64]>) -> (f64, f64) {
    let Some(motion) = motion else { return (0.0, 0.0) };
    let turns = reversals(motion);
    let (Some(first), Some(last)) = (turns.first(), turns.last()) else { return (0.0, 0.0) };
    let lengths = || turns.windows(2).map(|pair| pair[1] - pair[0]);
    let (Some(shortest), Some(longest)) = (lengths().min(), lengths().max()) else { return (0.0, 0.0) };
    if 10 * longest > 12 * shortest {
        return (0.0, 0.0);
    }
    let half = ((last - first) as f64 / (turns.len() - 1) as f64).round() as usize;
    let mean = residual.iter().sum::<f64>() / residual.len() as f64;
    residual.iter().zip(&residual[half..]).fold((0.0, 0.0), |(even, odd), (now, later)| {
        (even + (now + later - 2.0 * mean).powi(2), odd + (now - later).powi(2))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_are_even_or_odd() {
        let angle = |i: usize| std::f64::consts::TAU * (i as f64 - 30.0) / 100.0;
        let motion: Vec<f64> = (0..500).map(|i| angle(i).sin()).collect();
        let fraction = |order: f64| {
            let residual: Vec<f64> = (0..500).map(|i| 3.0 + (order * angle(i) + 0.7).cos()).collect();
            let (even, odd) = halves(&residual, Some(&motion));
            even / (even + odd)
        };
        for (order, expected) in [(1.0, 0.0), (2.0, 1.0), (3.0, 0.0), (4.0, 1.0)] {
            assert!((fraction(order) - expected).abs() < 1e-3, "{order}: {}", fraction(order));
        }
    }

    #[test]
    fn a_residual_follows_a_cube_and_not_the_line_within_it() {
        let motion: Vec<f64> =
            (0..400).map(|i| (std::f64::consts::TAU * f64::from(i) / 100.0).sin()).collect();
        let by_cube = |residual: Vec<f64>| {
            let mut both = <[Correlation; 2]>::default();
            follow(&residual, Some(&motion), &mut both);
            both[1].value().unwrap()
        };
        // sin³ = ¾ sin − ¼ sin 3θ: beside the line it is the third harmonic.
        let third = |(i, _): (usize, &f64)| -(3.0 * std::f64::consts::TAU * i as f64 / 100.0).sin();
        assert!((by_cube(motion.iter().enumerate().map(third).collect()) - 1.0).abs() < 1e-9);
        assert!(by_cube(motion.clone()).abs() < 1e-9);
    }
}
