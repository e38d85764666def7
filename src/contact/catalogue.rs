//! The catalogue of contact laws that a model file can name. A law is a file with its [`LawKind`], and its line in
//! [`LAWS`]; files, parameters by path, FMUs and what a fit may try come from it.

use super::kind::BaseLaw;
use super::{
    ContactLaw, Jenkins, JointBase, LawError, LawKind, LawParameter, LawRule, LawValues, MOST_PARAMETERS,
    bouc_wen, iwan, jenkins, measured, valanis,
};
use crate::vocabulary as v;
use std::ops::Deref;

/// Every law, in the order of the documentation.
pub static LAWS: [&LawKind; 5] =
    [&jenkins::KIND, &valanis::KIND, &iwan::KIND, &bouc_wen::KIND, &measured::KIND];

/// The law that is a table, for contacts that no other describes.
pub static MEASURED: &LawKind = &measured::KIND;

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

/// A law; one whose step is shorter than the way to it is known by its type.
#[derive(Debug)]
pub(crate) enum AnyLaw {
    Jenkins(Jenkins),
    Other(Box<dyn ContactLaw>),
}

impl AnyLaw {
    pub fn boxed(self) -> Box<dyn ContactLaw> {
        match self {
            Self::Jenkins(law) => Box::new(law),
            Self::Other(law) => law,
        }
    }
}

impl Deref for AnyLaw {
    type Target = dyn ContactLaw;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Jenkins(law) => law,
            Self::Other(law) => &**law,
        }
    }
}

impl JointBase {
    /// The law alone.
    pub fn into_law(self) -> Box<dyn ContactLaw> {
        AnyLaw::from(self).boxed()
    }
}

impl From<JointBase> for AnyLaw {
    fn from(base: JointBase) -> Self {
        match base.0 {
            BaseLaw::Slider(element) => Self::Jenkins(element.into()),
            BaseLaw::Sliders(sliders) => Self::Other(Box::new(sliders)),
            BaseLaw::Gradual(law) => Self::Other(law),
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
