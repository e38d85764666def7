//! The sections of the page of a diagnosis that are words and tables.

use maud::{Markup, html};
use stickslip::data::Use;
use stickslip::diagnose::{Candidate, Diagnosis, Estimate, Verdict};
use stickslip::effects::{self, Effect};

use super::page::list;
use super::{Run, terminal, words};
use crate::comparison::stages::name;
use crate::format;
use crate::plots::prose;

/// What to do.
pub fn next(diagnosis: &Diagnosis, run: &Run) -> Markup {
    let steps = words::next_steps(diagnosis, run);
    html! {
        @if !steps.is_empty() {
            section id="next" {
                h2 { "What to do next" }
                div.card { (list(&steps)) }
            }
        }
    }
}

/// The errors of the stages, as a table.
pub fn errors(diagnosis: &Diagnosis) -> Markup {
    let error = &diagnosis.error;
    let floor = |floor: Option<f64>| floor.map_or_else(|| "unknown".to_owned(), format::error);
    html! {
        div.scroll tabindex="0" role="region" aria-label="Errors" {
            table {
                thead { tr { th { "Normalised error" } th.number { "all records" } th.number { "test records" } } }
                tbody {
                    tr { th scope="row" { "model as given" } td.number { (format::error(error.baseline)) }
                        td.number { (format::error(words::test_baseline(diagnosis))) } }
                    tr {
                        th scope="row" { "refitted" }
                        td.number { (format::error(error.refitted)) }
                        td.number { (format::error(error.test_refitted)) }
                    }
                    @if !diagnosis.steps.is_empty() {
                        tr.final {
                            th scope="row" { "with what was added" }
                            td.number { (format::error(error.last)) }
                            td.number { (format::error(error.test)) }
                        }
                    }
                    tr {
                        th scope="row" { "noise alone" }
                        td.number { (floor(error.noise_floor)) }
                        td.number { (floor(error.test_noise_floor)) }
                    }
                }
            }
        }
        p.note {
            "The normalised error is the root mean square over all compared channels, each divided by its own standard "
            "deviation in its record: 0 is perfect, 1 is no better than the channel’s mean. Nothing is "
            "fitted to the test records, and no effect is selected by them; they are read once, at the end."
            @if let Some(chi_square) = diagnosis.chi_square {
                " On the test records the reduced χ² is " (format::significant(chi_square, 3)) " (1 means noise alone)."
            }
        }
    }
}

/// What the verdict rests on.
pub fn why(diagnosis: &Diagnosis) -> Markup {
    html! {
        section id="why" {
            h2 { "Why" }
            (list(&diagnosis.reasons))
            @for evidence in &diagnosis.evidence {
                div.evidence {
                    h3 { (words::title(evidence.effect)) }
                    p.text { strong { "What was seen: " } (name(&evidence.seen)) }
                    @if let Some(otherwise) = &evidence.otherwise {
                        p.text { strong { "What else could cause it: " } (name(otherwise)) }
                    }
                }
            }
            @for group in &diagnosis.groups {
                div.evidence {
                    h3 { (words::titles(&group.effects, "or")) }
                    p.text { strong { "Why they cannot be distinguished: " } (name(&group.reason)) }
                    p.text { strong { "The experiment that distinguishes them: " } (name(&group.experiment)) }
                }
            }
            (steps(diagnosis))
        }
    }
}

fn steps(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.steps.is_empty() {
            div.scroll tabindex="0" role="region" aria-label="Steps of the selection" {
                table {
                    thead { tr {
                        th { "Step" } th.number { "Error, training records" } th.number { "Squared error removed, of that before" }
                        th.number { "z" }
                    } }
                    tbody { @for step in &diagnosis.steps { tr {
                        th scope="row" { "+ " (words::titles(&step.added, "and")) }
                        td.number { (format::error(step.error)) }
                        td.number { (percent(step.gain_fraction)) }
                        td.number { (format::fixed(step.gain_z, 2)) }
                    } } }
                }
            }
            p.note { "z is √(2 × the gain of log evidence): the gain in standard deviations, the volume of the added parameters' priors taken off." }
        }
    }
}

