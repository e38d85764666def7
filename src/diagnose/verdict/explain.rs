//! The verdict in sentences.

use super::confound;
use super::decision::TakenBack;
use super::{Context, Decision, Tested, Weighed};
use crate::diagnose::diagnosis::{Errors, Evidence, Verdict};
use crate::diagnose::evidence::Sensitivities;
use crate::diagnose::features;
use crate::effects;

/// Correlation of prediction and measurement below which one of them has the wrong sign.
const OPPOSED: f64 = -0.3;

/// What the sentences of a verdict are made from.
pub(super) struct Explained<'a, 'b, 'd> {
    pub context: &'a Context<'b, 'd>,
    pub weighed: &'a Weighed,
    pub decision: &'a Decision,
    pub tested: &'a Tested,
    pub errors: &'a Errors,
}

fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    if value >= 10.0 { format!("{value:.0} %") } else { format!("{value:.2} %") }
}

/// A probability in words: no digits beyond those that were ever checked.
fn probability(p: f64) -> String {
    if p > 0.999 { "above 0.999".to_owned() } else { format!("{p:.3}") }
}

/// Why, the most important first.
pub(super) fn reasons(explained: &Explained) -> Vec<String> {
    let Explained { context, weighed, decision, tested, .. } = explained;
    let mut reasons = Vec::new();
    if context.table {
        let values: usize = context.bench.lanes.iter().map(|lane| lane.measured.len()).sum();
        reasons.push(format!(
            "{values} measured value{} {} little evidence, and none can be spared for a test",
            if values == 1 { "" } else { "s" },
            if values == 1 { "is" } else { "are" }
        ));
    }
    reasons.push(decided(explained));
    reasons.extend(taken_back(explained));
    let others = others(weighed, decision.best);
    if !others.is_empty() {
        reasons.push(format!("what else is likely: {others}"));
    }
    if tested.with.is_finite() && decision.best != 0 {
        reasons.push(format!(
            "on the test records the error is {} of the channels' standard deviation with the model as given, {} with \
             this model refitted, and {} with what was added",
            percent(tested.given),
            percent(tested.without),
            percent(tested.with)
        ));
    }
    if let Some(chi_square) = tested.chi_square {
        reasons.push(format!("on the test records the reduced χ² is {chi_square:.2} (1 means noise alone)"));
    }
    if !context.data.noise_is_known() {
        reasons.push(
            "the noise is unknown, since it is not stated and no motion was repeated closely enough to measure it: the \
             probabilities rest on what the residual looks like"
                .to_owned(),
        );
    }
    reasons.extend(decision.groups.iter().map(|group| group.reason.clone()));
    reasons.extend(opposed(explained));
    if context.bench.interrupted() {
        reasons.push("the search was interrupted: effects that were not tried may fit better".to_owned());
    }
    reasons
}

/// The verdict with its probability.
fn decided(explained: &Explained) -> String {
    let Explained { context, weighed, decision, errors, .. } = explained;
    let p = probability(decision.probability);
    let assumed = context.data.assumptions();
    match decision.verdict {
        Verdict::NothingMissing => format!(
            "with a probability of {p} no effect of the catalogue and nothing else that moves a channel by more than {} \
             of its variation is missing",
            percent(assumed.relevant)
        ),
        Verdict::EffectFound => format!(
            "with a probability of {p}{} {} missing, and nothing else that moves a channel by more than {} of its variation",
            if context.data.noise_is_known() { "" } else { ", if the noise resembles the residual," },
            named(&weighed.ordered(decision.best)),
            percent(assumed.relevant)
        ),
        Verdict::NotDistinguishable => {
            format!("with a probability of {p} something of the catalogue is missing")
        }
        Verdict::Unexplained if decision.taken_back.is_some() => {
            format!("the training records alone would say: {}", candidate(weighed, decision.best))
        }
        Verdict::Unexplained if decision.doubt < assumed.certain => format!(
            "the residual is {} of the measured channels' standard deviation: what lowers it stands for the slip of a \
             contact that the model does not have",
            percent(errors.last)
        ),
        Verdict::Unexplained => format!(
            "with a probability of {p} something is missing that no effect of the catalogue describes; it is largest in \
             `{}`",
            worst(explained)
        ),
        Verdict::InsufficientData if decision.taken_back.is_some() => {
            format!("the training records alone give a verdict with a probability of {p}; it is taken back")
        }
        Verdict::InsufficientData if decision.best == 0 && !context.data.noise_is_known() => format!(
            "the residual is {} of the measured channels' standard deviation. How much of it is noise is not known, so \
             these data do not show whether an effect is missing",
            percent(errors.refitted)
        ),
        Verdict::InsufficientData => format!(
            "no explanation reaches a probability of {}; that something outside the catalogue is missing has {}",
            assumed.certain,
            probability(decision.doubt)
        ),
    }
}

