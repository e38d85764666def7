//! The HTML page of a diagnosis.

use maud::{Markup, html};
use stickslip::diagnose::Diagnosis;

use super::{Run, figures, residual, sections, terminal, words};
use crate::comparison::stages;
use crate::comparison::summary;
use crate::figure::Figures;
use crate::page::{Shell, backbone_section, failures, figure_element, settings_section, spans, worst_first};
use crate::{Settings, explorer, format, tables};

/// One self-contained HTML page, verdict first; see [`crate::html`] for what that means.
///
/// Besides `diagnosis` and `run` it depends on nothing but `settings`: the same call gives the same bytes.
pub fn diagnosis_html(diagnosis: &Diagnosis, run: &Run, settings: &Settings) -> String {
    let mut drawn = Figures::default();
    let title = match diagnosis.comparison.title.as_str() {
        "" => "Which effect is missing".to_owned(),
        title => format!("Which effect is missing: {title}"),
    };
    let sections = html! {
        (sections::next(diagnosis, run))
        (crate::comparison::fitted::section(&diagnosis.comparison))
        (fall(&mut drawn, diagnosis))
        (sections::why(diagnosis))
        (sections::effects(diagnosis))
        (residual::section(&mut drawn, diagnosis))
        (candidates(&mut drawn, diagnosis))
        (super::alike::section(diagnosis))
        (sections::detectable(diagnosis))
        (failing(&mut drawn, diagnosis))
        @if diagnosis.comparison.stages.iter().any(|stage| !stage.parameters.is_empty()) {
            section id="parameters" { h2 { "Parameters" } (stages::parameter_table(&diagnosis.comparison)) }
        }
        (sections::noise(diagnosis))
        (sections::method(diagnosis, run))
        (settings_section(settings))
    };
    Shell {
        title: &title,
        badge: Some((words::badge(diagnosis), diagnosis.verdict.id())),
        verdict: &words::verdict(diagnosis),
        warnings: &words::warnings(diagnosis, run),
        scope: &scope(diagnosis, run),
        sections,
        figures: &drawn,
    }
    .page(settings)
}

fn scope(diagnosis: &Diagnosis, run: &Run) -> String {
    let records = format::count(diagnosis.comparison.records.len(), "record");
    let model = if run.model.is_empty() { "the model" } else { &run.model };
    let data = if run.dataset.is_empty() { String::new() } else { format!(" of {}", run.dataset) };
    format!("{model} against {records}{data}. {}.", terminal::effort(diagnosis))
}

fn fall(drawn: &mut Figures, diagnosis: &Diagnosis) -> Markup {
    html! {
        section id="error" {
            h2 { "How the error falls" }
            @if let Some(figure) = figures::waterfall(drawn, diagnosis) {
                (figure_element(&figure, &format!("height:{}px", 112 + 48 * diagnosis.comparison.stages.len().min(12))))
            }
            (sections::errors(diagnosis))
        }
    }
}

fn candidates(drawn: &mut Figures, diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.candidates.is_empty() || !diagnosis.untried.is_empty() {
            section id="candidates" {
                h2 { "Candidates" }
                @if let Some((figure, height)) = figures::ranking(drawn, &diagnosis.candidates) {
                    (figure_element(&figure, &format!("height:{height}px")))
                }
                (sections::candidates(diagnosis))
            }
        }
    }
}

/// The tables of records and the views.
fn failing(drawn: &mut Figures, diagnosis: &Diagnosis) -> Markup {
    let comparison = &diagnosis.comparison;
    let noise = &diagnosis.noise;
    html! {
        (explorer::section(drawn, comparison, &worst_first(comparison), noise))
        @for table in &summary::levels(comparison) { (backbone_section(drawn, comparison, table)) }
        @if let Some(one) = crate::transfer::section(comparison) { (crate::document::section(drawn, &one)) }
        section id="records" {
            h2 { "Records" }
            @for record in 0..comparison.records.len() { (failures(comparison, record)) }
            (sections::split(diagnosis))
            (tables::record_table(comparison, noise))
            (tables::harmonic_table(comparison))
        }
    }
}

/// A paragraph of several, as a list where there is more than one.
pub fn list(all: &[String]) -> Markup {
    html! {
        @match all {
            [] => {}
            [only] => { p.text { (spans(only)) } }
            more => { ul.text { @for one in more { li { (spans(one)) } } } }
        }
    }
}
