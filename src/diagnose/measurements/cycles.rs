//! Noise from what a motion repeats: all of it, or the cycles while its level is held between ramps.

use super::seen::Seen;
use super::tone;
use crate::data::{Channel, Record};
use crate::fit::predict::{Motion, period};

/// Two motions are one when they differ by less than this fraction of their size.
pub(super) const SAME: f64 = 0.01;

/// The channel that drives a record: the displacement of a contact, the first excitation of a structure.
pub(in crate::diagnose) fn driver(record: &Record) -> Option<&Channel> {
    let named = |name: &str| record.channels.iter().find(|channel| channel.quantity() == name);
    named("excitation").or_else(|| named("displacement")).or_else(|| named("amplitude"))
}

/// A motion that repeats.
pub(super) struct Cycles {
    /// In samples, not always whole.
    period: f64,
    /// Where it repeats, per sample, if not everywhere.
    held: Option<Vec<bool>>,
}

/// A record is searched for a level that is held in windows of it, down to this fraction of its length.
const SHORTEST: usize = 8;

impl Cycles {
    /// Of what drives a record. A structure goes on swinging when its excitation repeats already; a contact remembers no
    /// longer than a period.
    pub fn of(drive: &Channel) -> Option<Self> {
        let values = &drive.values;
        if let Some(period) = period(values) {
            return Some(Self { period, held: None });
        }
        if drive.quantity() != "displacement" {
            return None;
        }
        let windows = (2..=SHORTEST).flat_map(|parts| {
            let length = values.len() / parts;
            (0..2 * parts - 1).map(move |k| k * length / 2..k * length / 2 + length)
        });
        let periods = windows.filter_map(|window| period(&values[window]));
        let found = periods.map(|period| (period, held(values, period)));
        let most = |(_, held): &(f64, Vec<bool>)| held.iter().filter(|held| **held).count();
        let (period, held) = found.max_by_key(most)?;
        // Differences of fewer samples tell no noise.
        let enough = held.iter().filter(|held| **held).count() as f64 > 0.5 * period;
        enough.then_some(Self { period, held: Some(held) })
    }

    /// Whole samples of a period.
    pub fn lag(&self) -> usize {
        self.period.round() as usize
    }

    fn is_held(&self, index: usize) -> bool {
        self.held.as_ref().is_none_or(|held| held[index])
    }

    /// Whether the other inputs of `record` repeat with the drive: a normal load that swings at its own frequency makes
    /// periods differ that are no noise.
    pub fn inputs_repeat(&self, record: &Record) -> bool {
        let driving = driver(record).map(|drive| drive.name.as_str());
        let is = |c: &&Channel| c.name.starts_with("normal_") || c.quantity() == "excitation";
        let others = record.channels.iter().filter(is).filter(|c| Some(c.name.as_str()) != driving);
        others.into_iter().all(|channel| {
            let motion = Motion::even(&channel.values, 1.0).values;
            let lag = self.lag();
            let mean = motion.iter().sum::<f64>() / motion.len() as f64;
            let variance = motion.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / motion.len() as f64;
            let held = (lag..motion.len()).filter(|i| self.is_held(*i));
            let (sum, count) = held
                .map(|i| (motion[i] - motion[i - lag]).powi(2))
                .fold((0.0, 0), |(sum, count), square| (sum + square, count + 1));
            // What hardly varies at all varies by its noise.
            sum / f64::from(count.max(1)) < 0.02 * variance || variance < 1e-3 * mean * mean
        })
    }

    /// Differences of `values` from those a whole number of samples earlier, where the motion repeats.
    pub fn apart(&self, values: &[f64]) -> Vec<f64> {
        let lag = self.lag();
        (lag..values.len()).filter(|i| self.is_held(*i)).map(|i| values[i] - values[i - lag]).collect()
    }

