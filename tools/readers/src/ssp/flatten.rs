//! Nested systems as one: components by their full names, and the ways between them.

use std::collections::BTreeMap;

use super::known::TYPES;
use super::parse::{Files, resolve, transformation};
use super::route::{Hop, Route};
use super::{Component, Connection, DeclaredType, End, SspProblem, SystemInput, SystemOutput, unit_called};
use crate::error::InputError;
use crate::units::Unit;
use crate::xml::{Element, XmlFile};

/// A connector: the full name of its element (empty for the outermost system), and its own.
pub(super) type Key = (String, String);

/// What a connector is.
struct Connector<'e> {
    /// Whether values flow into its element.
    inward: bool,
    /// Position of its component; none for systems.
    component: Option<usize>,
    unit: Option<Unit>,
    element: &'e Element,
}

/// What sets a connector.
struct Driver<'e> {
    from: Key,
    hop: Hop,
    element: &'e Element,
}

/// A system and all systems in it.
pub(super) struct Flat<'e> {
    pub(super) file: &'e XmlFile,
    pub(super) files: &'e Files,
    pub(super) units: &'e [Unit],
    pub(super) components: Vec<Component>,
    connectors: BTreeMap<Key, Connector<'e>>,
    drivers: BTreeMap<Key, Driver<'e>>,
    /// Inputs of components and connectors of the outermost system, in the order of the file.
    order: Vec<Key>,
}

/// The full name of an element in the system `path`.
pub(super) fn inside(path: &str, name: &str) -> String {
    if path.is_empty() { name.to_owned() } else { format!("{path}.{name}") }
}

fn shown(key: &Key) -> String {
    inside(&key.0, &key.1)
}

impl<'e> Flat<'e> {
    pub(super) fn new(
        file: &'e XmlFile,
        files: &'e Files,
        system: &'e Element,
        units: &'e [Unit],
    ) -> Result<Self, InputError> {
        let (components, connectors) = (Vec::new(), BTreeMap::new());
        let drivers = BTreeMap::new();
        let mut flat = Self { file, files, units, components, connectors, drivers, order: Vec::new() };
        flat.system(system, "")?;
        Ok(flat)
    }

    /// Takes in a system, the systems in it first.
    fn system(&mut self, system: &'e Element, path: &str) -> Result<(), InputError> {
        self.connectors_of(system, path, None)?;
        let mut names = Vec::new();
        for element in system.all("Elements").flat_map(Element::children) {
            let name = match element.name() {
                "Component" | "System" => self.file.required(element, "name")?,
                "SignalDictionaryReference" => {
                    let what = "signal dictionaries".to_owned();
                    return Err(self.file.error(element, SspProblem::Unsupported(what)));
                }
                _ => continue,
            };
            let whole = inside(path, name);
            if names.contains(&name) || self.components.iter().any(|component| component.name == whole) {
                let problem = SspProblem::Twice { what: "the element", name: whole };
                return Err(self.file.error(element, problem));
            }
            names.push(name);
            if element.name() == "System" {
                self.system(element, &whole)?;
            } else {
                self.component(element, whole)?;
            }
        }
        for connection in system.list("Connections", "Connection") {
            self.connection(connection, path, &names)?;
        }
        Ok(())
    }

    fn component(&mut self, element: &'e Element, name: String) -> Result<(), InputError> {
        let unsupported = |what: String| Err(self.file.error(element, SspProblem::Unsupported(what)));
        match element.attribute("type") {
            None | Some("application/x-fmu-sharedlibrary") => {}
            Some(other) => return unsupported(format!("components of the type `{other}`")),
        }
        if element.attribute("implementation") == Some("ModelExchange") {
            return unsupported("components that ask for model exchange".to_owned());
        }
        let source = self.file.required(element, "source")?.to_owned();
        let file = resolve(self.files, self.file, element, &source)?;
        let place = self.file.place(element);
        self.connectors_of(element, &name, Some(self.components.len()))?;
        let own = || self.connectors.iter().filter(|(key, _)| key.0 == name);
        let units = own().filter_map(|(key, one)| Some((key.1.clone(), one.unit.clone()?))).collect();
        let types = own().filter_map(|(key, one)| self.declared(&key.1, one.element)).collect();
        self.components.push(Component { name, file, source, units, types, place });
        Ok(())
    }

