//! What came out, as Markdown and as JSON.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde_json::{Value, json};

use crate::scoring::run::Outcome;
use crate::scoring::score::Score;
use crate::scoring::truth::Class;
use crate::scoring::wilson;

/// Untouched error over the noise up to which a model counts as improved to the noise.
const NEAR: f64 = 1.15;
const ADDED: fn(&Score) -> Option<f64> = |score| score.untouched;
const FLOOR: fn(&Score) -> Option<f64> = |score| score.untouched_told;

/// Figures of a set of cases.
struct Figures<'a> {
    outcomes: Vec<&'a Outcome>,
}

impl<'a> Figures<'a> {
    fn of(outcomes: &'a [Outcome], keep: impl Fn(&Outcome) -> bool) -> Self {
        Self { outcomes: outcomes.iter().filter(|outcome| keep(outcome)).collect() }
    }

    fn class(&self, class: Class) -> impl Iterator<Item = &'a Outcome> {
        self.outcomes.iter().copied().filter(move |outcome| outcome.truth.class() == class)
    }

    /// Points and cases of a class.
    fn right(&self, class: Class) -> (f64, usize) {
        let points = self.class(class).map(|outcome| outcome.score.right).sum();
        (points, self.class(class).count())
    }

    fn named_falsely(&self, class: Class) -> (f64, usize) {
        (
            self.class(class).filter(|outcome| outcome.score.named_falsely).count() as f64,
            self.class(class).count(),
        )
    }

    fn coverage(&self) -> (f64, usize) {
        let told = self.outcomes.iter().map(|outcome| outcome.score.covered);
        let (covered, told) = told.fold((0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1));
        (covered as f64, told)
    }

    /// Errors on test records over the noise that `of` takes, rising.
    fn untouched(&self, of: fn(&Score) -> Option<f64>) -> Vec<f64> {
        let mut ratios: Vec<f64> = self.outcomes.iter().filter_map(|outcome| of(&outcome.score)).collect();
        ratios.sort_by(f64::total_cmp);
        ratios
    }

    fn untouched_near(&self, of: fn(&Score) -> Option<f64>) -> (f64, usize) {
        let ratios = self.untouched(of);
        (ratios.iter().filter(|ratio| **ratio <= NEAR).count() as f64, ratios.len())
    }

    fn seconds(&self) -> Vec<f64> {
        let mut seconds: Vec<f64> = self.outcomes.iter().map(|outcome| outcome.diagnosis.seconds).collect();
        seconds.sort_by(f64::total_cmp);
        seconds
    }

    fn row(&self) -> [String; 8] {
        let median = |values: &[f64]| values.get(values.len() / 2).map(|value| format!("{value:.3}"));
        [
            share(self.right(Class::Single)),
            share(self.right(Class::Pair)),
            share(self.named_falsely(Class::Null)),
            share(self.right(Class::Outside)),
            share(self.named_falsely(Class::Outside)),
            share(self.coverage()),
            median(&self.untouched(ADDED)).unwrap_or_else(|| "–".to_owned()),
            self.seconds()
                .get(self.outcomes.len() / 2)
                .map_or("–".to_owned(), |value| format!("{value:.1}")),
        ]
    }
}

fn share((hits, trials): (f64, usize)) -> String {
    if trials == 0 { "–".to_owned() } else { format!("{:.0} % of {trials}", 100.0 * hits / trials as f64) }
}

/// A share with its interval.
fn told((hits, trials): (f64, usize)) -> String {
    let (low, high) = wilson::interval(hits, trials);
    let percent = |value: f64| format!("{:.1}", 100.0 * value);
    if trials == 0 {
        return "–".to_owned();
    }
    format!(
        "{} % ({hits} of {trials}; {} … {} %)",
        percent(hits / trials as f64),
        percent(low),
        percent(high)
    )
}

/// Full strength and noise of at most 3 %: what the contract's figures are about.
fn is_clear(outcome: &Outcome) -> bool {
    outcome.truth.strength == "full" && outcome.truth.noise <= 0.0301
}

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
    confusion(&mut text, outcomes);
    durations(&mut text, outcomes);
    mistakes(&mut text, outcomes);
    text
}

