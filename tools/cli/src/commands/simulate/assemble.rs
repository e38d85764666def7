//! From files to a system the master can run.

use std::path::Path;
use std::sync::Arc;

use stickslip::cosim::System;
use stickslip_fmi_host::{Log, TypeOfVariable};
use stickslip_readers::ssp::{self, End, SspProblem, SystemStructure};
use stickslip_readers::units::Linear;

use super::parts::{Part, find, instantiate};
use super::starts::Starts;
use super::{Simulate, inputs, refused};
use crate::Failure;

/// A system ready to run.
pub(super) struct Assembly {
    pub title: String,
    pub system: System,
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub step: Option<f64>,
    pub remarks: Vec<String>,
    /// Outputs of the system as a whole.
    pub outputs: Vec<SystemColumn>,
    /// What each FMU says.
    pub logs: Vec<(String, Arc<Log>)>,
}

/// An output of the system: its name, the recorded column it comes from, how, and its unit.
pub(super) struct SystemColumn {
    pub name: String,
    pub from: String,
    pub linear: Linear,
    pub unit: Option<String>,
}

/// Reads the system and makes it ready.
pub(super) fn assemble(arguments: &Simulate) -> Result<Assembly, Failure> {
    let path = &arguments.system;
    let extension = path.extension().map(|end| end.to_string_lossy().to_lowercase());
    let structure = match extension.as_deref() {
        Some("ssp" | "ssd") => ssp::read(path).map_err(super::super::shown)?,
        Some("fmu") => single(path),
        _ => {
            let shown = path.display();
            return Err(Failure::input(format!("{shown} should end in .ssp, .ssd or .fmu")));
        }
    };
    let mut remarks = structure.remarks.clone();
    let mut parts = instantiate(&structure, arguments, &mut remarks)?;
    let mut starts = Starts::default();
    for parameter in &structure.parameters {
        starts.parameter(&parts, parameter, &mut remarks)?;
    }
    let sources = match &arguments.input {
        Some(file) => inputs::sources(file, &parts, &structure)?,
        None => Vec::new(),
    };
    for assignment in &arguments.set {
        starts.assignment(&parts, &structure, &sources, assignment)?;
    }
    for (component, variable, text) in &starts.texts {
        parts[*component].set_text(variable, text).map_err(|error| Failure::input(error.to_string()))?;
    }
    let experiment = Experiment::of(&structure, &parts);
    let connections = connections(&structure, &parts)?;
    let outputs = outputs(&structure, &parts)?;
    let records = arguments.record.iter().map(|name| find(&parts, name));
    let records = records.collect::<Result<Vec<_>, Failure>>()?;
    let power = arguments.power.iter().map(|pair| pair_of(&parts, pair)).collect::<Result<Vec<_>, _>>()?;
    let names: Vec<String> = parts.iter().map(|part| part.name.clone()).collect();
    let logs = parts.iter().map(|part| (part.name.clone(), part.log())).collect();
    let mut system = System::new();
    for part in parts {
        system.add(part.boxed()).map_err(refused)?;
    }
    for (from, to, linear) in &connections {
        let ends = [from, to].map(|end| (names[end.component].as_str(), end.variable.as_str()));
        system.connect(ends[0], ends[1], linear.factor, linear.offset).map_err(refused)?;
    }
    for ends in &power {
        let [force, motion] =
            ends.each_ref().map(|(part, variable)| (names[*part].as_str(), variable.as_str()));
        system.declare_power(force, motion).map_err(refused)?;
    }
    for ((component, variable), value) in &starts.numbers {
        system.start(&names[*component], variable, *value).map_err(refused)?;
    }
    let shown = structure.outputs.iter().map(|output| (output.from.component, output.from.variable.clone()));
    observe(&mut system, &names, &shown.chain(records).collect::<Vec<_>>())?;
    inputs::connect(&mut system, sources, &names)?;
    let Experiment { start, stop, step } = experiment;
    Ok(Assembly { title: structure.name.clone(), system, start, stop, step, remarks, outputs, logs })
}

