//! Whether the residual looks like the noise: white as the noise is, and without relation
//! to the motion, its rate and slow time.

use super::blocks;
use crate::diagnose::measurements::noise::driver;
use crate::diagnose::measurements::weighted_dataset::{Scored, WeightedDataset};
use crate::fit::predict::period;

/// Standard errors beyond which a relation is no chance.
const BEYOND: f64 = 3.0;

/// Products of a residual with something else, both about their means.
#[derive(Default)]
pub(in crate::diagnose) struct Relation {
    product: f64,
    squares: [f64; 2],
    count: f64,
}

impl Relation {
    pub fn add(&mut self, a: &[f64], b: &[f64]) {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len().max(1) as f64;
        let (means, count) = ([mean(a), mean(b)], a.len().min(b.len()));
        for (a, b) in a.iter().zip(b) {
            self.product += (a - means[0]) * (b - means[1]);
            self.squares[0] += (a - means[0]).powi(2);
            self.squares[1] += (b - means[1]).powi(2);
        }
        self.count += count as f64;
    }

    /// Their correlation.
    pub fn value(&self) -> f64 {
        let size = (self.squares[0] * self.squares[1]).sqrt();
        if size > 0.0 { self.product / size } else { 0.0 }
    }
}

/// What the residuals of `scored` follow beyond chance, in words; empty where they look like noise. That samples
/// near each other are alike counts only where the noise, as periods show it, is less so.
pub(in crate::diagnose) fn follows(bench: &WeightedDataset, scored: &[Scored]) -> Vec<&'static str> {
    let [mut motion, mut rate, mut time, mut next, mut noise] = [(); 5].map(|()| Relation::default());
    for one in scored {
        let lane = &bench.lanes[one.record];
        let drive = driver(lane.record);
        let period = drive.and_then(|drive| period(&drive.values));
        for (_, range) in &lane.channels {
            let residual = &one.residuals[range.clone()];
            let count = residual.len();
            if count < 3 {
                continue;
            }
            time.add(residual, &(0..count).map(|i| i as f64).collect::<Vec<_>>());
            next.add(&residual[1..], &residual[..count - 1]);
            if let Some(drive) = drive.filter(|drive| drive.values.len() == count) {
                motion.add(residual, &drive.values);
                let rates: Vec<f64> = drive.values.windows(3).map(|w| w[2] - w[0]).collect();
                rate.add(&residual[1..count - 1], &rates);
            }
            if let Some(lag) = period.map(|period| period.round() as usize).filter(|lag| count > lag + 2) {
                let measured = &lane.measured[range.clone()];
                let apart: Vec<f64> = measured[lag..].iter().zip(measured).map(|(a, b)| a - b).collect();
                noise.add(&apart[1..], &apart[..apart.len() - 1]);
            }
        }
    }
    let alike = blocks::correlation(scored.iter().map(|one| one.residuals.as_slice())).max(1.0);
    let mut found = Vec::new();
    for (relation, name) in [(motion, "the motion"), (rate, "its rate"), (time, "slow time")] {
        if relation.value().abs() * (relation.count / alike).sqrt() > BEYOND {
            found.push(name);
        }
    }
    let error = (alike * (1.0 / next.count.max(1.0) + 1.0 / noise.count.max(1.0))).sqrt();
    if noise.count > 0.0 && next.value() - noise.value() > BEYOND * error {
        found.push("itself from sample to sample, more than the noise does");
    }
    found
}

#[cfg(test)]
mod tests {
    use super::Relation;

    #[test]
    fn a_relation_is_one_between_lines_and_none_between_odd_and_even() {
        let line: Vec<f64> = (-50..=50).map(f64::from).collect();
        let mut same = Relation::default();
        same.add(&line, &line.iter().map(|x| 3.0 - 2.0 * x).collect::<Vec<_>>());
        assert!((same.value() + 1.0).abs() < 1e-12);
        let mut none = Relation::default();
        none.add(&line, &line.iter().map(|x| x * x).collect::<Vec<_>>());
        assert!(none.value().abs() < 1e-12 && (none.count - 101.0).abs() < 1e-12);
    }
}