fn percent(fraction: f64) -> String {
    format::Scale { factor: 100.0, unit: "%".to_owned(), decimals: 1 }.with_unit(fraction)
}

/// What the catalogue says of the effects found, of the members of groups, and of effects that only absorb error.
pub fn effects(diagnosis: &Diagnosis) -> Markup {
    let mut ids: Vec<&str> = Vec::new();
    let grouped = diagnosis.groups.iter().flat_map(|group| group.effects.iter());
    for id in diagnosis.effects.iter().chain(grouped).chain(&diagnosis.surrogates) {
        if !ids.contains(id) {
            ids.push(id);
        }
    }
    let heading = match diagnosis.verdict {
        Verdict::EffectFound if ids.len() == 1 => "The effect",
        Verdict::EffectFound => "The effects",
        Verdict::NotDistinguishable => "The effects in question",
        _ => "Terms that only absorb error: do not read them as physics",
    };
    html! {
        @if !ids.is_empty() {
            section id="effects" {
                h2 { (heading) }
                @for effect in ids.iter().filter_map(|id| effects::find(id)) { (effect_text(effect, diagnosis)) }
            }
        }
    }
}

fn effect_text(effect: &Effect, diagnosis: &Diagnosis) -> Markup {
    let fitted = words::in_the_end(effect, diagnosis);
    html! {
        div.evidence {
            h3 { (effect.title) " " code { (effect.id) } }
            p.text { (effect.summary) "." }
            @if !fitted.is_empty() {
                p.text { strong { "Here: " } (parameters(&fitted)) }
            }
            p.text { strong { "What it is: " } (effect.explanation) }
            p.text { strong { "How to confirm it: " } (effect.confirmation) }
        }
    }
}

fn parameters(all: &[&Estimate]) -> Markup {
    html! {
        @for (index, one) in all.iter().enumerate() {
            @if index > 0 { "; " }
            (name(&words::parameter(&one.name))) " = " span.keep { (name(&words::estimate(one))) }
        }
    }
}

/// The rounds of candidates, and what was not tried.
pub fn candidates(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.candidates.is_empty() {
            (candidate_table("First round: each effect alone added to the model", &diagnosis.candidates, diagnosis))
            p.note {
                "Errors are on the training records. Gain: fraction of the squared error removed, of that of the refitted model without \
                 effects, every channel alike. z: √(2 × the gain of log evidence), negative where the evidence speaks against the \
                 effect; it weighs every sample by its noise and by how long residuals last, and takes the volume of the priors off. The two \
                 need not agree, and z decides. Brackets hold 95 % confidence intervals; they assume that the model is right."
            }
        }
        @for (round, candidates) in diagnosis.rounds.iter().enumerate() {
            details {
                summary { span.record { "Round " (round + 2) } span.quiet { "each effect added to those of the rounds before" } }
                (candidate_table("Candidates of the round", candidates, diagnosis))
            }
        }
        @if !diagnosis.untried.is_empty() {
            details {
                summary { span.record { "Not tried" } span.quiet { (format::count(diagnosis.untried.len(), "effect")) } }
                ul.text { @for one in &diagnosis.untried {
                    li { strong { (words::untried(one, diagnosis)) } ": " (name(&one.reason)) }
                } }
            }
        }
    }
}

fn candidate_table(label: &str, candidates: &[Candidate], diagnosis: &Diagnosis) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label=(label) {
            table {
                thead { tr {
                    th { "Effect" } th.number { "Error" } th.number { "Gain" } th.number { "z" }
                    th { "Parameters" } th.number { "Model runs" }
                } }
                tbody { @for one in candidates { tr {
                    th scope="row" { (name(&words::candidate(one))) }
                    @if words::was_fitted(one) {
                        td.number { (format::error(one.error)) }
                        td.number { (terminal::gain(one)) }
                        td.number { (format::fixed(one.gain_z, 2)) }
                        td {
                            @if words::is_part_of_the_end(one, diagnosis) { "with all that was added: " }
                            (parameters(&one.parameters.iter().collect::<Vec<_>>()))
                        }
                    } @else {
                        @for _ in 0..3 { td.number { (format::ABSENT) } }
                        td { "promises too little to be fitted" }
                    }
                    td.number { (one.evaluations) }
                } } }
            }
        }
    }
}

