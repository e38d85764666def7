//! Where a model fails: the views of the residual, for every record, channel and stage, from one copy of the
//! samples. The page's script draws them as the reader chooses.

mod harmonics;
mod store;
mod views;

pub use harmonics::{Harmonics, by_harmonic};
pub use views::deviation;

use maud::{Markup, html};
use serde_json::{Value, json};
use stickslip::data::{Channel, Record};
use stickslip::diagnose::{Comparison, Noise};
use stickslip::fit::residual::causes;

use self::store::Store;
use crate::comparison::floors;
use crate::comparison::stages::{self, name};
use crate::comparison::summary;
use crate::decimate::{keep_extremes, worst_cycles};
use crate::figure::{self, Figures};
use crate::format::{self, Scale};
use crate::plots::prose;

/// Samples of a record that are stored at most, and at least when many records share the page.
const SAMPLES: (usize, usize) = (2_500, 200);
/// Numbers that the views of a page may hold together: two bytes and two thirds each.
const NUMBERS: usize = 340_000;
/// Records whose views are stored; the tables hold all.
const RECORDS: usize = 60;
/// Cycles that a loop shows of a record.
const LOOP_CYCLES: usize = 3;

/// The section: what may be chosen, and the views. Empty where there is no record in time. `noise` is what is
/// known of the noise.
pub fn section(figures: &mut Figures, comparison: &Comparison, records: &[usize], noise: &[Noise]) -> Markup {
    let shown: Vec<usize> = drawable(comparison, records).into_iter().take(RECORDS).collect();
    if shown.is_empty() {
        return html! {};
    }
    let count = comparison.stages.len();
    let columns: usize = shown
        .iter()
        .map(|&record| 2 + summary::compared_channels(comparison, record).len() * (3 + count))
        .sum();
    let limit = (NUMBERS / columns.max(1)).clamp(SAMPLES.1, SAMPLES.0);
    let mut store = Store::default();
    let scales = scales(comparison, &shown);
    let entries: Vec<Value> =
        shown.iter().map(|&record| entry(&mut store, comparison, record, &scales, limit, noise)).collect();
    let stages: Vec<Value> = (0..count).map(|stage| stage_style(comparison, stage)).collect();
    let roles = roles(&entries);
    let harmonics = entries.iter().any(|entry| each_channel(entry).any(|c| !c["harmonics"].is_null()));
    let thinned = shown.iter().any(|&record| comparison.records[record].len() > limit);
    figures.explorer = Some(json!({
        "stages": stages, "records": entries, "columns": store.into_columns(), "roles": roles,
    }));
    markup(comparison, &shown, &roles, harmonics, thinned.then_some(limit))
}

/// The records with something to draw.
fn drawable(comparison: &Comparison, records: &[usize]) -> Vec<usize> {
    let drawn = |record: usize| {
        !comparison.records[record].regime.is_table()
            && summary::compared_channels(comparison, record).iter().any(|(name, _)| {
                summary::channel(&comparison.records[record], name).is_some_and(|c| !c.values.is_empty())
            })
    };
    records.iter().copied().filter(|&record| drawn(record)).collect()
}

fn stage_style(comparison: &Comparison, stage: usize) -> Value {
    let count = comparison.stages.len();
    let style = figure::style(stage, count);
    let name = figure::text(&format!("{}  {}", stage + 1, comparison.stages[stage].name));
    json!({ "name": name, "colour": style.colour, "dash": style.dash, "on": stage == 0 || stage + 1 == count })
}

fn each_channel(entry: &Value) -> impl Iterator<Item = &Value> {
    entry["channels"].as_array().into_iter().flatten()
}

/// What the residual can be drawn against, in the order of the figures.
fn roles(entries: &[Value]) -> Vec<&'static str> {
    let has = |role: &str| {
        entries.iter().any(|entry| each_channel(entry).any(|channel| !channel["causes"][role].is_null()))
    };
    views::ROLES.into_iter().filter(|role| has(role)).collect()
}

/// One unit for each channel in all records, so that they can be laid over each other.
fn scales(comparison: &Comparison, shown: &[usize]) -> Vec<(String, Scale, Scale)> {
    let mut all: Vec<(String, Scale, Scale)> = Vec::new();
    let channels = |name: &str| -> Vec<&Channel> {
        shown.iter().filter_map(|&record| summary::channel(&comparison.records[record], name)).collect()
    };
    for &record in shown {
        for (name, unit) in summary::compared_channels(comparison, record) {
            if all.iter().any(|(known, ..)| *known == name) {
                continue;
            }
            let values = channels(&name).into_iter().flat_map(|channel| channel.values.iter().copied());
            let residuals = shown.iter().flat_map(|&record| {
                comparison.stages.iter().map(move |stage| (record, stage)).flat_map(|(record, stage)| {
                    residual(comparison, record, stage, &name).unwrap_or_default()
                })
            });
            let (value, rest) = (Scale::of(values, unit), Scale::of(residuals, unit));
            all.push((name, value, rest));
        }
    }
    all
}

