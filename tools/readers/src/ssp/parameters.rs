//! Parameter bindings: sets of values, mapped to the variables of components.

use std::collections::BTreeSet;

use super::flatten::{Flat, inside};
use super::known::check_known;
use super::parse::{check_version, resolve, transformation};
use super::{End, Parameter, SspProblem, Value, unit_called};
use crate::error::InputError;
use crate::units::{Linear, Unit, read_units};
use crate::xml::{Element, XmlFile, truth};

/// The parameters of `system` and all in it, those that hold last.
pub(super) fn bindings(
    flat: &Flat<'_>,
    root: &Element,
    system: &Element,
    found: &mut Vec<Parameter>,
    remarks: &mut Vec<String>,
) -> Result<(), InputError> {
    Collector { flat, root, found, remarks }.element(system, "")
}

struct Collector<'a, 'e> {
    flat: &'a Flat<'e>,
    root: &'a Element,
    found: &'a mut Vec<Parameter>,
    remarks: &'a mut Vec<String>,
}

/// A value of a set.
struct Given {
    name: String,
    value: Value,
    unit: Option<Unit>,
    place: String,
}

/// A line of a mapping.
struct Entry {
    source: String,
    target: String,
    transformation: Linear,
    booleans: bool,
    converts: bool,
}

impl Collector<'_, '_> {
    /// The bindings of a component or system called `path`, those of what is in it first: outer ones hold.
    fn element(&mut self, element: &Element, path: &str) -> Result<(), InputError> {
        for child in element.all("Elements").flat_map(Element::children) {
            if matches!(child.name(), "Component" | "System") {
                self.element(child, &inside(path, self.flat.file.required(child, "name")?))?;
            }
        }
        for binding in element.list("ParameterBindings", "ParameterBinding") {
            self.binding(binding, element, path)?;
        }
        Ok(())
    }

    fn binding(&mut self, binding: &Element, owner: &Element, path: &str) -> Result<(), InputError> {
        let file = self.flat.file;
        match binding.attribute("type") {
            None | Some("application/x-ssp-parameter-set") => {}
            Some(other) => {
                let what = format!("parameter sources of the type `{other}`");
                return Err(file.error(binding, SspProblem::Unsupported(what)));
            }
        }
        let given = match binding.attribute("source") {
            Some(uri) => {
                let set = self.outer(binding, uri)?;
                let root = set.root("ParameterSet")?;
                check_version(&set, root)?;
                check_known(&set, root, self.remarks)?;
                values(&set, root, None)?
            }
            None => {
                let inline = binding.child("ParameterValues").and_then(|values| values.child("ParameterSet"));
                let Some(set) = inline else {
                    self.remarks.push(format!("{}: a parameter binding without values", file.place(binding)));
                    return Ok(());
                };
                values(file, set, Some(self.root))?
            }
        };
        let mapping = self.mapping(binding)?;
        let prefix = binding.attribute("prefix").unwrap_or_default();
        for mut value in given {
            value.name.insert_str(0, prefix);
            let entries = mapping.as_deref().unwrap_or_default();
            let wrong = entries.iter().any(|entry| entry.booleans && entry.source == value.name);
            if wrong && !matches!(value.value, Value::Boolean(_)) {
                return Err(file.error(binding, SspProblem::BooleanMapping(value.name)));
            }
            self.mapped(value, mapping.as_deref(), owner, path);
        }
        Ok(())
    }

    /// A file that the description names.
    fn outer(&self, element: &Element, uri: &str) -> Result<XmlFile, InputError> {
        let path = resolve(self.flat.files, self.flat.file, element, uri)?;
        let named = self.flat.files.named.parent().map_or_else(|| uri.into(), |folder| folder.join(uri));
        let bytes = std::fs::read(&path).map_err(|error| {
            let problem = SspProblem::Source { source_uri: uri.to_owned(), reason: error.to_string() };
            self.flat.file.error(element, problem)
        })?;
        XmlFile::from_bytes(&named, bytes)
    }

    fn mapping(&mut self, binding: &Element) -> Result<Option<Vec<Entry>>, InputError> {
        let Some(mapping) = binding.child("ParameterMapping") else { return Ok(None) };
        if let Some(uri) = mapping.attribute("source") {
            let file = self.outer(mapping, uri)?;
            let root = file.root("ParameterMapping")?;
            check_version(&file, root)?;
            check_known(&file, root, self.remarks)?;
            return entries(&file, root).map(Some);
        }
        // An inline mapping is an element of the same name in it.
        let inner = mapping.child("ParameterMapping").unwrap_or(mapping);
        entries(self.flat.file, inner).map(Some)
    }

    /// Notes down `given` for every variable it is meant for.
    fn mapped(&mut self, given: Given, mapping: Option<&[Entry]>, owner: &Element, path: &str) {
        let as_it_is = Entry {
            source: given.name.clone(),
            target: given.name.clone(),
            transformation: Linear::IDENTITY,
            booleans: false,
            converts: true,
        };
        let entries: Vec<&Entry> = match mapping {
            Some(entries) => entries.iter().filter(|entry| entry.source == given.name).collect(),
            None => vec![&as_it_is],
        };
        let mut targets = 0;
        for entry in entries {
            for target in self.targets(&entry.target, owner, path) {
                targets += 1;
                self.found.push(Parameter {
                    target,
                    value: given.value.clone(),
                    unit: given.unit.clone().filter(|_| entry.converts),
                    transformation: entry.transformation,
                    place: given.place.clone(),
                });
            }
        }
        if targets == 0 {
            self.remarks.push(format!(
                "{}: the parameter `{}` belongs to nothing in the system",
                given.place, given.name
            ));
        }
    }

