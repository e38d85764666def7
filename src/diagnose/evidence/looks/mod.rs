//! First looks at sets of one more member: at beginnings of records, at motions as they were measured, and at the data as
//! they are. `pairs`: at sets of two effects at once.

mod pairs;

use rayon::prelude::*;

use super::joint::Tangents;
use super::measured::Measured;
use super::posterior::{LOOK, Posterior, Start, glance, screen};
use super::probe::{self, Probe, Probed, SIZES, SMALL};
use super::search::{BEHIND, CLOSER, Search, TWICE, is_adequate};
use super::set::{Set, best_of_each, evidence, rank};

/// What a line must promise (in nats) to be worth a fit where something is missing; where nothing is, the log evidence
/// behind the best, and the fraction of a relevant change.
pub(super) const WORTH: f64 = 2.0;
const UNLIKELY: f64 = -5.0;
const IRRELEVANT: f64 = 0.3;
/// Measured values below which every candidate is worth a fit, since none takes long.
const FEW: usize = 100;
/// Multiple of a prior's deviation that first numbers of effects with a second one start from, too.
const MORE: f64 = 10.0;
/// Starts from which a candidate with several places of a second number is followed beside the model given, at most.
const PLACES: usize = 3;
/// Sets that are followed from the beginnings of records to their ends, at most.
const LED: usize = 3;

