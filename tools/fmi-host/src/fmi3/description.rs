//! `modelDescription.xml` of FMI 3.0.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use stickslip::cosim::Causality;
use stickslip_readers::InputError;
use stickslip_readers::units::read_units;
use stickslip_readers::xml::{Element, XmlFile};

use super::Format;
use crate::description::{
    CoSimulation, FmiVersion, ModelDescription, Passed, ScalarVariable, TypeOfVariable, Variability,
    enumerated, experiment, items, repeated,
};
use crate::import::ImportProblem;
use crate::words::Words;

/// Elements of all arrays together, at most: each becomes a variable.
const MOST_ELEMENTS: usize = 1_000_000;

/// Declared dependencies of all outputs together, at most: a few words about arrays may mean any number.
const MOST_DEPENDENCIES: usize = 10_000_000;

/// Reads the description under `root`.
///
/// # Errors
/// [`ImportProblem::NoCoSimulation`], [`ImportProblem::Clocks`], and what is not as the standard says.
pub(crate) fn read(file: &XmlFile, root: &Element) -> Result<ModelDescription, ImportProblem> {
    let Some(element) = root.child("CoSimulation") else { return Err(ImportProblem::NoCoSimulation) };
    let mut rows = Rows {
        file,
        types: declared_types(file, root)?,
        sizes: BTreeMap::new(),
        words: Words::default(),
        variables: Vec::new(),
    };
    rows.structural_parameters(items(file, root))?;
    for element in items(file, root) {
        rows.variable(&element?)?;
    }
    let variables = rows.variables;
    check_names(file, root, &variables)?;
    Ok(ModelDescription {
        version: FmiVersion::Three,
        model_name: root.attribute("modelName").unwrap_or_default().to_owned(),
        guid: file.required(root, "instantiationToken")?.to_owned(),
        generation_tool: root.attribute("generationTool").map(str::to_owned),
        co_simulation: co_simulation(file, element)?,
        units: read_units(file, root.list("UnitDefinitions", "Unit"))?,
        log_categories: root
            .list("LogCategories", "Category")
            .filter_map(|category| category.attribute("name").map(str::to_owned))
            .collect(),
        experiment: experiment(file, root)?,
        dependencies: dependencies(file, root, &variables)?,
        variables,
    })
}

fn co_simulation(file: &XmlFile, element: &Element) -> Result<CoSimulation, InputError> {
    let flag = |name: &str| Ok::<bool, InputError>(file.boolean(element, name)?.unwrap_or(false));
    Ok(CoSimulation {
        model_identifier: file.required(element, "modelIdentifier")?.to_owned(),
        needs_execution_tool: flag("needsExecutionTool")?,
        variable_step: flag("canHandleVariableCommunicationStepSize")?,
        interpolates_inputs: false,
        output_derivative_order: file.number(element, "maxOutputDerivativeOrder")?.unwrap_or(0),
        once_per_process: flag("canBeInstantiatedOnlyOncePerProcess")?,
        saves_state: flag("canGetAndSetFMUState")?,
        serializes_state: flag("canSerializeFMUState")?,
        directional_derivatives: flag("providesDirectionalDerivatives")?,
        intermediate_update: flag("providesIntermediateUpdate")?,
    })
}

/// What declared types hold for the variables that refer to them.
#[derive(Debug, Default, Clone)]
struct DeclaredType {
    unit: Option<Arc<str>>,
    items: Arc<[(String, i32)]>,
}

fn declared_types(file: &XmlFile, root: &Element) -> Result<BTreeMap<String, DeclaredType>, InputError> {
    let mut types = BTreeMap::new();
    for element in root.all("TypeDefinitions").flat_map(|list| list.children()) {
        let declared = DeclaredType {
            unit: element.attribute("unit").map(Arc::from),
            items: enumerated(file, element.all("Item"))?,
        };
        types.insert(file.required(element, "name")?.to_owned(), declared);
    }
    Ok(types)
}

/// The variables read so far.
struct Rows<'a> {
    file: &'a XmlFile,
    types: BTreeMap<String, DeclaredType>,
    /// Values of structural parameters, which sizes refer to, by their value references.
    sizes: BTreeMap<u32, u32>,
    words: Words,
    variables: Vec<ScalarVariable>,
}