    /// The variables that `name` means in the element called `path`.
    fn targets(&self, name: &str, owner: &Element, path: &str) -> Vec<End> {
        if owner.name() == "Component" {
            let component = self.flat.components.iter().position(|component| component.name == path);
            let end = component.map(|component| End { component, variable: name.to_owned() });
            return end.into_iter().collect();
        }
        let key = (path.to_owned(), name.to_owned());
        if self.flat.has_connector(&key) {
            return self.flat.targets(&key);
        }
        for child in owner.all("Elements").flat_map(Element::children) {
            let Some(own) = child.attribute("name") else { continue };
            if let Some(rest) = name.strip_prefix(own).and_then(|rest| rest.strip_prefix('.')) {
                let found = self.targets(rest, child, &inside(path, own));
                if !found.is_empty() {
                    return found;
                }
            }
        }
        Vec::new()
    }
}

fn entries(file: &XmlFile, mapping: &Element) -> Result<Vec<Entry>, InputError> {
    let entry = |element: &Element| {
        let (transformation, booleans) = transformation(file, element)?;
        Ok(Entry {
            source: file.required(element, "source")?.to_owned(),
            target: file.required(element, "target")?.to_owned(),
            transformation,
            booleans,
            converts: !file.boolean(element, "suppressUnitConversion")?.unwrap_or(false),
        })
    };
    mapping.all("MappingEntry").map(entry).collect()
}

/// The values of a set; `outer` has the units and enumerations that hold for an inline set besides its own.
fn values(file: &XmlFile, set: &Element, outer: Option<&Element>) -> Result<Vec<Given>, InputError> {
    check_version(file, set)?;
    let mut units = read_units(file, set.list("Units", "Unit"))?;
    if let Some(outer) = outer {
        units.extend(read_units(file, outer.list("Units", "Unit"))?);
    }
    let value = |parameter: &Element| {
        let name = file.required(parameter, "name")?.to_owned();
        let (value, unit) = value(file, parameter, [Some(set), outer])?;
        let unit = match unit {
            None => None,
            Some(name) => Some(unit_called(name, &units).map_err(|problem| file.error(parameter, problem))?),
        };
        Ok(Given { name, value, unit, place: file.place(parameter) })
    };
    check_once(file, set)?;
    set.list("Parameters", "Parameter").map(value).collect()
}

/// Each parameter of a set has a name of its own.
fn check_once(file: &XmlFile, set: &Element) -> Result<(), InputError> {
    let mut names = BTreeSet::new();
    for parameter in set.list("Parameters", "Parameter") {
        let name = file.required(parameter, "name")?;
        if !names.insert(name) {
            let problem = SspProblem::Twice { what: "the parameter", name: name.to_owned() };
            return Err(file.error(parameter, problem));
        }
    }
    Ok(())
}

/// A value, and the name of its unit.
fn value<'e>(
    file: &XmlFile,
    parameter: &'e Element,
    enumerations: [Option<&Element>; 2],
) -> Result<(Value, Option<&'e str>), InputError> {
    let typed = parameter.children().iter().find(|child| child.name() != "Annotations");
    let Some(typed) = typed else {
        return Err(file
            .required_child(parameter, "Real")
            .err()
            .unwrap_or_else(|| file.value_error(parameter, "name", "a parameter with a value")));
    };
    let text = file.required(typed, "value")?;
    let value = match typed.name() {
        "Real" => {
            let number = file.number(typed, "value")?.unwrap_or_default();
            return Ok((Value::Real(number), typed.attribute("unit")));
        }
        "Integer" => Value::Integer(file.number(typed, "value")?.unwrap_or_default()),
        "Boolean" => {
            Value::Boolean(truth(text).ok_or_else(|| file.value_error(typed, "value", "true or false"))?)
        }
        "String" => Value::Text(text.to_owned()),
        "Enumeration" => {
            let lists = enumerations.into_iter().flatten();
            let lists = lists.flat_map(|owner| owner.list("Enumerations", "Enumeration"));
            let wanted = typed.attribute("name");
            let item = lists
                .filter(|list| wanted.is_none_or(|name| list.attribute("name") == Some(name)))
                .flat_map(|list| list.all("Item"))
                .find(|item| item.attribute("name") == Some(text));
            let Some(item) = item else {
                return Err(file.error(typed, SspProblem::UnknownItem(text.to_owned())));
            };
            file.required(item, "value")?;
            Value::Integer(file.number(item, "value")?.unwrap_or_default())
        }
        other => {
            let what = format!("parameters of the type `{other}`");
            return Err(file.error(typed, SspProblem::Unsupported(what)));
        }
    };
    Ok((value, None))
}
