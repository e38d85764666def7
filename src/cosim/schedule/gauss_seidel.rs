//! Gauss–Seidel: one slave after the other, each with the newest values.

use super::blocks::{Connected, Schedule};
use crate::cosim::system::{System, SystemError};

/// In the order of `names`, or along the connections: slaves that are fed come after those that feed them, and a loop
/// is opened at the slave whose outputs depend least on its inputs at once.
pub(in crate::cosim) fn schedule(system: &System, names: Option<&[String]>) -> Result<Schedule, SystemError> {
    let connected = Connected::new(system);
    let order: Vec<usize> = match names {
        Some(names) => given(system, names)?,
        None => connected.components().into_iter().flat_map(|(slaves, _)| slaves).collect(),
    };
    let mut schedule = Schedule::empty(system.slaves.len());
    schedule.push(&order, &connected, false);
    Ok(schedule)
}

fn given(system: &System, names: &[String]) -> Result<Vec<usize>, SystemError> {
    let slave = |name: &String| {
        let found = system.slaves.iter().position(|slave| slave.name() == name);
        found.ok_or_else(|| SystemError::UnknownSlave { slave: name.clone() })
    };
    let order = names.iter().map(slave).collect::<Result<Vec<_>, _>>()?;
    for (index, slave) in system.slaves.iter().enumerate() {
        let times = order.iter().filter(|other| **other == index).count();
        if times != 1 {
            return Err(SystemError::Order { slave: slave.name().to_owned(), times });
        }
    }
    Ok(order)
}
