//! A steady beam to first order about the motion that was measured.

use super::balance::{At, Known, SteadyRecord};
use crate::harmonic::steady::linearised::Linearised;
use crate::harmonic::{Assembly, HarmonicError};

/// The record, and the model it was last predicted with: a fit that accepts a step asks for the derivatives there next.
pub(super) struct LinearisedAtMeasurement {
    record: SteadyRecord,
    last: Option<Last>,
}

struct Last {
    known: Known,
    about: Linearised,
    predictions: Vec<f64>,
}

impl LinearisedAtMeasurement {
    pub fn new(record: SteadyRecord) -> Self {
        Self { record, last: None }
    }

    /// Coefficients of the measured normal load (N), `[a0, c1, s1, …]`.
    pub fn load(&self) -> Option<&[f64]> {
        self.record.measured.load.as_deref()
    }

    /// Predictions of all channels, one after the other.
    pub fn predict(&mut self, at: &At, out: &mut Vec<f64>) -> Result<(), String> {
        let last = self.at(at, &[]).map_err(|error| error.to_string())?;
        out.clone_from(&last.predictions);
        self.last = Some(last);
        Ok(())
    }

    /// The same with their differences to those of `neighbours`.
    pub fn linearise(
        &mut self,
        at: &At,
        neighbours: &[Assembly],
        predictions: &mut Vec<f64>,
        differences: &mut [Vec<f64>],
    ) -> Result<(), String> {
        let mut last = self.at(at, neighbours).map_err(|error| error.to_string())?;
        predictions.clone_from(&last.predictions);
        let done = self.record.differences(&mut last.about, at.assembly, neighbours, differences);
        self.last = Some(last);
        done.map_err(|error| error.to_string())
    }

    /// What was made of the model last time, if it serves; else made now.
    fn at(&mut self, at: &At, others: &[Assembly]) -> Result<Last, HarmonicError> {
        let assembly = at.assembly;
        let mut left = None;
        if let Some(last) = self.last.take() {
            if last.about.covers(assembly, others) && last.known.is(at) {
                return Ok(last);
            }
            left = last.about.into_workspace();
        }
        let forcing = &self.record.forcing;
        let start = forcing.start_at(assembly, &self.record.measured.motion, &mut left)?;
        let mut about = Linearised::new(forcing, assembly, others, &start, left)?;
        let mut predictions = Vec::new();
        self.record.measured.observe(&about.first_order(forcing, assembly)?, &mut predictions);
        Ok(Last { known: at.known(), about, predictions })
    }
}
