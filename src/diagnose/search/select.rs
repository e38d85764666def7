//! Forward selection with a backward drop: each candidate in the full simulator, fitted jointly with all else
//! on the fitted records, judged on the validation records.

use rayon::prelude::*;

use super::candidates::{self, Candidate};
use super::selection_path::{ADEQUATE, Added};
use crate::diagnose::measurements::split::Parts;
use crate::diagnose::measurements::weighted_dataset::{Scored, WeightedDataset, mean_square};
use crate::diagnose::refit::prediction_covariance;
use crate::diagnose::refit::trial::{self, Effort, Fitted, Unknown};
use crate::diagnose::residual::blocks::{self, Gain};
use crate::effects::Scales;
use crate::fit::{Parameter, Scale};
use crate::model::Model;

/// Gain over its standard error above which a candidate passes.
pub(in crate::diagnose) const PASSING_Z: f64 = 3.0;
/// Fraction of the squared error that it must remove.
pub(in crate::diagnose) const PASSING_FRACTION: f64 = 0.03;
/// Cost over that of the most promising candidate above which another is not refined to the end.
const USEFUL: f64 = 4.0;
/// Cost over that of the present fit below which a fit from another start has found another minimum.
pub(in crate::diagnose) const OTHER_MINIMUM: f64 = 0.7;
/// Starts that a fit is begun from; of more, those are that come nearest to the data as they are.
const MOST_STARTS: usize = 4;
/// Mean square of the weighted residuals below which a model fits well.
const WELL: f64 = 10.0;
/// Candidates that are refined from all their starts at most, as long as none reaches the noise.
const THOROUGHLY: usize = 3;
/// Cost over that of the present fit below which a fit that was led on has found a deeper minimum.
const DEEPER: f64 = 0.98;
/// Mean square of the weighted residuals below which a fit may be on its way to the noise.
const WITHIN_REACH: f64 = 300.0;
/// Times that a fit is led on from a minimum to a deeper one.
const MOST_LEADS: usize = 4;
/// Combinations of starts that are compared with the data.
const MOST_COMBINATIONS: usize = 320;
/// Largest probable mean square that the uncertainty of the parameters adds, as a multiple of its average.
const CHANCE: f64 = 4.0;
/// Two candidates whose difference is below this many standard errors are tied.
const TIED_Z: f64 = 1.0;

/// Fraction of its range within which a parameter counts as at its bound.
const AT_BOUND: f64 = 1e-3;

/// What all rounds have in common.
#[derive(Clone, Copy)]
pub(in crate::diagnose) struct Search<'a, 'd> {
    pub bench: &'a WeightedDataset<'d>,
    /// The beginnings of the same records, where those say more to a fit that starts far away.
    pub beginnings: Option<&'a WeightedDataset<'d>>,
    /// The records about their measured motions, where motions are solved for.
    pub linearised_at_measurement: Option<&'a WeightedDataset<'d>>,
    pub parts: &'a Parts,
    pub scales: &'a Scales,
    /// The model as given.
    pub origin: &'a Model,
    /// Effects that it came with.
    pub given: usize,
    /// Called after every candidate.
    pub report: &'a (dyn Fn(&str) + Sync),
}

/// A model fitted to the fitted records, with its predictions of the validation records.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct State {
    pub fitted: Fitted,
    pub scored: Vec<Scored>,
}

/// A candidate (or a pair) after its refit.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Trial {
    pub candidates: Vec<Candidate>,
    pub state: Result<State, String>,
    /// Over the model without it, on the validation records.
    pub gain: Gain,
}

/// A candidate after its rough fits.
struct Screened {
    best: Fitted,
    /// What each start led to about the measured motion, where motions are solved for.
    rough: Vec<Fitted>,
}

impl Trial {
    /// Whether its gain is significant and large enough to matter.
    pub fn passes(&self) -> bool {
        self.state.is_ok() && self.gain.passes()
    }

    /// ids, in order.
    pub fn ids(&self) -> Vec<&'static str> {
        self.candidates.iter().map(|candidate| candidate.effect.id).collect()
    }
}

