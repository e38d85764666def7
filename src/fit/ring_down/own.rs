//! What a model's own free decay shows at the amplitudes at which a measured one was cut.

use std::f64::consts::TAU;

use super::cut::windows;
use super::envelope::strongest;
use super::level;
use super::window::{Fitted, Window};

/// Samples in a period of the vibration: a window's fit takes no notice of more.
const PER_PERIOD: f64 = 20.0;
/// A running decay starts above the amplitude at which the first window begins by this factor: it may fall faster than the measured
/// one, and the first window is to show nothing of how it was begun.
const ABOVE: f64 = 1.5;
/// Largest fall of the logarithm of the amplitude from the beginning of the first window to its middle that counts.
const MOST_FALL: f64 = 1.0;
/// Times that a decay may last as long as the measured one before it is given up, and most samples.
const SLOWER: f64 = 2.0;
const MOST_SAMPLES: usize = 1_000_000;
/// Fewest cycles of a window: its fit has seven unknowns.
const FEWEST_CYCLES: f64 = 3.0;
/// Rounds in which the moment of an amplitude is found, each squaring the error of the one before, and the error that
/// ends them, as a fraction of the amplitude.
const ROUNDS: usize = 12;
const FOUND: f64 = 1e-9;
/// Largest error at the end, and how much the frequency may differ from that of the windows about: else another vibration was taken.
const REACHED: f64 = 1e-3;
const SAME: f64 = 0.2;
/// Windows of the model's decay are at least as long, but for this factor, as the measured ones.
const LONGER: f64 = 1.5;

/// A row of a measured table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Asked {
    /// Which row it is.
    pub place: usize,
    /// Amplitude of the acceleration (m/s²) in the middle of the window.
    pub amplitude: f64,
    /// Length of the window (s).
    pub window: f64,
    /// Measured frequency (rad/s).
    pub angular_frequency: f64,
    /// Measured damping ratio (1).
    pub damping_ratio: f64,
}

/// How a decay begins, higher by what it loses in so many cycles.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Start {
    /// Where the structure rests, at a velocity, above the first window.
    Running { cycles: f64 },
    /// Held aside and let go, where the first window begins.
    Released { cycles: f64 },
}

/// The decay of a model that answers to the rows of a table.
#[derive(Debug, Clone)]
pub(crate) struct OwnDecay {
    /// From the largest amplitude down.
    rows: Vec<Asked>,
    /// Amplitude of the acceleration (m/s²) where the first window begins, its frequency (rad/s), and the logarithm of what a cycle
    /// takes of it.
    first: f64,
    speed: f64,
    fall: f64,
    /// Time between two samples (s).
    pub step: f64,
    /// Most samples.
    most: usize,
    /// Amplitude (m/s²) below which as many samples more are enough.
    last: (f64, usize),
    /// Accelerations (m/s²).
    samples: Vec<f64>,
    /// How many there were when one was last above that amplitude.
    above: usize,
}

impl OwnDecay {
    /// For the rows of a table, if it has any.
    pub fn of(rows: impl Iterator<Item = Asked>) -> Option<Self> {
        let mut rows: Vec<Asked> = rows.collect();
        rows.sort_by(|a, b| b.amplitude.total_cmp(&a.amplitude));
        let (first, last) = (*rows.first()?, *rows.last()?);
        let fastest = rows.iter().map(|row| row.angular_frequency).fold(0.0, f64::max);
        let step = TAU / fastest / PER_PERIOD;
        let samples = |time: f64| ((time / step).ceil() as usize).min(MOST_SAMPLES);
        let damping = first.damping_ratio.max(0.0);
        let fallen = 0.5 * damping * first.angular_frequency * first.window;
        // Rows may have been left out of the table.
        let between = |pair: &[Asked]| {
            let rate = |row: &Asked| row.damping_ratio * row.angular_frequency;
            let slower = rate(&pair[0]).min(rate(&pair[1]));
            let fall = (pair[0].amplitude / pair[1].amplitude).ln();
            pair[0].window.max(if slower > 0.0 { fall / slower } else { 0.0 })
        };
        let lasted = rows.windows(2).map(between).sum::<f64>() + 2.0 * first.window + last.window;
        Some(Self {
            first: first.amplitude * fallen.min(MOST_FALL).exp(),
            speed: first.angular_frequency,
            fall: TAU * damping,
            step,
            most: samples(SLOWER * lasted),
            last: (last.amplitude, samples(0.5 * last.window) + samples(TAU / last.angular_frequency)),
            samples: Vec::new(),
            above: 0,
            rows,
        })
    }

