//! A system prepared for stepping: slaves in the order of their levels, connections as indices.

use super::energy::{Energy, Place};
use super::iteration::{Assumption, LoopStep};
use super::level::{Level, StepFrame, Trouble};
use super::mismatch::Mismatches;
use super::notes::InputCoupling;
use super::signals::Signals;
use super::solve::{Solved, Solver};
use super::unit::{BEGINNING, Channel, SignalSource, Unit};
use crate::cosim::schedule::Schedule;
use crate::cosim::settings::{Algorithm, Settings, Strong};
use crate::cosim::slave::{Kind, SlaveError};
use crate::cosim::system::{Port, System};
use std::collections::BTreeMap;
use std::ops::Range;

/// Slaves that are repeated together, or step once.
#[derive(Debug)]
struct Block {
    levels: Range<usize>,
    units: Range<usize>,
    repeated: Option<Repeated>,
}

/// What is assumed where a block is repeated.
#[derive(Debug)]
struct Repeated {
    assumptions: Vec<Assumption>,
    assumed: Vec<f64>,
    changes: Vec<f64>,
    turns: Vec<f64>,
    solver: Solver,
    solved: Solved,
}

/// The system, ready to step.
#[derive(Debug)]
pub(in crate::cosim) struct Engine {
    pub units: Vec<Unit>,
    pub signals: Signals,
    pub energy: Energy,
    pub mismatches: Mismatches,
    /// The unit of each slave, in the order of the system.
    pub unit_of: Vec<usize>,
    /// Signals that are reported.
    pub reported: Vec<usize>,
    /// Order to which inputs are extrapolated.
    pub order: u32,
    levels: Vec<Level>,
    blocks: Vec<Block>,
    /// Inputs are held at the values they are set to.
    plain: bool,
    /// Units whose output derivatives are asked for.
    derived: Vec<usize>,
}

impl Engine {
    pub fn new(system: System, settings: &Settings, schedule: &Schedule) -> Self {
        let (order, plain, strong) = match &settings.algorithm {
            Algorithm::Jacobi { extrapolation } | Algorithm::GaussSeidel { extrapolation, .. } => {
                ((*extrapolation).min(2), *extrapolation == 0, Strong::default())
            }
            Algorithm::Strong(strong) => (1, false, *strong),
        };
        let curved = matches!(settings.algorithm, Algorithm::Strong(_));
        let wiring = Wiring::new(&system, schedule, (plain, curved));
        let observed = system.observed();
        let reported = observed.iter().map(|port| wiring.signal(*port)).collect();
        let place = |port: Port| {
            let place = wiring.places.get(&port)?;
            Some(Place::new(*place, &wiring.channels[port.slave][place.1]))
        };
        let energy = Energy::new(&system, &system.power_connections(), place);
        let mismatches = Mismatches::new(&system, place);
        let Wiring { order: slaves, read, first, channels, assumptions, real, derivative_order, .. } = wiring;
        let (mut levels, mut start) = (Vec::new(), 0);
        for slaves in &schedule.levels {
            levels.push(Level::new(start..start + slaves.len(), settings.parallel));
            start += slaves.len();
        }
        let blocks = schedule.blocks.iter().zip(assumptions).map(|(block, assumptions)| {
            let own = &levels[block.levels.clone()];
            let units = own.first().map_or(0, |level| level.units.start)
                ..own.last().map_or(0, |level| level.units.end);
            let repeated = block.iterated.then(|| Repeated {
                assumed: vec![0.0; assumptions.len()],
                changes: vec![0.0; real.len()],
                turns: vec![0.0; real.len()],
                solver: Solver::new(strong, assumptions.len()),
                solved: Solved { evaluations: 0, residual: 0.0, converged: true },
                assumptions,
            });
            Block { levels: block.levels.clone(), units, repeated }
        });
        let blocks = blocks.collect();
        let mut unit_of = vec![0; slaves.len()];
        slaves.iter().enumerate().for_each(|(unit, slave)| unit_of[*slave] = unit);
        let mut parts: Vec<_> =
            system.slaves.into_iter().zip(channels).zip(read).zip(first).enumerate().collect();
        parts.sort_by_key(|(slave, _)| unit_of[*slave]);
        let units: Vec<Unit> = parts
            .into_iter()
            .map(|(_, (((slave, channels), read), first))| Unit::new(slave, channels, first, &read, curved))
            .collect();
        let wants = |unit: &Unit| {
            derivative_order[unit.first..unit.first + unit.outputs.len()].iter().any(|o| *o > 0)
        };
        let derived = (0..units.len()).filter(|unit| !plain && wants(&units[*unit])).collect();
        let signals = Signals::new(real, derivative_order);
        Self { units, signals, energy, mismatches, unit_of, reported, order, levels, blocks, plain, derived }
    }

