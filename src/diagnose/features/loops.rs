//! Features of the measured loops of a contact alone: plateaus, corners, heights.
//!
//! A record is cut at the reversals of its displacement. Along a branch the displacement `x` counts from the
//! reversal in the direction of the motion, and the force has the sign of that direction, so that all branches
//! rise from about −T to about T. The slope e that is left at the end of a branch is taken off first.

use crate::data::Record;
use crate::effects::Features;
use crate::fit::predict::Motion;
use crate::fit::residual::reversals;

/// Part of a branch in which it slides, if it slides at all.
const SLIDING: std::ops::Range<f64> = 0.65..0.97;
/// Slope at the end over the mean slope of a branch above which it does not slide.
const STUCK: f64 = 0.6;

/// A loop as it was measured.
pub(in crate::diagnose) struct Measured<'r> {
    displacement: Vec<f64>,
    force: &'r [f64],
    load: Option<&'r [f64]>,
    /// Seconds between samples; mean, where they are uneven.
    step: f64,
}

impl<'r> Measured<'r> {
    /// Of `record`, if it has a displacement, a force and a time.
    pub fn of(record: &'r Record) -> Option<Self> {
        let column = |name: &str| record.channel(name).map(|channel| channel.values.as_slice());
        let displacement = column("displacement")?;
        let time = record.time()?;
        let step = (time.last()? - time.first()?) / time.len().saturating_sub(1).max(1) as f64;
        let displacement = match record.sample_step() {
            Some(step) => Motion::even(displacement, step).values,
            None => displacement.to_vec(),
        };
        Some(Self { displacement, force: column("force")?, load: column("normal_load"), step })
    }
}

/// A branch from one reversal to the next.
struct Branch {
    /// Direction, ±1.
    direction: f64,
    /// Seconds.
    duration: f64,
    /// Distance from the reversal (m), and force in the direction of the motion (N).
    x: Vec<f64>,
    force: Vec<f64>,
    /// Normal load (N), where it was measured.
    load: Vec<f64>,
}

/// Numbers of a branch that slides.
struct Slid {
    /// Limit reached (N).
    height: f64,
    /// Slope left in slip over that in stick.
    slope_fraction: f64,
    /// Fall of the slope from the lower to the upper part of the rise, as a fraction.
    corner_fraction: f64,
    /// Distance without force over the stroke.
    plateau_fraction: f64,
    /// Distance (m) to the begin of slip.
    stick: f64,
}

/// Fills what the loops of `records` show.
pub(in crate::diagnose) fn fill(records: &[Measured], found: &mut Features) {
    let branches: Vec<Vec<Branch>> = records.iter().map(branches).collect();
    let longest = branches.iter().flatten().map(Branch::stroke).fold(0.0, f64::max);
    let slid: Vec<Vec<(&Branch, Slid)>> = branches
        .iter()
        .map(|record| record.iter().filter_map(|branch| Some((branch, branch.slid()?))).collect())
        .collect();
    let all = || slid.iter().flatten();
    let long = || all().filter(|(branch, _)| branch.stroke() >= 0.5 * longest);
    found.plateau_fraction = median(all().map(|(_, slid)| slid.plateau_fraction).collect());
    found.slip_slope_fraction = median(long().map(|(_, slid)| slid.slope_fraction).collect());
    found.corner_fraction = median(long().map(|(_, slid)| slid.corner_fraction).collect());
    let heights: Vec<&(&Branch, Slid)> = all().collect();
    if let (Some(upper), Some(lower)) = (height(&heights, 1.0), height(&heights, -1.0)) {
        found.loop_asymmetry = Some((upper - lower) / (0.5 * (upper + lower)));
    }
    found.height_per_slip = height_per_slip(&slid);
    found.height_by_speed = height_by_speed(&slid);
    found.height_by_load = height_by_load(branches.iter().flatten().filter(|b| b.stroke() >= 0.5 * longest));
}

/// The branches of a record between reversals; what comes before the first and after the last is left out.
fn branches(measured: &Measured) -> Vec<Branch> {
    let turns = reversals(&measured.displacement);
    let branch = |pair: &[usize]| {
        let range = pair[0]..=pair[1];
        let start = measured.displacement[pair[0]];
        let direction = (measured.displacement[pair[1]] - start).signum();
        let x = measured.displacement[range.clone()].iter().map(|u| direction * (u - start)).collect();
        let force: Vec<f64> = measured.force[range.clone()].iter().map(|f| direction * f).collect();
        let half = force.len() / 80;
        Branch {
            direction,
            duration: (pair[1] - pair[0]) as f64 * measured.step,
            x,
            force: averaged(&force, half),
            load: measured.load.map_or(Vec::new(), |load| load[range].to_vec()),
        }
    };
    turns.windows(2).filter(|pair| pair[1] - pair[0] >= 16).map(branch).collect()
}

