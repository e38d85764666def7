//! Values of an instance's variables, read and set.

use super::description::{Causality, Variable, VariableType};
use super::error::Error;
use super::instance::Instance;
use super::stage::Stage;

/// No physical input in SI units is larger; products of a few stay finite.
pub(super) const LARGEST_INPUT: f64 = 1e30;

impl Instance {
    /// Reads Real variables into `values`.
    ///
    /// # Errors
    /// An unknown or Integer variable; before the first step also parameters that make no model.
    pub fn get_real(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        self.check_rows(references, VariableType::Real)?;
        self.read_rows(references, values)
    }

    /// Reads variables of any type into `values`.
    #[cfg(feature = "analysis")]
    pub(crate) fn read(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        references.iter().try_for_each(|reference| self.variable(*reference).map(drop))?;
        self.read_rows(references, values)
    }

    /// Reads rows that exist, of any type.
    #[inline(always)]
    fn read_rows(&mut self, references: &[u32], values: &mut [f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        // What was set is read as it is, whether it makes a model or not.
        let rows = &self.shared.description.variables;
        let set = |reference: &u32| {
            matches!(rows[*reference as usize].causality, Causality::Input | Causality::Parameter)
        };
        if self.stale && !references.iter().all(set) {
            self.refresh()?;
        }
        let first_local = self.shared.parameters().end;
        if !self.is_continuous() && references.iter().any(|reference| *reference as usize >= first_local) {
            let mut indicators = vec![0.0; self.shared.description.continuous.indicators];
            self.show_modes(&mut indicators)?;
        }
        for (reference, value) in references.iter().zip(values) {
            *value = self.values[*reference as usize];
        }
        Ok(())
    }

    /// Reads Integer variables into `values`.
    ///
    /// # Errors
    /// As [`Instance::get_real`].
    pub fn get_integer(&mut self, references: &[u32], values: &mut [i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Integer)?;
        self.refresh()?;
        for (reference, value) in references.iter().zip(values) {
            *value = self.values[*reference as usize] as i32;
        }
        Ok(())
    }

    /// Sets Real inputs and, until the initialization ends, parameters. Sets all or none.
    ///
    /// # Errors
    /// An unknown, Integer or not settable variable, or a value outside its bounds.
    pub fn set_real(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        self.check_rows(references, VariableType::Real)?;
        self.write(references, values)
    }

    /// Sets variables of any type. Sets all or none.
    pub(crate) fn write(&mut self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_values(references, values)?;
        for (reference, value) in references.iter().zip(values) {
            self.values[*reference as usize] = *value;
        }
        self.stale |= !references.is_empty() && self.stage != Stage::StepComplete;
        Ok(())
    }

    /// Whether inputs may have these values, now or within the next step.
    ///
    /// # Errors
    /// As [`Instance::set_real`].
    pub fn check_inputs(&self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Real)?;
        self.check_values(references, values)
    }

    #[inline(always)]
    fn check_values(&self, references: &[u32], values: &[f64]) -> Result<(), Error> {
        for (reference, value) in references.iter().zip(values) {
            let variable = self.variable(*reference)?;
            self.check_settable(variable)?;
            check_value(variable, *value)?;
        }
        Ok(())
    }

    /// Sets Integer variables; no model has one that may be set.
    ///
    /// # Errors
    /// Always, unless `references` is empty.
    pub fn set_integer(&mut self, references: &[u32], values: &[i32]) -> Result<(), Error> {
        same_length(references.len(), values.len())?;
        self.check_rows(references, VariableType::Integer)?;
        let values: Vec<f64> = values.iter().copied().map(f64::from).collect();
        self.write(references, &values)
    }

    pub(super) fn check_rows(&self, references: &[u32], asked: VariableType) -> Result<(), Error> {
        for reference in references {
            let variable = self.variable(*reference)?;
            if variable.variable_type != asked {
                return Err(wrong_type(variable, type_name(asked)));
            }
        }
        Ok(())
    }

    /// The error for a value reference asked as a type that no variable of any model has.
    pub fn no_variable_of_type(&self, reference: u32, asked: &'static str) -> Error {
        match self.variable(reference) {
            Ok(variable) => wrong_type(variable, asked),
            Err(unknown) => unknown,
        }
    }

    #[inline(always)]
    fn variable(&self, reference: u32) -> Result<&Variable, Error> {
        let variables = &self.shared.description.variables;
        variables.get(reference as usize).ok_or_else(|| unknown(reference, variables))
    }

    #[inline(always)]
    pub(super) fn check_settable(&self, variable: &Variable) -> Result<(), Error> {
        let settable = match variable.causality {
            Causality::Input => !matches!(self.stage, Stage::StepFailed | Stage::Terminated),
            Causality::Parameter => matches!(self.stage, Stage::Instantiated | Stage::Initialization),
            Causality::Output | Causality::Local => false,
        };
        if settable { Ok(()) } else { Err(not_settable(variable)) }
    }
}

// Errors are made out of the way of calls that succeed.

#[cold]
fn unknown(reference: u32, variables: &[Variable]) -> Error {
    Error::UnknownReference { reference, largest: variables.len() - 1 }
}

#[cold]
fn not_settable(variable: &Variable) -> Error {
    let reason = match variable.causality {
        Causality::Input => "the simulation cannot go on from here",
        Causality::Parameter => "a fixed parameter is settled when the initialization ends",
        Causality::Output => "it is an output",
        Causality::Local => "it is a continuous state or a derivative of one",
    };
    Error::NotSettable { name: variable.name.to_string(), reason }
}

/// Whether `variable` may be `value`.
#[inline(always)]
pub(super) fn check_value(variable: &Variable, value: f64) -> Result<(), Error> {
    let allowed = value.abs() <= LARGEST_INPUT && variable.allows(value);
    if allowed { Ok(()) } else { Err(wrong_value(variable, value)) }
}

#[cold]
fn wrong_value(variable: &Variable, value: f64) -> Error {
    let bounds = if value.abs() > LARGEST_INPUT && value.is_finite() {
        format!("at most {LARGEST_INPUT:e} in magnitude")
    } else {
        variable.bounds()
    };
    Error::Value { name: variable.name.to_string(), value, bounds }
}

#[inline]
pub(super) fn same_length(references: usize, values: usize) -> Result<(), Error> {
    if references == values { Ok(()) } else { Err(Error::Lengths { references, values }) }
}

fn type_name(variable_type: VariableType) -> &'static str {
    match variable_type {
        VariableType::Real => "Real",
        VariableType::Integer => "Integer",
    }
}

#[cold]
fn wrong_type(variable: &Variable, asked: &'static str) -> Error {
    Error::WrongType { name: variable.name.to_string(), is: type_name(variable.variable_type), asked }
}
