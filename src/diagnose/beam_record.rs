//! A beam excited as measured, or held at measured response levels.

use std::f64::consts::TAU;

use crate::harmonic::{self, ContactOnBeam, Settings, fourier};
use crate::integrate::{self, BeamInputs, BeamIntegrator, Ramp};
use crate::measure::{Channel, Record, Regime};
use crate::model::{Beam, Contact};
use crate::structure::ModalBeam;

/// Harmonics and samples at phase resonance: the frequencies of the frictional support are then within
/// 7 mHz of those with 15 harmonics and 512 samples.
const HELD: Settings = Settings { harmonics: 5, samples: 128, tolerance: 1e-9, max_iterations: 40 };

/// Tolerance of the integration from rest, far below the noise of any sensor.
const FROM_REST: integrate::Settings = integrate::Settings { tolerance: 1e-6, step_limit: 1_000_000 };

/// The contact's harmonics excite every mode kept, and accelerations show the highest of them: the balance
/// reaches 1.4 times the highest mode. On steady records with a first resonance at 54 Hz and six modes
/// the accelerations are then within 0.3 % of those with 41 harmonics and 1024 samples; with 15 harmonics
/// they were 5 to 12 % off.
fn forced_settings(beam: &ModalBeam, period: f64) -> Settings {
    let highest = beam.angular_frequency.last().copied().unwrap_or(0.0) * period / TAU;
    let harmonics = ((1.4 * highest).ceil() as usize).clamp(9, 60);
    Settings { harmonics, samples: (8 * harmonics).next_power_of_two(), tolerance: 1e-8, max_iterations: 40 }
}

/// Predictions of the `frequency` (Hz) column of a backbone, or of every `acceleration:x=…` column (m/s²)
/// of a record in time, in the record's order.
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
        Regime::FromRest => from_rest(&modal, on_beam, record),
        Regime::UnknownInitialState => Err(
            "a beam's record needs the regime `from-rest`, `steady` or `backbone`: the motion at its start \
             is not measured everywhere"
                .into(),
        ),
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
    let period = step * force.len() as f64 / periods as f64;
    let settings = forced_settings(beam, period);
    let excitation = fourier::from_samples(force, periods, settings.harmonics);
    let response = harmonic::forced_response(beam, contact, period, &excitation, &settings, None)
        .map_err(|error| error.to_string())?;
    // Phase 0 of the Fourier coefficients is the first sample.
    let times: Vec<f64> = time.iter().map(|instant| instant - time[0]).collect();
    Ok(beam.sensors.iter().map(|sensor| response.acceleration(&sensor.shape, &times)).collect())
}

/// The excitation runs linearly from sample to sample.
fn from_rest(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    record: &Record,
) -> Result<Vec<Vec<f64>>, String> {
    let time = record.time().ok_or("there is no `time` column")?;
    let force = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
    let mut integrator = BeamIntegrator::new(beam).map_err(|error| error.to_string())?;
    let mut motion = integrator.rest(contact.map(|contact| (contact.law, contact.normal_load)));
    let mut outputs = integrator.new_outputs();
    let acting = |excitation| BeamInputs {
        excitation,
        contact: match contact {
            Some(ContactOnBeam { law, normal_load }) => {
                integrate::Contact::Friction { law, normal_load: Ramp::held(normal_load) }
            }
            None => integrate::Contact::Force(Ramp::held(0.0)),
        },
    };
    let mut predicted = vec![Vec::with_capacity(time.len()); beam.sensors.len()];
    for index in 0..time.len() {
        if index > 0 {
            let ramp = Ramp { start: force[index - 1], end: force[index] };
            integrator
                .advance(&mut motion, time[index] - time[index - 1], &acting(ramp), &FROM_REST)
                .map_err(|error| error.to_string())?;
        }
        integrator
            .outputs(&motion, f64::INFINITY, &acting(Ramp::held(force[index])), &mut outputs)
            .map_err(|error| error.to_string())?;
        for (channel, sensor) in predicted.iter_mut().zip(&outputs.sensors) {
            channel.push(sensor.acceleration);
        }
    }
    Ok(predicted)
}
