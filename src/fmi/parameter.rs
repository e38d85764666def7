//! Which numbers of a model file are parameters of its slave, and what they are called there.

use super::description::Variable;
use crate::effects::AppliedEffect;
use crate::model::{Model, ParameterError, Structure};
use std::borrow::Cow;

/// Rows of the variable table for the parameters of `model`, with their paths in the model file.
///
/// The normal load is an input, but of a contact in two directions, and positions are part of the names.
pub(super) fn parameters(model: &Model) -> (Vec<String>, Vec<Variable>) {
    let is_parameter = |path: &str| {
        // Load and normal displacement come from outside; what sensors show is not in an FMU.
        let about_the_load = !matches!(model.structure, Structure::PinRig(_))
            && model.contact.is_none_or(|contact| contact.normal.is_none())
            && ["contact.normal_load", "contact.normal_stiffness"].contains(&path);
        !about_the_load
            && !path.ends_with(".position")
            && effect(model, path).is_none_or(|applied| in_fmu(model, applied))
    };
    let list = model.parameters().into_iter().filter(|parameter| is_parameter(&parameter.path));
    list.map(|parameter| {
        let mut variable = Variable::parameter(parameter.quantity, parameter.value);
        let element = parameter.path.split('.').find_map(|part| part.parse::<usize>().ok());
        if let Some(effect) = effect(model, &parameter.path) {
            let description = format!("{}: {}", effect.effect.title, parameter.quantity.description);
            variable.name = Cow::Owned(parameter.path.clone());
            variable.description = Cow::Owned(description);
            return (parameter.path, variable);
        }
        if ["pin.", "string."].iter().any(|table| parameter.path.starts_with(table)) {
            // Pin and string both have a mass and an inertia.
            variable.name = Cow::Owned(parameter.path.clone());
            return (parameter.path, variable);
        }
        let beam = match &model.structure {
            Structure::Beam(beam) => Some(beam),
            Structure::PinRig(rig) => Some(&rig.beam),
            _ => None,
        };
        match (element, beam) {
            (Some(element), Some(beam)) if parameter.path.ends_with(".mass") => {
                let position = beam.point_masses[element - 1].position;
                let before = &beam.point_masses[..element - 1];
                let same = before.iter().filter(|point| point.position == position).count();
                // A sensor and a force transducer may sit at the same place.
                let suffix = if same == 0 { String::new() } else { format!(":{}", same + 1) };
                variable.name = Cow::Owned(format!("mass:x={position}{suffix}"));
                variable.description = Cow::Owned(format!("Mass fixed to the beam at x = {position} m"));
            }
            (Some(_), None) if matches!(model.structure, Structure::Oscillator(_)) => {
                variable.name = Cow::Owned(parameter.path.clone())
            }
            (Some(element), _) => {
                variable.name = Cow::Owned(format!("{}:mode={element}", parameter.quantity.name));
                variable.description = Cow::Owned(format!("Damping ratio of mode {element}"));
            }
            (None, _) => {
                let kind = model.contact.map(|contact| contact.law.kind);
                let of_law = kind.and_then(|kind| kind.parameter(parameter.quantity.name));
                variable.includes_min |= of_law.is_some_and(|parameter| parameter.includes_min);
            }
        }
        (parameter.path, variable)
    })
    .unzip()
}

/// Whether an FMU of `model` has the effect. The normal direction of a pin rig is within.
fn in_fmu(model: &Model, applied: &AppliedEffect) -> bool {
    let within = matches!(model.structure, Structure::PinRig(_)) && applied.effect.part.is_contact();
    within || applied.effect.part.is_in_fmu()
}

/// The effect that the parameter at `path` belongs to.
fn effect<'a>(model: &'a Model, path: &str) -> Option<&'a AppliedEffect> {
    let number: usize = path.strip_prefix("effect.")?.split('.').next()?.parse().ok()?;
    model.effects.get(number.checked_sub(1)?)
}

/// `model` with its parameters replaced by `values`, in the order of `paths`.
///
/// # Errors
/// The first rule the values break, in the words of the model file with the variable's name for the path.
pub(super) fn with_values(
    model: &Model,
    paths: &[String],
    variables: &[Variable],
    values: &[f64],
) -> Result<Model, String> {
    let mut changed = model.clone();
    let pairs: Vec<(&String, f64)> = paths.iter().zip(values.iter().copied()).collect();
    match changed.set_all(&pairs) {
        Ok(()) => Ok(changed),
        Err(ParameterError { path, message, help }) => {
            let name = paths.iter().position(|other| *other == path).map(|row| &*variables[row].name);
            let help = help.map(|help| format!(" ({help})")).unwrap_or_default();
            Err(format!("{}: {message}{help}", name.unwrap_or(&path)))
        }
    }
}
