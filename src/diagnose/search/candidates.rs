//! Which effects of the catalogue can be tried on a model and its data, where, and why others cannot.

use crate::data::{ChannelName, Dataset, Regime};
use crate::diagnose::diagnosis::Untried;
use crate::diagnose::measurements::magnitudes;
use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::diagnose::refit::trial::Unknown;
use crate::effects::{AppliedEffect, CATALOGUE, Effect, Kind, Location, Needs, PlaceKind, Range, Scales};
use crate::fit::Parameter;
use crate::fit::predict::white_noise;
use crate::model::{Model, Structure};

/// An effect at a place.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct Candidate {
    pub effect: &'static Effect,
    pub location: Option<Location>,
}

impl Candidate {
    /// Ranges of its parameters.
    pub fn ranges(&self, scales: &Scales, dataset: &Dataset) -> Vec<Range> {
        let scales = magnitudes::at(scales, dataset, self.location.as_ref());
        self.effect.parameters.iter().map(|parameter| (parameter.range)(&scales)).collect()
    }

    /// The effect with the values of one of its starts.
    pub fn applied(&self, ranges: &[Range], start: usize) -> AppliedEffect {
        let values = ranges.iter().map(|range| range.starts[start]).collect();
        AppliedEffect { effect: self.effect, location: self.location.clone(), values }
    }
}

/// Values of a parameter that are looked at on each side of none before a fit is made.
const SCANNED: i32 = 10;

impl Candidate {
    /// The effect at sizes from a tenth of its first start up to its bounds, on both sides where there are two; the
    /// other parameters where they start.
    pub fn scan(&self, ranges: &[Range]) -> Vec<AppliedEffect> {
        let Some(first) = ranges.first() else { return Vec::new() };
        let least = 0.1 * first.starts[0].abs();
        let sides = [(1.0, first.upper), (-1.0, -first.lower)].into_iter().filter(|(_, most)| *most > least);
        sides
            .flat_map(|(sign, most)| {
                let growth = (most / least).powf(1.0 / f64::from(SCANNED));
                (0..=SCANNED).map(move |k| sign * least * growth.powi(k))
            })
            .filter(|value| (first.lower..=first.upper).contains(value))
            .map(|value| {
                let mut applied = self.applied(ranges, 0);
                applied.values[0] = value;
                applied
            })
            .collect()
    }
}

/// The candidates beside what `model` has, and the effects left out.
pub(in crate::diagnose) fn of(model: &Model, bench: &WeightedDataset) -> (Vec<Candidate>, Vec<Untried>) {
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
        candidates.extend(left.into_iter().map(|location| Candidate { effect, location }));
    }
    (candidates, untried)
}

/// Why `effect` cannot be tried at all.
fn refusal(effect: &Effect, model: &Model, dataset: &Dataset) -> Option<String> {
    if !effect.kinds.contains(&model.kind()) {
        return Some(format!("a {} has no such effect", kind_name(model.kind())));
    }
    let contact = model.contact.as_ref();
    if effect.part.needs_contact() && contact.is_none() {
        return Some("the model has no contact".to_owned());
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
                .all(|record| record.regime == Regime::Steady || record.regime == Regime::Backbone) =>
        {
            Some("in a steady state it has no meaning; it needs records from rest".to_owned())
        }
        Needs::VaryingNormalLoad | Needs::Transient => None,
    }
}

fn kind_name(kind: Kind) -> &'static str {
    match kind {
        Kind::Contact => "contact",
        Kind::Oscillator => "oscillator",
        Kind::Beam => "beam",
    }
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
                Structure::Beam(beam) => {
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

/// The unknowns of a refit of `model`: what its file leaves free, and the parameters of effects from number
/// `added` on.
pub(in crate::diagnose) fn unknowns(
    model: &Model,
    added: usize,
    scales: &Scales,
    dataset: &Dataset,
) -> Vec<Unknown> {
    let mut found = Vec::new();
    for parameter in model.parameters() {
        let of_effect = effect_of(&parameter.path, model);
        let new = of_effect.as_ref().is_some_and(|(index, _)| *index >= added);
        if !(parameter.free || new) {
            continue;
        }
        let (mut lower, mut upper, mut scale) = (parameter.lower, parameter.upper, parameter.scale);
        if let Some((index, place)) = of_effect {
            let applied = &model.effects[index];
            let candidate = Candidate { effect: applied.effect, location: applied.location.clone() };
            let range = &candidate.ranges(scales, dataset)[place];
            (lower, upper, scale) =
                (range.lower.min(parameter.value), range.upper.max(parameter.value), range.scale);
        }
        found.push(Unknown {
            path: parameter.path,
            parameter: Parameter { start: parameter.value, lower, upper, scale },
            unit: parameter.quantity.unit,
        });
    }
    found
}

/// Of `effect.2.half_gap` the effect's index from 0 and that of its parameter.
pub(in crate::diagnose) fn effect_of(path: &str, model: &Model) -> Option<(usize, usize)> {
    let (number, name) = path.strip_prefix("effect.")?.split_once('.')?;
    let index = number.parse::<usize>().ok()?.checked_sub(1)?;
    let place = model.effects.get(index)?.effect.parameters.iter().position(|p| p.quantity.name == name)?;
    Some((index, place))
}
