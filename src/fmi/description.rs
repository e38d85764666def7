//! The variable table of a model: what XML, documentation, value dispatch and GUID are made from.

use super::continuous::ContinuousForm;
use crate::vocabulary::Quantity;
use std::borrow::Cow;
use std::fmt::Write as _;
use uuid::Uuid;

/// Name space of the GUIDs: any fixed number, the project's own.
const NAMESPACE: Uuid = Uuid::from_u128(0x9d0a_2f5e_7c0b_5b7e_8f1c_6a5d_3e42_91b7);

/// Type of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VariableType {
    /// A floating point number.
    Real,
    /// A whole number.
    Integer,
}

/// Who sets a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Causality {
    /// Set by the user before the simulation.
    Parameter,
    /// Set by other models during the simulation.
    Input,
    /// Computed by the model.
    Output,
    /// A continuous state, or its derivative.
    Local,
}

/// When a variable may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Not after initialization.
    Fixed,
    /// At certain instants.
    Discrete,
    /// At any time.
    Continuous,
}

/// How the initial value is found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Initial {
    /// The start value.
    Exact,
    /// Computed in the initialization.
    Calculated,
}

/// How an unknown depends on a known variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DependencyKind {
    /// In any way.
    Dependent,
    /// Linearly, with a factor fixed by the parameters.
    Fixed,
}

/// An output's dependency on another variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Dependency {
    /// Value reference of the known variable.
    pub on: u32,
    /// How it enters.
    pub kind: DependencyKind,
}

/// One row of the table. Its value reference is its position.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Unique name: a [`Quantity::name`], for sensors, masses and further contacts with a place, as `displacement:x=0.55`.
    pub name: Cow<'static, str>,
    /// One line for an engineer.
    pub description: Cow<'static, str>,
    /// Unit, bounds and nominal value.
    pub quantity: &'static Quantity,
    /// Type.
    pub variable_type: VariableType,
    /// Who sets it.
    pub causality: Causality,
    /// Start value of parameters and inputs; 0 for outputs, which have none.
    pub start: f64,
    /// It changes at certain instants, though it is Real.
    pub discrete: bool,
    /// The lower bound is legal itself although the quantity's interval is open.
    pub includes_min: bool,
    /// What an output depends on at a communication point.
    pub dependencies: Vec<Dependency>,
    /// What an output depends on at the end of the initialization.
    pub initial_dependencies: Vec<Dependency>,
}

impl Variable {
    fn new(quantity: &'static Quantity, causality: Causality, start: f64) -> Self {
        Self {
            name: Cow::Borrowed(quantity.name),
            description: Cow::Borrowed(quantity.description),
            quantity,
            variable_type: VariableType::Real,
            causality,
            start,
            discrete: false,
            includes_min: !quantity.open,
            dependencies: Vec::new(),
            initial_dependencies: Vec::new(),
        }
    }

    /// A fixed parameter.
    pub(crate) fn parameter(quantity: &'static Quantity, start: f64) -> Self {
        Self::new(quantity, Causality::Parameter, start)
    }

    /// A continuous input.
    pub(crate) fn input(quantity: &'static Quantity, start: f64) -> Self {
        Self::new(quantity, Causality::Input, start)
    }

    /// A continuous output.
    pub(crate) fn output(quantity: &'static Quantity) -> Self {
        Self::new(quantity, Causality::Output, 0.0)
    }

    /// A continuous state, or its derivative.
    pub(super) fn local(quantity: &'static Quantity) -> Self {
        Self::new(quantity, Causality::Local, 0.0)
    }

    /// Adds continuous states to what an output depends on.
    pub(super) fn depend_on_states(&mut self, states: &[usize]) {
        let states = states.iter().map(|row| Dependency { on: *row as u32, kind: DependencyKind::Dependent });
        self.dependencies.extend(states);
    }

    /// A continuous output of a sensor at `position` (m from the clamp).
    pub(crate) fn sensor(quantity: &'static Quantity, noun: &str, position: f64) -> Self {
        Self {
            name: Cow::Owned(format!("{}:x={position}", quantity.name)),
            description: Cow::Owned(format!("Transverse {noun} of the beam at x = {position} m")),
            ..Self::output(quantity)
        }
    }

    /// A continuous input, the force of a contact at `position` (m from the clamp).
    pub(crate) fn contact_force_at(quantity: &'static Quantity, position: f64) -> Self {
        Self {
            name: Cow::Owned(format!("{}:x={position}", quantity.name)),
            description: Cow::Owned(format!(
                "Restoring force of a contact on the beam at x = {position} m, positive when it resists positive \
                 displacement there"
            )),
            ..Self::input(quantity, 0.0)
        }
    }

    /// The same row with a whole number in it.
    pub(crate) fn integer(self) -> Self {
        Self { variable_type: VariableType::Integer, ..self }
    }

    /// The same row, which changes at certain instants only.
    pub(crate) fn discrete(self) -> Self {
        Self { discrete: true, ..self }
    }

    /// The same output with its dependencies at communication points and after initialization.
    pub(crate) fn depends(
        self,
        on: impl IntoIterator<Item = (usize, DependencyKind)>,
        initially_on: impl IntoIterator<Item = usize>,
    ) -> Self {
        let dependency = |(index, kind)| Dependency { on: index as u32, kind };
        Self {
            dependencies: on.into_iter().map(dependency).collect(),
            initial_dependencies: initially_on
                .into_iter()
                .map(|index| dependency((index, DependencyKind::Dependent)))
                .collect(),
            ..self
        }
    }

