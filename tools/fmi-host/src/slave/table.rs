//! What the master sees of an FMU: its variables, and what it can do.

use stickslip::cosim::{Abilities, Causality, Kind, Variable};
use stickslip::fmi::INPUT_DERIVATIVE_ORDER;

use crate::description::{ModelDescription, TypeOfVariable};

/// The variables that are numbers, in the order of the description, as the master sees them.
pub(crate) fn table(description: &ModelDescription) -> Vec<Variable> {
    // Positions in the description become positions in the table, which has no texts.
    let mut positions = Vec::new();
    let mut next = 0;
    for variable in &description.variables {
        positions.push(next);
        next += usize::from(variable.kind != TypeOfVariable::String);
    }
    let rows = description.variables.iter().filter(|variable| variable.kind != TypeOfVariable::String);
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
                    other.causality == Causality::Input && other.kind != TypeOfVariable::String
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

fn start_number(text: &str) -> Option<f64> {
    match text.trim() {
        "true" => Some(1.0),
        "false" => Some(0.0),
        other => other.parse().ok(),
    }
}

/// What an FMU can do for the master.
pub(crate) fn abilities(description: &ModelDescription) -> Abilities {
    let own = &description.co_simulation;
    Abilities {
        saves_state: own.saves_state,
        variable_step: own.variable_step,
        interpolates_inputs: own.interpolates_inputs,
        // FMI 2.0 has no word for it: others are only sure to know the first.
        input_derivative_order: match description.generation_tool.as_deref() {
            Some(tool) if tool.starts_with("stickslip ") => INPUT_DERIVATIVE_ORDER,
            _ => u32::from(own.interpolates_inputs),
        },
        output_derivative_order: own.output_derivative_order,
        directional_derivatives: own.directional_derivatives,
    }
}