fn taken_back(explained: &Explained) -> Option<String> {
    Some(match explained.decision.taken_back? {
        TakenBack::Worse => {
            "the training records alone would name an effect, but it makes the prediction of the test records worse"
                .to_owned()
        }
        TakenBack::Undetermined => {
            "an effect would be named, but the size that it would have has no interval, or one that holds none at all"
                .to_owned()
        }
        TakenBack::Unexplained => format!(
            "with the test records something is missing that the training records do not show; it is largest in `{}`",
            worst(explained)
        ),
    })
}

/// `Backlash is`, `Backlash and Wear are`.
fn named(ids: &[&str]) -> String {
    let titles: Vec<&str> = ids.iter().filter_map(|id| Some(effects::find(id)?.title)).collect();
    format!("{} {}", titles.join(" and "), if titles.len() == 1 { "is" } else { "are" })
}

fn candidate(weighed: &Weighed, set: usize) -> String {
    let ids = weighed.ordered(set);
    if ids.is_empty() { "nothing is missing".to_owned() } else { format!("{} missing", named(&ids)) }
}

/// What else has a probability worth a word: effects in any form, with their sum.
fn others(weighed: &Weighed, best: usize) -> String {
    let kind = |k: usize| (weighed.ids(k), weighed.sets[k].discrepancy.is_some());
    let mut others: Vec<(usize, f64)> = Vec::new();
    for (k, weight) in weighed.weights.iter().enumerate().filter(|(k, _)| kind(*k) != kind(best)) {
        match others.iter_mut().find(|(other, _)| kind(*other) == kind(k)) {
            Some((_, sum)) => *sum += weight,
            None => others.push((k, *weight)),
        }
    }
    others.retain(|(_, weight)| *weight > 1e-3);
    others.sort_by(|a, b| b.1.total_cmp(&a.1));
    let words = others.iter().take(5).map(|&(k, weight)| {
        let ids = weighed.ordered(k);
        let names = if ids.is_empty() { "nothing".to_owned() } else { ids.join(" + ") };
        let doubt = if weighed.sets[k].discrepancy.is_some() { " with something unknown" } else { "" };
        format!("{names}{doubt} ({})", probability(weight))
    });
    words.collect::<Vec<_>>().join(", ")
}

/// Name of the record that the best set describes worst against its noise, of all records.
fn worst(explained: &Explained) -> String {
    let Explained { context, weighed, decision, .. } = explained;
    let records = context.parts.all();
    let scored =
        context.bench.score(&weighed.sets[decision.best].posterior.model, &records).unwrap_or_default();
    let noise = |record: usize| {
        let known = context.data.records.iter().position(|r| *r == record);
        let own = known.map(|k| {
            let channels = &context.data.channels[k];
            channels.iter().map(|c| c.prior.deviation / c.size).sum::<f64>() / channels.len().max(1) as f64
        });
        own.filter(|_| context.data.noise_is_known()).unwrap_or(1.0)
    };
    let size = |one: &crate::diagnose::measurements::weighted_dataset::Scored| {
        context.bench.normalised_error(std::slice::from_ref(one)) / noise(one.record)
    };
    let worst = scored.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    worst.map_or(String::new(), |one| context.dataset.records[one.record].name.clone())
}

