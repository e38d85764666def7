//! Which effects of the catalogue can be tried on a model and its data, where, and why others cannot.

use super::diagnosis::Untried;
use super::measurements::magnitudes;
use super::measurements::weighted_dataset::WeightedDataset;
use crate::contact::{LAWS, Law, LawKind, LawParameter};
use crate::data::{ChannelName, Dataset, Record, Regime};
use crate::effects::{
    AppliedEffect, CATALOGUE, Effect, EffectParameter, InTables, Location, Needs, PlaceKind, Range, Scales,
};
use crate::fit::predict::white_noise;
use crate::model::{Model, PinnedBeam, Structure};
use crate::vocabulary::{Quantity, Scale};

/// An effect at a place, or a contact law that describes it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub effect: &'static Effect,
    pub location: Option<Location>,
    /// The law of the catalogue that shows the effect, in the place of the model's; `None` for the effect's own.
    pub law: Option<&'static LawKind>,
}

/// A number that a candidate brings into a model.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Brought {
    pub quantity: &'static Quantity,
    /// Where it changes nothing, infinite if for large values.
    pub neutral: Option<f64>,
    pub range: Range,
}

impl Candidate {
    /// `effect` at `location` in every form that it has in `model`: its own, and the laws that show it.
    pub fn forms(effect: &'static Effect, location: Option<&Location>, model: &Model) -> Vec<Self> {
        let one_slider = model.contact.is_some_and(|contact| contact.law.kind.one_slider);
        let laws =
            LAWS.into_iter().filter(|law| one_slider && effect.splits_slider() && law.shape().is_some());
        let form = |law| Self { effect, location: location.cloned(), law };
        std::iter::once(None).chain(laws.map(Some)).map(form).collect()
    }

    /// Whether `other` is the same effect at the same place, in any form.
    pub fn is_form_of(&self, other: &Self) -> bool {
        self.effect == other.effect && self.location == other.location
    }

    /// Its numbers, the first with a neutral value.
    pub fn brings(&self, scales: &Scales, dataset: &Dataset) -> Vec<Brought> {
        let scales = magnitudes::at(scales, dataset, self.location.as_ref());
        let Some(law) = self.law else {
            let brought = |parameter: &EffectParameter| Brought {
                quantity: parameter.quantity,
                neutral: parameter.neutral,
                range: (parameter.range)(&scales),
            };
            return self.effect.parameters.iter().map(brought).collect();
        };
        let brought = |parameter: &&LawParameter| {
            let (lower, upper, scale) = (parameter.range)(scales.stiffness);
            let middle =
                if scale == Scale::Logarithmic { (lower * upper).sqrt() } else { 0.5 * (lower + upper) };
            let starts = [1.0, 3.3, 1.0 / 3.3].map(|factor| (factor * middle).clamp(lower, upper)).to_vec();
            let range = Range { lower, upper, scale, starts };
            Brought { quantity: parameter.quantity, neutral: parameter.one_slider_at, range }
        };
        varied(law).iter().map(brought).collect()
    }

    /// `model` with it at `values`, one for each number that it brings.
    pub fn added_to(&self, model: &Model, values: &[f64]) -> Model {
        let mut model = model.clone();
        match (self.law, &mut model.contact) {
            (Some(law), Some(contact)) => {
                let own = law.parameters.iter().map(|parameter| {
                    let place = varied(law).iter().position(|one| one.quantity == parameter.quantity);
                    place.map_or(parameter.default.unwrap_or_default(), |place| values[place])
                });
                if let Some(law) = Law::new(law, &own.collect::<Vec<_>>()) {
                    contact.law = law;
                }
            }
            _ => model.effects.push(AppliedEffect {
                effect: self.effect,
                location: self.location.clone(),
                values: values.to_vec(),
            }),
        }
        model
    }

    /// What the paths of its numbers begin with, in the model that it was added to last.
    pub fn path(&self, model: &Model) -> String {
        if self.law.is_some() { "contact.".to_owned() } else { format!("effect.{}.", model.effects.len()) }
    }
}

/// What a fit varies of a law's own parameters, its shape first: all but those that are an effect of their own.
fn varied(law: &LawKind) -> Vec<&'static LawParameter> {
    let shape = law.shape().map(|(parameter, _)| parameter);
    let is_effect = |one: &LawParameter| {
        CATALOGUE.iter().flat_map(|effect| effect.parameters).any(|of| of.quantity == one.quantity)
    };
    let others = law.parameters.iter().filter(|one| one.one_slider_at.is_none() && !is_effect(one));
    shape.into_iter().chain(others).collect()
}

