//! What a comparison says, computed once for the page, the terminal and the JSON.

use stickslip::data::{Channel, Record, Regime};
use stickslip::diagnose::{ChannelResult, Comparison, Stage};

use crate::format::{self, Scale};

/// The one channel that every record is compared in.
#[derive(Debug, Clone, PartialEq)]
pub struct CommonChannel {
    pub name: String,
    pub unit: &'static str,
}

/// Stages up to which the gain of each is told in the verdict.
const FEW: usize = 4;

/// The verdict in words, with the numbers behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// One sentence.
    pub verdict: String,
    /// What a reader must know beside it: failures, a better stage in between.
    pub notes: Vec<String>,
    /// Index and reason of every record that a stage does not predict: it counts in no error here.
    pub skipped: Vec<(usize, String)>,
    /// The channel that all records share, if there is just one.
    pub common: Option<CommonChannel>,
    /// Error of each stage over the records that every stage predicts, so that the numbers can be
    /// compared: RMS over samples in the common channel's unit (SI) where there is one, else normalised.
    pub errors: Vec<f64>,
    /// Normalised error of each stage over the same records.
    pub normalised: Vec<f64>,
    /// How `errors` are printed.
    pub scale: Scale,
}

/// Measured values and residuals of one channel of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct Levels {
    /// Index of the record.
    pub record: usize,
    /// What the levels are of: `amplitude`, or `frequency`.
    pub over: &'static str,
    /// Name and unit of the compared channel.
    pub channel: String,
    pub unit: &'static str,
    /// Unit of the amplitude.
    pub amplitude_unit: &'static str,
    pub amplitude: Vec<f64>,
    pub measured: Vec<f64>,
    /// Predicted at each level, by stage; NaN where a stage has no prediction.
    pub predicted: Vec<Vec<f64>>,
}

impl Levels {
    /// Predicted minus measured at `level`, by stage.
    pub fn residual(&self, stage: usize, level: usize) -> f64 {
        self.predicted[stage][level] - self.measured[level]
    }

    /// The level with the largest residual of a stage.
    pub fn worst(&self, stage: usize) -> Option<usize> {
        (0..self.amplitude.len())
            .filter(|&level| self.residual(stage, level).is_finite())
            .max_by(|&a, &b| self.residual(stage, a).abs().total_cmp(&self.residual(stage, b).abs()))
    }

    /// The scale that all residuals of the table fraction: three digits of the largest.
    pub fn residual_scale(&self) -> Scale {
        let all = (0..self.predicted.len())
            .flat_map(|stage| (0..self.amplitude.len()).map(move |level| self.residual(stage, level)));
        let largest =
            all.clone().filter(|size| size.is_finite()).fold(0.0, |top: f64, size| top.max(size.abs()));
        let scale = Scale::of(all, self.unit);
        let decimals = if largest > 0.0 { 2 - (largest * scale.factor).log10().floor() as i32 } else { 2 };
        Scale { decimals: decimals.clamp(0, 9) as usize, ..scale }
    }
}

/// The channel of `record` called `name`.
pub fn channel<'a>(record: &'a Record, name: &str) -> Option<&'a Channel> {
    record.channels.iter().find(|channel| channel.name == name)
}

/// What `stage` predicts for channel `name` of record `record`.
pub fn prediction<'a>(stage: &'a Stage, record: usize, name: &str) -> Option<&'a ChannelResult> {
    stage.records.get(record)?.channels.iter().find(|channel| channel.name == name)
}