    /// The standard deviation of what differs between periods, with its standard error. A drift that is linear over three
    /// periods (wear) is taken off where it shows, and so is a tone.
    pub fn noise(&self, values: &[f64]) -> Option<Seen> {
        let (period, lag) = (self.period, self.period.floor() as usize);
        if (values.len() as f64) < 1.5 * period || lag == 0 {
            return None;
        }
        let once = |i: usize| self.is_held(i).then(|| values[i] - earlier(values, i, period));
        let twice = |i: usize| {
            let bend = values[i] - 2.0 * earlier(values, i, period) + earlier(values, i, 2.0 * period);
            (self.is_held(i) && self.is_held(i - lag)).then_some(bend)
        };
        let first = lag + 1;
        let second = (2.0 * period).ceil() as usize + 1;
        let [one, two] = [1.0, 2.0].map(|periods| Between::samples(periods * period));
        let over = |from: usize| {
            let differences: Vec<f64> = (from..values.len()).filter_map(once).collect();
            (differences.len() > lag / 2).then(|| one.variance(&differences))
        };
        // Later periods have forgotten the start; second differences do not see a drift.
        let mut variance = over(first)?;
        // Of two periods alone the first remembers how it began, which the second half of it hardly does.
        if self.held.is_none()
            && over(second).is_none()
            && let Some(late) = over(values.len().saturating_sub(lag / 2 + 1))
            && late < FORGOTTEN * variance
        {
            variance = late;
        }
        let bends: Vec<f64> = (second..values.len()).filter_map(twice).collect();
        let bends = (bends.len() > lag / 2).then(|| Between::bend(&one, &two).variance(&bends));
        let [mut log_error, bent] = self.log_errors(values);
        let bent = if bent > 0.0 { bent } else { log_error };
        // A drift has a memory that the noise has not.
        let least = log_error.min(bent);
        let late = (values.len() as f64 / period - BEGINNING).max(0.3).sqrt().recip();
        for (other, scatter) in [(over(second), late), (bends, late.max(BENT))] {
            let less = (-2.0 * NO_CHANCE * scatter * least).exp() * variance;
            if let Some(other) = other.filter(|other| *other < less) {
                (variance, log_error) = (other, bent);
            }
        }
        // What repeats at another frequency is no noise; what memory the rest has is hidden by it.
        for from in [first, second] {
            let apart: Vec<f64> = (from..values.len()).filter_map(once).collect();
            if let Some(beside) = tone::variance_beside(&apart).filter(|_| self.held.is_none()) {
                variance = variance.min(beside / (1.0 + one.squares));
            }
        }
        let is_noise = variance > 0.0 && variance.is_finite();
        is_noise.then(|| Seen { deviation: variance.sqrt(), log_error })
    }

    /// Standard errors of the logarithm of a standard deviation by differences a period apart, and by those of these. Of many
    /// periods every value is in several of them, which are alike by a half, or by two thirds and a sixth.
    fn log_errors(&self, values: &[f64]) -> [f64; 2] {
        let (periods, lag) = (values.len() as f64 / self.period, self.lag());
        let shared = |taken: f64| ((periods - taken - 1.0) / (periods - taken)).max(0.0);
        let bend = |i: usize| values[i] - 2.0 * values[i - lag] + values[i - 2 * lag];
        let held = |i: &usize| self.is_held(*i) && self.is_held(*i - lag);
        let bends: Vec<f64> = (2 * lag..values.len()).filter(held).map(bend).collect();
        [(self.apart(values), 1.0 + 0.5 * shared(1.0)), (bends, 1.0 + 0.94 * shared(2.0))]
            .map(|(differences, alike)| Seen::of(0.0, &differences, lag).log_error * alike.sqrt())
    }
}

/// What values that lie between samples, the mean of two each, add to the variance of a difference from them.
struct Between {
    /// By the variance of the samples, and by the covariance of neighbours, twice.
    squares: f64,
    products: f64,
}

impl Between {
    /// One value some samples `back`.
    fn samples(back: f64) -> Self {
        let part = back.fract();
        Self { squares: (1.0 - part).powi(2) + part * part, products: part * (1.0 - part) }
    }

    /// Twice one value, less another.
    fn bend(one: &Self, two: &Self) -> Self {
        Self { squares: 4.0 * one.squares + two.squares, products: 4.0 * one.products + two.products }
    }

    /// Variance of the noise of which `differences` are made: that of a difference is `σ² (1 + q + 2 s ρ)`.
    fn variance(&self, differences: &[f64]) -> f64 {
        let square = differences.iter().map(|x| x * x).sum::<f64>() / differences.len() as f64;
        square / (1.0 + self.squares + 2.0 * self.products * self.memory(differences))
    }

