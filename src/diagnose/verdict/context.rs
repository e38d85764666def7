//! What the answer is about, and what its parts ask of it.

use super::shared::Explanation;
use crate::contact::LawKind;
use crate::data::Dataset;
use crate::diagnose::candidates::Candidate as Form;
use crate::diagnose::evidence::{Measured, Set, Weighed};
use crate::diagnose::measurements::split::Parts;
use crate::diagnose::measurements::weighted_dataset::{RecordResiduals, Scored, WeightedDataset};
use crate::model::Model;
use crate::vocabulary as v;

/// What the answer is about.
pub(in crate::diagnose) struct Context<'a, 'd> {
    /// As given.
    pub model: &'a Model,
    pub dataset: &'a Dataset,
    pub bench: &'a WeightedDataset<'d>,
    /// The training records.
    pub data: &'a Measured<'a, 'd>,
    pub parts: &'a Parts,
    /// Whether the records are a table of few points, none of which could be spared for a test.
    pub table: bool,
}

impl Context<'_, '_> {
    /// The predictions of a set on the training records as the report measures them.
    pub(super) fn scored(&self, set: &Set) -> Vec<Scored> {
        let one = |(k, predictions): (usize, &Vec<f64>)| Scored {
            record: self.data.records[k],
            predictions: predictions.clone(),
            residuals: self.data.lane(k).residuals(predictions),
        };
        set.posterior.predictions.iter().enumerate().map(one).collect()
    }

    pub(super) fn error(&self, set: &Set) -> f64 {
        self.bench.normalised_error(&self.scored(set))
    }

    /// Whether nothing but frequencies was measured.
    pub(super) fn frequencies_alone(&self) -> bool {
        let of = |lane: &RecordResiduals| lane.channels.iter().all(|(name, _)| *name == v::FREQUENCY.name);
        self.bench.lanes.iter().all(of)
    }

    /// Whether the model as it is leaves nothing to explain, whatever the noise: a tenth of what is relevant.
    pub(super) fn is_exact(&self, weighed: &Weighed) -> bool {
        self.error(&weighed.sets[0]) < 0.1 * self.data.assumptions().relevant
    }
}

/// What is alike with the sum of its weights, in the order in which it comes first.
pub(super) fn summed<K: PartialEq>(of: impl Iterator<Item = (K, f64)>) -> Vec<(K, f64)> {
    let mut found: Vec<(K, f64)> = Vec::new();
    for (key, weight) in of {
        match found.iter_mut().find(|(known, _)| *known == key) {
            Some((_, sum)) => *sum += weight,
            None => found.push((key, weight)),
        }
    }
    found
}

impl Weighed {
    /// Ids of the effects of a set, sorted.
    pub(super) fn ids(&self, set: usize) -> Vec<&'static str> {
        let mut ids = self.ordered(set);
        ids.sort_unstable();
        ids
    }

    /// Those of the sets without a discrepancy of which the effects, sorted, are `wanted`.
    pub(super) fn of_which<'w>(
        &'w self,
        wanted: impl Fn(&[&str]) -> bool + 'w,
    ) -> impl Iterator<Item = usize> + 'w {
        (0..self.sets.len()).filter(move |k| self.sets[*k].discrepancy.is_none() && wanted(&self.ids(*k)))
    }

    /// The likeliest of those.
    pub(super) fn likeliest(&self, wanted: impl Fn(&[&str]) -> bool) -> Option<usize> {
        self.of_which(wanted).max_by(|a, b| self.within[*a].total_cmp(&self.within[*b]))
    }

    /// Their probability; that of all is 1 but for rounding.
    pub(super) fn sum(&self, wanted: impl Fn(&[&str]) -> bool) -> f64 {
        self.of_which(wanted).map(|k| self.weights[k]).sum::<f64>().min(1.0)
    }

    /// Probability of the effects of a set and nothing else, in any form.
    pub(super) fn alone(&self, set: usize) -> f64 {
        let ids = self.ids(set);
        self.sum(|of| of == ids)
    }

    /// What may be missing, each with its probability.
    pub(super) fn explanations(&self) -> Vec<Explanation> {
        summed(self.of_which(|_| true).map(|k| (self.ids(k), self.weights[k])))
    }

    pub(super) fn form(&self, member: usize) -> &Form {
        &self.candidates[member].candidate
    }

    /// The law that shows an effect of a set, where it is not the model's.
    pub(super) fn law(&self, set: usize) -> Option<&'static LawKind> {
        self.sets[set].members.iter().find_map(|member| self.form(*member).law)
    }

    /// The same in the order in which they were added.
    pub(super) fn ordered(&self, set: usize) -> Vec<&'static str> {
        self.sets[set].members.iter().map(|member| self.form(*member).effect.id).collect()
    }

    /// The empty set and the sets on the way to `best` that were fitted.
    pub(super) fn chain(&self, best: usize) -> Vec<usize> {
        let members = &self.sets[best].members;
        let prefix = |count: usize| self.sets.iter().position(|set| set.has_just(&members[..count]));
        let mut chain: Vec<usize> = (0..members.len()).filter_map(prefix).collect();
        chain.push(best);
        chain
    }
}
