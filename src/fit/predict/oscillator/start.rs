//! The state in which a record of an oscillator begins, where nobody knows it.

use super::OscillatorRecord;
use super::run::Run;
use crate::fit::{self, Options, Parameter, Scale};
use crate::model::Model;

/// Share of a record by which its start is judged: a damped structure forgets it.
const SHARE: f64 = 0.25;
/// Samples by which displacement and velocity at the start are read off the data.
const READ: usize = 7;
/// Bounds of the start over the motion's own size.
const ROOM: f64 = 10.0;
/// Contact forces to begin the search with, as shares of the limit.
const FORCES: [f64; 3] = [0.0, -0.8, 0.8];
/// Gauss–Newton steps of each search: the motion is nearly linear in its start.
const STEPS: usize = 15;

/// The state of the first sample: displacements and velocities of the masses and the contact's force. What hangs at
/// the contact moves with it.
pub(super) fn state(
    run: &mut Run,
    model: &Model,
    masses: usize,
    nuisances: &[f64],
) -> Result<Vec<f64>, String> {
    if nuisances.len() != count(masses) {
        return Err(format!("{} numbers for a start that has {}", nuisances.len(), count(masses)));
    }
    let at = match &model.structure {
        crate::model::Structure::Oscillator(oscillator) => oscillator.contact.unwrap_or(0),
        _ => 0,
    };
    let part = |from: usize| {
        let mut part = nuisances[from..from + masses].to_vec();
        part.resize(run.size(), nuisances[from + at]);
        part
    };
    let (displacement, velocity) = (part(0), part(masses));
    Ok(run.begin(&displacement, &velocity, nuisances[2 * masses]))
}

fn count(masses: usize) -> usize {
    2 * masses + 1
}

/// Finds the start that fits the first part of the record best.
pub(super) fn search(record: &OscillatorRecord, model: &Model) -> Result<Vec<Parameter>, String> {
    let read = read(record, model)?;
    let samples = ((record.samples as f64 * SHARE) as usize).max(READ).min(record.samples);
    let weights: Vec<f64> = record
        .channels
        .iter()
        .map(|channel| {
            let squares = channel.values[..samples].iter().map(|x| x * x).sum::<f64>();
            if squares > 0.0 { squares.sqrt().recip() } else { 1.0 }
        })
        .collect();
    let residual = |nuisances: &[f64], out: &mut [f64]| -> Result<(), String> {
        let mut predicted = Vec::new();
        record.simulate(model, nuisances, samples, &mut predicted)?;
        let measured = record.channels.iter().zip(&weights).zip(predicted.chunks_exact(samples));
        let residuals = measured.flat_map(|((channel, weight), predicted)| {
            channel.values.iter().zip(predicted).map(move |(measured, value)| (value - measured) * weight)
        });
        out.iter_mut().zip(residuals).for_each(|(out, residual)| *out = residual);
        Ok(())
    };
    let options = Options { max_iterations: STEPS, tolerance: 1e-7, ..Options::default() };
    let mut best: Option<fit::Fit> = None;
    let force = read.last().copied();
    for share in FORCES {
        let mut start = read.clone();
        if let (Some(force), Some(read)) = (start.last_mut(), force) {
            force.start = share * read.upper;
        }
        let fit = fit::fit(residual, samples * record.channels.len(), &start, &options)
            .map_err(|error| error.to_string())?;
        if best.as_ref().is_none_or(|best| fit.root_mean_square < best.root_mean_square) {
            best = Some(fit);
        }
    }
    let found = best.map(|fit| fit.parameters).unwrap_or_default();
    Ok(read.into_iter().zip(found).map(|(parameter, start)| Parameter { start, ..parameter }).collect())
}

/// Displacements and velocities at the first sample as far as they were measured, with their bounds.
fn read(record: &OscillatorRecord, model: &Model) -> Result<Vec<Parameter>, String> {
    let structure = model.assembled().map_err(|error| error.to_string())?;
    let law_limit = structure.law.as_ref().map_or(0.0, |law| law.limit(structure.normal_load));
    let slowest = structure.structure.natural_modes().map_err(|error| error.to_string())?;
    let rate = slowest.angular_frequency.iter().copied().find(|omega| *omega > 0.0);
    // A free structure moves at the pace of the record.
    let rate = rate.unwrap_or(1.0 / (record.inputs.step * record.samples as f64));
    // The size of the motion: of displacements, or of what they would be at the lowest frequency.
    let mut size = 0.0_f64;
    for (channel, observed) in record.channels.iter().zip(&record.observed) {
        let largest = channel.values.iter().fold(0.0_f64, |largest, x| largest.max(x.abs()));
        size = size.max(largest / rate.powi(observed.order as i32));
    }
    if size == 0.0 {
        size = 1.0;
    }
    let around = |start: f64, size: f64| Parameter {
        start,
        lower: -ROOM * size,
        upper: ROOM * size,
        scale: Scale::Linear,
    };
    let n = record.masses;
    let mut parameters: Vec<Parameter> =
        (0..2 * n).map(|i| around(0.0, if i < n { size } else { size * rate * ROOM })).collect();
    for (channel, observed) in record.channels.iter().zip(&record.observed) {
        let (value, slope) = line(&channel.values, record.inputs.step);
        match observed.order {
            0 => {
                parameters[observed.mass].start = value;
                let velocity = &mut parameters[n + observed.mass].start;
                if *velocity == 0.0 {
                    *velocity = slope;
                }
            }
            1 => parameters[n + observed.mass].start = value,
            _ => {}
        }
    }
    let force = if law_limit.is_finite() && law_limit > 0.0 { law_limit } else { 0.0 };
    // Equal bounds hold a force that there is not.
    parameters.push(Parameter { start: 0.0, lower: -force, upper: force, scale: Scale::Linear });
    Ok(parameters)
}

/// Value and slope at the first sample, by a straight line through a few.
fn line(values: &[f64], step: f64) -> (f64, f64) {
    let count = values.len().min(READ);
    let mean = values[..count].iter().sum::<f64>() / count as f64;
    let middle = 0.5 * (count as f64 - 1.0);
    let (mut above, mut below) = (0.0, 0.0);
    for (index, value) in values[..count].iter().enumerate() {
        let offset = index as f64 - middle;
        above += offset * (value - mean);
        below += offset * offset;
    }
    let slope = if below > 0.0 { above / below } else { 0.0 };
    (mean - slope * middle, slope / step)
}
