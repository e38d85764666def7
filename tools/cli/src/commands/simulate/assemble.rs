//! From files to a system the master can run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;

use stickslip::cosim::{Slave, SlaveError, System};
use stickslip::document::nearest;
use stickslip_fmi_host::{Fmu, FmuSlave, ImportError, IsolatedSlave, Log, ScalarVariable, TypeOfVariable};
use stickslip_readers::ssp::{self, End, Parameter, SystemStructure, Value};
use stickslip_readers::units::{Linear, Unit};

use super::inputs::{self, Driven};
use super::{Simulate, not_begun, refused};
use crate::{Failure, progress};

/// A system ready to run.
pub(super) struct Assembly {
    pub title: String,
    pub system: System,
    pub start: Option<f64>,
    pub stop: Option<f64>,
    pub step: Option<f64>,
    pub remarks: Vec<String>,
    /// What each FMU says.
    pub logs: Vec<(String, Arc<Log>)>,
}

/// An FMU in the system, before the master takes it.
pub(super) struct Part {
    pub name: String,
    pub fmu: Arc<Fmu>,
    /// Units that the system declares.
    units: Vec<(String, Unit)>,
    instance: Instance,
}

enum Instance {
    Here(FmuSlave),
    Elsewhere(IsolatedSlave),
}

impl Instance {
    /// What a connector says of a variable whose FMU says nothing: power connections are found by it.
    fn name_unit(&mut self, variable: &str, unit: &str) {
        match self {
            Instance::Here(slave) => slave.name_unit(variable, unit),
            Instance::Elsewhere(slave) => slave.name_unit(variable, unit),
        }
    }
}

impl Part {
    fn log(&self) -> Arc<Log> {
        match &self.instance {
            Instance::Here(slave) => Arc::clone(slave.log()),
            Instance::Elsewhere(slave) => Arc::clone(slave.log()),
        }
    }

    fn set_text(&mut self, variable: &str, text: &str) -> Result<(), SlaveError> {
        match &mut self.instance {
            Instance::Here(slave) => slave.set_text(variable, text),
            Instance::Elsewhere(slave) => slave.set_text(variable, text),
        }
    }

    fn boxed(self) -> Box<dyn Slave> {
        match self.instance {
            Instance::Here(slave) => Box::new(slave),
            Instance::Elsewhere(slave) => Box::new(slave),
        }
    }

    /// The variable called `name`, which is an input or parameter or whatever can be set.
    pub fn variable(&self, name: &str) -> Result<&ScalarVariable, Failure> {
        let description = self.fmu.description();
        match description.position(name) {
            Some(position) => Ok(&description.variables[position]),
            None => Err(Failure::input(self.unknown(name))),
        }
    }

    /// That there is no variable called `name`, and which may be meant.
    fn unknown(&self, name: &str) -> String {
        let names: Vec<&str> =
            self.fmu.description().variables.iter().map(|variable| variable.name.as_str()).collect();
        let meant =
            nearest(name, &names).map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
        format!("{} ({}) has no variable `{name}`{meant}", self.name, self.fmu.name())
    }

