//! Values of variables by their kinds: FMI sets and reads each kind by a function of its own.

use stickslip::cosim::{Kind, Severity, SlaveError};

use super::FmuSlave;
use super::component::Component;
use crate::component::Error;

/// Real variables and their value references: a master sets and reads the same ones step by step.
#[derive(Debug, Default)]
pub(super) struct Reals {
    count: usize,
    /// Positions in the table, then value references: side by side in memory.
    numbers: Vec<u32>,
}

impl Reals {
    /// The value references, if these are `variables`, of which there is one at least.
    #[inline]
    pub fn references_of(&self, variables: &[usize]) -> Option<&[u32]> {
        if variables.len() != self.count || self.count == 0 {
            return None;
        }
        let (positions, references) = self.numbers.split_at(self.count);
        let same = positions.iter().zip(variables).all(|(one, other)| *one as usize == *other);
        same.then_some(references)
    }

    fn note(&mut self, variables: &[usize], references: &[u32]) {
        self.count = variables.len();
        self.numbers.clear();
        self.numbers.extend(variables.iter().map(|variable| *variable as u32));
        self.numbers.extend_from_slice(references);
    }
}

impl FmuSlave {
    /// The first of `variables` and those after it that are of one kind; their references are noted down.
    #[inline]
    fn run(&mut self, variables: &[usize]) -> Result<(Kind, usize), SlaveError> {
        self.references.clear();
        let mut kind = None;
        for variable in variables {
            let Some(row) = self.table.get(*variable) else {
                let message = format!("there is no variable number {variable}");
                return Err(SlaveError { slave: self.name.clone(), message, severity: Severity::Call });
            };
            if *kind.get_or_insert(row.kind) != row.kind {
                break;
            }
            self.references.push(row.reference);
        }
        Ok((kind.unwrap_or(Kind::Real), self.references.len()))
    }

    /// Whole numbers for variables of `kind`.
    fn whole(&mut self, kind: Kind, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        self.numbers.clear();
        for (variable, value) in variables.iter().zip(values) {
            let fits = *value == value.trunc() && value.abs() <= f64::from(i32::MAX);
            self.numbers.push(match kind {
                Kind::Boolean => i32::from(*value != 0.0),
                _ if fits => *value as i32,
                _ => {
                    let name = self.named(&[*variable]);
                    return Err(self.refused(format!("{name} is a whole number and cannot be {value}")));
                }
            });
        }
        Ok(())
    }

    /// Runs of variables of one kind after another.
    #[cold]
    pub(super) fn set_of_all_kinds(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        if variables.len() != values.len() {
            return Err(self.refused(format!("{} variables, but {} values", variables.len(), values.len())));
        }
        if matches!(self.slave, Component::Three(_)) && !self.are_plain(variables) {
            return self.set_of_all_types(variables, values);
        }
        let mut at = 0;
        while at < variables.len() {
            let (kind, count) = self.run(&variables[at..])?;
            let (these, numbers) = (&variables[at..at + count], &values[at..at + count]);
            let done = if kind == Kind::Real {
                self.slave.set_real(&self.references, numbers)
            } else {
                self.whole(kind, these, numbers)?;
                match (&mut self.slave, kind) {
                    (Component::Two(slave), Kind::Boolean) => {
                        slave.set_boolean(&self.references, &self.numbers)
                    }
                    (Component::Two(slave), _) => slave.set_integer(&self.references, &self.numbers),
                    (Component::Three(_), _) => Err(Error::Missing("fmi3SetInt32")),
                }
            };
            if let Err(error) = done {
                return Err(self.not_set(error, these, numbers));
            }
            if kind == Kind::Real && count == variables.len() {
                self.inputs.note(variables, &self.references);
            }
            at += count;
        }
        Ok(())
    }

    /// Runs of variables of one kind after another.
    #[cold]
    pub(super) fn get_of_all_kinds(
        &mut self,
        variables: &[usize],
        values: &mut [f64],
    ) -> Result<(), SlaveError> {
        if variables.len() != values.len() {
            return Err(self.refused(format!("{} variables, but {} values", variables.len(), values.len())));
        }
        if matches!(self.slave, Component::Three(_)) && !self.are_plain(variables) {
            return self.get_of_all_types(variables, values);
        }
        let mut at = 0;
        while at < variables.len() {
            let (kind, count) = self.run(&variables[at..])?;
            let these = &variables[at..at + count];
            let numbers = &mut values[at..at + count];
            let done = if kind == Kind::Real {
                self.slave.get_real(&self.references, numbers)
            } else {
                self.numbers.clear();
                self.numbers.resize(count, 0);
                let done = match (&mut self.slave, kind) {
                    (Component::Two(slave), Kind::Boolean) => {
                        slave.get_boolean(&self.references, &mut self.numbers)
                    }
                    (Component::Two(slave), _) => slave.get_integer(&self.references, &mut self.numbers),
                    (Component::Three(_), _) => Err(Error::Missing("fmi3GetInt32")),
                };
                for (value, number) in numbers.iter_mut().zip(&self.numbers) {
                    // Any number but zero is true.
                    *value = if kind == Kind::Boolean {
                        f64::from(u8::from(*number != 0))
                    } else {
                        f64::from(*number)
                    };
                }
                done
            };
            if let Err(error) = done {
                return Err(self.not_read(error, these));
            }
            if kind == Kind::Real && count == variables.len() {
                self.outputs.note(variables, &self.references);
            }
            at += count;
        }
        Ok(())
    }

    #[cold]
    pub(super) fn not_set(&mut self, error: Error, variables: &[usize], values: &[f64]) -> SlaveError {
        let (names, shown) = (self.named(variables), &values[..values.len().min(6)]);
        self.failed(error, || format!("setting {names} to {shown:?}"))
    }

    #[cold]
    pub(super) fn not_read(&mut self, error: Error, variables: &[usize]) -> SlaveError {
        let names = self.named(variables);
        self.failed(error, || format!("reading {names}"))
    }

    /// Notes down the references of `variables`, which must all be Real.
    pub(super) fn references_of(&mut self, variables: &[usize]) -> Result<(), SlaveError> {
        let (_, count) = self.run(variables)?;
        if count == variables.len()
            && variables.iter().all(|variable| self.table[*variable].kind == Kind::Real)
        {
            return Ok(());
        }
        Err(self
            .refused(format!("{}: not all are Real, and only those have derivatives", self.named(variables))))
    }
}
