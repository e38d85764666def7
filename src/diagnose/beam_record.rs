//! A beam excited as measured, or held at measured response levels.

use std::f64::consts::TAU;

use super::predict::Prediction;
use crate::harmonic::{self, ContactOnBeam, Method, Resonance, Settings, fourier};
use crate::integrate::{self, BeamInputs, BeamIntegrator, Ramp, SensorReading};
use crate::measure::{Channel, Record, Regime};
use crate::model::{Beam, Model};
use crate::structure::ModalBeam;

/// Harmonics at phase resonance: the frequencies of the frictional support are then within 0.1 mHz of those
/// with 15.
const HELD: Settings = Settings { harmonics: 5, method: Method::Exact, tolerance: 1e-9, max_iterations: 40 };

/// Tolerance of the integration from rest, far below the noise of any sensor.
const FROM_REST: integrate::Settings = integrate::Settings { tolerance: 1e-6, step_limit: 1_000_000 };

/// Largest share of a steady excitation (root-mean-square, without its mean) that may lie outside the
/// harmonics kept: more is not noise.
const UNREPRESENTED: f64 = 0.1;

/// The contact's harmonics excite every mode kept, and accelerations show the highest of them: the balance
/// reaches 1.4 times the highest mode. On steady records with a first resonance at 54 Hz and six modes
/// the accelerations are then within 0.3 % of those with 41 harmonics and 1024 samples; with 15 harmonics
/// they were 5 to 12 % off.
fn forced_settings(beam: &ModalBeam, period: f64) -> Settings {
    let highest = beam.angular_frequency.last().copied().unwrap_or(0.0) * period / TAU;
    let harmonics = ((1.4 * highest).ceil() as usize).clamp(9, 60);
    Settings { harmonics, method: Method::Exact, tolerance: 1e-8, max_iterations: 40 }
}

/// Predictions of the columns `frequency` (Hz) and `damping_ratio` of a backbone, or of every motion
/// measured at a position (`acceleration:x=…`, `velocity:x=…`, `displacement:x=…`) of a record in time.
pub(super) fn predict<'r>(
    model: &Model,
    beam: &Beam,
    record: &Record,
    channels: Vec<&'r Channel>,
) -> Result<Vec<Prediction<'r>>, String> {
    // Predictions are wanted where the record was measured, whatever sensors the model lists.
    let sensors = match record.regime {
        Regime::Backbone => Vec::new(),
        _ => channels.iter().map(|channel| position(channel)).collect::<Result<_, _>>()?,
    };
    let modal = ModalBeam::new(&Beam { sensors, ..beam.clone() }).map_err(|error| error.to_string())?;
    let law = model.law().map_err(|error| error.to_string())?;
    let on_beam = law
        .as_deref()
        .zip(model.contact)
        .map(|(law, contact)| ContactOnBeam { law, normal_load: contact.normal_load });
    match record.regime {
        Regime::Backbone => backbone(&modal, on_beam, record, channels),
        Regime::Steady => steady(&modal, on_beam, record, channels),
        Regime::FromRest => from_rest(&modal, on_beam, record, channels),
        Regime::UnknownInitialState => Err(
            "a beam's record needs the regime `from-rest`, `steady` or `backbone`: the motion at its start \
             is not measured everywhere"
                .into(),
        ),
    }
}

fn position(channel: &Channel) -> Result<f64, String> {
    channel
        .position()
        .ok_or_else(|| format!("`{}` does not say where on the beam it was measured", channel.name))
}

fn backbone<'r>(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    record: &Record,
    channels: Vec<&'r Channel>,
) -> Result<Vec<Prediction<'r>>, String> {
    let amplitudes = &record.channel("amplitude").ok_or("there is no `amplitude` column")?.values;
    let points =
        harmonic::backbone(beam, contact, amplitudes, &HELD, &[]).map_err(|error| error.to_string())?;
    let predicted = |channel: &Channel| -> Vec<f64> {
        match channel.quantity() {
            "damping_ratio" => points.iter().map(Resonance::damping_ratio).collect(),
            _ => points.iter().map(|point| point.angular_frequency / TAU).collect(),
        }
    };
    Ok(channels.into_iter().map(|channel| (channel, predicted(channel))).collect())
}

fn steady<'r>(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    record: &Record,
    channels: Vec<&'r Channel>,
) -> Result<Vec<Prediction<'r>>, String> {
    let time = record.time().ok_or("there is no `time` column")?;
    let step = record.sample_step().ok_or("`time` is not evenly spaced")?;
    let force = &record.channel("excitation").ok_or("there is no `excitation` column")?.values;
    let periods = harmonic::whole_periods(force).ok_or("the excitation shows no spectral line")?;
    let period = step * force.len() as f64 / periods as f64;
    let settings = forced_settings(beam, period);
    let excitation = fourier::from_samples(force, periods, settings.harmonics);
    check_represented(force, periods, &excitation)?;
    let response = harmonic::forced_response(beam, contact, period, &excitation, &settings, None)
        .map_err(|error| error.to_string())?;
    // Phase 0 of the Fourier coefficients is the first sample.
    let times: Vec<f64> = time.iter().map(|instant| instant - time[0]).collect();
    let predicted = |channel: &Channel, shape: &[f64]| {
        let order = match channel.quantity() {
            "acceleration" => 2,
            "velocity" => 1,
            _ => 0,
        };
        response.motion(shape, order, &times)
    };
    let sensors = channels.into_iter().zip(&beam.sensors);
    Ok(sensors.map(|(channel, sensor)| (channel, predicted(channel, &sensor.shape))).collect())
}

/// Refuses an excitation with a good part beyond the harmonics kept, as a wide multisine has or a record that
/// does not hold whole periods: the response to the rest of it would not be the response to it.
fn check_represented(force: &[f64], periods: usize, excitation: &[f64]) -> Result<(), String> {
    let mean_square = force.iter().map(|f| (f - excitation[0]).powi(2)).sum::<f64>() / force.len() as f64;
    let represented = 0.5 * excitation[1..].iter().map(|f| f * f).sum::<f64>();
    let share = (1.0 - represented / mean_square).max(0.0).sqrt();
    if share <= UNREPRESENTED {
        return Ok(());
    }
    Err(format!(
        "{:.0} % of the excitation lies beyond harmonic {} of the period found ({periods} of it in the \
         record); a steady record holds whole periods, and of few harmonics",
        100.0 * share,
        excitation.len() / 2
    ))
}

/// The excitation runs linearly from sample to sample.
fn from_rest<'r>(
    beam: &ModalBeam,
    contact: Option<ContactOnBeam>,
    record: &Record,
    channels: Vec<&'r Channel>,
) -> Result<Vec<Prediction<'r>>, String> {
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
    let mut predictions: Vec<Prediction> =
        channels.into_iter().map(|channel| (channel, Vec::with_capacity(time.len()))).collect();
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
        for ((channel, values), SensorReading { displacement, velocity, acceleration }) in
            predictions.iter_mut().zip(&outputs.sensors)
        {
            values.push(match channel.quantity() {
                "acceleration" => *acceleration,
                "velocity" => *velocity,
                _ => *displacement,
            });
        }
    }
    Ok(predictions)
}
