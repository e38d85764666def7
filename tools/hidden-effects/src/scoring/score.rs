//! One diagnosis against the truth.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::scoring::truth::{Class, Truth};

/// What `stickslip diagnose --json` says, as far as it is scored.
#[derive(Debug, Clone, PartialEq)]
pub struct Diagnosis {
    /// `nothing-missing`, `effect-found`, `not-distinguishable`, `unexplained`, `insufficient-data`, or a weaker word for
    /// one of these; `failed` when there was none.
    pub verdict: String,
    /// Effects named as found, sorted.
    pub effects: Vec<String>,
    /// Where those sit that sit somewhere.
    pub places: BTreeMap<String, String>,
    /// Groups of effects that the data cannot tell apart.
    pub groups: Vec<Vec<String>>,
    /// Its probability, where it is told.
    pub probability: Option<f64>,
    /// The contact law that describes what was found, where one is told.
    pub law: Option<String>,
    /// Error on the test records.
    pub test_error: Option<f64>,
    /// What the noise alone leaves there, as the program sees it.
    pub test_floor: Option<f64>,
    /// Intervals of the candidates' parameters.
    pub intervals: Vec<Interval>,
    /// Duration (s).
    pub seconds: f64,
}

/// The interval of a parameter of a candidate.
#[derive(Debug, Clone, PartialEq)]
pub struct Interval {
    /// The candidate's effect.
    pub effect: String,
    /// Where it was tried, if somewhere.
    pub place: Option<String>,
    /// The parameter.
    pub name: String,
    /// Lower and upper end.
    pub ends: [f64; 2],
}

impl Diagnosis {
    /// Reads the program's JSON.
    ///
    /// # Errors
    /// Another schema, or no verdict.
    pub fn read(json: &Value) -> Result<Diagnosis, String> {
        let schema = json.get("schema").and_then(Value::as_str).unwrap_or_default();
        if schema != "stickslip.diagnosis/1" {
            return Err(format!("schema \"{schema}\" instead of \"stickslip.diagnosis/1\""));
        }
        let verdict = json.get("verdict").and_then(Value::as_str).ok_or("no `verdict`")?.to_owned();
        let error = |key: &str| json.get("error").and_then(|error| error.get(key)).and_then(Value::as_f64);
        let places = json.get("places").and_then(Value::as_object).into_iter().flatten();
        let groups = json.get("groups").and_then(Value::as_array).into_iter().flatten();
        let mut effects = json.get("effects").map(names).unwrap_or_default();
        effects.sort();
        effects.dedup();
        Ok(Diagnosis {
            verdict,
            effects,
            places: places.filter_map(|(id, place)| Some((id.clone(), place.as_str()?.to_owned()))).collect(),
            groups: groups.map(names).collect(),
            probability: json.get("probability").and_then(Value::as_f64),
            law: law(json),
            test_error: error("untouched"),
            test_floor: error("untouched_noise_floor"),
            intervals: intervals(json),
            seconds: json.get("seconds").and_then(Value::as_f64).unwrap_or(f64::NAN),
        })
    }

    /// What stands for a diagnosis that did not come.
    pub fn failed(seconds: f64) -> Diagnosis {
        Diagnosis {
            verdict: "failed".to_owned(),
            effects: Vec::new(),
            places: BTreeMap::new(),
            groups: Vec::new(),
            probability: None,
            law: None,
            test_error: None,
            test_floor: None,
            intervals: Vec::new(),
            seconds,
        }
    }

    /// How it stands in the confusion matrix.
    pub fn label(&self) -> String {
        match self.claim() {
            Claim::Effects => self.effects.join(" + "),
            Claim::Group => {
                let groups: Vec<String> = self.groups.iter().map(|group| group.join(" | ")).collect();
                let named =
                    self.effects.iter().filter(|name| !self.groups.iter().flatten().any(|n| n == *name));
                named.cloned().chain(groups).collect::<Vec<_>>().join(" + ")
            }
            _ => format!("({})", self.verdict),
        }
    }

    /// What is claimed, whatever word is used for how sure it is.
    pub fn claim(&self) -> Claim {
        match self.verdict.as_str() {
            "nothing-missing" => Claim::Nothing,
            "effect-found" => Claim::Effects,
            "not-distinguishable" => Claim::Group,
            "unexplained" => Claim::Unexplained,
            "insufficient-data" | "failed" => Claim::None,
            _ if !self.groups.is_empty() => Claim::Group,
            _ if !self.effects.is_empty() => Claim::Effects,
            weaker if weaker.contains("nothing") => Claim::Nothing,
            weaker if weaker.contains("unexplained") => Claim::Unexplained,
            _ => Claim::None,
        }
    }
}

/// What a diagnosis claims.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Claim {
    /// Nothing is missing.
    Nothing,
    /// These effects are missing.
    Effects,
    /// One of each group is.
    Group,
    /// Something is missing that no effect describes.
    Unexplained,
    /// Nothing is claimed.
    None,
}

/// The contact law that is told: for all, or of a candidate that was found.
fn law(json: &Value) -> Option<String> {
    let named = json.get("effects").map(names).unwrap_or_default();
    let candidates = json.get("candidates").and_then(Value::as_array).into_iter().flatten();
    let found = |one: &&Value| one.get("effect").is_some_and(|id| named.iter().any(|name| id == name));
    std::iter::once(json)
        .chain(candidates.filter(found))
        .find_map(|one| Some(one.get("law")?.as_str()?.to_owned()))
}

