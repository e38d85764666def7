//! The diagnosis of a table of few points: one backbone with a handful of frequencies cannot be split in three.
//! Each point is predicted by a model fitted to the others; the gain of an effect is given with its standard error.

mod leave_out;
mod words;

use rayon::prelude::*;

use self::leave_out::LeftOut;
use super::diagnosis::{Diagnosis, Group, Noise, Step, Untried, Verdict};
use super::engine::{DiagnoseOptions, comparison, cost, stage};
use crate::data::{Dataset, Regime};
use crate::diagnose::measurements::split::{FEWEST_RECORDS, Parts};
use crate::diagnose::measurements::weighted_dataset::mean_square;
use crate::diagnose::residual::blocks::Gain;
use crate::diagnose::search::candidates::{self, Candidate};
use crate::diagnose::search::confound;
use crate::diagnose::search::select::{Search, State, Trial};
use crate::diagnose::verdict;
use crate::effects::{InResonances, Location};
use crate::fit::InterruptHook;
use crate::fit::compare::Nested;
use crate::fit::compare::Stage;
use crate::model::Model;

/// Gain of a step over its standard error, at least.
const PASSING_Z: f64 = 1.0;
/// Fraction of the squared error of the points left out that a step must remove.
const PASSING_FRACTION: f64 = 0.2;
/// Two candidates whose difference is below this many standard errors are tied.
const TIED_Z: f64 = 1.0;
/// Degrees of freedom that must remain after a step.
const FEWEST_FREE: usize = 2;
/// Errors below this fraction of a value are those of the computation.
const RESOLUTION: f64 = 2e-6;

/// Whether `dataset` is tables alone, and too few of them to be split by record.
pub(super) fn applies(dataset: &Dataset) -> bool {
    let records = &dataset.records;
    (1..FEWEST_RECORDS).contains(&records.len())
        && records.iter().all(|record| record.regime == Regime::Backbone && record.use_for.is_none())
}

/// The whole table, for fits as for choices.
pub(super) fn whole(dataset: &Dataset) -> Parts {
    let all: Vec<usize> = (0..dataset.records.len()).collect();
    Parts { fit: all.clone(), select: all, test: Vec::new() }
}

/// What a diagnosis of a table starts from.
pub(super) struct Material<'a> {
    pub model: &'a Model,
    pub dataset: &'a Dataset,
    pub baseline: Stage,
    pub measured: Vec<Noise>,
    pub options: &'a DiagnoseOptions,
    pub interrupt: Option<InterruptHook<'a>>,
}

/// A model fitted to all points, and the points predicted without them.
#[derive(Clone)]
struct Standing {
    state: State,
    unseen: LeftOut,
}

/// A candidate after its refits.
struct Tried {
    trial: Trial,
    standing: Option<Standing>,
}

/// An effect that was kept.
struct Kept {
    candidate: Candidate,
    standing: Standing,
    gain: Gain,
    tied: Vec<Candidate>,
}

/// The rounds.
struct Rounds<'a, 'd> {
    search: &'a Search<'a, 'd>,
    interrupt: Option<InterruptHook<'a>>,
    base: Standing,
    kept: Vec<Kept>,
    rounds: Vec<Vec<Tried>>,
}

/// Forward steps from the refitted model, judged by the points left out.
///
/// # Errors
/// Why the model as it is cannot be fitted to the table.
pub(super) fn diagnose(search: &Search, material: Material) -> Result<Diagnosis, String> {
    let Material { model, dataset, baseline, measured, options, interrupt } = material;
    let values = leave_out::rows(search.bench).iter().map(|row| row.values.len()).sum::<usize>();
    let parameters = search.unknowns(model).len();
    if values < parameters + 1 + FEWEST_FREE {
        let reason = words::too_few(values, parameters);
        return Ok(verdict::insufficient(model, dataset, baseline, measured, search.parts, reason));
    }
    let base = standing(search, interrupt, search.state(model)?)?;
    let (mut tried, mut untried) = candidates::of(model, search.bench);
    if let Some(only) = &options.effects {
        tried.retain(|candidate| only.iter().any(|id| id == candidate.effect.id));
    }
    tried.retain(|candidate| match unseen_in(dataset, candidate) {
        Some(reason) => {
            let effect = candidate.effect.id;
            if untried.iter().all(|known: &Untried| known.effect != effect) {
                untried.push(Untried { effect, reason });
            }
            false
        }
        None => true,
    });
    let mut rounds = Rounds { search, interrupt, base, kept: Vec::new(), rounds: Vec::new() };
    rounds.run(&tried, options.max_effects, values);
    rounds.settle_ties();
    Ok(rounds.diagnosis(model, dataset, baseline, measured, untried))
}

