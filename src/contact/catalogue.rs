//! The catalogue of contact laws that a model file can name. A law is a file with its [`LawKind`], and its line in
//! [`LAWS`]; files, parameters by path, FMUs and what a fit may try come from it.

use super::{ContactLaw, JointBase, LawError, bouc_wen, iwan, jenkins, valanis};
use crate::vocabulary::{self as v, Quantity, Scale};

/// An entry of the catalogue.
pub struct LawKind {
    /// The name in model files: `law = "valanis"`.
    pub name: &'static str,
    /// Name of an FMU of the contact alone.
    pub fmu_name: &'static str,
    /// One line for an engineer.
    pub summary: &'static str,
    /// Its parameters beside tangential stiffness and coefficient of friction, at most [`MOST_PARAMETERS`].
    pub parameters: &'static [LawParameter],
    /// Whether it is one slider, in whose place an effect may put many.
    pub one_slider: bool,
    /// The rule that values break which are legal one by one.
    pub refuses: fn(&LawValues<'_>) -> Option<LawRule>,
    /// Makes the law.
    pub build: fn(&LawValues<'_>) -> Result<JointBase, LawError>,
}

/// A parameter that not every law has.
pub struct LawParameter {
    /// Name, unit and legal values.
    pub quantity: &'static Quantity,
    /// What stands for it in a file that does not give it; `None` where it must be given.
    pub default: Option<f64>,
    /// Whether its smallest value is legal although its bounds are open.
    pub includes_min: bool,
    /// Smallest and largest value that a fit may try, for a tangential stiffness (N/m).
    pub range: fn(f64) -> (f64, f64, Scale),
}

/// What a law is built from.
#[derive(Debug, Clone, Copy)]
pub struct LawValues<'a> {
    /// Stiffness in stick (N/m).
    pub tangential_stiffness: f64,
    /// Coefficient of friction (1).
    pub friction_coefficient: f64,
    /// The law's own parameters, in the order of [`LawKind::parameters`].
    pub own: &'a [f64],
}

/// A rule that a value breaks.
#[derive(Debug, Clone, PartialEq)]
pub struct LawRule {
    /// Name of the parameter.
    pub parameter: &'static str,
    /// What is wrong, in one sentence.
    pub message: String,
    /// What would be right.
    pub help: &'static str,
}

/// Every law, in the order of the documentation.
pub static LAWS: [&LawKind; 4] = [&jenkins::KIND, &valanis::KIND, &iwan::KIND, &bouc_wen::KIND];

/// Most parameters that a law has of its own.
pub const MOST_PARAMETERS: usize = 4;

/// A law of the catalogue with its own numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Law {
    /// Which.
    pub kind: &'static LawKind,
    values: [f64; MOST_PARAMETERS],
}

impl LawKind {
    /// The law called `name`, if there is one.
    ///
    /// ```
    /// use stickslip::contact::LawKind;
    /// let names: Vec<&str> = LawKind::find("valanis").unwrap().parameters.iter().map(|p| p.quantity.name).collect();
    /// assert_eq!(names, ["smoothness", "residual_stiffness"]);
    /// ```
    pub fn find(name: &str) -> Option<&'static Self> {
        LAWS.into_iter().find(|kind| kind.name == name)
    }

    /// Its own parameter called `name`, if it has one.
    pub fn parameter(&self, name: &str) -> Option<&'static LawParameter> {
        self.parameters.iter().find(|parameter| parameter.quantity.name == name)
    }
}

impl Law {
    /// The law called `name` with its own parameters, in the order of [`LawKind::parameters`]; `None` for a name that is
    /// not in the catalogue, or another number of parameters.
    ///
    /// ```
    /// use stickslip::contact::Law;
    /// assert_eq!(Law::named("iwan", &[-0.5, 2.0]).unwrap().values(), [-0.5, 2.0]);
    /// assert!(Law::named("iwan", &[]).is_none() && Law::named("magic", &[]).is_none());
    /// ```
    pub fn named(name: &str, own: &[f64]) -> Option<Self> {
        LawKind::find(name).and_then(|kind| Self::new(kind, own))
    }