impl Search<'_, '_, '_> {
    /// A set that was glanced at, looked at.
    pub(super) fn screened(data: &Measured, set: &mut Set) {
        let Posterior { model, unknowns, y, .. } = &set.posterior;
        let start = Start { model, unknowns, y };
        if let Ok(better) = screen(data, &start, LOOK)
            && better.log_evidence > evidence(set)
        {
            set.posterior = better;
        }
    }

    /// A set of one more member than `parent` from where a probe says, after a glance.
    pub(super) fn glanced(
        &self,
        data: &Measured,
        parent: &Set,
        tangents: Option<&Tangents>,
        probe: &Probe,
    ) -> Option<Set> {
        let prepared = &self.candidates[probe.candidate];
        let (model, unknowns, start) =
            self.extended(&parent.posterior, probe.candidate, &probe.start(&prepared.coordinates[0]));
        let start = Start { model: &model, unknowns: &unknowns, y: &start };
        let posterior = glance(data, &start, tangents).ok()?;
        (self.report)(prepared.candidate.effect.id);
        let members = parent.members.iter().copied().chain([probe.candidate]).collect();
        Some(Set { members, discrepancy: None, posterior, screened: true })
    }

    /// Glances at those sets of one more member than `parent`, of the candidates `which`, that lines promise something of: from
    /// the `most` starts that promise most.
    pub(super) fn glances(&self, data: &Measured, parent: &Set, which: &[usize], most: usize) -> Vec<Set> {
        let Probed { mut probes, tangents } = self.probed(data, parent, which, SIZES);
        probes.retain(|probe| probe.gain > WORTH);
        let mut starts = promising(probes);
        starts.truncate(most);
        let glanced = |probe| self.glanced(data, parent, tangents.as_ref(), probe);
        starts.par_iter().filter_map(glanced).collect()
    }

    /// Sets of one member, beside the model as it was given, in the place of `empty`, about the motions as they were measured; the
    /// likeliest there. Where something is missing, the model given may be nearer to the truth than what fits best: refitted about
    /// those motions or, where much is missing, as it is. There lines promise too little, or mislead: whatever they say, each
    /// amount is glanced at, and of what is narrow, such as a resonator near the drive, more at each of its places.
    pub(super) fn beside_given(&self, looks: &Measured, empty: &Set) -> Vec<Set> {
        let mut given = empty.clone();
        given.posterior.y.fill(0.0);
        let which = self.beside(&given);
        let (placed, others): (Vec<usize>, Vec<usize>) =
            which.iter().partition(|candidate| self.candidates[**candidate].has_places());
        let mut wanted = probe::amounts(self.candidates, &others, SIZES);
        wanted.extend(probe::amounts(self.candidates, &placed, &[MORE]));
        // A start that is far off promises much that is not there: each has its own best.
        let mut found = self.best_glanced(looks, &given, &wanted);
        if moved(looks, &mut given) {
            let mut worth = self.probed(looks, &given, &which, SIZES).probes;
            worth.retain(|probe| probe.gain > WORTH);
            let mut wanted = promising(worth);
            wanted.extend(probe::amounts(self.candidates, &placed, &[1.0]));
            found.extend(self.best_glanced(looks, &given, &wanted));
        }
        rank(&mut found);
        // About these motions nothing is solved for: each effect is worth a look.
        self.keep_worth_a_look(&mut found, true);
        let mut found = moved_all(looks, found);
        rank(&mut found);
        self.keep_worth_a_look(&mut found, false);
        // Several starts may lead to one place.
        let same = |a: &Set, b: &Set| a.members == b.members && (evidence(a) - evidence(b)).abs() < WORTH;
        let mut apart: Vec<Set> = Vec::new();
        for set in found {
            if !apart.iter().any(|known| same(known, &set)) {
                apart.push(set);
            }
        }
        apart
    }

    /// Glances at sets of one more member around the parents `from`, where a line through each promises something; beside none where
    /// something is missing, what has several places of a second number even where no line promises anything.
    pub(in crate::diagnose::evidence) fn around(&self, mut from: Vec<Set>, adequate: bool) -> Vec<Set> {
        let parents = from.clone();
        let (mut wanted, mut tangents): (Vec<(usize, Probe)>, Vec<Option<Tangents>>) = Default::default();
        let few = (0..self.data.records.len()).map(|k| self.data.lane(k).measured.len()).sum::<usize>() < FEW;
        let worthy = |probe: &Probe| {
            let likely =
                probe.evidence > UNLIKELY && probe.distance > IRRELEVANT * self.data.assumptions().relevant;
            (few || probe.gain > WORTH) && (!adequate || likely)
        };
        if !adequate && self.looks.is_none() {
            from.par_iter_mut().for_each(|set| self.whiten(set));
        }
        for (k, parent) in from.iter().enumerate() {
            let sizes = if adequate { SMALL } else { SIZES };
            let mut probed = self.probed(self.data, parent, &self.beside(parent), sizes);
            probed.probes.retain(worthy);
            wanted.extend(promising(probed.probes).into_iter().map(|probe| (k, probe)));
            tangents.push(probed.tangents);
            if !adequate && parent.members.is_empty() && self.looks.is_none() {
                let unpromising = self.in_all_places(parent, &wanted);
                wanted.extend(unpromising.into_iter().map(|probe| (k, probe)));
            }
        }
        let looks = self.looks.unwrap_or(self.data);
        if !adequate && let Some(looks) = self.looks {
            // What a wrong model moves through tells little of what else is missing: what was measured moves as it is.
            for (k, mut about) in from.clone().into_iter().enumerate() {
                if moved(looks, &mut about) {
                    let known = |c: usize| wanted.iter().any(|(of, probe)| *of == k && probe.candidate == c);
                    let mut probes = self.probed(looks, &about, &self.beside(&about), SIZES).probes;
                    probes.retain(|probe| probe.gain > WORTH && !known(probe.candidate));
                    wanted.extend(promising(probes).into_iter().map(|probe| (from.len(), probe)));
                    from.push(about);
                }
            }
        }
        let glanced = |(parent, probe): &(usize, Probe)| {
            let tangents = tangents.get(*parent).and_then(Option::as_ref);
            self.glanced(looks, &from[*parent], tangents, probe)
        };
        let seen: Vec<Option<Set>> = wanted.par_iter().map(glanced).collect();
        let led = parents.iter().filter(|_| !adequate).flat_map(|parent| self.led(parent));
        best_of_each(seen.into_iter().flatten().chain(led))
    }

    /// Starts in all places of a second number, of candidates that are not `wanted` for what lines promise: about a wrong place they
    /// promise nothing, however right another is.
    fn in_all_places(&self, parent: &Set, wanted: &[(usize, Probe)]) -> Vec<Probe> {
        let known = |c: &usize| wanted.iter().any(|(_, probe)| probe.candidate == *c);
        let mut unseen = self.beside(parent);
        unseen.retain(|c| self.candidates[*c].has_places() && !known(c));
        probe::amounts(self.candidates, &unseen, &[1.0])
    }

    /// The best of each candidate after a glance from `starts` beside `from`, of those with several places a few: which of
    /// them leads on, a glance does not tell.
    fn best_glanced(&self, looks: &Measured, from: &Set, starts: &[Probe]) -> Vec<Set> {
        let glanced = |start| self.glanced(looks, from, None, start);
        let mut seen: Vec<Set> = starts.par_iter().filter_map(glanced).collect();
        rank(&mut seen);
        let mut kept = vec![0; self.candidates.len()];
        seen.retain(|set| {
            let candidate = set.members[0];
            kept[candidate] += 1;
            kept[candidate] <= if self.candidates[candidate].has_places() { PLACES } else { 1 }
        });
        seen
    }

    /// Keeps of the ranked `found`, of one member each, those that come near the best or before a ninth effect, and the best of
    /// `each` effect if that is asked for: what ends far from where it would lead after a glance may have many before it.
    fn keep_worth_a_look(&self, found: &mut Vec<Set>, each: bool) {
        let least = found.first().map_or(0.0, evidence) - BEHIND;
        let mut effects: Vec<&str> = Vec::new();
        found.retain(|set| {
            let effect = self.candidates[set.members[0]].candidate.effect.id;
            let new = !effects.contains(&effect);
            if new {
                effects.push(effect);
            }
            evidence(set) > least || effects.len() <= TWICE || each && new
        });
    }

    /// `sets` looked at as the data are: what a line or a motion as it was measured promises can be compared with the same of
    /// others alone.
    pub(super) fn looked_at(&self, sets: Vec<Set>) -> Vec<Set> {
        moved_all(self.data, sets)
    }

    /// The best of those that were `glanced` at, looked at as the data are, and the rest. Where nothing is solved for the rest
    /// are among the first as they are.
    pub(super) fn looked_at_best(&self, mut glanced: Vec<Set>) -> (Vec<Set>, Vec<Set>) {
        rank(&mut glanced);
        let twice = glanced.len().min(TWICE);
        if self.looks.is_none() {
            glanced[..twice].par_iter_mut().for_each(|set| Self::screened(self.data, set));
            rank(&mut glanced);
            return (glanced, Vec::new());
        }
        let rest = glanced.split_off(twice);
        let mut found = self.looked_at(glanced);
        rank(&mut found);
        (found, rest)
    }

    /// The same of all that were `glanced` at; where one of the best lacks nothing, of those that are as likely.
    pub(super) fn thoroughly(&self, glanced: Vec<Set>) -> Vec<Set> {
        let best = glanced.iter().map(evidence).fold(f64::NEG_INFINITY, f64::max);
        let (mut found, mut rest) = self.looked_at_best(glanced);
        let enough = found.iter().any(|set| self.lacks_nothing(set));
        rest.retain(|set| !enough || evidence(set) > best - BEHIND);
        found.extend(self.looked_at(rest));
        rank(&mut found);
        found
    }

    /// Whether `set` lacks nothing.
    fn lacks_nothing(&self, set: &Set) -> bool {
        is_adequate(self.data, set, self.doubted(set).as_ref())
    }

    /// Fits `set` as if its residual were white, if it leaves less then: one that is far from what was measured is
    /// drawn to parameters that make its residual smooth, which promises nothing of what would make it small.
    pub(super) fn whiten(&self, set: &mut Set) {
        let mut white = set.clone();
        if moved(self.data, &mut white) && self.left(&white) < CLOSER * self.left(set) {
            *set = white;
        }
    }

    /// Sets of one more member than `parent` that fit the beginnings of the records best, from there: the longer a record
    /// is, the more a wrong frequency falls out of step.
    pub(super) fn led(&self, parent: &Set) -> Vec<Set> {
        let Some((short, longer)) = self.beginnings.split_first() else { return Vec::new() };
        let mut parent = parent.clone();
        if !moved(short, &mut parent) {
            return Vec::new();
        }
        let mut found = self.glances(short, &parent, &self.beside(&parent), usize::MAX);
        rank(&mut found);
        found.truncate(LED);
        found.par_iter_mut().for_each(|set| Self::screened(short, set));
        let mut found = best_of_each(found.into_iter());
        let whole = self.looks.unwrap_or(self.data);
        let reaches = |set: &mut Set| longer.iter().chain([whole]).all(|data| moved(data, set));
        found.retain_mut(reaches);
        found
    }

    /// The best fit with one of the candidates, from every start that promises something.
    pub fn alone(&self, base: &Posterior) -> Option<Posterior> {
        let every: Vec<usize> = (0..self.candidates.len()).collect();
        let parent = Set { members: Vec::new(), discrepancy: None, posterior: base.clone(), screened: false };
        let Probed { probes, tangents } = self.probed(self.data, &parent, &every, SIZES);
        let looks = self.looks.unwrap_or(self.data);
        let glanced = |probe| self.glanced(looks, &parent, tangents.as_ref(), probe);
        let mut tried: Vec<Set> = probes.par_iter().filter_map(glanced).collect();
        tried.extend(self.led(&parent));
        let mut tried = self.looked_at_best(tried).0;
        if let Some(looks) = self.looks {
            tried.extend(self.looked_at(self.beside_given(looks, &parent)));
        }
        rank(&mut tried);
        self.finish_best(&mut tried, &[], false);
        let order = |a: &Set, b: &Set| b.screened.cmp(&a.screened).then(evidence(a).total_cmp(&evidence(b)));
        tried.into_iter().max_by(order).map(|set| set.posterior)
    }
}