/// The two inputs of `FORCE=MOTION`: the number of the part and the variable of each.
fn pair_of(parts: &[Part], pair: &str) -> Result<[(usize, String); 2], Failure> {
    let Some((force, motion)) = pair.split_once('=') else {
        return Err(Failure::input(format!("--power {pair} should read FORCE=MOTION")));
    };
    Ok([find(parts, force)?, find(parts, motion)?])
}

/// A system of one FMU.
fn single(path: &Path) -> SystemStructure {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    SystemStructure::single(&stem, path)
}

/// The least step, and start and stop where the system has none and the FMUs agree on them.
struct Experiment {
    start: Option<f64>,
    stop: Option<f64>,
    step: Option<f64>,
}

impl Experiment {
    fn of(structure: &SystemStructure, parts: &[Part]) -> Self {
        let own = || parts.iter().map(|part| part.fmu.description().experiment);
        let least = |one: f64, other: f64| one.min(other);
        Self {
            start: structure.start.or_else(|| own().filter_map(|one| one.start).reduce(least)),
            stop: structure.stop.or_else(|| own().filter_map(|one| one.stop).reduce(f64::max)),
            step: own().filter_map(|one| one.step).filter(|step| *step > 0.0).reduce(least),
        }
    }
}

type Resolved = (End, End, Linear);

/// The connections with their units.
fn connections(structure: &SystemStructure, parts: &[Part]) -> Result<Vec<Resolved>, Failure> {
    let resolved = structure.connections.iter().map(|connection| {
        let (from, to) = (&connection.from, &connection.to);
        let placed = |message: &str| Failure::input(format!("{}: {message}", connection.place));
        let unit = |end: &End| {
            parts[end.component].unit(&end.variable).map_err(|failure| {
                placed(failure.message.strip_prefix("error: ").unwrap_or(&failure.message))
            })
        };
        let (source, target) = (unit(from)?, unit(to)?);
        if connection.route.maps_booleans()
            && let Some(end) = [from, to].into_iter().find(|end| !is_boolean(parts, end))
        {
            let name = format!("{}.{}", parts[end.component].name, end.variable);
            return Err(placed(&SspProblem::BooleanMapping(name).to_string()));
        }
        let linear = connection.route.linear(source.as_ref(), target.as_ref());
        let linear = linear.map_err(|error| {
            placed(&format!(
                "`{}.{}` to `{}.{}`: {error}",
                parts[from.component].name, from.variable, parts[to.component].name, to.variable
            ))
        })?;
        Ok((from.clone(), to.clone(), linear))
    });
    resolved.collect()
}

/// Outputs of the system, in the units of their connectors.
fn outputs(structure: &SystemStructure, parts: &[Part]) -> Result<Vec<SystemColumn>, Failure> {
    let columns = structure.outputs.iter().map(|output| {
        let part = &parts[output.from.component];
        let own = part.unit(&output.from.variable)?;
        let failed = |error| Failure::input(format!("the system's output `{}`: {error}", output.name));
        let linear = output.route.linear(own.as_ref(), output.route.unit()).map_err(failed)?;
        let unit = output.route.unit().or(own.as_ref()).map(|unit| unit.name.clone());
        let from = format!("{}.{}", part.name, output.from.variable);
        Ok(SystemColumn { name: output.name.clone(), from, linear, unit })
    });
    columns.collect()
}

fn is_boolean(parts: &[Part], end: &End) -> bool {
    parts[end.component].variable(&end.variable).is_ok_and(|row| row.kind == TypeOfVariable::Boolean)
}

/// All outputs, and what else is asked for.
fn observe(system: &mut System, names: &[String], more: &[(usize, String)]) -> Result<(), Failure> {
    for port in system.observed() {
        let variable = system.slaves()[port.slave].variables()[port.variable].name.clone();
        let slave = system.slaves()[port.slave].name().to_owned();
        system.observe(&slave, &variable).map_err(refused)?;
    }
    more.iter()
        .try_for_each(|(component, variable)| system.observe(&names[*component], variable).map_err(refused))
}
