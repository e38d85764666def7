//! Steady states with the motion at the shaker held.

use std::f64::consts::TAU;

use super::bench::Bench;
use super::error::RigError;
use super::measured::{ContactSamples, Measured};
use super::plan::{Frequencies, SteppedSine};
use crate::numeric::fourier::{time_derivative, value};

/// Record `index` of a test: frequency after frequency, amplitude after amplitude.
pub(super) fn measured(
    bench: &Bench,
    test: &SteppedSine,
    index: usize,
    delays: &[f64],
) -> Result<Measured, RigError> {
    let frequencies = test.frequencies.count();
    let amplitude = test.amplitudes[index / frequencies];
    let resonance = match test.frequencies {
        Frequencies::List(_) => 0.0,
        _ => bench.resonance(test.harmonics, amplitude)?.angular_frequency / TAU,
    };
    let frequency = test.frequencies.at(index % frequencies, resonance);
    let point = bench.held(test.harmonics, frequency, amplitude)?;
    let speed = point.angular_frequency;
    let step = TAU / speed / test.samples_per_period as f64;
    // One period is computed, and repeated.
    let sampled = |coefficients: &[f64], delay: f64| -> Vec<f64> {
        let at =
            |k: usize| value(coefficients, TAU * k as f64 / test.samples_per_period as f64 - speed * delay);
        let period: Vec<f64> = (0..test.samples_per_period).map(at).collect();
        period.repeat(test.periods)
    };
    let excitation = sampled(&[0.0, point.level, 0.0], delays[0]);
    let nodes = point.nodes.iter().take(bench.sensors());
    let acceleration = |displacement: &Vec<f64>| time_derivative(displacement, 2, speed);
    let accelerations =
        nodes.map(acceleration).zip(&delays[1..]).map(|(a, delay)| sampled(&a, *delay)).collect();
    let contact = point.contacts.first().map(|contact| ContactSamples {
        displacement: sampled(&contact.displacement, 0.0),
        velocity: sampled(&time_derivative(&contact.displacement, 1, speed), 0.0),
        force: sampled(&contact.force, 0.0),
        normal: None,
    });
    let time = (0..test.periods * test.samples_per_period).map(|k| k as f64 * step).collect();
    Ok(Measured { time, excitation: Some(excitation), accelerations, contact })
}