/// A list of names: of texts, or of objects with `effect` or a list `effects`.
fn names(list: &Value) -> Vec<String> {
    if let Some(inner) = list.get("effects") {
        return names(inner);
    }
    let name = |entry: &Value| entry.as_str().or_else(|| entry.get("effect")?.as_str()).map(str::to_owned);
    list.as_array().into_iter().flatten().filter_map(name).collect()
}

fn intervals(json: &Value) -> Vec<Interval> {
    let mut intervals = Vec::new();
    for candidate in json.get("candidates").and_then(Value::as_array).into_iter().flatten() {
        let Some(effect) = candidate.get("effect").and_then(Value::as_str) else { continue };
        let place = candidate.get("location").and_then(Value::as_str);
        let parameters = candidate.get("parameters").and_then(Value::as_object).into_iter().flatten();
        for (name, parameter) in parameters {
            let number = |key: &str| parameter.get(key).and_then(Value::as_f64);
            if let (Some(low), Some(high)) = (number("low"), number("high")) {
                intervals.push(Interval {
                    effect: effect.to_owned(),
                    place: place.map(str::to_owned),
                    name: name.clone(),
                    ends: [low, high],
                });
            }
        }
    }
    intervals
}

/// How right a diagnosis is.
#[derive(Debug, Clone, PartialEq)]
pub struct Score {
    /// 1 right, 1/2 the truth is in a group that was named, 0 wrong.
    pub right: f64,
    /// Something of the catalogue was named although nothing of it is there.
    pub named_falsely: bool,
    /// Parameters of truly hidden effects for which an interval was told, as `effect.parameter`, and whether it holds the
    /// true value.
    pub covered: Vec<(String, bool)>,
    /// Error on test records over the noise that was added, when the verdict is right.
    pub test_error_over_noise: Option<f64>,
    /// The same over the noise floor that the program tells.
    pub test_error_over_floor: Option<f64>,
}

/// Scores a diagnosis.
pub fn score(truth: &Truth, diagnosis: &Diagnosis) -> Score {
    let claim = diagnosis.claim();
    let names_fault = claim == Claim::Effects
        && !diagnosis.effects.is_empty()
        && diagnosis.effects.iter().all(|name| truth.faults.contains(name));
    let right = match (truth.class(), claim) {
        (Class::Null, Claim::Nothing) | (Class::Outside, Claim::Unexplained) => 1.0,
        (Class::Outside, Claim::Effects) => f64::from(names_fault),
        (Class::Single | Class::Pair, Claim::Effects) => {
            f64::from(diagnosis.effects == truth.effects && in_place(truth, diagnosis))
        }
        (Class::Single | Class::Pair, Claim::Group) if in_groups(truth, diagnosis) => 0.5,
        _ => 0.0,
    };
    let nothing_to_name = matches!(truth.class(), Class::Null | Class::Outside);
    let explained = right == 1.0 && truth.class() != Class::Outside;
    let over = |noise: f64| {
        let ratio = diagnosis.test_error.map(|error| error / noise);
        ratio.filter(|ratio| explained && ratio.is_finite())
    };
    Score {
        right,
        named_falsely: nothing_to_name && matches!(claim, Claim::Effects | Claim::Group) && !names_fault,
        covered: covered(truth, diagnosis),
        // The noise as it was made, and as the program sees it.
        test_error_over_noise: over(truth.noise),
        test_error_over_floor: diagnosis.test_floor.and_then(over),
    }
}

fn covered(truth: &Truth, diagnosis: &Diagnosis) -> Vec<(String, bool)> {
    let found = diagnosis.claim() == Claim::Effects;
    let mut covered = Vec::new();
    for Interval { effect, place, name, ends: [low, high] } in &diagnosis.intervals {
        let value = truth.parameters.get(effect).and_then(|parameters| parameters.get(name));
        let named = found && diagnosis.effects.contains(effect) && truth.effects.contains(effect);
        // The same effect was tried at other places, too: a mass at m2 says nothing of one at m1.
        let elsewhere = |at: &String| place.as_ref().is_some_and(|place| place != at);
        let there = !truth.places.get(effect).is_some_and(elsewhere);
        if let Some(value) = value.filter(|_| named && there) {
            covered.push((format!("{effect}.{name}"), (low..=high).contains(&value)));
        }
    }
    covered
}

/// Whether what was found sits where it was hidden, as far as the answer says where.
fn in_place(truth: &Truth, diagnosis: &Diagnosis) -> bool {
    truth.places.iter().all(|(effect, place)| diagnosis.places.get(effect).is_none_or(|found| found == place))
}

/// Every hidden effect is named or in a group, every group holds one, and nothing else is named.
fn in_groups(truth: &Truth, diagnosis: &Diagnosis) -> bool {
    let hidden = |name: &String| truth.effects.contains(name);
    let grouped = |name: &String| diagnosis.groups.iter().any(|group| group.contains(name));
    !diagnosis.groups.is_empty()
        && truth.effects.iter().all(|name| grouped(name) || diagnosis.effects.contains(name))
        && diagnosis.groups.iter().all(|group| group.iter().any(hidden))
        && diagnosis.effects.iter().all(|name| hidden(name) || grouped(name))
}