/// Predicted minus measured; `None` where the stage has no prediction.
fn residual(
    comparison: &Comparison,
    record: usize,
    stage: &stickslip::diagnose::Stage,
    name: &str,
) -> Option<Vec<f64>> {
    let measured = summary::channel(&comparison.records[record], name)?;
    let result = summary::prediction(stage, record, name)?;
    let values: Vec<f64> = result.predicted.iter().zip(&measured.values).map(|(p, m)| p - m).collect();
    (!values.is_empty()).then_some(values)
}

fn entry(
    store: &mut Store,
    comparison: &Comparison,
    index: usize,
    scales: &[(String, Scale, Scale)],
    limit: usize,
    noise: &[Noise],
) -> Value {
    let record = &comparison.records[index];
    let channels: Vec<Value> = scales
        .iter()
        .filter_map(|(name, value, rest)| {
            let measured = summary::channel(record, name).filter(|channel| !channel.values.is_empty())?;
            let noise = floors::deviation(noise, index, name).or(measured.noise);
            Some(channel(store, comparison, index, measured, (value, rest), limit, noise))
        })
        .collect();
    let error = comparison.stages.last().map_or(f64::NAN, |stage| summary::record_error(stage, index));
    let title =
        format!("{} ({}), error {}", record.name, stages::regime(comparison, index), format::error(error));
    json!({ "name": figure::text(&record.name), "title": name(&title), "channels": channels })
}

/// Everything the views of one channel of one record need.
fn channel(
    store: &mut Store,
    comparison: &Comparison,
    index: usize,
    measured: &Channel,
    (value, rest): (&Scale, &Scale),
    limit: usize,
    noise: Option<f64>,
) -> Value {
    let record = &comparison.records[index];
    let residuals: Vec<Option<Vec<f64>>> =
        comparison.stages.iter().map(|stage| residual(comparison, index, stage, &measured.name)).collect();
    let length = measured.values.len();
    let last = residuals.iter().rev().flatten().next();
    let mut guides: Vec<&[f64]> = vec![&measured.values];
    guides.extend(last.map(Vec::as_slice));
    let kept = keep_extremes(&guides, length, limit);
    let samples: Vec<f64> = (0..length).map(|sample| sample as f64).collect();
    let time = record.time().filter(|time| time.len() == length).unwrap_or(&samples);
    let clock = if record.time().is_some() {
        Scale::of(time.iter().copied(), "s")
    } else {
        Scale { factor: 1.0, unit: String::new(), decimals: 0 }
    };
    let shown = prose(&measured.name);
    let short = format::shorten(&shown, 24);
    let spread = views::deviation(&measured.values);
    json!({
        "name": figure::text(&shown),
        "label": figure::text(&value.label(&short)),
        "residualLabel": figure::text(&rest.label("residual")),
        "lackLabel": figure::text(&rest.label(&format!("measured − predicted {short}"))),
        "predictedLabel": figure::text(&value.label(&format!("predicted {short}"))),
        "perValue": rest.factor / value.factor,
        "timeLabel": clock.label(if record.time().is_some() { "time" } else { "sample" }),
        "time": store.scaled(time, &kept, clock.factor),
        "measured": store.scaled(&measured.values, &kept, value.factor),
        "residuals": residuals.iter()
            .map(|one| one.as_ref().map(|one| store.scaled(one, &kept, rest.factor))).collect::<Vec<_>>(),
        "noise": noise.map(|noise| noise * rest.factor),
        "noiseShare": noise.map(|noise| noise / spread),
        "drawn": kept.len(), "samples": length,
        "causes": against(store, record, measured, &kept),
        "loop": hysteresis(store, record, measured, last.map_or(&[], Vec::as_slice), &kept, limit),
        "slow": views::slow_time(record, measured, time, &residuals, (spread, clock.factor)),
        "spectrum": views::spectrum(store, record, &measured.values, &residuals, value.factor),
        "frequencyLabel": "frequency (Hz)",
        "spectrumLabel": figure::text(&value.label(&format!("amplitude of {short}"))),
        "harmonics": by_harmonic(comparison, index, &measured.name).map(|found| found.to_plot()),
    })
}

