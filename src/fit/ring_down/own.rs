//! What a model's own free decay shows at the amplitudes at which a measured one was cut.

use std::f64::consts::TAU;

use super::level;
use super::window::{Fitted, Window};

/// Samples in a period of the vibration: a window's fit takes no notice of more.
const PER_PERIOD: f64 = 20.0;
/// A running decay starts above the amplitude at which the first window begins by this factor: it may fall faster than the measured
/// one, and the first window is to show nothing of how it was begun.
const ABOVE: f64 = 1.5;
/// Longest decay over all windows one after the other, and one more for what is above them. Measured windows lie 0.7 of one apart.
const LONGEST: f64 = 1.25;
/// Rounds in which the moment of an amplitude is found, each squaring the error of the one before, and what is left of it, as
/// a fraction of the amplitude.
const ROUNDS: usize = 12;
const FOUND: f64 = 1e-9;

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
#[derive(Debug)]
pub(crate) struct OwnDecay {
    /// From the largest amplitude down.
    rows: Vec<Asked>,
    /// Amplitude of the acceleration (m/s²) where the first window begins, and the logarithm of what a cycle takes of it.
    first: f64,
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
        let samples = |time: f64| (time / step).ceil() as usize;
        let damping = first.damping_ratio.max(0.0);
        Some(Self {
            first: first.amplitude * (0.5 * damping * first.angular_frequency * first.window).exp(),
            fall: TAU * damping,
            step,
            most: samples(LONGEST * rows.iter().map(|row| row.window).sum::<f64>() + first.window),
            last: (last.amplitude, samples(0.5 * last.window) + samples(TAU / last.angular_frequency)),
            samples: Vec::new(),
            above: 0,
            rows,
        })
    }

    /// Displacement (m) and velocity (m/s) with which a vibration of `speed` (rad/s) begins.
    pub fn begins(&self, start: Start, speed: f64) -> [f64; 2] {
        match start {
            Start::Running { cycles } => [0.0, ABOVE * self.first * (self.fall * cycles).exp() / speed],
            Start::Released { cycles } => [self.first * (self.fall * cycles).exp() / speed.powi(2), 0.0],
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

    /// Frequency (Hz) and damping ratio in each row, where `speed` (rad/s) is about that of the first samples. An amplitude that the
    /// decay does not have long enough gives what is nearest to it.
    pub fn shown(&self, speed: f64) -> Option<Vec<[f64; 2]>> {
        let mut guess = [speed * self.step, 0.0, 0.0];
        let mut middle = 0.0;
        let mut shown = vec![[0.0; 2]; self.rows.len()];
        for row in &self.rows {
            let half = (0.5 * row.window / self.step).min(0.5 * self.samples.len() as f64 - 1.0);
            let fitted = self.about(row.amplitude, half, middle, guess)?;
            guess = [fitted.speed, fitted.speed_slope[0], fitted.rate];
            middle = fitted.middle;
            let level = level(&fitted, 2, [0.0, self.step]);
            shown[row.place] = [level.frequency, level.damping_ratio];
        }
        Some(shown)
    }

    /// The window of half the length `half` with this amplitude in its middle, looked for from `middle` on.
    fn about(&self, amplitude: f64, half: f64, middle: f64, mut guess: [f64; 3]) -> Option<Fitted> {
        let last = self.samples.len() as f64 - 1.0 - half;
        let mut middle = middle.clamp(half, last.max(half));
        let mut round = 0;
        loop {
            let fitted = Window::around(&self.samples, middle, half).fit_exact(guess)?;
            guess = [fitted.speed, fitted.speed_slope[0], fitted.rate];
            let above = (fitted.amplitude / amplitude).ln();
            // No farther than half a window at once: slopes reach no farther.
            let ahead = if above.abs() > FOUND * half * fitted.rate.abs() {
                (above / fitted.rate).clamp(-half, half)
            } else {
                0.0
            };
            let next = (middle + ahead).clamp(half, last.max(half));
            round += 1;
            if next == middle || round == ROUNDS || above.abs() < FOUND {
                return Some(fitted);
            }
            middle = next;
        }
    }
}
