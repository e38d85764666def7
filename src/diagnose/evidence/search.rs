//! Sets of effects, from none upwards: each fitted from those below it, the best in full.

use rayon::prelude::*;

use super::discrepancy::{self, Discrepancy};
use super::measured::Measured;
use super::posterior::Posterior;
use super::probe::{self, Prepared, Probed};
use super::set::{Set, best_of_each, evidence, of_size};
use super::unknown::Unknown;
use crate::model::Model;

/// Behind the best by how much (in nats) a set is not worth a whole fit.
pub(super) const BEHIND: f64 = 20.0;
/// At most so many sets of a size, single effects about measured motions, or candidates in the place of a member are looked at
/// twice (of sets of one member all, where motions are solved for and none of these lacks nothing); so many are fitted in full
/// besides the one of the smallest residual; and larger ones are made from so many (`looks::pairs`: those of two from more).
pub(super) const TWICE: usize = 8;
const FULL: usize = 5;
pub(super) const PARENTS: usize = 2;
/// Fraction of a residual that leads where it is not of the likeliest.
pub(super) const CLOSER: f64 = 0.95;
/// Members from which on a search may end for what they leave beyond the noise: over this part of the square of what the model
/// leaves without.
const SEVERAL: usize = 2;
const HOPELESS: f64 = 0.5;
/// Part of the square of a residual beyond a noise that is known over which a search goes on, whatever it looks like: all but a
/// tenth, which is over three times the noise.
const MOST: f64 = 0.9;

/// What is searched.
pub(in crate::diagnose) struct Search<'s, 'a, 'd> {
    pub data: &'s Measured<'a, 'd>,
    /// The same for first looks: where motions are solved for, with predictions to first order about the measured ones.
    pub looks: Option<&'s Measured<'a, 'd>>,
    /// Beginnings of the same records, the shortest first, where those are long.
    pub beginnings: &'s [Measured<'a, 'd>],
    pub candidates: &'s [Prepared],
    pub most: usize,
    pub report: &'s (dyn Fn(&str) + Sync),
}