    /// Displacement (m) and velocity (m/s) with which the decay begins.
    pub fn begins(&self, start: Start) -> [f64; 2] {
        match start {
            Start::Running { cycles } => [0.0, ABOVE * self.first * (self.fall * cycles).exp() / self.speed],
            Start::Released { cycles } => [self.first * (self.fall * cycles).exp() / self.speed.powi(2), 0.0],
        }
    }

    /// Begins with no samples.
    pub fn clear(&mut self) {
        self.samples.clear();
        self.above = 0;
    }

    /// Takes the next sample of the acceleration (m/s²); whether more are needed.
    pub fn push(&mut self, acceleration: f64) -> bool {
        let (amplitude, enough) = self.last;
        self.samples.push(acceleration);
        if acceleration.abs() > amplitude {
            self.above = self.samples.len();
        }
        self.samples.len() < self.most && self.samples.len() <= self.above + enough
    }

    /// Frequency (Hz) and damping ratio in each row of the table, from whose amplitude the decay shows a window as long.
    pub fn shown(&self) -> Vec<Option<[f64; 2]>> {
        let mut shown = vec![None; self.rows.len()];
        let line = strongest(&self.samples);
        let windows = line.and_then(|line| windows(&self.samples, line.cycles_per_sample).ok());
        let windows = windows.unwrap_or_default();
        for row in self.rows.iter().filter(|row| row.window * row.angular_frequency >= FEWEST_CYCLES * TAU) {
            let found = guess(&windows, row.amplitude).and_then(|near| self.about(row, &near));
            let level = found.map(|fitted| level(&fitted, 2, [0.0, self.step]));
            shown[row.place] = level.map(|level| [level.frequency, level.damping_ratio]);
        }
        shown
    }

    /// The window of `row` with its amplitude in the middle, from a guess of what it shows.
    fn about(&self, row: &Asked, near: &Fitted) -> Option<Fitted> {
        let half = 0.5 * row.window / self.step;
        // Where the model's amplitude falls much faster, as while a slider slips that sticks in the measurement, its decay has none like it.
        if 2.0 * half > LONGER * near.length {
            return None;
        }
        let inside = half..=self.samples.len() as f64 - 1.0 - half;
        let mut middle = near.middle;
        let mut guess = [near.speed, near.speed_slope[0], near.rate];
        for _ in 0..ROUNDS {
            // Nearer to an end it would be another window.
            if !inside.contains(&middle) {
                return None;
            }
            let fitted = Window::around(&self.samples, middle, half).fit_exact(guess)?;
            guess = [fitted.speed, fitted.speed_slope[0], fitted.rate];
            let above = (fitted.amplitude / row.amplitude).ln();
            if above.abs() < FOUND {
                break;
            }
            // No farther than half a window at once: slopes reach no farther.
            middle += (above / fitted.rate).clamp(-half, half);
        }
        let fitted = Window::around(&self.samples, middle, half).fit_exact(guess)?;
        let same = (fitted.speed / near.speed - 1.0).abs() < SAME;
        let reached = (fitted.amplitude / row.amplitude).ln().abs() < REACHED;
        (inside.contains(&middle) && same && reached).then_some(fitted)
    }
}

/// What `windows`, one after the other, tell of one with `amplitude` in its middle.
fn guess(windows: &[Fitted], amplitude: f64) -> Option<Fitted> {
    let after = windows.iter().position(|window| window.amplitude <= amplitude);
    let beside = match after {
        Some(after) => &windows[after.saturating_sub(1)..=after],
        None => windows.last().map(std::slice::from_ref)?,
    };
    let ahead = |window: &Fitted| (window.amplitude / amplitude).ln() / window.rate;
    let [before, after] = beside else {
        let only = &beside[0];
        return Some(Fitted { middle: only.middle + ahead(only), ..*only });
    };
    let part = (before.amplitude / amplitude).ln() / (before.amplitude / after.amplitude).ln();
    let between = |of: fn(&Fitted) -> f64| of(before) + part * (of(after) - of(before));
    // What is above the beginning of the one after belongs to the one before.
    let begins = after.amplitude * (0.5 * after.rate * after.length).exp();
    let length = if amplitude > begins { before.length } else { before.length.max(after.length) };
    let [middle, speed, rate] =
        [between(|window| window.middle), between(|window| window.speed), between(|window| window.rate)];
    Some(Fitted { middle, speed, rate, length, ..*before })
}
