//! What slaves cannot do, in plain words, with what it costs.

use super::schedule::Schedule;
use super::settings::{Algorithm, Settings};
use super::system::{InputRule, Port, System};
use super::unit::Given;
use std::collections::BTreeSet;

/// How `slave` is given its real `input` under more than the first order.
pub(super) fn given(system: &System, to: Port) -> Given {
    let abilities = system.slaves[to.slave].abilities();
    if system.variable(to).kind != super::Kind::Real {
        return Given::End;
    }
    if abilities.interpolates_inputs {
        return Given::Ramp;
    }
    match system.rules[to.slave] {
        InputRule::End => Given::End,
        InputRule::Middle => Given::Middle,
        InputRule::Auto => {
            let rows = system.slaves[to.slave].variables();
            let declared =
                rows.iter().all(|row| row.causality != super::Causality::Output || row.depends_on.is_some());
            if declared && system.feed_through(to.slave, to.variable) == 1.0 {
                Given::End
            } else {
                Given::Middle
            }
        }
    }
}

/// Notes on how the slaves of `system` take part.
pub(super) fn notes(system: &System, settings: &Settings, schedule: &Schedule) -> Vec<String> {
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
                    "{} cannot save its state: steps of the system cannot be repeated shorter",
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
    for connection in &system.connections {
        let (to, slave) = (connection.to, &system.slaves[connection.to.slave]);
        if system.variable(to).kind != super::Kind::Real {
            continue;
        }
        let name = system.full_name(to);
        match given(system, to) {
            Given::Ramp => {}
            Given::End => notes.push(format!(
                "{name} cannot be interpolated: it is given its value at the end of each step, which is right where the \
                 slave answers at once, and early by half a step where it holds and integrates it"
            )),
            Given::Middle => {
                let abilities = slave.abilities();
                let outputs = slave.variables().iter().enumerate();
                let touched = outputs
                    .filter(|(_, row)| row.causality == super::Causality::Output && row.kind == super::Kind::Real)
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
