//! A slave that notes what it is asked to do.

use stickslip::cosim::{Abilities, Setup, Slave, SlaveError, Stepped, Variable};

use crate::common::linear_slave::Linear;

/// What a slave was asked to do, in order.
#[derive(Debug)]
pub struct Watched {
    pub slave: Linear,
    pub calls: std::sync::Arc<std::sync::Mutex<Vec<&'static str>>>,
}

impl Watched {
    pub fn note(&self, call: &'static str) {
        let mut calls = self.calls.lock().unwrap();
        if calls.last() != Some(&call) {
            calls.push(call);
        }
    }
}

impl Slave for Watched {
    fn name(&self) -> &str {
        self.slave.name()
    }
    fn variables(&self) -> &[Variable] {
        self.slave.variables()
    }
    fn abilities(&self) -> Abilities {
        self.slave.abilities()
    }
    fn set_up(&mut self, setup: Setup) -> Result<(), SlaveError> {
        self.note("set up");
        self.slave.set_up(setup)
    }
    fn enter_initialization(&mut self) -> Result<(), SlaveError> {
        self.note("enter");
        self.slave.enter_initialization()
    }
    fn exit_initialization(&mut self) -> Result<(), SlaveError> {
        self.note("exit");
        self.slave.exit_initialization()
    }
    fn set(&mut self, variables: &[usize], values: &[f64]) -> Result<(), SlaveError> {
        self.note("set");
        self.slave.set(variables, values)
    }
    fn get(&mut self, variables: &[usize], values: &mut [f64]) -> Result<(), SlaveError> {
        self.note("get");
        self.slave.get(variables, values)
    }
    fn set_input_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        values: &[f64],
    ) -> Result<(), SlaveError> {
        self.slave.set_input_derivatives(variables, order, values)
    }
    fn output_derivatives(
        &mut self,
        variables: &[usize],
        order: u32,
        out: &mut [f64],
    ) -> Result<(), SlaveError> {
        self.slave.output_derivatives(variables, order, out)
    }
    fn directional_derivative(
        &mut self,
        unknowns: &[usize],
        knowns: &[usize],
        direction: &[f64],
        change: &mut [f64],
    ) -> Result<(), SlaveError> {
        self.slave.directional_derivative(unknowns, knowns, direction, change)
    }
    fn do_step(&mut self, time: f64, step: f64) -> Result<Stepped, SlaveError> {
        self.note("step");
        self.slave.do_step(time, step)
    }
    fn save(&mut self, slot: usize) -> Result<(), SlaveError> {
        self.note("save");
        self.slave.save(slot)
    }
    fn restore(&mut self, slot: usize) -> Result<(), SlaveError> {
        self.note("restore");
        self.slave.restore(slot)
    }
    fn terminate(&mut self) -> Result<(), SlaveError> {
        self.note("terminate");
        self.slave.terminate()
    }
}
