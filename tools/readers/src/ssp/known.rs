//! The elements and attributes that SSP 1.0 has. One that it does not have is somebody's own, or misspelt.

use stickslip::document::nearest;

use super::SspProblem;
use crate::error::InputError;
use crate::xml::{Element, XmlFile};

/// What the namespaces of the standard begin with.
const STANDARD: &str = "http://ssp-standard.org/SSP1/";

// How they go on.
const DESCRIPTION: &str = "SystemStructureDescription";
const COMMON: &str = "SystemStructureCommon";
const VALUES: &str = "SystemStructureParameterValues";
const MAPPING: &str = "SystemStructureParameterMapping";

const TRANSFORMATIONS: [&str; 4] = [
    "LinearTransformation",
    "BooleanMappingTransformation",
    "IntegerMappingTransformation",
    "EnumerationMappingTransformation",
];
/// Types of connectors and parameters.
pub(super) const TYPES: [&str; 6] = ["Real", "Integer", "Boolean", "String", "Enumeration", "Binary"];

/// Attributes that any element may have.
const ALWAYS: [&str; 2] = ["id", "description"];
/// Those of a file as a whole.
const FILE: [&str; 7] =
    ["version", "author", "fileversion", "copyright", "license", "generationTool", "generationDateAndTime"];

/// An element: what may be in it, of which namespace that is, and its attributes.
type Known = (&'static str, &'static [&'static str], &'static str, &'static [&'static str]);

/// What is in elements that are not listed is not looked at. Besides: `Annotations`, transformations, types and the attributes
/// above.
const KNOWN: [Known; 41] = [
    (
        "SystemStructureDescription",
        &["System", "Enumerations", "Units", "DefaultExperiment"],
        DESCRIPTION,
        &["name"],
    ),
    (
        "System",
        &[
            "Connectors",
            "ElementGeometry",
            "ParameterBindings",
            "Elements",
            "Connections",
            "SignalDictionaries",
            "SystemGeometry",
            "GraphicalElements",
        ],
        DESCRIPTION,
        &["name"],
    ),
    ("Elements", &["Component", "System", "SignalDictionaryReference"], DESCRIPTION, &[]),
    (
        "Component",
        &["Connectors", "ElementGeometry", "ParameterBindings"],
        DESCRIPTION,
        &["name", "type", "source", "implementation"],
    ),
    (
        "SignalDictionaryReference",
        &["Connectors", "ElementGeometry", "ParameterBindings"],
        DESCRIPTION,
        &["name", "dictionary"],
    ),
    ("SignalDictionaries", &["SignalDictionary"], DESCRIPTION, &[]),
    ("Connectors", &["Connector"], DESCRIPTION, &[]),
    ("Connector", &["ConnectorGeometry"], DESCRIPTION, &["name", "kind"]),
    ("Connections", &["Connection"], DESCRIPTION, &[]),
    (
        "Connection",
        &["ConnectionGeometry"],
        DESCRIPTION,
        &["startElement", "startConnector", "endElement", "endConnector", "suppressUnitConversion"],
    ),
    ("ParameterBindings", &["ParameterBinding"], DESCRIPTION, &[]),
    (
        "ParameterBinding",
        &["ParameterValues", "ParameterMapping"],
        DESCRIPTION,
        &["type", "source", "sourceBase", "prefix"],
    ),
    ("ParameterValues", &["ParameterSet"], VALUES, &[]),
    ("ParameterSet", &["Parameters", "Enumerations", "Units"], VALUES, &["name"]),
    ("Parameters", &["Parameter"], VALUES, &[]),
    ("Parameter", &[], VALUES, &["name"]),
    // Inside of a binding, a mapping is in an element of the same name.
    ("ParameterMapping", &["ParameterMapping", "MappingEntry"], MAPPING, &["type", "source", "sourceBase"]),
    ("MappingEntry", &[], MAPPING, &["source", "target", "suppressUnitConversion"]),
    ("LinearTransformation", &[], COMMON, &["factor", "offset"]),
    ("BooleanMappingTransformation", &["MapEntry"], COMMON, &[]),
    ("IntegerMappingTransformation", &["MapEntry"], COMMON, &[]),
    ("EnumerationMappingTransformation", &["MapEntry"], COMMON, &[]),
    ("MapEntry", &[], COMMON, &["source", "target"]),
    ("Enumerations", &["Enumeration"], COMMON, &[]),
    // The type is called as the list.
    ("Enumeration", &["Item"], COMMON, &["name"]),
    ("Item", &[], COMMON, &["name", "value"]),
    ("Units", &["Unit"], COMMON, &[]),
    ("Unit", &["BaseUnit"], COMMON, &["name"]),
    ("BaseUnit", &[], COMMON, &["kg", "m", "s", "A", "K", "mol", "cd", "rad", "factor", "offset"]),
    ("Real", &[], COMMON, &["unit"]),
    ("Integer", &[], COMMON, &[]),
    ("Boolean", &[], COMMON, &[]),
    ("String", &[], COMMON, &[]),
    ("Binary", &[], COMMON, &["mime-type"]),
    ("DefaultExperiment", &[], DESCRIPTION, &["startTime", "stopTime"]),
    (
        "ElementGeometry",
        &[],
        DESCRIPTION,
        &[
            "x1",
            "y1",
            "x2",
            "y2",
            "rotation",
            "iconSource",
            "iconRotation",
            "iconFlip",
            "iconFixedAspectRatio",
        ],
    ),
    ("SystemGeometry", &[], DESCRIPTION, &["x1", "y1", "x2", "y2"]),
    ("GraphicalElements", &["Note"], DESCRIPTION, &[]),
    ("Note", &[], DESCRIPTION, &["x1", "y1", "x2", "y2", "text"]),
    ("ConnectorGeometry", &[], DESCRIPTION, &["x", "y"]),
    ("ConnectionGeometry", &[], DESCRIPTION, &["pointsX", "pointsY"]),
];