/// What the residual is drawn against, by role.
fn against(store: &mut Store, record: &Record, measured: &Channel, kept: &[usize]) -> Value {
    let mut object = serde_json::Map::new();
    for (role, channel) in causes(record, measured) {
        let scale = Scale::of(channel.values.iter().copied(), channel.unit);
        let label = figure::text(&scale.label(&format::shorten(&prose(&channel.name), 24)));
        let x = store.scaled(&channel.values, kept, scale.factor);
        object.insert(role.to_owned(), json!({ "label": label, "x": x }));
    }
    Value::Object(object)
}

/// The samples of the cycles where the last prediction errs most, as a range of the kept ones, over the
/// displacement (of a contact) or against the excitation (of a structure).
fn hysteresis(
    store: &mut Store,
    record: &Record,
    measured: &Channel,
    residual: &[f64],
    kept: &[usize],
    limit: usize,
) -> Value {
    let contact = measured.name == "force";
    let other = if contact {
        summary::channel(record, "displacement")
    } else {
        record.channels.iter().find(|channel| channel.quantity() == "excitation")
    };
    let Some(other) = other.filter(|other| other.values.len() == measured.values.len()) else {
        return Value::Null;
    };
    let motion = if contact { &other.values } else { &measured.values };
    let (range, _) = worst_cycles(motion, residual, LOOP_CYCLES, limit / 8);
    let place = |sample: usize| kept.partition_point(|&index| index < sample);
    let scale = Scale::of(other.values.iter().copied(), other.unit);
    json!({
        "label": figure::text(&scale.label(&format::shorten(&prose(&other.name), 24))),
        "other": store.scaled(&other.values, kept, scale.factor),
        "across": contact, "range": [place(range.start), place(range.end)],
    })
}

fn markup(
    comparison: &Comparison,
    shown: &[usize],
    roles: &[&str],
    harmonics: bool,
    thinned: Option<usize>,
) -> Markup {
    let count = comparison.stages.len();
    let all = (0..comparison.records.len()).filter(|&r| !comparison.records[r].regime.is_table()).count();
    html! {
        section id="where" {
            h2 { "Where it fails" }
            p.note {
                "Choose a record, a channel and the stages; every figure follows. Residual means predicted minus measured. "
                "Drag to zoom, double-click to go back."
                @if shown.len() < all { " The views hold the " (shown.len()) " worst of " (all) " records." }
                @if let Some(limit) = thinned {
                    " Long records are drawn with about " (limit)
                    " samples, among them the extremes of every stretch."
                }
            }
            div.chooser role="group" aria-label="What the figures show" {
                label { "Record " select id="choose-record" {} }
                label id="channel-label" { "Channel " select id="choose-channel" {} }
                fieldset {
                    legend { "Stages" }
                    @for stage in 0..count {
                        label {
                            input type="checkbox" class="choose-stage" value=(stage)
                                checked[stage == 0 || stage + 1 == count];
                            (stages::key(stage, count)) (stage + 1) " " (name(&comparison.stages[stage].name))
                        }
                    }
                }
            }
            p.chosen id="chosen" aria-live="polite" {}
            div.figures {
                (view("time", "Over time: measured and predicted above, residual below. Dotted: the noise, ±1 \
                               standard deviation.", false))
                (view("loop", "Loop over the cycles with the largest residual: the force against the displacement of a \
                               contact, the excitation against the response of a structure.", true))
                (view("parity", "Parity: predicted against measured. A perfect model lies on the grey line.", true))
                @for role in roles {
                    (view(&format!("cause:{role}"), &format!("Residual against {role}. Lines: its mean{}.",
                        if *role == "displacement" { " while moving forwards and backwards" } else { "" }), true))
                }
                (view("slow", "Slow time: root mean square of the residual in windows along the record, over the \
                               channel’s standard deviation. A rise or fall means that something changes during the record.",
                      true))
                (view("spectrum", "Frequency: amplitude of the residual, and of the measurement in grey.", true))
                @if harmonics {
                    (view("harmonics", "Harmonics of the record’s fundamental: residual over the channel’s standard \
                                        deviation. Odd ones alone mean a symmetric cause.", true))
                }
            }
        }
    }
}

/// The place of one view.
fn view(kind: &str, caption: &str, half: bool) -> Markup {
    html! {
        figure.half[half] data-view-figure=(kind) {
            div.plot.view data-view=(kind) style=(if half { "height:368px" } else { "height:480px" }) role="img"
                aria-label=(caption) {}
            figcaption { (caption) }
        }
    }
}
