//! What came out, for programs.

use serde_json::{Value, json};

use crate::scoring::figures::{FLOOR, Figures, is_clear};
use crate::scoring::run::Outcome;
use crate::scoring::truth::Class;
use crate::scoring::wilson;

/// Everything by case, for programs.
pub fn readable(outcomes: &[Outcome]) -> Value {
    let cases = outcomes.iter().map(|outcome| {
        json!({
            "case": outcome.name,
            "kind": outcome.truth.kind,
            "effects": outcome.truth.effects,
            "noise": outcome.truth.noise,
            "coloured": outcome.truth.coloured,
            "strength": outcome.truth.strength,
            "question": outcome.truth.question,
            "verdict": outcome.diagnosis.verdict,
            "probability": outcome.diagnosis.probability,
            "exit": outcome.exit,
            "named": outcome.diagnosis.effects,
            "groups": outcome.diagnosis.groups,
            "law": outcome.diagnosis.law,
            "right": outcome.score.right,
            "named_falsely": outcome.score.named_falsely,
            "intervals": outcome.score.covered.iter().map(|(name, holds)| json!({"parameter": name, "holds": holds}))
                .collect::<Vec<_>>(),
            "test_error_over_noise": outcome.score.test_error_over_noise,
            "test_error_over_floor": outcome.score.test_error_over_floor,
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
            "test_error_near_floor": figure(clear.test_error_near(FLOOR)),
        },
        "cases": cases.collect::<Vec<_>>(),
    })
}
