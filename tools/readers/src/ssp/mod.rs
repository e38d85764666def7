//! System structures of SSP 1.0: which FMUs make a system, how they are connected, what their parameters are.
//!
//! [`read`] takes an `.ssp` package or a bare `.ssd` file. Nested systems are flattened: the component `beam` in the
//! system `rig` is called `rig.beam`, and a chain of connections through the systems' connectors becomes one
//! [`Route`]. [`Outline::package`] writes a package.

mod flatten;
mod known;
mod outline;
mod parameters;
mod parse;
mod problem;
mod route;

use std::path::{Path, PathBuf};

pub use outline::{Outline, OutlineComponent, OutlineConnection, OutlineConnector, OutlineParameter};
pub use problem::SspProblem;
pub use route::Route;

use crate::archive::{self, Limits, Unpacked};
use crate::error::{InputError, Problem};
use crate::units::{Linear, Unit};
use crate::xml::XmlFile;

/// A system of FMUs.
#[derive(Debug)]
pub struct SystemStructure {
    /// Its name.
    pub name: String,
    /// The FMUs.
    pub components: Vec<Component>,
    /// What leads from outputs to inputs.
    pub connections: Vec<Connection>,
    /// Inputs of the system as a whole.
    pub inputs: Vec<SystemInput>,
    /// Outputs of the system as a whole.
    pub outputs: Vec<SystemOutput>,
    /// Values to set before the initialization; where two set one variable, the later one holds.
    pub parameters: Vec<Parameter>,
    /// Start (s), where the file proposes one.
    pub start: Option<f64>,
    /// Stop (s), where the file proposes one.
    pub stop: Option<f64>,
    /// What the user should know: elements that were ignored, parameters that belong to nothing.
    pub remarks: Vec<String>,
    /// Keeps the unpacked files.
    _folder: Option<Unpacked>,
}

impl SystemStructure {
    /// A system called `name` that is the FMU at `file` and nothing else.
    pub fn single(name: &str, file: &Path) -> Self {
        let source = file.display().to_string();
        let place = source.clone();
        let (name, file, units, types) = (name.to_owned(), file.to_owned(), Vec::new(), Vec::new());
        let component = Component { name: name.clone(), file, source, units, types, place };
        Self {
            name,
            components: vec![component],
            connections: Vec::new(),
            inputs: Vec::new(),
            outputs: Vec::new(),
            parameters: Vec::new(),
            start: None,
            stop: None,
            remarks: Vec::new(),
            _folder: None,
        }
    }
}

/// An FMU in the system.
#[derive(Debug, Clone, PartialEq)]
pub struct Component {
    /// Its name, with those of the systems around it: `rig.beam`.
    pub name: String,
    /// The file.
    pub file: PathBuf,
    /// The file as the description names it.
    pub source: String,
    /// Connectors with the units they declare.
    pub units: Vec<(String, Unit)>,
    /// Connectors with the types they declare.
    pub types: Vec<DeclaredType>,
    /// `file:line` where it is described.
    pub place: String,
}

/// The type that a connector of a component declares.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DeclaredType {
    /// Name of the connector, which is the name of a variable of the FMU.
    pub variable: String,
    /// `Real`, `Integer`, `Boolean`, `String`, `Enumeration` or `Binary`.
    pub name: &'static str,
    /// `file:line` where it is declared.
    pub place: String,
}

/// A connector of a component.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct End {
    /// Position of the component.
    pub component: usize,
    /// Name of the connector, which is the name of a variable of the FMU.
    pub variable: String,
}

/// From an output to an input.
#[derive(Debug, Clone, PartialEq)]
pub struct Connection {
    /// The output.
    pub from: End,
    /// The input.
    pub to: End,
    /// What happens to the value.
    pub route: Route,
    /// `file:line` where it is described.
    pub place: String,
}

/// An input of the system.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemInput {
    /// Its name.
    pub name: String,
    /// The inputs of components it leads to.
    pub targets: Vec<(End, Route)>,
}

/// An output of the system.
#[derive(Debug, Clone, PartialEq)]
pub struct SystemOutput {
    /// Its name.
    pub name: String,
    /// Where its value comes from.
    pub from: End,
    /// What happens to the value.
    pub route: Route,
}

/// A value to be set.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Which variable.
    pub target: End,
    /// Its value.
    pub value: Value,
    /// The unit of a Real where the file declares it and asks for its conversion.
    pub unit: Option<Unit>,
    /// What happens to a number after its unit is converted.
    pub transformation: Linear,
    /// `file:line` where it is given.
    pub place: String,
}

/// A value of a parameter.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    /// Real.
    Real(f64),
    /// Integer, or an item of an enumeration.
    Integer(i32),
    /// Boolean.
    Boolean(bool),
    /// String.
    Text(String),
}

/// The unit called `name`: one of the file's `units`, one that engineers call so, or, where the file defines no units at
/// all, its name alone, which an FMU may define.
fn unit_called(name: &str, units: &[Unit]) -> Result<Unit, SspProblem> {
    match units.iter().find(|unit| unit.name == name) {
        Some(unit) => Ok(unit.clone()),
        None if units.is_empty() => Ok(Unit::named(name)),
        None => Unit::common(name).ok_or_else(|| SspProblem::UnknownUnit(name.to_owned())),
    }
}

/// Name of the description inside a package.
const STRUCTURE: &str = "SystemStructure.ssd";

/// Reads the package (`.ssp`) or description (`.ssd`) at `path`. Files it names are looked up beside the description;
/// a package's must be inside it.
///
/// # Errors
/// Archives and files that are damaged or not SSP 1.x, and [`SspProblem`].
pub fn read(path: impl AsRef<Path>) -> Result<SystemStructure, InputError> {
    let path = path.as_ref();
    let whole =
        |problem: Problem| InputError { path: path.to_owned(), excerpt: None, problem: Box::new(problem) };
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("ssd")) {
        let file = XmlFile::read(path)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        return parse::structure(
            &file,
            &parse::Files { folder, named: path.to_owned(), closed: false },
            None,
        );
    }
    let unpacked = archive::unpack(path, Limits::default()).map_err(|problem| whole(problem.into()))?;
    let inner = unpacked.path().join(STRUCTURE);
    if !inner.is_file() {
        return Err(whole(SspProblem::NoStructure.into()));
    }
    let bytes = std::fs::read(&inner).map_err(|error| {
        whole(Problem::Unreadable { what: STRUCTURE.to_owned(), reason: error.to_string() })
    })?;
    let file = XmlFile::from_bytes(&path.join(STRUCTURE), bytes)?;
    let files =
        parse::Files { folder: unpacked.path().to_owned(), named: path.join(STRUCTURE), closed: true };
    parse::structure(&file, &files, Some(unpacked))
}
