//! The verdict in sentences.

use super::thresholds;
use crate::diagnose::diagnosis::{Errors, Evidence, Group, Verdict};
use crate::diagnose::features;
use crate::diagnose::residual::maps::Repeated;
use crate::diagnose::residual::remainder::Relation;
use crate::diagnose::search::confound;
use crate::diagnose::search::select::Search;
use crate::diagnose::search::selection_path::{ADEQUATE, Outcome, UNEXPLAINED};
use crate::diagnose::search::sensitivity::Sensitivities;
use crate::effects;
use crate::model::Model;

/// Correlation of prediction and measurement below which one of them has the wrong sign.
const OPPOSED: f64 = -0.3;

/// What the sentences of a verdict are made from.
pub(in crate::diagnose) struct VerdictContext<'a, 'b, 'd> {
    pub search: &'a Search<'b, 'd>,
    pub outcome: &'a Outcome,
    /// The model as given.
    pub given: &'a Model,
    pub error: &'a Errors,
    pub known: bool,
    pub groups: &'a [Group],
    pub verdict: Verdict,
}

fn percent(fraction: f64) -> String {
    let value = 100.0 * fraction;
    if value >= 10.0 { format!("{value:.0} %") } else { format!("{value:.2} %") }
}

/// Why, the most important first.
pub(in crate::diagnose) fn reasons(context: &VerdictContext) -> Vec<String> {
    let VerdictContext { outcome, error, known, .. } = context;
    let findings = &outcome.findings;
    let mut reasons = Vec::new();
    let chosen = findings.base.chi_square();
    match (context.verdict, outcome.chi_square) {
        (Verdict::NothingMissing, Some(chi_square)) => reasons.push(format!(
            "the refitted model has a reduced χ² of {chi_square:.2} on the test records, and {}",
            nothing_gained(outcome)
        )),
        (Verdict::NothingMissing, None) => reasons.push(format!(
            "on the test records the residual of the refitted model is {} of the measured channels' standard \
             deviation: whatever the noise is, nothing remains to be explained",
            percent(error.test)
        )),
        (Verdict::Unexplained, Some(chi_square)) => reasons.push(unexplained(outcome, context.search, chi_square)),
        (Verdict::Unexplained, None) => reasons.push(format!(
            "the residual is {} of the measured channels' standard deviation. How much of it is noise is not known, so \
             these data do not show whether an effect is missing. {}",
            percent(error.last),
            if findings.effects().is_empty() {
                "No effect of the catalogue lowers it significantly"
            } else {
                "The residual is still too large with the effects that were added, so no effect is named"
            }
        )),
        _ => {}
    }
    if outcome.within_covariance {
        reasons.push(
            "the model explains the training and validation records. The uncertainty of the parameters alone could \
             cause the residual of the test records, so the model may be complete"
                .to_owned(),
        );
    }
    for step in &findings.steps {
        let names: Vec<&str> = step.candidates.iter().map(|candidate| candidate.effect.title).collect();
        let fate = match (step.without.is_empty(), step.vetoed) {
            (true, _) => String::new(),
            (false, false) => {
                "; removed again at the end: without it the error is not significantly larger".to_owned()
            }
            (false, true) => format!(
                "; {} is taken back, since the test records do not confirm it",
                step.without.iter().map(|c| c.effect.title).collect::<Vec<_>>().join(" with ")
            ),
        };
        let how = match step.in_all_seen {
            true => {
                ", when the model is fitted to them as well: no other effect lowers the error of the training records to the noise"
            }
            false => "",
        };
        reasons.push(format!(
            "{} removes {} of the squared error of the validation records, {:.0} standard errors above zero{how}{fate}",
            names.join(" with "),
            percent(step.gain.fraction),
            step.gain.z
        ));
    }
    if !findings.effects().is_empty() {
        reasons.push(format!(
            "on the test records the error is {} of the channels' standard deviation with the model as given, {} with \
             this model refitted, and {} with what was added",
            percent(outcome.given),
            percent(error.test_refitted),
            percent(error.test)
        ));
    }
    match outcome.chi_square {
        Some(chi_square) if context.verdict == Verdict::EffectFound && chi_square > ADEQUATE => reasons.push(format!(
            "a small part remains unexplained: the reduced χ² is {chi_square:.2}"
        )),
        Some(chi_square) if context.verdict == Verdict::EffectFound => {
            reasons.push(format!("the residual is noise: the reduced χ² is {chi_square:.2}"));
        }
        None if context.verdict == Verdict::EffectFound => reasons.push(format!(
            "on the test records the residual is {} of the channels' standard deviation; how much of it is noise is \
             unknown, since no motion was repeated closely enough to measure the noise",
            percent(error.test)
        )),
        _ => {}
    }
    if outcome.chi_square.is_some_and(|chi| (ADEQUATE..UNEXPLAINED).contains(&chi))
        && !outcome.follows.is_empty()
    {
        reasons.push(format!(
            "the residual of the test records is not noise alone: it follows {}",
            outcome.follows.join(", ")
        ));
    }
    if let Some(repeated) = outcome.repeated.filter(|_| context.verdict != Verdict::Unexplained) {
        reasons.push(format!("{}, though it is small", repeats(repeated)));
    }
    reasons.extend(context.groups.iter().map(|group| group.reason.clone()));
    if *known && context.verdict == Verdict::NothingMissing && chosen > ADEQUATE {
        reasons.push(format!("on the validation records the reduced χ² is {chosen:.2}"));
    }
    let most = outcome.chi_square.map_or(f64::NAN, |chi_square| chi_square.max(chosen));
    if *known && context.verdict == Verdict::NothingMissing && most > UNEXPLAINED {
        reasons.push(
            "noise alone can cause this value: the noise is correlated over a long time, and these records hold few \
             independent values of it; measure longer records"
                .to_owned(),
        );
    }
    reasons.extend(opposed(context.search, outcome));
    if findings.interrupted {
        reasons.push("the search was interrupted: effects that were not tried may fit better".to_owned());
    }
    reasons
}

