//! A diagnosis as text for a terminal.

use stickslip::diagnose::{Candidate, Detectable, Diagnosis, Verdict};

use super::{Run, residual, words};
use crate::format;
use crate::table::{BOLD, RED, Text};

/// Candidates shown at most; the files hold all.
const CANDIDATES: usize = 8;

/// Verdict, what to do next, why, the fall of the error and the best candidates, in lines of at most `width`
/// columns (at least 40 are used). With `color`, ANSI sequences are added.
pub fn diagnosis_table(diagnosis: &Diagnosis, run: &Run, width: usize, color: bool) -> String {
    let mut out = Text::new(width, color);
    out.paragraph(words::badge(diagnosis), BOLD);
    out.paragraph(&words::verdict(diagnosis), "");
    for warning in words::warnings(diagnosis, run) {
        out.paragraph(&warning, RED);
    }
    heading(&mut out, "Next");
    for step in words::next_steps(diagnosis, run) {
        out.paragraph(&format!("- {step}"), "");
    }
    found(&mut out, diagnosis);
    crate::table::fitted(&mut out, &diagnosis.comparison);
    why(&mut out, diagnosis);
    listed(&mut out, "Residual: measured minus predicted", &residual::told(diagnosis));
    listed(&mut out, "Detection limits: sizes that would have been found", &limits(diagnosis));
    errors(&mut out, diagnosis);
    candidates(&mut out, &diagnosis.candidates);
    out.line("");
    out.paragraph(&effort_and_time(diagnosis, run), "");
    out.finish()
}

fn heading(out: &mut Text, text: &str) {
    out.line("");
    out.paragraph(text, BOLD);
}

/// The parameters of what was found, with their intervals.
fn found(out: &mut Text, diagnosis: &Diagnosis) {
    // Of sets that hold nothing else: a larger one that predicts the same was weighed, and not found.
    let found = |one: &&Candidate| one.effects.iter().all(|id| diagnosis.effects.contains(id));
    let fitted = |id: &&str| {
        let all = diagnosis.rounds.iter().rev().flatten().chain(&diagnosis.candidates);
        all.filter(found).filter(|one| one.effects.contains(id)).find(|one| !one.parameters.is_empty())
    };
    let mut all: Vec<&Candidate> = diagnosis.effects.iter().filter_map(fitted).collect();
    all.dedup_by(|a, b| std::ptr::eq(*a, *b));
    if !all.is_empty() {
        heading(out, "Found (95 % intervals in brackets)");
    }
    for one in all {
        let numbers: Vec<String> = one
            .parameters
            .iter()
            .map(|estimate| format!("{} = {}", words::parameter(&estimate.name), words::estimate(estimate)))
            .collect();
        out.paragraph(&format!("- {}: {}", words::candidate(one), numbers.join(", ")), "");
    }
}

fn listed(out: &mut Text, title: &str, lines: &[String]) {
    if !lines.is_empty() {
        heading(out, title);
        lines.iter().for_each(|line| out.paragraph(&format!("- {line}"), ""));
    }
}

/// What would have been found, where nothing was.
fn limits(diagnosis: &Diagnosis) -> Vec<String> {
    let null = matches!(diagnosis.verdict, Verdict::NothingMissing | Verdict::InsufficientData);
    let one = |one: &Detectable| {
        let size = format::engineering(words::rounded(one.value?), one.unit);
        Some(format!("{}: {} {size}", words::title(one.effect), words::parameter(one.parameter)))
    };
    diagnosis.detectable.iter().filter(|_| null).filter_map(one).collect()
}

fn why(out: &mut Text, diagnosis: &Diagnosis) {
    if diagnosis.reasons.is_empty() && diagnosis.evidence.is_empty() {
        return;
    }
    heading(out, "Why");
    for reason in &diagnosis.reasons {
        out.paragraph(&format!("- {reason}"), "");
    }
    for evidence in &diagnosis.evidence {
        out.paragraph(&format!("- {}: {}", words::title(evidence.effect), evidence.seen), "");
        if let Some(otherwise) = &evidence.otherwise {
            out.paragraph(&format!("  What else could cause it: {otherwise}"), "");
        }
    }
    for group in &diagnosis.groups {
        out.paragraph(&format!("- {}: {}", words::titles(&group.effects, "or"), group.reason), "");
    }
}

fn errors(out: &mut Text, diagnosis: &Diagnosis) {
    let error = &diagnosis.error;
    heading(out, "Error, normalised by each channel's standard deviation");
    let floor = |value: Option<f64>| value.map_or_else(|| "unknown".to_owned(), format::error);
    let added: Vec<&str> = match diagnosis.verdict {
        Verdict::EffectFound => diagnosis.effects.clone(),
        _ => diagnosis.steps.iter().flat_map(|step| step.added.clone()).collect(),
    };
    let mut left = vec![String::new(), "as given".to_owned(), "refitted".to_owned()];
    let mut cells = vec![
        vec!["all records".to_owned(), "test records".to_owned()],
        vec![format::error(error.baseline), format::error(words::test_baseline(diagnosis))],
        vec![format::error(error.refitted), format::error(error.test_refitted)],
    ];
    if !added.is_empty() {
        left.push(format!("with {}", words::titles(&added, "and")));
        cells.push(vec![format::error(error.last), format::error(error.test)]);
    }
    left.push("noise alone".to_owned());
    cells.push(vec![floor(error.noise_floor), floor(error.test_noise_floor)]);
    out.grid(&left, &cells, 0);
}

fn candidates(out: &mut Text, candidates: &[Candidate]) {
    if candidates.is_empty() {
        return;
    }
    heading(out, "Candidates, each refitted with the whole model; error on the training records");
    let mut left = vec!["effect".to_owned()];
    let mut cells = vec![["error", "gain", "z", "parameter"].map(str::to_owned).to_vec()];
    for one in candidates.iter().take(CANDIDATES) {
        left.push(format::printable(&words::candidate(one)));
        cells.push(match one.parameters.first() {
            None => vec![String::new(), String::new(), String::new(), "promises too little".to_owned()],
            Some(first) => vec![
                format::error(one.error),
                gain(one),
                format::fixed(one.gain_z, 2),
                format!("{} {}", first.name, format::engineering(first.value, first.unit)),
            ],
        });
    }
    out.grid(&left, &cells, 0);
    if candidates.len() > CANDIDATES {
        out.line(&format!("… and {} more", candidates.len() - CANDIDATES));
    }
}

/// Fraction of the squared error removed, in per cent.
pub fn gain(candidate: &Candidate) -> String {
    if !candidate.gain_fraction.is_finite() {
        return format::ABSENT.to_owned();
    }
    if candidate.gain_fraction < -1.0 {
        return "worse".to_owned();
    }
    format::Scale { factor: 100.0, unit: "%".to_owned(), decimals: 1 }.with_unit(candidate.gain_fraction)
}

/// What it took, in one line, without the time: the same input gives the same page.
pub fn effort(diagnosis: &Diagnosis) -> String {
    let refits = format::count(diagnosis.cost.refits, "refit");
    let simulations = format::count(diagnosis.cost.simulations, "simulated record");
    format!("{refits}, {simulations}")
}

/// What it took, and how long.
fn effort_and_time(diagnosis: &Diagnosis, run: &Run) -> String {
    let rate = diagnosis.cost.refits as f64 / run.seconds;
    let rate = if rate.is_finite() && rate > 0.0 {
        format!(", {} refits a second", format::significant(rate, 2))
    } else {
        String::new()
    };
    format!("{} in {} s{rate}.", effort(diagnosis), format::significant(run.seconds, 2))
}
