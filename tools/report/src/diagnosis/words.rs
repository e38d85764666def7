//! A diagnosis in sentences for an engineer.

use stickslip::data::Use;
use stickslip::diagnose::{
    Candidate, DiagnoseOptions, Diagnosis, Estimate, NoiseSource, Skipped, Untried, Verdict,
};
use stickslip::effects::{self, Effect};

use super::Run;
use crate::comparison::floors::{self, Against};
use crate::comparison::summary;
use crate::format;

/// The name of an effect for people.
pub fn title(id: &str) -> String {
    effects::find(id).map_or_else(|| id.replace('_', " "), |effect| effect.title.to_owned())
}

/// Several names: `Backlash`, `Backlash and Wear`, `A, B and C`.
pub fn titles(ids: &[&str], last: &str) -> String {
    let all: Vec<String> = ids.iter().map(|id| title(id)).collect();
    match &all[..] {
        [] => "nothing".to_owned(),
        [only] => only.clone(),
        [before @ .., end] => format!("{} {last} {end}", before.join(", ")),
    }
}

/// The verdict in a word or two.
pub fn badge(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.verdict {
        Verdict::NothingMissing => "Nothing is missing",
        Verdict::EffectFound if !diagnosis.noise_is_known => "Effect likely",
        Verdict::EffectFound => "Effect found",
        Verdict::NotDistinguishable => "Not distinguishable",
        Verdict::Unexplained => "Unexplained",
        Verdict::InsufficientData => "Insufficient data",
    }
}

/// The candidate as a name: its effects, where it sits, and the law that shows it.
pub fn candidate(candidate: &Candidate) -> String {
    let names = titles(&candidate.effects, "and");
    let place = candidate.location.as_ref().map(|location| format!(" at {location}")).unwrap_or_default();
    let law = candidate.law.map(|law| format!(" (law {law})")).unwrap_or_default();
    format!("{names}{place}{law}")
}

/// Whether the candidate was fitted: one that promised too little was not, and its error is that of the model without it.
pub fn was_fitted(candidate: &Candidate) -> bool {
    !candidate.parameters.is_empty()
}

/// The effects that the model has in the end.
fn added(diagnosis: &Diagnosis) -> &[&'static str] {
    if diagnosis.effects.is_empty() { &diagnosis.surrogates } else { &diagnosis.effects }
}

/// Whether `candidate` is one of several effects in the end: its parameters are then those of the end.
pub fn is_part_of_the_end(candidate: &Candidate, diagnosis: &Diagnosis) -> bool {
    let end = added(diagnosis);
    candidate.effects.len() < end.len() && is_within(&candidate.effects, end)
}

/// The parameters of `effect` with all that was added, or alone where nothing was.
pub fn in_the_end<'d>(effect: &Effect, diagnosis: &'d Diagnosis) -> Vec<&'d Estimate> {
    let end = added(diagnosis);
    let all = || diagnosis.rounds.iter().rev().flatten().chain(&diagnosis.candidates);
    let whole = |one: &&Candidate| one.effects.len() == end.len() && is_within(&one.effects, end);
    let alone = |one: &&Candidate| one.effects == [effect.id];
    let fitted = all().filter(|one| was_fitted(one));
    let found = fitted
        .clone()
        .find(|one| end.contains(&effect.id) && whole(one))
        .or_else(|| fitted.clone().find(alone));
    // A law that shows an effect has parameters of its own.
    let own = |candidate: &Candidate, name: &str| {
        candidate.effects.len() == 1
            || effect.parameters.iter().any(|parameter| parameter.quantity.name == name)
    };
    found
        .into_iter()
        .flat_map(|one| one.parameters.iter().filter(|estimate| own(one, &estimate.name)))
        .collect()
}

fn is_within(some: &[&str], all: &[&str]) -> bool {
    some.iter().all(|id| all.contains(id))
}

/// An effect that was not tried; at one place, where it was at another.
pub fn untried(one: &Untried, diagnosis: &Diagnosis) -> String {
    let tried = diagnosis.candidates.iter().any(|candidate| candidate.effects == [one.effect]);
    format!("{}{}", title(one.effect), if tried { ", at other places than above" } else { "" })
}

/// The verdict in one sentence or two, with the numbers that it rests on, after what was found before any fit.
pub fn verdict(diagnosis: &Diagnosis) -> String {
    crate::comparison::findings::before_all(&diagnosis.comparison.findings) + &decided(diagnosis)
}

