//! The run itself: what is recorded, and how far it has come.

use std::ops::ControlFlow;

use stickslip::cosim::{Master, Settings};
use stickslip_report::simulation::{Column, Simulation};

use super::assemble::SystemColumn;
use crate::progress::{self, Progress};

/// Parts in which progress is shown.
const PARTS: usize = 1000;

/// Adds the outputs of the system as a whole, which are values of its parts under other names and in other units.
pub(super) fn add_outputs(simulation: &mut Simulation, outputs: Vec<SystemColumn>) {
    for SystemColumn { name, from, linear, unit } in outputs {
        let found = simulation.columns.iter().find(|column| column.name == from);
        let Some(values) =
            found.map(|column| column.values.iter().map(|value| linear.apply(*value)).collect())
        else {
            continue;
        };
        simulation.columns.push(Column { name, unit, values });
    }
}

/// Runs to the stop, to an interrupt or to a failure; what there is so far is in the result.
pub(super) fn simulate(master: Master, settings: &Settings, every: u64) -> Simulation {
    let mut simulation = Simulation {
        span: (settings.start, settings.stop),
        step: settings.step,
        columns: master
            .observed()
            .iter()
            .map(|one| Column {
                name: format!("{}.{}", one.slave, one.variable),
                unit: one.unit.clone(),
                values: Vec::new(),
            })
            .collect(),
        ..Simulation::default()
    };
    let meter = Progress::new();
    let span = settings.stop - settings.start;
    let (mut points, mut shown) = (0_u64, usize::MAX);
    let ended = master.run(|point| {
        let last = point.time >= settings.stop;
        if points.is_multiple_of(every) || last {
            simulation.time.push(point.time);
            for (column, value) in simulation.columns.iter_mut().zip(point.values) {
                column.values.push(*value);
            }
            simulation.energy.resize(point.energy.len(), Vec::new());
            for (history, residual) in simulation.energy.iter_mut().zip(point.energy) {
                history.push(residual.sum);
            }
        }
        points += 1;
        let part =
            if span > 0.0 { ((point.time - settings.start) / span * PARTS as f64) as usize } else { PARTS };
        if part != shown {
            shown = part;
            meter.show(&format!("t = {:.6} s", point.time), part, PARTS);
        }
        if progress::interrupted_after_a_step() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    meter.finish();
    match ended {
        Ok(report) => simulation.report = report,
        Err(failure) => {
            simulation.failure = Some(failure.error.to_string());
            simulation.report = *failure.report;
        }
    }
    simulation
}
