//! What the master sees of an FMU: its variables, and what it can do.

use std::collections::BTreeSet;

use stickslip::cosim::{Abilities, Causality, Kind, Variable};
use stickslip::fmi::INPUT_DERIVATIVE_ORDER;

use crate::description::{FmiVersion, ModelDescription, Passed, ScalarVariable, TypeOfVariable};
use crate::fmi3::Format;

/// The variables that are numbers, in the order of the description, as the master sees them.
pub(crate) fn table(description: &ModelDescription) -> Vec<Variable> {
    // Positions in the description become positions in the table, which has no texts.
    let mut positions = Vec::new();
    let mut next = 0;
    for variable in &description.variables {
        positions.push(next);
        next += usize::from(variable.kind.is_number());
    }
    let rows = description.variables.iter().filter(|variable| variable.kind.is_number());
    rows.map(|variable| Variable {
        name: variable.name.clone(),
        reference: variable.reference,
        kind: match variable.kind {
            TypeOfVariable::Boolean => Kind::Boolean,
            TypeOfVariable::Integer | TypeOfVariable::Enumeration(_) => Kind::Integer,
            _ => Kind::Real,
        },
        causality: variable.causality,
        unit: variable.unit.clone(),
        start: variable.start.as_deref().and_then(start_number),
        depends_on: variable.depends_on.as_ref().filter(|_| variable.causality == Causality::Output).map(
            |on| {
                let numbers = on.iter().filter(|other| {
                    let other = &description.variables[**other];
                    other.causality == Causality::Input && other.kind.is_number()
                });
                numbers.map(|other| positions[*other]).collect()
            },
        ),
    })
    .collect()
}

pub(crate) fn name_unit(table: &mut [Variable], variable: &str, unit: &str) {
    let row = table.iter_mut().find(|row| row.name == variable && row.unit.is_none());
    if let Some(row) = row {
        row.unit = Some(unit.to_owned());
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