fn decided(diagnosis: &Diagnosis) -> String {
    let found = titles(&diagnosis.effects, "and");
    let be = if diagnosis.effects.len() == 1 { "is" } else { "are" };
    // Where the noise is unknown, the words are weaker.
    let likely = if diagnosis.noise_is_known { "" } else { "probably " };
    match diagnosis.verdict {
        Verdict::NothingMissing => format!(
            "These data show no missing effect. With refitted parameters the error of the model is {}.{}",
            format::error(diagnosis.error.refitted),
            floor(diagnosis)
        ),
        Verdict::EffectFound => {
            let law = diagnosis.law.map(|law| format!(", described by law = \"{law}\"")).unwrap_or_default();
            format!(
                "{found} {be} {likely}missing from the model{law}. {}{}",
                fall(diagnosis),
                floor(diagnosis)
            )
        }
        Verdict::NotDistinguishable => format!(
            "An effect is {likely}missing, but these data cannot distinguish between the candidates: {}.{}",
            groups(diagnosis),
            floor(diagnosis)
        ),
        Verdict::Unexplained => format!(
            "{}{}{}",
            if diagnosis.noise_is_known {
                "The model lacks something, and none of the effects that were tried explains it."
            } else {
                "The data suggest that the model lacks something that none of the effects that were tried explains."
            },
            if diagnosis.steps.is_empty() { String::new() } else { format!(" {}", fall(diagnosis)) },
            floor(diagnosis)
        ),
        Verdict::InsufficientData if diagnosis.candidates.is_empty() => {
            "There are too few data to decide whether an effect is missing.".to_owned()
        }
        Verdict::InsufficientData => "These data do not decide whether an effect is missing.".to_owned(),
    }
}

/// `Backlash or Wear; and X or Y`.
fn groups(diagnosis: &Diagnosis) -> String {
    let all: Vec<String> = diagnosis.groups.iter().map(|group| titles(&group.effects, "or")).collect();
    if all.is_empty() { "several effects fit equally well".to_owned() } else { all.join("; and ") }
}

/// How far the error falls, on the test records where there are any.
fn fall(diagnosis: &Diagnosis) -> String {
    let error = &diagnosis.error;
    let with = match (diagnosis.verdict, diagnosis.effects.len() + diagnosis.surrogates.len()) {
        (Verdict::EffectFound, 1) => "With it",
        (Verdict::EffectFound, _) => "With them",
        _ => "With the best of them",
    };
    let (before, after, whose) = if error.test.is_finite() && error.test_refitted.is_finite() {
        (error.test_refitted, error.test, " on the test records")
    } else {
        (error.refitted, error.last, "")
    };
    let change = format::change(before, after).map(|change| format!(" ({change})")).unwrap_or_default();
    format!(
        "{with} the error{whose} {} from {} to {}{change}.",
        if after < before { "falls" } else { "goes" },
        format::error(before),
        format::error(after)
    )
}

/// The error of the model as given on the test records; NaN where there are none.
pub fn test_baseline(diagnosis: &Diagnosis) -> f64 {
    let test = |record: usize| diagnosis.split.get(record) == Some(&Use::Confirm);
    diagnosis.comparison.stages.first().map_or(f64::NAN, |stage| summary::pooled_error(stage, test))
}

/// The error that noise alone would cause.
fn floor(diagnosis: &Diagnosis) -> String {
    let Diagnosis { error, comparison, noise, .. } = diagnosis;
    let test = |record: usize| diagnosis.split.get(record) == Some(&Use::Confirm);
    let skipped = |record: usize| {
        diagnosis.skipped.iter().any(|skipped| skipped.record == comparison.records[record].name)
    };
    let nothing = diagnosis.verdict == Verdict::NothingMissing;
    let (floor, remains, on_test) = match error.test_noise_floor {
        Some(floor) if !nothing => (Some(floor), error.test, true),
        _ if nothing => (error.noise_floor, error.refitted, false),
        _ => (error.noise_floor, error.last, false),
    };
    let Some(floor) = floor else { return " The noise is unknown.".to_owned() };
    let which = |record: usize| !skipped(record) && (!on_test || test(record));
    let caused = format::error(floor);
    match floors::of_remains(comparison, noise, which, [remains, floor]) {
        Against::Less => format!(
            " The noise was estimated to cause {caused}; less remains, so that it is smaller: what it was estimated from differs by \
             more than noise."
        ),
        Against::More if nothing => format!(
            " Noise alone would cause {caused}: more remains, too small to be taken for a missing effect."
        ),
        _ => format!(" Noise alone would cause an error of {caused}."),
    }
}