/// The first two of each candidate, another where it promises nearly as much.
pub(super) fn promising(probes: Vec<Probe>) -> Vec<Probe> {
    let mut starts: Vec<Probe> = Vec::new();
    for probe in probes {
        let same: Vec<&Probe> = starts.iter().filter(|s| s.candidate == probe.candidate).collect();
        let near = same.first().is_none_or(|best| probe.gain > 0.5 * best.gain);
        if same.len() < 2 && near {
            starts.push(probe);
        }
    }
    starts
}

/// `set` looked at in other data than before.
pub(super) fn moved(data: &Measured, set: &mut Set) -> bool {
    let Posterior { model, unknowns, y, .. } = &set.posterior;
    let found = screen(data, &Start { model, unknowns, y: &y[..unknowns.len()] }, LOOK);
    found.map(|found| set.posterior = found).is_ok()
}

/// All of `sets` that can be, looked at in other data than before.
fn moved_all(data: &Measured, sets: Vec<Set>) -> Vec<Set> {
    sets.into_par_iter().filter_map(|mut set| moved(data, &mut set).then_some(set)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;
    use crate::diagnose::evidence::samples::{beam, moved, searching, slider, steady, steady_at};
    use crate::model::Model;

    #[test]
    fn several_forms_of_one_effect_leave_room_for_the_looks_at_others() {
        let given = beam(1.95e11, 0.42, "");
        searching(&given, &steady(&given), &[], 1, |search, base| {
            let id = |member: &usize| search.candidates[*member].candidate.effect.id;
            let (same, mut others): (Vec<usize>, Vec<usize>) =
                (0..search.candidates.len()).partition(|member| id(member) == "micro_slip");
            others.dedup_by_key(|member| id(member));
            assert!(same.len() > 1 && others.len() > TWICE);
            // All but the first so far behind.
            let worth = |behind: f64, each: bool| {
                let set = |(k, member): (usize, &usize)| {
                    let log_evidence = if k == 0 { 0.0 } else { -behind };
                    let posterior = Posterior { log_evidence, ..base.clone() };
                    Set { members: vec![*member], discrepancy: None, posterior, screened: true }
                };
                let all = same.iter().chain(&others).chain(&others);
                let mut sets: Vec<Set> = all.enumerate().map(set).collect();
                search.keep_worth_a_look(&mut sets, each);
                sets.len()
            };
            assert_eq!(worth(2.0 * BEHIND, false), same.len() + TWICE - 1);
            assert_eq!(worth(2.0 * BEHIND, true), same.len() + others.len());
            assert_eq!(worth(0.5 * BEHIND, false), same.len() + 2 * others.len());
        });
    }

    #[test]
    fn what_has_several_places_is_followed_from_some_of_them() {
        let (truth, given) = (beam(1.94e11, 0.4, ""), beam(1.915e11, 0.34, ""));
        searching(&given, &steady(&truth), &["hanging_mass", "residual_stiffness"], 1, |search, base| {
            let empty = Set { members: Vec::new(), discrepancy: None, posterior: base, screened: false };
            let all: Vec<usize> = (0..search.candidates.len()).collect();
            let starts = probe::amounts(search.candidates, &all, SIZES);
            let found = search.best_glanced(search.looks.unwrap(), &empty, &starts);
            let of = |effect: &str| -> Vec<f64> {
                let id = |set: &&Set| search.candidates[set.members[0]].candidate.effect.id == effect;
                found.iter().filter(id).map(evidence).collect()
            };
            assert_eq!(of("residual_stiffness").len(), 1);
            let placed = of("hanging_mass");
            assert_eq!(placed.len(), PLACES);
            assert!(placed.is_sorted_by(|a, b| a >= b));
        });
    }

    #[test]
    fn what_has_several_places_is_glanced_at_whatever_lines_promise() {
        let mut random = fastrand::Rng::with_seed(7);
        let mut record = moved(&slider(""), 400, 1e-3, |i| 5e-5 * (0.05 * f64::from(i)).sin());
        record.channels[2].values.iter_mut().for_each(|force| *force += random.f64() - 0.5);
        let dataset = Dataset { title: None, records: vec![record] };
        searching(&slider(""), &dataset, &["velocity_weakening", "stiffening"], 1, |search, base| {
            // Nothing is missing, so that no line promises anything.
            let empty = Set { members: Vec::new(), discrepancy: None, posterior: base, screened: false };
            let glanced = |adequate: bool| -> Vec<&str> {
                let found = search.around(vec![empty.clone()], adequate);
                found.iter().map(|set| search.candidates[set.members[0]].candidate.effect.id).collect()
            };
            assert!(glanced(true).is_empty());
            assert_eq!(glanced(false), ["velocity_weakening"]);
        });
    }

    /// The value of `number` in what is found beside `given`, of all effects of one member, where `truth` was measured at these
    /// levels and frequencies, and the residual of it.
    fn found(truth: &Model, given: &Model, levels: &[(f64, f64)], number: &str) -> (f64, f64) {
        searching(given, &steady_at(truth, levels), &[], 1, |search, base| {
            let empty = Set { members: Vec::new(), discrepancy: None, posterior: base, screened: false };
            let mut all = search.looked_at(search.beside_given(search.looks.unwrap(), &empty));
            rank(&mut all);
            let mut best = all.swap_remove(0);
            search.finish(&mut best);
            let estimates = best.posterior.estimates();
            let value = estimates.iter().find(|estimate| estimate.name.ends_with(number));
            (value.map_or(f64::NAN, |found| found.value), search.left(&best))
        })
    }

    #[test]
    fn a_hanging_mass_of_many_times_the_size_that_its_prior_has_is_found() {
        for (hung, frequency) in [(60.0, 50.0), (8.0, 57.0), (9.0, 40.0)] {
            let effect = format!(
                "[[effect]]\nid = \"hanging_mass\"\nmass = {hung}\nhanging_frequency = {frequency}\n"
            );
            let (truth, given) = (beam(1.94e11, 0.4, &effect), beam(1.915e11, 0.34, ""));
            let levels = [(1.0, 47.0), (9.0, 52.0), (9.0, 50.0)];
            let (mass, left) = found(&truth, &given, &levels, ".mass");
            // The noise is uniform, of at most half a hundredth.
            assert!(left < 0.01, "{hung} kg at {frequency} Hz");
            // Where it hardly lets the beam move, a stiffer beam under a lighter one moves the same.
            assert!((mass / hung - 1.0).abs() < 0.15, "{mass} for {hung} kg");
        }
    }

    #[test]
    fn a_gap_is_found_where_what_fits_best_without_it_is_far_from_the_model_given() {
        for gap in [4e-6, 6e-6] {
            for (modulus, friction) in [(1.915e11, 0.34), (2.0e11, 0.34), (1.98e11, 0.5)] {
                let effect = format!("[[effect]]\nid = \"backlash\"\nhalf_gap = {gap}\n");
                let (truth, given) = (beam(1.94e11, 0.4, &effect), beam(modulus, friction, ""));
                let levels = [(1.0, 47.0), (4.0, 52.0), (9.0, 50.0), (15.0, 55.0), (20.0, 49.0)];
                let (half_gap, left) = found(&truth, &given, &levels, ".half_gap");
                assert!(left < 0.01 && (half_gap / gap - 1.0).abs() < 0.01, "{half_gap} for {gap} m");
            }
        }
    }
}
