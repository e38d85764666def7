//! What the views of a residual need beyond the samples themselves.

use realfft::RealFftPlanner;
use serde_json::{Value, json};
use stickslip::data::{Channel, Record};
use stickslip::fit::residual::drive;

use super::store::Store;
use crate::decimate::samples_per_cycle;

/// What a residual may be drawn against, in the order of the figures.
pub const ROLES: [&str; 6] =
    ["displacement", "velocity", "normal load", "normal displacement", "excitation", "measured value"];

/// Windows of slow time at most, and samples that one needs.
const WINDOWS: (usize, usize) = (32, 8);
/// Points of a spectrum at most.
const LINES: usize = 240;

/// Population standard deviation.
pub fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / count).sqrt()
}

/// Root mean square of each stage's residual in windows along the record, over the channel's standard
/// deviation; times are multiplied by `factor`. Windows are about a cycle long, or two, three ... in a record of
/// many, since within a cycle every residual rises and falls.
pub fn slow_time(
    record: &Record,
    measured: &Channel,
    time: &[f64],
    residuals: &[Option<Vec<f64>>],
    (spread, factor): (f64, f64),
) -> Value {
    let count = time.len();
    let cycle = drive(record, measured).and_then(|drive| samples_per_cycle(&drive.values));
    let cycles = cycle.map_or(WINDOWS.0 / 2, |samples| count / samples.max(1));
    let windows = (cycles / cycles.div_ceil(WINDOWS.0).max(1)).min(count / WINDOWS.1);
    if windows < 2 {
        return Value::Null;
    }
    let edges = |window: usize| window * count / windows..(window + 1) * count / windows;
    let middle =
        |window: usize| short(0.5 * (time[edges(window).start] + time[edges(window).end - 1]) * factor);
    let rms = |values: &[f64]| -> Vec<Value> {
        let part = |window| values.get(edges(window)).unwrap_or(&[]);
        let one =
            |part: &[f64]| (part.iter().map(|v| v * v).sum::<f64>() / part.len() as f64).sqrt() / spread;
        (0..windows).map(|window| short(one(part(window)))).collect()
    };
    json!({
        "time": (0..windows).map(middle).collect::<Vec<_>>(),
        "rms": residuals.iter().map(|one| one.as_ref().map(|one| rms(one))).collect::<Vec<_>>(),
    })
}

/// Amplitude over frequency of measurement and residuals, in decades, the largest line of each stretch.
pub fn spectrum(
    store: &mut Store,
    record: &Record,
    measured: &[f64],
    residuals: &[Option<Vec<f64>>],
    factor: f64,
) -> Value {
    let (Some(step), true) = (record.sample_step(), measured.len() >= 16) else { return Value::Null };
    let width = (measured.len() / 2).div_ceil(LINES).max(1);
    let resolution = 1.0 / (step * measured.len() as f64);
    let mut decades = |values: &[f64]| -> usize {
        let lines = amplitudes(values);
        let stretches = lines.get(1..).unwrap_or(&[]).chunks(width);
        let largest: Vec<f64> =
            stretches.map(|part| (part.iter().copied().fold(0.0, f64::max) * factor).log10()).collect();
        let all: Vec<usize> = (0..largest.len()).collect();
        store.scaled(&largest, &all, 1.0)
    };
    let whole = |values: &&Vec<f64>| values.len() == measured.len();
    json!({
        "measured": decades(measured),
        "residuals": residuals.iter().map(|one| one.as_ref().filter(whole).map(|one| decades(one))).collect::<Vec<_>>(),
        "from": resolution * (1.0 + 0.5 * (width - 1) as f64), "step": resolution * width as f64,
    })
}

/// Amplitudes of the lines from 0 to the Nyquist frequency, the mean removed, under a Hann window.
fn amplitudes(values: &[f64]) -> Vec<f64> {
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let window = |index: usize| {
        let phase = std::f64::consts::TAU * index as f64 / count as f64;
        0.5 - 0.5 * phase.cos()
    };
    let mut input: Vec<f64> =
        values.iter().enumerate().map(|(index, value)| (value - mean) * window(index)).collect();
    let transform = RealFftPlanner::<f64>::new().plan_fft_forward(count);
    let mut lines = transform.make_output_vec();
    match transform.process(&mut input, &mut lines) {
        // The window's mean is a half: a sine of amplitude 1 is a line of height 1.
        Ok(()) => lines.iter().map(|line| 4.0 * line.norm() / count as f64).collect(),
        Err(_) => Vec::new(),
    }
}

/// Five digits are enough for a plot.
pub fn short(value: f64) -> Value {
    json!(format!("{value:.4e}").parse::<f64>().ok().filter(|value| value.is_finite()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn a_sine_of_amplitude_one_is_a_line_of_height_one() {
        let sine: Vec<f64> = (0..1000).map(|i| 7.0 + (TAU * 0.05 * f64::from(i)).sin()).collect();
        let lines = amplitudes(&sine);
        assert!((lines[50] - 1.0).abs() < 1e-12 && lines[60] < 1e-12 && lines[0] < 1e-12);
    }
}
