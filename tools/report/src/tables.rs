//! The page's tables of records: error by record and channel, and by harmonic.

use maud::{Markup, html};
use stickslip::data::Record;
use stickslip::diagnose::{Comparison, Noise};

use crate::comparison::floors;
use crate::comparison::stages::{key, name, regime};
use crate::comparison::summary;
use crate::explorer::{Harmonics, by_harmonic};
use crate::format::{self, Scale};
use crate::plots::prose;

/// Normalised error of every stage in every channel of every record, beside the level of the record and what the
/// noise alone would leave.
pub fn record_table(comparison: &Comparison, noise: &[Noise]) -> Markup {
    let count = comparison.stages.len();
    let rows: Vec<(usize, Option<(String, &'static str)>)> = (0..comparison.records.len())
        .flat_map(|record| {
            let channels = summary::compared_channels(comparison, record);
            let some = channels.into_iter().map(move |channel| (record, Some(channel)));
            let rows: Vec<_> = some.collect();
            if rows.is_empty() { vec![(record, None)] } else { rows }
        })
        .collect();
    let worst: Vec<f64> = (0..count).map(|stage| largest(comparison, stage)).collect();
    html! {
        p.note {
            "Normalised error in every record and channel; the largest of each stage in bold. The noise is the error of a "
            "perfect model; – where it is unknown."
        }
        div.scroll tabindex="0" role="region" aria-label="Error in every record" {
            table.levels {
                thead { tr {
                    th { "Record" }
                    th { "Regime and use" }
                    th { "Level" }
                    th { "Channel" }
                    @for (index, stage) in comparison.stages.iter().enumerate() {
                        th.number { (key(index, count)) (index + 1) " " (name(&stage.name)) }
                    }
                    th.number { "Noise" }
                } }
                tbody { @for (row, (record, channel)) in rows.iter().enumerate() {
                    @let first = row == 0 || rows[row - 1].0 != *record;
                    tr {
                        th scope="row" { @if first { (name(&comparison.records[*record].name)) } }
                        td { @if first { (regime(comparison, *record)) } }
                        td { @if first { (level(&comparison.records[*record])) } }
                        @match channel {
                            None => { td colspan=(count + 2) { span.quiet { "nothing to compare" } } }
                            Some((channel, _)) => {
                                td { (name(&prose(channel))) }
                                @for (stage, worst) in worst.iter().enumerate() {
                                    (error_cell(comparison, stage, *record, channel, *worst))
                                }
                                td.number { (floors::fraction(comparison, noise, *record, channel).map_or(format::ABSENT.into(), format::error)) }
                            }
                        }
                    }
                } }
            }
        }
    }
}

fn error_cell(comparison: &Comparison, stage: usize, record: usize, channel: &str, worst: f64) -> Markup {
    let stage = &comparison.stages[stage];
    html! {
        @match (summary::failure(stage, record), summary::prediction(stage, record, channel)) {
            (Some(reason), _) => { td.number.failed title=(name(reason)) { "failed" } }
            (None, Some(result)) => {
                td.number.worst[result.error == worst] { (format::error(result.error)) }
            }
            (None, None) => { td.number.failed { "no prediction" } }
        }
    }
}

fn largest(comparison: &Comparison, stage: usize) -> f64 {
    let results = comparison.stages[stage].records.iter().flat_map(|record| &record.channels);
    results.map(|channel| channel.error).filter(|error| error.is_finite()).fold(f64::NEG_INFINITY, f64::max)
}

/// Half of the range of what drives the record: the displacement of a contact, the excitation of a structure.
fn level(record: &Record) -> String {
    if record.regime.is_table() {
        return "every level".to_owned();
    }
    let drive = record.channels.iter().find(|channel| channel.quantity() == "excitation");
    let Some(drive) = drive.or_else(|| summary::channel(record, "displacement")) else {
        return format::ABSENT.to_owned();
    };
    let finite = || drive.values.iter().copied().filter(|value| value.is_finite());
    let (low, high) = (finite().fold(f64::INFINITY, f64::min), finite().fold(f64::NEG_INFINITY, f64::max));
    if low > high {
        return format::ABSENT.to_owned();
    }
    let half = 0.5 * (high - low);
    format!("±\u{a0}{}", format::engineering(format!("{half:.2e}").parse().unwrap_or(half), drive.unit))
}

/// The residual of every record that repeats, by harmonic.
pub fn all_harmonics(comparison: &Comparison) -> Vec<Harmonics> {
    let mut all = Vec::new();
    for record in 0..comparison.records.len() {
        for (channel, _) in summary::compared_channels(comparison, record) {
            all.extend(by_harmonic(comparison, record, &channel));
        }
    }
    all
}

/// Residual of the first and the last stage at the harmonics of every record that repeats.
pub fn harmonic_table(comparison: &Comparison) -> Markup {
    let all = all_harmonics(comparison);
    let harmonics = all.iter().flat_map(|one| &one.residuals).flatten().map(Vec::len).max().unwrap_or(0);
    let count = comparison.stages.len();
    let stages: Vec<usize> = if count > 1 { vec![0, count - 1] } else { (0..count).collect() };
    let several = comparison.records.iter().any(|record| {
        let quantities: Vec<_> = record.channels.iter().map(|channel| channel.quantity()).collect();
        quantities
            .iter()
            .filter(|quantity| ["force", "acceleration", "velocity", "displacement"].contains(quantity))
            .count()
            > 1
    });
    html! {
        @if harmonics > 0 {
            h3 { "Error by harmonic" }
            p.note {
                "Records that repeat: root mean square of the residual at the mean and at each harmonic of the fundamental, "
                "over the channel’s standard deviation."
            }
            div.scroll tabindex="0" role="region" aria-label="Error by harmonic" {
                table.levels {
                    thead { tr {
                        th { "Record" }
                        @if several { th { "Channel" } }
                        th.number { "Fundamental" }
                        th { "Stage" }
                        @for harmonic in 0..harmonics {
                            th.number { @if harmonic == 0 { "mean" } @else { (harmonic) } }
                        }
                    } }
                    tbody { @for one in &all {
                        @for (row, &stage) in stages.iter().enumerate() {
                            tr {
                                th scope="row" { @if row == 0 { (name(&comparison.records[one.record].name)) } }
                                @if several { td { @if row == 0 { (name(&prose(&one.channel))) } } }
                                td.number { @if row == 0 { (Scale::of([one.fundamental], "Hz").with_unit(one.fundamental)) } }
                                td { (key(stage, count)) (stage + 1) }
                                @for harmonic in 0..harmonics {
                                    td.number { (one.residuals[stage].as_ref().and_then(|all| all.get(harmonic))
                                        .map_or(format::ABSENT.to_owned(), |value| format::error(*value))) }
                                }
                            }
                        }
                    } }
                }
            }
        }
    }
}