/// Names and units of the channels that any stage is compared in, in the order they come.
pub fn compared_channels(comparison: &Comparison, record: usize) -> Vec<(String, &'static str)> {
    let mut found: Vec<(String, &'static str)> = Vec::new();
    for result in comparison.stages.iter().filter_map(|stage| stage.records.get(record)) {
        for channel in &result.channels {
            if !found.iter().any(|(name, _)| *name == channel.name) {
                found.push((channel.name.clone(), channel.unit));
            }
        }
    }
    found
}

/// Why `stage` has no prediction of a record, or `None` where it has one.
pub fn failure(stage: &Stage, record: usize) -> Option<&str> {
    match stage.records.get(record) {
        None => Some("no result"),
        Some(result) => result.failure.as_deref(),
    }
}

/// The error of a record as a stage predicts it; NaN where it has no prediction.
pub fn record_error(stage: &Stage, record: usize) -> f64 {
    if failure(stage, record).is_some() { f64::NAN } else { stage.records[record].error }
}

/// One number of decimals for the errors of all records and stages, so that a table lines up.
pub fn error_scale(comparison: &Comparison) -> Scale {
    let records = 0..comparison.records.len();
    let all =
        comparison.stages.iter().flat_map(|stage| records.clone().map(|record| record_error(stage, record)));
    Scale::of(all, "1")
}

/// The backbone records, channel by channel.
pub fn levels(comparison: &Comparison) -> Vec<Levels> {
    let mut tables = Vec::new();
    for (index, record) in comparison.records.iter().enumerate() {
        if !record.regime.is_table() {
            continue;
        }
        let over = if record.regime == Regime::SteppedSine { "frequency" } else { "amplitude" };
        let Some(amplitude) = record.channels_of(over).next() else { continue };
        for (name, unit) in compared_channels(comparison, index) {
            let Some(measured) = channel(record, &name) else { continue };
            let count = amplitude.values.len().min(measured.values.len());
            let predicted = comparison.stages.iter().map(|stage| {
                let values = prediction(stage, index, &name).map_or(&[][..], |result| &result.predicted);
                (0..count).map(|level| values.get(level).copied().unwrap_or(f64::NAN)).collect()
            });
            tables.push(Levels {
                record: index,
                over,
                unit,
                amplitude_unit: amplitude.unit,
                amplitude: amplitude.values[..count].to_vec(),
                measured: measured.values[..count].to_vec(),
                predicted: predicted.collect(),
                channel: name,
            });
        }
    }
    tables
}

/// The channel that every compared record has, where it is the only one.
fn common_channel(comparison: &Comparison) -> Option<CommonChannel> {
    let mut all = (0..comparison.records.len()).flat_map(|record| compared_channels(comparison, record));
    let (name, unit) = all.next()?;
    all.all(|other| other == (name.clone(), unit)).then_some(CommonChannel { name, unit })
}

/// RMS over the samples of the records `included`, in the channel's unit; NaN for none.
fn pooled_rms(stage: &Stage, included: impl Fn(usize) -> bool) -> f64 {
    let (mut squares, mut samples) = (0.0, 0.0);
    for (index, record) in stage.records.iter().enumerate().filter(|(index, _)| included(*index)) {
        if failure(stage, index).is_some() {
            continue;
        }
        for channel in &record.channels {
            let weight = channel.predicted.len().max(1) as f64;
            squares += weight * channel.rms * channel.rms;
            samples += weight;
        }
    }
    if samples > 0.0 { (squares / samples).sqrt() } else { f64::NAN }
}

/// Normalised error over the channels of the records `included`; NaN for none.
pub fn pooled_error(stage: &Stage, included: impl Fn(usize) -> bool) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0);
    for (index, record) in stage.records.iter().enumerate().filter(|(index, _)| included(*index)) {
        if failure(stage, index).is_none() {
            squares += record.channels.iter().map(|channel| channel.error * channel.error).sum::<f64>();
            count += record.channels.len() as f64;
        }
    }
    if count > 0.0 { (squares / count).sqrt() } else { f64::NAN }
}

/// Where `stage` is farthest from the measurement, in a few words.
pub fn worst(comparison: &Comparison, levels: &[Levels], stage_index: usize) -> String {
    let stage = &comparison.stages[stage_index];
    let records = 0..comparison.records.len();
    let failed: Vec<usize> = records.clone().filter(|&record| failure(stage, record).is_some()).collect();
    if let Some(&first) = failed.first() {
        let more = if failed.len() > 1 { format!(" and {} more", failed.len() - 1) } else { String::new() };
        return format!("no prediction: {}{more}", comparison.records[first].name);
    }
    let errors = records.map(|record| (record, record_error(stage, record)));
    let Some((record, error)) =
        errors.filter(|(_, error)| error.is_finite()).max_by(|a, b| a.1.total_cmp(&b.1))
    else {
        return format::ABSENT.to_owned();
    };
    let name = &comparison.records[record].name;
    let table = levels.iter().find(|table| table.record == record);
    let Some((table, level)) = table.and_then(|table| Some((table, table.worst(stage_index)?))) else {
        return format!("{name} ({})", format::error(error));
    };
    let at = Scale::of([table.amplitude[level]], table.amplitude_unit);
    let residual = table.residual_scale();
    let place = format!(
        "{}\u{a0}{}:\u{a0}{}\u{a0}{}",
        format::engineering(table.amplitude[level] * at.factor, "1"),
        at.unit,
        residual.signed(table.residual(stage_index, level)),
        residual.unit
    );
    if comparison.records.len() > 1 { format!("{name}, {place}") } else { place }
}

/// The verdict on a comparison.
pub fn summarise(comparison: &Comparison) -> Summary {
    let common = common_channel(comparison);
    let total = comparison.records.len();
    let predicted = |record: usize| comparison.stages.iter().all(|stage| failure(stage, record).is_none());
    let shared = (0..total).filter(|&record| predicted(record)).count();
    // With no record in common each stage stands for itself; the verdict then says so.
    let included = |record: usize| shared == 0 || predicted(record);
    let normalised = |stage: &Stage| match shared {
        all if all == total => stage.error,
        _ => pooled_error(stage, included),
    };
    let normalised: Vec<f64> = comparison.stages.iter().map(normalised).collect();
    let errors = match common {
        Some(_) => comparison.stages.iter().map(|stage| pooled_rms(stage, included)).collect(),
        None => normalised.clone(),
    };
    let scale = Scale::of(errors.iter().copied(), common.as_ref().map_or("1", |common| common.unit));
    let skipped = skipped(comparison);
    let mut notes = crate::findings(&comparison.findings);
    notes.extend(stage_notes(comparison));
    let mut summary = Summary { verdict: String::new(), notes, skipped, common, errors, normalised, scale };
    for stage in &comparison.stages {
        let missing = (0..total).filter(|&record| failure(stage, record).is_some()).count();
        if missing > 0 {
            let records = format::count(total, "record");
            summary.notes.push(format!("“{}” has no prediction for {missing} of {records}.", stage.name));
        }
    }
    for (record, reason) in &summary.skipped {
        summary.notes.push(format!("{} is skipped: {reason}.", comparison.records[*record].name));
    }
    verdict(comparison, shared, &mut summary);
    summary
}