/// Why a table cannot show `candidate`.
fn unseen_in(dataset: &Dataset, candidate: &Candidate) -> Option<String> {
    let damping = dataset.records.iter().any(|record| record.channel("damping_ratio").is_some());
    let counted = candidate.location == Some(Location::Channel("frequency".to_owned()));
    let reason = match candidate.effect.in_resonances {
        InResonances::AllButFrequency if counted => {
            "the frequency is measured by counting against a clock, which has no gain and no offset"
        }
        InResonances::Nothing => "a table of resonances has no time in which a sensor could be late",
        InResonances::DampingAlone if !damping => {
            "damping does not shift a frequency measured at phase resonance; it needs the column `damping_ratio`"
        }
        InResonances::Shown | InResonances::DampingAlone | InResonances::AllButFrequency => return None,
    };
    Some(reason.to_owned())
}

/// `state` with its points predicted one by one without them.
fn standing(search: &Search, interrupt: Option<InterruptHook>, state: State) -> Result<Standing, String> {
    let unseen = leave_out::errors(search, interrupt, &state.fitted.model)?;
    if unseen.squares.iter().all(|square| square.is_finite()) {
        Ok(Standing { state, unseen })
    } else {
        Err("a point left out has no finite prediction".to_owned())
    }
}

impl Standing {
    /// Sum of the squared residuals of the fit.
    fn squares(&self) -> f64 {
        self.state.scored.iter().flat_map(|one| &one.residuals).map(|r| r * r).sum()
    }
}

impl Rounds<'_, '_> {
    fn last(&self) -> &Standing {
        self.kept.last().map_or(&self.base, |kept| &kept.standing)
    }

    /// Mean square of the errors that the computation itself may make.
    fn resolution(&self) -> f64 {
        let of = |value: &f64, weight: &f64| (RESOLUTION * value * weight).powi(2);
        let lanes = &self.search.bench.lanes;
        let count: usize = lanes.iter().map(|lane| lane.measured.len()).sum();
        let sum: f64 = lanes
            .iter()
            .flat_map(|lane| lane.measured.iter().zip(&lane.weights))
            .map(|(v, w)| of(v, w))
            .sum();
        sum / count.max(1) as f64
    }

    /// Whether the residual has nothing that an effect could lower.
    fn exact(&self) -> bool {
        mean_square(&self.last().state.scored) < self.resolution()
    }

    fn run(&mut self, tried: &[Candidate], most: usize, values: usize) {
        while self.kept.len() < most && !self.exact() && !self.search.bench.interrupted() {
            let left: Vec<&Candidate> = tried
                .iter()
                .filter(|candidate| self.kept.iter().all(|kept| kept.candidate != **candidate))
                .filter(|candidate| {
                    let unknowns = self.search.unknowns(&self.last().state.fitted.model).len();
                    unknowns + candidate.effect.parameters.len() + FEWEST_FREE <= values
                })
                .collect();
            let round = self.round(&left);
            let step = self.best_of(&round);
            self.rounds.push(round);
            let Some(step) = step else { break };
            self.kept.push(step);
        }
    }

