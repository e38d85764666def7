//! The elements that SSP has. One that it does not have is somebody's own, or misspelt.

use stickslip::document::nearest;

use super::SspProblem;
use crate::error::InputError;
use crate::xml::{Element, XmlFile};

/// What the namespaces of the standard begin with.
const STANDARD: &str = "http://ssp-standard.org/SSP1/";

const TRANSFORMATIONS: [&str; 4] = [
    "LinearTransformation",
    "BooleanMappingTransformation",
    "IntegerMappingTransformation",
    "EnumerationMappingTransformation",
];
const TYPES: [&str; 6] = ["Real", "Integer", "Boolean", "String", "Enumeration", "Binary"];

/// The elements of a description, by the element they are in. What is in others is not looked at.
const KNOWN: [(&str, &[&str]); 15] = [
    ("SystemStructureDescription", &["System", "Enumerations", "Units", "DefaultExperiment"]),
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
    ),
    ("Elements", &["Component", "System", "SignalDictionaryReference"]),
    ("Component", &["Connectors", "ElementGeometry", "ParameterBindings"]),
    ("Connectors", &["Connector"]),
    ("Connector", &["ConnectorGeometry"]),
    ("Connections", &["Connection"]),
    ("Connection", &["ConnectionGeometry"]),
    ("ParameterBindings", &["ParameterBinding"]),
    ("ParameterBinding", &["ParameterValues", "ParameterMapping"]),
    ("ParameterValues", &["ParameterSet"]),
    ("ParameterSet", &["Parameters", "Enumerations", "Units"]),
    ("Parameters", &["Parameter"]),
    ("Parameter", &[]),
    // Inside of a binding, a mapping is in an element of the same name.
    ("ParameterMapping", &["ParameterMapping", "MappingEntry"]),
];

/// What may be in `element`; none where that is not looked at.
fn known(element: &str) -> Option<Vec<&'static str>> {
    let (_, own) = KNOWN.iter().find(|(name, _)| *name == element)?;
    let more: &[&str] = match element {
        "Connector" | "Parameter" => &TYPES,
        "Connection" => &TRANSFORMATIONS,
        _ => &[],
    };
    Some(own.iter().chain(more).copied().chain(["Annotations"]).collect())
}

/// Remarks on elements from elsewhere.
///
/// # Errors
/// An element that the standard does not have, without a namespace or in the standard's own.
pub(super) fn check_known(
    file: &XmlFile,
    element: &Element,
    remarks: &mut Vec<String>,
) -> Result<(), InputError> {
    let Some(known) = known(element.name()) else { return Ok(()) };
    for child in element.children() {
        if known.contains(&child.name()) {
            check_known(file, child, remarks)?;
        } else if child.namespace().is_none_or(|uri| uri.starts_with(STANDARD)) {
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
