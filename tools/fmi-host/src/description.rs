//! `modelDescription.xml`: that of FMI 2.0 is read here, that of 3.0 in [`crate::fmi3`].

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use stickslip::cosim::Causality;
use stickslip_readers::InputError;
use stickslip_readers::units::{Unit, read_units};
use stickslip_readers::xml::{Element, XmlFile};

use crate::fmi3::Format;
use crate::import::ImportProblem;
use crate::log::NO_LETTER;
use crate::words::Words;

/// Versions of FMI.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FmiVersion {
    /// FMI 2.0.
    Two,
    /// FMI 3.0.
    Three,
}

/// What an FMU says of itself.
#[derive(Debug, Clone, PartialEq)]
pub struct ModelDescription {
    /// Version of FMI.
    pub version: FmiVersion,
    /// Name of the model.
    pub model_name: String,
    /// By which library and description know each other: GUID or instantiation token.
    pub guid: String,
    /// What wrote it.
    pub generation_tool: Option<String>,
    /// What it can do.
    pub co_simulation: CoSimulation,
    /// Its units.
    pub units: Vec<Unit>,
    /// Categories of its messages.
    pub log_categories: Vec<String>,
    /// The experiment it proposes.
    pub experiment: Experiment,
    /// Its variables, in the order of the file.
    pub variables: Vec<ScalarVariable>,
    /// On which variables outputs depend, all by their positions. An output that is not here has not declared it, which
    /// means on all.
    pub dependencies: BTreeMap<usize, Arc<[usize]>>,
}

/// Abilities in co-simulation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CoSimulation {
    /// Name of the library.
    pub model_identifier: String,
    /// Another program must be there.
    pub needs_execution_tool: bool,
    /// Steps of different lengths.
    pub variable_step: bool,
    /// Derivatives of inputs.
    pub interpolates_inputs: bool,
    /// Order of derivatives of outputs.
    pub output_derivative_order: u32,
    /// There can be one instance in a process.
    pub once_per_process: bool,
    /// States can be saved and set.
    pub saves_state: bool,
    /// Saved states can become bytes.
    pub serializes_state: bool,
    /// Directional derivatives.
    pub directional_derivatives: bool,
    /// It asks for inputs within steps (FMI 3.0).
    pub intermediate_update: bool,
}

/// What an FMU proposes; each part may be absent.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Experiment {
    /// Start (s).
    pub start: Option<f64>,
    /// Stop (s).
    pub stop: Option<f64>,
    /// Relative tolerance.
    pub tolerance: Option<f64>,
    /// Communication step (s).
    pub step: Option<f64>,
}

/// How a variable is passed to the functions.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Passed {
    /// Its type in C.
    pub format: Format,
    /// Its place in the array that has its value reference, and the length of that: 0 and 1 of a variable that is none.
    pub element: u32,
    /// See above.
    pub size: u32,
    /// It may be set within steps.
    pub intermediate: bool,
}

/// A variable; of an array, one of its elements. There may be a million of them: equal texts are kept once.
#[derive(Debug, Clone, PartialEq)]
pub struct ScalarVariable {
    /// Its name.
    pub name: Arc<str>,
    /// Its value reference.
    pub reference: u32,
    /// Who sets it; what is neither parameter, input nor output is local here.
    pub causality: Causality,
    /// When it changes.
    pub variability: Variability,
    /// Its type.
    pub kind: TypeOfVariable,
    /// How it is passed.
    pub passed: Passed,
    /// Name of its unit.
    pub unit: Option<Arc<str>>,
    /// Its value unless set, as it is written.
    pub start: Option<Arc<str>>,
}

/// When a variable changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Variability {
    /// Never.
    Constant,
    /// Not after the initialization.
    Fixed,
    /// When somebody sets it.
    Tunable,
    /// At events.
    Discrete,
    /// Always.
    Continuous,
}

/// Type of a variable.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum TypeOfVariable {
    /// A floating point number.
    Real,
    /// A whole number.
    Integer,
    /// True or false.
    Boolean,
    /// A text.
    String,
    /// What the master has no use for: binary data.
    Opaque,
    /// One of these items, each with its number.
    Enumeration(Arc<[(String, i32)]>),
}

/// What declared types hold for the variables that refer to them.
#[derive(Debug, Default, Clone)]
struct DeclaredType {
    unit: Option<Arc<str>>,
    items: Arc<[(String, i32)]>,
}

