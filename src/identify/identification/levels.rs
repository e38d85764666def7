//! The resonance at each amplitude: its frequency, its damping and the rotational stiffness that stands for the contact.

use std::f64::consts::{FRAC_PI_2, TAU};

use nalgebra::Complex;

use super::{LinearRecord, Setup};
use crate::data::Record;
use crate::fit::Interval;
use crate::identify::resonance_of;
use crate::identify::steady::Steady;
use crate::system::rotational_stiffness_from_frequency;

/// Amplitudes of one level differ by this part at most.
const SAME_LEVEL: f64 = 0.05;
/// Frequencies of a level about one resonance lie within this part of their mean.
const NEAR: f64 = 0.1;
/// Frequencies from which a resonance is fitted.
const POINTS: usize = 4;
/// Steps of a fitted curve.
const CURVE: usize = 100;
/// A single record counts as a resonance up to this phase (rad) off.
const OFF_RESONANCE: f64 = 10.0 * TAU / 360.0;

/// How a resonance was found.
#[derive(Debug, Clone, PartialEq)]
pub enum LevelSource {
    /// Frequency responses under random excitation.
    Random,
    /// Steady records of one amplitude at several frequencies.
    Stepped(Vec<String>),
    /// One steady record, its phase off a resonance by so much (rad).
    Single(String, f64),
    /// A row of a table.
    Table(String),
}

/// The resonance at an amplitude.
#[derive(Debug, Clone, PartialEq)]
pub struct Level {
    /// How it was found.
    pub source: LevelSource,
    /// Amplitude of the acceleration at the excitation (m/s²); 0 for the linear beam.
    pub amplitude: f64,
    /// Natural frequency (Hz).
    pub frequency: f64,
    /// Its 95 % interval, where it is told.
    pub frequency_interval: Option<Interval>,
    /// Damping ratio (1), where it is told.
    pub damping_ratio: Option<f64>,
    /// Acceleration over force at the resonance (1/kg), where it is told.
    pub peak: Option<f64>,
    /// The frequency response that it was fitted to, where there is one.
    pub response: Option<LevelResponse>,
    /// Rotational stiffness at the end (N m/rad) that gives the beam this frequency, or why none does.
    pub rotational_stiffness: Result<f64, String>,
}

/// Magnitudes of acceleration over force (1/kg) under held response.
#[derive(Debug, Clone, PartialEq)]
pub struct LevelResponse {
    /// Frequencies (Hz) and what was measured there.
    pub measured: Vec<[f64; 2]>,
    /// The fitted resonance over the same band.
    pub fitted: Vec<[f64; 2]>,
}

impl Level {
    fn new(setup: &Setup, source: LevelSource, amplitude: f64, frequency: f64) -> Self {
        let beam = setup.beam.changed(&setup.changes);
        let rotational_stiffness = beam
            .and_then(|beam| rotational_stiffness_from_frequency(&beam, frequency))
            .map_err(|error| error.to_string());
        Self {
            source,
            amplitude,
            frequency,
            frequency_interval: None,
            damping_ratio: None,
            peak: None,
            response: None,
            rotational_stiffness,
        }
    }
}

/// Resonances of steady records, and of each level the record that the contact is identified from: of a stepped sine the one
/// nearest to the resonance.
pub(super) fn of_records(
    setup: &Setup,
    records: Vec<Steady>,
    skipped: &mut Vec<(String, String)>,
) -> (Vec<Level>, Vec<Steady>) {
    let order: Vec<String> = records.iter().map(|record| record.name.clone()).collect();
    let (mut levels, mut chosen) = (Vec::new(), Vec::new());
    for group in grouped(records) {
        match stepped(setup, &group) {
            Some(level) => {
                let off = |record: &Steady| (record.frequency - level.frequency).abs();
                let nearest = (0..group.len()).min_by(|a, b| off(&group[*a]).total_cmp(&off(&group[*b])));
                for (k, record) in group.into_iter().enumerate() {
                    if Some(k) == nearest {
                        chosen.push(record);
                    } else {
                        let reason = format!("used for the resonance at {:.4} Hz alone", level.frequency);
                        skipped.push((record.name, reason));
                    }
                }
                levels.push(level);
            }
            None => {
                levels.extend(group.iter().filter_map(|record| single(setup, record)));
                chosen.extend(group);
            }
        }
    }
    chosen.sort_by_key(|record| order.iter().position(|name| *name == record.name));
    (levels, chosen)
}

