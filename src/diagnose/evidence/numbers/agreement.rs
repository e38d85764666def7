//! Whether fits from elsewhere end where a hypothesis is: a minimum is the best one as far as others were looked for.

use rayon::prelude::*;

use crate::diagnose::diagnosis::Agreement;
use crate::diagnose::evidence::again;
use crate::diagnose::evidence::measured::Measured;
use crate::diagnose::evidence::posterior::{LOOK, Posterior, Start, screen};

/// Where another fit starts: multiples of what was found, of the model's own parameters from those given and of what effects
/// brought; or of what one of them brought alone.
#[derive(Clone, Copy)]
struct Elsewhere {
    own: f64,
    brought: f64,
    /// Which; `None` for all.
    by: Option<usize>,
}

const STARTS: [Elsewhere; 2] =
    [Elsewhere { own: 0.0, brought: 0.5, by: None }, Elsewhere { own: -1.0, brought: 2.0, by: None }];

/// Fits `posterior` from elsewhere; a better fit takes its place.
pub(super) fn agreement(data: &Measured, posterior: &Posterior) -> (Posterior, Agreement) {
    best_from(data, posterior, &STARTS)
}

/// A better fit than `of`, which lacks something, from elsewhere, where motions are solved for: a response that jumps as a
/// record begins to slip ends a fit where it cannot be followed. Of several effects each is moved alone, too, beside the others
/// as they are.
pub(in crate::diagnose) fn freed(data: &Measured, of: &Posterior) -> Option<Posterior> {
    if !data.records.iter().any(|record| data.bench.lanes[*record].seed.is_some()) {
        return None;
    }
    let mut effects: Vec<usize> = of.unknowns.iter().filter_map(|unknown| unknown.owner).collect();
    effects.dedup();
    let mut starts = STARTS.to_vec();
    if effects.len() > 1 {
        let alone = |effect| STARTS.map(|start| Elsewhere { own: 1.0, by: Some(effect), ..start });
        starts.extend(effects.into_iter().flat_map(alone));
    }
    let (found, _) = best_from(data, of, &starts);
    (found.log_evidence > of.log_evidence).then_some(found)
}

/// The best fit of `posterior` and those from `starts`, and how many of these agree with it.
fn best_from(data: &Measured, posterior: &Posterior, starts: &[Elsewhere]) -> (Posterior, Agreement) {
    let ends = starts.par_iter().filter_map(|start| end(data, posterior, *start));
    let ends: Vec<Posterior> = ends.collect();
    let left = |of: &Posterior| data.left(&of.predictions);
    let promises = |end: &&Posterior| {
        left(end) < left(posterior) && !is_same(data, &end.predictions, &posterior.predictions)
    };
    let closest = ends.iter().min_by(|a, b| left(a).total_cmp(&left(b))).filter(promises);
    let better = closest.and_then(|end| again(data, end).ok());
    let better = better.filter(|better| better.log_peak > posterior.log_peak);
    let told = better.unwrap_or_else(|| posterior.clone());
    let agreeing = ends.iter().filter(|end| is_same(data, &end.predictions, &told.predictions)).count();
    (told, Agreement { starts: ends.len(), agreeing })
}

/// Where a fit from elsewhere than `posterior` ends.
fn end(data: &Measured, posterior: &Posterior, from: Elsewhere) -> Option<Posterior> {
    let Posterior { model, unknowns, .. } = posterior;
    screen(data, &Start { model, unknowns, y: &start(posterior, from) }, LOOK).ok()
}

/// Where it starts.
fn start(posterior: &Posterior, from: Elsewhere) -> Vec<f64> {
    let start = posterior.unknowns.iter().zip(&posterior.y).map(|(unknown, y)| {
        let (low, high) = unknown.coordinate.bounds();
        let multiple = match unknown.owner {
            None => from.own,
            Some(effect) if from.by.is_none_or(|by| by == effect) => from.brought,
            Some(_) => 1.0,
        };
        unknown.coordinate.times(*y, multiple).clamp(low, high)
    });
    start.collect()
}

