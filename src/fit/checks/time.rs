//! Time stamps, and records that were moving when they are said to begin at rest.

use super::{Fault, Finding, finding, largest, quantile};
use crate::data::{Record, Regime};
use crate::fit::predict::white_noise;

/// Steps without a sample from which time jumps, and fraction of steps that may be off in an even record.
const JUMP: f64 = 2.5;
const UNEVEN: f64 = 0.02;
/// First value over the largest from which a record moves: of a contact, and of a structure, whose noise is larger.
const MOVES: [f64; 2] = [0.1, 0.3];
/// Mean over the largest value from which a displacement has an offset, or a static part, that says nothing of its start.
const OFFSET: f64 = 0.1;
/// An excitation that starts below this part of its largest value starts nothing by itself.
const SMALL: f64 = 0.05;
/// Standard deviations of noise.
const CERTAIN: f64 = 12.0;

pub(super) fn of(record: &Record, found: &mut Vec<Finding>) {
    gap(record, found);
    if record.regime == Regime::FromRest {
        at_rest(record, found);
    }
}

fn gap(record: &Record, found: &mut Vec<Finding>) {
    let Some(time) = record.time() else { return };
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = quantile(&steps, 0.5);
    let off = steps.iter().filter(|step| (**step / usual - 1.0).abs() > 0.5).count();
    if steps.len() < 10 || off as f64 > (UNEVEN * steps.len() as f64).max(1.0) {
        return;
    }
    let Some(sample) = steps.iter().position(|step| *step > JUMP * usual) else { return };
    let length = steps[sample];
    let missing = (length / usual).round() as usize - 1;
    found.push(finding(record, "time", Fault::TimeGap { sample, length, missing }));
}

fn at_rest(record: &Record, found: &mut Vec<Finding>) {
    let first = |values: &[f64]| values.first().map_or(0.0, |first| first.abs());
    let starts_gently =
        record.channels_of("excitation").all(|one| first(&one.values) < SMALL * largest(&one.values));
    let structure = record.channels_of("excitation").next().is_some();
    for channel in &record.channels {
        let (values, most) = (&channel.values, largest(&channel.values));
        let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
        let tells = match channel.quantity() {
            "displacement" if structure => starts_gently && mean.abs() < OFFSET * most,
            "displacement" => true,
            "velocity" => structure,
            "acceleration" => starts_gently,
            _ => false,
        };
        let moves = MOVES[usize::from(structure)] * most;
        if tells && first(values) > moves.max(CERTAIN * white_noise(values)) {
            let fraction = first(values) / most;
            found.push(finding(record, &channel.name, Fault::MovingAtStart { fraction }));
        }
    }
}
