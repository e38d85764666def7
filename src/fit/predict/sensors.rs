//! What faulty sensors show of a prediction.

use std::f64::consts::TAU;

use nalgebra::Complex;
use realfft::RealFftPlanner;

use super::motion::read_at;
use crate::data::{Channel, Record, Regime};
use crate::effects::SensorFault;
use crate::model::Model;

/// The fault of `channel` under `model`, if it has one.
pub(crate) fn fault(model: &Model, channel: &Channel) -> Option<SensorFault> {
    if model.effects.is_empty() {
        return None;
    }
    model.changes().sensors.into_iter().find(|fault| fault.channel == channel.name)
}

/// Turns the true motion `values` of `channel` into what the model's faulty sensors show of it.
///
/// A steady record is late by the phases of its harmonics; elsewhere values are read between samples as
/// [`read_at`] does. What a sensor shows of the time after the record follows from no input and is taken as measured.
/// With `timed` the values are those of the moments that the sensor shows already. In a table a delay turns phases and
/// a gain scales amplitudes; nothing else of a fault shows there.
pub(crate) fn apply(model: &Model, record: &Record, channel: &Channel, timed: bool, values: &mut [f64]) {
    let Some(fault) = fault(model, channel) else { return };
    if record.regime.is_table() {
        return tabulate(&fault, record, channel, values);
    }
    let mut foretold = values.len();
    if !timed
        && !fault.is_on_time()
        && let Some(step) = record.sample_step()
    {
        let place = |index| fault.place(index, step);
        match record.regime {
            Regime::Steady => turn(values, fault.delay / step),
            _ => {
                foretold =
                    (0..values.len()).take_while(|index| place(*index) <= (values.len() - 1) as f64).count();
                values.copy_from_slice(&read_at(values, place));
            }
        }
    }
    let (shown, after) = values.split_at_mut(foretold);
    for value in shown {
        *value = fault.gain * *value + fault.bias;
    }
    after.copy_from_slice(&channel.values[foretold..]);
}

/// The same of a column of a table.
fn tabulate(fault: &SensorFault, record: &Record, channel: &Channel, values: &mut [f64]) {
    match (channel.quantity(), record.channel("frequency")) {
        ("phase", Some(frequency)) => {
            values.iter_mut().zip(&frequency.values).for_each(|(phase, f)| *phase -= TAU * f * fault.delay);
        }
        ("displacement" | "velocity" | "acceleration", _) => {
            values.iter_mut().for_each(|amplitude| *amplitude *= fault.gain);
        }
        _ => {}
    }
}

/// Moves `values`, whose first follows the last, later by `samples`, which need not be whole: every line of their
/// spectrum keeps its size.
fn turn(values: &mut [f64], samples: f64) {
    let count = values.len();
    let mut planner = RealFftPlanner::<f64>::new();
    let (forward, inverse) = (planner.plan_fft_forward(count), planner.plan_fft_inverse(count));
    let mut spectrum = forward.make_output_vec();
    if count < 2 || forward.process(values, &mut spectrum).is_err() {
        return;
    }
    for (line, value) in spectrum.iter_mut().enumerate() {
        *value *= Complex::from_polar(1.0 / count as f64, -TAU * line as f64 * samples / count as f64);
    }
    // What lies at half the sampling rate has no phase.
    spectrum[0].im = 0.0;
    if count.is_multiple_of(2) {
        spectrum[count / 2].im = 0.0;
    }
    let mut moved = inverse.make_output_vec();
    if inverse.process(&mut spectrum, &mut moved).is_ok() {
        values.copy_from_slice(&moved);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::predict::predict;

    #[test]
    fn a_late_line_lies_lower_by_its_slope() {
        for samples in [0.0, 0.3, 2.0, 2.75, -1.5] {
            let line: Vec<f64> = (0..20).map(f64::from).collect();
            let fault = SensorFault {
                channel: "force".to_owned(),
                delay: 0.1 * samples,
                clock_error: 0.0,
                gain: 1.0,
                bias: 0.0,
            };
            let shown = read_at(&line, |index| fault.place(index, 0.1));
            for (index, value) in shown.iter().enumerate() {
                assert!((value - (index as f64 - samples).max(0.0)).abs() < 1e-12, "{samples}: {value}");
            }
        }
    }

    #[test]
    fn what_comes_after_the_record_is_not_foretold() {
        let model = |effect: &str| {
            Model::parse(&format!(
                "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n[[mass]]\nname = \"m\"\nmass = 1.0\n[[spring]]\n\
                 between = [\"ground\", \"m\"]\nstiffness = 1e4\ndamping = 2.0\n{effect}"
            ))
            .unwrap()
        };
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let force = |i: u32| (0.2 * f64::from(i)).sin();
        let record = |count: u32, shown: Vec<f64>| Record {
            name: "r".into(),
            regime: Regime::FromRest,
            use_for: None,
            channels: vec![
                channel("time", "s", (0..count).map(|i| 1e-3 * f64::from(i)).collect()),
                channel("excitation:m", "N", (0..count).map(force).collect()),
                channel("displacement:m", "m", shown),
            ],
        };
        // By a clock 1 % fast, of a motion that goes on.
        let fast =
            "[[effect]]\nid = \"sensor_clock_drift\"\nchannel = \"displacement:m\"\nclock_error = 0.01\n";
        let on_time = predict(&model(""), &record(1100, vec![0.0; 1100])).unwrap().remove(0).values;
        let measured = read_at(&on_time, |index| 1.01 * index as f64)[..1000].to_vec();
        let largest = measured.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let shown = predict(&model(fast), &record(1000, measured.clone())).unwrap().remove(0).values;
        let off = shown.iter().zip(&measured).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(off < 1e-4 * largest, "{off} of {largest}");
    }

    #[test]
    fn a_periodic_record_comes_round() {
        let mut values = vec![0.0, 1.0, 2.0, 3.0];
        turn(&mut values, 1.0);
        for (value, expected) in values.iter().zip([3.0, 0.0, 1.0, 2.0]) {
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
    }

    #[test]
    fn a_late_wave_of_a_periodic_record_keeps_its_height() {
        for (count, samples) in [(64, 0.37), (63, -2.6)] {
            let wave = |at: f64| 0.4 + (TAU * 9.0 * at / f64::from(count)).cos();
            let mut values: Vec<f64> = (0..count).map(|index| wave(f64::from(index))).collect();
            turn(&mut values, samples);
            for (index, value) in (0..).zip(&values) {
                assert!((value - wave(f64::from(index) - samples)).abs() < 1e-12, "{index}: {value}");
            }
        }
    }
}