/// The candidates to try: of the catalogue those that `only` names, if it is there; and the effects left out.
pub(super) fn tried(
    model: &Model,
    bench: &WeightedDataset,
    only: Option<&[String]>,
) -> (Vec<Candidate>, Vec<Untried>) {
    let (mut tried, mut untried) = of(model, bench);
    if let Some(only) = only {
        tried.retain(|candidate| only.iter().any(|id| id == candidate.effect.id));
    }
    let reason = |one: &Candidate| Some((one.effect, unseen(bench.dataset, one)?));
    let refused: Vec<_> = tried.iter().filter_map(reason).collect();
    tried.retain(|candidate| unseen(bench.dataset, candidate).is_none());
    for (effect, reason) in refused {
        let known = untried.iter().any(|known| known.effect == effect.id);
        if !known && tried.iter().all(|candidate| candidate.effect != effect) {
            untried.push(Untried { effect: effect.id, reason: reason.to_owned() });
        }
    }
    (tried, untried)
}

/// The candidates beside what `model` has, and the effects left out.
fn of(model: &Model, bench: &WeightedDataset) -> (Vec<Candidate>, Vec<Untried>) {
    let (mut candidates, mut untried) = (Vec::new(), Vec::new());
    for effect in CATALOGUE {
        let reason = refusal(effect, model, bench.dataset);
        if let Some(reason) = reason {
            untried.push(Untried { effect: effect.id, reason });
            continue;
        }
        let places = places(effect, model, bench);
        let known = |location: &Option<Location>| {
            model.effects.iter().any(|applied| applied.effect == effect && applied.location == *location)
        };
        let left: Vec<_> = places.into_iter().filter(|place| !known(place)).collect();
        if left.is_empty() {
            untried.push(Untried { effect: effect.id, reason: "the model has it already".to_owned() });
        }
        candidates
            .extend(left.iter().flat_map(|location| Candidate::forms(effect, location.as_ref(), model)));
    }
    (candidates, untried)
}

/// Why `effect` cannot be tried at all.
fn refusal(effect: &'static Effect, model: &Model, dataset: &Dataset) -> Option<String> {
    if !effect.kinds.contains(&model.kind()) {
        return Some(format!("a {} has no such effect", model.kind().name()));
    }
    let contact = model.contact.as_ref();
    if effect.part.needs_contact() && contact.is_none() {
        return Some("the model has no contact".to_owned());
    }
    if let Structure::PinRig(_) = model.structure {
        return on_pin_rig(effect, model);
    }
    match effect.needs {
        Needs::Nothing => None,
        Needs::VaryingNormalLoad if !load_varies(dataset) => {
            Some("no record has a measured normal load that varies".to_owned())
        }
        Needs::NormalMotion => {
            let measured = dataset.records.iter().any(|record| {
                record.channel("normal_displacement").is_some() && record.channel("normal_load").is_some()
            });
            let stiffness = contact.is_some_and(|contact| contact.normal_stiffness > 0.0);
            (!(measured && stiffness)).then(|| {
                "it needs the columns `normal_displacement` and `normal_load`, and `normal_stiffness` in [contact]"
                    .to_owned()
            })
        }
        Needs::Transient
            if dataset
                .records
                .iter()
                .all(|record| record.regime == Regime::Steady || record.regime.is_table()) =>
        {
            Some("in a steady state it has no meaning; it needs records from rest".to_owned())
        }
        Needs::VaryingNormalLoad | Needs::Transient => None,
    }
}

/// The same on a pin rig, whose contact makes its normal load itself: none need be measured, and an effect is left out
/// where the contact has it by itself.
fn on_pin_rig(effect: &'static Effect, model: &Model) -> Option<String> {
    if effect.needs == Needs::Transient {
        return Some(
            "in a steady state it has no meaning; no other records of a pin rig are predicted".to_owned(),
        );
    }
    let starts = effect.parameters.iter().map(|parameter| (parameter.range)(&Scales::default()).starts[0]);
    let applied = AppliedEffect { effect, location: None, values: starts.collect() };
    let mut with = model.clone();
    with.effects.push(applied);
    let refused = with.check().err().filter(|_| effect.part.is_contact());
    refused.map(|refused| refused.message)
}

