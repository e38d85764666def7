//! What the master sees of an FMU: its variables, and what it can do.

use std::collections::BTreeSet;
use std::sync::Arc;

use stickslip::cosim::{Abilities, Causality, Kind, Variable};
use stickslip::fmi::INPUT_DERIVATIVE_ORDER;

use crate::description::{FmiVersion, ModelDescription, Passed, ScalarVariable, TypeOfVariable};
use crate::fmi3::Format;

/// The variables that are numbers, in the order of the description, as the master sees them.
pub(crate) fn table(description: &ModelDescription) -> Vec<Variable> {
    let mut known = Dependencies::new(description);
    let rows = description.variables.iter().enumerate().filter(|(_, variable)| variable.kind.is_number());
    rows.map(|(position, variable)| Variable {
        name: Arc::clone(&variable.name),
        reference: variable.reference,
        kind: match variable.kind {
            TypeOfVariable::Boolean => Kind::Boolean,
            TypeOfVariable::Integer | TypeOfVariable::Enumeration(_) => Kind::Integer,
            _ => Kind::Real,
        },
        causality: variable.causality,
        unit: variable.unit.clone(),
        start: variable.start.as_deref().and_then(start_number),
        depends_on: if variable.causality == Causality::Output { known.of(position) } else { None },
    })
    .collect()
}

/// Positions in the description, or in the table.
type Positions = Arc<[usize]>;

/// Dependencies as the master sees them: positions in the table, which has no texts, of inputs alone.
struct Dependencies<'d> {
    description: &'d ModelDescription,
    /// Positions in the description of what is not in the table, in order.
    absent: Vec<usize>,
    /// The declaration that was translated last, and what it became: elements of an array have the same one.
    last: Option<(&'d Positions, Positions)>,
}

impl<'d> Dependencies<'d> {
    fn new(description: &'d ModelDescription) -> Self {
        let rows = description.variables.iter().enumerate();
        let absent = rows.filter(|(_, row)| !row.kind.is_number()).map(|(position, _)| position).collect();
        Self { description, absent, last: None }
    }

    /// Those of the output at `position` in the description, if it declares them.
    fn of(&mut self, position: usize) -> Option<Positions> {
        let declared = self.description.dependencies.get(&position)?;
        if let Some((last, translated)) = &self.last
            && Arc::ptr_eq(last, declared)
        {
            return Some(Arc::clone(translated));
        }
        let inputs = declared.iter().filter(|on| {
            let row = &self.description.variables[**on];
            row.causality == Causality::Input && row.kind.is_number()
        });
        let translated: Positions =
            inputs.map(|on| on - self.absent.partition_point(|absent| absent < on)).collect();
        self.last = Some((declared, Arc::clone(&translated)));
        Some(translated)
    }
}

pub(crate) fn name_unit(table: &mut [Variable], variable: &str, unit: &str) {
    let row = table.iter_mut().find(|row| *row.name == *variable && row.unit.is_none());
    if let Some(row) = row {
        row.unit = Some(unit.into());
    }
}

impl TypeOfVariable {
    /// Whether the master can pass it on: texts and binary data are not for it.
    pub(crate) fn is_number(&self) -> bool {
        !matches!(self, Self::String | Self::Opaque)
    }
}

fn start_number(text: &str) -> Option<f64> {
    match text.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        other => other.parse().ok(),
    }
}

/// Whether an FMU asks for every input that is a floating point number within its steps, and has one.
fn told_within_steps(description: &ModelDescription) -> bool {
    let mut inputs = description
        .variables
        .iter()
        .filter(|variable| variable.causality == Causality::Input && variable.kind == TypeOfVariable::Real);
    let count = inputs.clone().count();
    description.co_simulation.intermediate_update
        && count > 0
        && inputs.all(ScalarVariable::is_told_within_steps)
}

impl ScalarVariable {
    fn is_told_within_steps(&self) -> bool {
        let Passed { format, size, intermediate, .. } = self.passed;
        self.causality == Causality::Input && intermediate && size == 1 && format == Format::Float64
    }
}

impl ModelDescription {
    /// Value references of the inputs for which the FMU asks within its steps.
    pub(crate) fn told_within_steps(&self) -> Vec<u32> {
        let asked = self.co_simulation.intermediate_update;
        let rows = self.variables.iter().filter(|row| asked && row.is_told_within_steps());
        // An alias has the same.
        rows.map(|row| row.reference).collect::<BTreeSet<_>>().into_iter().collect()
    }
}

/// What an FMU can do for the master.
pub(crate) fn abilities(description: &ModelDescription) -> Abilities {
    let own = &description.co_simulation;
    let told = told_within_steps(description);
    Abilities {
        saves_state: own.saves_state,
        variable_step: own.variable_step,
        interpolates_inputs: own.interpolates_inputs || told,
        // FMI 2.0 has no word for it: others are only sure to know the first. In FMI 3.0 they are told the values
        // themselves, at as many times as they ask for.
        input_derivative_order: match description.generation_tool.as_deref() {
            _ if told => INPUT_DERIVATIVE_ORDER,
            Some(tool) if tool.starts_with("stickslip ") && description.version == FmiVersion::Two => {
                INPUT_DERIVATIVE_ORDER
            }
            _ => u32::from(own.interpolates_inputs),
        },
        output_derivative_order: own.output_derivative_order,
        directional_derivatives: own.directional_derivatives,
    }
}
