//! Every law of the catalogue, fitted at some levels and predicted at the others.

use super::{Identification, IdentifyOptions, Setup, check_interrupt};
use crate::contact::{LAWS, MEASURED};
use crate::effects::Kind;
use crate::identify::measured::half_range;
use crate::identify::{IdentificationError, IdentifiedLaw, fit_law, tabulate};
use crate::model::{Contact, Model, Structure};

/// No law describes a contact where the best leaves more than this part of the force in records that it was not fitted to. The
/// measured map stands for it where it leaves less than this part of that.
const UNDESCRIBED: f64 = 0.03;
const BETTER: f64 = 0.5;
/// Motions that exceed the map's by more than this factor are beyond it.
const RANGE: f64 = 1.001;

/// Fits all laws and takes the one that predicts best into `model`.
pub(super) fn fit_laws(
    setup: &Setup,
    model: &Model,
    options: &IdentifyOptions,
    found: &mut Identification,
) -> Result<(), IdentificationError> {
    let Some(inversion) = &found.inversion else { return Ok(()) };
    found.fitted = fitted(found, options)?;
    for kind in LAWS {
        let (load, periods, fitted) = (setup.normal_load, &inversion.periods, &found.fitted);
        let law = match kind == MEASURED {
            true => tabulate(load, periods, fitted),
            false => fit_law(kind, load, periods, fitted, options.interrupt),
        };
        match law {
            Ok(law) => found.laws.push(law),
            Err(error) => found.failed_laws.push((kind.name, error.to_string())),
        }
        check_interrupt(options)?;
    }
    choose(found);
    if found.fitted.len() == found.records.len() {
        found
            .warnings
            .push("All levels were fitted: the best law is not checked by a prediction.".to_owned());
    }
    found.model = found.best.and_then(|best| {
        with_contact(model, &found.laws[best], found.static_correction, &mut found.warnings)
    });
    Ok(())
}

/// Takes the law that predicts best, or the measured map where none describes the contact.
fn choose(found: &mut Identification) {
    let errors: Vec<f64> = found.laws.iter().map(|law| judged(law, &found.fitted)).collect();
    let map = found.laws.iter().position(|law| name_of(law) == MEASURED.name);
    let usable = (0..errors.len()).filter(|k| errors[*k].is_finite() && Some(*k) != map);
    let law = usable.min_by(|a, b| errors[*a].total_cmp(&errors[*b]));
    let left = law.map_or(f64::INFINITY, |law| errors[law]);
    found.best = law;
    if left <= UNDESCRIBED {
        return;
    }
    let than = law.map_or("none could be fitted".to_owned(), |law| {
        format!("{}, the best, leaves {:.1} % of the force", name_of(&found.laws[law]), 100.0 * left)
    });
    let undescribed = format!("No law of the library describes the contact: {than}");
    match map.filter(|map| errors[*map] < BETTER * left) {
        Some(map) => {
            found.best = Some(map);
            let left = 100.0 * errors[map];
            found
                .warnings
                .push(format!("{undescribed}; the measured map leaves {left:.1} % and stands for it."));
            tell_range(found);
        }
        None => {
            found.warnings.push(format!("{undescribed}, and the measured map does not do better by half."))
        }
    }
}

/// Names the range of the measured map, and the records beyond it.
fn tell_range(found: &mut Identification) {
    let periods = found.inversion.iter().flat_map(|inversion| &inversion.periods);
    let moved: Vec<f64> = periods.map(half_range).collect();
    let range = found.fitted.iter().map(|k| moved[*k]).fold(0.0, f64::max);
    found.range = Some(range);
    found.warnings.push(format!(
        "The map holds for motions of up to ± {:.1} µm about their middle. Beyond that its force stays as it is there, which nobody \
         has measured.",
        1e6 * range
    ));
    let beyond = found.records.iter().zip(&moved).filter(|(_, moved)| **moved > RANGE * range);
    let beyond: Vec<&str> = beyond.map(|(record, _)| record.name.as_str()).collect();
    if !beyond.is_empty() {
        found.warnings.push(format!("Beyond the range of the measured map: {}.", beyond.join(", ")));
    }
}

fn name_of(law: &IdentifiedLaw) -> &'static str {
    law.model.contact.map_or("", |contact| contact.law.kind.name)
}

/// Places of the records to fit.
fn fitted(found: &Identification, options: &IdentifyOptions) -> Result<Vec<usize>, IdentificationError> {
    let place = |name: &String| {
        let stem = |file: &str| file.strip_suffix(".csv").unwrap_or(file).to_owned();
        let known = found.records.iter().position(|record| stem(&record.name) == stem(name));
        known.ok_or_else(|| {
            if let Some((record, reason)) = found.skipped.iter().find(|one| stem(&one.0) == stem(name)) {
                return IdentificationError::NotIdentified { record: record.clone(), reason: reason.clone() };
            }
            let names: Vec<&str> = found.records.iter().map(|record| record.name.as_str()).collect();
            IdentificationError::Failed(format!(
                "laws cannot be fitted to `{name}`: the identified records are {}",
                names.join(", ")
            ))
        })
    };
    if !options.fitted.is_empty() {
        let mut places = options.fitted.iter().map(place).collect::<Result<Vec<_>, _>>()?;
        places.sort_unstable();
        places.dedup();
        return Ok(places);
    }
    let moved = |k: &usize| {
        let period = found.inversion.as_ref().map(|inversion| &inversion.periods[*k]);
        period.map_or(0.0, |period| period.displacement[1].hypot(period.displacement[2]))
    };
    Ok((0..found.records.len()).max_by(|a, b| moved(a).total_cmp(&moved(b))).into_iter().collect())
}

/// Root mean square of the errors on records that were not fitted, or on the fitted ones where there are no others.
pub(super) fn judged(law: &IdentifiedLaw, fitted: &[usize]) -> f64 {
    let all = fitted.len() == law.errors.len();
    let errors = law.errors.iter().enumerate().filter(|(k, _)| all || !fitted.contains(k));
    let squares: Vec<f64> =
        errors.map(|(_, error)| error.map_or(f64::INFINITY, |error| error * error)).collect();
    (squares.iter().sum::<f64>() / squares.len().max(1) as f64).sqrt()
}

/// `model` with the contact of `law`. Effects on its contact were not assumed, and go.
fn with_contact(
    model: &Model,
    law: &IdentifiedLaw,
    static_correction: bool,
    warnings: &mut Vec<String>,
) -> Option<Model> {
    let contact = law.model.contact?;
    let mut new = model.clone();
    let normal_stiffness = model.contact.map_or(0.0, |contact| contact.normal_stiffness);
    let normal = model.contact.and_then(|contact| contact.normal);
    new.contact = Some(Contact { normal_stiffness, normal, ..contact });
    new.effects.retain(|effect| !effect.effect.kinds.contains(&Kind::Contact));
    let gone: Vec<&str> = model
        .effects
        .iter()
        .filter(|effect| !new.effects.contains(effect))
        .map(|effect| effect.effect.id)
        .collect();
    if !gone.is_empty() {
        warnings.push(format!(
            "Effects of the model on its contact are not in the identified one: {}.",
            gone.join(", ")
        ));
    }
    if let Structure::Beam(beam) = &mut new.structure {
        beam.static_correction |= static_correction;
        // A spring stood for the contact.
        beam.rotational_stiffness *= if model.contact.is_some() { 1.0 } else { 0.0 };
    }
    Some(new)
}