impl ModelDescription {
    /// Reads the description in the file at `path`, never as a whole: it may hold millions of variables.
    ///
    /// # Errors
    /// [`ImportProblem::Version`], [`ImportProblem::NoCoSimulation`], and what is not as the standard says.
    pub fn read(path: &Path) -> Result<Self, ImportProblem> {
        let file = &XmlFile::read_but(VARIABLES, path, Path::new("modelDescription.xml"))?;
        let root = file.root("fmiModelDescription")?;
        let version = file.required(root, "fmiVersion")?;
        if version == "3" || version.starts_with("3.0") {
            return crate::fmi3::read(file, root);
        }
        if !version.starts_with("2.") {
            return Err(ImportProblem::Version(version.to_owned()));
        }
        let Some(element) = root.child("CoSimulation") else { return Err(ImportProblem::NoCoSimulation) };
        let declared = declared_types(file, root)?;
        let mut words = Words::default();
        let rows = || {
            items(file, root).filter(|row| row.as_ref().map_or(true, |row| row.name() == "ScalarVariable"))
        };
        let variables = rows()
            .map(|row| scalar_variable(file, &row?, &declared, &mut words))
            .collect::<Result<Vec<_>, _>>()?;
        if let Some(twice) = repeated(&variables) {
            let element = rows().nth(twice).transpose()?;
            let element = element.as_ref().unwrap_or(root);
            return Err(file.value_error(element, "name", "a name that no other variable has").into());
        }
        Ok(Self {
            version: FmiVersion::Two,
            model_name: root.attribute("modelName").unwrap_or_default().to_owned(),
            guid: file.required(root, "guid")?.to_owned(),
            generation_tool: root.attribute("generationTool").map(str::to_owned),
            co_simulation: co_simulation(file, element)?,
            units: read_units(file, root.list("UnitDefinitions", "Unit"))?,
            log_categories: root
                .list("LogCategories", "Category")
                .filter_map(|category| category.attribute("name").map(str::to_owned))
                .collect(),
            experiment: experiment(file, root)?,
            dependencies: dependencies(file, root, variables.len())?,
            variables,
        })
    }

    /// The position of the variable `name`.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.variables.iter().position(|variable| *variable.name == *name)
    }

    /// The name of the variable of a value reference whose type has a letter in messages: of several the last.
    pub(crate) fn named(&self, letter: u8, reference: u32) -> Option<&str> {
        let own = |variable: &ScalarVariable| match variable.kind {
            _ if self.version == FmiVersion::Three => NO_LETTER,
            TypeOfVariable::Real => b'r',
            TypeOfVariable::Integer | TypeOfVariable::Enumeration(_) => b'i',
            TypeOfVariable::Boolean => b'b',
            TypeOfVariable::String | TypeOfVariable::Opaque => b's',
        };
        let mut rows = self.variables.iter().rev();
        let found = rows.find(|variable| variable.reference == reference && own(variable) == letter);
        found.map(|variable| &*variable.name)
    }

    /// The unit of a variable: only its name where the FMU does not define it.
    pub fn unit(&self, variable: &ScalarVariable) -> Option<Unit> {
        let name = variable.unit.as_ref()?;
        let defined = self.units.iter().find(|unit| unit.name == **name);
        Some(defined.cloned().unwrap_or_else(|| Unit::named(name)))
    }
}

/// The list of variables, which may be long: its items are read one by one.
const VARIABLES: &str = "ModelVariables";

/// The elements of the variables.
pub(crate) fn items<'f>(
    file: &'f XmlFile,
    root: &'f Element,
) -> impl Iterator<Item = Result<Element, InputError>> + 'f {
    root.all(VARIABLES).flat_map(|list| file.items(list))
}

fn co_simulation(file: &XmlFile, element: &Element) -> Result<CoSimulation, InputError> {
    let flag = |name: &str| Ok::<bool, InputError>(file.boolean(element, name)?.unwrap_or(false));
    Ok(CoSimulation {
        model_identifier: file.required(element, "modelIdentifier")?.to_owned(),
        needs_execution_tool: flag("needsExecutionTool")?,
        variable_step: flag("canHandleVariableCommunicationStepSize")?,
        interpolates_inputs: flag("canInterpolateInputs")?,
        output_derivative_order: file.number(element, "maxOutputDerivativeOrder")?.unwrap_or(0),
        once_per_process: flag("canBeInstantiatedOnlyOncePerProcess")?,
        saves_state: flag("canGetAndSetFMUstate")?,
        serializes_state: flag("canSerializeFMUstate")?,
        directional_derivatives: flag("providesDirectionalDerivative")?,
        intermediate_update: false,
    })
}

pub(crate) fn experiment(file: &XmlFile, root: &Element) -> Result<Experiment, InputError> {
    let Some(element) = root.child("DefaultExperiment") else { return Ok(Experiment::default()) };
    Ok(Experiment {
        start: file.number(element, "startTime")?,
        stop: file.number(element, "stopTime")?,
        tolerance: file.number(element, "tolerance")?,
        step: file.number(element, "stepSize")?,
    })
}

