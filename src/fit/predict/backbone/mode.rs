//! A mode of an oscillator or a beam at measured acceleration amplitudes of a mass or a sensor.

use std::f64::consts::TAU;

use crate::data::{Channel, Record};
use crate::fit::predict::channels::position;
use crate::fit::predict::observed_system::observed_system;
use crate::fit::predict::stepper::excitation::mass_of;
use crate::fit::predict::table::Table;
use crate::harmonic::{Assembly, CurveSettings, mode_at, mode_near};
use crate::model::{Model, Structure};

/// Harmonics of the vibration: frequency and damping need few.
const HARMONICS: usize = 15;
const TOLERANCE: f64 = 1e-9;

/// A mode, and who sees it.
pub(super) struct SensedMode {
    /// Where the sensor of a beam is (m).
    pub positions: Vec<f64>,
    /// Place of the mass or the sensor among what is read.
    pub node: usize,
    /// The mode, counted from 0 with the contact in stick.
    pub mode: usize,
}

impl SensedMode {
    /// That of models like `model` which is nearest to the frequency measured at the least amplitude of `record`. An amplitude of an
    /// oscillator without a place is that of the mass excited.
    pub fn of(model: &Model, record: &Record) -> Result<Self, String> {
        let amplitude = record.channels_of("amplitude").next().ok_or("there is no `amplitude` column")?;
        let frequency = record.channel("frequency").ok_or("there is no `frequency` column")?;
        let (positions, node) = match &model.structure {
            Structure::Oscillator(oscillator) if amplitude.name.contains(':') => {
                let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
                (Vec::new(), mass_of(&amplitude.name, &names)?)
            }
            Structure::Oscillator(oscillator) => (Vec::new(), oscillator.excitation),
            _ => (vec![position(amplitude)?], 0),
        };
        let pairs = amplitude.values.iter().zip(&frequency.values);
        let least = pairs.min_by(|a, b| a.0.total_cmp(b.0)).ok_or("the table is empty")?;
        let assembly = Assembly::new(observed_system(model, &positions)?);
        let mode = mode_near(&assembly, TAU * least.1).map_err(|error| error.to_string())?;
        Ok(Self { positions, node, mode })
    }

    /// Frequency (Hz) and damping ratio of `model` at each of the amplitudes of the acceleration (m/s²).
    pub fn at(&self, model: &Model, amplitudes: &[f64]) -> Result<Vec<[f64; 2]>, String> {
        let assembly = Assembly::new(observed_system(model, &self.positions)?);
        let settings =
            CurveSettings { harmonics: HARMONICS, tolerance: TOLERANCE, ..CurveSettings::default() };
        let found = mode_at(&assembly, self.mode, self.node, amplitudes, &settings);
        let points = found.map_err(|error| format!("the mode cannot be followed: {error}"))?;
        Ok(points.into_iter().map(|[omega, ratio]| [omega / TAU, ratio]).collect())
    }
}

/// Predictions of a table's columns `frequency` (Hz) and `damping_ratio` at each `amplitude`.
pub(in crate::fit::predict) struct BackboneOfMode<'r> {
    amplitudes: &'r [f64],
    channels: Vec<&'r Channel>,
    sensed: SensedMode,
}

impl<'r> BackboneOfMode<'r> {
    /// Of `channels` of `record`, for models like `model`.
    pub fn new(model: &Model, record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let amplitude = record.channels_of("amplitude").next().ok_or("there is no `amplitude` column")?;
        Ok(Self { amplitudes: &amplitude.values, channels, sensed: SensedMode::of(model, record)? })
    }
}

impl Table for BackboneOfMode<'_> {
    type Rows = Vec<[f64; 2]>;

    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn solve(&self, model: &Model) -> Result<Vec<[f64; 2]>, String> {
        self.sensed.at(model, self.amplitudes)
    }

    fn show(&self, rows: &Vec<[f64; 2]>, out: &mut Vec<f64>) {
        for channel in &self.channels {
            let column = usize::from(channel.quantity() == "damping_ratio");
            out.extend(rows.iter().map(|row| row[column]));
        }
    }
}
