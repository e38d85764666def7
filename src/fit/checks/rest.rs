//! Records that were moving when they are said to begin at rest.

use nalgebra::{DMatrix, DVector};

use super::dynamic::Linear;
use super::{Fault, Finding, finding, hum, is_sound, largest, quantile};
use crate::data::{Channel, Record, Regime};
use crate::fit::predict::white_noise;
use crate::model::{Model, Structure};

/// First displacement of a contact over the largest from which it moves.
const MOVED: f64 = 0.1;
/// First force of a contact from which it had slipped: over the largest, and over half of the range from its middle. From rest it is zero,
/// or a sensor's offset, which moves the middle as far.
const LOADED: f64 = 0.25;
/// Part of its range by which a displacement goes to both sides of its start, so that the middle of the force is that of a loop.
const BOTH: f64 = 0.2;
/// First value of a structure's channel over the largest from which it moves, where the excitation starts gently.
const MOVES: f64 = 0.3;
/// Mean over the largest value from which a displacement has an offset, or a static part, that says nothing of its start.
const OFFSET: f64 = 0.1;
/// An excitation that starts below this part of its largest value starts nothing by itself.
const SMALL: f64 = 0.05;
/// Standard deviations of noise.
const CERTAIN: f64 = 12.0;
/// Frequencies of the machine over those of the model that a first period is compared with: those of a first guess are within a
/// factor of two.
const FASTER: [f64; 9] = [0.5, 0.6, 0.7, 0.84, 1.0, 1.2, 1.4, 1.7, 2.0];
/// Part of the first period that the excitation does not explain, over that period; and over the whole channel, which noise does not reach.
const UNDRIVEN: [f64; 2] = [0.3, 0.12];
/// Samples of a period from which its course is seen.
const SEEN: usize = 12;
/// What is not explained, over the hum that the line at the frequencies of the mains would be, from which it is no hum.
const HUM: f64 = 1.2;

pub(super) fn of(model: &Model, linear: Option<&Linear>, record: &Record, found: &mut Vec<Finding>) {
    if record.regime != Regime::FromRest {
        return;
    }
    if record.channels_of("excitation").next().is_none() {
        of_contact(record, found);
    } else {
        of_structure(model, linear, record, found);
    }
}