    /// As [`Law::named`].
    pub fn new(kind: &'static LawKind, own: &[f64]) -> Option<Self> {
        let mut values = [0.0; MOST_PARAMETERS];
        values.get_mut(..own.len()).filter(|_| own.len() == kind.parameters.len())?.copy_from_slice(own);
        Some(Self { kind, values })
    }

    /// Its own parameters, in the order of [`LawKind::parameters`].
    pub fn values(&self) -> &[f64] {
        &self.values[..self.kind.parameters.len()]
    }

    /// As [`Law::values`], to be changed.
    pub fn values_mut(&mut self) -> &mut [f64] {
        &mut self.values[..self.kind.parameters.len()]
    }

    /// Its parameters with their values.
    pub fn parameters(&self) -> impl Iterator<Item = (&'static LawParameter, f64)> {
        self.kind.parameters.iter().zip(self.values)
    }

    /// Slope that the law keeps in macro-slip (N/m), below its stiffness in stick.
    pub fn residual_stiffness(&self) -> f64 {
        self.parameters()
            .find(|(parameter, _)| *parameter.quantity == v::RESIDUAL_STIFFNESS)
            .map_or(0.0, |(_, value)| value)
    }

    /// The rule that these numbers break, although each is legal by itself.
    pub fn refuses(&self, tangential_stiffness: f64, friction_coefficient: f64) -> Option<LawRule> {
        (self.kind.refuses)(&self.with(tangential_stiffness, friction_coefficient))
    }

    /// The law, to be changed by effects.
    ///
    /// # Errors
    /// A parameter outside its bounds.
    pub fn base(&self, tangential_stiffness: f64, friction_coefficient: f64) -> Result<JointBase, LawError> {
        (self.kind.build)(&self.with(tangential_stiffness, friction_coefficient))
    }

    fn with(&self, tangential_stiffness: f64, friction_coefficient: f64) -> LawValues<'_> {
        LawValues { tangential_stiffness, friction_coefficient, own: self.values() }
    }
}

/// Residual stiffness (N/m), of laws that keep one: below that in stick.
pub(super) const RESIDUAL_STIFFNESS: LawParameter = LawParameter {
    quantity: &v::RESIDUAL_STIFFNESS,
    default: Some(0.0),
    includes_min: false,
    range: |tangential| (0.0, 0.9 * tangential, Scale::Linear),
};

/// The rule that joins residual and tangential stiffness.
pub(super) fn residual_rule(residual: f64, tangential: f64) -> Option<LawRule> {
    (residual >= tangential).then(|| LawRule {
        parameter: v::RESIDUAL_STIFFNESS.name,
        message: format!(
            "`residual_stiffness` ({residual} N/m) must be below `tangential_stiffness` ({tangential} N/m)"
        ),
        help: "the stiffness in macro-slip cannot exceed the stiffness in stick",
    })
}

impl PartialEq for LawKind {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

impl std::fmt::Debug for LawKind {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(self.name)
    }
}

impl JointBase {
    /// The law alone.
    pub fn into_law(self) -> Box<dyn ContactLaw> {
        match self {
            Self::Jenkins(law) => Box::new(law),
            Self::Iwan(law) => Box::new(law),
            Self::Gradual(law) => law,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_unique_and_ranges_legal() {
        for (index, kind) in LAWS.iter().enumerate() {
            assert_eq!(LAWS.iter().position(|other| other == kind), Some(index));
            assert!(kind.parameters.len() <= MOST_PARAMETERS);
            for parameter in kind.parameters {
                let (lower, upper, _) = (parameter.range)(1e6);
                assert!(lower < upper);
                assert!(parameter.quantity.min.is_none_or(|min| lower >= min));
                assert!(parameter.quantity.max.is_none_or(|max| upper <= max));
            }
        }
    }
}
