//! Free decays: a record without an excitation comes in, a table of frequency and damping over the amplitude goes out.
//!
//! `envelope` finds the vibration that is strongest over the noise, and where it begins to decay freely: at a release, after a
//! hammer's blow, when a shaker is shut off. `cut` cuts it into levels, windows in which the amplitude falls by a third.
//! In each `window` fits amplitude, frequency, damping and their slopes, with a weight that keeps other modes out. What a
//! model's own decay shows in windows as long about the same amplitudes is in `own`: whatever a window blurs, it blurs in both.

mod cut;
mod envelope;
mod own;
mod window;

pub(crate) use own::{Asked, OwnDecay, Start};

use std::f64::consts::TAU;

use crate::data::{Channel, Record, Regime};
use crate::fit::least_squares::student_quantile;
use crate::model::{Model, Structure};
use crate::vocabulary as v;

/// Fewest levels that make a table.
const FEWEST: usize = 3;
/// Where half of a two-sided 95 % interval ends.
const HALF_95: f64 = 0.975;

/// Cycles since the last reversal, in the mean.
const SINCE_REVERSAL: f64 = 0.25;

/// So much of a frequency's logarithmic rate ω'/ω is to be taken off the damping that an amplitude's fall shows. Energy falls by
/// `a E'(a) δ = ζ ω · m ω² a²`, and `E'` is not `m ω² a` where the stiffness depends on the amplitude. An elastic spring
/// stiffens upwards, by a half. Friction softens: at a reversal a contact holds `a T − ∫T` under its first loading `T(a)`, so
/// `E' = a (k + T')`, while `m ω² − k` is `T/a` and less: 2 where a few sliders slip, and 4/3 where a single one is far beyond
/// its limit (`m ω² − k ~ a^(−3/2)`, `T' = 0`). Between these two nothing is known of a contact.
const BY_A_SPRING: f64 = 0.5;
const BY_FRICTION: [f64; 2] = [4.0 / 3.0, 2.0];
/// Standard deviations of a normal number in such a half.
pub(crate) const NORMAL_95: f64 = 1.96;

/// A free decay, cut into levels.
#[derive(Debug, Clone, PartialEq)]
pub struct RingDown {
    /// Name of the record.
    pub record: String,
    /// The channel that shows the vibration best.
    pub channel: String,
    /// From the largest amplitude down.
    pub levels: Vec<Level>,
    /// Whether the levels are compared to those of a model's mode; else to those of its own decay, cut in the same way.
    pub as_mode: bool,
}

/// One level of a free decay.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Level {
    /// Middle of its window (s).
    pub time: f64,
    /// Length of its window (s).
    pub window: f64,
    /// Amplitude of the acceleration (m/s²).
    pub amplitude: f64,
    /// Frequency (Hz).
    pub frequency: f64,
    /// Half of its 95 % interval (Hz).
    pub frequency_interval: f64,
    /// Damping ratio (1).
    pub damping_ratio: f64,
    /// Half of its 95 % interval (1).
    pub damping_interval: f64,
}

/// Whether `record` is a free decay: nothing that excites a structure was measured.
pub fn is_ring_down(model: &Model, record: &Record) -> bool {
    record.regime == Regime::UnknownInitialState
        && model.structure != Structure::Prescribed
        && record.channels_of("excitation").next().is_none()
}

/// The levels of a free decay.
///
/// # Errors
/// Why it cannot be cut, for a reader of the comparison.
pub fn levels(record: &Record) -> Result<RingDown, String> {
    let step = record.even_step()?;
    let motion =
        |channel: &&Channel| ["acceleration", "velocity", "displacement"].contains(&channel.quantity());
    let seen = record.channels.iter().filter(motion);
    let seen = seen.filter_map(|channel| Some((channel, envelope::strongest(&channel.values)?)));
    let (channel, line) = seen
        .max_by(|a, b| a.1.above_noise.total_cmp(&b.1.above_noise))
        .ok_or("no column shows a vibration that stands out of the noise")?;
    let windows = cut::windows(&channel.values, line.cycles_per_sample)?;
    if windows.len() < FEWEST {
        return Err(format!(
            "the free decay gives {} of the {FEWEST} levels that make a table: record it for longer, from a larger \
             amplitude or with less noise",
            windows.len()
        ));
    }
    let first = record.time().and_then(|time| time.first()).copied().unwrap_or(0.0);
    let order = match channel.quantity() {
        "acceleration" => 2,
        "velocity" => 1,
        _ => 0,
    };
    let mut levels: Vec<Level> = windows.iter().map(|window| level(window, order, [first, step])).collect();
    unresolved(&mut levels);
    Ok(RingDown { record: record.name.clone(), channel: channel.name.clone(), levels, as_mode: false })
}