    /// Correlation ρ of that noise from a sample to the next, at least 0. That of `differences` is
    /// `(ρ (1 + q) + s (1 + ρ²)) / (1 + q + 2 s ρ)` where the correlation of the noise falls as a power.
    fn memory(&self, differences: &[f64]) -> f64 {
        let Self { squares: q, products: s } = self;
        let product: f64 = differences.windows(2).map(|pair| pair[0] * pair[1]).sum();
        let square: f64 = differences.iter().map(|x| x * x).sum();
        let seen = if square > 0.0 { product / square } else { 0.0 };
        let (b, c) = (1.0 + q - 2.0 * s * seen, s - seen * (1.0 + q));
        let root = (b * b - 4.0 * s * c).max(0.0).sqrt();
        (-2.0 * c / (b + root)).clamp(0.0, 1.0)
    }
}

/// Standard deviations by which the noise of other differences of the same samples is less that is less by no chance.
const NO_CHANCE: f64 = 2.5;
/// How far the noise by the differences of later periods and that by all scatter about each other, as a part of their
/// standard error: one over the root of the periods beyond this many. Second differences scatter as far, and by many periods
/// this part. So it is in noise with any memory.
const BEGINNING: f64 = 1.8;
const BENT: f64 = 0.5;

/// Fraction of a variance between two periods below which that of their second halves tells that the start was still felt
/// in the first: chance does not make so much of half a period.
const FORGOTTEN: f64 = 0.25;

/// The value `back` samples before another; between two samples noise is averaged.
fn earlier(values: &[f64], index: usize, back: f64) -> f64 {
    let (whole, part) = (back.floor() as usize, back.fract());
    let near = values[index - whole];
    if part > 1e-9 && index > whole { (1.0 - part) * near + part * values[index - whole - 1] } else { near }
}

/// Where `values` have been the same as a `period` before, for a whole period.
fn held(values: &[f64], period: f64) -> Vec<bool> {
    let lag = period.round() as usize;
    let first = period.ceil() as usize + 1;
    let (mut sum, mut squares, mut apart) = (0.0, 0.0, 0.0);
    let change = |i: usize| (values[i] - earlier(values, i, period)).powi(2);
    let mut held = vec![false; values.len()];
    for i in first..values.len() {
        apart += change(i);
        sum += values[i];
        squares += values[i] * values[i];
        if i >= first + lag {
            apart -= change(i - lag);
            sum -= values[i - lag];
            squares -= values[i - lag] * values[i - lag];
            let size = squares - sum * sum / lag as f64;
            held[i] = apart < SAME * SAME * size;
        }
    }
    held
}

#[cfg(test)]
mod tests {
    use super::super::seen::samples::{coloured, normal};
    use super::*;
    use std::f64::consts::TAU;

    const DEVIATION: f64 = 0.01;

    fn everywhere(period: f64) -> Cycles {
        Cycles { period, held: None }
    }

    /// Two periods of a sine with white noise, on which `start` lies.
    fn two_periods(start: impl Fn(f64) -> f64) -> Vec<f64> {
        let mut noise = normal(7);
        let value = |i: usize| (std::f64::consts::TAU * i as f64 / 600.0).sin() + start(i as f64 / 600.0);
        (0..1200).map(|i| value(i) + DEVIATION * noise()).collect()
    }

    /// Two periods' difference is the noise, and the start that the first one still remembers is not.
    #[test]
    fn of_two_periods_the_start_of_the_first_is_no_noise() {
        for start in [0.0, 0.1, 1.0] {
            let values = two_periods(|periods| if periods < 0.4 { start } else { 0.0 });
            let found = everywhere(600.0).noise(&values).unwrap().deviation;
            assert!((found / DEVIATION - 1.0).abs() < 0.1, "a start of {start}: {found}");
        }
        // A difference that lasts is none of the start.
        let found = everywhere(600.0).noise(&two_periods(|periods| if periods < 1.0 { 0.1 } else { 0.0 }));
        let found = found.unwrap().deviation;
        assert!(found > 3.0 * DEVIATION, "{found}");
    }

