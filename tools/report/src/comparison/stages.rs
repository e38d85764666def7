//! The page's tables: stages, levels, records and parameters.

use maud::{Markup, html};
use stickslip::data::{Regime, Use};
use stickslip::diagnose::{Comparison, Parameter};

use crate::comparison::summary::{self, Levels, Summary};
use crate::figure;
use crate::format::{self, Scale};
use crate::plots::{error_name, prose};

/// A name from a file as the page shows it; the template escapes it.
pub fn name(text: &str) -> String {
    format::printable(text)
}

/// The key of a stage: its number on its colour.
pub fn key(stage: usize, count: usize) -> Markup {
    html! { span.key style=(format!("background:{}", figure::style(stage, count).colour)) {} }
}

/// One row a stage: error as bar and number, effort, and where it fails worst.
pub fn stage_table(comparison: &Comparison, summary: &Summary, levels: &[Levels]) -> Markup {
    let (errors, scale, what) = (&summary.errors, &summary.scale, error_name(summary));
    let count = comparison.stages.len();
    let top = errors.iter().copied().filter(|error| error.is_finite()).fold(0.0, f64::max);
    let normalised = Scale::of(comparison.stages.iter().map(|stage| stage.error), "1");
    html! {
        div.scroll tabindex="0" role="region" aria-label="Error of each stage" {
            table.stages {
                thead { tr {
                    th.number { "#" }
                    th { "Stage" }
                    th.bars { (capital(&scale.label(&what))) }
                    @if summary.common.is_some() { th.number { "Normalised" } }
                    th.number { "Model runs" }
                    th { "Worst at" }
                } }
                tbody { @for (index, stage) in comparison.stages.iter().enumerate() {
                    tr.final[index + 1 == count] {
                        td.number { (index + 1) }
                        th scope="row" { (key(index, count)) (name(&stage.name)) }
                        td.bars { (bar(errors[index], top, figure::style(index, count).colour, scale)) }
                        @if summary.common.is_some() { td.number { (normalised.number(stage.error)) } }
                        td.number { @if stage.evaluations == 0 { (format::ABSENT) } @else { (stage.evaluations) } }
                        td { (name(&summary::worst(comparison, levels, index))) }
                    }
                } }
            }
        }
        p.note {
            "The normalised error is the root mean square over all compared channels, each divided by its own "
            "standard deviation in its record: 0 is perfect, 1 is no better than the channel’s mean. "
            @if comparison.records.iter().enumerate().any(|(record, _)| failed(comparison, record)) {
                "The bars are over the records that every stage predicts. "
            }
            "Model runs are those spent on the fit; – means that nothing was fitted."
        }
    }
}

/// What each step rests on, where the values are few.
pub fn step_list(comparison: &Comparison) -> Markup {
    let steps = comparison.steps();
    html! {
        @if !steps.is_empty() {
            h3 { "What each step gains, and the probability that chance explains the gain" }
            ul { @for step in &steps {
                li {
                    strong { (name(&comparison.stages[step.stages[0]].name)) " → " (name(&comparison.stages[step.stages[1]].name)) }
                    ": " (name(&step.words)) "."
                }
            } }
        }
    }
}

fn failed(comparison: &Comparison, record: usize) -> bool {
    comparison.stages.iter().any(|stage| summary::failure(stage, record).is_some())
}

/// A bar of length `value / top` with the number behind it.
fn bar(value: f64, top: f64, colour: &str, scale: &Scale) -> Markup {
    let fraction = if top > 0.0 && value.is_finite() { (value / top).clamp(0.0, 1.0) } else { 0.0 };
    html! {
        span.bar {
            span.value { (scale.number(value)) }
            span.track { span.fill style=(format!("width:{:.1}%;background:{colour}", 100.0 * fraction)) {} }
        }
    }
}

fn capital(text: &str) -> String {
    let mut characters = text.chars();
    characters.next().map_or_else(String::new, |first| first.to_uppercase().chain(characters).collect())
}