/// What to do next, most important first.
pub fn next_steps(diagnosis: &Diagnosis, run: &Run) -> Vec<String> {
    let mut steps = Vec::new();
    if run.interrupted {
        steps.push("The diagnosis was interrupted: run it again to its end before you act on it.".to_owned());
    }
    match diagnosis.verdict {
        Verdict::EffectFound => {
            steps.extend(diagnosis.effects.iter().filter_map(|id| {
                let effect = effects::find(id)?;
                Some(format!("Confirm it ({}): {}", effect.title.to_lowercase(), effect.confirmation))
            }));
            steps.push(add(diagnosis, run));
        }
        Verdict::NotDistinguishable => {
            steps.extend(diagnosis.groups.iter().map(|group| group.experiment.clone()));
        }
        Verdict::Unexplained => {
            steps.push(
                "Look at the shapes of the residual (section “Residual”): they are the best indication of a cause that is not \
                 in the catalogue."
                    .to_owned(),
            );
            let most = run.options.max_effects;
            if diagnosis.may_lack_more_than(most) {
                steps.push(format!("Try more effects at once: `{}`", diagnose(run, most + 1)));
            }
        }
        Verdict::NothingMissing | Verdict::InsufficientData => {}
    }
    if let Some(experiment) = &diagnosis.next_experiment
        && !steps.contains(experiment)
    {
        steps.push(experiment.clone());
    }
    if steps.is_empty() && diagnosis.verdict == Verdict::NothingMissing {
        steps.push("Use the refitted model. The detection limits are listed below.".to_owned());
    }
    steps
}

/// How to get the model with the effects.
fn add(diagnosis: &Diagnosis, run: &Run) -> String {
    if let Some(path) = &run.written {
        return format!(
            "The model with the effects found is in {path}; `stickslip export {path} -o X.fmu` makes an FMU of it."
        );
    }
    match (&diagnosis.effects[..], diagnosis.candidates.iter().find(|one| one.effects == diagnosis.effects)) {
        ([id], candidate) => {
            let place = candidate.and_then(|one| one.location.as_ref());
            let place = place.map(|place| format!("@{place}")).unwrap_or_default();
            let (model, data) = (quoted(&run.model), quoted(&run.dataset));
            format!("Add it: `stickslip add {model} {id}{place} --fit {data} -o NEW.toml`")
        }
        _ => format!("Write the model with them: `{} -o NEW.toml`", diagnose(run, run.options.max_effects)),
    }
}

/// The command that makes the diagnosis, with so many effects at most.
fn diagnose(run: &Run, most: usize) -> String {
    let DiagnoseOptions { effects, assumptions, .. } = &run.options;
    let usual = DiagnoseOptions::default();
    let mut command = format!("stickslip diagnose {} {}", quoted(&run.model), quoted(&run.dataset));
    if let Some(only) = effects {
        command += &format!(" --effects {}", only.join(","));
    }
    if most != usual.max_effects {
        command += &format!(" --max-effects {most}");
    }
    for ((name, value), (_, usual)) in assumptions.named().into_iter().zip(usual.assumptions.named()) {
        if value != usual {
            command += &format!(" --assume {name}={value}");
        }
    }
    command
}

fn quoted(path: &str) -> String {
    if path.contains(' ') { format!("'{path}'") } else { path.to_owned() }
}

