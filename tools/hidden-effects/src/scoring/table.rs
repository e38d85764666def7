//! What came out, as a page.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::scoring::figures::{ADDED, FLOOR, Figures, is_clear, told};
use crate::scoring::run::Outcome;
use crate::scoring::truth::Class;
use crate::scoring::{calibration, questions};

/// The page; `command` is what made it.
pub fn markdown(outcomes: &[Outcome], command: &str, machine: &str) -> String {
    let mut text = format!(
        "# Hidden effects\n\nSimulated measurements with a hidden effect, made by a program that has no code in \
         common with\nthe models (tools/hidden-effects), and the verdicts of `stickslip diagnose`. Command:\n\n\
         ```sh\n{command}\n```\n\n{} cases. Intervals are Wilson's, 95 %. A group of effects that holds the hidden one \
         counts half.\n{machine}\n",
        outcomes.len()
    );
    clear_cases(&mut text, outcomes);
    breakdown(&mut text, outcomes);
    questions::section(&mut text, outcomes);
    calibration::probabilities(&mut text, outcomes);
    calibration::intervals(&mut text, outcomes);
    confusion(&mut text, outcomes);
    durations(&mut text, outcomes);
    exits(&mut text, outcomes);
    mistakes(&mut text, outcomes);
    text
}

fn clear_cases(text: &mut String, outcomes: &[Outcome]) {
    let first = Figures::of(outcomes, |outcome| is_clear(outcome) && outcome.truth.question.is_none());
    let all = Figures::of(outcomes, is_clear);
    text.push_str(
        "\n## Noise of at most 3 %, full strength\n\nThe first cases are those that there have always been; of the others see \
         \"Later kinds of case\".\n\n| | first cases | all cases | goal |\n|---|---|---|---|\n",
    );
    let mut row = |what: &str, of: &dyn Fn(&Figures<'_>) -> String, goal: &str| {
        let _ = writeln!(text, "| {what} | {} | {} | {goal} |", of(&first), of(&all));
    };
    row("single effects named correctly", &|of| told(of.right(Class::Single)), "≥ 98 %");
    row("pairs named correctly", &|of| told(of.right(Class::Pair)), "≥ 95 %");
    row("false alarms on null cases", &|of| told(of.named_falsely(Class::Null)), "≤ 1 %");
    row("null cases with the verdict nothing-missing", &|of| told(of.right(Class::Null)), "");
    row(
        "effects outside the catalogue with the verdict unexplained",
        &|of| told(of.right(Class::Outside)),
        "",
    );
    row(
        "effects outside the catalogue named as found",
        &|of| told(of.named_falsely(Class::Outside)),
        "≤ 2 %",
    );
    row("parameters inside their interval", &|of| told(of.coverage()), "90 … 99 %");
    for (noise, of_noise, near, most) in
        [("noise floor reported", FLOOR, "all", "≤ 1.15"), ("noise added", ADDED, "", "")]
    {
        row(&format!("test error ≤ 1.15 × the {noise}"), &|of| told(of.test_error_near(of_noise)), near);
        let largest = |of: &Figures<'_>| {
            of.test_errors(of_noise).last().map_or("–".to_owned(), |value| format!("{value:.3}"))
        };
        row(&format!("largest test error over the {noise}"), &largest, most);
    }
    text.push_str(
        "\nThe noise added is a fraction of a channel's root mean square, its mean included. The error and the noise floor\n\
         that the diagnosis reports are over the channel's standard deviation, which is less where the force has a mean.\n",
    );
}

