//! The HTML page.

use maud::{DOCTYPE, Markup, PreEscaped, html};
use stickslip::diagnose::{Comparison, Noise};

use crate::comparison::floors;
use crate::comparison::stages::{self, name};
use crate::comparison::summary::{self, Levels, Summary};
use crate::document::{self, Section};
use crate::figure::{Captioned, Figures};
use crate::{Settings, explorer, format, plots, tables, transfer};

/// Nothing may be fetched, from anywhere: the browser enforces what the page promises.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      img-src data: blob:; base-uri 'none'; form-action 'none'";

/// The script library that draws the figures, packed: its licence, then what the page's script unpacks.
const PLOTLY: &str = include_str!(concat!(env!("OUT_DIR"), "/plotly.packed"));

/// One self-contained HTML page: it opens without a network, prints, and reads on a small screen.
///
/// `noise` is what is known of the noise ([`stickslip::diagnose::noise_of`]). Besides these two it depends on
/// nothing but `settings`, so that the same call gives the same
/// bytes. Names from files are escaped wherever they appear. Long records are drawn with about 2 000
/// points that keep the extremes of every stretch, and the captions say so.
///
/// ```
/// use stickslip::diagnose::{Comparison, Noise};
/// let comparison = Comparison { title: "joint A".into(), records: vec![], ring_downs: vec![], findings: vec![], notes: vec![], stages: vec![] };
/// let page = stickslip_report::html(&comparison, &[], &stickslip_report::Settings::default());
/// assert!(page.starts_with("<!DOCTYPE html>"));
/// ```
pub fn html(comparison: &Comparison, noise: &[Noise], settings: &Settings) -> String {
    html_with(comparison, noise, &[], settings)
}

/// As [`html()`], with `more` sections after those of the comparison.
pub fn html_with(comparison: &Comparison, noise: &[Noise], more: &[Section], settings: &Settings) -> String {
    let summary = summary::summarise(comparison);
    let levels = summary::levels(comparison);
    let mut figures = Figures::default();
    let sections = html! {
        (crate::comparison::fitted::section(comparison))
        (stage_section(comparison, &summary, &levels, noise))
        @if let Some(one) = transfer::section(comparison) { (document::section(&mut figures, &one)) }
        @for table in &levels { (backbone_section(&mut figures, comparison, table)) }
        (gain_section(&mut figures, comparison, &summary))
        @for one in &comparison.ring_downs { (crate::comparison::ring_down::section(one)) }
        (record_section(&mut figures, comparison, noise))
        @if comparison.stages.iter().any(|stage| !stage.parameters.is_empty()) {
            section id="parameters" { h2 { "Parameters" } (stages::parameter_table(comparison)) }
        }
        @for one in more { (document::section(&mut figures, one)) }
        (settings_section(settings))
    };
    Shell {
        title: &comparison.title,
        badge: None,
        verdict: &floors::with_noise(&summary.verdict, comparison, &summary, noise),
        warnings: &summary.notes,
        scope: &scope(comparison, &levels),
        sections,
        figures: &figures,
    }
    .page(settings)
}

/// What every page has around its sections.
pub(crate) struct Shell<'a> {
    pub title: &'a str,
    /// The verdict in a word or two, and the class that colours it.
    pub badge: Option<(&'a str, &'a str)>,
    pub verdict: &'a str,
    pub warnings: &'a [String],
    pub scope: &'a str,
    pub sections: Markup,
    pub figures: &'a Figures,
}