impl Search<'_, '_, '_> {
    /// All sets that were fitted, the empty one `base` first.
    pub fn run(&self, base: Posterior) -> Vec<Set> {
        let mut sets = vec![Set { members: Vec::new(), discrepancy: None, posterior: base, screened: false }];
        let mut doubts: Vec<Set> = Vec::new();
        let (mut stalled, mut adequate) = (false, false);
        for size in 0..=self.most {
            let Some((doubt, lacks_nothing)) = self.arrived(&mut sets, size) else { break };
            adequate = lacks_nothing;
            doubts.extend(doubt);
            if size == self.most || !adequate && self.is_hopeless(&sets, size) {
                break;
            }
            let mut parents = of_size(&sets, size);
            self.different(&sets, &mut parents);
            let closest = self.closest(parents.iter().map(|k| (*k, &sets[*k])));
            parents.truncate(if adequate || size >= SEVERAL { 1 } else { PARENTS });
            parents.extend(closest.filter(|k| !adequate && !parents.contains(k)));
            let before = sets.iter().map(evidence).fold(f64::NEG_INFINITY, f64::max);
            let found = self.grown(&sets, &parents, adequate);
            sets.extend(found);
            for reformed in self.to_be_reformed(&sets, size + 1, adequate) {
                self.in_other_forms(&mut sets, reformed, adequate);
            }
            let grown = sets.iter().filter(|set| set.members.len() == size + 1);
            let best = grown.map(evidence).fold(f64::NEG_INFINITY, f64::max);
            // Two effects can explain together what neither explains alone, and half of what is missing may look less like
            // noise than all of it: a search that has not arrived goes one member on.
            let stalls = best < before && (adequate || std::mem::replace(&mut stalled, true));
            if stalls || self.data.bench.interrupted() {
                break;
            }
        }
        if !adequate && !self.data.bench.interrupted() {
            self.never_reformed(&sets).into_iter().for_each(|set| self.in_other_forms(&mut sets, set, false));
        }
        doubts.extend(self.last_doubt(&sets, &doubts));
        self.repair(&mut sets, &doubts);
        self.told("likely sets of effects without one of them");
        self.nest(&mut sets);
        self.told("sets of effects that fitted worse than smaller ones");
        self.make_sure(&mut sets);
        self.doubt(&mut sets, doubts);
        self.told("likely sets of effects with a discrepancy");
        sets
    }

    /// The likeliest set of a size with a discrepancy, and whether it lacks nothing. What lacks something is sought with other
    /// members in the place of its own before, then from elsewhere, and what does not with others in the place of those that bring
    /// several numbers.
    fn arrived(&self, sets: &mut Vec<Set>, size: usize) -> Option<(Option<Set>, bool)> {
        let best = of_size(sets, size).first().copied()?;
        let judged = self.judged(&sets[best]);
        let adequate = judged.1;
        // Of one effect alone all others were looked at.
        if size == 0 || adequate && size == 1 {
            return Some(judged);
        }
        if adequate {
            self.in_simpler_exchange(sets, best);
        } else if self.in_exchange(sets, best) {
            for reformed in self.to_be_reformed(sets, size, true) {
                self.in_other_forms(sets, reformed, false);
            }
        }
        let after = of_size(sets, size)[0];
        let judged = if after == best { judged } else { self.judged(&sets[after]) };
        Some(if judged.1 { judged } else { self.freed(&mut sets[after]).unwrap_or(judged) })
    }

    /// `set` with a discrepancy, and whether it lacks nothing.
    fn judged(&self, set: &Set) -> (Option<Set>, bool) {
        let doubt = self.doubted(set);
        let adequate = is_adequate(self.data, set, doubt.as_ref());
        (doubt, adequate)
    }

    /// `set`, which lacks something, fitted from elsewhere where motions are solved for; judged anew if it is better there.
    fn freed(&self, set: &mut Set) -> Option<(Option<Set>, bool)> {
        set.posterior = super::freed(self.data, &set.posterior)?;
        set.screened = false;
        Some(self.judged(set))
    }

    /// The likeliest of `sets` with a discrepancy, unless that is among the `known`.
    fn last_doubt(&self, sets: &[Set], known: &[Set]) -> Option<Set> {
        let best =
            sets.iter().filter(|set| !set.screened).max_by(|a, b| evidence(a).total_cmp(&evidence(b)))?;
        if known.iter().any(|known| known.is_of(best)) { None } else { self.doubted(best) }
    }

    /// Reports a stage that was done.
    fn told(&self, stage: &str) {
        if !self.data.bench.interrupted() {
            (self.report)(stage);
        }
    }

    /// Whether two candidates are forms of one.
    pub(super) fn are_forms(&self, a: usize, b: usize) -> bool {
        self.candidates[a].candidate.is_form_of(&self.candidates[b].candidate)
    }

    /// Leaves of those of `parents` that have the same effects in several forms the first.
    pub(super) fn different(&self, sets: &[Set], parents: &mut Vec<usize>) {
        let among = |a: usize, members: &[usize]| members.iter().any(|b| self.are_forms(a, *b));
        let same = |a: usize, b: usize| sets[a].members.iter().all(|a| among(*a, &sets[b].members));
        let mut kept: Vec<usize> = Vec::new();
        parents.retain(|parent| {
            let new = !kept.iter().any(|kept| same(*kept, *parent));
            kept.extend(new.then_some(*parent));
            new
        });
    }

    /// The sets of one more member, from `parents`, of two members from others, too; of those that lack nothing only what could be
    /// likelier. The best are fitted in full.
    pub(super) fn grown(&self, sets: &[Set], parents: &[usize], adequate: bool) -> Vec<Set> {
        let from: Vec<Set> = parents.iter().map(|parent| sets[*parent].clone()).collect();
        // One effect alone is what is likeliest: none is passed over for what it does not promise.
        let thorough = !adequate && self.looks.is_some() && from.iter().any(|set| set.members.is_empty());
        let mut found = match self.looks.filter(|_| thorough) {
            Some(looks) => self.looked_at(self.beside_given(looks, &from[0])),
            None => Vec::new(),
        };
        // What explains all may have a rival that does so, too: only those around the refitted model tell.
        let single = |set: &Set| set.members.len() == 1;
        let seen = match !adequate && from.iter().all(single) {
            true => self.paired(sets, from),
            false => self.around(from, adequate),
        };
        found.extend(if thorough { self.thoroughly(seen) } else { self.looked_at_best(seen).0 });
        let mut found = best_of_each(found.into_iter());
        self.finish_best(&mut found, sets, adequate);
        found
    }

    /// Fits those of the ranked `found` in full that may be the best of them and of `sets`, and the one that leaves the smallest
    /// residual. By how much a fit raises the evidence of a look shows how far below its own another look may have ended.
    pub(super) fn finish_best(&self, found: &mut [Set], sets: &[Set], adequate: bool) {
        let best = |found: &[Set]| found.iter().chain(sets).map(evidence).fold(f64::NEG_INFINITY, f64::max);
        let (looked, mut gained) = (best(found), 0.0_f64);
        let closest = self.closest(found.iter().enumerate()).filter(|_| !adequate);
        let mut open: Vec<usize> = (0..found.len()).filter(|k| *k < FULL || Some(*k) == closest).collect();
        loop {
            let near = looked.min(best(found)) - BEHIND - gained;
            let first = |k: usize| k == 0 && !adequate;
            let (now, later): (Vec<usize>, Vec<usize>) = open
                .into_iter()
                .partition(|k| evidence(&found[*k]) > near || first(*k) || Some(*k) == closest);
            if now.is_empty() {
                break;
            }
            open = later;
            let gain = |(k, set): (usize, &mut Set)| {
                let before = evidence(set);
                self.finish(set);
                // What is far behind says nothing of those that are not.
                if before > near || first(k) { evidence(set) - before } else { 0.0 }
            };
            let wanted = found.par_iter_mut().enumerate().filter(|(k, _)| now.contains(k));
            gained = wanted.map(gain).reduce(|| gained, f64::max);
        }
    }

    /// Size of the residual of a set.
    pub(super) fn left(&self, set: &Set) -> f64 {
        self.data.left(&set.posterior.predictions)
    }

    /// Whether several effects leave so much beyond the noise, wherever they are, that one more will not explain the rest.
    fn is_hopeless(&self, sets: &[Set], size: usize) -> bool {
        let left = |set: &Set| self.data.unexplained(&set.posterior.predictions);
        let least = of_size(sets, size).into_iter().map(|k| left(&sets[k])).fold(f64::INFINITY, f64::min);
        size >= SEVERAL && least * least > HOPELESS * left(&sets[0]).powi(2)
    }

    /// The one of `sets` that leaves the smallest residual, if that of the first is larger.
    pub(super) fn closest<'k>(&self, sets: impl Iterator<Item = (usize, &'k Set)>) -> Option<usize> {
        let left: Vec<(usize, f64)> = sets.map(|(k, set)| (k, self.left(set))).collect();
        let closest = left.iter().min_by(|a, b| a.1.total_cmp(&b.1))?;
        (closest.1 < CLOSER * left[0].1).then_some(closest.0)
    }

    /// Candidates that are no form of a member of `set`.
    pub(super) fn beside(&self, set: &Set) -> Vec<usize> {
        let own = |m: &usize| self.candidates[*m].candidate.law.is_none();
        let absent = |m: &usize| !set.members.iter().any(|member| self.are_forms(*m, *member));
        (0..self.candidates.len()).filter(own).filter(absent).collect()
    }

    /// Amounts of the candidates `which` beside `parent`, of these `sizes` first; the most promising first.
    pub(super) fn probed(&self, data: &Measured, parent: &Set, which: &[usize], sizes: &[f64]) -> Probed {
        probe::around(data, &parent.posterior, self.candidates, which, sizes).unwrap_or_default()
    }

    pub(super) fn extended(
        &self,
        parent: &Posterior,
        candidate: usize,
        y: &[f64],
    ) -> (Model, Vec<Unknown>, Vec<f64>) {
        let prepared = &self.candidates[candidate];
        let model = prepared.added_to(&parent.model, y);
        let mut unknowns = parent.unknowns.clone();
        unknowns.extend(prepared.unknowns(&model, candidate));
        let start = [&parent.y, y].concat();
        (model, unknowns, start)
    }

    /// Fits a set that was looked at.
    pub(super) fn finish(&self, set: &mut Set) {
        if let Ok(whole) = super::again(self.data, &set.posterior) {
            set.posterior = whole;
            set.screened = false;
        }
    }

    /// `set` with a discrepancy, to first order.
    pub(super) fn doubted(&self, set: &Set) -> Option<Set> {
        let doubt = discrepancy::about(self.data, &set.posterior).ok()?;
        let mut with = set.clone();
        with.discrepancy = Some(doubt.kind);
        with.posterior.log_evidence = doubt.log_evidence;
        with.posterior.predictions = doubt.predictions;
        Some(with)
    }
}

