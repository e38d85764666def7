//! The mean of a residual over what it may depend on, and how much of it that predicts elsewhere.

use super::Compared;
use super::abscissae::{REMEMBERED, causes, memories};
use crate::data::Channel;
use crate::fit::student_quantile;

/// Places at which a mean is told.
const NODES: usize = 15;
/// Parts of the samples, each predicted from the others: records, or pieces of them where these are few.
const PARTS: usize = 8;
/// Pieces of a record where there are fewer records than that.
const PIECES: usize = 4 * PARTS;
/// Fewest samples on which a mean is told.
const FEWEST: usize = 8;
/// Probability of a fraction above zero where nothing depends on anything.
const CHANCE: f64 = 0.005;

/// What a model lacks in one channel over something that it may depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Name of the channel, and its unit.
    pub channel: String,
    /// Unit of [`Shape::mean`].
    pub unit: &'static str,
    /// What it is drawn against: `displacement`, `velocity`, `phase of the cycle`, `time in the record` ...
    pub against: &'static str,
    /// Unit of [`Shape::x`].
    pub x_unit: &'static str,
    /// Places, rising.
    pub x: Vec<f64>,
    /// Mean of measured minus predicted there.
    pub mean: Vec<f64>,
    /// Standard deviation of the samples about it.
    pub deviation: Vec<f64>,
    /// Fraction of the residual's variance that the mean of the other records (or pieces of records) predicts; 0 where noise
    /// alone could do so. Fractions of different shapes overlap.
    pub fraction: f64,
}

impl Shape {
    /// Whether it is over what was before.
    pub fn remembers(&self) -> bool {
        REMEMBERED.contains(&self.against)
    }
}

/// Samples of all records: abscissa, residual, and the part that each belongs to.
#[derive(Default)]
struct Samples {
    x: Vec<f64>,
    y: Vec<f64>,
    part: Vec<usize>,
}

/// All shapes of their channel that can be told.
pub(super) fn of(all: &[Compared], unit: &'static str) -> Vec<Shape> {
    let mut kinds: Vec<(&'static str, &'static str, Samples)> = Vec::new();
    for (k, one) in all.iter().enumerate() {
        for (role, x_unit, x) in abscissae(one) {
            let place = kinds.iter().position(|(known, ..)| *known == role).unwrap_or_else(|| {
                kinds.push((role, x_unit, Samples::default()));
                kinds.len() - 1
            });
            let samples = &mut kinds[place].2;
            let count = x.len();
            for (i, (x, y)) in x.into_iter().zip(&one.lacks).enumerate().filter(|(_, (x, _))| x.is_finite()) {
                samples.x.push(x);
                samples.y.push(*y);
                let piece = if all.len() >= PARTS { k } else { i * PIECES / count };
                samples.part.push(piece % PARTS);
            }
        }
    }
    let shape = |(against, x_unit, samples): (&'static str, &'static str, Samples)| {
        let Told { x, mean, deviation } = samples.told()?;
        let fraction = samples.predicted();
        Some(Shape { channel: all[0].name.to_owned(), unit, against, x_unit, x, mean, deviation, fraction })
    };
    kinds.into_iter().filter_map(shape).collect()
}

/// What the residual of a record may depend on, with its role and unit.
fn abscissae(one: &Compared) -> Vec<(&'static str, &'static str, Vec<f64>)> {
    let Some(measured) = one.record.channel(one.name) else { return Vec::new() };
    let causes = causes(one.record, measured);
    let motion = |role: &str| causes.iter().find(|(known, _)| *known == role).map(|(_, channel)| channel);
    let moved: Option<&Channel> =
        motion("displacement").or_else(|| motion("excitation")).or_else(|| motion("measured value"));
    let past = moved.and_then(memories);
    let mut found: Vec<(&'static str, &'static str, Vec<f64>)> = Vec::new();
    found.extend(past.into_iter().flatten());
    if let Some(time) = one.record.time() {
        found.push(("time in the record", "s", time.iter().map(|t| t - time[0]).collect()));
    }
    // A value that holds the residual itself would predict it.
    let others = causes.into_iter().filter(|(role, _)| *role != "measured value");
    found.extend(others.map(|(role, channel)| (role, channel.unit, channel.values)));
    found
}

/// Means at nodes.
struct Told {
    x: Vec<f64>,
    mean: Vec<f64>,
    deviation: Vec<f64>,
}

