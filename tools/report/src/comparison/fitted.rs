//! What a fit made of the parameters: old and new value, interval, bound, correlation; for every output alike.

use maud::{Markup, html};
use serde_json::{Value, json};
use stickslip::diagnose::{Comparison, Fitted, Parameter, Stage};

use crate::comparison::stages::name;
use crate::diagnosis::{interval, value_within};
use crate::format;

/// The last stage of which parameters were fitted.
fn last(comparison: &Comparison) -> Option<&Stage> {
    comparison.stages.iter().rev().find(|stage| stage.parameters.iter().any(|one| one.fitted.is_some()))
}

fn of(stage: &Stage) -> impl Iterator<Item = (&Parameter, &Fitted)> {
    stage.parameters.iter().filter_map(|one| Some((one, one.fitted.as_ref()?)))
}

/// A heading and a line for each fitted parameter of the last fitted stage; `None` where nothing was fitted.
pub fn sentences(comparison: &Comparison) -> Option<(String, Vec<String>)> {
    let stage = last(comparison)?;
    let line = |(parameter, fitted): (&Parameter, &Fitted)| {
        let now = now(parameter, fitted);
        let remarks = remarks(fitted);
        let more = if remarks.is_empty() { String::new() } else { format!("; {}", remarks.join("; ")) };
        format!(
            "{}: {} → {now} ({}){more}",
            parameter.path,
            before(parameter, fitted),
            range(parameter, fitted)
        )
    };
    Some((format!("Fitted in “{}”: old → new (95 % interval)", stage.name), of(stage).map(line).collect()))
}

/// The same as a section of the page.
pub fn section(comparison: &Comparison) -> Markup {
    let Some(stage) = last(comparison) else { return html! {} };
    html! {
        section id="fitted" {
            h2 { "What was fitted" }
            div.scroll tabindex="0" role="region" aria-label="Fitted parameters" {
                table.levels {
                    thead { tr {
                        th { "Parameter of “" (name(&stage.name)) "”" }
                        th.number { "Before" } th.number { "Fitted" } th.number { "Change" } th { "95 % interval" } th { "Remarks" }
                    } }
                    tbody { @for (parameter, fitted) in of(stage) {
                        tr {
                            th scope="row" { code { (name(&parameter.path)) } }
                            td.number { (before(parameter, fitted)) }
                            td.number { strong { (now(parameter, fitted)) } }
                            td.number { (change(parameter, fitted)) }
                            td { (range(parameter, fitted)) }
                            td { (name(&remarks(fitted).join("; "))) }
                        }
                    } }
                }
            }
            p.note {
                "Intervals hold where the model is right: they allow for residuals with a memory, not for a wrong law. A correlation "
                "near ±1 means that these data determine a combination of both parameters better than each."
            }
        }
    }
}

fn before(parameter: &Parameter, fitted: &Fitted) -> String {
    fitted.from.map_or_else(|| "new".to_owned(), |before| format::engineering(before, parameter.unit))
}

fn now(parameter: &Parameter, fitted: &Fitted) -> String {
    let Parameter { value, unit, .. } = *parameter;
    fitted.interval.map_or_else(|| format::engineering(value, unit), |ends| value_within(ends, value, unit))
}

fn change(parameter: &Parameter, fitted: &Fitted) -> String {
    let change = fitted.from.and_then(|before| format::change(before, parameter.value));
    change.unwrap_or_else(|| format::ABSENT.to_owned())
}

fn range(parameter: &Parameter, fitted: &Fitted) -> String {
    match fitted.interval {
        Some([low, high]) => interval(low, high, parameter.unit),
        None => "not determined".to_owned(),
    }
}

fn remarks(fitted: &Fitted) -> Vec<String> {
    let mut all = Vec::new();
    if fitted.at_bound {
        all.push("ended at its bound".to_owned());
    }
    if fitted.unseen {
        all.push("no fitted record depends on it".to_owned());
    }
    let with = |(path, correlation): &(String, f64)| {
        format!("correlated with {path} ({})", format::fixed(*correlation, 3))
    };
    all.extend(fitted.correlated.iter().map(with));
    all
}

/// A parameter with how it was fitted.
pub fn to_json(parameter: &Parameter) -> Value {
    let fitted = parameter.fitted.as_ref();
    let end = |which: usize| fitted.and_then(|fitted| fitted.interval).map(|ends| ends[which]);
    let correlated = fitted.map(|fitted| {
        let one = |(path, correlation): &(String, f64)| json!({ "with": path, "correlation": correlation });
        fitted.correlated.iter().map(one).collect::<Vec<_>>()
    });
    json!({
        "value": parameter.value, "unit": parameter.unit, "fitted": fitted.is_some(),
        "fitted_from": fitted.and_then(|fitted| fitted.from), "low": end(0), "high": end(1),
        "at_bound": fitted.map(|fitted| fitted.at_bound), "unseen": fitted.map(|fitted| fitted.unseen),
        "correlated": correlated,
    })
}