/// Records of one level each.
fn grouped(mut records: Vec<Steady>) -> Vec<Vec<Steady>> {
    records.sort_by(|a, b| a.amplitude.total_cmp(&b.amplitude));
    let mut groups: Vec<Vec<Steady>> = Vec::new();
    for record in records {
        match groups.last_mut() {
            Some(group) if record.amplitude <= group[0].amplitude * (1.0 + SAME_LEVEL) => group.push(record),
            _ => groups.push(vec![record]),
        }
    }
    groups
}

/// The resonance of a stepped sine under held response; `None` of records that are none.
fn stepped(setup: &Setup, group: &[Steady]) -> Option<Level> {
    let frequencies: Vec<f64> = group.iter().map(|record| record.frequency).collect();
    let mut different = frequencies.clone();
    different.sort_by(f64::total_cmp);
    different.dedup_by(|a, b| (*a / *b - 1.0).abs() < 1e-6);
    let mean = frequencies.iter().sum::<f64>() / group.len() as f64;
    if different.len() < POINTS || frequencies.iter().any(|f| (f / mean - 1.0).abs() > NEAR) {
        return None;
    }
    let value = |record: &Steady| Complex::from_polar(record.amplitude / record.force(), record.phase);
    let values: Vec<Complex<f64>> = group.iter().map(value).collect();
    let fitted = resonance_of(&frequencies, &values).ok()?;
    let amplitude = group.iter().map(|record| record.amplitude).sum::<f64>() / group.len() as f64;
    let names = group.iter().map(|record| record.name.clone()).collect();
    Some(Level {
        frequency_interval: fitted.frequency_interval,
        damping_ratio: Some(fitted.damping_ratio),
        peak: Some(fitted.peak),
        response: Some(LevelResponse {
            measured: frequencies.iter().zip(&values).map(|(f, value)| [*f, value.norm()]).collect(),
            fitted: between(&frequencies).map(|f| [f, fitted.value(f).norm()]).collect(),
        }),
        ..Level::new(setup, LevelSource::Stepped(names), amplitude, fitted.frequency)
    })
}

/// Frequencies (Hz) evenly over the band of `frequencies`.
fn between(frequencies: &[f64]) -> impl Iterator<Item = f64> {
    let ends =
        frequencies.iter().fold((f64::INFINITY, 0.0_f64), |(low, high), f| (low.min(*f), high.max(*f)));
    (0..=CURVE).map(move |k| ends.0 + (ends.1 - ends.0) * k as f64 / CURVE as f64)
}

/// The resonance at which one record was taken.
fn single(setup: &Setup, record: &Steady) -> Option<Level> {
    let off = (record.phase - FRAC_PI_2 + TAU / 2.0).rem_euclid(TAU) - TAU / 2.0;
    let source = LevelSource::Single(record.name.clone(), off);
    let level = Level::new(setup, source, record.amplitude, record.frequency);
    (off.abs() < OFF_RESONANCE).then(|| Level { peak: Some(record.amplitude / record.force()), ..level })
}

/// The first mode of a random record.
pub(super) fn of_modes(setup: &Setup, record: &LinearRecord) -> Option<Level> {
    let first = record.poles.first()?;
    let level = Level::new(setup, LevelSource::Random, 0.0, first.frequency);
    Some(Level { damping_ratio: Some(first.damping_ratio), ..level })
}

/// The rows of a table of frequency against amplitude, that of a free decay among them.
///
/// # Errors
/// An amplitude that is not that of the exciter.
pub(super) fn of_backbone(setup: &Setup, record: &Record) -> Result<Vec<Level>, String> {
    let values = |name: &str| record.channel(name).map(|channel| channel.values.as_slice());
    let Some(amplitude) = record.channels_of("amplitude").next() else { return Ok(Vec::new()) };
    let exciter = setup.beam.excitation_position;
    if amplitude.position().is_some_and(|position| (position - exciter).abs() > 1e-9) {
        return Err(format!(
            "its amplitude is `{}`: levels are told at the exciter, x={exciter}",
            amplitude.name
        ));
    }
    let (amplitudes, frequencies) = (&amplitude.values, values("frequency").unwrap_or_default());
    let (damping, intervals) = (values("damping_ratio"), values("frequency_interval"));
    let row = |(k, (amplitude, frequency)): (usize, (&f64, &f64))| Level {
        damping_ratio: damping.map(|damping| damping[k]),
        frequency_interval: intervals
            .map(|intervals| Interval { low: frequency - intervals[k], high: frequency + intervals[k] }),
        ..Level::new(setup, LevelSource::Table(record.name.clone()), *amplitude, *frequency)
    };
    Ok(amplitudes.iter().zip(frequencies).enumerate().map(row).collect())
}