    /// The type that the connector `variable` declares.
    fn declared(&self, variable: &str, connector: &Element) -> Option<DeclaredType> {
        let name = TYPES.into_iter().find(|name| connector.child(name).is_some())?;
        Some(DeclaredType { variable: variable.to_owned(), name, place: self.file.place(connector) })
    }

    fn connectors_of(
        &mut self,
        owner: &'e Element,
        path: &str,
        component: Option<usize>,
    ) -> Result<(), InputError> {
        for element in owner.list("Connectors", "Connector") {
            let name = self.file.required(element, "name")?;
            let inward = match self.file.required(element, "kind")? {
                "input" | "parameter" => true,
                "output" | "calculatedParameter" => false,
                "inout" => {
                    let what = "connectors of the kind `inout`".to_owned();
                    return Err(self.file.error(element, SspProblem::Unsupported(what)));
                }
                _ => {
                    let kinds = "input, output, parameter, calculatedParameter or inout";
                    return Err(self.file.value_error(element, "kind", kinds));
                }
            };
            let unit = element.child("Real").and_then(|real| real.attribute("unit"));
            let unit = unit.map(|name| self.unit(element, name)).transpose()?;
            let key = (path.to_owned(), name.to_owned());
            let connector = Connector { inward, component, unit, element };
            if self.connectors.insert(key.clone(), connector).is_some() {
                let problem = SspProblem::Twice { what: "the connector", name: shown(&key) };
                return Err(self.file.error(element, problem));
            }
            if component.is_some() || path.is_empty() {
                self.order.push(key);
            }
        }
        Ok(())
    }

    fn unit(&self, element: &Element, name: &str) -> Result<Unit, InputError> {
        unit_called(name, self.units).map_err(|problem| self.file.error(element, problem))
    }

    fn connection(&mut self, element: &'e Element, path: &str, names: &[&str]) -> Result<(), InputError> {
        let start = self.end(element, path, names, "startElement", "startConnector")?;
        let end = self.end(element, path, names, "endElement", "endConnector")?;
        // A system's own connector seen from inside works the other way round.
        let gives = |key: &Key, own: bool| self.connectors[key].inward == own;
        let (from, to) = match (gives(&start.0, start.1), gives(&end.0, end.1)) {
            (true, false) => (start.0, end.0),
            (false, true) => (end.0, start.0),
            _ => {
                let problem = SspProblem::Direction { start: shown(&start.0), end: shown(&end.0) };
                return Err(self.file.error(element, problem));
            }
        };
        let (transformation, booleans) = transformation(self.file, element)?;
        let real = |key: &&Key| self.connectors[*key].element.child("Real").is_some();
        if let Some(key) = [&from, &to].into_iter().find(|key| booleans && real(key)) {
            return Err(self.file.error(element, SspProblem::BooleanMapping(shown(key))));
        }
        let hop = Hop {
            converts: !self.file.boolean(element, "suppressUnitConversion")?.unwrap_or(false),
            transformation,
            booleans,
            unit: self.connectors[&to].unit.clone(),
        };
        let name = shown(&to);
        if self.drivers.insert(to, Driver { from, hop, element }).is_some() {
            return Err(self.file.error(element, SspProblem::TwoSources(name)));
        }
        Ok(())
    }

    /// One end of a connection, and whether it is the system's own connector.
    fn end(
        &self,
        element: &Element,
        path: &str,
        names: &[&str],
        which: &'static str,
        connector: &'static str,
    ) -> Result<(Key, bool), InputError> {
        let connector = self.file.required(element, connector)?.to_owned();
        let (owner, key, own) = match element.attribute(which) {
            Some(name) if !names.contains(&name) => {
                return Err(self.file.error(element, SspProblem::UnknownElement(name.to_owned())));
            }
            Some(name) => (name.to_owned(), (inside(path, name), connector), false),
            None => ("the system".to_owned(), (path.to_owned(), connector), true),
        };
        if self.connectors.contains_key(&key) {
            return Ok((key, own));
        }
        let problem = SspProblem::UnknownConnector { element: owner, connector: key.1 };
        Err(self.file.error(element, problem))
    }