    /// Saves every slave at the beginning of a step.
    pub fn save(&mut self) -> Result<(), SlaveError> {
        self.units.iter_mut().try_for_each(|unit| unit.slave.save(BEGINNING))
    }

    /// Takes every slave back to the beginning of the step.
    pub fn restore(&mut self) -> Result<(), SlaveError> {
        self.units.iter_mut().try_for_each(|unit| unit.slave.restore(BEGINNING))
    }

    /// Tries a step; `saved` if every slave has been saved at its beginning. How often loops were stepped.
    pub fn step(&mut self, time: f64, step: f64, saved: bool) -> Result<u32, Trouble> {
        let Self { units, signals, levels, blocks, plain, order, .. } = self;
        signals.predict(*order, step);
        let mut evaluations = 0;
        for block in blocks {
            let mut frame = StepFrame { time, step, plain: *plain, signals };
            let levels = &mut levels[block.levels.clone()];
            let Some(repeated) = &mut block.repeated else {
                for level in levels {
                    level.advance(units, &mut frame, false, &[])?;
                }
                continue;
            };
            if !saved {
                units[block.units.clone()].iter_mut().try_for_each(|unit| unit.slave.save(BEGINNING))?;
            }
            let Repeated { assumptions, assumed, changes, turns, solver, solved } = repeated;
            for (assumed, assumption) in assumed.iter_mut().zip(assumptions.iter()) {
                *assumed = assumption.expected(frame.signals, step);
            }
            let mut equations =
                LoopStep { units, levels, frame, assumptions, changes, turns, repetitions: 0 };
            *solved = solver.solve(&mut equations, assumed)?;
            evaluations += solved.evaluations;
        }
        Ok(evaluations)
    }

    /// Largest energy residual of the step tried last, as power over the largest power so far, and its power connection.
    pub fn measure_energy(&mut self, step: f64) -> (f64, usize) {
        self.energy.measure(&self.units, &self.signals, self.plain, step)
    }

    /// Did a loop not settle? The residual, and a slave of it.
    pub fn unsettled(&self) -> Option<(f64, &str)> {
        let loops = self.blocks.iter().filter_map(|block| Some((block, block.repeated.as_ref()?)));
        let mut unsettled = loops.filter(|(_, repeated)| !repeated.solved.converged);
        let (block, repeated) = unsettled.next()?;
        Some((repeated.solved.residual, self.units[block.units.start].slave.name()))
    }

    /// Takes the step tried last as done.
    pub fn accept(&mut self, step: f64) -> Result<(), SlaveError> {
        self.energy.accept(step);
        self.mismatches.accept(&self.units, &self.signals);
        self.units.iter_mut().for_each(Unit::accept);
        self.signals.accept(step);
        self.signals.sloped = true;
        for repeated in self.blocks.iter_mut().filter_map(|block| block.repeated.as_mut()) {
            repeated.solver.remember(&repeated.assumed);
        }
        self.derive()
    }

    /// Reads the slopes before the first step. Where a slave does not know its own yet, that step runs linearly.
    pub fn read_slopes(&mut self) {
        let Self { units, signals, .. } = self;
        signals.sloped = units.iter_mut().all(|unit| unit.read_slopes().is_ok());
        for unit in units {
            for (place, slope) in unit.coupled_places.iter().zip(&unit.slopes_out) {
                signals.slopes[0][unit.first + place] = *slope;
            }
        }
    }

    /// Reads the output derivatives that are asked for.
    pub fn derive(&mut self) -> Result<(), SlaveError> {
        for unit in &self.derived {
            self.units[*unit].read_derivatives(self.order, &mut self.signals.derivatives)?;
        }
        self.signals.derived = !self.derived.is_empty();
        Ok(())
    }
}

/// Connections as indices, while the system is still in one piece.
struct Wiring {
    /// Slaves in the order of their levels.
    order: Vec<usize>,
    /// Of each slave: what is read, by position, and whether it feeds another as a Real.
    read: Vec<Vec<(usize, bool)>>,
    /// Of each slave: the number of its first signal.
    first: Vec<usize>,
    channels: Vec<Vec<Channel>>,
    /// Unit and channel of each connected input.
    places: BTreeMap<Port, (usize, usize)>,
    /// Of each block.
    assumptions: Vec<Vec<Assumption>>,
    /// Of each signal.
    real: Vec<bool>,
    derivative_order: Vec<u32>,
}