/// What may be in the element of this row.
fn children((element, own, ..): &Known) -> Vec<&'static str> {
    let more: &[&str] = match *element {
        "Connector" | "Parameter" => &TYPES,
        "Connection" | "MappingEntry" => &TRANSFORMATIONS,
        _ => &[],
    };
    own.iter().chain(more).copied().chain(["Annotations"]).collect()
}

/// The namespace of what is called `child` in the element of this row, if there is only one.
fn space((element, _, inside, _): &Known, child: &str) -> Option<String> {
    let common = TRANSFORMATIONS.contains(&child) || *element == "Connector" && TYPES.contains(&child);
    (child != "Annotations").then(|| format!("{STANDARD}{}", if common { COMMON } else { inside }))
}

/// The attributes of the element of this row in `parent`.
fn attributes((element, _, _, own): &Known, parent: Option<&str>) -> Vec<&'static str> {
    let more: &[&str] = match (parent, *element) {
        (Some("Parameter"), _) => &["value"],
        (_, "SystemStructureDescription" | "ParameterSet" | "ParameterMapping") => &FILE,
        _ => &[],
    };
    own.iter().chain(more).copied().chain(ALWAYS).collect()
}

/// Remarks on elements from elsewhere in a file with the root `element`.
///
/// # Errors
/// An element or an attribute that the standard does not have, without a namespace or in the standard's own; an element of
/// the standard in another namespace.
pub(super) fn check_known(
    file: &XmlFile,
    element: &Element,
    remarks: &mut Vec<String>,
) -> Result<(), InputError> {
    if let Some((_, _, own, _)) = row_of(element) {
        check_space(file, element, Some(format!("{STANDARD}{own}")))?;
    }
    check_in(None, file, element, remarks)
}

fn row_of(element: &Element) -> Option<&'static Known> {
    KNOWN.iter().find(|(name, ..)| *name == element.name())
}

fn check_in(
    parent: Option<&str>,
    file: &XmlFile,
    element: &Element,
    remarks: &mut Vec<String>,
) -> Result<(), InputError> {
    let Some(row) = row_of(element) else { return Ok(()) };
    check_attributes(file, element, &attributes(row, parent))?;
    let known = children(row);
    for child in element.children() {
        if known.contains(&child.name()) {
            check_space(file, child, space(row, child.name()))?;
            check_in(Some(element.name()), file, child, remarks)?;
        } else if is_standard(child.namespace()) {
            let meant = nearest(child.name(), &known);
            let (element, parent) = (child.to_string(), element.to_string());
            return Err(file.error(child, SspProblem::UnknownStandardElement { element, parent, meant }));
        } else {
            remarks.push(format!(
                "{}: the element {child} in {element} is not known; it is ignored",
                file.place(child)
            ));
        }
    }
    Ok(())
}

/// The standard's own, or none.
fn is_standard(namespace: Option<&str>) -> bool {
    namespace.is_none_or(|uri| uri.starts_with(STANDARD))
}

/// Its attributes have no namespace.
fn check_attributes(file: &XmlFile, element: &Element, known: &[&'static str]) -> Result<(), InputError> {
    let mut own = element.attributes().filter(|(_, namespace)| is_standard(*namespace));
    let Some((name, _)) = own.find(|(name, namespace)| namespace.is_some() || !known.contains(name)) else {
        return Ok(());
    };
    let (attribute, meant) = (name.to_owned(), nearest(name, known));
    Err(file.error(element, SspProblem::UnknownAttribute { attribute, element: element.to_string(), meant }))
}

fn check_space(file: &XmlFile, element: &Element, right: Option<String>) -> Result<(), InputError> {
    match (element.namespace(), right) {
        (Some(found), Some(right)) if *found != *right => {
            let (element_name, found) = (element.to_string(), found.to_owned());
            Err(file.error(element, SspProblem::Namespace { element: element_name, found, right }))
        }
        _ => Ok(()),
    }
}
