//! Responses from tables, steady records and sweeps.

use realfft::num_complex::Complex;
use stickslip::data::{Channel, Record, Regime};
use stickslip::diagnose::Comparison;
use stickslip::fit::residual::drive;
use stickslip::harmonic::{fourier, whole_periods};

use super::{Curve, Point, Response, Source, swept};
use crate::comparison::summary::{self, compared_channels};

/// All curves, those of steady records together by channel.
pub fn curves(comparison: &Comparison) -> Vec<Curve> {
    let mut found: Vec<Curve> = Vec::new();
    for (index, record) in comparison.records.iter().enumerate() {
        for (name, _) in compared_channels(comparison, index) {
            let Some(measured) = summary::channel(record, &name) else { continue };
            let curve = match record.regime {
                Regime::SteppedSine => table(comparison, index, measured),
                Regime::Backbone => None,
                Regime::Steady => steady(comparison, index, measured),
                _ => sweep(comparison, index, measured),
            };
            let Some(curve) = curve else { continue };
            let same = |other: &&mut Curve| {
                let steady = [curve.source, other.source] == [Source::Steady; 2];
                steady && other.channel == curve.channel && other.drive == curve.drive
            };
            match found.iter_mut().find(same) {
                Some(group) => group.points.extend(curve.points),
                None => found.push(curve),
            }
        }
    }
    found
}

/// Unit of `channel` over `drive`, and how often the displacement is differentiated in it.
fn unit(channel: &Channel, drive: &Channel) -> Option<(&'static str, Option<i32>)> {
    let force = drive.unit == "N";
    match channel.quantity() {
        "acceleration" if force => Some(("m/s^2/N", Some(2))),
        "velocity" if force => Some(("m/s/N", Some(1))),
        "displacement" if force => Some(("m/N", Some(0))),
        "force" if drive.unit == "m" => Some(("N/m", None)),
        _ => None,
    }
}

fn curve(record: &Record, channel: &Channel, drive: &Channel, source: Source) -> Option<Curve> {
    let (unit, order) = unit(channel, drive)?;
    let (record, drive) = (record.name.clone(), (drive.name.clone(), drive.unit));
    Some(Curve { channel: channel.name.clone(), drive, unit, order, record, source, points: Vec::new() })
}

fn table(comparison: &Comparison, index: usize, measured: &Channel) -> Option<Curve> {
    let record = &comparison.records[index];
    let frequency = &record.channel("frequency")?.values;
    let force = record.channels_of("excitation").next()?;
    let phase_name = match measured.name.split_once(':') {
        Some((_, place)) => format!("phase:{place}"),
        None => "phase".to_owned(),
    };
    let value = |values: &[f64], row: usize| values.get(row).copied().filter(|value| value.is_finite());
    let phases = summary::channel(record, &phase_name);
    let mut curve = curve(record, measured, force, Source::Table)?;
    for (row, (&frequency, &level)) in frequency.iter().zip(&force.values).enumerate() {
        let response = |amplitude: &[f64], phase: Option<&[f64]>| {
            let size = value(amplitude, row)? / level;
            let phase = phase.and_then(|phase| value(phase, row));
            size.is_finite().then_some(Response { size, phase })
        };
        let Some(measured_here) = response(&measured.values, phases.map(|one| &one.values[..])) else {
            continue;
        };
        let predicted = comparison.stages.iter().map(|stage| {
            let phase = summary::prediction(stage, index, &phase_name).map(|one| &one.predicted[..]);
            response(&summary::prediction(stage, index, &measured.name)?.predicted, phase)
        });
        curve.points.push(Point {
            frequency,
            level,
            measured: measured_here,
            predicted: predicted.collect(),
        });
    }
    (!curve.points.is_empty()).then_some(curve)
}

/// The ratio of first harmonics as a response.
fn ratio(response: Complex<f64>, drive: Complex<f64>) -> Option<Response> {
    let ratio = response / drive;
    (ratio.norm().is_finite()).then(|| Response { size: ratio.norm(), phase: Some(ratio.arg()) })
}

/// A point of each stretch: `first` gives the first harmonic of a column in it, `frequency` its frequency (Hz).
fn point(
    comparison: &Comparison,
    index: usize,
    (measured, drive): (&Channel, &Channel),
    frequency: f64,
    first: impl Fn(&[f64]) -> Complex<f64>,
) -> Option<Point> {
    let driven = first(&drive.values);
    let length = measured.values.len();
    let predicted = comparison.stages.iter().map(|stage| {
        let values = &summary::prediction(stage, index, &measured.name)?.predicted;
        (values.len() == length).then(|| ratio(first(values), driven)).flatten()
    });
    let predicted = predicted.collect();
    Some(Point {
        frequency,
        level: driven.norm(),
        measured: ratio(first(&measured.values), driven)?,
        predicted,
    })
}

fn steady(comparison: &Comparison, index: usize, measured: &Channel) -> Option<Curve> {
    let record = &comparison.records[index];
    let (step, drive) = (record.sample_step()?, drive(record, measured)?);
    let periods = whole_periods(&drive.values)?;
    let frequency = periods as f64 / (step * drive.values.len() as f64);
    let first = |values: &[f64]| {
        let coefficients = fourier::from_samples(values, periods, 1);
        Complex::new(coefficients[1], -coefficients[2])
    };
    let mut curve = curve(record, measured, drive, Source::Steady)?;
    curve.record.clear();
    curve.points.push(point(comparison, index, (measured, drive), frequency, first)?);
    Some(curve)
}

fn sweep(comparison: &Comparison, index: usize, measured: &Channel) -> Option<Curve> {
    let record = &comparison.records[index];
    let drive = drive(record, measured).filter(|drive| drive.values.len() == measured.values.len())?;
    let mut curve = curve(record, measured, drive, Source::Sweep)?;
    let stretches = swept::stretches(record.time()?, &drive.values)?;
    curve.points.extend(stretches.iter().filter_map(|stretch| {
        point(comparison, index, (measured, drive), stretch.frequency, |values| stretch.first(values))
    }));
    (!curve.points.is_empty()).then_some(curve)
}
