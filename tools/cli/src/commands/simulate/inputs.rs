//! Inputs over time, from a CSV file.

use std::path::Path;

use stickslip::cosim::{Source, System};
use stickslip_readers::Signal;
use stickslip_readers::ssp::{End, SystemStructure};
use stickslip_readers::units::{Linear, Unit};

use super::parts::{Part, converted, defined, find};
use super::refused;
use crate::Failure;

/// A column of the file with the inputs it is for.
pub(super) struct Driven {
    time: Vec<f64>,
    signal: Signal,
    targets: Vec<(End, Linear)>,
}

impl Driven {
    /// Name of the column.
    pub fn name(&self) -> &str {
        &self.signal.name
    }

    /// Whether it is for this input.
    pub fn drives(&self, end: &End) -> bool {
        self.targets.iter().any(|(target, _)| target == end)
    }
}

/// The columns of `file`, each for an input of the system or of a component.
pub(super) fn sources(
    file: &Path,
    parts: &[Part],
    structure: &SystemStructure,
) -> Result<Vec<Driven>, Failure> {
    let (time, signals) = stickslip_readers::read_signals(file).map_err(super::super::shown)?;
    let mut driven = Vec::new();
    for signal in signals {
        let targets = targets(&signal, parts, structure).and_then(|targets| {
            targets.iter().try_for_each(|(end, _)| check_free(parts, structure, &driven, end))?;
            Ok(targets)
        });
        let targets = targets.map_err(|failure| {
            Failure::rendered(format!("{} (column `{}` of {})", failure.message, signal.name, file.display()))
        })?;
        driven.push(Driven { time: time.clone(), signal, targets });
    }
    Ok(driven)
}

fn targets(
    signal: &Signal,
    parts: &[Part],
    structure: &SystemStructure,
) -> Result<Vec<(End, Linear)>, Failure> {
    let from = signal.unit.as_deref().map(|name| defined(&Unit::named(name), parts));
    let from = from.transpose().map_err(Failure::input)?;
    if let Some(input) = structure.inputs.iter().find(|input| input.name == signal.name) {
        let ends = input.targets.iter().map(|(end, route)| {
            let own = parts[end.component].unit(&end.variable)?;
            let linear = route.linear(from.as_ref(), own.as_ref());
            Ok((end.clone(), linear.map_err(|error| Failure::input(error.to_string()))?))
        });
        return ends.collect();
    }
    let (component, variable) = find(parts, &signal.name)?;
    let own = parts[component].unit(&variable)?;
    let linear = converted(from.as_ref(), own.as_ref()).map_err(Failure::input)?;
    Ok(vec![(End { component, variable }, linear)])
}

/// Adds a source for each column and connects it.
pub(super) fn connect(system: &mut System, driven: Vec<Driven>, names: &[String]) -> Result<(), Failure> {
    for one in driven {
        // No component is called so: names of components have no colon in front.
        let slave = format!(":{}", one.signal.name);
        let unit = one.signal.unit.clone().unwrap_or_else(|| "1".to_owned());
        let (time, values) = (one.time.clone(), one.signal.values.clone());
        let (again, same) = (one.time, one.signal.values);
        let source = Source::new(&slave, "value", &unit, move |at| interpolated(&time, &values, at))
            .with_derivative(move |at| slope(&again, &same, at))
            .with_corners();
        system.add(Box::new(source)).map_err(refused)?;
        for (end, linear) in &one.targets {
            let to = (names[end.component].as_str(), end.variable.as_str());
            system.connect((&slave, "value"), to, linear.factor, linear.offset).map_err(refused)?;
        }
    }
    Ok(())
}

/// The rows before and after a time; the same twice beyond the ends.
fn around(time: &[f64], at: f64) -> (usize, usize) {
    let after = time.partition_point(|row| *row <= at);
    (after.saturating_sub(1), after.min(time.len().saturating_sub(1)))
}

/// On straight lines between the rows; held before the first and after the last.
fn interpolated(time: &[f64], values: &[f64], at: f64) -> f64 {
    let (before, after) = around(time, at);
    let span = time[after] - time[before];
    if at <= time[before] || span <= 0.0 {
        return values[before];
    }
    values[before] + (at - time[before]) / span * (values[after] - values[before])
}

fn slope(time: &[f64], values: &[f64], at: f64) -> f64 {
    let (before, after) = around(time, at);
    let span = time[after] - time[before];
    if at < time[before] || span <= 0.0 { 0.0 } else { (values[after] - values[before]) / span }
}

/// Refuses a value for an input that a connection or a column gives its values.
pub(super) fn check_free(
    parts: &[Part],
    structure: &SystemStructure,
    sources: &[Driven],
    end: &End,
) -> Result<(), Failure> {
    let name = |end: &End| format!("`{}.{}`", parts[end.component].name, end.variable);
    let connection = structure.connections.iter().find(|connection| connection.to == *end);
    let driver = match connection {
        Some(connection) => format!("{} ({})", name(&connection.from), connection.place),
        None => match sources.iter().find(|source| source.drives(end)) {
            Some(source) => format!("the column `{}` of --input", source.name()),
            None => return Ok(()),
        },
    };
    Err(Failure::input(format!(
        "{} takes its values from {driver}: another value for it would be overwritten",
        name(end)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_met_and_lines_are_straight_between_them() {
        let (time, values) = ([0.0, 1.0, 3.0], [5.0, 7.0, -1.0]);
        for (at, value, derivative) in [
            (-1.0, 5.0, 0.0),
            (0.0, 5.0, 2.0),
            (0.5, 6.0, 2.0),
            (1.0, 7.0, -4.0),
            (2.0, 3.0, -4.0),
            (3.0, -1.0, 0.0),
            (9.0, -1.0, 0.0),
        ] {
            assert_eq!(
                (interpolated(&time, &values, at), slope(&time, &values, at)),
                (value, derivative),
                "{at}"
            );
        }
    }
}
