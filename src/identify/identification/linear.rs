//! Linear modes from a record under random excitation.

use std::f64::consts::TAU;

use super::Setup;
use crate::data::Record;
use crate::identify::steady::motions;
use crate::identify::{FrequencyResponse, Pole, frequency_response_of, poles};
use crate::numeric::fourier::time_derivative;
use crate::system::{Beam, ModalBeam, rotational_stiffness_from_frequency};

/// Modes looked for, and the band about them.
const MODES: usize = 3;
const BELOW: f64 = 0.6;
const ABOVE: f64 = 1.2;
/// Highest order of the denominator; lines for every one of it.
const ORDER: usize = 30;
const LINES: usize = 3;
/// Segments that a record is cut into, about, and their samples at least.
const SEGMENTS: usize = 16;
const SHORTEST: usize = 256;
/// Of Nyquist's frequency the part that can be trusted.
const TRUSTED: f64 = 0.9;
/// Mean coherence between force and response below which a record is not of a linear structure under this force.
const COHERENCE: f64 = 0.2;

/// The linear beam under random excitation.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearRecord {
    /// Name of the record.
    pub name: String,
    /// Positions of the sensors (m), and the responses of their accelerations to the excitation.
    pub responses: Vec<(f64, FrequencyResponse)>,
    /// The modes.
    pub poles: Vec<Pole>,
    /// Rotational stiffness (N m/rad) that gives the beam the first of them, if one does.
    pub rotational_stiffness: Option<f64>,
    /// Natural frequencies (Hz) of the beam with that spring.
    pub model: Vec<f64>,
}

/// The modes that a record tells.
pub(super) fn linear(setup: &Setup, record: &Record) -> Result<LinearRecord, String> {
    let step = record.even_step()?;
    let excitation = record.channel("excitation").map(|channel| channel.values.as_slice());
    let driven = excitation.filter(|values| values.iter().any(|force| *force != 0.0));
    let force = driven.ok_or(
        "nothing excites it: the contact is not identified from free vibrations; a steady or random record is needed",
    )?;
    let beam = setup.beam.changed(&setup.changes).map_err(|error| error.to_string())?;
    let (frequencies, rate) = (natural(&beam)?, 1.0 / step);
    let band = [BELOW * frequencies[0], (ABOVE * frequencies[MODES - 1]).min(0.5 * TRUSTED * rate)];
    let length = (record.len() / SEGMENTS).max(SHORTEST).next_power_of_two();
    let lines = (band[1] - band[0]) * length as f64 / rate;
    let order = ORDER.min((lines / LINES as f64).max(0.0) as usize);
    let mut responses = Vec::new();
    for (at, channel, derivatives) in motions(record) {
        let mut found =
            frequency_response_of(force, &channel.values, rate, length).map_err(|error| error.to_string())?;
        for (k, frequency) in found.frequencies.iter().enumerate() {
            for h in [&mut found.h1[k], &mut found.h2[k]] {
                let turned = time_derivative(&[0.0, h.re, -h.im], derivatives, TAU * frequency);
                (h.re, h.im) = (turned[1], -turned[2]);
            }
        }
        responses.push((at, found));
    }
    let inside = |f: &f64| (band[0]..=band[1]).contains(f);
    let coherence: Vec<f64> = responses
        .iter()
        .flat_map(|(_, r)| r.frequencies.iter().zip(&r.coherence).filter(|(f, _)| inside(f)).map(|(_, c)| *c))
        .collect();
    let mean = coherence.iter().sum::<f64>() / coherence.len().max(1) as f64;
    if mean.is_nan() || mean <= COHERENCE {
        return Err(
            "the excitation does not explain the motion over a band: it is no record of the linear beam \
                    under random excitation"
                .to_owned(),
        );
    }
    let all: Vec<FrequencyResponse> = responses.iter().map(|(_, response)| response.clone()).collect();
    let poles = poles(&all, band, order).map_err(|error| error.to_string())?;
    let rotational_stiffness =
        poles.first().and_then(|pole| rotational_stiffness_from_frequency(&beam, pole.frequency).ok());
    let sprung = Beam { rotational_stiffness: rotational_stiffness.unwrap_or(0.0), ..beam };
    let model = natural(&sprung)?;
    Ok(LinearRecord { name: record.name.clone(), responses, poles, rotational_stiffness, model })
}

/// The lowest natural frequencies (Hz).
fn natural(beam: &Beam) -> Result<Vec<f64>, String> {
    let modal = ModalBeam::new(beam).map_err(|error| error.to_string())?;
    if modal.angular_frequency.len() < MODES {
        return Err(format!("{MODES} modes of the beam are needed"));
    }
    Ok(modal.angular_frequency[..MODES].iter().map(|omega| omega / TAU).collect())
}