/// What a window of a channel that shows time derivative `order` of the displacement says of the vibration as that of a mode;
/// `first` and `step` are those of the time stamps (s).
///
/// With the displacement as the real part of `z`, `z' = μ z`, `μ = −δ + i ω`, and `z'' + 2 δₑ z' + ω₀² z = 0`:
/// `δₑ = δ − ω'/2ω` and `ω₀² = ω² + δ² + δ' − δ ω'/ω`; where friction changes ω it takes more off. A derivative of z is ahead of it by an angle that changes by `δ'/ω`, and
/// falls slower by `ω'/ω`.
fn level(window: &window::Fitted, order: i32, [first, step]: [f64; 2]) -> Level {
    let n = f64::from(order);
    let [turn, turn_error] = window.rate_slope.map(|slope| slope / window.speed);
    let [rise, rise_error] = window.speed_slope.map(|slope| slope / window.speed);
    let speed = window.speed - n * turn;
    let rate = window.rate + n * rise;
    let taken = if rise > 0.0 { 0.5 * (BY_FRICTION[0] + BY_FRICTION[1]) } else { BY_A_SPRING };
    let natural = (speed * speed + rate * rate + window.rate_slope[0] - rate * rise).sqrt();
    let half = student_quantile(HALF_95, window.freedom);
    let hertz = 1.0 / (step * TAU);
    Level {
        time: first + window.middle * step,
        window: window.length * step,
        amplitude: window.amplitude * (natural / step).powi(2 - order),
        frequency: natural * hertz,
        frequency_interval: half * window.speed_error.hypot(n * turn_error) * hertz,
        damping_ratio: (rate - taken * rise) / natural,
        damping_interval: half * window.rate_error.hypot((n - taken) * rise_error) / natural,
    }
}

/// Widens the intervals of `levels` by what changes in a quarter of a cycle, by the steepest way to a level beside: a friction
/// contact answers to the amplitude of its last reversal, which a table does not resolve.
fn unresolved(levels: &mut [Level]) {
    let steepest = |place: usize, value: fn(&Level) -> f64| {
        let here = &levels[place];
        let beside = [place.checked_sub(1), Some(place + 1)].into_iter().flatten();
        let slope = |other: &Level| ((value(other) - value(here)) / (other.time - here.time)).abs();
        beside.filter_map(|other| levels.get(other)).map(slope).fold(0.0, f64::max) * SINCE_REVERSAL
            / here.frequency
    };
    let changes: Vec<[f64; 2]> = (0..levels.len())
        .map(|place| [steepest(place, |level| level.frequency), steepest(place, |level| level.damping_ratio)])
        .collect();
    for (level, [frequency, damping]) in levels.iter_mut().zip(changes) {
        level.frequency_interval = level.frequency_interval.hypot(frequency);
        level.damping_interval = level.damping_interval.hypot(damping);
    }
}

impl RingDown {
    /// The same without the windows that its amplitudes were taken from, for a comparison to a mode and not to a decay. The intervals
    /// hold what is not known of a contact that changes the frequency. All levels of a decay then err alike: taken for
    /// independent ones they say no more than one does where each has the root of their number times as much.
    pub(crate) fn of_mode(mut self) -> Self {
        let levels = &self.levels;
        let alike = (levels.len() as f64).sqrt();
        let by = |place: usize| {
            let (before, after) =
                (&levels[place.saturating_sub(1)], &levels[(place + 1).min(levels.len() - 1)]);
            let rise = (after.frequency / before.frequency).ln() / (after.time - before.time);
            alike * 0.5 * (BY_FRICTION[1] - BY_FRICTION[0]) * rise.max(0.0) / (TAU * levels[place].frequency)
        };
        let by: Vec<f64> = (0..levels.len()).map(by).collect();
        for (level, by) in self.levels.iter_mut().zip(by) {
            level.damping_interval = level.damping_interval.hypot(by);
        }
        self.as_mode = true;
        self
    }

    /// The levels as a backbone table in the place of `record`.
    pub(crate) fn table(&self, record: &Record) -> Record {
        let place = self.channel.split_once(':').map_or(String::new(), |(_, place)| format!(":{place}"));
        let column = |name: String, unit, value: fn(&Level) -> f64, interval: Option<fn(&Level) -> f64>| {
            let squares = |half: fn(&Level) -> f64| {
                let sum: f64 = self.levels.iter().map(|level| (half(level) / NORMAL_95).powi(2)).sum();
                (sum / self.levels.len() as f64).sqrt()
            };
            let values = self.levels.iter().map(value).collect();
            Channel { name, unit, values, noise: interval.map(squares) }
        };
        let mut channels = vec![
            column(format!("{}{place}", v::AMPLITUDE.name), v::AMPLITUDE.unit, |level| level.amplitude, None),
            column(
                v::FREQUENCY.name.to_owned(),
                v::FREQUENCY.unit,
                |level| level.frequency,
                Some(|level| level.frequency_interval),
            ),
            column(
                v::DAMPING_RATIO.name.to_owned(),
                v::DAMPING_RATIO.unit,
                |level| level.damping_ratio,
                Some(|level| level.damping_interval),
            ),
            column(
                v::FREQUENCY_INTERVAL.name.to_owned(),
                v::FREQUENCY_INTERVAL.unit,
                |level| level.frequency_interval,
                None,
            ),
            column(
                v::DAMPING_INTERVAL.name.to_owned(),
                v::DAMPING_INTERVAL.unit,
                |level| level.damping_interval,
                None,
            ),
        ];
        if !self.as_mode {
            channels.push(column(v::WINDOW.name.to_owned(), v::WINDOW.unit, |level| level.window, None));
        }
        Record { regime: Regime::Backbone, channels, ..record.clone() }
    }
}