fn clear_cases(text: &mut String, outcomes: &[Outcome]) {
    let clear = Figures::of(outcomes, is_clear);
    let largest = |of| clear.untouched(of).last().map_or("–".to_owned(), |value| format!("{value:.3}"));
    let rows = [
        ("single effects named correctly", told(clear.right(Class::Single)), "≥ 95 %"),
        ("pairs named correctly", told(clear.right(Class::Pair)), "≥ 80 %"),
        ("false alarms on null cases", told(clear.named_falsely(Class::Null)), "≤ 2 %"),
        ("null cases with the verdict nothing-missing", told(clear.right(Class::Null)), ""),
        ("effects outside the catalogue with the verdict unexplained", told(clear.right(Class::Outside)), ""),
        ("effects outside the catalogue named as found", told(clear.named_falsely(Class::Outside)), "≤ 5 %"),
        ("parameters inside their interval", told(clear.coverage()), ""),
        ("test error ≤ 1.15 × the noise floor reported", told(clear.untouched_near(FLOOR)), "all"),
        ("largest test error over the noise floor reported", largest(FLOOR), "≤ 1.15"),
        ("test error ≤ 1.15 × the noise added", told(clear.untouched_near(ADDED)), ""),
        ("largest test error over the noise added", largest(ADDED), ""),
    ];
    text.push_str("\n## Noise of at most 3 %, full strength\n\n| | measured | goal |\n|---|---|---|\n");
    for (what, measured, goal) in rows {
        let _ = writeln!(text, "| {what} | {measured} | {goal} |");
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
    let mut kinds: Vec<&str> = outcomes.iter().map(|outcome| outcome.truth.kind.as_str()).collect();
    kinds.dedup();
    for kind in kinds {
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
    let mut kinds: Vec<&str> = outcomes.iter().map(|outcome| outcome.truth.kind.as_str()).collect();
    kinds.dedup();
    for kind in kinds {
        let seconds = Figures::of(outcomes, |outcome| outcome.truth.kind == kind).seconds();
        let (median, largest) = (seconds[seconds.len() / 2], seconds[seconds.len() - 1]);
        let _ = writeln!(text, "| {kind} | {} | {median:.1} | {largest:.1} |", seconds.len());
    }
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

/// Everything by case, for programs.
pub fn machine_readable(outcomes: &[Outcome]) -> Value {
    let cases = outcomes.iter().map(|outcome| {
        json!({
            "case": outcome.name,
            "kind": outcome.truth.kind,
            "effects": outcome.truth.effects,
            "noise": outcome.truth.noise,
            "coloured": outcome.truth.coloured,
            "strength": outcome.truth.strength,
            "verdict": outcome.diagnosis.verdict,
            "named": outcome.diagnosis.effects,
            "groups": outcome.diagnosis.groups,
            "right": outcome.score.right,
            "named_falsely": outcome.score.named_falsely,
            "intervals": {"told": outcome.score.covered.1, "hold": outcome.score.covered.0},
            "untouched_over_noise": outcome.score.untouched,
            "untouched_over_floor": outcome.score.untouched_told,
            "seconds": outcome.diagnosis.seconds,
        })
    });
    let clear = Figures::of(outcomes, is_clear);
    let figure = |(hits, trials): (f64, usize)| {
        let (low, high) = wilson::interval(hits, trials);
        json!({"hits": hits, "trials": trials, "low": low, "high": high})
    };
    json!({
        "schema": "stickslip.hidden-effects/1",
        "clear": {
            "single": figure(clear.right(Class::Single)),
            "pairs": figure(clear.right(Class::Pair)),
            "false_alarms": figure(clear.named_falsely(Class::Null)),
            "outside_unexplained": figure(clear.right(Class::Outside)),
            "outside_named": figure(clear.named_falsely(Class::Outside)),
            "intervals": figure(clear.coverage()),
            "untouched_near_floor": figure(clear.untouched_near(FLOOR)),
        },
        "cases": cases.collect::<Vec<_>>(),
    })
}