/// Whether the measured normal load varies by more than its noise.
fn load_varies(dataset: &Dataset) -> bool {
    let loads = dataset.records.iter().filter_map(|record| record.channel("normal_load"));
    let (mut count, mut sum, mut squares, mut noise) = (0.0, 0.0, 0.0, 0.0_f64);
    for channel in loads {
        for value in &channel.values {
            count += 1.0;
            sum += value;
            squares += value * value;
        }
        noise = noise.max(channel.noise.unwrap_or(0.0)).max(white_noise(&channel.values));
    }
    let mean: f64 = sum / count;
    let deviation = (squares / count - mean * mean).max(0.0).sqrt();
    count > 0.0 && deviation > 2.0 * noise && deviation > 2e-3 * mean.abs()
}

/// The possible places of `effect`.
fn places(effect: &Effect, model: &Model, bench: &WeightedDataset) -> Vec<Option<Location>> {
    let channels = || {
        let mut names: Vec<&str> =
            bench.lanes.iter().flat_map(|lane| lane.channels.iter().map(|(name, _)| *name)).collect();
        names.sort_unstable();
        names.dedup();
        names
    };
    match effect.place {
        PlaceKind::Nowhere => vec![None],
        PlaceKind::Channel => {
            channels().into_iter().map(|name| Some(Location::Channel(name.to_owned()))).collect()
        }
        PlaceKind::Structure => {
            let mut places: Vec<Location> = match &model.structure {
                Structure::Prescribed => Vec::new(),
                Structure::Oscillator(oscillator) => {
                    oscillator.masses.iter().map(|mass| Location::Mass(mass.name.clone())).collect()
                }
                Structure::Beam(beam) | Structure::PinRig(PinnedBeam { beam, .. }) => {
                    let sensors = channels().into_iter().filter_map(|name| {
                        ChannelName::parse(name).ok().and_then(|name| Location::of_channel(&name))
                    });
                    let masses = beam.point_masses.iter().map(|mass| Location::Position(mass.position));
                    sensors.chain(masses).chain([Location::Position(beam.excitation_position)]).collect()
                }
            };
            places.sort_by_key(|place| place.to_string());
            places.dedup();
            places.into_iter().map(Some).collect()
        }
    }
}

/// Why no record shows `candidate`: all that could are tables of something else.
fn unseen(dataset: &Dataset, candidate: &Candidate) -> Option<&'static str> {
    let of_channel = match &candidate.location {
        Some(Location::Channel(name)) => Some(name.as_str()),
        _ => None,
    };
    let measured = |record: &&Record| of_channel.is_none_or(|name| record.channel(name).is_some());
    let reason = |record: &Record| match candidate.effect.in_tables {
        InTables::DampingAlone
            if record.regime == Regime::Backbone && record.channel("damping_ratio").is_none() =>
        {
            Some(
                "damping does not shift a frequency measured at phase resonance; it needs the column `damping_ratio`",
            )
        }
        InTables::Columns(quantities, reason) if record.regime.is_table() => {
            let quantity = of_channel.map(|name| name.split(':').next().unwrap_or(name));
            let shown = quantity.is_some_and(|quantity| quantities.contains(&quantity));
            (!shown).then_some(reason)
        }
        _ => None,
    };
    let reasons: Vec<Option<&str>> = dataset.records.iter().filter(measured).map(reason).collect();
    reasons.iter().all(Option::is_some).then(|| reasons.first().copied().flatten()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::find;

    #[test]
    fn what_the_contact_of_a_rig_has_by_itself_is_not_tried() {
        let example = include_str!("../../examples/slip-slap/model.toml");
        let hertz = Model::parse(example).unwrap();
        let why = |model: &Model, id: &str| on_pin_rig(find(id).unwrap(), model);
        assert!(why(&hertz, "normal_load_variation").unwrap().contains("`normal_law`"));
        assert!(why(&hertz, "normal_hardening").unwrap().contains("Hertz"));
        assert!(why(&hertz, "wear").unwrap().contains("steady"));
        assert_eq!(why(&hertz, "impact_damping"), None);
        let constant: Vec<&str> = example
            .lines()
            .filter(|line| {
                !["normal_law", "normal_exponent", "impact"].iter().any(|key| line.starts_with(key))
            })
            .collect();
        let constant = Model::parse(&constant.join("\n")).unwrap();
        for id in ["normal_load_variation", "normal_hardening", "impact_damping", "hanging_mass"] {
            assert_eq!(why(&constant, id), None, "{id}");
        }
    }
}