fn breakdown(text: &mut String, outcomes: &[Outcome]) {
    text.push_str(
        "\n## By kind, noise and strength\n\nThe test error over the noise added, and the seconds, are medians.\n\n\
         | | single | pairs | false alarms | outside: unexplained | outside: named | intervals correct | test error/noise | s |\n\
         |---|---|---|---|---|---|---|---|---|\n",
    );
    let mut groups: Vec<(String, Vec<&Outcome>)> = Vec::new();
    let mut add = |label: String, outcome| match groups.iter_mut().find(|(name, _)| *name == label) {
        Some((_, members)) => members.push(outcome),
        None => groups.push((label, vec![outcome])),
    };
    for outcome in outcomes {
        add("all".to_owned(), outcome);
    }
    let first = |outcome: &&Outcome| outcome.truth.question.is_none();
    if !outcomes.iter().all(|outcome| first(&outcome)) {
        outcomes.iter().filter(first).for_each(|outcome| add("first cases".to_owned(), outcome));
    }
    for outcome in outcomes {
        add(outcome.truth.kind.clone(), outcome);
    }
    let mut by_noise: Vec<&Outcome> = outcomes.iter().collect();
    by_noise.sort_by(|a, b| a.truth.noise.total_cmp(&b.truth.noise));
    for outcome in by_noise {
        add(format!("noise {} %", (outcome.truth.noise * 1e4).round() / 100.0), outcome);
    }
    for outcome in outcomes {
        add(if outcome.truth.coloured { "coloured" } else { "white" }.to_owned(), outcome);
    }
    for outcome in outcomes.iter().filter(|outcome| outcome.truth.class() != Class::Null) {
        add(format!("{} strength", outcome.truth.strength), outcome);
    }
    for outcome in outcomes.iter().filter(|outcome| outcome.truth.moving) {
        add("records not stationary".to_owned(), outcome);
    }
    for (label, members) in groups {
        let _ = writeln!(text, "| {label} | {} |", Figures { outcomes: members }.row().join(" | "));
    }
}

fn confusion(text: &mut String, outcomes: &[Outcome]) {
    text.push_str(
        "\n## Confusion\n\nThe hidden effect, and the verdicts with their number. `a | b`: a group that cannot be distinguished; \
         in\nbrackets: a verdict without an effect.\n",
    );
    for kind in kinds(outcomes) {
        let mut rows: BTreeMap<(Class, String), BTreeMap<String, usize>> = BTreeMap::new();
        for outcome in outcomes.iter().filter(|outcome| outcome.truth.kind == kind) {
            let row = rows.entry((outcome.truth.class(), outcome.truth.label())).or_default();
            *row.entry(outcome.diagnosis.label().replace('|', "\\|")).or_default() += 1;
        }
        let _ = writeln!(text, "\n### {kind}\n\n| hidden | cases | verdict |\n|---|---:|---|");
        for ((_, truth), said) in rows {
            let count: usize = said.values().sum();
            let mut said: Vec<(String, usize)> = said.into_iter().collect();
            said.sort_by(|a, b| b.1.cmp(&a.1).then_with(|| a.0.cmp(&b.0)));
            let said: Vec<String> = said.iter().map(|(label, count)| format!("{label} × {count}")).collect();
            let _ = writeln!(text, "| {truth} | {count} | {} |", said.join("; "));
        }
    }
}

fn durations(text: &mut String, outcomes: &[Outcome]) {
    text.push_str("\n## Seconds per case\n\n| kind | cases | median | largest |\n|---|---:|---:|---:|\n");
    for kind in kinds(outcomes) {
        let seconds = Figures::of(outcomes, |outcome| outcome.truth.kind == kind).seconds();
        let (median, largest) = (seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
        let _ = writeln!(text, "| {kind} | {} | {median:.1} | {largest:.1} |", seconds.len());
    }
}

/// What the program's exit codes say, beside its words.
fn exits(text: &mut String, outcomes: &[Outcome]) {
    let mut codes: BTreeMap<(Option<i32>, &str), usize> = BTreeMap::new();
    for outcome in outcomes {
        *codes.entry((outcome.exit, &outcome.diagnosis.verdict)).or_default() += 1;
    }
    text.push_str("\n## Exit codes\n\n| exit code | verdict | cases |\n|---|---|---:|\n");
    for ((code, verdict), count) in codes {
        let code = code.map_or("none".to_owned(), |code| code.to_string());
        let _ = writeln!(text, "| {code} | {verdict} | {count} |");
    }
}

/// Kinds of model, in the order in which they come.
pub fn kinds(outcomes: &[Outcome]) -> Vec<&str> {
    let mut kinds: Vec<&str> = Vec::new();
    for outcome in outcomes {
        if !kinds.contains(&outcome.truth.kind.as_str()) {
            kinds.push(&outcome.truth.kind);
        }
    }
    kinds
}

fn mistakes(text: &mut String, outcomes: &[Outcome]) {
    let wrong: Vec<&Outcome> = outcomes.iter().filter(|outcome| outcome.score.right < 1.0).collect();
    if wrong.is_empty() {
        return;
    }
    text.push_str("\n## Errors\n\n| case | verdict |\n|---|---|\n");
    for outcome in wrong {
        let _ = writeln!(text, "| {} | {} |", outcome.name, outcome.diagnosis.label().replace('|', "\\|"));
    }
}