fn first(values: &[f64]) -> f64 {
    values.first().map_or(0.0, |first| first.abs())
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// A contact that is displaced, or loaded, at its first sample.
fn of_contact(record: &Record, found: &mut Vec<Finding>) {
    let Some(displacement) = record.channel("displacement") else { return };
    let part = |channel: &Channel| first(&channel.values) / largest(&channel.values);
    let noise = |channel: &Channel| CERTAIN * white_noise(&channel.values);
    let most = largest(&displacement.values);
    let channel = if first(&displacement.values) > (MOVED * most).max(noise(displacement)) {
        displacement
    } else {
        let Some(force) = record.channel("force") else { return };
        let [from_middle, range] = about_middle(&force.values);
        let [aside, width] = about_middle(&displacement.values);
        let is_loop = 0.5 * width - aside > BOTH * width;
        if !is_loop || part(force) < LOADED || from_middle < (LOADED * 0.5 * range).max(noise(force)) {
            return;
        }
        force
    };
    found.push(finding(record, &channel.name, Fault::MovingAtStart { fraction: part(channel) }));
}

/// How far from the middle of nearly all values the first one is, and their range.
fn about_middle(values: &[f64]) -> [f64; 2] {
    let [low, high] = [0.01, 0.99].map(|fraction| quantile(values, fraction));
    [(values.first().copied().unwrap_or(0.0) - 0.5 * (low + high)).abs(), high - low]
}

/// A structure that moves before its excitation has moved it.
fn of_structure(model: &Model, linear: Option<&Linear>, record: &Record, found: &mut Vec<Finding>) {
    let gently =
        record.channels_of("excitation").all(|one| first(&one.values) < SMALL * largest(&one.values));
    // A sign that is reversed is told by itself, as are errors of the logger: neither is a response to the excitation.
    let spoilt = record.channels_of("excitation").any(|one| !is_sound(found, one))
        || found.iter().any(|one| matches!(one.fault, Fault::ReversedSign { .. }));
    for channel in &record.channels {
        let (values, most) = (&channel.values, largest(&channel.values));
        let tells = match channel.quantity() {
            "displacement" => gently && mean(values).abs() < OFFSET * most,
            "velocity" => true,
            "acceleration" => gently,
            _ => false,
        };
        let fault = if tells && first(values) > (MOVES * most).max(CERTAIN * white_noise(values)) {
            Some(Fault::MovingAtStart { fraction: first(values) / most })
        } else {
            let linear = linear.filter(|_| !spoilt && is_sound(found, channel));
            linear.and_then(|linear| undriven(model, linear, record, channel))
        };
        found.extend(fault.map(|fault| finding(record, &channel.name, fault)));
    }
}

/// What of an oscillator's first period is no response to its excitation. A beam's many modes are not known so well.
fn undriven(model: &Model, linear: &Linear, record: &Record, channel: &Channel) -> Option<Fault> {
    let Structure::Oscillator(_) = model.structure else { return None };
    let order =
        ["displacement", "velocity", "acceleration"].iter().position(|one| *one == channel.quantity())?;
    let (_, output) = channel.name.split_once(':')?;
    let mut driven = record.channels_of("excitation");
    let (excitation, None) = (driven.next()?, driven.next()) else { return None };
    let step = record.sample_step()?;
    let lowest = linear.natural_frequencies()[0].iter().copied().find(|one| *one > 0.0)?;
    let count = (1.0 / (lowest * step)).ceil() as usize;
    if count < SEEN || channel.values.len() < 2 * count {
        return None;
    }
    let (force, values) = (&excitation.values[..count], &channel.values[..count]);
    let left = FASTER
        .iter()
        .filter_map(|faster| linear.response_from_rest(output, order, force, step, *faster))
        .map(|driven| unexplained(values, &driven))
        .fold(f64::INFINITY, f64::min);
    let middle = mean(&channel.values);
    let size = |values: &[f64]| {
        (values.iter().map(|x| (x - middle).powi(2)).sum::<f64>() / values.len() as f64).sqrt()
    };
    let fraction = left / size(values);
    let least = (UNDRIVEN[1] * size(&channel.values))
        .max(HUM * std::f64::consts::FRAC_1_SQRT_2 * hum::at_mains(&channel.values, step));
    (left.is_finite() && fraction > UNDRIVEN[0] && left > least)
        .then_some(Fault::MovingUndriven { fraction: fraction.min(1.0) })
}

/// Root mean square of what `values` have beside an offset and positive parts of the responses `driven`: a machine has another mass than its
/// model, and its contact sticks at times.
fn unexplained(values: &[f64], driven: &[Vec<f64>]) -> f64 {
    let [free, stuck] = driven else { return f64::INFINITY };
    let target = DVector::from_column_slice(values);
    let left = |columns: &[&Vec<f64>]| {
        let entry = |row: usize, column: usize| {
            columns.get(column).map_or(1.0, |one| one[row] / largest(one).max(f64::MIN_POSITIVE))
        };
        let matrix = DMatrix::from_fn(values.len(), columns.len() + 1, entry);
        let parts = matrix.clone().svd(true, true).solve(&target, 1e-9).ok()?;
        let positive = parts.iter().take(columns.len()).all(|part| *part >= 0.0);
        positive.then(|| (matrix * parts - &target).norm() / (values.len() as f64).sqrt())
    };
    [&[][..], &[free], &[stuck], &[free, stuck]].into_iter().filter_map(left).fold(f64::INFINITY, f64::min)
}
