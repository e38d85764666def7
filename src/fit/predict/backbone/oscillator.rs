//! A mode of an oscillator at measured acceleration amplitudes of a mass.

use std::f64::consts::TAU;

use crate::data::{Channel, Record};
use crate::fit::predict::observed_system::observed_system;
use crate::fit::predict::simulation::Simulation;
use crate::fit::predict::stepper::excitation::mass_of;
use crate::harmonic::{Assembly, CurveSettings, mode_at};
use crate::model::{Model, Oscillator};

/// Harmonics of the vibration: frequency and damping need few.
const HARMONICS: usize = 15;
const TOLERANCE: f64 = 1e-9;

/// Predictions of a table's columns `frequency` (Hz) and `damping_ratio` at each `amplitude`.
pub(in crate::fit::predict) struct BackboneOfOscillator<'r> {
    amplitudes: &'r [f64],
    channels: Vec<&'r Channel>,
    /// Place of the mass whose amplitude it is.
    mass: usize,
    /// The mode, counted from 0 with the contact in stick.
    mode: usize,
}

impl<'r> BackboneOfOscillator<'r> {
    /// Of `channels` of `record`, for models like `model` with the masses of its `oscillator`: of its mode that is nearest
    /// to the frequency measured at the least amplitude. An amplitude without a place is that of the mass excited.
    pub fn new(
        model: &Model,
        oscillator: &Oscillator,
        record: &'r Record,
        channels: Vec<&'r Channel>,
    ) -> Result<Self, String> {
        let amplitude = record.channels_of("amplitude").next().ok_or("there is no `amplitude` column")?;
        let frequency = record.channel("frequency").ok_or("there is no `frequency` column")?;
        let names: Vec<&str> = oscillator.masses.iter().map(|mass| mass.name.as_str()).collect();
        let mass = match amplitude.name.contains(':') {
            true => mass_of(&amplitude.name, &names)?,
            false => oscillator.excitation,
        };
        let pairs = amplitude.values.iter().zip(&frequency.values);
        let least = pairs.min_by(|a, b| a.0.total_cmp(b.0)).ok_or("the table is empty")?;
        let mut structure = observed_system(model, &[])?.linear_part();
        if let Some(contact) = &model.contact {
            structure.stiffness.extend(structure.along_contacts([contact.tangential_stiffness]));
        }
        let modes = structure.natural_modes().map_err(|error| error.to_string())?;
        let apart = |omega: &f64| (omega / TAU / least.1).ln().abs();
        let nearest = modes.angular_frequency.iter().enumerate().filter(|(_, omega)| **omega > 0.0);
        let nearest = nearest.min_by(|a, b| apart(a.1).total_cmp(&apart(b.1)));
        let (mode, _) = nearest.ok_or("the model has no vibration")?;
        Ok(Self { amplitudes: &amplitude.values, channels, mass, mode })
    }
}

impl Simulation for BackboneOfOscillator<'_> {
    fn channels(&self) -> &[&Channel] {
        &self.channels
    }

    fn predict(&mut self, model: &Model, _: &[f64], out: &mut Vec<f64>) -> Result<(), String> {
        let assembly = Assembly::new(observed_system(model, &[])?);
        let settings =
            CurveSettings { harmonics: HARMONICS, tolerance: TOLERANCE, ..CurveSettings::default() };
        let found = mode_at(&assembly, self.mode, self.mass, self.amplitudes, &settings);
        let points = found.map_err(|error| format!("the mode cannot be followed: {error}"))?;
        out.clear();
        for channel in &self.channels {
            match channel.quantity() {
                "damping_ratio" => out.extend(points.iter().map(|[_, ratio]| ratio)),
                _ => out.extend(points.iter().map(|[omega, _]| omega / TAU)),
            }
        }
        Ok(())
    }
}
