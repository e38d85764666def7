//! Sets made from other sets: one member less, or one member in another of its forms.

use rayon::prelude::*;

use super::joint::Latent;
use super::posterior::{Start, fit, screen};
use super::probe;
use super::search::{BEHIND, Search, Set, evidence, keep};
use super::unknown::Unknown;
use super::weights;
use crate::model::Model;

/// Probability from which a set is made sure of.
const LIKELY: f64 = 0.01;

impl Search<'_, '_, '_> {
    /// Every subset of one less of the likely sets, fitted from the larger one's parameters: a smaller set that stuck
    /// would make the larger one look better than it is.
    pub(super) fn repair(&self, sets: &mut Vec<Set>) {
        for size in (1..=self.most).rev() {
            let weights = weights::of(self.data, sets, self.candidates);
            let likely = (0..sets.len()).filter(|k| sets[*k].size() == size && weights[*k] > LIKELY);
            let wanted: Vec<(usize, usize)> =
                likely.flat_map(|k| (0..size).map(move |place| (k, place))).collect();
            let found: Vec<Set> = wanted
                .par_iter()
                .filter_map(|(k, place)| self.without(&sets[0], &sets[*k], *place))
                .collect();
            found.into_iter().for_each(|set| keep(sets, set));
        }
    }

    /// `set` without the member in a place, fitted from where it is; `empty` has no member.
    fn without(&self, empty: &Set, set: &Set, place: usize) -> Option<Set> {
        let (members, model, unknowns, y) = self.replaced(empty, set, place, None);
        let start = Start { model: &model, unknowns: &unknowns, y: &y };
        let posterior = fit(self.data, &start, &Latent::default(), None).ok()?;
        Some(Set { members, discrepancy: None, posterior, screened: false })
    }

    /// Adds the best set of a size in all forms that its members have.
    pub(super) fn in_other_forms(&self, sets: &mut Vec<Set>, size: usize) {
        let fitted = sets.iter().filter(|set| set.members.len() == size && !set.screened);
        let Some(best) = fitted.max_by(|a, b| evidence(a).total_cmp(&evidence(b))) else { return };
        let forms = |(place, member): (usize, &usize)| {
            let member = *member;
            let others =
                (0..self.candidates.len()).filter(move |m| *m != member && self.are_forms(*m, member));
            others.map(move |other| (place, other))
        };
        let wanted: Vec<(usize, usize)> = best.members.iter().enumerate().flat_map(forms).collect();
        let other = |(place, other): &(usize, usize)| self.in_another_form(&sets[0], best, *place, *other);
        let found: Vec<Set> = wanted.par_iter().filter_map(other).collect();
        found.into_iter().for_each(|set| keep(sets, set));
    }

    /// `set` with candidate `other` in the place of a member, from the best of its starts.
    fn in_another_form(&self, empty: &Set, set: &Set, place: usize, other: usize) -> Option<Set> {
        let looked = |y: &Vec<f64>| {
            let (members, model, unknowns, y) = self.replaced(empty, set, place, Some((other, y)));
            model.check().ok()?;
            let start = Start { model: &model, unknowns: &unknowns, y: &y };
            let posterior = screen(self.looks.unwrap_or(self.data), &start, false).ok()?;
            Some(Set { members, discrepancy: None, posterior, screened: true })
        };
        let starts = probe::places(&self.candidates[other]);
        let seen = starts.iter().filter_map(looked);
        let mut best = seen.max_by(|a, b| evidence(a).total_cmp(&evidence(b)))?;
        Self::screened(self.looks.unwrap_or(self.data), &mut best);
        // First looks of another kind are not to be compared with a fit.
        if self.looks.is_some() || evidence(&best) > evidence(set) - BEHIND {
            self.finish(&mut best);
        }
        Some(best).filter(|set| !set.screened)
    }

    /// A hypothesis like `set`, whose member in a place is left out, or replaced by another candidate at coordinates: its
    /// members, its model, and its unknowns with where they are.
    fn replaced(
        &self,
        empty: &Set,
        set: &Set,
        place: usize,
        by: Option<(usize, &Vec<f64>)>,
    ) -> (Vec<usize>, Model, Vec<Unknown>, Vec<f64>) {
        let of = |owner: Option<usize>| {
            let pairs = set.posterior.unknowns.iter().zip(&set.posterior.y);
            pairs.filter(move |(unknown, _)| unknown.owner == owner)
        };
        let (mut unknowns, mut y): (Vec<Unknown>, Vec<f64>) = of(None).map(|(u, y)| (u.clone(), *y)).unzip();
        let (mut members, mut model) = (Vec::new(), empty.posterior.model.clone());
        for (k, &member) in set.members.iter().enumerate() {
            let own = || of(Some(member)).map(|(_, y)| *y).collect::<Vec<f64>>();
            let (member, at) = match by {
                None if k == place => continue,
                Some((other, at)) if k == place => (other, at.clone()),
                _ => (member, own()),
            };
            model = self.candidates[member].added_to(&model, &at);
            unknowns.extend(self.candidates[member].unknowns(&model, member));
            y.extend(at);
            members.push(member);
        }
        (members, model, unknowns, y)
    }
}
