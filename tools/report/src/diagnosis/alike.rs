//! How alike the candidates are: a map that needs no script, and prints.

use maud::{Markup, html};
use stickslip::diagnose::{ALIKE, Diagnosis};

use super::words;

/// The section; empty where nothing was set against anything else.
pub fn section(diagnosis: &Diagnosis) -> Markup {
    let ids = in_question(diagnosis);
    html! {
        @if ids.len() > 1 {
            section id="confounding" {
                h2 { "Which effects these data can distinguish" }
                (map(diagnosis, &ids))
                p.note {
                    "How similar two candidates are in these data: the size of the correlation (0 to 1) of their changes of the \
                     prediction, after the model’s own parameters are refitted. From " (ALIKE) " on (orange, bold) these data \
                     cannot distinguish the two. A dash: not compared, since the one or the other changes nothing here."
                }
            }
        }
    }
}

/// The effects that were compared, in the order of the ranking, so that those that matter are in a corner.
fn in_question(diagnosis: &Diagnosis) -> Vec<&'static str> {
    let mut ids: Vec<&str> = Vec::new();
    let ranked = diagnosis.candidates.iter().flat_map(|one| one.effects.iter().copied());
    let pairs = diagnosis.confounding.iter().flat_map(|one| one.effects);
    for id in ranked.chain(pairs) {
        let known = diagnosis.confounding.iter().any(|one| one.effects.contains(&id));
        if known && !ids.contains(&id) {
            ids.push(id);
        }
    }
    ids
}

/// Absolute correlation of two effects; `None` where it is not known.
fn correlation(diagnosis: &Diagnosis, a: &str, b: &str) -> Option<f64> {
    let pair = diagnosis.confounding.iter().find(|one| one.effects == [a, b] || one.effects == [b, a])?;
    Some(pair.correlation.abs()).filter(|value| value.is_finite())
}

fn map(diagnosis: &Diagnosis, ids: &[&str]) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="Correlation of effects" {
            table.map {
                thead { tr {
                    td {}
                    @for id in ids { th scope="col" { span { (words::title(id)) } } }
                } }
                tbody { @for (row, a) in ids.iter().enumerate() { tr {
                    th scope="row" { (words::title(a)) }
                    @for (column, b) in ids.iter().enumerate() {
                        @match correlation(diagnosis, a, b) {
                            _ if row == column => td.same {},
                            Some(value) => td.alike[value >= ALIKE] style=(ground(value)) title=(pair(a, b)) {
                                (format!("{value:.2}"))
                            },
                            None => td title=(pair(a, b)) { (crate::format::ABSENT) },
                        }
                    }
                } } }
            }
        }
    }
}

fn pair(a: &str, b: &str) -> String {
    format!("{} and {}", words::title(a), words::title(b))
}

/// The colour of a cell, which lets light and dark pages through.
fn ground(value: f64) -> String {
    match value >= ALIKE {
        true => "background:rgba(213,94,0,.55)".to_owned(),
        false => format!("background:rgba(0,114,178,{:.2})", 0.55 * value),
    }
}
