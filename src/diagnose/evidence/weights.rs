//! Probabilities of sets, and the one rule that makes a verdict of them.

use super::discrepancy::Discrepancy;
use super::measured::Measured;
use super::probe::Prepared;
use super::set::{Set, evidence};

/// Below this a weight decides nothing.
const NEGLIGIBLE: f64 = 1e-4;

/// The probability of each of `sets` among them, of `candidates` that could be members: of two sets of which the larger
/// predicts the same, the smaller has both.
pub(super) fn of(data: &Measured, sets: &[Set], candidates: &[Prepared]) -> Vec<f64> {
    let scores: Vec<f64> = sets.iter().map(|set| score(set, candidates, data.assumptions().odds)).collect();
    let top = scores.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mut weights: Vec<f64> = scores.iter().map(|score| (score - top).exp()).collect();
    let sum: f64 = weights.iter().sum();
    weights.iter_mut().for_each(|w| *w /= sum);
    let deepest = sets.iter().map(Set::size).max().unwrap_or(0);
    for size in (1..=deepest).rev() {
        for k in 0..sets.len() {
            if sets[k].size() != size || weights[k] < NEGLIGIBLE || is_residual(&sets[k]) {
                continue;
            }
            let below = (0..sets.len()).filter(|j| is_one_less(&sets[*j], &sets[k]));
            let near = below
                .map(|j| (j, data.relevance(&sets[k].posterior.predictions, &sets[j].posterior.predictions)))
                .min_by(|a, b| a.1.total_cmp(&b.1));
            if let Some((j, distance)) = near
                && distance < data.assumptions().relevant
            {
                weights[j] += weights[k];
                weights[k] = 0.0;
            }
        }
    }
    weights
}

/// Log evidence with the prior of the set: each further member at the same odds, any of them alike, and so are the forms of
/// one; the discrepancy is a member like any other.
fn score(set: &Set, candidates: &[Prepared], odds: f64) -> f64 {
    let own = candidates.iter().filter(|one| one.candidate.law.is_none()).count();
    let forms = |member: usize| {
        let of = &candidates[member].candidate;
        candidates.iter().filter(|one| one.candidate.is_form_of(of)).count() as f64
    };
    let (m, size) = (own as f64 + 1.0, set.size());
    let forms: f64 = set.members.iter().map(|member| forms(*member).ln()).sum();
    let choices: f64 = (0..size).map(|i| ((m - i as f64) / (i as f64 + 1.0)).ln()).sum();
    evidence(set) + size as f64 * odds.ln() - choices - forms
}

/// Whether a set differs from that without its discrepancy by its residual alone, which has its smallest size itself.
fn is_residual(set: &Set) -> bool {
    set.discrepancy == Some(Discrepancy::Residual)
}

fn is_one_less(smaller: &Set, larger: &Set) -> bool {
    smaller.size() + 1 == larger.size()
        && (smaller.discrepancy.is_none() || larger.discrepancy.is_some())
        && smaller.members.iter().all(|member| larger.members.contains(member))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::assumptions::Assumptions;
    use crate::diagnose::evidence::Posterior;
    use crate::diagnose::evidence::samples::slider;
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;

    /// The weight of a set that is far likelier than none and moves the predictions of the first of `count` records by a
    /// `fraction` of their size.
    fn weight(count: usize, fraction: f64) -> f64 {
        let model = slider("");
        let force: Vec<f64> = (0..200).map(|i| (0.1 * f64::from(i)).sin()).collect();
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let record = |k: usize| {
            let channels = vec![
                channel("time", "s", (0..200).map(|i| 1e-3 * f64::from(i)).collect()),
                channel("displacement", "m", force.iter().map(|f| 1e-6 * f).collect()),
                channel("force", "N", force.clone()),
            ];
            Record { name: k.to_string(), regime: Regime::FromRest, use_for: None, channels }
        };
        let dataset = Dataset { title: None, records: (0..count).map(record).collect() };
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &(0..count).collect::<Vec<_>>(), &[], &[]);
        let size = data.channels[0][0].size;
        let set = |discrepancy, log_evidence, moved: f64| {
            let mut predictions = vec![force.clone(); count];
            predictions[0].iter_mut().for_each(|f| *f += moved * size);
            let (unknowns, y, deviations, correlations) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
            let (model, log_peak, simulations) = (model.clone(), log_evidence, 0);
            let posterior = Posterior {
                model,
                unknowns,
                y,
                log_evidence,
                log_peak,
                deviations,
                correlations,
                predictions,
                simulations,
            };
            Set { members: Vec::new(), discrepancy, posterior, screened: false }
        };
        let sets = [set(None, 0.0, 0.0), set(Some(Discrepancy::Force), 50.0, fraction)];
        of(&data, &sets, &[])[1]
    }

    #[test]
    fn what_matters_in_one_record_matters_beside_any_number_of_others() {
        for count in [1, 2, 8, 32] {
            assert!(weight(count, 0.011) > 0.99, "{count}");
            assert!(weight(count, 0.009) < 0.01, "{count}");
        }
    }
}
