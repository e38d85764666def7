//! The verdict in sentences.

use super::confound;
use super::context::summed;
use super::decision::TakenBack;
use super::{Context, Decision, Tested, Weighed};
use crate::diagnose::diagnosis::{Agreement, Detectable, Errors, Evidence, Verdict};
use crate::diagnose::evidence::{Discrepancy, Measured, Sensitivities};
use crate::diagnose::features;
use crate::effects;
use crate::fit::residual::Appearance;
use crate::model::Structure;

/// Correlation of prediction and measurement below which one of them has the wrong sign.
const OPPOSED: f64 = -0.3;

/// Probability from which an explanation is worth a word.
const LIKELY: f64 = 1e-3;

/// What the sentences of a verdict are made from.
pub(super) struct Explained<'a, 'b, 'd> {
    pub context: &'a Context<'b, 'd>,
    pub weighed: &'a Weighed,
    pub decision: &'a Decision,
    pub tested: &'a Tested,
    pub errors: &'a Errors,
    pub residual: &'a Appearance,
    /// Training and test records together.
    pub all: &'a Measured<'b, 'd>,
}

fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    let digits = if value >= 10.0 || value == value.round() { 0 } else { 2 };
    format!("{value:.digits$} %")
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
    if !matches!(decision.taken_back, Some(TakenBack::Unseen)) {
        reasons.push(others(weighed, decision, context.data.assumptions().certain));
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
    if tested.with.is_nan() && !context.parts.test.is_empty() && !context.bench.interrupted() {
        reasons.push("the test records could not be predicted with that: nothing confirms it".to_owned());
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
    reasons.extend(placed(weighed, decision, context.data.assumptions().certain));
    reasons.extend(opposed(explained));
    reasons.extend(agreed(weighed.agreement));
    if context.bench.interrupted() {
        reasons.push("the search was interrupted: effects that were not tried may fit better".to_owned());
    }
    reasons
}

/// Where effects are that may be at several places, if the place of what is found is not `certain`.
fn placed(weighed: &Weighed, decision: &Decision, certain: f64) -> Option<String> {
    let places = |k: usize| -> Vec<String> {
        let of = |member: &usize| weighed.form(*member).location.as_ref().map(ToString::to_string);
        let mut places: Vec<String> = weighed.sets[k].members.iter().filter_map(of).collect();
        places.sort();
        places
    };
    let ids = weighed.ids(decision.best);
    let mut found = summed(weighed.of_which(|of| of == ids).map(|k| (places(k), weighed.weights[k])));
    let all: f64 = found.iter().map(|(_, weight)| weight).sum();
    found.retain(|(_, weight)| *weight > LIKELY * all);
    found.sort_by(|a, b| b.1.total_cmp(&a.1));
    let open = decision.verdict == Verdict::EffectFound && found.first()?.1 < certain * all;
    let word = |(places, weight): &(Vec<String>, f64)| {
        format!("`{}` ({})", places.join("`, `"), probability(weight / all))
    };
    open.then(|| format!("where it is, is open: {}", found.iter().map(word).collect::<Vec<_>>().join(", ")))
}

/// What fits from other starts say of the parameters told.
fn agreed(agreement: Agreement) -> Option<String> {
    let Agreement { starts, agreeing } = agreement;
    let fits = if starts == 1 { "the fit from another start ends" } else { "the fits from other starts end" };
    match starts - agreeing {
        _ if starts == 0 => None,
        0 => Some(format!("{fits} at the same parameters ({starts} of {starts})")),
        others => Some(format!("{others} of {starts} fits from other starts end elsewhere, and are worse")),
    }
}

/// Whether what is missing beside the likeliest set is a residual of its own, on a contact that is moved as measured.
fn is_disturbed(explained: &Explained) -> bool {
    let Explained { context, weighed, .. } = explained;
    let likeliest =
        (0..weighed.sets.len()).max_by(|a, b| weighed.weights[*a].total_cmp(&weighed.weights[*b]));
    let kind = likeliest.and_then(|k| weighed.sets[k].discrepancy);
    context.model.structure == Structure::Prescribed && kind == Some(Discrepancy::Residual)
}

/// The verdict with its probability.
fn decided(explained: &Explained) -> String {
    let Explained { context, weighed, decision, errors, .. } = explained;
    let assumed = context.data.assumptions();
    let (p, small) = (probability(decision.probability), percent(assumed.relevant));
    let known = context.data.noise_is_known();
    let suggest = if known { "" } else { "if the noise resembles the residual, the data suggest that, " };
    match decision.verdict {
        Verdict::NothingMissing => format!(
            "with a probability of {p} no effect of the catalogue is missing, and nothing else that follows the motion and moves \
             a channel by more than {small} of its variation"
        ),
        Verdict::EffectFound if decision.alone < assumed.certain => format!(
            "{suggest}with a probability of {p}, {} missing; that nothing else is, which moves a channel by more than {small} of \
             its variation, has one of {}",
            named(&weighed.ordered(decision.best)),
            probability(decision.alone)
        ),
        Verdict::EffectFound => format!(
            "{suggest}with a probability of {p}, {} missing, and nothing else that moves a channel by more than {small} of its \
             variation",
            named(&weighed.ordered(decision.best))
        ),
        Verdict::NotDistinguishable => {
            format!("{suggest}with a probability of {p}, something of the catalogue is missing")
        }
        Verdict::Unexplained if decision.taken_back.is_some() => {
            format!("the probabilities alone would say: {}", candidate(weighed, decision.likeliest))
        }
        Verdict::Unexplained if decision.doubt < assumed.certain => format!(
            "the residual is {} of the measured channels' standard deviation: what lowers it stands for the slip of a \
             contact that the model does not have",
            percent(errors.last)
        ),
        Verdict::Unexplained if is_disturbed(explained) => format!(
            "{suggest}with a probability of {p}, the residual is more than the noise that was told, {} of the channels' \
             standard deviation in all, and it does not follow the motion: the noise is larger than told, or the measurement \
             is disturbed; it is largest in `{}`",
            percent(errors.refitted),
            worst(explained)
        ),
        Verdict::Unexplained => format!(
            "{suggest}with a probability of {p}, something is missing that no effect of the catalogue describes; it is largest \
             in `{}`",
            worst(explained)
        ),
        Verdict::InsufficientData => undecided(explained, &p),
    }
}

/// Why there is no verdict.
fn undecided(explained: &Explained, p: &str) -> String {
    let Explained { context, weighed, decision, errors, .. } = explained;
    let certain = context.data.assumptions().certain;
    match decision.taken_back {
        Some(TakenBack::Unseen) => {
            "nothing is seen to be missing, but these data could not show every effect that matters"
                .to_owned()
        }
        Some(_) => {
            format!("the training records alone give a verdict with a probability of {p}; it is taken back")
        }
        None if decision.best == 0 && !context.data.noise_is_known() => format!(
            "the residual is {} of the measured channels' standard deviation. How much of it is noise is not known, so \
             these data do not show whether an effect is missing",
            percent(errors.refitted)
        ),
        None => format!(
            "no explanation reaches a probability of {certain}: the likeliest of the catalogue is that {}; that something outside \
             the catalogue is missing has {}",
            candidate(weighed, decision.best),
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
        TakenBack::Outweighed => {
            "the noise is unknown, and what the likeliest effects leave follows from its own past by more than they explain: \
             coloured noise, or something else that is missing. State the noise, or repeat a record to measure it"
                .to_owned()
        }
        TakenBack::Unexplained => format!(
            "with the test records something is missing that the training records do not show; it is largest in `{}`",
            worst(explained)
        ),
        TakenBack::Unseen => {
            let one = |one: &Detectable| format!("{} ({})", title(one.effect), probability(one.relevant.unwrap_or(1.0)));
            let all: Vec<String> = explained.decision.open.iter().map(one).collect();
            format!(
                "if they are there, these effects may well move a channel by more than {} of its variation (with what \
                 probability): {}; the detection limits say from which size they would be found",
                percent(explained.context.data.assumptions().relevant),
                all.join(", ")
            )
        }
    })
}

fn title(id: &str) -> &str {
    effects::find(id).map_or(id, |effect| effect.title)
}

/// `Backlash is`, `Backlash and Wear are`.
fn named(ids: &[&str]) -> String {
    let titles: Vec<&str> = ids.iter().map(|id| title(id)).collect();
    format!("{} {}", titles.join(" and "), if titles.len() == 1 { "is" } else { "are" })
}

fn candidate(weighed: &Weighed, set: usize) -> String {
    let ids = weighed.ordered(set);
    if ids.is_empty() { "nothing is missing".to_owned() } else { format!("{} missing", named(&ids)) }
}

/// What else has a probability worth a word: effects in any form, with their sum.
fn others(weighed: &Weighed, decision: &Decision, certain: f64) -> String {
    let kind = |k: usize| (weighed.ids(k), weighed.sets[k].discrepancy.is_some());
    let told = |k: usize| match decision.verdict {
        // The verdict is of all sets with something unknown.
        Verdict::Unexplained if decision.doubt >= certain => weighed.sets[k].discrepancy.is_some(),
        Verdict::NotDistinguishable | Verdict::InsufficientData => false,
        _ => kind(k) == kind(decision.likeliest),
    };
    let mut others: Vec<(usize, f64)> = Vec::new();
    for (k, weight) in weighed.weights.iter().enumerate().filter(|(k, _)| !told(*k)) {
        match others.iter_mut().find(|(other, _)| kind(*other) == kind(k)) {
            Some((_, sum)) => *sum += weight,
            None => others.push((k, *weight)),
        }
    }
    others.retain(|(_, weight)| *weight > LIKELY);
    others.sort_by(|a, b| b.1.total_cmp(&a.1));
    let words = others.iter().take(5).map(|&(k, weight)| {
        let unknown = weighed.sets[k].discrepancy.map(|_| "something unknown");
        let names: Vec<&str> = weighed.ordered(k).into_iter().chain(unknown).collect();
        let names = if names.is_empty() { "nothing".to_owned() } else { names.join(" + ") };
        format!("{names} ({})", probability(weight))
    });
    let words = words.collect::<Vec<_>>().join(", ");
    match decision.verdict {
        _ if words.is_empty() => format!("no other explanation has a probability above {LIKELY}"),
        Verdict::NotDistinguishable | Verdict::InsufficientData => format!("what may be missing: {words}"),
        _ => format!("what else may be missing: {words}"),
    }
}

/// Name of the record that the best set describes worst against its noise, of all records.
fn worst(explained: &Explained) -> String {
    let Explained { context, weighed, decision, all, .. } = explained;
    let scored =
        context.bench.score(&weighed.sets[decision.best].posterior.model, &all.records).unwrap_or_default();
    let noise = |record: usize| {
        let own = all.records.iter().position(|r| *r == record).map(|k| {
            let channels = &all.channels[k];
            channels.iter().map(|c| c.prior.deviation / c.size).sum::<f64>() / channels.len().max(1) as f64
        });
        own.filter(|_| all.noise_is_known()).unwrap_or(1.0)
    };
    let size = |one: &crate::diagnose::measurements::weighted_dataset::Scored| {
        context.bench.normalised_error(std::slice::from_ref(one)) / noise(one.record)
    };
    let worst = scored.iter().max_by(|a, b| size(a).total_cmp(&size(b)));
    worst.map_or(String::new(), |one| context.dataset.records[one.record].name.clone())
}

/// Channels that are measured the other way round than they are predicted, with what was found and in every record: a
/// resonance that the model lacks turns those beyond it alone.
fn opposed(explained: &Explained) -> Vec<String> {
    let Explained { context, weighed, decision, .. } = explained;
    let mut relations: Vec<(&str, f64)> = Vec::new();
    for one in context.scored(&weighed.sets[decision.best]) {
        let lane = &context.bench.lanes[one.record];
        for (name, range) in &lane.channels {
            let mut relation = features::Correlation::default();
            range.clone().for_each(|i| relation.add(one.predictions[i], lane.measured[i]));
            let value = relation.value().unwrap_or(0.0);
            match relations.iter_mut().find(|(known, _)| known == name) {
                Some((_, largest)) => *largest = largest.max(value),
                None => relations.push((name, value)),
            }
        }
    }
    let of = |(name, _): &(&str, f64)| {
        format!(
            "`{name}` is measured with the opposite sign to the prediction: check the sign of its sensor and the sign \
             of the excitation"
        )
    };
    relations.iter().filter(|(_, largest)| *largest < OPPOSED).map(of).collect()
}

/// What was seen of the effects, and what else could cause the same.
pub(super) fn evidence(explained: &Explained, sensitivities: &Sensitivities) -> Vec<Evidence> {
    let Explained { context, weighed, decision, .. } = explained;
    let mut named: Vec<&'static str> = weighed.ordered(decision.best);
    for group in &decision.groups {
        named.extend(group.effects.iter().filter(|id| !named.contains(id)).copied().collect::<Vec<_>>());
    }
    // What stands for something unknown is no finding.
    if named.is_empty() || decision.verdict == Verdict::Unexplained {
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
