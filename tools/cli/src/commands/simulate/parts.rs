//! The FMUs of a system, before the master takes them.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;
use std::sync::Arc;

use stickslip::cosim::{Slave, SlaveError};
use stickslip::document::nearest;
use stickslip_fmi_host::{Fmu, FmuSlave, ImportError, IsolatedSlave, Log, ScalarVariable, TypeOfVariable};
use stickslip_readers::ssp::{Component, DeclaredType, SystemStructure};
use stickslip_readers::units::{Linear, Unit};

use super::{Simulate, not_begun};
use crate::{Failure, progress};

/// An FMU in the system, before the master takes it.
pub struct Part {
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
    pub fn log(&self) -> Arc<Log> {
        match &self.instance {
            Instance::Here(slave) => Arc::clone(slave.log()),
            Instance::Elsewhere(slave) => Arc::clone(slave.log()),
        }
    }

    pub fn set_text(&mut self, variable: &str, text: &str) -> Result<(), SlaveError> {
        match &mut self.instance {
            Instance::Here(slave) => slave.set_text(variable, text),
            Instance::Elsewhere(slave) => slave.set_text(variable, text),
        }
    }

    pub fn boxed(self) -> Box<dyn Slave> {
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
    pub fn unknown(&self, name: &str) -> String {
        let names: Vec<&str> =
            self.fmu.description().variables.iter().map(|variable| &*variable.name).collect();
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

/// Opens each file once and makes an instance for each component.
pub fn instantiate(
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
                if foreign(&fmu) && !arguments.isolate && !arguments.no_isolate {
                    remarks.push(format!(
                        "{} is not of this program: it runs in a process of its own (--no-isolate runs it here, which \
                         saves some 15 µs a call)",
                        fmu.name()
                    ));
                }
                opened.insert(component.file.clone(), Arc::clone(&fmu));
                fmu
            }
        };
        check_types(component, &fmu)?;
        let name = component.name.clone();
        let apart = arguments.isolate || !arguments.no_isolate && foreign(&fmu);
        let mut instance = if apart {
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

/// Refuses connectors of another type than that of their variables.
fn check_types(component: &Component, fmu: &Fmu) -> Result<(), Failure> {
    let description = fmu.description();
    for DeclaredType { variable, name, place } in &component.types {
        let Some(position) = description.position(variable) else { continue };
        let own = match &description.variables[position].kind {
            TypeOfVariable::Real => "Real",
            TypeOfVariable::Integer => "Integer",
            TypeOfVariable::Boolean => "Boolean",
            TypeOfVariable::Enumeration(_) => "Enumeration",
            // Arrays of texts are not told from binary data.
            TypeOfVariable::String | TypeOfVariable::Opaque if ["String", "Binary"].contains(name) => {
                continue;
            }
            TypeOfVariable::String => "String",
            TypeOfVariable::Opaque => "Binary",
        };
        // An item of an enumeration is a whole number.
        let whole = ["Integer", "Enumeration"];
        if own != *name && !(whole.contains(&own) && whole.contains(name)) {
            return Err(Failure::input(format!(
                "{place}: the connector `{}.{variable}` is declared {name}, but the variable is {own}",
                component.name
            )));
        }
    }
    Ok(())
}

/// Whether it holds other code than what this program exports.
fn foreign(fmu: &Fmu) -> bool {
    !fmu.has_library(stickslip_fmu_package::library().bytes)
}

/// This program, to run one FMU.
fn own_process(fmu: &Fmu, name: &str) -> Result<Command, Failure> {
    let program = std::env::current_exe()
        .map_err(|error| Failure::other(format!("this program cannot be started again: {error}")))?;
    let mut command = Command::new(program);
    command.arg(super::super::serve::NAME).arg("--").arg(fmu.folder()).arg(fmu.name()).arg(name);
    Ok(command)
}

/// A unit as its file, one of the FMUs or common use defines it.
pub fn defined(unit: &Unit, parts: &[Part]) -> Result<Unit, String> {
    let units = || parts.iter().flat_map(|part| &part.fmu.description().units);
    if unit.exponents.is_some() {
        return Ok(unit.clone());
    }
    let found = units().find(|other| other.name == unit.name).cloned().or_else(|| Unit::common(&unit.name));
    found.ok_or_else(|| format!("`{}` is no unit that is known here or defined in the files", unit.name))
}

/// From unit to unit; numbers without a unit, or for a variable without one, are taken as they are.
pub fn converted(from: Option<&Unit>, to: Option<&Unit>) -> Result<Linear, String> {
    match (from, to) {
        (Some(from), Some(to)) => from.conversion(to).map_err(|error| error.to_string()),
        _ => Ok(Linear::IDENTITY),
    }
}

/// The component and variable that `component.variable` names; a lone FMU's variables go by their names alone, too.
pub fn find(parts: &[Part], name: &str) -> Result<(usize, String), Failure> {
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