/// Whether two predictions differ by nothing that matters.
fn is_same(data: &Measured, a: &[Vec<f64>], b: &[Vec<f64>]) -> bool {
    data.relevance(a, b) < data.assumptions().relevant
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Record, Regime};
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::first;
    use crate::diagnose::evidence::posterior::GLANCE;
    use crate::diagnose::evidence::samples::{beam, steady};
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::predict;
    use crate::model::Model;

    #[test]
    fn a_base_that_stuck_is_freed_where_motions_are_solved_for() {
        let (truth, given) = (beam(1.94e11, 0.4, ""), beam(1.95e11, 0.42, ""));
        let dataset = steady(&truth);
        let bench = WeightedDataset::new(&given, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let found = first(&data, None, &given).and_then(|(first, _)| again(&data, &first)).unwrap();
        assert!(freed(&data, &found).is_none());
        let given_again =
            Start { model: &given, unknowns: &found.unknowns, y: &vec![0.0; found.unknowns.len()] };
        let stuck = screen(&data, &given_again, GLANCE).unwrap();
        // Where a glance left it, and taken for an end.
        let stuck = Posterior {
            predictions: stuck.predictions.iter().map(|of| of.iter().map(|x| 0.7 * x).collect()).collect(),
            log_peak: f64::NEG_INFINITY,
            log_evidence: f64::NEG_INFINITY,
            ..stuck
        };
        let freed = freed(&data, &stuck).unwrap();
        assert!(data.relevance(&freed.predictions, &found.predictions) < 1e-3);
    }

    fn model(stiffness: f64, friction: f64) -> Model {
        Model::parse(&format!(
            "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
             tangential_stiffness = {stiffness}\nfriction_coefficient = {friction}\nnormal_load = 100.0\n"
        ))
        .unwrap()
    }

    #[test]
    fn a_fit_that_stuck_is_freed_and_one_that_did_not_is_agreed_with() {
        let truth = model(2e6, 0.5);
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let mut record = Record {
            name: "r".into(),
            regime: Regime::FromRest,
            use_for: None,
            channels: vec![
                channel("time", "s", (0..300).map(|i| 1e-3 * f64::from(i)).collect()),
                channel("displacement", "m", (0..300).map(|i| 8e-5 * (0.1 * f64::from(i)).sin()).collect()),
                channel("force", "N", vec![0.0; 300]),
            ],
        };
        let clean = predict(&truth, &record).unwrap()[0].values.clone();
        record.channels[2].values =
            clean.iter().enumerate().map(|(i, f)| f + 0.3 * (3.0 * i as f64).sin()).collect();
        let dataset = Dataset { title: None, records: vec![record] };
        let given = model(2.4e6, 0.4);
        let bench = WeightedDataset::new(&given, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0], &[], &[]);
        let found = first(&data, None, &given).and_then(|(first, _)| again(&data, &first)).unwrap();
        let (same, agreement_of) = agreement(&data, &found);
        assert_eq!((same.y, agreement_of), (found.y.clone(), Agreement { starts: 2, agreeing: 2 }));
        // As if of two effects: one moved, the other as it is.
        let mut of_two = found.clone();
        (of_two.unknowns[0].owner, of_two.unknowns[1].owner) = (Some(3), Some(5));
        let halved = of_two.unknowns[1].coordinate.times(of_two.y[1], 0.5);
        let from = Elsewhere { own: 1.0, brought: 0.5, by: Some(5) };
        assert_eq!(start(&of_two, from), [of_two.y[0], halved]);
        assert_ne!(halved, of_two.y[1]);
        // Where it started, and taken for an end.
        let unknowns = found.unknowns.clone();
        let mut stuck =
            screen(&data, &Start { model: &given, unknowns: &unknowns, y: &[0.0, 0.0] }, GLANCE).unwrap();
        stuck.predictions[0].iter_mut().for_each(|f| *f *= 0.7);
        stuck.log_peak = f64::NEG_INFINITY;
        let (freed, _) = agreement(&data, &stuck);
        assert!(data.relevance(&freed.predictions, &found.predictions) < 1e-3);
    }
}
