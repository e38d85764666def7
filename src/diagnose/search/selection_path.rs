//! The rounds of the selection, and their results.

use super::candidates::Candidate;
use super::select::{OTHER_MINIMUM, PASSING_Z, Search, State, Trial};
use crate::diagnose::engine::Progress;
use crate::diagnose::measurements::weighted_dataset::{Scored, mean_square};
use crate::diagnose::refit::trial::Fitted;
use crate::diagnose::residual::blocks::{self, Gain};
use crate::diagnose::residual::maps::Repeated;
use crate::model::Model;

/// How many of the best are looked at until one holds.
const HELD: usize = 3;
/// Mean square of the weighted residuals below which a model is adequate.
pub(in crate::diagnose) const ADEQUATE: f64 = 1.15;
/// The same above which it leaves the data unexplained.
pub(in crate::diagnose) const UNEXPLAINED: f64 = 1.5;
/// The same in a single record, whose noise is less well known.
const RECORD_UNEXPLAINED: f64 = 3.0;
/// Singles from which pairs are made.
const PAIRED: usize = 5;
/// Fraction of the squared error that a single must remove to be paired.
const PROMISING: f64 = 0.005;

/// Something that was added.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Added {
    pub candidates: Vec<Candidate>,
    pub state: State,
    pub gain: Gain,
    pub error: f64,
    /// Those of the candidates that were taken back at the end.
    pub without: Vec<Candidate>,
    /// Whether they were because of the test records.
    pub vetoed: bool,
    /// Others that these data cannot tell from it.
    pub tied: Vec<Candidate>,
    /// Whether it was found with the validation records fitted, too: the test records alone have judged it.
    pub in_all_seen: bool,
}

/// All rounds.
pub(in crate::diagnose) struct SelectionPath {
    /// The model refitted, nothing added.
    pub base: State,
    /// What was added, in order.
    pub steps: Vec<Added>,
    /// Every round, best first.
    pub rounds: Vec<Vec<Trial>>,
    /// After the backward drop, where anything was dropped.
    pub shortened: Option<State>,
    pub interrupted: bool,
}

/// The end of the search, on all records seen, and the test records.
pub(in crate::diagnose) struct Outcome {
    pub findings: SelectionPath,
    /// The base, and one per step; one more where something was dropped.
    pub fits: Vec<Fitted>,
    /// Normalised error of the test records under the model as given.
    pub given: f64,
    /// Test records under the first and the last of them.
    pub before: Vec<Scored>,
    pub after: Vec<Scored>,
    /// Mean square of the weighted residuals on the test records, where the noise is known.
    pub chi_square: Option<f64>,
    /// The same on the validation records under the model that the search ended with, less what the uncertainty of its
    /// parameters makes of it.
    pub selecting: f64,
    /// Reduced χ² of the last model elsewhere, where the noise is known.
    pub left: Option<ResidualSummary>,
    /// Whether the last model, which explains all records seen, leaves more than noise on the test records, but no
    /// more than the uncertainty of its parameters can make of them.
    pub within_covariance: bool,
    /// What the residual there still follows, where the noise is known.
    pub follows: Vec<&'static str>,
    /// Whether that residual is the one that the records seen leave at the same places of the motion.
    pub repeated: Option<Repeated>,
}

/// Reduced χ² of a model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) struct ResidualSummary {
    /// Over all records seen.
    pub seen: f64,
    /// In the record it describes worst, and that record's index.
    pub worst: (usize, f64),
    /// Lower confidence bound, over those seen, the validation records, or those that nothing was fitted to, where it is
    /// largest.
    pub certain: f64,
}

impl ResidualSummary {
    /// Of scores of the records seen and of the test records, and what is `certain`.
    pub fn of(seen: &[Scored], test: &[Scored], certain: f64) -> Self {
        let worst = seen.iter().chain(test).map(|one| (one.record, mean_square(std::slice::from_ref(one))));
        Self {
            seen: mean_square(seen),
            worst: worst.max_by(|a, b| a.1.total_cmp(&b.1)).unwrap_or((0, 0.0)),
            certain,
        }
    }

