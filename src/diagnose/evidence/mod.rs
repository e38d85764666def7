//! One score: the evidence of sets of effects. Records and candidates come in, sets with their probabilities go out.
//!
//! A hypothesis is a model with a set of effects, and possibly a `discrepancy` that stands for what the catalogue
//! lacks. Its `unknown`s have priors in units of the problem (`Assumptions` hold all that decides), the noise is
//! `autoregression` with a size per record (`noise_prior`, `measured`). `joint` is the sum of squares of all that is unknown, over
//! `slot`s of one record each (`starts`: their unknown past) and with what a discrepancy adds (`latent`); `posterior`
//! is its minimum with the volume around it, `probe` what amounts of each candidate would change to first order. `search`
//! grows `set`s from none by first `looks` and whole fits, and `neighbours` makes sure of the likely ones; `weights` makes
//! probabilities of their evidence, `limits` tells what could not have been seen. `numbers` makes sure of those
//! of the base and of the decided one, which are told.

mod autoregression;
mod discrepancy;
mod joint;
mod latent;
mod limits;
mod looks;
mod measured;
mod neighbours;
mod noise_prior;
mod numbers;
mod posterior;
mod probe;
#[cfg(test)]
mod samples;
mod search;
mod set;
mod slot;
mod starts;
mod unknown;
mod weights;

pub(super) use discrepancy::Discrepancy;
pub(super) use limits::{Sensitivities, around};
pub(super) use measured::Measured;
pub(super) use numbers::{freed, intervals, steps_needed};
pub(super) use posterior::{Posterior, Solutions};
pub(super) use probe::Prepared;
pub(super) use search::Search;
pub(super) use set::Set;

use joint::Joint;
use latent::Latent;
use posterior::{HERE, INTERVAL, LOOK, Start, fit, screen, screened, white_round};
use probe::Sorted;
use unknown::Unknown;

use super::candidates::Candidate;
use super::diagnosis::Agreement;
use super::measurements::weighted_dataset::WeightedDataset;
use crate::data::Dataset;
use crate::effects::Scales;
use crate::model::Model;

/// Deviations from none that no other width of the likelihood makes up for: more than those it is followed over.
const CLEAR: f64 = 100.0;

/// All sets of effects that were weighed.
pub(super) struct Weighed {
    /// The empty one first.
    pub sets: Vec<Set>,
    /// Their probabilities.
    pub weights: Vec<f64>,
    /// Their probabilities if nothing outside the catalogue is missing.
    pub within: Vec<f64>,
    /// What could be a member.
    pub candidates: Vec<Prepared>,
    /// What changes nothing in these data, whatever its size.
    pub silent: Vec<Candidate>,
    /// What nothing can be predicted with.
    pub unpredictable: Vec<Candidate>,
    /// What other starts say of the set that is told.
    pub agreement: Agreement,
}

impl Weighed {
    /// Makes sure of the parameters of the set that was `decided` for: no better fit lies near, they are in the middle of the
    /// likelihood, the error of predictions is no part of them, and they allow for the noise that drove the model; why not, if
    /// they do not. Only of what is told, after the decision: all sets were compared by the same predictions. `whole` are all
    /// samples of those records, where `data` are not.
    pub fn assure(&mut self, decided: usize, data: &Measured, whole: Option<&Measured>) -> Option<String> {
        if data.bench.interrupted() {
            return None;
        }
        let (agreement, reason) = numbers::assure(data, whole, &mut self.sets[decided].posterior);
        self.agreement = agreement;
        reason
    }

    /// Has the numbers of the set that was `decided` for allow for the noise of the inputs alone; why they do not, if so. Of a model
    /// that lacks something the likelihood says little.
    pub fn allow_for_inputs(&mut self, decided: usize, data: &Measured) -> Option<String> {
        if data.bench.interrupted() {
            return None;
        }
        numbers::allow_for_inputs(data, &mut self.sets[decided].posterior)
    }

    /// Whether all members of set `k` have a size, by intervals that hold.
    pub fn is_determined(&self, k: usize, data: &Measured) -> bool {
        let Set { posterior, members, .. } = &self.sets[k];
        let all = |of: &Posterior, least: f64| members.iter().all(|member| of.determines(*member, least));
        let mut told = posterior.clone();
        all(posterior, INTERVAL) && {
            if all(posterior, CLEAR) {
                numbers::allow_for_inputs(data, &mut told);
            } else {
                intervals(data, &mut told);
            }
            all(&told, INTERVAL)
        }
    }

    /// Tells the model without effects as `fitted`, where that leaves less: a residual that is no noise draws a fit that
    /// takes it for one away from what was measured.
    pub fn refitted_as(&mut self, fitted: Posterior, data: &Measured) {
        let known = &mut self.sets[0].posterior;
        if data.left(&fitted.predictions) < data.left(&known.predictions) {
            // Sets are compared by whole fits.
            let Posterior { log_evidence, log_peak, .. } = *known;
            *known = Posterior { log_evidence, log_peak, ..fitted };
            numbers::allow_for_inputs(data, known);
        }
    }
}

