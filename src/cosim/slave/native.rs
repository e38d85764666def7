//! The library's own models as slaves, without an FMU.

use std::sync::Arc;

use super::{Abilities, Causality, Kind, Setup, Severity, Slave, SlaveError, Stepped, Variable};
use crate::fmi::{self, DERIVATIVE_ORDER, INPUT_DERIVATIVE_ORDER, Instance, Snapshot, VariableType};
use crate::model::Model;
use crate::time::Ramp;

/// An [`Instance`] behind the trait: the same numbers as the FMU of the model.
#[derive(Debug)]
pub struct NativeSlave {
    name: String,
    instance: Instance,
    table: Vec<Variable>,
    references: Vec<u32>,
    knowns: Vec<u32>,
    lines: Vec<Ramp>,
    /// The order of a call, as often as there are variables.
    orders: Vec<i32>,
    slots: Vec<Option<Snapshot>>,
}

impl NativeSlave {
    /// A slave called `name` of `model`.
    ///
    /// # Errors
    /// Parameters that make no model.
    pub fn new(name: &str, model: &Model) -> Result<Self, fmi::Error> {
        let instance = Instance::from_model(model)?;
        let table: Vec<Variable> = instance
            .description()
            .variables
            .iter()
            .enumerate()
            .map(|(reference, row)| Variable {
                name: Arc::from(&*row.name),
                reference: reference as u32,
                kind: match row.variable_type {
                    VariableType::Real => Kind::Real,
                    VariableType::Integer => Kind::Integer,
                },
                causality: match row.causality {
                    fmi::Causality::Parameter => Causality::Parameter,
                    fmi::Causality::Input => Causality::Input,
                    fmi::Causality::Output => Causality::Output,
                    fmi::Causality::Local => Causality::Local,
                },
                unit: Some(Arc::from(row.quantity.unit)),
                start: row.start(),
                depends_on: (row.causality == fmi::Causality::Output)
                    .then(|| row.dependencies.iter().map(|other| other.on as usize).collect()),
            })
            .collect();
        Ok(Self {
            name: name.to_owned(),
            instance,
            orders: vec![0; table.len()],
            table,
            references: Vec::new(),
            knowns: Vec::new(),
            lines: Vec::new(),
            slots: Vec::new(),
        })
    }

    /// The instance.
    pub fn instance(&self) -> &Instance {
        &self.instance
    }

    fn error(&self, error: fmi::Error) -> SlaveError {
        failed(&self.name, error)
    }
}

/// Value references are positions.
fn refer(references: &mut Vec<u32>, variables: &[usize]) {
    references.clear();
    references.extend(variables.iter().map(|variable| *variable as u32));
}

#[cold]
fn failed(name: &str, error: fmi::Error) -> SlaveError {
    let severity = if matches!(error, fmi::Error::Step { .. }) { Severity::Slave } else { Severity::Call };
    SlaveError { slave: name.to_owned(), message: error.to_string(), severity }
}

#[cold]
fn unable(name: &str, what: &str) -> SlaveError {
    SlaveError { slave: name.to_owned(), message: format!("it {what}"), severity: Severity::Call }
}

impl Slave for NativeSlave {
    fn name(&self) -> &str {
        &self.name
    }

    fn variables(&self) -> &[Variable] {
        &self.table
    }

    fn abilities(&self) -> Abilities {
        Abilities {
            saves_state: true,
            variable_step: true,
            interpolates_inputs: true,
            input_derivative_order: INPUT_DERIVATIVE_ORDER,
            output_derivative_order: DERIVATIVE_ORDER,
            directional_derivatives: true,
        }
    }

    fn set_up(&mut self, setup: Setup) -> Result<(), SlaveError> {
        let setup = fmi::Setup { tolerance: setup.tolerance, start: setup.start, stop: setup.stop };
        self.instance.set_up(setup).map_err(|error| self.error(error))
    }

    fn enter_initialization(&mut self) -> Result<(), SlaveError> {
        self.instance.enter_initialization().map_err(|error| self.error(error))
    }

    fn exit_initialization(&mut self) -> Result<(), SlaveError> {
        self.instance.exit_initialization().map_err(|error| self.error(error))
    }

    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        refer(&mut self.references, variables);
        self.instance.write(&self.references, values).map_err(|error| failed(&self.name, error))
    }

    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        refer(&mut self.references, variables);
        self.instance.read(&self.references, values).map_err(|error| failed(&self.name, error))
    }

    fn set_input_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &[f64],
    ) -> Result<(), SlaveError> {
        let Self { instance, orders, .. } = self;
        refer(&mut self.references, variables);
        orders[..variables.len()].fill(order.cast_signed());
        let set = instance.set_input_derivatives(&self.references, &orders[..variables.len()], derivatives);
        set.map_err(|error| failed(&self.name, error))
    }

    fn output_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        derivatives: &mut [f64],
    ) -> Result<(), SlaveError> {
        if order != DERIVATIVE_ORDER {
            return Err(unable(&self.name, "gives first derivatives only"));
        }
        let Self { instance, orders, .. } = self;
        refer(&mut self.references, variables);
        orders[..variables.len()].fill(DERIVATIVE_ORDER.cast_signed());
        let read = instance.output_derivatives(&self.references, &orders[..variables.len()], derivatives);
        read.map_err(|error| failed(&self.name, error))
    }

    fn directional_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        refer(&mut self.references, unknowns);
        refer(&mut self.knowns, knowns);
        let derived = self.instance.directional_derivative(&self.references, &self.knowns, direction, change);
        derived.map_err(|error| failed(&self.name, error))
    }

    fn end_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        slopes: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        refer(&mut self.references, unknowns);
        refer(&mut self.knowns, knowns);
        self.lines.clear();
        self.lines.extend(direction.iter().map(|end| Ramp::line(0.0, *end)));
        for (line, slope) in self.lines.iter_mut().zip(slopes) {
            *line = Ramp { bow: -0.5 * slope, skew: line.end - 0.5 * slope, ..*line };
        }
        let derived = self.instance.line_derivative(&self.references, &self.knowns, &self.lines, change);
        derived.map_err(|error| failed(&self.name, error))
    }

    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        match self.instance.do_step(time, step) {
            Ok(()) => Ok(Stepped::Done),
            Err(error) => Err(failed(&self.name, error)),
        }
    }

    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        if self.slots.len() <= slot {
            self.slots.resize(slot + 1, None);
        }
        match &mut self.slots[slot] {
            Some(snapshot) => self.instance.save(snapshot),
            empty => *empty = Some(self.instance.snapshot()),
        }
        Ok(())
    }

    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        match self.slots.get(slot) {
            Some(Some(snapshot)) => {
                self.instance.restore(snapshot).map_err(|error| failed(&self.name, error))
            }
            _ => Err(unable(&self.name, "has saved nothing there")),
        }
    }

    fn terminate(&mut self) -> Result<(), SlaveError> {
        self.instance.terminate().map_err(|error| self.error(error))
    }
}