impl Shell<'_> {
    /// The whole page.
    pub fn page(self, settings: &Settings) -> String {
        let Shell { title, badge, verdict, warnings, scope, sections, figures } = self;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta http-equiv="Content-Security-Policy" content=(POLICY);
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="referrer" content="no-referrer";
                    title { (name(title)) }
                    style { (PreEscaped(include_str!("style.css"))) }
                }
                body {
                    header {
                        h1 { (name(title)) }
                        @if let Some((text, class)) = badge { p { span class=(format!("badge {class}")) { (text) } } }
                        p.verdict { (spans(verdict)) }
                        @for note in warnings { p.warning { (spans(note)) } }
                        p.quiet { (name(scope)) " " (made(settings)) }
                        (contents(&sections))
                    }
                    p.warning id="undrawn" hidden {
                        "The figures could not be drawn; a browser from 2023 or later does. The tables are complete."
                    }
                    noscript { p.warning { "The figures need JavaScript; the tables do not." } }
                    main { (sections) }
                    script type="application/json" id="figures" { (PreEscaped(figures.to_json())) }
                    script type="text/plain" id="library" { (PreEscaped(PLOTLY)) }
                    script {
                        (PreEscaped(include_str!("explorer.js")))
                        (PreEscaped(include_str!("page.js")))
                    }
                }
            }
        };
        page.into_string()
    }
}

/// Text in which what stands between backticks is a command or a key.
pub(crate) fn spans(text: &str) -> Markup {
    html! {
        @for (index, part) in text.split('`').enumerate() {
            @if index % 2 == 1 { code { (name(part)) } } @else { (name(part)) }
        }
    }
}

/// Version and date, in a sentence.
fn made(settings: &Settings) -> String {
    let version = Some(format!("stickslip {}", settings.version)).filter(|_| !settings.version.is_empty());
    let parts: Vec<String> = version.into_iter().chain(settings.date.as_deref().map(name)).collect();
    if parts.is_empty() { String::new() } else { format!("{}.", parts.join(", ")) }
}

/// Sections up to which a page needs no list of them.
const FEW: usize = 2;

/// Links to the sections, by their headings.
fn contents(sections: &Markup) -> Markup {
    let heading = |part: &str| {
        let (id, rest) = part.split_once('"')?;
        let title = rest.split_once("<h2>")?.1.split_once("</h2>")?.0;
        // Another section may begin before a heading does.
        (!rest.split_once("<h2>")?.0.contains("<section")).then(|| (id.to_owned(), title.to_owned()))
    };
    let all: Vec<(String, String)> = sections.0.split("<section id=\"").skip(1).filter_map(heading).collect();
    html! {
        @if all.len() > FEW {
            nav.contents aria-label="Contents" {
                ul { @for (id, title) in &all { li { a href={ "#" (id) } { (PreEscaped(title)) } } } }
            }
        }
    }
}

/// What was compared, and where the largest error remains.
fn scope(comparison: &Comparison, levels: &[Levels]) -> String {
    let records = format::count(comparison.records.len(), "record");
    let count = comparison.stages.len();
    let stages = match &comparison.stages[..] {
        [] => return format!("{records}."),
        [only] => format!("“{}”", only.name),
        [first, .., last] => format!("{count} stages of the model, from “{}” to “{}”", first.name, last.name),
    };
    // A record without a prediction is said above, as a warning.
    let failed = |record: usize| {
        comparison.stages.last().is_some_and(|stage| summary::failure(stage, record).is_some())
    };
    if (0..comparison.records.len()).any(failed) {
        return format!("{records} against {stages}.");
    }
    let worst = summary::worst(comparison, levels, count - 1);
    format!("{records} against {stages}. Largest error that remains: {worst}.")
}

fn stage_section(comparison: &Comparison, summary: &Summary, levels: &[Levels], noise: &[Noise]) -> Markup {
    html! {
        section id="stages" {
            h2 { "Error of each stage" }
            (stages::stage_table(comparison, summary, levels))
            p.note {
                "Error that noise alone would cause (normalised): "
                @match floors::total(comparison, noise) {
                    Some(floor) => { strong { (format::error(floor)) } ", " (floors::sources(noise)) "." }
                    None => { strong { "unknown" } "." }
                }
            }
        }
    }
}

/// What each stage gains; empty where there are no two to compare.
fn gain_section(figures: &mut Figures, comparison: &Comparison, summary: &Summary) -> Markup {
    let (steps, figure) = (stages::step_list(comparison), plots::waterfall(figures, comparison, summary));
    let style = format!("height:{}px", 112 + 48 * comparison.stages.len().min(12));
    html! {
        @if figure.is_some() || !steps.0.is_empty() {
            section id="gains" {
                h2 { "What each stage changes" }
                @if let Some(figure) = figure {
                    (figure_element(&Captioned {
                        figure,
                        caption: "From the first stage’s error to what remains. Green lowers the error, orange raises it."
                            .to_owned(),
                        half: false,
                    }, &style))
                }
                (steps)
            }
        }
    }
}