impl Rows<'_> {
    fn structural_parameters(
        &mut self,
        elements: impl Iterator<Item = Result<Element, InputError>>,
    ) -> Result<(), ImportProblem> {
        for element in elements {
            let element = element?;
            if element.attribute("causality") != Some("structuralParameter") {
                continue;
            }
            self.file.required(&element, "valueReference")?;
            let reference = self.file.number(&element, "valueReference")?.unwrap_or_default();
            if let Some(size) = self.file.number::<u32>(&element, "start")? {
                self.sizes.insert(reference, size);
            }
        }
        Ok(())
    }

    /// Lengths in all directions; none of a variable that is no array.
    fn dimensions(&self, element: &Element) -> Result<Vec<u32>, InputError> {
        let expected = "a length, or the value reference of a structural parameter";
        let lengths = element.all("Dimension").map(|dimension| {
            if let Some(start) = self.file.number::<u32>(dimension, "start")? {
                return Ok(start);
            }
            let reference: Option<u32> = self.file.number(dimension, "valueReference")?;
            let size = reference.and_then(|reference| self.sizes.get(&reference)).copied();
            size.ok_or_else(|| self.file.value_error(dimension, "valueReference", expected))
        });
        lengths.collect()
    }

    fn variable(&mut self, element: &Element) -> Result<(), ImportProblem> {
        let name = self.file.required(element, "name")?;
        let format = match (element.name(), Format::of_element(element.name())) {
            ("Clock", _) => return Err(ImportProblem::Clocks(name.to_owned())),
            ("String" | "Binary", _) => Format::default(),
            (_, Some(format)) => format,
            // Annotations and what later versions add.
            _ => return Ok(()),
        };
        let lengths = self.dimensions(element)?;
        let size = lengths.iter().try_fold(1_u32, |size, length| size.checked_mul(*length));
        let size = size.filter(|size| self.variables.len() + *size as usize <= MOST_ELEMENTS);
        let Some(size) = size else {
            return Err(self
                .file
                .value_error(element, "name", "an array of a length that fits in memory")
                .into());
        };
        let row = self.row(element, format, size)?;
        let starts: Vec<&str> = match element.name() {
            "String" => element.all("Start").filter_map(|start| start.attribute("value")).collect(),
            _ => element.attribute("start").unwrap_or_default().split_whitespace().collect(),
        };
        for place in 0..size {
            // One value may stand for all of an array.
            let start = starts.get(place as usize).or_else(|| starts.first().filter(|_| starts.len() == 1));
            self.variables.push(ScalarVariable {
                name: if lengths.is_empty() {
                    name.into()
                } else {
                    element_name(name, &lengths, place).into()
                },
                start: start.map(|start| self.words.shared(start)),
                passed: Passed { element: place, ..row.passed },
                ..row.clone()
            });
        }
        for alias in element.all("Alias").filter(|_| lengths.is_empty()) {
            let name = Arc::from(self.file.required(alias, "name")?);
            let start = starts.first().map(|start| self.words.shared(start));
            // The variable itself is recorded.
            let causality = if row.causality == Causality::Output { Causality::Local } else { row.causality };
            self.variables.push(ScalarVariable { name, start, causality, ..row.clone() });
        }
        Ok(())
    }

    /// All of a variable but names and starts.
    fn row(&mut self, element: &Element, format: Format, size: u32) -> Result<ScalarVariable, InputError> {
        let file = self.file;
        file.required(element, "valueReference")?;
        let causality = match element.attribute("causality") {
            Some("parameter") => Causality::Parameter,
            Some("input") => Causality::Input,
            Some("output") => Causality::Output,
            None | Some("local" | "calculatedParameter" | "independent" | "structuralParameter") => {
                Causality::Local
            }
            Some(_) => return Err(file.value_error(element, "causality", "a causality of FMI 3.0")),
        };
        let floating = matches!(element.name(), "Float64" | "Float32");
        let variability = match element.attribute("variability") {
            Some("constant") => Variability::Constant,
            Some("fixed") => Variability::Fixed,
            Some("tunable") => Variability::Tunable,
            Some("discrete") => Variability::Discrete,
            Some("continuous") => Variability::Continuous,
            None if causality == Causality::Parameter => Variability::Fixed,
            None if floating => Variability::Continuous,
            None => Variability::Discrete,
            Some(_) => return Err(file.value_error(element, "variability", "a variability of FMI 3.0")),
        };
        let declared = element.attribute("declaredType").and_then(|name| self.types.get(name));
        let declared = declared.cloned().unwrap_or_default();
        let kind = match element.name() {
            "Float64" | "Float32" => TypeOfVariable::Real,
            "Boolean" => TypeOfVariable::Boolean,
            "String" if size == 1 => TypeOfVariable::String,
            "String" | "Binary" => TypeOfVariable::Opaque,
            "Enumeration" => TypeOfVariable::Enumeration(declared.items),
            _ => TypeOfVariable::Integer,
        };
        Ok(ScalarVariable {
            name: Arc::default(),
            reference: file.number(element, "valueReference")?.unwrap_or_default(),
            causality,
            variability,
            kind,
            passed: Passed {
                format,
                element: 0,
                size,
                intermediate: file.boolean(element, "intermediateUpdate")?.unwrap_or(false),
            },
            unit: element.attribute("unit").map(|unit| self.words.shared(unit)).or(declared.unit),
            start: None,
        })
    }
}