/// Residual of every stage at every level.
pub fn level_table(comparison: &Comparison, levels: &Levels) -> Markup {
    let count = comparison.stages.len();
    let amplitude = Scale::of(levels.amplitude.iter().copied(), levels.amplitude_unit);
    let value = Scale::of(levels.measured.iter().copied(), levels.unit);
    let value = Scale { decimals: value.decimals.max(2), ..value };
    let residual = levels.residual_scale();
    let worst: Vec<Option<usize>> = (0..count).map(|stage| levels.worst(stage)).collect();
    html! {
        p.note {
            (name(&residual.label(&format!("Predicted minus measured {}", prose(&levels.channel)))))
            "; the largest of each stage in bold."
        }
        div.scroll tabindex="0" role="region" aria-label="Error at every level" {
            table.levels {
                thead { tr {
                    th.number { (amplitude.label(levels.over)) }
                    th.number { (value.label("Measured")) }
                    @for (index, stage) in comparison.stages.iter().enumerate() {
                        th.number { (key(index, count)) (index + 1) " " (name(&stage.name)) }
                    }
                } }
                tbody { @for level in 0..levels.amplitude.len() {
                    tr {
                        th.number scope="row" { (format::engineering(levels.amplitude[level] * amplitude.factor, "1")) }
                        td.number { (value.number(levels.measured[level])) }
                        @for (stage, worst) in worst.iter().enumerate() {
                            td.number.worst[*worst == Some(level)] { (residual.signed(levels.residual(stage, level))) }
                        }
                    }
                } }
            }
        }
    }
}

/// What may be done with a record and how it begins, in words.
pub fn regime(comparison: &Comparison, record: usize) -> String {
    let record = &comparison.records[record];
    let regime = match record.regime {
        Regime::FromRest => "from rest",
        Regime::Steady => "steady state",
        Regime::UnknownInitialState => "unknown initial state",
        Regime::Backbone => "backbone",
        Regime::SteppedSine => "stepped sine",
    };
    match record.use_for {
        None => regime.to_owned(),
        Some(Use::Fit) => format!("{regime}, training"),
        Some(Use::Select) => format!("{regime}, validation"),
        Some(Use::Confirm) => format!("{regime}, test"),
    }
}

/// Every parameter in every stage; a fitted one with its value before.
pub fn parameter_table(comparison: &Comparison) -> Markup {
    let count = comparison.stages.len();
    let mut paths: Vec<&str> = Vec::new();
    for parameter in comparison.stages.iter().flat_map(|stage| &stage.parameters) {
        if !paths.contains(&parameter.path.as_str()) {
            paths.push(&parameter.path);
        }
    }
    html! {
        p.note { "Fitted values in bold, with the value before the fit and the change." }
        div.scroll tabindex="0" role="region" aria-label="Parameters" {
            table.parameters {
                thead { tr {
                    th { "Parameter" }
                    @for (index, stage) in comparison.stages.iter().enumerate() {
                        th { (key(index, count)) (index + 1) " " (name(&stage.name)) }
                    }
                } }
                tbody { @for path in paths {
                    tr {
                        th scope="row" { code { (breakable(path)) } }
                        @for stage in &comparison.stages {
                            td { @match stage.parameters.iter().find(|parameter| parameter.path == path) {
                                Some(parameter) => { (value(parameter)) }
                                None => { span.quiet { (format::ABSENT) } }
                            } }
                        }
                    }
                } }
            }
        }
    }
}

/// A path that may be broken after its dots and underscores.
fn breakable(path: &str) -> Markup {
    let path = name(path);
    html! { @for part in path.split_inclusive(['.', '_']) { (part) wbr; } }
}

fn value(parameter: &Parameter) -> Markup {
    let now = format::engineering(parameter.value, parameter.unit);
    html! {
        @match &parameter.fitted {
            None => { (now) }
            Some(fitted) => {
                strong { (now) }
                span.before {
                    @match fitted.from {
                        None => { "new" }
                        Some(before) => {
                            (format::engineering(before, parameter.unit)) " → "
                            (format::change(before, parameter.value).unwrap_or_else(|| "fitted".to_owned()))
                        }
                    }
                }
            }
        }
    }
}