/// The records that a stage does not predict, with the reason of the first such stage.
fn skipped(comparison: &Comparison) -> Vec<(usize, String)> {
    let reason = |record| comparison.stages.iter().find_map(|stage| failure(stage, record));
    let skipped = |record| Some((record, reason(record)?.to_owned()));
    (0..comparison.records.len()).filter_map(skipped).collect()
}

fn verdict(comparison: &Comparison, shared: usize, summary: &mut Summary) {
    let total = comparison.records.len();
    let rms = if summary.common.is_some() { " RMS" } else { "" };
    let what = if summary.common.is_some() { "error" } else { "normalised error" };
    let print =
        |value: f64| if rms.is_empty() { format::error(value) } else { summary.scale.with_unit(value) };
    let limited = if shared < total {
        let who = if comparison.stages.len() == 1 { "it" } else { "every stage" };
        format!(" over the {} that {who} predicts", format::count(shared, "record"))
    } else {
        String::new()
    };
    let (before, after) = match summary.errors[..] {
        [] => return summary.verdict = "Nothing was compared: there is no model.".to_owned(),
        _ if total == 0 => return summary.verdict = "Nothing was compared: there are no records.".to_owned(),
        _ if shared == 0 => return summary.verdict = nothing_shared(comparison),
        [only] => {
            let normalised = pooled_error(&comparison.stages[0], |_| true);
            let beside = if rms.is_empty() {
                String::new()
            } else {
                format!(" (normalised {})", format::error(normalised))
            };
            return summary.verdict = format!("The {what} is {}{rms}{beside}{limited}.", print(only));
        }
        [before, .., after] => (before, after),
    };
    let change = format::change(before, after).map(|change| format!(" ({change})")).unwrap_or_default();
    let verdict = if !(before.is_finite() && after.is_finite()) {
        "The errors are not finite numbers and cannot be compared.".to_owned()
    } else if after < 0.99 * before {
        format!("The {what} falls from {} to {}{rms}{change}{limited}.", print(before), print(after))
    } else if after > 1.01 * before {
        format!("The {what} rises from {} to {}{rms}{change}{limited}.", print(before), print(after))
    } else {
        format!("The {what} does not fall: {} before, {}{rms} after{limited}.", print(before), print(after))
    };
    let finite = summary.errors.iter().enumerate().filter(|(_, error)| error.is_finite());
    let better = finite.min_by(|a, b| a.1.total_cmp(b.1)).filter(|(_, error)| **error < 0.99 * after);
    let note = better.map(|(stage, &error)| {
        let name = &comparison.stages[stage].name;
        format!("The smallest error is not the last stage’s: “{name}” has {}{rms}.", print(error))
    });
    summary.verdict = verdict + &in_steps(comparison, summary, &print);
    summary.notes.extend(note);
}

/// What each stage gains, where there are a few between the first and the last.
fn in_steps(comparison: &Comparison, summary: &Summary, print: &dyn Fn(f64) -> String) -> String {
    let count = comparison.stages.len();
    if !(3..=FEW).contains(&count) || summary.errors.iter().any(|error| !error.is_finite()) {
        return String::new();
    }
    let step = |index: usize| {
        let [before, after] = [summary.errors[index - 1], summary.errors[index]];
        let change = format::change(before, after).unwrap_or_else(|| "no change".to_owned());
        format!("{} {} → {} ({change})", comparison.stages[index].name, print(before), print(after))
    };
    format!(" Step by step: {}.", (1..count).map(step).collect::<Vec<_>>().join("; "))
}

/// What must be known of how the stages were made.
pub fn stage_notes(comparison: &Comparison) -> Vec<String> {
    let of = |stage: &Stage| {
        stage.notes.iter().map(|note| format!("“{}”: {note}.", stage.name)).collect::<Vec<_>>()
    };
    let general = comparison.notes.iter().map(|note| format!("{note}."));
    general.chain(comparison.stages.iter().flat_map(of)).collect()
}

fn nothing_shared(comparison: &Comparison) -> String {
    if comparison.stages.len() == 1 {
        "The model predicts none of the records.".to_owned()
    } else {
        "The errors cannot be compared: no record is predicted by every stage.".to_owned()
    }
}