/// `name[2,1]` of the element at `place`, the last index running fastest, all from 1.
fn element_name(name: &str, lengths: &[u32], mut place: u32) -> String {
    let mut indices = Vec::new();
    for length in lengths.iter().rev() {
        indices.push((place % length + 1).to_string());
        place /= length;
    }
    indices.reverse();
    format!("{name}[{}]", indices.join(","))
}

fn check_names(file: &XmlFile, root: &Element, variables: &[ScalarVariable]) -> Result<(), ImportProblem> {
    let Some(twice) = repeated(variables) else { return Ok(()) };
    let twice = &*variables[twice].name;
    let bare = twice.split('[').next().unwrap_or_default();
    let named =
        |element: &Element| element.attribute("name").is_some_and(|name| twice == name || bare == name);
    let mut last = None;
    for element in items(file, root) {
        last = Some(element?).filter(named).or(last);
    }
    let place = last.as_ref().unwrap_or(root);
    Err(file.value_error(place, "name", "a name that no other variable has").into())
}

/// On which `variables` outputs depend. A value reference may be that of an array, or have aliases.
fn dependencies(
    file: &XmlFile,
    root: &Element,
    variables: &[ScalarVariable],
) -> Result<BTreeMap<usize, Arc<[usize]>>, InputError> {
    let places = mentioned(root, variables);
    let (mut found, mut count) = (BTreeMap::new(), 0);
    let expected = "value references of variables";
    for unknown in root.list("ModelStructure", "Output") {
        file.required(unknown, "valueReference")?;
        let reference: u32 = file.number(unknown, "valueReference")?.unwrap_or_default();
        let Some(own) = places.get(&reference) else {
            return Err(file.value_error(unknown, "valueReference", expected));
        };
        let Some(text) = unknown.attribute("dependencies") else { continue };
        let mut references = BTreeSet::new();
        for word in text.split_whitespace() {
            match word.parse().ok().filter(|reference| places.contains_key(reference)) {
                Some(known) => references.insert(known),
                None => return Err(file.value_error(unknown, "dependencies", expected)),
            };
        }
        let of = |reference| places.get(reference).map_or(&[][..], Vec::as_slice);
        count += references.iter().map(|reference| of(reference).len()).sum::<usize>();
        if count > MOST_DEPENDENCIES {
            return Err(file.value_error(unknown, "dependencies", "as many as fit in memory"));
        }
        let on: Arc<[usize]> = references.iter().flat_map(of).copied().collect();
        found.extend(own.iter().map(|place| (*place, Arc::clone(&on))));
    }
    Ok(found)
}

/// The positions of what the outputs' declarations mention, by value references.
fn mentioned(root: &Element, variables: &[ScalarVariable]) -> BTreeMap<u32, Vec<usize>> {
    let words = |unknown: &Element| {
        let told = ["valueReference", "dependencies"].map(|name| unknown.attribute(name).unwrap_or_default());
        told.join(" ").split_whitespace().filter_map(|word| word.parse().ok()).collect::<Vec<u32>>()
    };
    let mut places: BTreeMap<u32, Vec<usize>> = BTreeMap::new();
    for reference in root.list("ModelStructure", "Output").flat_map(words) {
        places.entry(reference).or_default();
    }
    for (place, variable) in variables.iter().enumerate() {
        if let Some(known) = places.get_mut(&variable.reference) {
            known.push(place);
        }
    }
    places.retain(|_, known| !known.is_empty());
    places
}
