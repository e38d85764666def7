//! A slave whose output is a function of time.

use super::{Abilities, Causality, Kind, Setup, Severity, Slave, SlaveError, Stepped, Variable};
use std::fmt;
use std::sync::Arc;

/// One output, given by a function of time: an exciter.
pub struct Source {
    name: String,
    table: [Variable; 1],
    value: Box<dyn Fn(f64) -> f64 + Send>,
    derivative: Option<Box<dyn Fn(f64) -> f64 + Send>>,
    corners: bool,
    time: f64,
    saved: Vec<f64>,
}

impl fmt::Debug for Source {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("Source")
            .field("name", &self.name)
            .field("time", &self.time)
            .finish_non_exhaustive()
    }
}

impl Source {
    /// A slave called `name` with the one output `variable`, of unit `unit`, that is `value` of the time (s).
    pub fn new(name: &str, variable: &str, unit: &str, value: impl Fn(f64) -> f64 + Send + 'static) -> Self {
        let variable = Variable {
            name: variable.into(),
            reference: 0,
            kind: Kind::Real,
            causality: Causality::Output,
            unit: Some(unit.into()),
            start: None,
            depends_on: Some(Arc::default()),
        };
        let value = Box::new(value);
        Self {
            name: name.to_owned(),
            table: [variable],
            value,
            derivative: None,
            corners: false,
            time: 0.0,
            saved: Vec::new(),
        }
    }

    /// The same with its derivative with respect to time (per second).
    pub fn with_derivative(self, derivative: impl Fn(f64) -> f64 + Send + 'static) -> Self {
        Self { derivative: Some(Box::new(derivative)), ..self }
    }

    /// The same, straight between communication points with corners at them.
    pub fn with_corners(self) -> Self {
        Self { corners: true, ..self }
    }

    fn refuse<T>(&self, message: &str) -> Result<T, SlaveError> {
        Err(SlaveError { slave: self.name.clone(), message: message.to_owned(), severity: Severity::Call })
    }
}

impl Slave for Source {
    fn name(&self) -> &str {
        &self.name
    }

    fn variables(&self) -> &[Variable] {
        &self.table
    }

    fn has_corners(&self) -> bool {
        self.corners
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            saves_state: true,
            variable_step: true,
            output_derivative_order: u32::from(self.derivative.is_some()),
            ..Abilities::default()
        }
    }

    fn set_up(&mut self, setup: Setup) -> Result<(), SlaveError> {
        self.time = setup.start;
        Ok(())
    }

    fn set(&mut self, variables: &[usize], _values: &[f64]) -> Result<(), SlaveError> {
        if variables.is_empty() { Ok(()) } else { self.refuse("it has no variable that can be set") }
    }

    fn get(&mut self, _variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        values.fill((self.value)(self.time));
        Ok(())
    }

    fn output_derivatives(
        &mut self,
        _variables: &[usize],
        order: u32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        match &self.derivative {
            Some(derivative) if order == 1 => derivatives.fill(derivative(self.time)),
            _ => return self.refuse("it gives no derivative of this order"),
        }
        Ok(())
    }

    fn directional_derivative(
        &mut self,
        _unknowns: &[usize],
        _knowns: &[usize],
        _direction: &[f64],
        _change: &mut [f64],
    ) -> Result<(), SlaveError> {
        self.refuse("it has no inputs to differentiate by")
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        self.time = time + step;
        Ok(Stepped::Done)
    }

    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        if self.saved.len() <= slot {
            self.saved.resize(slot + 1, f64::NAN);
        }
        self.saved[slot] = self.time;
        Ok(())
    }

    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        match self.saved.get(slot) {
            Some(time) if !time.is_nan() => self.time = *time,
            _ => return self.refuse("nothing was saved there"),
        }
        Ok(())
    }

    fn terminate(&mut self) -> Result<(), SlaveError> {
        Ok(())
    }
}