/// Channels that are measured the other way round than they are predicted.
fn opposed(explained: &Explained) -> Vec<String> {
    let Explained { context, weighed, .. } = explained;
    let mut names: Vec<&str> = Vec::new();
    for one in context.scored(&weighed.sets[0]) {
        let lane = &context.bench.lanes[one.record];
        for (name, range) in &lane.channels {
            let mut relation = features::Correlation::default();
            range.clone().for_each(|i| relation.add(one.predictions[i], lane.measured[i]));
            if relation.value().is_some_and(|value| value < OPPOSED) && !names.contains(name) {
                names.push(name);
            }
        }
    }
    let of = |name: &str| {
        format!(
            "`{name}` is measured with the opposite sign to the prediction: check the sign of its sensor and the sign \
             of the excitation"
        )
    };
    names.into_iter().map(of).collect()
}

/// What was seen of the effects, and what else could cause the same.
pub(super) fn evidence(explained: &Explained, sensitivities: &Sensitivities) -> Vec<Evidence> {
    let Explained { context, weighed, decision, .. } = explained;
    let mut named: Vec<&'static str> = weighed.ordered(decision.best);
    for group in &decision.groups {
        named.extend(group.effects.iter().filter(|id| !named.contains(id)).copied().collect::<Vec<_>>());
    }
    if named.is_empty() {
        return Vec::new();
    }
    let base = &weighed.sets[0];
    let features = features::of(context.bench, &context.scored(base), context.model, &base.posterior.model);
    named
        .into_iter()
        .filter_map(|id| {
            let seen = (effects::find(id)?.signature)(&features)?;
            Some(Evidence { effect: id, seen, otherwise: otherwise(id, sensitivities) })
        })
        .collect()
}

/// What else would look like the effect `id` in these data.
fn otherwise(id: &str, sensitivities: &Sensitivities) -> Option<String> {
    let mut others: Vec<(f64, &str)> = sensitivities
        .confounding
        .iter()
        .filter(|pair| pair.effects.contains(&id))
        .filter_map(|pair| {
            let other = pair.effects.into_iter().find(|other| *other != id)?;
            Some((pair.correlation.abs(), effects::find(other)?.title))
        })
        .collect();
    others.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (nearest, title) = *others.first()?;
    let alike: Vec<&str> =
        others.iter().filter(|(size, _)| *size > confound::ALIKE).map(|(_, title)| *title).collect();
    Some(if alike.is_empty() {
        format!(
            "nothing else in the catalogue: these data distinguish it from the nearest effect, {title} (correlation \
             {nearest:.2})"
        )
    } else {
        format!("in these data {} would look almost the same", alike.join(", "))
    })
}

/// The experiment that would decide between the explanations that remain.
pub(super) fn next_experiment(explained: &Explained) -> Option<String> {
    let Explained { context, decision, .. } = explained;
    let known = context.data.noise_is_known();
    if context.table {
        return Some(
            "Measure the table again, so that its scatter is known, with levels between those where the frequency \
             changes most and with the damping ratio at each level; or record the acceleration in time at three levels \
             or more"
                .to_owned(),
        );
    }
    match decision.verdict {
        Verdict::NotDistinguishable => decision.groups.first().map(|group| group.experiment.clone()),
        Verdict::EffectFound if !known => Some(
            "Repeat one record, or run it over several periods: only then is it known how much of the residual is noise"
                .to_owned(),
        ),
        Verdict::Unexplained | Verdict::InsufficientData if !known => Some(
            "Repeat one record, or run it over several periods: the difference of the repeats is the noise".to_owned(),
        ),
        Verdict::Unexplained => Some(
            "Look at the residual of the refitted model against displacement, velocity, normal load and time, and \
             repeat the record in which it is largest at half and at twice its speed"
                .to_owned(),
        ),
        Verdict::InsufficientData => Some(
            "Measure more records at levels and frequencies between those there are and a little beyond them".to_owned(),
        ),
        Verdict::NothingMissing | Verdict::EffectFound => None,
    }
}
