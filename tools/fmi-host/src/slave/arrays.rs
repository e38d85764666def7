//! Values of FMI 3.0, where a value reference may be that of an array and every type has functions of its own.

use stickslip::cosim::SlaveError;

use super::FmuSlave;
use super::component::Component;
use crate::component::Error;
use crate::fmi3::{Format, Slave3};

/// Value references, each once, and where the elements of variables are among all their values.
#[derive(Debug, Default)]
struct Spread {
    references: Vec<u32>,
    /// Of each variable.
    places: Vec<usize>,
    /// Number of values of all references.
    length: usize,
}

impl FmuSlave {
    /// Whether all of `variables` are passed by one call of `fmi3GetFloat64`.
    pub(super) fn are_plain(&self, variables: &[usize]) -> bool {
        variables.iter().all(|variable| {
            self.passed
                .get(*variable)
                .is_some_and(|passed| passed.format == Format::Float64 && passed.size == 1)
        })
    }

    fn spread(&self, variables: &[usize]) -> Spread {
        let mut spread = Spread::default();
        let mut begins: Vec<usize> = Vec::new();
        for variable in variables {
            let (reference, passed) = (self.table[*variable].reference, self.passed[*variable]);
            let known = spread.references.iter().position(|other| *other == reference);
            let known = known.unwrap_or_else(|| {
                spread.references.push(reference);
                begins.push(spread.length);
                spread.length += passed.size as usize;
                spread.references.len() - 1
            });
            spread.places.push(begins[known] + passed.element as usize);
        }
        spread
    }

    /// Reads variables of any type, the elements of an array that stand side by side by one call.
    pub(super) fn get_of_all_types(
        &mut self,
        variables: &[usize],
        values: &mut [f64],
    ) -> Result<(), SlaveError> {
        self.check_known(variables)?;
        let mut array: (Option<u32>, Vec<f64>) = (None, Vec::new());
        for (variable, value) in variables.iter().zip(values) {
            let (reference, passed) = (self.table[*variable].reference, self.passed[*variable]);
            if array.0 != Some(reference) || passed.size == 1 {
                array = (Some(reference), vec![0.0; passed.size as usize]);
                let done = self.three()?.get_numbers(passed.format, reference, &mut array.1);
                done.map_err(|error| self.not_read(error, &[*variable]))?;
            }
            *value = array.1[passed.element as usize];
        }
        Ok(())
    }

    /// Sets variables of any type; of an array the other elements stay.
    pub(super) fn set_of_all_types(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        self.check_known(variables)?;
        let mut at = 0;
        while at < variables.len() {
            let first = variables[at];
            let (reference, passed) = (self.table[first].reference, self.passed[first]);
            let same = |variable: &usize| passed.size > 1 && self.table[*variable].reference == reference;
            let count = 1 + variables[at + 1..].iter().take_while(|variable| same(variable)).count();
            let mut all = vec![0.0; passed.size as usize];
            if count < passed.size as usize {
                let done = self.three()?.get_numbers(passed.format, reference, &mut all);
                done.map_err(|error| self.not_read(error, &[first]))?;
            }
            for (variable, value) in variables[at..at + count].iter().zip(&values[at..]) {
                if !passed.format.holds(*value) {
                    let name = self.named(&[*variable]);
                    return Err(
                        self.refused(format!("{name} is of type {:?} and cannot be {value}", passed.format))
                    );
                }
                all[self.passed[*variable].element as usize] = *value;
            }
            let done = self.three()?.set_numbers(passed.format, reference, &all);
            let range = at..at + count;
            done.map_err(|error| self.not_set(error, &variables[range.clone()], &values[range]))?;
            at += count;
        }
        Ok(())
    }

    /// Derivatives of outputs of FMI 3.0 with respect to time.
    pub(super) fn output_derivatives_3(
        &mut self,
        variables: &[usize],
        order: i32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        let spread = self.spread(variables);
        let mut all = vec![0.0; spread.length];
        let done = self.three()?.get_output_derivatives(&spread.references, order, &mut all);
        done.map_err(|error| {
            let names = self.named(variables);
            self.failed(error, || format!("reading derivatives of {names}"))
        })?;
        derivatives.iter_mut().zip(spread.places).for_each(|(derivative, place)| *derivative = all[place]);
        Ok(())
    }

    /// The directional derivative of FMI 3.0.
    pub(super) fn directional_derivative_3(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), Error> {
        let (of, by) = (self.spread(unknowns), self.spread(knowns));
        let (mut seed, mut sensitivity) = (vec![0.0; by.length], vec![0.0; of.length]);
        by.places.iter().zip(direction).for_each(|(place, value)| seed[*place] += value);
        let Component::Three(slave) = &mut self.slave else {
            return Err(Error::Missing("fmi3GetDirectionalDerivative"));
        };
        slave.directional_derivative(&of.references, &by.references, &seed, &mut sensitivity)?;
        change.iter_mut().zip(of.places).for_each(|(change, place)| *change = sensitivity[place]);
        Ok(())
    }

    fn three(&mut self) -> Result<&mut Slave3, SlaveError> {
        match &mut self.slave {
            Component::Three(slave) => Ok(slave),
            Component::Two(_) => Err(SlaveError {
                slave: self.name.clone(),
                message: "a function of FMI 3.0 for an FMU of FMI 2.0".to_owned(),
                severity: stickslip::cosim::Severity::Call,
            }),
        }
    }

    fn check_known(&self, variables: &[usize]) -> Result<(), SlaveError> {
        match variables.iter().find(|variable| **variable >= self.table.len()) {
            None => Ok(()),
            Some(other) => Err(self.refused(format!("there is no variable number {other}"))),
        }
    }
}