/// The smallest size of each effect that would have been found.
pub fn detectable(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.detectable.is_empty() {
            section id="detectable" {
                h2 { "Detection limits" }
                p.note {
                    "The smallest size of each effect that would have been found in these data. Relevant: the probability that "
                    "the effect, if it is there, moves a channel by more than 1 % of its variation."
                }
                div.scroll tabindex="0" role="region" aria-label="Detectable sizes" {
                    table {
                        thead { tr { th { "Effect" } th { "Parameter" } th.number { "Smallest size" } th.number { "Relevant" } } }
                        tbody { @for one in &diagnosis.detectable { tr {
                            th scope="row" { (words::title(one.effect)) }
                            td { (words::parameter(one.parameter)) }
                            td.number { @match one.value {
                                Some(value) => { (format::engineering(words::rounded(value), one.unit)) }
                                None => { "not identifiable" }
                            } }
                            td.number { @if let Some(p) = one.relevant { (words::probability(p)) } }
                        } } }
                    }
                }
            }
        }
    }
}

/// What each record was used for.
pub fn split(diagnosis: &Diagnosis) -> Markup {
    let records = &diagnosis.comparison.records;
    let of = |used: Use| -> Vec<String> {
        let all = records.iter().zip(&diagnosis.split).filter(|(_, one)| **one == used);
        all.map(|(record, _)| name(&record.name)).collect()
    };
    let uses = [
        (Use::Fit, "Training"),
        (Use::Select, "Training, marked select"),
        (Use::Confirm, "Test, read once at the end"),
    ];
    html! {
        @if diagnosis.split.len() == records.len() && !records.is_empty() {
            ul.text { @for (used, words) in uses {
                @let found = of(used);
                li { strong { (words) ": " } @if found.is_empty() { "none" } @else { (found.join(", ")) } }
            } }
        }
    }
}

/// The noise of each channel and how it is known.
pub fn noise(diagnosis: &Diagnosis) -> Markup {
    html! {
        @if !diagnosis.noise.is_empty() {
            section id="noise" {
                h2 { "Noise" }
                div.scroll tabindex="0" role="region" aria-label="Noise" {
                    table {
                        thead { tr { th { "Record" } th { "Channel" } th.number { "Standard deviation" } th { "How it is known" } } }
                        tbody { @for one in &diagnosis.noise {
                            @let record = diagnosis.comparison.records.get(one.record);
                            @let unit = record.and_then(|r| r.channel(&one.channel)).map_or("1", |channel| channel.unit);
                            tr {
                                th scope="row" { (record.map_or_else(String::new, |record| name(&record.name))) }
                                td { (name(&prose(&one.channel))) }
                                td.number { (one.deviation.map_or_else(
                                    || "unknown".to_owned(), |value| format::engineering(short(value), unit))) }
                                td { (words::source(one.source)) }
                            }
                        } }
                    }
                }
            }
        }
    }
}

fn short(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

/// How the verdict was reached, and with what settings.
pub fn method(diagnosis: &Diagnosis, run: &Run) -> Markup {
    let tried = match &run.options.effects {
        Some(ids) => ids.iter().map(|id| words::title(id)).collect::<Vec<_>>().join(", "),
        None => "the whole catalogue".to_owned(),
    };
    html! {
        section id="method" {
            h2 { "How this was found" }
            p.text {
                "Each candidate is added to the simulator, and the whole model is refitted with it: otherwise other "
                "parameters could absorb the effect. Sets of candidates, and one that stands for what the catalogue lacks, are "
                "compared by their evidence on the training records. Test records are read once, after that: they may "
                "take a verdict back."
            }
            ul.text {
                li { "Tried: " (name(&tried)) "; at most " (format::count(run.options.max_effects, "effect")) " added." }
                li { (terminal::effort(diagnosis)) "." }
            }
        }
    }
}
