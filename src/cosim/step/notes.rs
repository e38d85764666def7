//! Notes on what slaves cannot do, and how this changes the accuracy.

use super::unit::Given;
use crate::cosim::schedule::Schedule;
use crate::cosim::settings::{Algorithm, Settings};
use crate::cosim::slave::{Causality, Kind};
use crate::cosim::system::{InputRule, Port, System};
use std::collections::BTreeSet;

/// How each slave is given its inputs under more than the first order.
pub(in crate::cosim) struct InputCoupling {
    /// Of each variable of each slave: does the slave declare that all it puts out depends on it at once?
    at_once: Vec<Vec<bool>>,
}

impl InputCoupling {
    pub fn new(system: &System) -> Self {
        let at_once = system.slaves.iter().enumerate().map(|(index, slave)| {
            let mut rows = slave.variables().iter();
            let declared = rows.all(|row| row.causality != Causality::Output || row.depends_on.is_some());
            system.feed_through(index).into_iter().map(|fraction| declared && fraction == 1.0).collect()
        });
        Self { at_once: at_once.collect() }
    }

    /// Does the slave declare that all it puts out depends at once on the input?
    pub fn at_once(&self, to: Port) -> bool {
        self.at_once[to.slave][to.variable]
    }

    /// How the input is given.
    pub fn given(&self, system: &System, to: Port) -> Given {
        if system.variable(to).kind != Kind::Real {
            return Given::End;
        }
        match system.rules[to.slave] {
            _ if system.slaves[to.slave].abilities().interpolates_inputs => Given::Ramp,
            InputRule::End => Given::End,
            InputRule::Middle => Given::Middle,
            InputRule::Auto if self.at_once(to) => Given::End,
            InputRule::Auto => Given::Middle,
        }
    }
}

/// Notes on how the slaves of `system` take part.
pub(in crate::cosim) fn notes(system: &System, settings: &Settings, schedule: &Schedule) -> Vec<String> {
    let mut notes = Vec::new();
    let order = match &settings.algorithm {
        Algorithm::Jacobi { extrapolation } | Algorithm::GaussSeidel { extrapolation, .. } => *extrapolation,
        Algorithm::Strong(_) => 1,
    };
    let strong = matches!(settings.algorithm, Algorithm::Strong(_));
    let loops = system.algebraic_loops();
    if !loops.is_empty() && !strong {
        for ports in &loops {
            let names: Vec<String> = ports.iter().map(|port| system.full_name(*port)).collect();
            notes.push(format!(
                "algebraic loop {}: solved at the start, then each value is as old as its extrapolation",
                shortened(&names)
            ));
        }
    }
    if strong {
        explicit(system, schedule, &mut notes);
    }
    if order > 0 {
        past_values(system, schedule, &mut notes);
        inputs(system, &mut notes);
    }
    if settings.adaptive.is_some() {
        for slave in &system.slaves {
            let abilities = slave.abilities();
            if !abilities.saves_state {
                notes.push(format!(
                    "{} cannot save its state: steps of the system cannot be repeated with a shorter size",
                    slave.name()
                ));
            }
            if !abilities.variable_step {
                notes.push(format!(
                    "{} takes steps of one length only: the step is not adapted",
                    slave.name()
                ));
            }
        }
    }
    notes
}

fn shortened(names: &[String]) -> String {
    const SHOWN: usize = 6;
    let more = names.len().saturating_sub(SHOWN);
    let list = names.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
    if more > 0 { format!("{list} and {more} more") } else { list }
}

/// Slaves of loops that cannot be repeated.
fn explicit(system: &System, schedule: &Schedule, notes: &mut Vec<String>) {
    for (index, slave) in system.slaves.iter().enumerate() {
        let delayed = system.connections.iter().any(|connection| {
            connection.to.slave == index && schedule.rank[connection.from.slave] >= schedule.rank[index]
        });
        if delayed && !slave.abilities().saves_state {
            notes.push(format!(
                "{} cannot save its state: it is coupled explicitly, from extrapolated inputs, which may be unstable where \
                 the coupling is stiff",
                slave.name()
            ));
        }
    }
}

/// Slaves whose outputs are extrapolated from past values.
fn past_values(system: &System, schedule: &Schedule, notes: &mut Vec<String>) {
    let late = system.connections.iter().filter(|connection| {
        schedule.rank[connection.from.slave] >= schedule.rank[connection.to.slave]
            && system.slaves[connection.from.slave].abilities().output_derivative_order == 0
    });
    let slaves: BTreeSet<usize> = late.map(|connection| connection.from.slave).collect();
    let repeated = |slave: &usize| schedule.repeats(*slave);
    for slave in slaves.into_iter().filter(|slave| !repeated(slave)) {
        let name = system.slaves[slave].name();
        notes.push(format!(
            "{name} gives no output derivatives: its outputs are extrapolated from past values"
        ));
    }
}

/// Slaves that cannot interpolate.
fn inputs(system: &System, notes: &mut Vec<String>) {
    let coupling = InputCoupling::new(system);
    for connection in &system.connections {
        let (to, slave) = (connection.to, &system.slaves[connection.to.slave]);
        if system.variable(to).kind != Kind::Real {
            continue;
        }
        let name = system.full_name(to);
        match coupling.given(system, to) {
            Given::Ramp => {}
            Given::End => notes.push(format!(
                "{name} cannot be interpolated: it is given its value at the end of each step, which is right where the \
                 slave answers at once, and early by half a step where it holds and integrates it"
            )),
            Given::Middle => {
                let abilities = slave.abilities();
                let outputs = slave.variables().iter().enumerate();
                let touched = outputs
                    .filter(|(_, row)| row.causality == Causality::Output && row.kind == Kind::Real)
                    .any(|(output, _)| system.depends(to.slave, output, to.variable));
                let able = abilities.saves_state || abilities.directional_derivatives;
                let cost = if touched && !able {
                    "; its outputs that answer to it at once are late by half a step (order 1)"
                } else {
                    ""
                };
                notes.push(format!(
                    "{name} cannot be interpolated: it is given its value at the middle of each step (order 2 where the \
                     slave holds it){cost}"
                ));
            }
        }
    }
}
