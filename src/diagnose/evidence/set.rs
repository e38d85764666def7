//! A hypothesis, and lists of them.

use super::discrepancy::Discrepancy;
use super::posterior::Posterior;

/// A hypothesis.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Set {
    /// Indices of the candidates, in the order of the model's effects.
    pub members: Vec<usize>,
    /// Its discrepancy.
    pub discrepancy: Option<Discrepancy>,
    pub posterior: Posterior,
    /// Whether it was only looked at.
    pub screened: bool,
}

impl Set {
    /// Members, the discrepancy one of them.
    pub fn size(&self) -> usize {
        self.members.len() + usize::from(self.discrepancy.is_some())
    }

    /// Whether it is `set` as that stands, with a discrepancy or without.
    pub fn is_of(&self, set: &Set) -> bool {
        self.members == set.members && self.posterior.y == set.posterior.y
    }

    /// Whether it has these members, in any order, and no discrepancy.
    pub fn has_just(&self, members: &[usize]) -> bool {
        self.discrepancy.is_none()
            && self.members.len() == members.len()
            && members.iter().all(|m| self.members.contains(m))
    }
}

/// Those of `sets` with so many members, the likeliest first.
pub(super) fn of_size(sets: &[Set], size: usize) -> Vec<usize> {
    let mut found: Vec<usize> = (0..sets.len()).filter(|k| sets[*k].members.len() == size).collect();
    found.sort_by(|a, b| evidence(&sets[*b]).total_cmp(&evidence(&sets[*a])));
    found
}

/// Adds `set`, or puts it in the place of one of the same members that was only looked at, or is less likely: what a look
/// promises is no evidence against a whole fit.
pub(super) fn keep(sets: &mut Vec<Set>, set: Set) {
    let order = |a: &Set, b: &Set| b.screened.cmp(&a.screened).then(evidence(a).total_cmp(&evidence(b)));
    match sets.iter_mut().find(|known| known.has_just(&set.members)) {
        Some(known) if order(known, &set).is_lt() => *known = set,
        Some(_) => {}
        None => sets.push(set),
    }
}

pub(super) fn rank(sets: &mut [Set]) {
    sets.sort_by(|a, b| evidence(b).total_cmp(&evidence(a)));
}

/// The likeliest of those that have the same members, in the order of their evidence.
pub(super) fn best_of_each(sets: impl Iterator<Item = Set>) -> Vec<Set> {
    let mut found = Vec::new();
    sets.for_each(|set| keep(&mut found, set));
    rank(&mut found);
    found
}

pub(in crate::diagnose) fn evidence(set: &Set) -> f64 {
    set.posterior.log_evidence
}