/// Channels that are measured the other way round than they are predicted.
fn opposed(search: &Search, outcome: &Outcome) -> Vec<String> {
    let mut names: Vec<&str> = Vec::new();
    for one in &outcome.findings.base.scored {
        let lane = &search.bench.lanes[one.record];
        for (name, range) in &lane.channels {
            let (predicted, measured) = (&one.predictions[range.clone()], &lane.measured[range.clone()]);
            let mut relation = Relation::default();
            relation.add(predicted, measured);
            if relation.value() < OPPOSED && !names.contains(name) {
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

/// What the candidates of the first round came to, where the noise explains the residual.
fn nothing_gained(outcome: &Outcome) -> String {
    let best = outcome.findings.rounds.first().and_then(|round| round.iter().find(|trial| trial.passes()));
    match best {
        None => format!("no effect of the catalogue gains {} on the validation records", thresholds()),
        Some(best) => format!(
            "the best effect of the catalogue, {}, removes {} of a squared error that is no larger than the noise",
            best.ids().join(" + "),
            percent(best.gain.fraction)
        ),
    }
}

/// A reduced χ².
fn times(chi_square: f64) -> String {
    if chi_square < 1e4 { format!("{chi_square:.1}") } else { format!("{chi_square:.0e}") }
}

/// Why the data are not explained, though the noise is known.
fn unexplained(outcome: &Outcome, search: &Search, test: f64) -> String {
    let selecting = outcome.selecting;
    let (chi_square, records) = match (test > UNEXPLAINED, selecting > UNEXPLAINED, outcome.repeated) {
        (true, _, _) => (test, "the test records"),
        (_, true, _) if selecting < outcome.findings.last().chi_square() => {
            (selecting, "the validation records, less what the uncertainty of the parameters explains,")
        }
        (_, true, _) => (selecting, "the validation records"),
        _ if outcome.left.is_some_and(|left| left.is_too_much()) => return at_worst(outcome, search),
        (_, _, Some(repeated)) => return format!("{}, so it is not noise", repeats(repeated)),
        _ => (test, "the test records"),
    };
    format!(
        "the reduced χ² of {records} is {}; above {UNEXPLAINED} a model does not explain its data, and the effects \
         that were added only absorb error; it is largest in `{}`: {}",
        times(chi_square),
        worst(outcome, search).0,
        times(worst(outcome, search).1)
    )
}

/// Name of the record that the model describes worst, and what it leaves there.
fn worst<'d>(outcome: &Outcome, search: &Search<'_, 'd>) -> (&'d str, f64) {
    let (record, left) = outcome.left.map_or((0, f64::NAN), |left| left.worst);
    (search.bench.dataset.records.get(record).map_or("", |record| &record.name), left)
}

/// The record that the model describes worst, where the others look explained.
fn at_worst(outcome: &Outcome, search: &Search) -> String {
    let Some(left) = outcome.left else { return String::new() };
    let name = worst(outcome, search).0;
    format!(
        "the reduced χ² over the training and validation records is {}, and {} in `{name}`: look at that record first, \
         at what only this record has (its level, its speed, a fault of its measurement)",
        times(left.seen),
        times(left.worst.1)
    )
}

fn repeats(repeated: Repeated) -> String {
    format!(
        "the residual repeats from record to record: as a function of {}, taken from the training and validation \
         records, it removes {} of the squared residual of the test records, {:.0} standard errors above zero",
        repeated.view,
        percent(repeated.gain.fraction),
        repeated.gain.z
    )
}

/// What was seen of the effects, and what else could cause the same.
pub(in crate::diagnose) fn evidence(
    context: &VerdictContext,
    ids: &[&'static str],
    sensitivities: &Sensitivities,
) -> Vec<Evidence> {
    let mut named: Vec<&'static str> = ids.to_vec();
    for group in context.groups {
        named.extend(group.effects.iter().filter(|id| !ids.contains(*id)));
    }
    if named.is_empty() {
        return Vec::new();
    }
    let features = features::of(context.search, context.given, &context.outcome.findings.base);
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
pub(in crate::diagnose) fn next_experiment(context: &VerdictContext, _: &Sensitivities) -> Option<String> {
    match context.verdict {
        Verdict::NotDistinguishable => context.groups.first().map(|group| group.experiment.clone()),
        Verdict::EffectFound if !context.known => Some(
            "Repeat one record, or run it over several periods: only then is it known how much of the residual is \
             noise"
                .to_owned(),
        ),
        Verdict::Unexplained if !context.known => Some(
            "Repeat one record, or run it over several periods: the difference of the repeats is the noise".to_owned(),
        ),
        Verdict::Unexplained if context.outcome.within_covariance => Some(
            "Measure more records like the test records, with levels and frequencies a little above and a little below \
             theirs: then the parameters are known well enough to decide whether an effect is missing"
                .to_owned(),
        ),
        Verdict::Unexplained => Some(
            "Look at the residual of the refitted model against displacement, velocity, normal load and time, and \
             repeat the record in which it is largest at half and at twice its speed"
                .to_owned(),
        ),
        _ => None,
    }
}