/// Means over `half` samples on either side.
fn averaged(values: &[f64], half: usize) -> Vec<f64> {
    (0..values.len())
        .map(|index| {
            let half = half.min(index).min(values.len() - 1 - index);
            let window = &values[index - half..=index + half];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

impl Branch {
    fn stroke(&self) -> f64 {
        self.x.last().copied().unwrap_or(0.0)
    }

    /// Indices of the samples in the sliding part.
    fn sliding(&self) -> impl Iterator<Item = usize> + '_ {
        let stroke = self.stroke();
        (0..self.x.len()).filter(move |i| SLIDING.contains(&(self.x[*i] / stroke)))
    }

    /// The numbers of the branch, if it slides at its end.
    fn slid(&self) -> Option<Slid> {
        let (stroke, last) = (self.stroke(), self.force.len() - 1);
        let (left, _) = line(self.sliding().map(|i| (self.x[i], self.force[i])))?;
        let slides = left < STUCK * (self.force[last] - self.force[0]) / stroke;
        let bare: Vec<f64> =
            self.x.iter().zip(&self.force).map(|(x, f)| f - left * (x - 0.5 * stroke)).collect();
        let count = self.sliding().count() as f64;
        let height = self.sliding().map(|i| bare[i]).sum::<f64>() / count;
        let (start, end) = (bare[0], height);
        if !slides || start >= 0.0 || end <= 0.0 {
            return None;
        }
        // Four levels: the rise below zero and the rise above it, each without its ends.
        let at = |level: f64| passage(&self.x, &bare, level);
        let (x1, x2, x3, x4) = (at(0.8 * start)?, at(0.2 * start)?, at(0.2 * end)?, at(0.8 * end)?);
        let (lower, upper) = ((x2 - x1) / (-0.6 * start), (x4 - x3) / (0.6 * end));
        if lower <= 0.0 || upper <= 0.0 || x4 > 0.9 * stroke {
            return None;
        }
        let crossing = 0.2 * 0.5 * ((end - start) * (lower + upper));
        Some(Slid {
            height,
            slope_fraction: left * lower / (1.0 + left * lower),
            corner_fraction: 1.0 - lower / upper,
            plateau_fraction: (x3 - x2 - crossing) / stroke,
            stick: (x4 + 0.2 * end * upper).min(stroke),
        })
    }
}

/// Where `values` first reach `level`, between samples.
fn passage(x: &[f64], values: &[f64], level: f64) -> Option<f64> {
    let index = values.iter().position(|value| *value >= level)?;
    if index == 0 {
        return Some(x[0]);
    }
    let (before, after) = (values[index - 1], values[index]);
    Some(x[index - 1] + (x[index] - x[index - 1]) * (level - before) / (after - before))
}

/// Slope and value at zero of the straight line through points.
fn line(points: impl Iterator<Item = (f64, f64)>) -> Option<(f64, f64)> {
    let (mut n, mut x, mut y, mut xx, mut xy) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (a, b) in points {
        n += 1.0;
        x += a;
        y += b;
        xx += a * a;
        xy += a * b;
    }
    let spread = n * xx - x * x;
    let slope = (n * xy - x * y) / spread;
    (n >= 3.0 && spread > 1e-12 * n * xx).then(|| (slope, (y - slope * x) / n))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        n if n % 2 == 1 => Some(values[middle]),
        _ => Some(0.5 * (values[middle - 1] + values[middle])),
    }
}

/// Median height of the branches of one direction.
fn height(branches: &[&(&Branch, Slid)], direction: f64) -> Option<f64> {
    let of_direction = branches.iter().filter(|(branch, _)| branch.direction == direction);
    median(of_direction.map(|(_, slid)| slid.height).collect())
}

/// Relative change of the height per metre of slip: the median of the records.
fn height_per_slip(records: &[Vec<(&Branch, Slid)>]) -> Option<f64> {
    let rate = |record: &Vec<(&Branch, Slid)>| {
        let mut travelled = 0.0;
        // The two directions one by one, so that a difference between them is no trend.
        let mut points: [Vec<(f64, f64)>; 2] = Default::default();
        for (branch, slid) in record {
            let slip = branch.stroke() - slid.stick;
            points[usize::from(branch.direction > 0.0)].push((travelled + 0.5 * slip, slid.height));
            travelled += slip;
        }
        let rates = points.iter().filter_map(|points| {
            let (slope, start) = line(points.iter().copied()).or_else(|| through_two(points))?;
            (start > 0.0).then_some(slope / start)
        });
        median(rates.collect())
    };
    median(records.iter().filter_map(rate).collect())
}

/// The line through two points.
fn through_two(points: &[(f64, f64)]) -> Option<(f64, f64)> {
    let [(a, f), (b, g)] = *points else { return None };
    let slope = (g - f) / (b - a);
    slope.is_finite().then_some((slope, f - slope * a))
}

/// Relative change of the height from the slowest to the fastest record, where one is twice as fast.
fn height_by_speed(records: &[Vec<(&Branch, Slid)>]) -> Option<f64> {
    let mut levels: Vec<(f64, f64)> = records
        .iter()
        .filter_map(|record| {
            let speed = median(record.iter().map(|(branch, _)| branch.stroke() / branch.duration).collect())?;
            let all: Vec<&(&Branch, Slid)> = record.iter().collect();
            Some((speed, 0.5 * (height(&all, 1.0)? + height(&all, -1.0)?)))
        })
        .collect();
    levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (slow, fast) = (levels.first()?, levels.last()?);
    (fast.0 > 2.0 * slow.0).then(|| fast.1 / slow.1 - 1.0)
}

/// Correlation of the force with the measured normal load over the ends of the branches.
fn height_by_load<'b>(branches: impl Iterator<Item = &'b Branch>) -> Option<f64> {
    let mut correlation = super::correlation::Correlation::default();
    for branch in branches.filter(|branch| !branch.load.is_empty()) {
        for i in branch.sliding() {
            correlation.add(branch.force[i], branch.load[i]);
        }
    }
    correlation.value()
}

#[cfg(test)]
#[path = "loops_tests.rs"]
mod tests;