/// What a reader must know beside the verdict.
pub fn warnings(diagnosis: &Diagnosis, run: &Run) -> Vec<String> {
    let mut all = Vec::new();
    if run.interrupted {
        all.push("Interrupted: these are the results so far.".to_owned());
    }
    all.extend(crate::findings(&diagnosis.comparison.findings));
    all.extend(summary::stage_notes(&diagnosis.comparison));
    let skipped = |one: &Skipped| format!("{} is skipped: {}.", one.record, one.reason);
    all.extend(diagnosis.skipped.iter().map(skipped));
    let (samples, fitted) = (diagnosis.cost.samples, diagnosis.cost.fitted_samples);
    if fitted < samples {
        all.push(format!(
            "Effects were weighed by {fitted} of {samples} samples, between which the motion is straight. The numbers of what was \
             found are those of all."
        ));
    }
    if !diagnosis.surrogates.is_empty() && diagnosis.verdict == Verdict::Unexplained {
        let one = diagnosis.surrogates.len() == 1;
        all.push(format!(
            "{} {} the error on the training records without explaining the data. {}",
            titles(&diagnosis.surrogates, "and"),
            if one { "lowers" } else { "lower" },
            if one {
                "This term only absorbs error; do not read it as physics."
            } else {
                "These terms only absorb error; do not read them as physics."
            },
        ));
    }
    if diagnosis.verdict != Verdict::InsufficientData && diagnosis.error.noise_floor.is_none() {
        all.push(
            "The noise is unknown: no record is repeated or periodic, and the dataset states none. How much of the \
             remaining error is noise is therefore unknown, too."
                .to_owned(),
        );
    }
    if !diagnosis.error.test.is_finite() && diagnosis.verdict == Verdict::EffectFound {
        all.push(
            "There is no test record: no independent data confirm the error with the effect added."
                .to_owned(),
        );
    }
    all.extend(super::residual::warnings(diagnosis));
    let known = |source| !matches!(source, NoiseSource::Unknown);
    let some = diagnosis.noise.iter().any(|noise| known(noise.source));
    if some && diagnosis.noise.iter().any(|noise| !known(noise.source)) {
        all.push("The noise of some channels is unknown; see “Noise”.".to_owned());
    }
    all
}

/// Two digits: a limit is not known more exactly.
pub fn rounded(value: f64) -> f64 {
    format!("{value:.1e}").parse().unwrap_or(value)
}

/// A probability: no digits beyond those that were ever checked.
pub fn probability(p: f64) -> String {
    match p {
        p if p < 0.001 => "below 0.001".to_owned(),
        p if p > 0.999 => "above 0.999".to_owned(),
        p => format!("{p:.3}"),
    }
}

/// How the noise of a channel is known.
pub fn source(source: NoiseSource) -> &'static str {
    match source {
        NoiseSource::Stated => "stated in the dataset",
        NoiseSource::Periods => "difference of repeated periods",
        NoiseSource::Repeats => "repeated record",
        NoiseSource::Carried => "taken from other records",
        NoiseSource::Unknown => "unknown",
    }
}

/// A fitted number with its interval: `2.3 mm (2.2 … 2.4)`.
pub fn estimate(estimate: &Estimate) -> String {
    match (estimate.low, estimate.high) {
        (Some(low), Some(high)) => {
            let value = value_within([low, high], estimate.value, estimate.unit);
            format!("{value} ({})", interval(low, high, estimate.unit))
        }
        _ => format!("{} (not determined)", format::engineering(estimate.value, estimate.unit)),
    }
}

/// A value with as many digits as its interval has.
pub fn value_within([low, high]: [f64; 2], value: f64, unit: &str) -> String {
    format::engineering_to(format::digits_between(low, high), value, unit)
}

/// Both ends with the unit once where it is the same.
pub fn interval(low: f64, high: f64, unit: &str) -> String {
    let [low, high] = [low, high].map(|end| value_within([low, high], end, unit));
    match (low.split_once('\u{a0}'), high.split_once('\u{a0}')) {
        (Some((number, of)), Some((_, same))) if of == same => format!("{number} … {high}"),
        _ => format!("{low} … {high}"),
    }
}

/// `half_gap` as prose.
pub fn parameter(name: &str) -> String {
    name.replace('_', " ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_names_its_unit_once_where_both_ends_share_it() {
        let of = |low, high| {
            let estimate = Estimate { name: "half_gap".into(), value: 2.3e-3, low, high, unit: "m" };
            super::estimate(&estimate).replace('\u{a0}', " ")
        };
        assert_eq!(of(Some(2.2e-3), Some(2.4e-3)), "2.3 mm (2.2 … 2.4 mm)");
        assert_eq!(of(Some(0.9e-3), Some(2.4e-3)), "2.3 mm (900 µm … 2.4 mm)");
        assert_eq!(of(None, Some(2.4e-3)), "2.3 mm (not determined)");
        // A narrow one is not shown as a point.
        assert_eq!(of(Some(2.29996e-3), Some(2.30004e-3)), "2.3 mm (2.29996 … 2.30004 mm)");
        assert_eq!(of(Some(2.3e-3), Some(2.3e-3)), "2.3 mm (2.3 … 2.3 mm)");
    }

    #[test]
    fn names_are_joined_as_in_prose() {
        assert_eq!(
            titles(&["backlash", "wear"], "or"),
            format!("{} or {}", title("backlash"), title("wear"))
        );
        assert_eq!(title("not_in_the_catalogue"), "not in the catalogue");
    }
}