    /// A slider that is moved to and fro in two ramps, each with its level held afterwards, with noise that has a memory
    /// beside the force, which grows by a fraction `drift` per period: what moves it, and the force.
    fn ramped(seed: u64, memory: f64, drift: f64) -> (Channel, Vec<f64>) {
        let mut uniform = fastrand::Rng::with_seed(seed + 100).fork();
        let (part, phase) = (0.4 + 0.3 * uniform.f64(), TAU * uniform.f64());
        let (mut noise, mut last, mut slider) = (normal(seed), 0.0, 0.0);
        let place = |i: i32| {
            let t = f64::from(i) / 140.0;
            (part * t.min(1.0) + (1.0 - part) * (t - 4.0).clamp(0.0, 1.0)) * (TAU * t + phase).sin()
        };
        let mut force = |i: i32| {
            slider = f64::clamp(slider, place(i) - 0.3, place(i) + 0.3);
            last = memory * last + (1.0 - memory * memory).sqrt() * noise();
            (place(i) - slider) * (1.0 + drift * f64::from(i) / 140.0) + DEVIATION * last
        };
        let values = (0..1260).map(|i| place(i) + 1e-4 * f64::from(i % 7 - 3)).collect();
        let drive = Channel { name: "displacement".into(), unit: "m", values, noise: None };
        (drive, (0..1260).map(&mut force).collect())
    }

    /// The noise of cycles held between ramps is found to within its own standard error, with a memory or without one, and
    /// no drift is taken for noise.
    #[test]
    fn cycles_that_are_held_between_ramps_tell_the_noise() {
        for (memory, drift) in [(0.0, 0.0), (0.8, 0.0), (0.0, 0.03), (0.8, 0.03)] {
            let square = |seed: u64| {
                let (drive, force) = ramped(seed, memory, drift);
                let cycles = Cycles::of(&drive).unwrap();
                assert_eq!(cycles.lag(), 140);
                let seen = cycles.noise(&force).unwrap();
                ((seen.deviation / DEVIATION).ln() / seen.log_error).powi(2)
            };
            let off = ((0..60).map(square).sum::<f64>() / 60.0).sqrt();
            assert!((0.5..1.5).contains(&off), "memory {memory}, drift {drift}: {off} standard errors");
        }
    }

    /// A drift has a memory, and the noise beside it has none.
    #[test]
    fn beside_a_drift_noise_between_samples_is_told_as_it_is() {
        let told = |seed: u64| {
            let mut noise = normal(seed);
            let drift = |i: usize| 0.02 * i as f64 * (TAU * i as f64 / 64.5).sin();
            let values: Vec<f64> = (0..512).map(|i| drift(i) + noise()).collect();
            everywhere(64.5).noise(&values).unwrap().deviation.powi(2)
        };
        let square = (0..200).map(told).sum::<f64>() / 200.0;
        assert!((square - 1.0).abs() < 0.05, "{square}");
    }

    /// Whatever its memory and whether a period is whole samples or not, the square of the noise that is told is right on
    /// average, and its standard error is its scatter.
    #[test]
    fn noise_with_a_memory_is_neither_too_small_nor_too_large_on_average() {
        const RECORDS: u64 = 300;
        for (memory, period) in
            [0.0, 0.8, 0.95].into_iter().flat_map(|m| [64.3, 128.0, 199.6].map(|p| (m, p)))
        {
            let told = |seed: u64| {
                let values = coloured(seed, memory, 512);
                everywhere(period).noise(&values).unwrap()
            };
            let seen: Vec<Seen> = (0..RECORDS).map(told).collect();
            let mean = |of: &dyn Fn(&Seen) -> f64| seen.iter().map(of).sum::<f64>() / RECORDS as f64;
            let square = mean(&|seen| seen.deviation.powi(2));
            let centre = mean(&|seen| seen.deviation.ln());
            let scatter = mean(&|seen| (seen.deviation.ln() - centre).powi(2)).sqrt();
            let error = mean(&|seen| seen.log_error.powi(2)).sqrt();
            let chance = 2.0 * scatter / (RECORDS as f64).sqrt();
            assert!((square - 1.0).abs() < 0.02 + 3.0 * chance, "{memory}, {period}: a square of {square}");
            assert!((error / scatter - 1.0).abs() < 0.25, "{memory}, {period}: {error} for {scatter}");
        }
    }

    #[test]
    fn where_no_level_is_held_nothing_repeats() {
        let grown = |of: fn(f64) -> f64| Channel {
            name: "displacement".into(),
            unit: "m",
            values: (0..1260).map(|i| of(f64::from(i) / 140.0)).collect(),
            noise: None,
        };
        assert!(Cycles::of(&grown(|t| t * (TAU * t).sin())).is_none());
        assert!(Cycles::of(&grown(|t| (TAU * t * (1.0 + 0.2 * t)).sin())).is_none());
    }
}
