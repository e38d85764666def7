//! A model and its data before anything is fitted: what the numbers come to, what is wrong, what the data can show.

use serde_json::{Map, Value, json};
use stickslip::fit::checks::Finding;
use stickslip::fit::compare::{Skipped, Visibility};

use crate::format;
use crate::table::{BOLD, RED, Text};

/// A number, or several, with its name and SI unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Fact {
    /// What it is.
    pub name: String,
    /// Its values in `unit`.
    pub values: Vec<f64>,
    /// SI unit (Hz for frequencies).
    pub unit: &'static str,
}

impl Fact {
    /// The fact `name` of `values`.
    pub fn new(name: &str, values: Vec<f64>, unit: &'static str) -> Self {
        Self { name: name.to_owned(), values, unit }
    }
}

/// What is known before a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckReport {
    /// What was looked at.
    pub title: String,
    /// What the model's numbers come to.
    pub facts: Vec<Fact>,
    /// What is wrong.
    pub findings: Vec<Finding>,
    /// What the records are.
    pub data: Vec<Fact>,
    /// How far the data depend on each parameter that a fit may change.
    pub visible: Vec<Visibility>,
    /// The records that the model does not predict.
    pub skipped: Vec<Skipped>,
    /// What the data cannot show, a sentence each.
    pub limits: Vec<String>,
}

/// The report as text, in lines of at most `width` columns.
pub fn check_table(report: &CheckReport, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    out.paragraph(&report.title, BOLD);
    for finding in crate::findings(&report.findings) {
        out.paragraph(&finding, RED);
    }
    for Skipped { record, reason } in &report.skipped {
        out.paragraph(&format!("{record} cannot be predicted, and so shows nothing: {reason}."), RED);
    }
    if report.findings.is_empty() && report.skipped.is_empty() {
        out.paragraph("Nothing is wrong as far as can be seen before a fit.", "");
    }
    let mut list = |title: &str, lines: Vec<String>| {
        if !lines.is_empty() {
            out.line("");
            out.paragraph(title, BOLD);
            lines.iter().for_each(|line| out.paragraph(line, ""));
        }
    };
    list("The model", report.facts.iter().map(fact).collect());
    list("The data", report.data.iter().map(fact).collect());
    list(
        "What the data can show: change of the predictions, over each channel's standard deviation, for a change of the parameter by a tenth",
        report.visible.iter().map(visible).collect(),
    );
    list("What they cannot show", report.limits.iter().map(|limit| format!("- {limit}")).collect());
    out.finish()
}

fn fact(fact: &Fact) -> String {
    let values: Vec<String> =
        fact.values.iter().map(|value| format::engineering(*value, fact.unit)).collect();
    format!("{}: {}", fact.name, values.join(", "))
}

fn visible(one: &Visibility) -> String {
    let alike: Vec<String> = one.alike.iter().map(|(path, _)| path.clone()).collect();
    let more = if alike.is_empty() {
        String::new()
    } else {
        format!("; hardly told apart from {}", alike.join(", "))
    };
    format!("{}: {}{more}", one.path, format::error(one.change))
}

/// The same as JSON, schema `stickslip.check/1`.
///
/// ```json
/// {"schema": "stickslip.check/1", "title": "model.toml",
///  "model": {"friction limit": {"values": [50.0], "unit": "N"}},
///  "checks": [{"file": null, "channel": "beam.youngs_modulus", "fault": "implausible", "message": "..."}],
///  "data": {"loop.csv: length": {"values": [1.0], "unit": "s"}},
///  "visible": {"contact.friction_coefficient": {"change": 0.07, "alike": ["contact.normal_load"]}},
///  "skipped": [{"file": "open.csv", "reason": "..."}], "limits": ["the noise is unknown: ..."]}
/// ```
pub fn check_json(report: &CheckReport) -> Value {
    let facts = |all: &[Fact]| -> Map<String, Value> {
        all.iter().map(|one| (one.name.clone(), json!({ "values": one.values, "unit": one.unit }))).collect()
    };
    let visible = |one: &Visibility| {
        let alike: Vec<&String> = one.alike.iter().map(|(path, _)| path).collect();
        (one.path.clone(), json!({ "change": one.change, "alike": alike }))
    };
    let skipped = |one: &Skipped| json!({ "file": one.record, "reason": one.reason });
    json!({
        "schema": "stickslip.check/1", "title": report.title, "model": facts(&report.facts),
        "checks": crate::comparison::findings::to_json(&report.findings), "data": facts(&report.data),
        "visible": report.visible.iter().map(visible).collect::<Map<_, _>>(),
        "skipped": report.skipped.iter().map(skipped).collect::<Vec<_>>(), "limits": report.limits,
    })
}
