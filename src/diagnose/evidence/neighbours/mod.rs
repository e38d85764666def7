//! Sets made from other sets: with a discrepancy, one member less, one member in another of its forms or another candidate in
//! its place, or looked at again from a part that fits better.

use rayon::prelude::*;

use super::discrepancy::{self, Discrepancy};
use super::looks::{moved, promising};
use super::posterior::{LOOK, Posterior, Start, fit, screen};
use super::probe::{Probed, SIZES};
use super::search::{BEHIND, PARENTS, Search, TWICE};
use super::set::{Set, best_of_each, evidence, keep, of_size, rank};
use super::unknown::Unknown;
use super::weights;
use crate::model::Model;

/// Probability from which a set is made sure of.
const LIKELY: f64 = 0.01;

/// By how much (in nats) a smaller set fits better than a larger one that stuck.
const STUCK: f64 = 0.5;
/// Fraction of what an effect was that is next to nothing.
const NEXT_TO_NOTHING: f64 = 0.01;

fn peak(set: &Set) -> f64 {
    set.posterior.log_peak
}

/// Of the sets of one member less that fit better than set `k` the one that fits best; both fitted in full.
fn best_within(sets: &[Set], k: usize) -> Option<usize> {
    let larger = &sets[k];
    let within = |j: &usize| {
        let smaller = &sets[*j];
        let part = smaller.members.iter().all(|member| larger.members.contains(member));
        let one_less = part && smaller.members.len() + 1 == larger.members.len();
        one_less && !smaller.screened && peak(smaller) > peak(larger) + STUCK
    };
    let better = (0..sets.len()).filter(within).filter(|_| !larger.screened);
    better.max_by(|a, b| peak(&sets[*a]).total_cmp(&peak(&sets[*b])))
}

/// Whether `set` without its last member was far likelier than with `other` in a place besides.
fn is_behind(sets: &[Set], set: &Set, place: usize, other: usize) -> bool {
    let Some((_, before)) = set.members.split_last().filter(|(_, before)| place < before.len()) else {
        return false;
    };
    let mut replaced = before.to_vec();
    replaced[place] = other;
    let of = |members: &[usize]| sets.iter().find(|set| !set.screened && set.has_just(members)).map(evidence);
    of(before).zip(of(&replaced)).is_some_and(|(before, replaced)| replaced < before - BEHIND)
}

/// Whether a whole fit from where a look at `set` ended may make it likely: it is not far behind the best of `sets`, or half as
/// far as what is known of its members, or nothing is known of these.
fn may_be_likely(set: &Set, sets: &[Set]) -> bool {
    let best = sets.iter().map(evidence).fold(f64::NEG_INFINITY, f64::max);
    let known = sets.iter().find(|known| known.has_just(&set.members) && !known.screened);
    let halfway = known.map_or(f64::NEG_INFINITY, |known| 0.5 * (evidence(known) + best));
    evidence(set) > halfway.min(best - BEHIND)
}