impl State {
    /// Mean square of the weighted residuals on the validation records.
    pub fn chi_square(&self) -> f64 {
        mean_square(&self.scored)
    }
}

impl<'a, 'd> Search<'a, 'd> {
    /// For effects beside those of `origin`, without beginnings.
    pub fn new(
        bench: &'a WeightedDataset<'d>,
        parts: &'a Parts,
        scales: &'a Scales,
        origin: &'a Model,
        report: &'a (dyn Fn(&str) + Sync),
    ) -> Self {
        Self {
            bench,
            beginnings: None,
            linearised_at_measurement: None,
            parts,
            scales,
            origin,
            given: origin.effects.len(),
            report,
        }
    }

    /// The model's unknowns.
    pub fn unknowns(&self, model: &Model) -> Vec<Unknown> {
        candidates::unknowns(model, self.given, self.scales, self.bench.dataset)
    }

    /// Refits `model` and scores it.
    pub fn state(&self, model: &Model) -> Result<State, String> {
        self.refitted(model, Effort::Full)
    }

    /// `model` without a refit, scored.
    pub fn as_it_is(&self, model: &Model) -> Result<State, String> {
        self.refitted(model, Effort::None)
    }

    fn refitted(&self, model: &Model, effort: Effort) -> Result<State, String> {
        let fitted = trial::fit(self.bench, model, &self.unknowns(model), &self.parts.fit, effort)?;
        let mut state = State { fitted, scored: Vec::new() };
        // What fits well deserves a second look where it seems to fail.
        state.scored = if self.fitted_chi_square(&state) < WELL {
            self.bench.score_anew(&state.fitted, &self.parts.select)?
        } else {
            self.bench.score(&state.fitted.model, &self.parts.select)?
        };
        Ok(state)
    }

    /// Tries every set of `sets` beside what `base` has, best first. Of the same tried before, over another base, the
    /// better fit is kept, and nothing is begun again that was begun then.
    pub fn round(&self, base: &State, sets: &[Vec<Candidate>], earlier: Option<&[Trial]>) -> Vec<Trial> {
        let model = &base.fitted.model;
        let Some(earlier) = earlier else { return self.round_from(&self.begun_at(model), base, sets, None) };
        let states = earlier.iter().filter_map(|trial| trial.state.as_ref().ok());
        let reaching = states.filter(|state| self.fitted_chi_square(state) < ADEQUATE);
        let reached = reaching.map(|state| state.fitted.cost).min_by(f64::total_cmp);
        let mut round = self.round_from(&[(model, false)], base, sets, reached);
        let cost = |trial: &Trial| trial.state.as_ref().map_or(f64::INFINITY, |state| state.fitted.cost);
        for trial in &mut round {
            let same = earlier.iter().find(|one| one.candidates == trial.candidates);
            if let Some((same, Ok(state))) = same.map(|same| (same, same.state.as_ref()))
                && cost(same) < cost(trial)
            {
                trial.state = Ok(state.clone());
                trial.gain = blocks::gain(self.bench, &base.scored, &state.scored);
            }
        }
        best_first(&mut round);
        round
    }

    /// The round of `first`, or one from the model as given, where that leads to a far better fit. A refit without an
    /// effect that is there bends all other parameters, and those that the engineer gave may be the nearer ones.
    pub fn begun_at_origin(&self, base: &State, sets: &[Vec<Candidate>], first: Vec<Trial>) -> Vec<Trial> {
        let best = |round: &[Trial]| {
            let states = round.iter().filter_map(|trial| trial.state.as_ref().ok());
            states.map(|state| state.fitted.cost).fold(f64::INFINITY, f64::min)
        };
        let again = self.round_from(&[(self.origin, true)], base, sets, None);
        if best(&again) < OTHER_MINIMUM * best(&first) { again } else { first }
    }