    /// Every candidate beside what was kept, best first.
    fn round(&self, left: &[&Candidate]) -> Vec<Tried> {
        let before = self.last();
        let mut round: Vec<Tried> = left
            .par_iter()
            .map(|&candidate| {
                let set = vec![candidate.clone()];
                let added = self.search.added(&before.state.fitted.model, &set);
                // What does not even fit better is not worth a refit per point.
                let fits = |state: &State| {
                    mean_square(&state.scored) < (1.0 - PASSING_FRACTION) * mean_square(&before.state.scored)
                };
                let (standing, state) = match added {
                    Ok(state) if !fits(&state) => (None, Ok(state)),
                    Ok(state) => match standing(self.search, self.interrupt, state) {
                        Ok(standing) => (Some(standing.clone()), Ok(standing.state)),
                        Err(reason) => (None, Err(reason)),
                    },
                    Err(reason) => (None, Err(reason)),
                };
                (self.search.report)(candidate.effect.id);
                let none = Gain { z: f64::NAN, fraction: f64::NAN };
                let gain = standing.as_ref().map_or(none, |after| after.unseen.gain_over(&before.unseen));
                Tried { trial: Trial { candidates: set, state, gain }, standing }
            })
            .collect();
        round.sort_by(|a, b| {
            let failed = |tried: &Tried| tried.standing.is_none();
            failed(a).cmp(&failed(b)).then(b.trial.gain.fraction.total_cmp(&a.trial.gain.fraction))
        });
        round
    }

    /// The best of a round if its gain is more than chance would give, with those that do as well.
    fn best_of(&self, round: &[Tried]) -> Option<Kept> {
        let best = round.iter().find(|tried| passes(tried))?;
        let standing = best.standing.clone()?;
        let candidate = best.trial.candidates.first()?.clone();
        let tied = round
            .iter()
            .filter(|other| nearly_passes(other) && other.trial.candidates != best.trial.candidates)
            .filter(|other| other.standing.as_ref().is_some_and(|other| tie(other, &standing)))
            .flat_map(|other| other.trial.candidates.clone())
            .filter(|other| other.effect != candidate.effect)
            .collect();
        Some(Kept { candidate, standing, gain: best.trial.gain, tied })
    }

    /// Of the ties, keeps those that still stand beside all else that was found.
    fn settle_ties(&mut self) {
        let found: Vec<Candidate> = self.kept.iter().map(|kept| kept.candidate.clone()).collect();
        let last = self.last().clone();
        for index in 0..self.kept.len() {
            let mut tied = std::mem::take(&mut self.kept[index].tied);
            tied.retain(|other| found.iter().all(|candidate| candidate.effect != other.effect));
            if index + 1 < found.len() {
                tied.retain(|other| {
                    let mut model = last.state.fitted.model.clone();
                    model.effects.remove(self.search.given + index);
                    let set = std::slice::from_ref(other);
                    let swapped = self.search.added(&model, set);
                    let swapped = swapped.and_then(|state| standing(self.search, self.interrupt, state));
                    swapped.is_ok_and(|swapped| tie(&swapped, &last))
                });
            }
            self.kept[index].tied = tied;
        }
    }

    fn groups(&self) -> Vec<Group> {
        let group = |kept: &Kept| {
            let mut ids = vec![kept.candidate.effect.id];
            for other in &kept.tied {
                if !ids.contains(&other.effect.id) {
                    ids.push(other.effect.id);
                }
            }
            (ids.len() > 1).then(|| Group { reason: words::tied(&ids), ..confound::group(ids) })
        };
        self.kept.iter().filter_map(group).collect()
    }

    /// The sums of squares before and after step `index`.
    fn nested(&self, index: usize) -> Nested {
        let before = if index == 0 { &self.base } else { &self.kept[index - 1].standing };
        let after = &self.kept[index].standing;
        let count = |standing: &Standing| self.search.unknowns(&standing.state.fitted.model).len();
        Nested {
            values: after.unseen.residuals.len(),
            parameters: [count(before), count(after)],
            squares: [before.squares(), after.squares()],
        }
    }

