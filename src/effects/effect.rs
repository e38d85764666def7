//! An entry of the catalogue of effects.

use super::{Changes, Features, Location, Range, Scales};
use crate::vocabulary::Quantity;

/// An entry of the catalogue.
///
/// ```
/// let backlash = stickslip::effects::find("backlash").unwrap();
/// assert_eq!((backlash.title, backlash.parameters[0].quantity.name), ("Backlash", "half_gap"));
/// ```
pub struct Effect {
    /// The name in files and on the command line: `backlash`.
    pub id: &'static str,
    /// The name for people: `Backlash`.
    pub title: &'static str,
    /// What it adds, in one line, with the formula.
    pub summary: &'static str,
    /// One paragraph for an engineer: what it is and where it comes from.
    pub explanation: &'static str,
    /// How to confirm it by inspection or by one more test.
    pub confirmation: &'static str,
    /// Effects that look like it. Each pair stands in one of its two files: see [`Effect::confusion`].
    pub confused_with: &'static [Confusion],
    /// What to measure next, to distinguish it from effects that `confused_with` does not name.
    pub next_experiment: &'static str,
    /// The parameters, in the order of [`AppliedEffect::values`](super::AppliedEffect::values).
    pub parameters: &'static [EffectParameter],
    /// What it acts on.
    pub part: Part,
    /// Whether it has a place, and what kind of place that is.
    pub place: PlaceKind,
    /// The kinds of model it can be added to.
    pub kinds: &'static [Kind],
    /// What a record must contain for the effect to show.
    pub needs: Needs,
    /// What a table shows of it.
    pub in_tables: InTables,
    /// Adds the effect with `values` (one per parameter, SI) at a place to the changes.
    pub apply: fn(values: &[f64], location: Option<&Location>, changes: &mut Changes),
    /// What of it shows in the views of the residual, as a sentence; `None` when nothing does. It explains a
    /// verdict and never decides it.
    pub signature: fn(&Features) -> Option<String>,
}

/// A parameter of an effect.
pub struct EffectParameter {
    /// Name, unit, legal values.
    pub quantity: &'static Quantity,
    /// The value at which the effect vanishes, infinite if it does towards large ones; `None` if no value of this
    /// parameter does away with the effect. The first parameter of each effect has one.
    pub neutral: Option<f64>,
    /// What a fit may try, on a problem of these magnitudes.
    pub range: fn(&Scales) -> Range,
}

/// Another effect that looks similar in the data.
pub struct Confusion {
    /// The other one.
    pub with: &'static Effect,
    /// What the two have in common in the data.
    pub why: &'static str,
    /// The experiment that distinguishes them.
    pub experiment: &'static str,
}

/// The part of a model that an effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// The contact's law, what stands beside it, and how the measured load reaches it.
    Joint,
    /// The normal direction of the contact, from which its load comes.
    NormalDirection,
    /// A mass attached to the structure at the contact.
    HungAtContact,
    /// The structure.
    Structure,
    /// A sensor: the measurement, not the machine.
    Sensor,
}

impl Part {
    /// Whether it is the contact itself: its law or its load.
    pub fn is_contact(self) -> bool {
        matches!(self, Self::Joint | Self::NormalDirection)
    }

    /// Whether there is no such part without a contact.
    pub fn needs_contact(self) -> bool {
        self.is_contact() || self == Self::HungAtContact
    }

    /// Whether an FMU of the model has it: the normal load comes in from outside, and sensors belong to measurements.
    pub fn is_in_fmu(self) -> bool {
        !matches!(self, Self::NormalDirection | Self::Sensor)
    }
}

/// What kind of place an effect has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceKind {
    /// None, or the only one there is: the contact, the clamp.
    Nowhere,
    /// A mass of an oscillator or a position on a beam: `at = "m2"`, `at = "x=0.55"`.
    Structure,
    /// A measured channel: `channel = "displacement:m1"`.
    Channel,
}

/// `kind` of a model.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// A contact alone, with prescribed motion.
    Contact,
    /// Masses and springs.
    Oscillator,
    /// The beam with a frictional support.
    Beam,
    /// The beam whose pin slips and slaps.
    PinRig,
}

impl Kind {
    /// The name in model files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Contact => "contact",
            Self::Oscillator => "oscillator",
            Self::Beam => "beam",
            Self::PinRig => "pin_rig",
        }
    }
}

/// All kinds.
pub const ALL_KINDS: &[Kind] = &[Kind::Contact, Kind::Oscillator, Kind::Beam, Kind::PinRig];

/// What a record must contain for an effect to show.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Needs {
    /// Nothing beyond what its kind of model needs.
    Nothing,
    /// A measured normal load that varies.
    VaryingNormalLoad,
    /// A measured normal displacement and normal load, and a model with `contact.normal_stiffness`.
    NormalMotion,
    /// A start from rest: over a steady state the effect has no meaning.
    Transient,
}

/// What a table, of resonances against the level or of a stepped sine, shows of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InTables {
    /// All that is measured.
    Shown,
    /// Of resonances the damping ratios: it does not shift a frequency at phase resonance.
    DampingAlone,
    /// Of a fault of a sensor: columns of these quantities, and why no other.
    Columns(&'static [&'static str], &'static str),
}

impl Effect {
    /// Why it looks like `other`, and the experiment that distinguishes the two, where that is known.
    ///
    /// ```
    /// use stickslip::effects;
    /// let [one, other] = ["wear", "velocity_weakening"].map(|id| effects::find(id).unwrap());
    /// assert_eq!(one.confusion(other).unwrap().why, other.confusion(one).unwrap().why);
    /// ```
    pub fn confusion(&self, other: &Effect) -> Option<&'static Confusion> {
        let of = |one: &Effect, other: &Effect| one.confused_with.iter().find(|pair| pair.with == other);
        of(self, other).or_else(|| of(other, self))
    }

    /// The value of the first parameter at which the effect vanishes, infinite if it does towards large values.
    pub fn neutral(&self) -> f64 {
        self.parameters.first().and_then(|parameter| parameter.neutral).unwrap_or(0.0)
    }

    /// Whether it puts many sliders in the place of a law's one, which a law without such a slider does not take.
    pub fn splits_slider(&self) -> bool {
        let starts = self.parameters.iter().map(|parameter| (parameter.range)(&Scales::default()).starts[0]);
        let mut changes = Changes::default();
        (self.apply)(&starts.collect::<Vec<_>>(), None, &mut changes);
        changes.joint.spread != 0.0
    }
}

impl PartialEq for Effect {
    fn eq(&self, other: &Self) -> bool {
        self.id == other.id
    }
}

impl std::fmt::Debug for Effect {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Effect({})", self.id)
    }
}
