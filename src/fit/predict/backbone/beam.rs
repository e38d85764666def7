//! A beam held at measured response levels in phase resonance.

use std::f64::consts::TAU;

use crate::data::{Channel, Record};
use crate::fit::predict::observed_system::observed_system;
use crate::fit::predict::table::Table;
use crate::harmonic::{self, CurveSettings, HarmonicError, Resonance};
use crate::model::Model;
use crate::system::{Core, System};

/// Harmonics at phase resonance: the frequencies of the frictional support are then within 0.1 mHz of those
/// with 15.
const HARMONICS: usize = 5;
const TOLERANCE: f64 = 1e-9;

/// Predictions of a table's columns `frequency` (Hz) and `damping_ratio` at each `amplitude`.
pub(in crate::fit::predict) struct BackboneOfBeam<'r> {
    amplitudes: &'r [f64],
    channels: Vec<&'r Channel>,
    /// The last solutions, one per amplitude.
    starts: Vec<Resonance>,
}

impl<'r> BackboneOfBeam<'r> {
    /// Of `channels` of `record`.
    pub fn new(record: &'r Record, channels: Vec<&'r Channel>) -> Result<Self, String> {
        let amplitudes = &record.channel("amplitude").ok_or("there is no `amplitude` column")?.values;
        Ok(Self { amplitudes, channels, starts: Vec::new() })
    }

    /// `error` with the frequencies to compare, and the parameters to check.
    fn advice(&self, error: &HarmonicError, system: &System) -> String {
        let measured = self.channels.iter().find(|channel| channel.quantity() == "frequency");
        let (HarmonicError::NotConverged { .. }, Some(measured), Core::Modal { angular_frequency, .. }) =
            (error, measured, &system.core)
        else {
            return error.to_string();
        };
        let (low, high) = measured
            .values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), f| (low.min(*f), high.max(*f)));
        format!(
            "{error}; the model's first natural frequency without contact is {:.1} Hz, measured are {low:.1} to {high:.1} Hz: \
             check `beam.youngs_modulus`, the dimensions and the masses",
            angular_frequency.first().map_or(f64::NAN, |first| first / TAU)
        )
    }
}

impl Table for BackboneOfBeam<'_> {
    type Rows = Vec<Resonance>;

    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn solve(&self, model: &Model) -> Result<Vec<Resonance>, String> {
        let system = observed_system(model, &[])?;
        let settings =
            CurveSettings { harmonics: HARMONICS, tolerance: TOLERANCE, ..CurveSettings::default() };
        harmonic::backbone(&system, self.amplitudes, &settings, &self.starts)
            .map_err(|error| self.advice(&error, &system))
    }

    fn show(&self, rows: &Vec<Resonance>, out: &mut Vec<f64>) {
        for channel in &self.channels {
            match channel.quantity() {
                "damping_ratio" => out.extend(rows.iter().map(Resonance::damping_ratio)),
                _ => out.extend(rows.iter().map(|row| row.angular_frequency / TAU)),
            }
        }
    }

    fn keep(&mut self, rows: Vec<Resonance>) {
        self.starts = rows;
    }
}