fn declared_types(file: &XmlFile, root: &Element) -> Result<BTreeMap<String, DeclaredType>, InputError> {
    let mut types = BTreeMap::new();
    for element in root.list("TypeDefinitions", "SimpleType") {
        let real = element.child("Real");
        let declared = DeclaredType {
            unit: real.and_then(|real| real.attribute("unit")).map(Arc::from),
            items: enumerated(file, element.list("Enumeration", "Item"))?,
        };
        types.insert(file.required(element, "name")?.to_owned(), declared);
    }
    Ok(types)
}

/// The items of an enumeration, each with its number.
pub(crate) fn enumerated<'e>(
    file: &XmlFile,
    items: impl Iterator<Item = &'e Element>,
) -> Result<Arc<[(String, i32)]>, InputError> {
    let item = |item: &'e Element| {
        let value = file.number(item, "value")?.unwrap_or_default();
        Ok((file.required(item, "name")?.to_owned(), value))
    };
    items.map(item).collect()
}

fn scalar_variable(
    file: &XmlFile,
    element: &Element,
    declared: &BTreeMap<String, DeclaredType>,
    words: &mut Words,
) -> Result<ScalarVariable, InputError> {
    let name = Arc::from(file.required(element, "name")?);
    file.required(element, "valueReference")?;
    let causality = match element.attribute("causality") {
        Some("parameter") => Causality::Parameter,
        Some("input") => Causality::Input,
        Some("output") => Causality::Output,
        None | Some("local" | "calculatedParameter" | "independent") => Causality::Local,
        Some(_) => return Err(file.value_error(element, "causality", "a causality of FMI 2.0")),
    };
    let variability = match element.attribute("variability") {
        Some("constant") => Variability::Constant,
        Some("fixed") => Variability::Fixed,
        Some("tunable") => Variability::Tunable,
        Some("discrete") => Variability::Discrete,
        None | Some("continuous") => Variability::Continuous,
        Some(_) => return Err(file.value_error(element, "variability", "a variability of FMI 2.0")),
    };
    let types = ["Real", "Integer", "Boolean", "String", "Enumeration"];
    let typed = element.children().iter().find(|child| types.contains(&child.name()));
    let Some(typed) = typed else {
        return Err(file.value_error(element, "name", "a variable with a type"));
    };
    let own =
        typed.attribute("declaredType").and_then(|name| declared.get(name)).cloned().unwrap_or_default();
    Ok(ScalarVariable {
        name,
        reference: file.number(element, "valueReference")?.unwrap_or_default(),
        causality,
        variability,
        kind: match typed.name() {
            "Real" => TypeOfVariable::Real,
            "Integer" => TypeOfVariable::Integer,
            "Boolean" => TypeOfVariable::Boolean,
            "String" => TypeOfVariable::String,
            _ => TypeOfVariable::Enumeration(own.items),
        },
        passed: Passed { format: Format::Float64, element: 0, size: 1, intermediate: false },
        unit: typed.attribute("unit").map(|unit| words.shared(unit)).or(own.unit),
        start: typed.attribute("start").map(|start| words.shared(start)),
    })
}

/// The position of the first of `variables` whose name one before it has.
pub(crate) fn repeated(variables: &[ScalarVariable]) -> Option<usize> {
    let mut order: Vec<usize> = (0..variables.len()).collect();
    let name = |position: usize| &*variables[position].name;
    order.sort_unstable_by(|a, b| name(*a).cmp(name(*b)).then(a.cmp(b)));
    order.windows(2).filter(|pair| name(pair[0]) == name(pair[1])).map(|pair| pair[1]).min()
}

/// On which of `count` variables outputs depend.
fn dependencies(
    file: &XmlFile,
    root: &Element,
    count: usize,
) -> Result<BTreeMap<usize, Arc<[usize]>>, InputError> {
    let mut found = BTreeMap::new();
    let expected = "numbers of variables, from 1";
    for unknown in root.all("ModelStructure").flat_map(|structure| structure.list("Outputs", "Unknown")) {
        file.required(unknown, "index")?;
        let index: u32 = file.number(unknown, "index")?.unwrap_or_default();
        let position = (index as usize).checked_sub(1).filter(|position| *position < count);
        let Some(position) = position else { return Err(file.value_error(unknown, "index", expected)) };
        let Some(text) = unknown.attribute("dependencies") else { continue };
        let mut on = Vec::new();
        for word in text.split_whitespace() {
            let number: Option<usize> = word.parse().ok();
            match number.and_then(|number| number.checked_sub(1)) {
                Some(other) if other < count => on.push(other),
                _ => return Err(file.value_error(unknown, "dependencies", expected)),
            }
        }
        found.insert(position, on.into());
    }
    Ok(found)
}