impl Search<'_, '_, '_> {
    /// Adds the likely sets with a discrepancy, those of `known` as they are where their sets did not change; in full
    /// where to first order they are neither far behind nor far before the best.
    pub(super) fn doubt(&self, sets: &mut Vec<Set>, known: Vec<Set>) {
        let mut order: Vec<usize> = (0..sets.len()).filter(|k| !sets[*k].screened).collect();
        order.sort_by(|a, b| evidence(&sets[*b]).total_cmp(&evidence(&sets[*a])));
        order.truncate(PARENTS);
        if !order.contains(&0) {
            order.push(0);
        }
        let best = order.iter().map(|k| evidence(&sets[*k])).fold(f64::NEG_INFINITY, f64::max);
        let doubted = |k: &usize| {
            let set = &sets[*k];
            let mut with =
                known.iter().find(|with| with.is_of(set)).cloned().or_else(|| self.doubted(set))?;
            let force = with.discrepancy == Some(Discrepancy::Force);
            if force && (evidence(&with) - best).abs() < BEHIND {
                self.doubt_in_full(set, &mut with);
            }
            let without = (evidence(&with) > best - BEHIND).then(|| self.refitted_from(set, &with)).flatten();
            Some((*k, with, without))
        };
        let found: Vec<(usize, Set, Option<Posterior>)> = order.par_iter().filter_map(doubted).collect();
        for (k, with, without) in found {
            sets.push(with);
            without.into_iter().for_each(|better| sets[k].posterior = better);
        }
    }

    /// The fit of `set` from where a likelier one with a discrepancy is, if it is better there. A discrepancy that was weighed
    /// to first order alone is where the set is.
    fn refitted_from(&self, set: &Set, with: &Set) -> Option<Posterior> {
        if evidence(with) <= evidence(set) || with.posterior.y == set.posterior.y {
            return None;
        }
        let found = super::again(self.data, &with.posterior).ok()?;
        (found.log_evidence > evidence(set)).then_some(found)
    }

    /// Fits `with`, which is `set` with a discrepancy to first order.
    fn doubt_in_full(&self, set: &Set, with: &mut Set) {
        let Ok(doubt) = discrepancy::about(self.data, &set.posterior) else { return };
        let Posterior { model, unknowns, .. } = &set.posterior;
        let start = Start { model, unknowns, y: &doubt.y };
        match fit(self.data, &start, &doubt.latent, Some(&doubt.priors)) {
            Ok(whole) if whole.log_evidence > doubt.log_evidence => with.posterior = whole,
            _ => {}
        }
    }

    /// Every subset of one less of the likely sets, looked at from the larger one's parameters, and fitted from there where it
    /// may be likely: a smaller set that stuck would make the larger one look better than it is. Those far behind one of the
    /// `doubts` that matters are passed over: a set is told with no probability then, and its subsets lack no less.
    pub(super) fn repair(&self, sets: &mut Vec<Set>, doubts: &[Set]) {
        let doubts = doubts.iter().filter(|doubt| self.matters(doubt, sets));
        let least = doubts.map(evidence).fold(f64::NEG_INFINITY, f64::max) - BEHIND;
        for size in (1..=self.most).rev() {
            let weights = weights::of(self.data, sets, self.candidates);
            let is_likely = |k: usize| weights[k] > LIKELY && evidence(&sets[k]) > least;
            let likely = (0..sets.len()).filter(|k| sets[*k].size() == size && is_likely(*k));
            let wanted: Vec<(usize, usize)> =
                likely.flat_map(|k| (0..size).map(move |place| (k, place))).collect();
            let without = |(k, place): &(usize, usize)| self.without(&sets[0], &sets[*k], *place);
            let mut found: Vec<Set> = wanted.par_iter().filter_map(without).collect();
            found.retain(|set| may_be_likely(set, sets));
            found.par_iter_mut().for_each(|set| self.finish(set));
            found.into_iter().filter(|set| !set.screened).for_each(|set| keep(sets, set));
        }
    }

    /// Whether the discrepancy of `doubt` matters beside its set among `sets`.
    fn matters(&self, doubt: &Set, sets: &[Set]) -> bool {
        let without = sets.iter().find(|set| set.has_just(&doubt.members));
        doubt.discrepancy.zip(without).is_some_and(|(kind, without)| {
            kind.matters(self.data, &doubt.posterior.predictions, &without.posterior.predictions)
        })
    }

    /// Looks again at those that fit worse than a set of one member less, from there: what the smaller can the larger can, too.
    /// Those that may be the best then are fitted in full; others stay as they are.
    pub(super) fn nest(&self, sets: &mut [Set]) {
        for size in 1..=self.most {
            let larger = (0..sets.len()).filter(|k| sets[*k].members.len() == size);
            let worse = |k: usize| Some((k, best_within(sets, k)?));
            let wanted: Vec<(usize, usize)> = larger.filter_map(worse).collect();
            let again = wanted.par_iter().filter_map(|(k, j)| self.looked_at_from(&sets[*j], &sets[*k]));
            for set in self.likely_of(again.collect(), sets) {
                if let Some(known) = sets.iter_mut().find(|known| known.has_just(&set.members))
                    && peak(&set) > peak(known)
                {
                    *known = set;
                }
            }
        }
    }

    /// Fits those that were only looked at and promise not far less than the best.
    pub(super) fn make_sure(&self, sets: &mut [Set]) {
        let mut tried = vec![false; sets.len()];
        loop {
            let best =
                sets.iter().filter(|set| !set.screened).map(evidence).fold(f64::NEG_INFINITY, f64::max);
            let open = |k: &usize| sets[*k].screened && !tried[*k] && evidence(&sets[*k]) > best - BEHIND;
            let order = |a: &usize, b: &usize| evidence(&sets[*a]).total_cmp(&evidence(&sets[*b]));
            let Some(next) = (0..sets.len()).filter(open).max_by(order) else { break };
            tried[next] = true;
            self.finish(&mut sets[next]);
        }
    }

    /// Those of `found` that may be the likeliest of them and of `sets`, fitted in full.
    fn likely_of(&self, mut found: Vec<Set>, sets: &[Set]) -> Vec<Set> {
        rank(&mut found);
        self.finish_best(&mut found, sets, true);
        found.retain(|set| !set.screened);
        found
    }

    /// The members of `larger` looked at from `smaller`, with what that lacks as it was and with next to nothing of it.
    fn looked_at_from(&self, smaller: &Set, larger: &Set) -> Option<Set> {
        let member = *larger.members.iter().find(|member| !smaller.members.contains(member))?;
        let pairs = larger.posterior.unknowns.iter().zip(&larger.posterior.y);
        let own: Vec<f64> = pairs.filter(|(u, _)| u.owner == Some(member)).map(|(_, y)| *y).collect();
        let first = &self.candidates[member].coordinates[0];
        let (low, high) = first.bounds();
        let looked = |fraction: f64| {
            let mut own = own.clone();
            own[0] = first.times(own[0], fraction).clamp(low, high);
            let (model, unknowns, y) = self.extended(&smaller.posterior, member, &own);
            screen(self.data, &Start { model: &model, unknowns: &unknowns, y: &y }, LOOK).ok()
        };
        let looks = [1.0, NEXT_TO_NOTHING].into_iter().filter_map(looked);
        let posterior = looks.max_by(|a, b| a.log_peak.total_cmp(&b.log_peak))?;
        let members = smaller.members.iter().copied().chain([member]).collect();
        Some(Set { members, discrepancy: None, posterior, screened: true })
    }

    /// `set` without the member in a place, looked at from where it is; `empty` has no member.
    fn without(&self, empty: &Set, set: &Set, place: usize) -> Option<Set> {
        let (members, model, unknowns, y) = self.remainder(empty, set, place);
        let start = Start { model: &model, unknowns: &unknowns, y: &y };
        let posterior = screen(self.data, &start, LOOK).ok()?;
        Some(Set { members, discrepancy: None, posterior, screened: true })
    }

    /// The sets of a size that are tried in other forms: the likeliest and, unless that `alone` is wanted, the one of other effects
    /// that leaves the smallest residual.
    pub(super) fn to_be_reformed(&self, sets: &[Set], size: usize, alone: bool) -> Vec<usize> {
        let mut fitted: Vec<usize> = of_size(sets, size).into_iter().filter(|k| !sets[*k].screened).collect();
        self.different(sets, &mut fitted);
        let closest = if alone { None } else { self.closest(fitted.iter().map(|k| (*k, &sets[*k]))) };
        fitted.truncate(1);
        fitted.extend(closest);
        fitted
    }

    /// Single effects of other forms than those that are known: none of them alone shows how another would fit.
    pub(super) fn never_reformed(&self, sets: &[Set]) -> Vec<usize> {
        let is_known = |form: usize| sets.iter().any(|set| set.has_just(&[form]));
        let other = |a: usize, b: usize| a != b && self.are_forms(a, b);
        let never = |k: &usize| {
            let member = sets[*k].members[0];
            let mut others = (0..self.candidates.len()).filter(|form| other(*form, member)).peekable();
            others.peek().is_some() && others.all(|form| !is_known(form))
        };
        of_size(sets, 1).into_iter().filter(never).collect()
    }

    /// Adds set `k` in all forms that its members have and that may be the likeliest; where all was `adequate` before its last
    /// member, without those that were far behind without that, if motions are solved for.
    pub(super) fn in_other_forms(&self, sets: &mut Vec<Set>, k: usize, adequate: bool) {
        let (parent, settled) = (&sets[k].clone(), adequate && self.looks.is_some());
        let open = |place: usize, other: usize| !settled || !is_behind(sets, parent, place, other);
        let forms = |(place, member): (usize, &usize)| {
            let is_other = |m: &usize| m != member && self.are_forms(*m, *member) && open(place, *m);
            let others: Vec<usize> = (0..self.candidates.len()).filter(is_other).collect();
            self.in_forms(&sets[0], parent, place, &others)
        };
        let mut found: Vec<Set> = parent.members.iter().enumerate().flat_map(forms).collect();
        if parent.members.len() == 1 && self.looks.is_some() {
            // One effect alone is what is likeliest: no form of it is passed over for a look that stuck.
            found.par_iter_mut().for_each(|set| self.finish(set));
            found.retain(|set| !set.screened);
        } else {
            found = self.likely_of(found, sets);
        }
        found.into_iter().for_each(|set| keep(sets, set));
    }

    /// Adds sets like `best`, which lacks something, with another candidate in the place of a member each, from where `best` is:
    /// what explains a part leads to where a fit of another that explains all would not come by itself.
    /// Gives whether one of them is likelier.
    pub(super) fn in_exchange(&self, sets: &mut Vec<Set>, best: usize) -> bool {
        self.in_exchange_of(sets, best, false, |_| true)
    }

    /// Adds the same of `best`, which lacks nothing, in the place of members that bring several numbers: what brings fewer may
    /// explain as much.
    pub(super) fn in_simpler_exchange(&self, sets: &mut Vec<Set>, best: usize) {
        self.in_exchange_of(sets, best, true, |member| self.candidates[member].coordinates.len() > 1);
    }

    /// The same in the place of those members that are `wanted`; where `best` is `adequate` those that may be the likeliest alone.
    fn in_exchange_of(
        &self,
        sets: &mut Vec<Set>,
        best: usize,
        adequate: bool,
        wanted: impl Fn(usize) -> bool,
    ) -> bool {
        let before = evidence(&sets[best]);
        let exchanged = |place: usize| self.exchanged(&sets[0], &sets[best], place);
        let members = &sets[best].members;
        let places = (0..members.len()).filter(|place| wanted(members[*place]));
        let mut found: Vec<Set> = places.flat_map(exchanged).collect();
        rank(&mut found);
        self.finish_best(&mut found, sets, adequate);
        found.retain(|set| !set.screened);
        let likelier = found.iter().any(|set| evidence(set) > before);
        found.into_iter().for_each(|set| keep(sets, set));
        likelier
    }

    /// Looks at the most promising candidates in the place of a member of `set`.
    fn exchanged(&self, empty: &Set, set: &Set, place: usize) -> Vec<Set> {
        let Some(parent) = self.left_as_it_was(empty, set, place) else { return Vec::new() };
        let looks = self.looks.unwrap_or(self.data);
        let glanced = self.glances(looks, &parent, &self.beside(set), TWICE);
        self.looked_at_best(best_of_each(glanced.into_iter())).0
    }

    /// Looks at other `forms` of a member of `set` in its place, each from the best of the starts that lines promise most of.
    fn in_forms(&self, empty: &Set, set: &Set, place: usize, forms: &[usize]) -> Vec<Set> {
        if forms.is_empty() {
            return Vec::new();
        }
        let Some(parent) = self.left_as_it_was(empty, set, place) else { return Vec::new() };
        let looks = self.looks.unwrap_or(self.data);
        let Probed { probes, tangents } = self.probed(looks, &parent, forms, SIZES);
        let starts = promising(probes);
        let glanced = |probe| self.glanced(looks, &parent, tangents.as_ref(), probe);
        let mut found = best_of_each(starts.par_iter().filter_map(glanced).collect::<Vec<_>>().into_iter());
        found.par_iter_mut().for_each(|set| Self::screened(looks, set));
        // First looks of another kind are not to be compared with a fit.
        found.retain_mut(|set| self.looks.is_none() || moved(self.data, set));
        found
    }

    /// `set` without the member in a place, all other numbers as they are; what it predicted with that stays beside them.
    fn left_as_it_was(&self, empty: &Set, set: &Set, place: usize) -> Option<Set> {
        let (members, mut model, unknowns, y) = self.remainder(empty, set, place);
        let value = |(unknown, y): (&Unknown, &f64)| (unknown.path.clone(), unknown.coordinate.value(*y));
        let values: Vec<(String, f64)> = unknowns.iter().zip(&y).map(value).collect();
        let values: Vec<(&str, f64)> = values.iter().map(|(path, value)| (path.as_str(), *value)).collect();
        model.set_all(&values).ok()?;
        let posterior = Posterior { model, unknowns, y, ..set.posterior.clone() };
        Some(Set { members, discrepancy: None, posterior, screened: true })
    }

    /// A hypothesis like `set` without its member in a place: its members, its model, and its unknowns with where they are.
    fn remainder(&self, empty: &Set, set: &Set, place: usize) -> (Vec<usize>, Model, Vec<Unknown>, Vec<f64>) {
        let of = |owner: Option<usize>| {
            let pairs = set.posterior.unknowns.iter().zip(&set.posterior.y);
            pairs.filter(move |(unknown, _)| unknown.owner == owner)
        };
        let (mut unknowns, mut y): (Vec<Unknown>, Vec<f64>) = of(None).map(|(u, y)| (u.clone(), *y)).unzip();
        let (mut members, mut model) = (set.members.clone(), empty.posterior.model.clone());
        members.remove(place);
        for &member in &members {
            let own: Vec<f64> = of(Some(member)).map(|(_, y)| *y).collect();
            model = self.candidates[member].added_to(&model, &own);
            unknowns.extend(self.candidates[member].unknowns(&model, member));
            y.extend(own);
        }
        (members, model, unknowns, y)
    }
}

#[cfg(test)]
mod tests;