    /// Whether the residual is so large that the model does not explain its data.
    pub fn is_too_much(&self) -> bool {
        self.seen > UNEXPLAINED || self.worst.1 > RECORD_UNEXPLAINED
    }

    /// The same, at the lower confidence bound.
    pub fn is_significant(&self) -> bool {
        self.certain > UNEXPLAINED || self.worst.1 > RECORD_UNEXPLAINED
    }
}

impl Added {
    /// Whether nothing of it was kept.
    pub fn dropped(&self) -> bool {
        self.candidates.iter().all(|candidate| self.without.contains(candidate))
    }
}

impl SelectionPath {
    /// Adds what gains most until the model is adequate or nothing passes.
    pub fn search(
        search: &Search,
        base: State,
        tried: &[Candidate],
        most: usize,
        known: bool,
        meter: &Progress,
    ) -> Self {
        let mut findings =
            Self { base, steps: Vec::new(), rounds: Vec::new(), shortened: None, interrupted: false };
        while findings.effects().len() < most {
            let first = findings.rounds.is_empty();
            let mut adequate = known && findings.is_adequate(search);
            // The first round is made in any case: its candidates are part of the answer.
            if adequate && !first {
                break;
            }
            let left: Vec<Vec<Candidate>> =
                tried.iter().filter(|c| !findings.effects().contains(c)).map(|c| vec![c.clone()]).collect();
            if !first {
                meter.expect(left.len());
            }
            let mut round = search.round(findings.last(), &left, None);
            findings.interrupted |= search.bench.interrupted();
            if first && !findings.interrupted {
                if known && let Some(only) = findings.only_explanation(search, &round) {
                    findings.rounds.push(round);
                    findings.steps.push(only);
                    break;
                }
                if !adequate && findings.begin_elsewhere(search, &left, &mut round, known, meter) {
                    adequate = known && findings.is_adequate(search);
                }
            }
            let step = if adequate { None } else { findings.best_of(search, findings.last(), &round) };
            // Where nobody knows what is noise, any second effect finds something to mend.
            let step = step.filter(|step| known || findings.steps.is_empty() || search.stands_alone(step));
            findings.rounds.push(round);
            let Some(step) = step else { break };
            findings.steps.push(step);
            if known {
                findings.begin_again(search);
            }
            if findings.interrupted {
                break;
            }
        }
        findings.try_pairs(search, most, known, meter);
        findings.drop_backward(search);
        findings.settle_ties(search);
        findings
    }

    /// Whether the present model leaves nothing but noise on the records seen.
    fn is_adequate(&self, search: &Search) -> bool {
        let present = self.last();
        search.fitted_chi_square(present) < ADEQUATE
            && present.chi_square() < UNEXPLAINED
            && search.least_chi_square(present, ADEQUATE) < ADEQUATE
    }

    /// Makes the first `round` anew where that leads to a far better fit: from the model as given, then from a better
    /// minimum of the model without effects, which becomes the base. Returns whether it has.
    fn begin_elsewhere(
        &mut self,
        search: &Search,
        sets: &[Vec<Candidate>],
        round: &mut Vec<Trial>,
        known: bool,
        meter: &Progress,
    ) -> bool {
        let fits = round.iter().filter_map(|trial| trial.state.as_ref().ok());
        let least = fits.fold(f64::INFINITY, |least, fit| least.min(search.fitted_chi_square(fit)));
        if known && least > UNEXPLAINED && search.linearised_at_measurement.is_none() {
            meter.expect(sets.len());
            *round = search.begun_at_origin(&self.base, sets, std::mem::take(round));
        }
        let Some(better) = search.elsewhere(&self.base, round) else { return false };
        meter.expect(sets.len());
        *round = search.round(&better, sets, Some(round.as_slice()));
        self.base = better;
        self.interrupted |= search.bench.interrupted();
        true
    }