/// Whether `set` lacks nothing that `doubt` stands for, and its residual is not far beyond a noise that is known; without a doubt,
/// nothing relevant beyond the noise.
pub(super) fn is_adequate(data: &Measured, set: &Set, doubt: Option<&Set>) -> bool {
    let predictions = &set.posterior.predictions;
    let is_noise = data.unexplained(predictions) < data.assumptions().relevant;
    let Some(doubt) = doubt else { return is_noise };
    // No force at the contact of a structure stands for what is missing elsewhere.
    let elsewhere = !discrepancy::is_moved(&set.posterior) && doubt.discrepancy == Some(Discrepancy::Force);
    // What moves on slowly may look like noise with a memory; a noise that is known has a size, too.
    let is_too_much = data.noise_is_known() && data.share_beyond_noise(predictions) > MOST;
    evidence(doubt) < evidence(set) && (is_noise || !elsewhere && !is_too_much)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::assumptions::Assumptions;
    use crate::diagnose::diagnosis::{Noise, NoiseSource};
    use crate::diagnose::evidence::samples::{beam, searching, slider, steady};
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;

    /// A set that predicts `predictions` of one record with a log evidence of zero.
    fn set(model: &Model, predictions: Vec<f64>) -> Set {
        let posterior = Posterior {
            model: model.clone(),
            unknowns: Vec::new(),
            y: Vec::new(),
            log_evidence: 0.0,
            log_peak: 0.0,
            deviations: Vec::new(),
            correlations: Vec::new(),
            predictions: vec![predictions],
            simulations: 0,
        };
        Set { members: Vec::new(), discrepancy: None, posterior, screened: false }
    }

    /// A search without candidates.
    fn search<'s, 'a, 'd>(data: &'s Measured<'a, 'd>) -> Search<'s, 'a, 'd> {
        Search { data, looks: None, beginnings: &[], candidates: &[], most: 3, report: &|_| {} }
    }

    /// A noise of the force that is stated.
    fn told(deviation: f64) -> Noise {
        let (channel, source) = ("force".to_owned(), NoiseSource::Stated);
        Noise { record: 0, channel, deviation: Some(deviation), log_error: 0.0, source }
    }

    /// A contact that sticks, its force without noise.
    fn sticking() -> (Model, Dataset) {
        let force: Vec<f64> = (0..200).map(|i| (0.1 * f64::from(i)).sin()).collect();
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let channels = vec![
            channel("time", "s", (0..200).map(|i| 1e-3 * f64::from(i)).collect()),
            channel("displacement", "m", force.iter().map(|f| 1e-6 * f).collect()),
            channel("force", "N", force),
        ];
        let record = Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels };
        (slider(""), Dataset { title: None, records: vec![record] })
    }

    #[test]
    fn a_look_is_fitted_where_it_may_have_ended_as_far_below_its_fit_as_another_did() {
        let (model, dataset) = sticking();
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0], &[], &[]);
        let base = first(&data, None, &model).and_then(|(first, _)| again(&data, &first)).unwrap();
        let search = search(&data);
        // Looks that promise so much more than their fits hold, and sets that are fitted already.
        let fitted = |looks: &[f64], known: &[f64]| {
            let sets = |of: &[f64]| -> Vec<Set> {
                let of = of.iter().map(|more| {
                    let log_evidence = base.log_evidence + more;
                    let posterior = Posterior { log_evidence, ..base.clone() };
                    Set { members: Vec::new(), discrepancy: None, posterior, screened: true }
                });
                of.collect()
            };
            let mut looks = sets(looks);
            search.finish_best(&mut looks, &sets(known), true);
            looks.iter().map(|set| !set.screened).collect::<Vec<bool>>()
        };
        assert_eq!(fitted(&[0.0, -10.0, -70.0], &[]), [true, true, false]);
        assert_eq!(fitted(&[-100.0, -170.0, -1000.0], &[]), [true, true, false]);
        // What promised too much hides no other.
        assert_eq!(fitted(&[1000.0, 970.0, -100.0], &[]), [true, true, false]);
        // What is known is far better.
        assert_eq!(fitted(&[0.0, -10.0], &[100.0]), [false, false]);
        // Five at most.
        assert_eq!(fitted(&[0.0; 7], &[]), [true, true, true, true, true, false, false]);
    }

    #[test]
    fn without_a_doubt_a_residual_of_the_size_of_the_noise_is_adequate() {
        let (model, dataset) = sticking();
        let force = dataset.records[0].channels[2].values.clone();
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let (known, unknown) =
            (Measured::new(&bench, &[0], &[told(0.02)], &[]), Measured::new(&bench, &[0], &[], &[]));
        let off = |by: f64| {
            let signs = [by, -by].into_iter().cycle();
            set(&model, force.iter().zip(signs).map(|(force, by)| force + by).collect())
        };
        assert!(is_adequate(&known, &off(0.02), None));
        assert!(!is_adequate(&known, &off(0.05), None));
        assert!(!is_adequate(&unknown, &off(0.02), None));
        // Of an unknown noise what follows from its own past is not new, and of few values, or of much, nothing is told.
        let mut random = fastrand::Rng::with_seed(4);
        let mut noisy = |size: f64, wave: f64| {
            let noise = (0..200).map(|i| size * (random.f64() - 0.5) + wave * (0.05 * f64::from(i)).sin());
            set(&model, force.iter().zip(noise).map(|(force, noise)| force + noise).collect())
        };
        assert!(is_adequate(&unknown, &noisy(0.04, 0.0), None));
        assert!(is_adequate(&unknown, &noisy(0.01, 0.005), None));
        assert!(!is_adequate(&unknown, &noisy(0.01, 0.02), None));
        assert!(!is_adequate(&unknown, &noisy(0.7, 0.0), None));
        let mut short = dataset.clone();
        short.records[0].channels.iter_mut().for_each(|channel| channel.values.truncate(40));
        let bench = WeightedDataset::new(&model, &short, Assumptions::default(), None).unwrap();
        let few = noisy(0.04, 0.0).posterior.predictions[0][..40].to_vec();
        assert!(!is_adequate(&Measured::new(&bench, &[0], &[], &[]), &set(&model, few), None));
        // One that is seen decides.
        let doubt = |log_evidence| {
            let mut doubt = off(0.02);
            doubt.posterior.log_evidence = log_evidence;
            doubt
        };
        assert!(!is_adequate(&known, &off(0.02), Some(&doubt(1.0))));
        assert!(is_adequate(&known, &off(0.05), Some(&doubt(-1.0))));
        // Unless most of it is beyond a noise that is known.
        assert!(!is_adequate(&known, &off(0.08), Some(&doubt(-1.0))));
        assert!(is_adequate(&unknown, &off(0.08), Some(&doubt(-1.0))));
        // What is not relevant is enough, however precise the measurements are.
        let precise = Measured::new(&bench, &[0], &[told(1e-4)], &[]);
        assert!(is_adequate(&precise, &off(5e-3), Some(&doubt(-1.0))));
        // As is what one that is hardly known may be.
        let hardly = Measured::new(&bench, &[0], &[Noise { log_error: 1.0, ..told(0.02) }], &[]);
        assert!(is_adequate(&hardly, &off(0.08), Some(&doubt(-1.0))));
    }

    #[test]
    fn where_two_explain_little_no_third_is_sought() {
        let (model, dataset) = sticking();
        let force = &dataset.records[0].channels[2].values;
        let bench = WeightedDataset::new(&model, &dataset, Assumptions::default(), None).unwrap();
        let off = |members: &[usize], by: f64| {
            let predictions = force.iter().map(|force| force * (1.0 + by)).collect();
            Set { members: members.to_vec(), ..set(&model, predictions) }
        };
        let is_hopeless = |noise: f64, sets: &[Set]| {
            let data = Measured::new(&bench, &[0], &[told(noise)], &[]);
            search(&data).is_hopeless(sets, sets[1].members.len())
        };
        assert!(is_hopeless(1e-3, &[off(&[], 0.1), off(&[0, 1], 0.08)]));
        assert!(!is_hopeless(1e-3, &[off(&[], 0.1), off(&[0, 1], 0.06)]));
        // The noise is not to be explained: of the same two a fifth of what there is beyond it is left.
        assert!(!is_hopeless(0.05, &[off(&[], 0.1), off(&[0, 1], 0.08)]));
        // The one that comes closest tells, and one effect alone is not several.
        assert!(!is_hopeless(1e-3, &[off(&[], 0.1), off(&[0, 1], 0.08), off(&[0, 2], 0.06)]));
        assert!(!is_hopeless(1e-3, &[off(&[], 0.1), off(&[0], 0.08)]));
    }

    #[test]
    fn a_set_that_stuck_is_judged_where_it_is_freed() {
        let (truth, given) = (beam(1.94e11, 0.4, ""), beam(1.95e11, 0.42, ""));
        searching(&given, &steady(&truth), &["added_mass"], 1, |search, base| {
            let whole = Set { members: Vec::new(), discrepancy: None, posterior: base, screened: false };
            assert!(search.freed(&mut whole.clone()).is_none());
            // Elsewhere, and taken for an end.
            let mut stuck = Set { screened: true, ..whole.clone() };
            stuck.posterior.predictions.iter_mut().flatten().for_each(|x| *x *= 0.7);
            stuck.posterior.log_evidence = f64::NEG_INFINITY;
            stuck.posterior.log_peak = f64::NEG_INFINITY;
            let (doubt, adequate) = search.freed(&mut stuck).unwrap();
            assert!(adequate && !stuck.screened && (evidence(&stuck) - evidence(&whole)).abs() < 1.0);
            assert!(doubt.is_none_or(|doubt| doubt.is_of(&stuck)));
        });
    }
}