    /// The diagnosis.
    fn diagnosis(
        &self,
        model: &Model,
        dataset: &Dataset,
        baseline: Stage,
        measured: Vec<Noise>,
        untried: Vec<Untried>,
    ) -> Diagnosis {
        let groups = self.groups();
        let ids: Vec<&'static str> = self.kept.iter().map(|kept| kept.candidate.effect.id).collect();
        let verdict = match (ids.is_empty(), groups.is_empty()) {
            (true, _) => Verdict::InsufficientData,
            // What softens a beam without a contact stands for the slip that the model lacks.
            _ if model.contact.is_none() => Verdict::Unexplained,
            (false, true) => Verdict::EffectFound,
            (false, false) => Verdict::NotDistinguishable,
        };
        let mut stages = vec![baseline];
        let mut before = model;
        let names = std::iter::once("refitted".to_owned())
            .chain(self.kept.iter().map(|kept| format!("+ {}", kept.candidate.effect.title)));
        for (name, standing) in
            names.zip(std::iter::once(&self.base).chain(self.kept.iter().map(|kept| &kept.standing)))
        {
            stages.push(stage(&name, &standing.state.fitted, before, dataset));
            before = &standing.state.fitted.model;
        }
        let insufficient = verdict::insufficient(
            model,
            dataset,
            stages[0].clone(),
            measured,
            self.search.parts,
            String::new(),
        );
        let mut error = insufficient.error;
        (error.refitted, error.last) = (stages[1].error, stages[stages.len() - 1].error);
        let mut rounds = self.rounds.iter().map(|round| self.reported(round));
        let steps = self.kept.iter().map(|kept| Step {
            added: vec![kept.candidate.effect.id],
            error: self.normalised(&kept.standing),
            gain_z: kept.gain.z,
            gain_fraction: kept.gain.fraction,
            dropped: false,
        });
        Diagnosis {
            verdict,
            reasons: self.reasons(model, verdict),
            effects: if verdict == Verdict::EffectFound { ids.clone() } else { Vec::new() },
            surrogates: if verdict == Verdict::Unexplained { ids } else { Vec::new() },
            evidence: self.evidence(),
            groups,
            error,
            steps: steps.collect(),
            candidates: rounds.next().unwrap_or_default(),
            rounds: rounds.collect(),
            untried,
            next_experiment: Some(words::next_experiment()),
            comparison: comparison(dataset, stages),
            model: self.last().state.fitted.model.clone().with_effects_free(self.search.given),
            cost: cost(&[Some(self.search.bench)]),
            ..insufficient
        }
    }

    /// Error of the points left out, normalised by the channels' standard deviations.
    fn normalised(&self, standing: &Standing) -> f64 {
        let rows = leave_out::rows(self.search.bench);
        let places = rows.iter().flat_map(|row| row.values.iter().map(|value| (row.record, *value)));
        let squares = places.zip(&standing.unseen.residuals).map(|((record, value), residual)| {
            let lane = &self.search.bench.lanes[record];
            (residual * lane.scales[value] / lane.weights[value]).powi(2)
        });
        (squares.sum::<f64>() / standing.unseen.residuals.len().max(1) as f64).sqrt()
    }

    /// A round for the report, its errors those of the points left out.
    fn reported(&self, round: &[Tried]) -> Vec<super::diagnosis::Candidate> {
        round
            .iter()
            .map(|tried| {
                let mut shown = verdict::reported_one(self.search.bench, &tried.trial, self.search.given);
                if let Some(standing) = &tried.standing {
                    shown.error = self.normalised(standing);
                }
                shown
            })
            .collect()
    }
}

fn passes(tried: &Tried) -> bool {
    tried.standing.is_some() && tried.trial.gain.z > PASSING_Z && tried.trial.gain.fraction > PASSING_FRACTION
}

/// A rival need not pass by itself to make the winner uncertain.
fn nearly_passes(tried: &Tried) -> bool {
    tried.standing.is_some()
        && tried.trial.gain.z > 0.5 * PASSING_Z
        && tried.trial.gain.fraction > PASSING_FRACTION
}

/// Whether `winner` is better than `other` by less than a standard error.
fn tie(other: &Standing, winner: &Standing) -> bool {
    winner.unseen.gain_over(&other.unseen).z < TIED_Z
}
