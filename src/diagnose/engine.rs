//! Stand-in with the signatures of the diagnosis, so that commands and reports can be built beside it.

use super::{
    Cost, Diagnosis, Errors, Noise, NoiseSource, RefitError, Stage, Verdict, Watch, evaluate, refit,
};
use crate::effects::{AppliedEffect, CATALOGUE, Effect, Location, Scales};
use crate::identify::InterruptHook;
use crate::measure::{Dataset, Use};
use crate::model::Model;

/// What a diagnosis tries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DiagnoseOptions {
    /// Ids of the only effects to try; `None` for the whole catalogue.
    pub effects: Option<Vec<String>>,
    /// Effects that may be added at most.
    pub max_effects: usize,
}

impl Default for DiagnoseOptions {
    fn default() -> Self {
        Self { effects: None, max_effects: 3 }
    }
}

/// How a diagnosis is watched and stopped.
#[derive(Clone, Copy, Default)]
pub struct DiagnoseWatch<'a> {
    /// Called when something has been tried, with what is done in words, and how much of how much.
    pub progress: Option<&'a (dyn Fn(&str, usize, usize) + Sync)>,
    /// Asked again and again; `true` ends the diagnosis with what is known.
    pub interrupt: Option<InterruptHook<'a>>,
}

/// Why there is no diagnosis.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum DiagnoseError {
    /// An id that the catalogue does not have.
    #[error("there is no effect `{0}`")]
    UnknownEffect(String),
    /// The model as it is could not be refitted.
    #[error("{0}")]
    Refit(#[from] RefitError),
}

/// A model with an effect added and refitted.
#[derive(Debug, Clone, PartialEq)]
pub struct Added {
    /// The model.
    pub model: Model,
    /// Before, and after.
    pub stages: Vec<Stage>,
}

/// Diagnoses nothing: refits and says so.
///
/// # Errors
/// [`DiagnoseError`].
pub fn diagnose(
    model: &Model,
    dataset: &Dataset,
    options: &DiagnoseOptions,
    watch: DiagnoseWatch,
) -> Result<Diagnosis, DiagnoseError> {
    for id in options.effects.iter().flatten() {
        crate::effects::find(id).ok_or_else(|| DiagnoseError::UnknownEffect(id.clone()))?;
    }
    let baseline = evaluate("as given", model, dataset);
    let told = |done| {
        if let Some(tell) = watch.progress {
            tell("refitting", done, 1);
        }
    };
    told(0);
    let done = refit("refitted", model, dataset, Watch { progress: None, interrupt: watch.interrupt })?;
    told(1);
    let (first, last) = (baseline.error, done.stage.error);
    Ok(Diagnosis {
        verdict: Verdict::InsufficientData,
        reasons: vec!["nothing was tried".to_owned()],
        effects: vec![],
        surrogates: vec![],
        groups: vec![],
        error: Errors {
            baseline: first,
            refitted: last,
            last,
            untouched: f64::NAN,
            untouched_refitted: f64::NAN,
            noise_floor: None,
            untouched_noise_floor: None,
        },
        chi_square: None,
        steps: vec![],
        candidates: vec![],
        rounds: vec![],
        untried: CATALOGUE
            .iter()
            .map(|effect| super::Untried { effect: effect.id, reason: "nothing was tried".to_owned() })
            .collect(),
        confounding: vec![],
        detectable: vec![],
        evidence: vec![],
        next_experiment: None,
        split: vec![Use::Fit; dataset.records.len()],
        noise: vec![Noise {
            record: 0,
            channel: "force".to_owned(),
            deviation: None,
            source: NoiseSource::Unknown,
        }],
        comparison: super::Comparison {
            title: dataset.title.clone().unwrap_or_default(),
            records: dataset.records.clone(),
            stages: vec![baseline, done.stage],
        },
        model: done.model,
        cost: Cost { refits: 1, simulations: 1 },
    })
}

/// Adds an effect at its first start value and refits.
///
/// # Errors
/// [`DiagnoseError`].
pub fn add(
    model: &Model,
    effect: &'static Effect,
    location: Option<Location>,
    dataset: &Dataset,
    watch: DiagnoseWatch,
) -> Result<Added, DiagnoseError> {
    let before = evaluate("as given", model, dataset);
    let values = effect.parameters.iter().map(|p| (p.range)(&Scales::default()).starts[0]).collect();
    let mut with = model.clone();
    with.effects.push(AppliedEffect { effect, location, values });
    let done = refit("with it", &with, dataset, Watch { progress: None, interrupt: watch.interrupt })?;
    Ok(Added { model: done.model, stages: vec![before, done.stage] })
}
