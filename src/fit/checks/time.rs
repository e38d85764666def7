//! Time stamps: samples that are missing, and digits that are.

use super::{Fault, Finding, finding, quantile};
use crate::data::Record;

/// Steps without a sample from which time jumps: one lost sample makes two, and stamps that wander by a third of a step at both ends 1.67.
const JUMP: f64 = 1.75;
/// Fraction of steps that may be off in an even record: a clock that wanders makes more.
const UNEVEN: f64 = 0.02;
/// Last digit of the stamps over the step from which rounding moves samples by more than an even record's may be off.
const COARSE: f64 = 0.1;
/// Distance of stamps from multiples of that digit, which numbers of 16 digits keep since 1970, too.
const ROUNDED: f64 = 0.01;

pub(super) fn of(record: &Record, found: &mut Vec<Finding>) {
    let Some(time) = record.time().filter(|time| time.len() > 10) else { return };
    let fault = rounding(record, time).or_else(|| gaps(time));
    found.extend(fault.map(|fault| finding(record, "time", fault)));
}

/// Stretches without samples: after them, the stamps stay late.
fn gaps(time: &[f64]) -> Option<Fault> {
    let steps: Vec<f64> = time.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = quantile(&steps, 0.5);
    let off = steps.iter().filter(|step| (**step / usual - 1.0).abs() > 0.5).count();
    if off as f64 > (UNEVEN * steps.len() as f64).max(1.0) {
        return None;
    }
    // A single late stamp has a short step behind it.
    let stays_late = |at: usize| {
        let around = &steps[at.saturating_sub(1)..(at + 2).min(steps.len())];
        around.iter().sum::<f64>() > (around.len() as f64 - 1.0 + JUMP) * usual
    };
    let places: Vec<usize> =
        (0..steps.len()).filter(|at| steps[*at] > JUMP * usual && stays_late(*at)).collect();
    let &sample = places.first()?;
    let missing = places.iter().map(|at| (steps[*at] / usual).round() as usize - 1).sum();
    Some(Fault::TimeGap { sample, length: steps[sample], missing, count: places.len() })
}

/// The last digit of stamps that are those of an even clock but for their rounding.
fn rounding(record: &Record, time: &[f64]) -> Option<Fault> {
    let (first, last) = (time[0], time[time.len() - 1]);
    let step = (last - first) / (time.len() - 1) as f64;
    if record.sample_step().is_some() || !(step > 0.0 && step.is_finite()) {
        return None;
    }
    // The largest power of ten in a step, and the one below.
    let coarsest = step.log10().floor() as i32;
    let multiple = |digit: f64| {
        time.iter().all(|stamp| {
            let count = (stamp - first) / digit;
            (count - count.round()).abs() < ROUNDED
        })
    };
    let digit = [coarsest, coarsest - 1]
        .map(|power| 10.0_f64.powi(power))
        .into_iter()
        .find(|digit| *digit > COARSE * step && multiple(*digit))?;
    // Both ends are rounded, too.
    let on_line = |(k, stamp): (usize, &f64)| (stamp - first - k as f64 * step).abs() < 1.1 * digit;
    let long =
        time.windows(2).filter(|pair| pair[1] - pair[0] > (step / digit).floor() * digit + 0.5 * digit);
    let long = long.count() as f64 / (time.len() - 1) as f64;
    let both = UNEVEN..1.0 - UNEVEN;
    (both.contains(&long) && time.iter().enumerate().all(on_line))
        .then_some(Fault::RoundedTime { digit, step })
}