    /// All effects at once from their own starts, where they do not reach the noise: an effect found alone is bent to do
    /// the work of those found after it, and from there a fit may not come back.
    fn begin_again(&mut self, search: &Search) {
        let effects = self.effects();
        let [before @ .., step] = self.steps.as_mut_slice() else { return };
        if effects.len() < 2 || search.fitted_chi_square(&step.state) < ADEQUATE {
            return;
        }
        if let Ok(again) = search.added(&self.base.fitted.model, &effects)
            && again.fitted.cost < OTHER_MINIMUM * step.state.fitted.cost
            && blocks::gain(search.bench, &step.state.scored, &again.scored).z > -PASSING_Z
        {
            let before = before.last().map_or(&self.base, |step| &step.state);
            step.gain = blocks::gain(search.bench, &before.scored, &again.scored);
            step.error = search.bench.normalised_error(&again.scored);
            step.state = again;
        }
        self.interrupted |= search.bench.interrupted();
    }

    /// Of the ties that the rounds met, keeps those that still stand beside all else that was found.
    fn settle_ties(&mut self, search: &Search) {
        let kept = self.effects();
        let last = self.last().clone();
        for step in &mut self.steps {
            let place = kept.iter().position(|candidate| step.candidates.first() == Some(candidate));
            let Some(place) = place.filter(|_| !step.dropped() && step.candidates.len() == 1) else {
                step.tied.clear();
                continue;
            };
            step.tied.retain(|other| {
                if kept.iter().any(|candidate| candidate.effect == other.effect) {
                    return false;
                }
                if kept.len() == 1 {
                    return true;
                }
                let mut model = last.fitted.model.clone();
                model.effects.remove(search.given + place);
                let replaced = search.added(&model, std::slice::from_ref(other));
                replaced.is_ok_and(|replaced| search.is_tied(&replaced, &last))
            });
        }
    }

    fn best_of(&self, search: &Search, base: &State, round: &[Trial]) -> Option<Added> {
        let best =
            round.iter().filter(|trial| trial.passes()).take(HELD).find(|trial| search.holds(base, trial))?;
        let state = best.state.as_ref().ok()?.clone();
        let tied = search.tied(round).into_iter().filter(|trial| trial.candidates != best.candidates);
        let tied = tied.filter_map(|trial| trial.candidates.first().cloned()).collect();
        let error = search.bench.normalised_error(&state.scored);
        Some(Added {
            candidates: best.candidates.clone(),
            state,
            gain: best.gain,
            error,
            without: Vec::new(),
            vetoed: false,
            tied,
            in_all_seen: false,
        })
    }

    /// The one effect of the first `round` that brings the model to the noise of the fitted records, if no other comes
    /// near it and it comes to the noise of all records seen once it is fitted to them: beside a jump, a record for
    /// selecting may hang on a parameter that the fitted ones hardly show. Whether it is the cause the test records say.
    fn only_explanation(&self, search: &Search, round: &[Trial]) -> Option<Added> {
        search.linearised_at_measurement?;
        let states = round.iter().filter_map(|trial| Some((trial, trial.state.as_ref().ok()?)));
        let mut explaining = states.filter(|(_, state)| search.fitted_chi_square(state) < UNEXPLAINED);
        let (Some((only, fitted)), None) = (explaining.next(), explaining.next()) else { return None };
        let fits = search.fitted_chi_square(fitted) < ADEQUATE;
        if !fits || search.fitted_chi_square(&self.base) < UNEXPLAINED || fitted.chi_square() < ADEQUATE {
            return None;
        }
        let state = search.fitted_to_seen(fitted).filter(|(_, chi_square)| *chi_square < ADEQUATE)?.0;
        Some(Added {
            candidates: only.candidates.clone(),
            gain: blocks::gain(search.bench, &self.base.scored, &state.scored),
            error: search.bench.normalised_error(&state.scored),
            state,
            without: Vec::new(),
            vetoed: false,
            tied: Vec::new(),
            in_all_seen: true,
        })
    }

