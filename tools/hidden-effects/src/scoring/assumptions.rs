//! What each number that a diagnosis takes for granted does to its verdicts: halved, doubled.

use std::fmt::Write;
use std::fs;

use serde_json::Value;

use crate::scoring::run::{self, Outcome, Plan, Task};

/// Runs `tasks` as they are and with each assumption of the program halved and doubled; the table in Markdown.
///
/// # Errors
/// As [`run::run`]; answers that do not tell what was taken for granted.
pub fn markdown(plan: &Plan, tasks: &[Task], command: &str) -> Result<String, String> {
    let usual = run::run(plan, tasks)?;
    let assumed = assumptions(plan, tasks)?;
    let mut page = format!(
        "# What the diagnosis takes for granted\n\nEach number that influences a verdict (`stickslip::diagnose::Assumptions` \
         gives its reason), halved and doubled, on the same\n{} cases: how many are right, and in how many the verdict is \
         another. `certain` is not halved or doubled itself, its distance\nfrom 1 is. Command:\n\n```sh\n{command}\n```\n\n\
         As they are, {} are right.\n\n| assumption | value | right at half | other verdicts | right at double | other verdicts \
         |\n|---|---:|---:|---:|---:|---:|\n",
        tasks.len(),
        right(&usual)
    );
    for (name, value) in &assumed {
        let _ = write!(page, "| `{name}` | {value} |");
        for factor in [0.5, 2.0] {
            let changed = match name.as_str() {
                "certain" => 1.0 - factor * (1.0 - value),
                _ => factor * value,
            };
            let word = format!("{name}={changed}");
            let varied = Plan { results: plan.results.join(&word), assume: Some(word), ..plan.clone() };
            let outcomes = run::run(&varied, tasks)?;
            let _ = write!(page, " {} | {} |", right(&outcomes), others(&usual, &outcomes));
        }
        page.push('\n');
    }
    Ok(page)
}

fn right(outcomes: &[Outcome]) -> f64 {
    outcomes.iter().map(|outcome| outcome.score.right).sum()
}

fn others(usual: &[Outcome], varied: &[Outcome]) -> usize {
    usual.iter().zip(varied).filter(|(a, b)| a.diagnosis.label() != b.diagnosis.label()).count()
}

/// What the program says that it takes for granted, from the answers kept.
fn assumptions(plan: &Plan, tasks: &[Task]) -> Result<Vec<(String, f64)>, String> {
    let told = |task: &Task| {
        let text = fs::read_to_string(plan.results.join(format!("{}.json", task.name))).ok()?;
        let answer: Value = serde_json::from_str(&text).ok()?;
        let all = answer.pointer("/diagnosis/settings/assumptions")?.as_object()?;
        all.iter().map(|(name, value)| Some((name.clone(), value.as_f64()?))).collect()
    };
    tasks.iter().find_map(told).ok_or_else(|| "no answer tells what it takes for granted".to_owned())
}
