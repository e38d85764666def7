//! What a catalogue holds of a law: its name, its parameters, and how it is made.

use super::element::Element;
use super::{GradualLaw, LawError, ParallelSliders};
use crate::vocabulary::{self as v, Quantity, Scale};

/// An entry of the catalogue.
pub struct LawKind {
    /// The name in model files: `law = "valanis"`.
    pub name: &'static str,
    /// Name of an FMU of the contact alone.
    pub fmu_name: &'static str,
    /// One line for an engineer.
    pub summary: &'static str,
    /// The law in formulas, a line each, with the names of its parameters.
    pub equations: &'static [&'static str],
    /// Its parameters beside tangential stiffness and coefficient of friction, at most [`MOST_PARAMETERS`].
    pub parameters: &'static [LawParameter],
    /// Whether it is one slider, in whose place an effect may put many.
    pub one_slider: bool,
    /// The rule that values break which are legal one by one.
    pub refuses: fn(&LawValues<'_>) -> Option<LawRule>,
    /// Makes the law, to be changed by effects.
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
    /// The value towards which the law becomes that of one slider, infinite if it does towards large ones; `None` if no
    /// value of this parameter makes it so.
    pub one_slider_at: Option<f64>,
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

/// Most parameters that a law has of its own.
pub const MOST_PARAMETERS: usize = 11;

impl LawKind {
    /// Its parameter that makes it the law of one slider at a value, with this; only laws that slip gradually have one.
    pub fn shape(&self) -> Option<(&'static LawParameter, f64)> {
        self.parameters.iter().find_map(|parameter| Some((parameter, parameter.one_slider_at?)))
    }

    /// Its own parameter called `name`, if it has one.
    pub fn parameter(&self, name: &str) -> Option<&'static LawParameter> {
        self.parameters.iter().find(|parameter| parameter.quantity.name == name)
    }
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

/// A law as a [`Joint`](super::Joint) changes it: made from the law itself, with `into`.
#[derive(Debug, Clone)]
pub struct JointBase(pub(super) BaseLaw);

#[derive(Debug, Clone)]
pub(super) enum BaseLaw {
    /// One slider, or with a spread many.
    Slider(Element),
    /// Many, which slip one after the other and take no spread.
    Sliders(ParallelSliders),
    /// Another law that slips gradually, which takes no spread either.
    Gradual(Box<dyn GradualLaw>),
}

impl<L: GradualLaw + 'static> From<L> for JointBase {
    fn from(law: L) -> Self {
        Self(BaseLaw::Gradual(Box::new(law)))
    }
}

/// Residual stiffness (N/m), of laws that keep one: below that in stick.
pub(super) const RESIDUAL_STIFFNESS: LawParameter = LawParameter {
    quantity: &v::RESIDUAL_STIFFNESS,
    default: Some(0.0),
    includes_min: false,
    one_slider_at: None,
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
