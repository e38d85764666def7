//! `[fit] free`: which parameters a fit may change.

use super::Model;
use super::error::ParameterError;
use crate::document::suggestion;

const NORMAL_LOAD: &str = "contact.normal_load";
const IMPACT_DAMPING: &str = "contact.impact_damping";

/// Whether a fit of `model` may change the parameter at `path`, which now has `value`.
pub(super) fn is_free(model: &Model, path: &str, value: f64) -> bool {
    match &model.free {
        None => free_by_default(path, value),
        Some(patterns) => patterns.iter().any(|pattern| frees(pattern, path)),
    }
}

fn free_by_default(path: &str, value: f64) -> bool {
    // What is zero stays zero where adding it is a change of the model, not a fit of it: a spring, losses of an impact.
    let spring = path == "support.rotational_stiffness" || matches("spring.*", path);
    let spring_present = spring && value > 0.0;
    let impact_without_loss = path == IMPACT_DAMPING && value == 0.0;
    frees("contact.*", path) && !impact_without_loss
        || frees("effect.*", path)
        || frees("beam.*damping*", path)
        // A beam's stiffness, known to a few per cent where its frequencies are measured to a thousandth.
        || path == "beam.youngs_modulus"
        || path == "support.clamp_stiffness"
        || spring_present
}

fn frees(pattern: &str, path: &str) -> bool {
    // Load and coefficient act as a product: a pattern that means both would ask for a degenerate fit.
    matches(pattern, path) && (path != NORMAL_LOAD || pattern == NORMAL_LOAD)
}

/// Whether `pattern`, in which each `*` stands for any characters or none, describes all of `text`.
fn matches(pattern: &str, text: &str) -> bool {
    let mut pieces = pattern.split('*');
    let first = pieces.next().unwrap_or_default();
    let Some(mut rest) = text.strip_prefix(first) else { return false };
    let mut pieces: Vec<&str> = pieces.collect();
    let Some(last) = pieces.pop() else { return rest.is_empty() };
    for piece in pieces {
        match rest.find(piece) {
            Some(start) => rest = &rest[start + piece.len()..],
            None => return false,
        }
    }
    rest.ends_with(last)
}

impl Model {
    /// The model with all parameters free that `before` does not have, those of an effect or of another law, where
    /// `[fit] free` lists what is: what was added is part of every later fit.
    pub fn with_new_free(mut self, before: &Self) -> Self {
        let paths = |model: &Self| model.values().into_iter().map(|one| one.path).collect::<Vec<String>>();
        let (known, all) = (paths(before), paths(&self));
        if let Some(free) = &mut self.free {
            for path in all.iter().filter(|path| !known.contains(path)) {
                if !free.iter().any(|pattern| frees(pattern, path)) {
                    free.push(all_of_effect(path).unwrap_or_else(|| path.clone()));
                }
            }
        }
        self
    }
}

/// `effect.2.*` for a parameter of the second effect.
fn all_of_effect(path: &str) -> Option<String> {
    let number = path.strip_prefix("effect.")?.split('.').next()?;
    Some(format!("effect.{number}.*"))
}

/// Refuses patterns that free nothing.
pub(super) fn check_patterns(model: &Model) -> Result<(), ParameterError> {
    let patterns = model.free.iter().flatten();
    let paths: Vec<String> = model.values().into_iter().map(|parameter| parameter.path).collect();
    for (index, pattern) in patterns.enumerate() {
        if !paths.iter().any(|path| frees(pattern, path)) {
            let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
            return Err(ParameterError::new(
                format!("fit.free.{}", index + 1),
                format!("\"{pattern}\" names no parameter of this model"),
            )
            .with_help(suggestion(pattern, &paths, "parameters")));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_zero_is_free_where_it_is_no_change_of_the_model() {
        for (path, value, expected) in [
            ("contact.smoothness", 0.0, true),
            (IMPACT_DAMPING, 0.0, false),
            (IMPACT_DAMPING, 30.0, true),
            ("spring.1.stiffness", 0.0, false),
            ("spring.1.stiffness", 5.0, true),
        ] {
            assert_eq!(free_by_default(path, value), expected, "{path} of {value}");
        }
    }

    #[test]
    fn a_star_stands_for_any_characters_or_none() {
        for (pattern, text, expected) in [
            ("contact.*", "contact.smoothness", true),
            ("contact.*", "contact", false),
            ("*", "", true),
            ("*.mass", "beam.point_mass.1.mass", true),
            ("beam.*.mass", "beam.point_mass.1.mass", true),
            ("beam.*.mass", "beam.point_mass.1.position", false),
            ("beam.*mass*mass", "beam.mass", false),
            ("a*b*a", "aba", true),
            ("a*a", "a", false),
            ("contact.smoothness", "contact.smoothness", true),
            ("contact.smooth", "contact.smoothness", false),
        ] {
            assert_eq!(matches(pattern, text), expected, "{pattern} against {text}");
        }
    }
}
