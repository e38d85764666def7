//! A force, or an excitation, whose sign is reversed: over the record it takes energy from where it should bring it.

use realfft::num_complex::Complex;

use super::{Fault, Finding, finding, is_sound};
use crate::data::{Channel, Record};
use crate::fit::residual::reversals;
use crate::model::Model;
use crate::numeric::spectrum::hann_lines;

/// Energy over the largest that force and motion could have, below which nothing else explains it; and where the slope of the force
/// over the displacement is negative, too.
const FEEDS: [f64; 2] = [-0.3, -0.02];
/// The same of an excitation: what a delay of the chain makes is less.
const DRIVES: f64 = -0.3;
/// Lines below this part of the frequency that moves most are the chain's drift.
const SLOW: f64 = 0.3;

pub(super) fn of(model: &Model, record: &Record, found: &mut Vec<Finding>) {
    if let (Some(force), Some(displacement)) = (record.channel("force"), record.channel("displacement")) {
        let sound = is_sound(found, force) && is_sound(found, displacement);
        if let Some(fraction) = of_contact(&force.values, &displacement.values).filter(|_| sound) {
            found.push(finding(record, "force", Fault::ReversedSign { fraction }));
        }
        return;
    }
    let driven = record.channels_of("excitation").next();
    let Some((excitation, moved)) = driven.and_then(|one| Some((one, at_the_drive(model, record, one)?)))
    else {
        return;
    };
    let sound = is_sound(found, excitation) && is_sound(found, moved);
    if let Some(fraction) = of_structure(record, excitation, moved).filter(|_| sound) {
        found.push(finding(record, &excitation.name, Fault::ReversedSign { fraction }));
    }
}

/// What a contact takes over the record, as a fraction, where it gives.
fn of_contact(force: &[f64], displacement: &[f64]) -> Option<f64> {
    let turns = reversals(displacement);
    let (&from, &to) = (turns.first()?, turns.last()?);
    let (mut work, mut most) = (0.0, 0.0);
    for k in from..to {
        let one = 0.5 * (force[k] + force[k + 1]) * (displacement[k + 1] - displacement[k]);
        work += one;
        most += one.abs();
    }
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let (f, u) = (mean(&force[from..=to]), mean(&displacement[from..=to]));
    let slope: f64 = (from..=to).map(|k| (force[k] - f) * (displacement[k] - u)).sum();
    let fraction = work / most;
    (turns.len() > 2 && (fraction < FEEDS[0] || fraction < FEEDS[1] && slope < 0.0)).then_some(fraction)
}

/// The channel that shows the motion where `excitation` acts: at the same mass, or where the model excites its beam.
fn at_the_drive<'r>(model: &Model, record: &'r Record, excitation: &Channel) -> Option<&'r Channel> {
    let quantities = ["acceleration", "velocity", "displacement"];
    let place = excitation.name.split_once(':').map(|(_, place)| place.to_owned());
    let place = place.or_else(|| Some(format!("x={}", model.structure.beam()?.excitation_position)));
    let named = place.and_then(|place| {
        quantities.iter().find_map(|quantity| record.channel(&format!("{quantity}:{place}")))
    });
    named.filter(|_| record.channels_of("excitation").count() == 1)
}

/// What the excitation brings, as a fraction, where it takes.
fn of_structure(record: &Record, excitation: &Channel, moved: &Channel) -> Option<f64> {
    let step = record.sample_step()?;
    let order =
        ["displacement", "velocity", "acceleration"].iter().position(|one| *one == moved.quantity())?;
    let (force, motion) = (hann_lines(&excitation.values)?, hann_lines(&moved.values)?);
    let most = (1..force.len()).max_by(|a, b| {
        (force[*a].norm() * motion[*a].norm()).total_cmp(&(force[*b].norm() * motion[*b].norm()))
    })?;
    let (mut power, mut all) = (0.0, 0.0);
    for k in ((SLOW * most as f64) as usize).max(1)..force.len() {
        let speed = std::f64::consts::TAU * k as f64 / (step * excitation.values.len() as f64);
        // The velocity is iω x, or a/(iω).
        let by = Complex::new(0.0, speed).powi(1 - order as i32);
        let velocity = motion[k] * by;
        power += (force[k] * velocity.conj()).re;
        all += force[k].norm() * velocity.norm();
    }
    let fraction = power / all;
    (fraction < DRIVES).then_some(fraction)
}