    /// Where the search for effects beside those of `model` begins, and whether as far off: at the model itself and,
    /// where motions are solved for, at the model as given.
    fn begun_at<'m>(&'m self, model: &'m Model) -> Vec<(&'m Model, bool)> {
        let nothing_added = model.effects.len() == self.given;
        let origin =
            (self.linearised_at_measurement.is_some() && nothing_added).then_some((self.origin, true));
        std::iter::once((model, false)).chain(origin).collect()
    }

    /// As [`Search::round`] from the parameters of each of `from`. All are screened; the most promising are refined first,
    /// and the others as long as they can come near them. Where it is `true`, the screen looks at the beginnings of the
    /// records, and the size of each effect that is nearest to the data as it is makes one more start. Where a fit has
    /// `reached` the noise at that cost before, nothing is refined but what can come near it.
    fn round_from(
        &self,
        from: &[(&Model, bool)],
        base: &State,
        sets: &[Vec<Candidate>],
        reached: Option<f64>,
    ) -> Vec<Trial> {
        // Most of the time goes here.
        let screened: Vec<Result<Screened, String>> = sets
            .par_iter()
            .map(|set| {
                let screened = self.screened(from, set);
                let ids: Vec<&str> = set.iter().map(|candidate| candidate.effect.id).collect();
                (self.report)(&ids.join(" + "));
                screened
            })
            .collect();
        let cost = |index: usize| screened[index].as_ref().map_or(f64::INFINITY, |s| s.best.cost);
        let mut order: Vec<usize> = (0..sets.len()).collect();
        order.sort_by(|a, b| cost(*a).total_cmp(&cost(*b)));
        let mut refined: Vec<Option<Result<State, String>>> = vec![None; sets.len()];
        let mut least = reached.unwrap_or(f64::INFINITY);
        let leaders = if reached.is_some() { 0 } else { THOROUGHLY };
        for &index in order.iter().take(leaders) {
            let state = screened[index].as_ref().map_err(Clone::clone).and_then(|s| self.refined(s));
            let enough = state.as_ref().is_ok_and(|state| self.fitted_chi_square(state) < ADEQUATE);
            least = least.min(state.as_ref().map_or(f64::INFINITY, |state| state.fitted.cost));
            refined[index] = Some(state);
            if enough || self.linearised_at_measurement.is_none() {
                break;
            }
        }
        // A screen about the measured motion has been to the minimum: what is far above is not followed.
        let followed = |index: usize| {
            let leading = order.first().map_or(f64::INFINITY, |leader| cost(*leader));
            let most = reached.map_or(USEFUL * leading, |reached| WITHIN_REACH * reached);
            self.linearised_at_measurement.is_none() || cost(index) <= most
        };
        let mut trials: Vec<Trial> = sets
            .par_iter()
            .zip(refined)
            .enumerate()
            .map(|(index, (set, refined))| {
                let state = refined.unwrap_or_else(|| {
                    let effort = if followed(index) { Effort::Below(USEFUL * least) } else { Effort::None };
                    let found = screened[index].as_ref().map_err(Clone::clone);
                    found.and_then(|found| self.refitted(&found.best.model, effort))
                });
                let gain = match &state {
                    Ok(state) => blocks::gain(self.bench, &base.scored, &state.scored),
                    Err(_) => Gain { z: 0.0, fraction: 0.0 },
                };
                Trial { candidates: set.clone(), state, gain }
            })
            .collect();
        best_first(&mut trials);
        trials
    }

    /// The model of `base` at a better minimum than it was found at, if the best fit of `round` leads to one once what
    /// was added is taken away again. From a poor minimum any effect gains that opens a way out of it.
    pub fn elsewhere(&self, base: &State, round: &[Trial]) -> Option<State> {
        let states = round.iter().filter_map(|trial| Some((trial, trial.state.as_ref().ok()?)));
        let (best, state) = states.min_by(|a, b| a.1.fitted.cost.total_cmp(&b.1.fitted.cost))?;
        let mut model = state.fitted.model.clone();
        model.effects.truncate(model.effects.len().saturating_sub(best.candidates.len()));
        let found = self.state(&model).ok()?;
        (found.fitted.cost < OTHER_MINIMUM * base.fitted.cost).then_some(found)
    }

    /// `model` with the candidates of `set`, refitted from all their starts.
    pub fn added(&self, model: &Model, set: &[Candidate]) -> Result<State, String> {
        self.refined(&self.screened(&self.begun_at(model), set)?)
    }

    /// The best of what was screened, fitted to the end; where that does not reach the noise, the best of all that was
    /// found about the measured motion. What fits best there need not lead to the deepest minimum.
    fn refined(&self, screened: &Screened) -> Result<State, String> {
        let state = self.led_on(self.state(&screened.best.model)?);
        if self.fitted_chi_square(&state) < ADEQUATE {
            return Ok(state);
        }
        let below = Effort::Below(state.fitted.cost);
        let others = screened.rough.par_iter().map(|rough| self.refitted(&rough.model, below));
        let others: Vec<Result<State, String>> = others.collect();
        let best = others.into_iter().flatten().min_by(|a, b| a.fitted.cost.total_cmp(&b.fitted.cost));
        let best = best.filter(|best| best.fitted.cost < state.fitted.cost);
        Ok(best.map_or(state, |best| self.led_on(best)))
    }

    /// `state`, led by what fits best about the measured motion from minimum to minimum as long as each is deeper than
    /// the last and does not reach the noise.
    fn led_on(&self, mut state: State) -> State {
        let Some(about) = self.linearised_at_measurement else { return state };
        for _ in 0..MOST_LEADS {
            if !(ADEQUATE..WITHIN_REACH).contains(&self.fitted_chi_square(&state)) {
                break;
            }
            let model = &state.fitted.model;
            let led = trial::fit(about, model, &self.unknowns(model), &self.parts.fit, Effort::Rough);
            let deeper = DEEPER * state.fitted.cost;
            match led.and_then(|led| self.refitted(&led.model, Effort::Below(deeper))) {
                Ok(found) if found.fitted.cost < deeper => state = found,
                _ => break,
            }
        }
        state
    }

    /// Each of the models `from` with the candidates of `set`, fitted roughly from all their starts. Where motions are
    /// solved for, from what fits best about those that were measured.
    fn screened(&self, from: &[(&Model, bool)], set: &[Candidate]) -> Result<Screened, String> {
        let mut best: Result<Fitted, String> = Err("the fit failed from every start".to_owned());
        let mut rough = Vec::new();
        for &(model, far) in from {
            let found = match self.linearised_at_measurement {
                None => {
                    let bench = self.beginnings.filter(|_| far).unwrap_or(self.bench);
                    let found = self.screened_on(bench, Effort::Screen, model, set, far);
                    found.and_then(deepest)
                }
                Some(about) => self.screened_on(about, Effort::Rough, model, set, far).and_then(|found| {
                    rough.extend(found.iter().cloned());
                    let nearest = deepest(found)?;
                    let unknowns = self.unknowns(&nearest.model);
                    trial::fit(self.bench, &nearest.model, &unknowns, &self.parts.fit, Effort::Screen)
                }),
            };
            match (&found, &best) {
                (Ok(found), Ok(best)) if found.cost >= best.cost => {}
                (Err(_), Ok(_)) => {}
                _ => best = found,
            }
        }
        Ok(Screened { best: best?, rough })
    }

    /// The fits from all starts by the predictions of `bench` alone.
    fn screened_on(
        &self,
        bench: &WeightedDataset,
        effort: Effort,
        model: &Model,
        set: &[Candidate],
        far: bool,
    ) -> Result<Vec<Fitted>, String> {
        let fit = &self.parts.fit;
        let ranges: Vec<_> =
            set.iter().map(|candidate| candidate.ranges(self.scales, self.bench.dataset)).collect();
        let starts: Vec<usize> =
            ranges.iter().map(|range| range.first().map_or(1, |r| r.starts.len())).collect();
        let combinations: usize = starts.iter().product();
        let with = |mut number: usize| {
            let mut with = model.clone();
            for ((candidate, ranges), count) in set.iter().zip(&ranges).zip(&starts) {
                with.effects.push(candidate.applied(ranges, number % count));
                number /= count;
            }
            with
        };
        // Of many effects together only so many combinations are looked at.
        let looked_at = (0..combinations).step_by(combinations.div_ceil(MOST_COMBINATIONS).max(1));
        let mut models = self.nearest(bench, looked_at.map(with).collect(), MOST_STARTS);
        if let ([candidate], true) = (set, far) {
            let sizes = candidate.scan(&ranges[0]).into_iter().map(|applied| {
                let mut with = model.clone();
                with.effects.push(applied);
                with
            });
            models.extend(self.nearest(bench, sizes.collect(), 1));
        }
        let screened: Vec<Result<Fitted, String>> = models
            .par_iter()
            .map(|with| trial::fit(bench, with, &self.unknowns(with), fit, effort))
            .collect();
        let (found, failed): (Vec<_>, Vec<_>) = screened.into_iter().partition(Result::is_ok);
        let failure = failed.into_iter().find_map(Result::err);
        let found: Vec<Fitted> = found.into_iter().flatten().collect();
        if found.is_empty() { Err(failure.unwrap_or_default()) } else { Ok(found) }
    }

    /// The `count` of `models` that come nearest to the fitted records of `bench` as they are.
    fn nearest(&self, bench: &WeightedDataset, models: Vec<Model>, count: usize) -> Vec<Model> {
        if models.len() <= count {
            return models;
        }
        let mut apart: Vec<(f64, Model)> = models
            .into_par_iter()
            .map(|model| {
                let scored = bench.score(&model, &self.parts.fit);
                (scored.map_or(f64::INFINITY, |scored| mean_square(&scored)), model)
            })
            .collect();
        apart.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Small effects are near to the data whatever else is wrong: of every size the best is a start, too.
        let size = |model: &Model| model.effects.last().and_then(|effect| effect.values.first().copied());
        let mut sizes = Vec::new();
        let mut starts = Vec::new();
        for (place, (_, model)) in apart.into_iter().enumerate() {
            let new = !sizes.contains(&size(&model));
            sizes.push(size(&model));
            let shaped = model.effects.last().is_some_and(|effect| effect.values.len() > 1);
            if place < count || count > 1 && new && shaped {
                starts.push(model);
            }
        }
        starts
    }

    /// Whether `winner` is better than `other` by less than a standard error.
    pub fn is_tied(&self, other: &State, winner: &State) -> bool {
        blocks::gain(self.bench, &other.scored, &winner.scored).z < TIED_Z
    }

    /// Whether what `trial` gains over `base` stays when both are refitted to all records seen, the effects just
    /// added held at what the fitted records gave them. A record for selecting may depend on a parameter that
    /// those hardly show; an effect that happens to correct it then gains there from every block at once.
    pub fn holds(&self, base: &State, trial: &Trial) -> bool {
        let Ok(state) = &trial.state else { return false };
        let refitted = |model: &Model, first: usize| -> Result<Vec<Scored>, String> {
            let mut unknowns = self.unknowns(model);
            unknowns.retain(|unknown| {
                candidates::effect_of(&unknown.path, model).is_none_or(|(index, _)| index < first)
            });
            Ok(self.refitted_to_seen(model, &unknowns)?.scored)
        };
        let first = state.fitted.model.effects.len().saturating_sub(trial.candidates.len());
        match (refitted(&base.fitted.model, usize::MAX), refitted(&state.fitted.model, first)) {
            (Ok(without), Ok(with)) => blocks::gain(self.bench, &without, &with).passes(),
            _ => false,
        }
    }

    /// The model of `without` where, once it and that of `with`, which has one effect more, are refitted to all records
    /// seen, that effect gains nothing: then it only led the fit out of a poor minimum.
    pub fn idle(&self, with: &State, without: &State) -> Option<State> {
        let refitted = |state: &State| {
            let model = &state.fitted.model;
            self.refitted_to_seen(model, &self.unknowns(model))
        };
        let (more, less) = (refitted(with).ok()?, refitted(without).ok()?);
        if blocks::gain(self.bench, &less.scored, &more.scored).passes() {
            None
        } else {
            self.state(&less.fitted.model).ok()
        }
    }

    /// `state` with its model fitted to all records seen, and its reduced χ² there.
    pub fn fitted_to_seen(&self, state: &State) -> Option<(State, f64)> {
        let parts = Parts { fit: self.parts.seen(), ..self.parts.clone() };
        let wide = Search { parts: &parts, ..*self };
        let fitted = wide.led_on(wide.state(&state.fitted.model).ok()?);
        let left = wide.fitted_chi_square(&fitted);
        Some((self.as_it_is(&fitted.fitted.model).ok()?, left))
    }

    /// `unknowns` of `model` fitted to all records seen, with the predictions of those.
    fn refitted_to_seen(&self, model: &Model, unknowns: &[Unknown]) -> Result<State, String> {
        let seen = self.parts.seen();
        let fitted = trial::fit(self.bench, model, unknowns, &seen, Effort::Full)?;
        let scored = self.bench.score_anew(&fitted, &seen)?;
        Ok(State { fitted, scored })
    }

    /// Whether no other effect does what `step` does, and its parameters have found values within their bounds.
    pub fn stands_alone(&self, step: &Added) -> bool {
        let model = &step.state.fitted.model;
        let first = model.effects.len().saturating_sub(step.candidates.len());
        let inside = |unknown: &Unknown| {
            let own = candidates::effect_of(&unknown.path, model).is_some_and(|(index, _)| index >= first);
            let Parameter { start, lower, upper, scale } = unknown.parameter;
            let place = match scale {
                Scale::Linear => (start - lower) / (upper - lower),
                Scale::Logarithmic => (start / lower).ln() / (upper / lower).ln(),
            };
            !own || !place.is_finite() || (AT_BOUND..1.0 - AT_BOUND).contains(&place)
        };
        step.tied.is_empty() && self.unknowns(model).iter().all(inside)
    }

    /// Mean square of the weighted residuals on the validation records, less what the uncertainty of the parameters makes of
    /// it; looked at only where it is `limit` or more.
    pub fn least_chi_square(&self, state: &State, limit: f64) -> f64 {
        let chi_square = state.chi_square();
        if chi_square < limit {
            return chi_square;
        }
        let (fitted, others) = (&self.parts.fit, &self.parts.select);
        chi_square - self.prediction_variance(self.bench, &state.fitted.model, fitted, others)
    }

    /// What the uncertainty of the parameters of `model`, fitted to the records `fitted`, can make of the mean square of the
    /// weighted residuals of `others`.
    pub fn prediction_variance(
        &self,
        bench: &WeightedDataset,
        model: &Model,
        fitted: &[usize],
        others: &[usize],
    ) -> f64 {
        let variance =
            prediction_covariance::of_predictions(bench, model, &self.unknowns(model), fitted, others);
        variance.map_or(0.0, |variance| CHANCE * variance)
    }

    /// Mean square of the weighted residuals on the fitted records.
    pub fn fitted_chi_square(&self, state: &State) -> f64 {
        let samples: usize =
            self.parts.fit.iter().map(|record| self.bench.lanes[*record].measured.len()).sum();
        2.0 * state.fitted.cost / samples.max(1) as f64
    }

    /// The trials of `round` (best first) that are as good as the best to within a standard error.
    pub fn tied<'t>(&self, round: &'t [Trial]) -> Vec<&'t Trial> {
        let Some((best, Ok(winner))) = round.first().map(|best| (best, best.state.as_ref())) else {
            return Vec::new();
        };
        let mut tied = vec![best];
        for other in &round[1..] {
            let Ok(state) = &other.state else { continue };
            if other.passes() && self.is_tied(state, winner) {
                tied.push(other);
            }
        }
        tied
    }
}

/// The fit of least cost.
fn deepest(fits: Vec<Fitted>) -> Result<Fitted, String> {
    let deepest = fits.into_iter().min_by(|a, b| a.cost.total_cmp(&b.cost));
    deepest.ok_or_else(|| "the fit failed from every start".to_owned())
}

/// What gains most on the validation records first, what failed last.
fn best_first(trials: &mut [Trial]) {
    trials.sort_by(|a, b| {
        let key = |trial: &Trial| (trial.state.is_err(), -trial.gain.fraction);
        let (left, right) = (key(a), key(b));
        left.0.cmp(&right.0).then(left.1.total_cmp(&right.1))
    });
}