    /// The unit of a variable, as the FMU says or else the system.
    pub fn unit(&self, name: &str) -> Result<Option<Unit>, Failure> {
        let declared = || self.units.iter().find(|(other, _)| other == name).map(|(_, unit)| unit.clone());
        Ok(self.fmu.description().unit(self.variable(name)?).or_else(declared))
    }
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
    let records = arguments.record.iter().map(|name| find(&parts, name));
    let records = records.collect::<Result<Vec<_>, Failure>>()?;
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
    for ((component, variable), value) in &starts.numbers {
        system.start(&names[*component], variable, *value).map_err(refused)?;
    }
    observe(&mut system, &names, &records)?;
    inputs::connect(&mut system, sources, &names)?;
    let Experiment { start, stop, step } = experiment;
    Ok(Assembly { title: structure.name.clone(), system, start, stop, step, remarks, logs })
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

/// Opens each file once and makes an instance for each component.
fn instantiate(
    structure: &SystemStructure,
    arguments: &Simulate,
    remarks: &mut Vec<String>,
) -> Result<Vec<Part>, Failure> {
    let failed = |error: ImportError| not_begun(error.to_string());
    let mut opened: BTreeMap<PathBuf, Arc<Fmu>> = BTreeMap::new();
    let mut parts = Vec::new();
    for component in &structure.components {
        let fmu = match opened.get(&component.file) {
            Some(fmu) => Arc::clone(fmu),
            None => {
                let fmu = Fmu::open_as(&component.file, &component.source).map_err(failed)?;
                remarks.extend(fmu.remarks());
                opened.insert(component.file.clone(), Arc::clone(&fmu));
                fmu
            }
        };
        let name = component.name.clone();
        let mut instance = if arguments.isolate {
            let process = own_process(&fmu, &name)?;
            Instance::Elsewhere(fmu.isolated(&name, process, progress::interrupted).map_err(failed)?)
        } else {
            Instance::Here(fmu.instantiate(&name).map_err(failed)?)
        };
        for (variable, unit) in &component.units {
            instance.name_unit(variable, &unit.name);
        }
        parts.push(Part { name, fmu, units: component.units.clone(), instance });
    }
    Ok(parts)
}

/// This program, to run one FMU.
fn own_process(fmu: &Fmu, name: &str) -> Result<Command, Failure> {
    let program = std::env::current_exe()
        .map_err(|error| Failure::other(format!("this program cannot be started again: {error}")))?;
    let mut command = Command::new(program);
    command.arg(super::super::serve::NAME).arg("--").arg(fmu.folder()).arg(fmu.name()).arg(name);
    Ok(command)
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

/// A unit as its file, one of the FMUs or common use defines it.
pub(super) fn defined(unit: &Unit, parts: &[Part]) -> Result<Unit, String> {
    let units = || parts.iter().flat_map(|part| &part.fmu.description().units);
    if unit.exponents.is_some() {
        return Ok(unit.clone());
    }
    let found = units().find(|other| other.name == unit.name).cloned().or_else(|| Unit::common(&unit.name));
    found.ok_or_else(|| format!("`{}` is no unit that is known here or defined in the files", unit.name))
}

/// From unit to unit; numbers without a unit, or for a variable without one, are taken as they are.
pub(super) fn converted(from: Option<&Unit>, to: Option<&Unit>) -> Result<Linear, String> {
    match (from, to) {
        (Some(from), Some(to)) => from.conversion(to).map_err(|error| error.to_string()),
        _ => Ok(Linear::IDENTITY),
    }
}

/// Start values: the last one given for a variable holds.
#[derive(Default)]
struct Starts {
    numbers: BTreeMap<(usize, String), f64>,
    texts: Vec<(usize, String, String)>,
}

impl Starts {
    /// A value from the system's file. One that belongs to nothing is only remarked on, as the standard wants it.
    fn parameter(
        &mut self,
        parts: &[Part],
        parameter: &Parameter,
        remarks: &mut Vec<String>,
    ) -> Result<(), Failure> {
        let End { component, variable } = &parameter.target;
        let part = &parts[*component];
        let Ok(own) = part.unit(variable) else {
            remarks.push(format!("{}: the value is ignored: {}", parameter.place, part.unknown(variable)));
            return Ok(());
        };
        let from = parameter.unit.as_ref().map(|unit| defined(unit, parts)).transpose();
        let linear = from.and_then(|from| converted(from.as_ref(), own.as_ref())).map_err(|reason| {
            Failure::input(format!("{}: `{}.{variable}`: {reason}", parameter.place, part.name))
        })?;
        let number = match &parameter.value {
            Value::Real(value) => *value,
            Value::Integer(value) => f64::from(*value),
            Value::Boolean(value) => f64::from(u8::from(*value)),
            Value::Text(text) => {
                self.texts.push((*component, variable.clone(), text.clone()));
                return Ok(());
            }
        };
        let value = linear.then(parameter.transformation).apply(number);
        self.numbers.insert((*component, variable.clone()), value);
        Ok(())
    }

    /// `component.variable=value`, or an input of the system.
    fn assignment(
        &mut self,
        parts: &[Part],
        structure: &SystemStructure,
        sources: &[Driven],
        assignment: &str,
    ) -> Result<(), Failure> {
        let Some((name, text)) = assignment.split_once('=') else {
            return Err(Failure::input(format!("`--set {assignment}` should be NAME=VALUE")));
        };
        let (name, text) = (name.trim(), text.trim());
        if let Some(input) = structure.inputs.iter().find(|input| input.name == name) {
            let value = number(name, text)?;
            for (end, route) in &input.targets {
                check_free(parts, structure, sources, end)?;
                let unit = parts[end.component].unit(&end.variable)?;
                let linear = route.linear(None, unit.as_ref());
                let linear = linear.map_err(|error| Failure::input(format!("`{name}`: {error}")))?;
                self.numbers.insert((end.component, end.variable.clone()), linear.apply(value));
            }
            return Ok(());
        }
        let (component, variable) = find(parts, name)?;
        check_free(parts, structure, sources, &End { component, variable: variable.clone() })?;
        let row = parts[component].variable(&variable)?;
        let value = match &row.kind {
            TypeOfVariable::String => {
                self.texts.push((component, variable, text.to_owned()));
                return Ok(());
            }
            TypeOfVariable::Boolean => match text {
                "true" | "1" => 1.0,
                "false" | "0" => 0.0,
                _ => return Err(Failure::input(format!("`{name}` is true or false, not `{text}`"))),
            },
            TypeOfVariable::Enumeration(items) => match items.iter().find(|(item, _)| item == text) {
                Some((_, value)) => f64::from(*value),
                None => number(name, text)?,
            },
            _ => number(name, text)?,
        };
        self.numbers.insert((component, variable), value);
        Ok(())
    }
}

fn number(name: &str, text: &str) -> Result<f64, Failure> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(Failure::input(format!("`{name}` cannot be `{text}`: it is a number"))),
    }
}

/// The component and variable that `component.variable` names; a lone FMU's variables go by their names alone, too.
pub(super) fn find(parts: &[Part], name: &str) -> Result<(usize, String), Failure> {
    let mut ends = parts.iter().enumerate().filter_map(|(index, part)| {
        let rest = name.strip_prefix(part.name.as_str())?.strip_prefix('.')?;
        part.variable(rest).is_ok().then(|| (index, rest.to_owned()))
    });
    if let Some(found) = ends.next_back() {
        return Ok(found);
    }
    if let [part] = parts
        && part.variable(name).is_ok()
    {
        return Ok((0, name.to_owned()));
    }
    let named = parts.iter().find(|part| name.starts_with(&format!("{}.", part.name)));
    Err(Failure::input(match (named, parts) {
        (Some(part), _) => part.unknown(&name[part.name.len() + 1..]),
        (None, [part]) => part.unknown(name),
        (None, _) => {
            let names: Vec<&str> = parts.iter().map(|part| part.name.as_str()).collect();
            format!("there is no component of `{name}`; the system has {}", names.join(", "))
        }
    }))
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
