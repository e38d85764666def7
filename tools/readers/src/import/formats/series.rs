//! From series to tables: which belong together, on which times.

use std::collections::BTreeMap;

use super::Series;
use crate::import::heading::quantity_of;
use crate::import::raw::{RawColumn, RawTable};
use crate::import::{Refusal, refuse};

/// Names of a single number that is the rate of the samples (Hz), and of one that is their step (s).
const RATES: [&str; 9] = [
    "fs",
    "rate",
    "sample_rate",
    "samplerate",
    "sampling_rate",
    "sampling_frequency",
    "samplefrequency",
    "srate",
    "sf",
];
const STEPS: [&str; 7] = ["dt", "ts", "step", "delta_t", "time_step", "sample_time", "increment"];

/// One table per group.
pub(in crate::import) fn tables(
    series: Vec<Series>,
    notes: &mut Vec<String>,
) -> Result<Vec<RawTable>, Refusal> {
    let mut order: Vec<String> = Vec::new();
    let mut groups: BTreeMap<String, Vec<Series>> = BTreeMap::new();
    for one in series {
        if !order.contains(&one.group) {
            order.push(one.group.clone());
        }
        groups.entry(one.group.clone()).or_default().push(one);
    }
    // A time, or a rate, beside the groups holds for all of them.
    let shared: Vec<Series> =
        groups.get("").into_iter().flatten().filter(|one| gives_times(one)).cloned().collect();
    let several = order.len() > 1;
    let mut made = Vec::new();
    for name in order {
        let mut members = groups.remove(&name).unwrap_or_default();
        if several && name.is_empty() && members.iter().all(|one| gives_times(one) || one.values.len() < 2) {
            continue;
        }
        if !members.iter().any(gives_times) && !name.is_empty() {
            members.extend(shared.iter().cloned());
        }
        made.extend(table(name, members, notes)?);
    }
    Ok(made)
}

fn gives_times(series: &Series) -> bool {
    series.times.is_some() || quantity_of(&series.name) == Some("time") || step_of(series).is_some()
}

/// The step (s) that a single number stands for.
fn step_of(series: &Series) -> Option<f64> {
    let [value] = series.values[..] else { return None };
    let name = series.name.to_lowercase();
    let name = name.split(['[', '(']).next().unwrap_or_default().trim().replace(' ', "_");
    let name = name.trim_end_matches("_hz").trim_end_matches("_s");
    let step = match (RATES.contains(&name), STEPS.contains(&name)) {
        (true, _) => 1.0 / value,
        (_, true) => value,
        _ => return None,
    };
    (step.is_finite() && step > 0.0).then_some(step)
}

/// The series of one group on one time base.
fn table(name: String, members: Vec<Series>, notes: &mut Vec<String>) -> Result<Option<RawTable>, Refusal> {
    let step = members.iter().find_map(|one| Some((step_of(one)?, one.name.clone())));
    let (long, single): (Vec<Series>, Vec<Series>) =
        members.into_iter().partition(|one| one.values.len() > 1);
    let ignored: Vec<String> =
        single.iter().filter(|one| step_of(one).is_none()).map(|one| format!("`{}`", one.name)).collect();
    if !ignored.is_empty() {
        notes.push(format!("single values were not used: {}", ignored.join(", ")));
    }
    let Some(rows) = long.iter().map(|one| one.values.len()).max() else { return Ok(None) };
    let time = long.iter().position(|one| quantity_of(&one.name) == Some("time"));
    let mut columns = Vec::new();
    let base: Option<Vec<f64>> =
        match (time, long.iter().find_map(|one| one.times.filter(|_| one.values.len() == rows)), &step) {
            (Some(_), ..) => None,
            (None, Some(times), _) => Some(equal(times, rows)),
            (None, None, Some((step, from))) => {
                notes.push(format!("time stamps are those of equal steps of {step} s (`{from}`)"));
                Some(equal([0.0, *step], rows))
            }
            _ => None,
        };
    if let Some(base) = &base {
        columns.push(RawColumn::new("time [s]", None, base.clone()));
    }
    let stamps = time.map(|at| long[at].values.clone()).or(base);
    let rows = stamps.as_ref().map_or(rows, Vec::len);
    for one in long {
        let values = if one.values.len() == rows && !differs(&one, stamps.as_deref()) {
            one.values
        } else {
            match (one.times, &stamps) {
                (Some(times), Some(stamps)) => {
                    let note = "`{}` has samples of its own ({} values): straight lines give it at the {} times of the others";
                    let filled = [one.name.clone(), one.values.len().to_string(), rows.to_string()];
                    notes
                        .push(filled.iter().fold(note.to_owned(), |text, part| text.replacen("{}", part, 1)));
                    resampled(&one.values, times, stamps)
                }
                _ => {
                    notes.push(format!(
                        "`{}` has {} values, not {rows}, and was not used",
                        one.name,
                        one.values.len()
                    ));
                    continue;
                }
            }
        };
        columns.push(RawColumn { clock: one.clock, ..RawColumn::new(&one.name, one.unit, values) });
    }
    if columns.len() < 2 {
        return match name.is_empty() {
            true => Err(refuse(
                "it holds no two series of the same length",
                "store time stamps and signals with one length",
            )),
            false => Ok(None),
        };
    }
    Ok(Some(RawTable { name, columns }))
}

/// Whether the samples of a series lie at other times than the stamps, by more than a thousandth of a step.
fn differs(series: &Series, stamps: Option<&[f64]>) -> bool {
    let (Some([start, step]), Some(stamps)) = (series.times, stamps) else { return false };
    let last = stamps.len() - 1;
    (start - stamps[0]).abs() > 1e-3 * step || (start + last as f64 * step - stamps[last]).abs() > 1e-3 * step
}

fn equal([start, step]: [f64; 2], rows: usize) -> Vec<f64> {
    (0..rows).map(|row| start + row as f64 * step).collect()
}

/// Values at `stamps` by straight lines; NaN beyond the ends.
fn resampled(values: &[f64], [start, step]: [f64; 2], stamps: &[f64]) -> Vec<f64> {
    let at = |time: &f64| {
        let place = (time - start) / step;
        let floor = place.floor();
        if floor < 0.0 || place > (values.len() - 1) as f64 {
            return f64::NAN;
        }
        let index = floor as usize;
        let next = values[(index + 1).min(values.len() - 1)];
        values[index] + (place - floor) * (next - values[index])
    };
    stamps.iter().map(at).collect()
}