/// `model` refitted as it is: from where it is or, where motions are solved for, from what fits best about those that
/// were measured; with the solutions there.
pub(super) fn first(
    data: &Measured,
    about_measured: Option<&Measured>,
    model: &Model,
) -> Result<(Posterior, Solutions), String> {
    let unknowns = unknown::of_model(model, data.assumptions());
    let zeros = vec![0.0; unknowns.len()];
    let from = |y: &[f64]| screened(data, &Start { model, unknowns: &unknowns, y }, LOOK);
    let direct = from(&zeros);
    let start = Start { model, unknowns: &unknowns, y: &zeros };
    let about = about_measured.and_then(|about| screen(about, &start, LOOK).ok());
    match (direct, about.and_then(|about| from(&about.y).ok())) {
        (Ok(direct), Some(led)) if direct.0.log_evidence >= led.0.log_evidence => Ok(direct),
        (_, Some(led)) => Ok(led),
        (direct, None) => direct,
    }
}

/// Why no fit of `model` to `record` alone can start, if none can.
pub(super) fn no_start(bench: &WeightedDataset, model: &Model, record: usize) -> Option<String> {
    let data = Measured::new(bench, &[record], &[], &[]);
    let (unknowns, latent) = (unknown::of_model(model, data.assumptions()), Latent::default());
    let start = || {
        let mut joint = Joint::new(&data, model, &unknowns, &latent)?;
        white_round(&mut joint, &vec![0.0; unknowns.len()], HERE)
    };
    start().err()
}

/// A hypothesis fitted to `data` from where it was.
pub(super) fn again(data: &Measured, from: &Posterior) -> Result<Posterior, String> {
    let Posterior { model, unknowns, y, .. } = from;
    fit(data, &Start { model, unknowns, y: &y[..unknowns.len()] }, &Latent::default(), None)
}

/// What hypotheses are fitted to.
pub(super) struct Question<'q, 'a, 'd> {
    pub data: &'q Measured<'a, 'd>,
    /// The same with predictions about the measured motions, where motions are solved for.
    pub looks: Option<&'q Measured<'a, 'd>>,
    /// Beginnings of the same records, the shortest first, where those are long.
    pub beginnings: &'q [Measured<'a, 'd>],
    pub dataset: &'d Dataset,
    pub scales: &'q Scales,
}

/// Weighs the sets of `tried` beside `base`.
pub(super) fn weigh(
    question: &Question,
    base: Posterior,
    tried: &[Candidate],
    most: usize,
    report: &(dyn Fn(&str) + Sync),
) -> Result<Weighed, String> {
    let Question { data, looks, beginnings, dataset, scales } = *question;
    let Sorted { prepared: candidates, silent, unpredictable } =
        probe::prepare(data, &base, tried, scales, dataset)?;
    let search = Search { data, looks, beginnings, candidates: &candidates, most, report };
    let sets = search.run(base);
    let weights = weights::of(data, &sets, &candidates);
    let sane: Vec<usize> = (0..sets.len()).filter(|k| sets[*k].discrepancy.is_none()).collect();
    let named: Vec<Set> = sane.iter().map(|k| sets[*k].clone()).collect();
    let mut within = vec![0.0; sets.len()];
    sane.iter().zip(weights::of(data, &named, &candidates)).for_each(|(k, weight)| within[*k] = weight);
    let agreement = Agreement::default();
    Ok(Weighed { sets, weights, within, candidates, silent, unpredictable, agreement })
}

/// The best fit with one of `candidates` beside `base`, from every start that promises something.
pub(super) fn added(
    question: &Question,
    base: &Posterior,
    candidates: &[Candidate],
) -> Result<Posterior, String> {
    let Question { data, looks, beginnings, dataset, scales } = *question;
    let candidates = probe::prepare(data, base, candidates, scales, dataset)?.prepared;
    let report = |_: &str| {};
    let search = Search { data, looks, beginnings, candidates: &candidates, most: 1, report: &report };
    search.alone(base).ok_or_else(|| "the effect changes nothing in these records".to_owned())
}

/// Log evidence of a discrepancy beside a hypothesis over that of none; positive where something relevant is missing.
pub(super) fn doubt(data: &Measured, of: &Posterior) -> Result<f64, String> {
    let doubt = discrepancy::about(data, of)?;
    let matters = doubt.kind.matters(data, &doubt.predictions, &of.predictions);
    Ok(if matters { doubt.log_evidence - of.log_evidence } else { f64::NEG_INFINITY })
}

/// Log evidence that the residual of `predictions`, however small, is more than the noise that is known.
pub(super) fn beyond_noise(data: &Measured, predictions: &[Vec<f64>]) -> f64 {
    discrepancy::larger_noise(data, predictions, |_| true).map_or(f64::NEG_INFINITY, |(gain, _)| gain)
}

/// `model` with those of its parameters that `free` names fitted to one record.
pub(super) fn alone(
    bench: &WeightedDataset,
    model: &Model,
    record: usize,
    free: impl Fn(&str, f64) -> bool,
) -> Result<Model, String> {
    let data = Measured::new(bench, &[record], &[], &[]);
    let parameters = model.parameters().into_iter().filter(|p| free(&p.path, p.value));
    let unknowns: Vec<Unknown> = parameters.map(|p| Unknown::of(&p, data.assumptions())).collect();
    let zeros = vec![0.0; unknowns.len()];
    Ok(screen(&data, &Start { model, unknowns: &unknowns, y: &zeros }, LOOK)?.model)
}