    /// Where single effects do not reach the noise: two at once, from the best singles of the first round.
    fn try_pairs(&mut self, search: &Search, most: usize, known: bool, meter: &Progress) {
        let poor = !known || self.last().chi_square() > UNEXPLAINED;
        let stuck = if known { poor && self.steps.len() < 2 } else { self.steps.is_empty() };
        if !(poor && stuck) || most < 2 || self.interrupted {
            return;
        }
        let Some(first) = self.rounds.first() else { return };
        let best = self.to_pair(first, known);
        let pairs: Vec<Vec<Candidate>> = (0..best.len())
            .flat_map(|b| (0..b).map(move |a| (a, b)))
            .map(|(a, b)| vec![best[a].clone(), best[b].clone()])
            .filter(|pair| pair[0].effect != pair[1].effect)
            .collect();
        meter.expect(pairs.len());
        let round = search.round(&self.base, &pairs, None);
        self.interrupted |= search.bench.interrupted();
        if let Some(step) = self.best_of(search, &self.base, &round) {
            let over_last = blocks::gain(search.bench, &self.last().scored, &step.state.scored);
            if over_last.passes() {
                self.steps = vec![step];
            }
        }
        self.rounds.push(round);
    }

    /// The candidates of the round `first` that gain most on the validation records; then, where the noise is known, those
    /// that gain most on the fitted ones: what else is missing may spoil the validation records alone.
    fn to_pair(&self, first: &[Trial], known: bool) -> Vec<Candidate> {
        let candidate = |trial: &&Trial| trial.candidates.first().cloned();
        let promising = first.iter().filter(|trial| trial.state.is_ok() && trial.gain.fraction > PROMISING);
        let mut best: Vec<Candidate> = promising.filter_map(|trial| candidate(&trial)).take(PAIRED).collect();
        let far_below = OTHER_MINIMUM * self.base.fitted.cost;
        let costs = first.iter().filter_map(|trial| Some((trial.state.as_ref().ok()?.fitted.cost, trial)));
        let mut fitting: Vec<(f64, &Trial)> = costs.filter(|(cost, _)| known && *cost < far_below).collect();
        fitting.sort_by(|a, b| a.0.total_cmp(&b.0));
        for found in fitting.iter().filter_map(|(_, trial)| candidate(trial)) {
            if best.len() < PAIRED && !best.contains(&found) {
                best.push(found);
            }
        }
        best
    }

    /// Drops effects without which the others do as well.
    fn drop_backward(&mut self, search: &Search) {
        if self.effects().len() < 2 {
            return;
        }
        let given = search.given;
        let mut kept = self.effects();
        let mut present = self.last().clone();
        loop {
            let mut dropped = None;
            for index in 0..kept.len() {
                if kept.len() < 2 || search.bench.interrupted() {
                    break;
                }
                let mut model = present.fitted.model.clone();
                model.effects.remove(given + index);
                let Ok(without) = search.state(&model) else { continue };
                let without = if blocks::gain(search.bench, &without.scored, &present.scored).passes() {
                    search.idle(&present, &without)
                } else {
                    Some(without)
                };
                if let Some(without) = without {
                    dropped = Some((index, without));
                    break;
                }
            }
            let Some((index, without)) = dropped else { break };
            let candidate = kept.remove(index);
            if let Some(step) = self.steps.iter_mut().find(|step| step.candidates.contains(&candidate)) {
                step.without.push(candidate);
            }
            present = without;
            self.shortened = Some(present.clone());
        }
    }

    /// The effects added and not dropped, in the order of the model.
    pub fn effects(&self) -> Vec<Candidate> {
        let kept = |step: &Added| -> Vec<Candidate> {
            step.candidates.iter().filter(|c| !step.without.contains(c)).cloned().collect()
        };
        self.steps.iter().flat_map(kept).collect()
    }

    /// Takes back all effects after the first `count`, which the test records do not confirm; `model` has
    /// those alone.
    pub fn veto(&mut self, search: &Search, count: usize, model: &Model) {
        for candidate in self.effects().split_off(count) {
            if let Some(step) = self.steps.iter_mut().find(|step| step.candidates.contains(&candidate)) {
                step.without.push(candidate);
                step.vetoed = true;
                step.tied.clear();
            }
        }
        self.shortened = search.state(model).ok().or_else(|| self.shortened.take());
    }

    /// The model that the search ended with.
    pub fn last(&self) -> &State {
        let added = self.steps.last().map(|step| &step.state);
        self.shortened.as_ref().or(added).unwrap_or(&self.base)
    }

    /// Whether the last model is none of the steps'.
    pub fn dropped(&self) -> bool {
        self.shortened.is_some()
    }
}