impl Samples {
    /// Place of a sample among the nodes: the one below it, and the way to the next.
    fn place(&self, i: usize, (low, high): (f64, f64)) -> (usize, f64) {
        let place = (self.x[i] - low) / (high - low) * (NODES - 1) as f64;
        let node = (place as usize).min(NODES - 2);
        (node, place - node as f64)
    }

    fn range(&self) -> Option<(f64, f64)> {
        let low = self.x.iter().copied().fold(f64::INFINITY, f64::min);
        let high = self.x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (high > low && self.x.len() >= FEWEST * NODES).then_some((low, high))
    }

    /// The broken line that fits the samples of all parts but one best; its mean where there are none.
    fn line(&self, range: (f64, f64), without: Option<usize>) -> ([f64; NODES], f64) {
        let seen = || (0..self.x.len()).filter(|i| Some(self.part[*i]) != without);
        let count = seen().count().max(1) as f64;
        let mean = seen().map(|i| self.y[i]).sum::<f64>() / count;
        // A spring to the mean as stiff as a twentieth of a sample, so that empty nodes have a value.
        let (mut diagonal, mut beside, mut right) = ([0.05; NODES], [0.0; NODES], [0.0; NODES]);
        for i in seen() {
            let ((k, t), y) = (self.place(i, range), self.y[i] - mean);
            diagonal[k] += (1.0 - t) * (1.0 - t);
            diagonal[k + 1] += t * t;
            beside[k] += t * (1.0 - t);
            right[k] += (1.0 - t) * y;
            right[k + 1] += t * y;
        }
        for k in 1..NODES {
            let factor = beside[k - 1] / diagonal[k - 1];
            diagonal[k] -= factor * beside[k - 1];
            right[k] -= factor * right[k - 1];
        }
        let mut line = [0.0; NODES];
        for k in (0..NODES).rev() {
            let after = if k + 1 < NODES { beside[k] * line[k + 1] } else { 0.0 };
            line[k] = (right[k] - after) / diagonal[k];
        }
        (line, mean)
    }

    fn at(&self, line: &[f64; NODES], i: usize, range: (f64, f64)) -> f64 {
        let (k, t) = self.place(i, range);
        (1.0 - t) * line[k] + t * line[k + 1]
    }

    /// Mean and deviation at nodes that have samples.
    fn told(&self) -> Option<Told> {
        let range = self.range()?;
        let (line, mean) = self.line(range, None);
        let (mut squares, mut counts) = ([0.0; NODES], [0.0; NODES]);
        for i in 0..self.x.len() {
            let (k, t) = self.place(i, range);
            let nearest = k + usize::from(t > 0.5);
            squares[nearest] += (self.y[i] - mean - self.at(&line, i, range)).powi(2);
            counts[nearest] += 1.0;
        }
        let seen: Vec<usize> = (0..NODES).filter(|k| counts[*k] >= FEWEST as f64).collect();
        let x = |k: &usize| range.0 + (range.1 - range.0) * *k as f64 / (NODES - 1) as f64;
        Some(Told {
            x: seen.iter().map(x).collect(),
            mean: seen.iter().map(|k| mean + line[*k]).collect(),
            deviation: seen.iter().map(|k| f64::sqrt(squares[*k] / counts[*k])).collect(),
        })
    }

    /// Fraction of the variance of each part that the others predict, on the whole; 0 unless that is above zero by Student's
    /// test over the parts.
    fn predicted(&self) -> f64 {
        let Some(range) = self.range() else { return 0.0 };
        let (mut gains, mut left, mut whole) = (Vec::new(), 0.0, 0.0);
        for part in 0..PARTS {
            let (line, mean) = self.line(range, Some(part));
            let (mut after, mut before) = (0.0, 0.0);
            for i in (0..self.x.len()).filter(|i| self.part[*i] == part) {
                let y = self.y[i] - mean;
                before += y * y;
                after += (y - self.at(&line, i, range)).powi(2);
            }
            if before > 0.0 {
                gains.push(1.0 - after / before);
            }
            left += after;
            whole += before;
        }
        let count = gains.len() as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let variance = gains.iter().map(|gain| (gain - mean).powi(2)).sum::<f64>() / (count - 1.0);
        let above = student_quantile(1.0 - CHANCE, gains.len().saturating_sub(1)) * (variance / count).sqrt();
        let fraction = 1.0 - left / whole;
        if gains.len() > 2 && mean > above && fraction > 0.0 { fraction } else { 0.0 }
    }
}
