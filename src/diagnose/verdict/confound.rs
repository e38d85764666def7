//! Effects that look similar in the data, and the experiment that distinguishes them.

use crate::diagnose::diagnosis::Group;
use crate::effects;

/// Correlation (1) of two effects from which on data cannot tell them apart; words and pages alone use it, no verdict does.
pub const ALIKE: f64 = 0.9;

/// What separates two effects: the experiment made for the pair, or the one that shows `second` apart from others.
fn separates(first: &str, second: &str) -> &'static str {
    let (Some(first), Some(second)) = (effects::find(first), effects::find(second)) else { return "" };
    first.confusion(second).map_or(second.next_experiment, |pair| pair.experiment)
}

/// The experiment that separates `effects`.
fn experiment(effects: &[&str]) -> String {
    let mut sentences: Vec<&str> = Vec::new();
    for (index, first) in effects.iter().enumerate() {
        for second in &effects[..index] {
            let sentence = separates(first, second);
            if !sentences.contains(&sentence) {
                sentences.push(sentence);
            }
        }
    }
    let mut text = sentences.join("; ");
    if let Some(first) = text.get(..1) {
        let upper = first.to_uppercase();
        text.replace_range(..1, &upper);
    }
    text
}

/// A group of effects that share the probability, best first.
pub(super) fn group(effects: Vec<&'static str>, probability: f64) -> Group {
    let experiment = experiment(&effects);
    let reason = format!(
        "one of these is missing with a probability of {probability:.2}, and none of them alone reaches that of a \
         finding: {}",
        effects.join(", ")
    );
    Group { effects, reason, experiment }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::CATALOGUE;

    #[test]
    fn either_order_of_a_pair_finds_its_experiment() {
        for one in CATALOGUE {
            for pair in one.confused_with {
                let (a, b) = (one.id, pair.with.id);
                assert_eq!(experiment(&[a, b]), experiment(&[b, a]));
                assert_eq!(experiment(&[a, b]).to_lowercase(), pair.experiment.to_lowercase());
            }
        }
    }

    #[test]
    fn every_pair_has_an_experiment() {
        for first in CATALOGUE {
            for second in CATALOGUE {
                assert!(first == second || experiment(&[first.id, second.id]).len() > 20);
            }
        }
    }
}
