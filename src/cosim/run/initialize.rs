//! From start values to values that agree with each other.

use super::report::Cause;
use crate::cosim::settings::{Algorithm, Method, Settings, Strong};
use crate::cosim::slave::{Setup, SlaveError};
use crate::cosim::step::engine::Engine;
use crate::cosim::step::iteration::Assumption;
use crate::cosim::step::solve::{Coupling, Solver};
use crate::cosim::step::unit::SignalSource;
use crate::cosim::system::Port;
use std::collections::BTreeMap;

/// Relative change of values that count as settled, where the settings say nothing.
const SETTLED: f64 = 1e-10;
/// Most rounds, besides one for each slave that may wait for another.
const ROUNDS: u32 = 200;

/// Sets start values and lets inputs and outputs settle, algebraic loops included; then the slaves are ready to step.
pub(in crate::cosim) fn initialize(
    engine: &mut Engine,
    settings: &Settings,
    starts: &[(Port, f64)],
    stop: f64,
) -> Result<(), Cause> {
    let setup = Setup { tolerance: settings.tolerance, start: settings.start, stop: Some(stop) };
    let mut of_unit: BTreeMap<usize, (Vec<usize>, Vec<f64>)> = BTreeMap::new();
    for (port, value) in starts {
        let (variables, values) = of_unit.entry(engine.unit_of[port.slave]).or_default();
        variables.push(port.variable);
        values.push(*value);
    }
    for (index, unit) in engine.units.iter_mut().enumerate() {
        unit.slave.set_up(setup)?;
        if let Some((variables, values)) = of_unit.get(&index) {
            unit.slave.set(variables, values)?;
        }
        unit.slave.enter_initialization()?;
    }
    settle(engine, settings)?;
    for unit in &mut engine.units {
        unit.slave.exit_initialization()?;
        unit.reached.copy_from_slice(&unit.values);
        unit.read_numbers()?;
        let own = unit.first..unit.first + unit.outputs.len();
        engine.signals.next[own].copy_from_slice(&unit.outputs);
    }
    let values = engine.signals.next.clone();
    engine.signals.begin(&values);
    // Before the first step a slave need not know any: then the first step holds its inputs.
    if engine.derive().is_err() {
        engine.signals.derived = false;
    }
    engine.read_slopes();
    Ok(())
}

fn settle(engine: &mut Engine, settings: &Settings) -> Result<(), Cause> {
    let mut assumptions = Vec::new();
    let mut origins = Vec::with_capacity(engine.units.len());
    let mut names = Vec::new();
    for unit in &engine.units {
        let row = unit.channels.iter().map(|channel| {
            if channel.source < unit.first {
                return SignalSource::Computed;
            }
            let name = &unit.slave.variables()[channel.input].name;
            names.push(format!("{}.{name}", unit.slave.name()));
            let (source, factor, offset) = (channel.source, channel.factor, channel.offset);
            assumptions.push(Assumption { source, factor, offset, slope: false });
            SignalSource::Assumed(assumptions.len() - 1)
        });
        origins.push(row.collect::<Vec<_>>());
    }
    for unit in &mut engine.units {
        unit.read()?;
        let own = unit.first..unit.first + unit.outputs.len();
        engine.signals.next[own].copy_from_slice(&unit.outputs);
    }
    let next = &engine.signals.next;
    let mut assumed: Vec<f64> =
        assumptions.iter().map(|assumption| assumption.of(next[assumption.source])).collect();
    let (method, tolerance) = match &settings.algorithm {
        Algorithm::Strong(strong) => (strong.method, strong.tolerance.min(SETTLED)),
        _ => (Method::Anderson { depth: 5 }, SETTLED),
    };
    let iterations = ROUNDS + 2 * engine.units.len() as u32;
    let mut solver = Solver::new(Strong { method, tolerance, iterations }, assumed.len());
    let mut round = Round { engine, assumptions: &assumptions, origins: &origins };
    let solved = solver.solve(&mut round, &mut assumed)?;
    if solved.converged {
        return Ok(());
    }
    names.sort_unstable();
    Err(Cause::InitialLoop { variables: names, residual: solved.residual })
}

/// Sets all inputs and reads all outputs, one slave after the other.
struct Round<'a> {
    engine: &'a mut Engine,
    assumptions: &'a [Assumption],
    origins: &'a [Vec<SignalSource>],
}

impl Coupling for Round<'_> {
    type Trouble = SlaveError;

    fn evaluate(&mut self, assumed: &[f64], residual: &mut [f64]) -> Result<(), SlaveError> {
        let Engine { units, signals, .. } = &mut *self.engine;
        for (unit, origins) in units.iter_mut().zip(self.origins) {
            unit.settle(signals, assumed, origins)?;
            let own = unit.first..unit.first + unit.outputs.len();
            signals.next[own].copy_from_slice(&unit.outputs);
        }
        for ((residual, assumption), assumed) in residual.iter_mut().zip(self.assumptions).zip(assumed) {
            *residual = assumption.of(signals.next[assumption.source]) - assumed;
        }
        Ok(())
    }

    fn product(&mut self, _direction: &[f64], _change: &mut [f64]) -> Result<bool, SlaveError> {
        Ok(false)
    }
}
