//! First looks at sets of one more member: at beginnings of records, at motions as they were measured, and at the data as
//! they are.

use rayon::prelude::*;

use super::measured::Measured;
use super::posterior::{Posterior, Start, screen};
use super::probe::Probe;
use super::search::{
    BEHIND, Search, Set, TWICE, WORTH, best_of_each, evidence, is_adequate, promising, rank,
};

/// Sets that are followed from the beginnings of records to their ends, at most.
const LED: usize = 3;

impl Search<'_, '_, '_> {
    /// A set that was glanced at, looked at.
    pub(super) fn screened(data: &Measured, set: &mut Set) {
        let Posterior { model, unknowns, y, .. } = &set.posterior;
        let start = Start { model, unknowns, y };
        if let Ok(better) = screen(data, &start, true)
            && better.log_evidence > evidence(set)
        {
            set.posterior = better;
        }
    }

    /// A set of one more member than `parent` from where a probe says, after a glance.
    pub(super) fn glanced(&self, data: &Measured, parent: &Set, probe: &Probe) -> Option<Set> {
        let prepared = &self.candidates[probe.candidate];
        let mut y = probe.start();
        let (low, high) = prepared.coordinates[0].bounds();
        y[0] = y[0].clamp(low, high);
        let (model, unknowns, start) = self.extended(&parent.posterior, probe.candidate, &y);
        let start = Start { model: &model, unknowns: &unknowns, y: &start };
        let posterior = screen(data, &start, false).ok()?;
        (self.report)(prepared.candidate.effect.id);
        let members = parent.members.iter().copied().chain([probe.candidate]).collect();
        Some(Set { members, discrepancy: None, posterior, screened: true })
    }

    /// Glances at those sets of one more member than `parent` that a line promises something of.
    fn glances(&self, data: &Measured, parent: &Set) -> Vec<Set> {
        let mut probes = self.probed(data, parent);
        probes.retain(|probe| probe.gain > WORTH);
        promising(probes).par_iter().filter_map(|probe| self.glanced(data, parent, probe)).collect()
    }

    /// Sets of one member, beside the model as it was given, refitted about the motions as they were measured, in the place
    /// of `empty`; the likeliest there. Where something is missing, it may be nearer to the truth than what fits best.
    pub(super) fn beside_given(&self, looks: &Measured, empty: &Set) -> Vec<Set> {
        let mut given = empty.clone();
        given.posterior.y.fill(0.0);
        if !moved(looks, &mut given) {
            return Vec::new();
        }
        let mut found = best_of_each(self.glances(looks, &given).into_iter());
        found.truncate(TWICE);
        found.into_par_iter().filter_map(|mut set| moved(looks, &mut set).then_some(set)).collect()
    }

    /// Those that come from the model as it is `given` and the best of those that were `glanced` at, looked at as the data
    /// are: what a line or a motion as it was measured promises can be compared with the same of others alone. If `thorough`
    /// all of them, or where one of the best lacks nothing those that are as likely. Where nothing is solved for the rest stay
    /// as they are.
    pub(super) fn looked_at(&self, given: Vec<Set>, mut glanced: Vec<Set>, thorough: bool) -> Vec<Set> {
        rank(&mut glanced);
        let twice = glanced.len().min(TWICE);
        if self.looks.is_none() {
            glanced[..twice].par_iter_mut().for_each(|set| Self::screened(self.data, set));
            rank(&mut glanced);
            return glanced;
        }
        let looked = |mut set: Set| moved(self.data, &mut set).then_some(set);
        let mut rest = glanced.split_off(twice);
        let best = glanced.first().map_or(f64::NEG_INFINITY, evidence);
        let mut found: Vec<Set> = given.into_par_iter().chain(glanced).filter_map(looked).collect();
        let lacks_nothing = |set: &Set| is_adequate(self.data, set, self.doubted(set).as_ref());
        if thorough {
            let enough = found.iter().any(lacks_nothing);
            rest.retain(|set| !enough || evidence(set) > best - BEHIND);
            found.par_extend(rest.into_par_iter().filter_map(looked));
        }
        rank(&mut found);
        found
    }

    /// Sets of one more member than `parent` that fit the beginnings of the records best, from there: the longer a record
    /// is, the more a wrong frequency falls out of step.
    pub(super) fn led(&self, parent: &Set) -> Vec<Set> {
        let Some((short, longer)) = self.beginnings.split_first() else { return Vec::new() };
        let mut parent = parent.clone();
        if !moved(short, &mut parent) {
            return Vec::new();
        }
        let mut found = self.glances(short, &parent);
        rank(&mut found);
        found.truncate(LED);
        found.par_iter_mut().for_each(|set| Self::screened(short, set));
        let mut found = best_of_each(found.into_iter());
        let whole = self.looks.unwrap_or(self.data);
        let reaches = |set: &mut Set| longer.iter().chain([whole]).all(|data| moved(data, set));
        found.retain_mut(reaches);
        found
    }
}

/// `set` looked at in other data than before.
pub(super) fn moved(data: &Measured, set: &mut Set) -> bool {
    let Posterior { model, unknowns, y, .. } = &set.posterior;
    let found = screen(data, &Start { model, unknowns, y: &y[..unknowns.len()] }, true);
    found.map(|found| set.posterior = found).is_ok()
}