    /// Where the value of `key` comes from: a component's output or the outermost system's input, or nowhere.
    fn way(&self, key: &Key) -> Result<Option<(Key, Route)>, InputError> {
        let mut route = Route::default();
        let mut at = key;
        while let Some(driver) = self.drivers.get(at) {
            route.hops.insert(0, driver.hop.clone());
            at = &driver.from;
            let connector = &self.connectors[at];
            if connector.component.is_some() || (at.0.is_empty() && connector.inward) {
                route.first = connector.unit.clone();
                return Ok(Some((at.clone(), route)));
            }
            if route.hops.len() > self.drivers.len() {
                return Err(self.file.error(driver.element, SspProblem::Circle(shown(key))));
            }
        }
        Ok(None)
    }

    fn component_end(&self, key: &Key) -> Option<End> {
        let component = self.connectors[key].component?;
        Some(End { component, variable: key.1.clone() })
    }

    /// Inputs of components with what sets them.
    fn inward_ways(&self) -> impl Iterator<Item = Result<(End, Key, Route), InputError>> {
        let inputs = self.order.iter().filter(|key| self.connectors[key].inward);
        inputs.filter_map(|key| {
            let end = self.component_end(key)?;
            match self.way(key) {
                Ok(way) => way.map(|(from, route)| Ok((end, from, route))),
                Err(error) => Some(Err(error)),
            }
        })
    }

    /// From components to components.
    pub(super) fn connections(&self, remarks: &mut Vec<String>) -> Result<Vec<Connection>, InputError> {
        let mut connections = Vec::new();
        for way in self.inward_ways() {
            let (to, from, route) = way?;
            if let Some(from) = self.component_end(&from) {
                let key = (self.components[to.component].name.clone(), to.variable.clone());
                let place = self.file.place(self.drivers[&key].element);
                connections.push(Connection { from, to, route, place });
            }
        }
        for (key, driver) in &self.drivers {
            let outer = self.connectors[key].component.is_some() || key.0.is_empty();
            if outer && self.way(key)?.is_none() {
                let place = self.file.place(driver.element);
                remarks.push(format!(
                    "{place}: nothing sets `{}`, from which `{}` comes",
                    shown(&driver.from),
                    shown(key)
                ));
            }
        }
        Ok(connections)
    }

    /// Inputs of the outermost system.
    pub(super) fn inputs(&self) -> Result<Vec<SystemInput>, InputError> {
        let own = self.order.iter().filter(|key| key.0.is_empty() && self.connectors[key].inward);
        let mut inputs: Vec<SystemInput> =
            own.map(|key| SystemInput { name: key.1.clone(), targets: Vec::new() }).collect();
        for way in self.inward_ways() {
            let (to, from, route) = way?;
            if let Some(input) = inputs.iter_mut().find(|input| from.0.is_empty() && input.name == from.1) {
                input.targets.push((to, route));
            }
        }
        Ok(inputs)
    }

    /// Outputs of the outermost system.
    pub(super) fn outputs(&self, remarks: &mut Vec<String>) -> Result<Vec<SystemOutput>, InputError> {
        let mut outputs = Vec::new();
        for key in self.order.iter().filter(|key| key.0.is_empty() && !self.connectors[key].inward) {
            let from = self.way(key)?.and_then(|(from, route)| Some((self.component_end(&from)?, route)));
            match from {
                Some((from, route)) => outputs.push(SystemOutput { name: key.1.clone(), from, route }),
                None => remarks.push(format!(
                    "{}: no component sets the system's output `{}`",
                    self.file.place(self.connectors[key].element),
                    key.1
                )),
            }
        }
        Ok(outputs)
    }

    /// The inputs of components that a system's connector leads to.
    pub(super) fn targets(&self, key: &Key) -> Vec<End> {
        let mut found = Vec::new();
        let mut front = vec![key.clone()];
        let mut seen = 0;
        while let Some(at) = front.pop() {
            seen += 1;
            if seen > self.connectors.len() {
                break;
            }
            match self.component_end(&at) {
                Some(end) if at != *key => found.push(end),
                _ => front.extend(
                    self.drivers.iter().filter(|(_, driver)| driver.from == at).map(|(to, _)| to.clone()),
                ),
            }
        }
        found.sort_by(|one, other| (one.component, &one.variable).cmp(&(other.component, &other.variable)));
        found
    }

    /// Whether a system has such a connector.
    pub(super) fn has_connector(&self, key: &Key) -> bool {
        self.connectors.contains_key(key)
    }
}