    /// When the variable may change.
    pub fn variability(&self) -> Variability {
        match (self.causality, self.variable_type) {
            (Causality::Parameter, _) => Variability::Fixed,
            (_, VariableType::Integer) => Variability::Discrete,
            (_, VariableType::Real) if self.discrete => Variability::Discrete,
            (_, VariableType::Real) => Variability::Continuous,
        }
    }

    /// How the initial value is found; an input has none.
    pub fn initial(&self) -> Option<Initial> {
        match self.causality {
            Causality::Parameter => Some(Initial::Exact),
            Causality::Input => None,
            Causality::Output | Causality::Local => Some(Initial::Calculated),
        }
    }

    /// The start value, where the table must give one.
    pub fn start(&self) -> Option<f64> {
        matches!(self.causality, Causality::Input | Causality::Parameter).then_some(self.start)
    }

    /// Finite and within the bounds?
    #[inline(always)]
    pub fn allows(&self, value: f64) -> bool {
        let Quantity { min, max, open, .. } = *self.quantity;
        value.is_finite()
            && min.is_none_or(|min| value > min || (self.includes_min && value == min))
            && max.is_none_or(|max| value < max || (!open && value == max))
    }

    /// The least and the largest number that is allowed: FMI includes its bounds, so that an open interval ends beside its
    /// own, at zero with the least number of full precision.
    pub fn allowed_range(&self) -> (Option<f64>, Option<f64>) {
        let Quantity { min, max, open, .. } = *self.quantity;
        let above = |min: f64| if min == 0.0 { f64::MIN_POSITIVE } else { min.next_up() };
        let below = |max: f64| if max == 0.0 { -f64::MIN_POSITIVE } else { max.next_down() };
        (
            min.map(|min| if self.includes_min { min } else { above(min) }),
            max.map(|max| if open { below(max) } else { max }),
        )
    }

    /// The bounds in words, for messages.
    pub fn bounds(&self) -> String {
        let Quantity { min, max, open, unit, .. } = *self.quantity;
        let mut text = String::from("a finite number");
        if let Some(min) = min {
            let _ = write!(text, ", {} {min}", if self.includes_min { "at least" } else { "above" });
        }
        if let Some(max) = max {
            let _ = write!(text, ", {} {max}", if open { "below" } else { "at most" });
        }
        if unit != "1" {
            let _ = write!(text, " (in {unit})");
        }
        text
    }
}

/// What a simulation of the model would usually run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Experiment {
    /// Start (s).
    pub start: f64,
    /// Stop (s).
    pub stop: f64,
    /// Relative tolerance of the integration inside.
    pub tolerance: f64,
    /// Communication step (s).
    pub step: f64,
}

/// A model as others see it.
#[derive(Debug, Clone, PartialEq)]
pub struct Description {
    /// Name of the model.
    pub name: &'static str,
    /// One line about it.
    pub summary: &'static str,
    /// Default experiment.
    pub experiment: Experiment,
    /// The table. First the inputs, then the outputs, then the parameters, then what [`Description::continuous`] needs.
    pub variables: Vec<Variable>,
    /// What importers that integrate themselves are given.
    pub continuous: ContinuousForm,
    /// The model file in its normal form: what no variable shows (the number of modes, positions)
    /// distinguishes models too.
    pub(crate) model: String,
}

impl Description {
    /// Identity of the model: the version 5 UUID of all that can be told of it as text, the same for the same
    /// model on any machine.
    pub fn guid(&self) -> Uuid {
        Uuid::new_v5(&NAMESPACE, self.canonical().as_bytes())
    }

    /// Everything about the model as text, the same for the same model on any machine.
    fn canonical(&self) -> String {
        let mut text = format!("stickslip slave/1\n{}\n{}\n", self.name, self.model);
        let ContinuousForm { modes, indicators } = self.continuous;
        let _ = writeln!(text, "continuous {modes} {indicators}");
        for (reference, variable) in self.variables.iter().enumerate() {
            let Variable { name, description, quantity, variable_type, causality, .. } = variable;
            let _ = writeln!(
                text,
                "{reference} {name} {variable_type:?} {causality:?} [{}] {:?} {:?} {:?} {:?} {description}",
                quantity.unit,
                quantity.min,
                quantity.max,
                quantity.nominal,
                variable.start(),
            );
            for (label, list) in
                [("on", &variable.dependencies), ("initially", &variable.initial_dependencies)]
            {
                for dependency in list {
                    let _ = writeln!(text, "  {label} {} {:?}", dependency.on, dependency.kind);
                }
            }
        }
        text
    }

    /// Value reference of the variable called `name`.
    pub fn reference(&self, name: &str) -> Option<u32> {
        self.variables.iter().position(|variable| variable.name == name).map(|index| index as u32)
    }

    /// Value references of all variables with `causality`.
    pub fn references(&self, causality: Causality) -> impl Iterator<Item = u32> + '_ {
        let rows = self.variables.iter().enumerate();
        rows.filter(move |(_, variable)| variable.causality == causality).map(|(index, _)| index as u32)
    }
}
