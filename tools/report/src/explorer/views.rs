//! What the views of a residual need beyond the samples themselves.

use realfft::RealFftPlanner;
use realfft::num_complex::Complex;
use serde_json::{Value, json};
use stickslip::data::{Channel, Record, Regime};
use stickslip::harmonic::whole_periods;

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

/// What could cause the residual of `measured`, with the role of each: the relative motion of a contact, the
/// motion of the same place of a structure (from a measured acceleration where the record is steady), the load,
/// the excitation. The measured value itself where its motion is not known.
pub fn causes(record: &Record, measured: &Channel) -> Vec<(&'static str, Channel)> {
    let mut found = Vec::new();
    let place = measured.name.split_once(':').map(|(_, place)| place);
    let named = |quantity: &str| match place {
        Some(place) => record.channel(&format!("{quantity}:{place}")),
        None => record.channel(quantity),
    };
    let time = record.time().filter(|time| time.len() == measured.values.len());
    let displacement = named("displacement").cloned().or_else(|| integral(record, measured, 2));
    let velocity = named("velocity").cloned().or_else(|| match named("displacement") {
        Some(channel) => derivative(channel, time?),
        None => integral(record, measured, 1),
    });
    if displacement.is_none() && measured.quantity() != "normal_load" {
        found.push(("measured value", measured.clone()));
    }
    found.extend(displacement.map(|channel| ("displacement", channel)));
    found.extend(velocity.map(|channel| ("velocity", channel)));
    found.extend(record.channel("normal_load").map(|channel| ("normal load", channel.clone())));
    found.extend(
        record.channel("normal_displacement").map(|channel| ("normal displacement", channel.clone())),
    );
    let excitation = record.channels.iter().find(|channel| channel.quantity() == "excitation");
    found.extend(excitation.map(|channel| ("excitation", channel.clone())));
    found.retain(|(_, channel)| channel.values.len() == measured.values.len());
    found
}

fn derivative(displacement: &Channel, time: &[f64]) -> Option<Channel> {
    let values = differences(&displacement.values, time);
    let name = displacement.name.replacen("displacement", "velocity", 1);
    (values.len() == time.len()).then_some(Channel { name, unit: "m/s", values, noise: None })
}

/// Central differences, one-sided at the ends.
fn differences(values: &[f64], times: &[f64]) -> Vec<f64> {
    let length = values.len().min(times.len());
    (0..length)
        .map(|i| {
            let (before, after) = (i.saturating_sub(1), (i + 1).min(length - 1));
            (values[after] - values[before]) / (times[after] - times[before])
        })
        .collect()
}

/// The integral of order `order` of a steady acceleration, without the lines below its fundamental.
fn integral(record: &Record, measured: &Channel, order: i32) -> Option<Channel> {
    if record.regime != Regime::Steady || measured.quantity() != "acceleration" {
        return None;
    }
    let step = record.sample_step()?;
    let count = measured.values.len();
    let first = drive(record, measured).and_then(|drive| whole_periods(&drive.values)).unwrap_or(1);
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, backward) = (planner.plan_fft_forward(count), planner.plan_fft_inverse(count));
    let mut lines = forward.make_output_vec();
    forward.process(&mut measured.values.clone(), &mut lines).ok()?;
    let resolution = std::f64::consts::TAU / (step * count as f64);
    for (k, line) in lines.iter_mut().enumerate() {
        *line = if k < first {
            Complex::new(0.0, 0.0)
        } else {
            *line / Complex::new(0.0, k as f64 * resolution).powi(order) / count as f64
        };
    }
    // What the inverse transform demands of a real signal.
    if let (true, Some(end)) = (count.is_multiple_of(2), lines.last_mut()) {
        end.im = 0.0;
    }
    let mut values = backward.make_output_vec();
    backward.process(&mut lines, &mut values).ok()?;
    let (quantity, unit) = if order == 2 { ("displacement", "m") } else { ("velocity", "m/s") };
    let name = measured.name.replacen("acceleration", quantity, 1);
    Some(Channel { name, unit, values, noise: None })
}

/// What drives the record: the displacement of a contact, the excitation of a structure.
pub fn drive<'r>(record: &'r Record, measured: &Channel) -> Option<&'r Channel> {
    match measured.name.as_str() {
        "force" => record.channel("displacement"),
        _ => record.channels.iter().find(|channel| channel.quantity() == "excitation"),
    }
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

    fn record(regime: Regime, channels: Vec<Channel>) -> Record {
        Record { name: "r".into(), regime, use_for: None, channels }
    }

    fn channel(name: &str, unit: &'static str, value: impl Fn(f64) -> f64) -> Channel {
        let values = (0..1000).map(|i| value(f64::from(i) * 1e-3)).collect();
        Channel { name: name.into(), unit, values, noise: None }
    }

    #[test]
    fn central_differences_are_exact_for_a_parabola() {
        let times: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.01).collect();
        let values: Vec<f64> = times.iter().map(|t| 3.0 * t * t).collect();
        let velocity = differences(&values, &times);
        for i in 1..49 {
            assert!((velocity[i] - 6.0 * times[i]).abs() < 1e-12);
        }
    }

    #[test]
    fn the_motion_of_a_steady_acceleration_is_its_integral() {
        let rate = TAU * 20.0;
        let record = record(
            Regime::Steady,
            vec![
                channel("time", "s", |t| t),
                channel("excitation", "N", |t| (rate * t).sin()),
                channel("acceleration:x=0.5", "m/s^2", |t| 3.0 + 5.0 * (rate * t).cos()),
            ],
        );
        let causes = causes(&record, &record.channels[2]);
        let of = |role: &str| &causes.iter().find(|(name, _)| *name == role).unwrap().1;
        for (index, time) in record.time().unwrap().iter().enumerate() {
            let (displacement, velocity) =
                (-5.0 * (rate * time).cos() / rate.powi(2), 5.0 * (rate * time).sin() / rate);
            assert!((of("displacement").values[index] - displacement).abs() < 1e-9 * 5.0);
            assert!((of("velocity").values[index] - velocity).abs() < 1e-9 * 5.0);
        }
    }

    #[test]
    fn a_sine_of_amplitude_one_is_a_line_of_height_one() {
        let sine: Vec<f64> = (0..1000).map(|i| 7.0 + (TAU * 0.05 * f64::from(i)).sin()).collect();
        let lines = amplitudes(&sine);
        assert!((lines[50] - 1.0).abs() < 1e-12 && lines[60] < 1e-12 && lines[0] < 1e-12);
    }
}
