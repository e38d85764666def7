//! A beam excited as measured, or held at measured response levels.

use std::f64::consts::TAU;

use crate::harmonic::{self, ContactOnBeam, Settings, fourier};
use crate::measure::{Channel, Record, Regime};
use crate::model::{Beam, Contact};
use crate::structure::ModalBeam;

/// Harmonics and samples at phase resonance. The third harmonic carries most of what the first does
/// not; with seven the frequency of the frictional support stands to 1e-3 Hz.
const HELD: Settings = Settings { harmonics: 5, samples: 128, tolerance: 1e-9, max_iterations: 40 };
/// Harmonics and samples of a forced response: several modes above the excitation answer the contact's
/// harmonics, up to the eleventh in the steady records at hand.
const FORCED: Settings = Settings { harmonics: 15, samples: 256, tolerance: 1e-8, max_iterations: 40 };

/// Predictions of the `frequency` (Hz) column of a backbone, or of every `acceleration:x=…` column (m/s²)
/// of a steady record, in the record's order.
pub(super) fn predict(
    beam: &Beam,
    contact: Option<&Contact>,
    record: &Record,
) -> Result<Vec<Vec<f64>>, String> {
    // Predictions are wanted where the record was measured, whatever sensors the model lists.
    let sensors = record.channels_of("acceleration").filter_map(Channel::position).collect();
    let modal = ModalBeam::new(&Beam { sensors, ..beam.clone() }).map_err(|error| error.to_string())?;
    let law = contact.map(Contact::law).transpose().map_err(|error| error.to_string())?;
    let on_beam = law
        .as_deref()
        .zip(contact)
        .map(|(law, contact)| ContactOnBeam { law, normal_load: contact.normal_load });
    match record.regime {
        Regime::Backbone => backbone(&modal, on_beam, record).map(|frequencies| vec![frequencies]),
        Regime::Steady => steady(&modal, on_beam, record),
        Regime::FromRest | Regime::UnknownInitialState => {
            Err("a beam is compared with backbone tables and with records of regime `steady`".into())
        }
    }
}

fn backbone(beam: &ModalBeam, contact: Option<ContactOnBeam>, record: &Record) -> Result<Vec<f64>, String> {
    let amplitudes = &record.channel("amplitude").ok_or("there is no `amplitude` column")?.values;
    let points =
        harmonic::backbone(beam, contact, amplitudes, &HELD, &[]).map_err(|error| error.to_string())?;
    Ok(points.iter().map(|point| point.angular_frequency / TAU).collect())
}

fn steady(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    record: &Record,
) -> Result<Vec<Vec<f64>>, String> {
    let time = record.time().ok_or("there is no `time` column")?;
    let step = record.sample_step().ok_or("`time` is not evenly spaced")?;
    let force = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
    let periods = harmonic::whole_periods(force).ok_or("the excitation shows no spectral line")?;
    let excitation = fourier::from_samples(force, periods, FORCED.harmonics);
    let period = step * force.len() as f64 / periods as f64;
    let response = harmonic::forced_response(beam, contact, period, &excitation, &FORCED, None)
        .map_err(|error| error.to_string())?;
    // Phase 0 of the Fourier coefficients is the first sample.
    let times: Vec<f64> = time.iter().map(|instant| instant - time[0]).collect();
    Ok(beam.sensors.iter().map(|sensor| response.acceleration(&sensor.shape, &times)).collect())
}