impl Wiring {
    fn new(system: &System, schedule: &Schedule, (plain, curved): (bool, bool)) -> Self {
        let order: Vec<usize> = schedule.levels.iter().flatten().copied().collect();
        let read = read(system);
        let (mut first, mut count) = (vec![0; order.len()], 0);
        let (mut real, mut unit_of) = (Vec::new(), vec![0; order.len()]);
        for (unit, slave) in order.iter().enumerate() {
            unit_of[*slave] = unit;
            first[*slave] = count;
            count += read[*slave].len();
            let rows = system.slaves[*slave].variables();
            real.extend(read[*slave].iter().map(|(position, _)| rows[*position].kind == Kind::Real));
        }
        let mut wiring = Self {
            channels: vec![Vec::new(); order.len()],
            assumptions: vec![Vec::new(); schedule.blocks.len()],
            derivative_order: vec![0; count],
            places: BTreeMap::new(),
            order,
            read,
            first,
            real,
        };
        wiring.connect(system, schedule, &unit_of, (plain, curved));
        wiring
    }

    fn connect(&mut self, system: &System, schedule: &Schedule, unit_of: &[usize], kind: (bool, bool)) {
        let (plain, curved) = kind;
        let coupling = InputCoupling::new(system);
        let mut block_of = vec![0; unit_of.len()];
        for (index, block) in schedule.blocks.iter().enumerate() {
            schedule.levels[block.levels.clone()].iter().flatten().for_each(|slave| block_of[*slave] = index);
        }
        for connection in &system.connections {
            let (from, to) = (connection.from, connection.to);
            let (source, block) = (self.signal(from), block_of[to.slave]);
            let (factor, offset) = (connection.factor, connection.offset);
            let origin = if schedule.rank[from.slave] < schedule.rank[to.slave] {
                SignalSource::Computed
            } else if schedule.blocks[block].iterated && block_of[from.slave] == block {
                self.assumptions[block].push(Assumption { source, factor, offset, slope: false });
                SignalSource::Assumed(self.assumptions[block].len() - 1)
            } else {
                let given = system.slaves[from.slave].abilities().output_derivative_order.min(2);
                self.derivative_order[source] = if plain { 0 } else { given };
                SignalSource::Extrapolated
            };
            let slope = match origin {
                _ if !curved || !tells_slopes(system, from) || system.variable(to).kind != Kind::Real => None,
                SignalSource::Computed => Some(SignalSource::Computed),
                SignalSource::Assumed(_) => {
                    self.assumptions[block].push(Assumption { source, factor, offset: 0.0, slope: true });
                    Some(SignalSource::Assumed(self.assumptions[block].len() - 1))
                }
                SignalSource::Extrapolated => None,
            };
            let channels = &mut self.channels[to.slave];
            self.places.insert(to, (unit_of[to.slave], channels.len()));
            let (given, continued) = (coupling.given(system, to), coupling.at_once(to));
            channels.push(Channel {
                input: to.variable,
                source,
                factor,
                offset,
                origin,
                slope,
                given,
                continued,
            });
        }
    }

    /// The signal at a port that is read.
    fn signal(&self, port: Port) -> usize {
        let read = &self.read[port.slave];
        self.first[port.slave] + read.partition_point(|(position, _)| *position < port.variable)
    }
}

/// Whether the slopes of a signal are known where a step ends, and the same where the next begins.
fn tells_slopes(system: &System, from: Port) -> bool {
    let slave = &system.slaves[from.slave];
    let real = system.variable(from).kind == Kind::Real;
    real && slave.abilities().output_derivative_order > 0 && !slave.has_corners()
}

/// What is read of each slave, in ascending order: sources of connections, and what is reported.
fn read(system: &System) -> Vec<Vec<(usize, bool)>> {
    let mut read = vec![BTreeMap::new(); system.slaves.len()];
    for port in system.observed() {
        read[port.slave].insert(port.variable, false);
    }
    for connection in &system.connections {
        let port = connection.from;
        read[port.slave].insert(port.variable, system.variable(port).kind == Kind::Real);
    }
    read.into_iter().map(|ports| ports.into_iter().collect()).collect()
}
