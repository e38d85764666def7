//! The sections of how far what is told with confidence can be trusted: probabilities and intervals.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::scoring::figures::told;
use crate::scoring::run::Outcome;
use crate::scoring::score::Claim;
use crate::scoring::table;

/// Probability from which a verdict counts as certain.
const CERTAIN: f64 = 0.95;
/// Lower ends of the bins.
const BINS: [f64; 6] = [0.0, 0.5, 0.8, 0.95, 0.99, 0.999];

/// What was told with a probability, and whether it is true. A group is true that holds what is hidden.
fn told_and_true(outcomes: &[Outcome]) -> Vec<(f64, bool)> {
    let claims = outcomes.iter().filter(|outcome| outcome.diagnosis.claim() != Claim::None);
    claims.filter_map(|one| Some((one.diagnosis.probability?, one.score.right >= 0.5))).collect()
}

/// Probabilities told against the share of what is true.
pub fn probabilities(text: &mut String, outcomes: &[Outcome]) {
    let told_and_true = told_and_true(outcomes);
    if told_and_true.is_empty() {
        return;
    }
    let hits = |low: f64, high: f64| {
        let inside = told_and_true.iter().filter(|(told, _)| (low..high).contains(told));
        inside.fold((0.0, 0, 0.0), |(hits, count, sum), (told, is_true)| {
            (hits + f64::from(*is_true), count + 1, sum + told)
        })
    };
    let (certain, count, _) = hits(CERTAIN, f64::INFINITY);
    let _ = write!(
        text,
        "\n## Calibration\n\nOf all cases in which something is claimed. Claimed with a probability of at least {CERTAIN}: {} \
         true; goal ≥ 95 %.\n\n| probability told | mean of it | true |\n|---|---:|---|\n",
        told((certain, count))
    );
    for (index, low) in BINS.into_iter().enumerate() {
        let high = BINS.get(index + 1).copied();
        let (hits, count, sum) = hits(low, high.unwrap_or(f64::INFINITY));
        if count > 0 {
            let (mean, high) = (sum / count as f64, high.unwrap_or(1.0));
            let _ = writeln!(text, "| {low} … {high} | {mean:.4} | {} |", told((hits, count)));
        }
    }
}

/// Intervals told that hold the true value, by kind and noise and by parameter.
pub fn intervals(text: &mut String, outcomes: &[Outcome]) {
    let mut by_noise: BTreeMap<u64, Row> = BTreeMap::new();
    let mut by_parameter: BTreeMap<&str, Row> = BTreeMap::new();
    let kinds = table::kinds(outcomes);
    for outcome in outcomes {
        for (name, holds) in &outcome.score.covered {
            // Noise in hundredths of a percent.
            let noise = (outcome.truth.noise * 1e4).round() as u64;
            by_noise.entry(noise).or_default().add(&outcome.truth.kind, *holds);
            by_parameter.entry(name).or_default().add(&outcome.truth.kind, *holds);
        }
    }
    if by_noise.is_empty() {
        return;
    }
    let columns = |row: &Row| kinds.iter().map(|kind| row.told(kind)).collect::<Vec<_>>().join(" | ");
    let heads = format!("{} |\n|---|{}\n", kinds.join(" | "), "---|".repeat(kinds.len()));
    let _ = write!(text, "\n## Coverage of the 95 % intervals\n\nGoal: 90 … 99 %.\n\n| noise | {heads}");
    for (noise, row) in &by_noise {
        let _ = writeln!(text, "| {} % | {} |", *noise as f64 / 100.0, columns(row));
    }
    let _ = write!(text, "\n| parameter | {heads}");
    for (name, row) in &by_parameter {
        let _ = writeln!(text, "| {name} | {} |", columns(row));
    }
}

/// Intervals that hold the truth, and how many there are, by kind.
#[derive(Default)]
struct Row(BTreeMap<String, (f64, usize)>);

impl Row {
    fn add(&mut self, kind: &str, holds: bool) {
        let (hits, count) = self.0.entry(kind.to_owned()).or_default();
        *hits += f64::from(holds);
        *count += 1;
    }

    fn told(&self, kind: &str) -> String {
        self.0.get(kind).map_or("–".to_owned(), |figures| told(*figures))
    }
}