pub(crate) fn backbone_section(figures: &mut Figures, comparison: &Comparison, levels: &Levels) -> Markup {
    let record = &comparison.records[levels.record];
    let channel = plots::prose(&levels.channel);
    let figure = plots::backbone(figures, comparison, levels);
    let caption = format!(
        "{}: measured {channel} (circles) and every stage’s prediction against {}; below, predicted minus \
         measured. Lines join the levels and only lead the eye.",
        record.name, levels.over
    );
    html! {
        section id=(format!("levels-{}-{}", levels.record, identifier(&levels.channel))) {
            // Several tables may show the same channel, and the contents list them all.
            h2 {
                (name(&format!("{channel} against {}", levels.over)))
                @if comparison.records.len() > 1 { ": " (name(&record.name)) }
            }
            (figure_element(&Captioned { figure, caption, half: false }, "height:576px"))
            (stages::level_table(comparison, levels))
        }
    }
}

/// `name` as part of an identifier in a page.
fn identifier(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect()
}

/// The tables of all records and the views of those in time, the worst first.
fn record_section(figures: &mut Figures, comparison: &Comparison, noise: &[Noise]) -> Markup {
    let time = worst_first(comparison);
    if time.is_empty() && comparison.records.len() < 2 {
        return html! {};
    }
    html! {
        section id="records" {
            h2 { "Records" }
            @for record in 0..comparison.records.len() { (failures(comparison, record)) }
            (tables::record_table(comparison, noise))
            (tables::harmonic_table(comparison))
        }
        (explorer::section(figures, comparison, &time, noise))
    }
}

/// Time records by the error of the last stage, those without a prediction after all others.
pub(crate) fn worst_first(comparison: &Comparison) -> Vec<usize> {
    let mut records: Vec<usize> = (0..comparison.records.len())
        .filter(|&record| !comparison.records[record].regime.is_table())
        .collect();
    let error = |record: usize| {
        let error = comparison.stages.last().map_or(0.0, |stage| summary::record_error(stage, record));
        if error.is_finite() { error } else { f64::NEG_INFINITY }
    };
    records.sort_by(|&a, &b| error(b).total_cmp(&error(a)));
    records
}

/// Why stages have no prediction of a record.
pub(crate) fn failures(comparison: &Comparison, record: usize) -> Markup {
    html! {
        @for stage in &comparison.stages {
            @if let Some(reason) = summary::failure(stage, record) {
                p.warning {
                    "No prediction of " (name(&comparison.records[record].name)) " by "
                    strong { (name(&stage.name)) } ": " (name(reason))
                }
            }
        }
    }
}

pub(crate) fn figure_element(one: &Captioned, style: &str) -> Markup {
    html! {
        figure.half[one.half] {
            div.plot data-figure=(one.figure) style=(style) role="img" aria-label=(name(&one.caption)) {}
            figcaption { (name(&one.caption)) }
        }
    }
}

pub(crate) fn settings_section(settings: &Settings) -> Markup {
    html! {
        section id="settings" {
            h2 { "How to repeat this" }
            @if !settings.command.is_empty() { pre { code { (name(&settings.command)) } } }
            @if !settings.version.is_empty() { p { "stickslip " (name(&settings.version)) } }
            @if !settings.files.is_empty() {
                div.scroll tabindex="0" role="region" aria-label="Files" {
                    table.files {
                        thead { tr { th { "File" } th { "SHA-256" } } }
                        tbody { @for file in &settings.files {
                            tr { th scope="row" { (name(&file.name)) } td { code { (name(&file.sha256)) } } }
                        } }
                    }
                }
            }
            p.note {
                "This page is complete in itself and fetches nothing. The figures are drawn by plotly.js, "
                "which it contains (MIT licence, Plotly, Inc.)."
            }
        }
    }
}
