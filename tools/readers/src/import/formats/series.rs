//! From series to tables: which belong together, on which times.

use std::collections::BTreeMap;

use super::Series;
use crate::import::heading::{quantity_of, unit_spelling};
use crate::import::raw::{RawColumn, RawTable};
use crate::import::{Refusal, refuse};
use crate::units::Unit;

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

/// Steps that differ by less than this part of them agree.
const AGREES: f64 = 1e-3;

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
    series.times.is_some() || quantity_of(&series.name) == Some("time") || base_of(series).is_some()
}

/// What a single number says of the samples.
struct Base {
    is_rate: bool,
    value: f64,
    unit: Option<String>,
}

/// The rate or step that a single number stands for: `dt`, `fs [kHz]`, `rate_hz`, with its unit in the name or beside it.
fn base_of(series: &Series) -> Option<Base> {
    let [value] = series.values[..] else { return None };
    let is_rate = |name: &str| {
        let name = name.trim().to_lowercase().replace(' ', "_");
        RATES.contains(&name.as_str()).then_some(true).or(STEPS.contains(&name.as_str()).then_some(false))
    };
    let name = series.name.trim();
    let (is_rate, unit) = match (name.split_once(['[', '(']), name.rsplit_once(['_', ' '])) {
        (Some((words, unit)), _) => (is_rate(words)?, Some(unit.trim_end_matches([']', ')']).to_owned())),
        (None, behind) => match (is_rate(name), behind) {
            (Some(is_rate), _) => (is_rate, series.unit.clone()),
            (None, Some((words, unit))) => {
                let is_rate = is_rate(words)?;
                seconds(1.0, is_rate, unit)?;
                (is_rate, Some(unit.to_owned()))
            }
            (None, None) => return None,
        },
    };
    (value.is_finite() && value > 0.0).then_some(Base { is_rate, value, unit })
}

/// The step (s) of a step or rate in `unit`; `None` where that measures neither.
fn seconds(value: f64, is_rate: bool, unit: &str) -> Option<f64> {
    let spelling = match unit_spelling(unit) {
        unit if ["hz", "s/s", "sa/s", "samples/s"].contains(&unit.to_lowercase().as_str()) => "Hz".to_owned(),
        unit if ["khz", "ks/s"].contains(&unit.to_lowercase().as_str()) => "kHz".to_owned(),
        unit => unit,
    };
    let own = Unit::common(&spelling)?;
    let value = own.conversion(&Unit::common(if is_rate { "Hz" } else { "s" })?).ok()?.apply(value);
    Some(if is_rate { 1.0 / value } else { value })
}

/// The step (s) that single numbers give, and the name of the first of them: they must agree.
pub(super) fn step_of<'s>(
    members: impl IntoIterator<Item = &'s Series>,
) -> Result<Option<(f64, String)>, String> {
    let mut found: Option<(f64, String)> = None;
    for one in members {
        let Some(base) = base_of(one) else { continue };
        let unit = base.unit.unwrap_or_else(|| if base.is_rate { "Hz" } else { "s" }.to_owned());
        let step = seconds(base.value, base.is_rate, &unit).ok_or_else(|| {
            let kind = if base.is_rate { "frequency" } else { "time" };
            format!("`{}` is in `{unit}`, which is no unit of {kind} that is known", one.name)
        })?;
        match &found {
            None => found = Some((step, one.name.clone())),
            Some((first, name)) if (step - first).abs() > AGREES * first => {
                let other = &one.name;
                return Err(format!(
                    "`{name}` and `{other}` contradict each other: steps of {first} s and of {step} s"
                ));
            }
            Some(_) => {}
        }
    }
    Ok(found)
}

/// The series of one group on one time base.
fn table(name: String, members: Vec<Series>, notes: &mut Vec<String>) -> Result<Option<RawTable>, Refusal> {
    let (long, single): (Vec<Series>, Vec<Series>) =
        members.into_iter().partition(|one| one.values.len() > 1);
    let ignored: Vec<String> =
        single.iter().filter(|one| base_of(one).is_none()).map(|one| format!("`{}`", one.name)).collect();
    if !ignored.is_empty() {
        notes.push(format!("single values were not used: {}", ignored.join(", ")));
    }
    let Some(rows) = long.iter().map(|one| one.values.len()).max() else { return Ok(None) };
    let time = long.iter().position(|one| quantity_of(&one.name) == Some("time"));
    // Time stamps go before all that single numbers say.
    let step = match time {
        Some(_) => None,
        None => {
            step_of(&single).map_err(|reason| refuse(reason, "store the one that is right, with its unit"))?
        }
    };
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
