//! Start values of a system's variables, from its files and the command line.

use std::collections::BTreeMap;

use stickslip_fmi_host::TypeOfVariable;
use stickslip_readers::ssp::{End, Parameter, SystemStructure, Value};

use super::inputs::{Driven, check_free};
use super::parts::{Part, converted, defined, find};
use crate::Failure;

/// Start values: the last one given for a variable holds.
#[derive(Default)]
pub struct Starts {
    pub numbers: BTreeMap<(usize, String), f64>,
    pub texts: Vec<(usize, String, String)>,
}

impl Starts {
    /// A value from the system's file. One that belongs to nothing is only remarked on, as the standard wants it.
    pub fn parameter(
        &mut self,
        parts: &[Part],
        parameter: &Parameter,
        remarks: &mut Vec<String>,
    ) -> Result<(), Failure> {
        let End { component, variable } = &parameter.target;
        let part = &parts[*component];
        let Ok(own) = part.unit(variable) else {
            remarks.push(format!("{}: the value is ignored: {}", parameter.place, part.unknown(variable)));
            return Ok(());
        };
        let from = parameter.unit.as_ref().map(|unit| defined(unit, parts)).transpose();
        let linear = from.and_then(|from| converted(from.as_ref(), own.as_ref())).map_err(|reason| {
            Failure::input(format!("{}: `{}.{variable}`: {reason}", parameter.place, part.name))
        })?;
        let number = match &parameter.value {
            Value::Real(value) => *value,
            Value::Integer(value) => f64::from(*value),
            Value::Boolean(value) => f64::from(u8::from(*value)),
            Value::Text(text) => {
                self.texts.push((*component, variable.clone(), text.clone()));
                return Ok(());
            }
        };
        let value = linear.then(parameter.transformation).apply(number);
        self.numbers.insert((*component, variable.clone()), value);
        Ok(())
    }

    /// `component.variable=value`, or an input of the system.
    pub fn assignment(
        &mut self,
        parts: &[Part],
        structure: &SystemStructure,
        sources: &[Driven],
        assignment: &str,
    ) -> Result<(), Failure> {
        let Some((name, text)) = assignment.split_once('=') else {
            return Err(Failure::input(format!("`--set {assignment}` should be NAME=VALUE")));
        };
        let (name, text) = (name.trim(), text.trim());
        if let Some(input) = structure.inputs.iter().find(|input| input.name == name) {
            let value = number(name, text)?;
            for (end, route) in &input.targets {
                check_free(parts, structure, sources, end)?;
                let unit = parts[end.component].unit(&end.variable)?;
                let linear = route.linear(None, unit.as_ref());
                let linear = linear.map_err(|error| Failure::input(format!("`{name}`: {error}")))?;
                self.numbers.insert((end.component, end.variable.clone()), linear.apply(value));
            }
            return Ok(());
        }
        let (component, variable) = find(parts, name)?;
        check_free(parts, structure, sources, &End { component, variable: variable.clone() })?;
        let row = parts[component].variable(&variable)?;
        let value = match &row.kind {
            TypeOfVariable::String => {
                self.texts.push((component, variable, text.to_owned()));
                return Ok(());
            }
            TypeOfVariable::Boolean => match text {
                "true" | "1" => 1.0,
                "false" | "0" => 0.0,
                _ => return Err(Failure::input(format!("`{name}` is true or false, not `{text}`"))),
            },
            TypeOfVariable::Enumeration(items) => match items.iter().find(|(item, _)| item == text) {
                Some((_, value)) => f64::from(*value),
                None => number(name, text)?,
            },
            _ => number(name, text)?,
        };
        self.numbers.insert((component, variable), value);
        Ok(())
    }
}

fn number(name: &str, text: &str) -> Result<f64, Failure> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(Failure::input(format!("`{name}` cannot be `{text}`: it is a number"))),
    }
}
