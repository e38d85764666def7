//! Units that people read, and the types of variables: for every version of FMI.

use stickslip::fmi::{Description, Variable, VariableType};
use stickslip::vocabulary::Quantity;

/// Units in which values of a unit of the vocabulary are shown, with the number that a value is multiplied by.
const SHOWN: [(&str, &[(&str, f64)]); 11] = [
    ("J", &[("mJ", 1e3)]),
    ("N", &[("kN", 1e-3)]),
    ("N/m", &[("N/mm", 1e-3), ("N/um", 1e-6)]),
    ("N/m^3", &[("N/mm^3", 1e-9)]),
    ("Pa", &[("MPa", 1e-6), ("GPa", 1e-9)]),
    ("kg", &[("g", 1e3)]),
    ("m", &[("mm", 1e3), ("um", 1e6)]),
    ("m/s", &[("mm/s", 1e3)]),
    ("rad", &[("deg", 180.0 / std::f64::consts::PI)]),
    ("s", &[("ms", 1e3), ("us", 1e6)]),
    ("N.m/rad", &[("kN.m/rad", 1e-3)]),
];

/// Kinds of quantities by their unit: the name of the type, the kind in the words of ISO 80000, the unit.
const TYPES: [(&str, &str, &str); 17] = [
    ("Acceleration", "Acceleration", "m/s^2"),
    ("AngularStiffness", "RotationalStiffness", "N.m/rad"),
    ("CubicStiffness", "CubicStiffness", "N/m^3"),
    ("Damping", "DampingConstant", "N.s/m"),
    ("Density", "Density", "kg/m^3"),
    ("Energy", "Energy", "J"),
    ("Force", "Force", "N"),
    ("Frequency", "Frequency", "Hz"),
    ("Inertia", "MomentOfInertia", "kg.m^2"),
    ("Length", "Length", "m"),
    ("Mass", "Mass", "kg"),
    ("Modulus", "ModulusOfElasticity", "Pa"),
    ("Angle", "Angle", "rad"),
    ("Rate", "Rate", "1/s"),
    ("Stiffness", "TranslationalStiffness", "N/m"),
    ("Time", "Time", "s"),
    ("Velocity", "Velocity", "m/s"),
];

/// The type of a quantity.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Type {
    /// Its name; no variable of a model is called so, since those begin with a small letter.
    pub name: &'static str,
    /// What it is of.
    pub quantity: &'static str,
    /// SI, without a prefix.
    pub unit: &'static str,
}

/// The units in which values in `unit` are shown, each with its factor.
pub fn display_units(unit: &str) -> &'static [(&'static str, f64)] {
    SHOWN.iter().find(|(name, _)| *name == unit).map_or(&[], |(_, shown)| shown)
}

/// The unit in which a quantity of its nominal size reads best: from 1 to 1000; `None` for its own.
pub fn display_unit(quantity: &Quantity) -> Option<&'static str> {
    let reads_well = |factor: f64| (0.999..999.0).contains(&(quantity.nominal.abs() * factor));
    if reads_well(1.0) {
        return None;
    }
    display_units(quantity.unit).iter().find(|(_, factor)| reads_well(*factor)).map(|(name, _)| *name)
}

/// The type of a variable; a number without a unit has none.
pub fn type_of(variable: &Variable) -> Option<Type> {
    let real = variable.variable_type == VariableType::Real;
    let (name, quantity, unit) = *TYPES.iter().find(|(.., unit)| real && *unit == variable.quantity.unit)?;
    Some(Type { name, quantity, unit })
}

/// The types that occur in a model, by name.
pub fn types(description: &Description) -> Vec<Type> {
    let used = |name: &str| {
        description.variables.iter().any(|variable| type_of(variable).is_some_and(|found| found.name == name))
    };
    let all = TYPES.iter().filter(|(name, ..)| used(name));
    all.map(|(name, quantity, unit)| Type { name, quantity, unit }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use stickslip::vocabulary as v;

    #[test]
    fn a_quantity_is_shown_in_the_unit_in_which_its_usual_size_reads_best() {
        assert_eq!(display_unit(&v::DISPLACEMENT), Some("um"));
        assert_eq!(display_unit(&v::THICKNESS), Some("mm"));
        assert_eq!(display_unit(&v::LENGTH), None);
        assert_eq!(display_unit(&v::YOUNGS_MODULUS), Some("GPa"));
        assert_eq!(display_unit(&v::TANGENTIAL_STIFFNESS), Some("N/um"));
        assert_eq!(display_unit(&v::FORCE), None);
    }

    /// Every prefix and every base unit of a name, multiplied: the factor must be what the name says.
    #[test]
    fn factors_are_those_that_the_names_say() {
        for (unit, shown) in SHOWN {
            for (name, factor) in shown {
                let expected = scale(unit) / scale(name);
                assert!(
                    (factor / expected - 1.0).abs() < 1e-12,
                    "1 {unit} is {expected} {name}, not {factor}"
                );
            }
        }
    }

    /// What one of the unit is in SI.
    fn scale(unit: &str) -> f64 {
        let mut sign = 1;
        let mut total = 1.0;
        for part in unit.split_inclusive(['.', '/']) {
            let (part, next) = match part.strip_suffix('/') {
                Some(part) => (part, -1),
                None => (part.trim_end_matches('.'), 1),
            };
            let (base, power) =
                part.split_once('^').map_or((part, 1), |(base, power)| (base, power.parse().unwrap()));
            total *= one(base).powi(sign * power);
            sign = next;
        }
        total
    }

    fn one(unit: &str) -> f64 {
        match unit {
            "deg" => std::f64::consts::PI / 180.0,
            "m" | "s" | "N" | "J" | "Pa" | "kg" | "rad" => 1.0,
            "g" => 1e-3,
            _ => {
                one(&unit[1..])
                    * match &unit[..1] {
                        "u" => 1e-6,
                        "m" => 1e-3,
                        "k" => 1e3,
                        "M" => 1e6,
                        "G" => 1e9,
                        other => panic!("{other} in {unit}"),
                    }
            }
        }
    }
}
