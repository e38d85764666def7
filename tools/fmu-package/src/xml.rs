//! `modelDescription.xml` from the variable table.

use quick_xml::events::{BytesDecl, BytesEnd, BytesStart, Event};
use quick_xml::writer::Writer;
use stickslip::fmi::{
    Causality, DERIVATIVE_ORDER, Dependency, DependencyKind, Description, Initial, Variability, Variable,
    VariableType,
};

use crate::Stamp;
use crate::units::{Type, display_unit, display_units, type_of};

/// The base units that occur.
pub(crate) const BASES: [&str; 4] = ["kg", "m", "s", "rad"];

/// Exponents of [`BASES`].
pub(crate) type Exponents = [i8; 4];

/// Those of a unit of the vocabulary.
pub(crate) fn exponents(unit: &str) -> Option<Exponents> {
    UNITS.iter().find(|(name, _)| *name == unit).map(|(_, exponents)| *exponents)
}

/// Unit names of the project's vocabulary. All are SI without prefixes: factor 1, offset 0.
pub(crate) const UNITS: [(&str, Exponents); 21] = [
    ("1", [0, 0, 0, 0]),
    ("1/m", [0, -1, 0, 0]),
    ("1/s", [0, 0, -1, 0]),
    ("Hz", [0, 0, -1, 0]),
    ("J", [1, 2, -2, 0]),
    ("N", [1, 1, -2, 0]),
    ("N.m/rad", [1, 2, -2, -1]),
    ("N/m", [1, 0, -2, 0]),
    ("N/m^3", [1, -2, -2, 0]),
    ("N.s/m", [1, 0, -1, 0]),
    ("N.s^2/m^2", [1, -1, 0, 0]),
    ("Pa", [1, -1, -2, 0]),
    ("kg", [1, 0, 0, 0]),
    ("kg.m^2", [1, 2, 0, 0]),
    ("kg/m^3", [1, -3, 0, 0]),
    ("m", [0, 1, 0, 0]),
    ("m/s", [0, 1, -1, 0]),
    ("m/s^2", [0, 1, -2, 0]),
    ("rad", [0, 0, 0, 1]),
    ("s", [0, 0, 1, 0]),
    ("s/m", [0, -1, 1, 0]),
];

/// Log categories with what they hold.
pub(crate) const LOG_CATEGORIES: [(&str, &str); 6] = [
    ("logAll", "All messages"),
    ("logEvents", "Creation, initialization, reset and end of the instance"),
    ("logStatusDiscard", "Why a call returned fmi2Discard: a step that could not be computed"),
    ("logStatusError", "Why a call returned fmi2Error; the message names the variable"),
    ("logStatusFatal", "Why a call returned fmi2Fatal"),
    ("logStatusWarning", "Why a call returned fmi2Warning"),
];

pub(crate) type Element<'a> = (&'a str, Vec<(&'a str, String)>);

/// The XML of `description` for an FMU called `model_identifier`, with the usual author and date.
pub fn model_description_xml(model_identifier: &str, description: &Description) -> String {
    stamped_xml(model_identifier, description, &Stamp::default())
}

/// The same with the author and date of `stamp`.
pub(crate) fn stamped_xml(model_identifier: &str, description: &Description, stamp: &Stamp) -> String {
    let mut xml = Xml::new();
    let root = vec![
        ("fmiVersion", "2.0".to_owned()),
        ("modelName", description.name.to_owned()),
        ("guid", format!("{{{}}}", description.guid())),
        ("description", description.summary.to_owned()),
        ("author", stamp.author.clone()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("license", "MIT OR Apache-2.0".to_owned()),
        ("generationTool", concat!("stickslip ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("generationDateAndTime", stamp.date.clone()),
        ("variableNamingConvention", "flat".to_owned()),
        ("numberOfEventIndicators", description.continuous.indicators.to_string()),
    ];
    xml.inside(("fmiModelDescription", root), |xml| {
        xml.empty(("ModelExchange", model_exchange(model_identifier)));
        xml.empty(("CoSimulation", co_simulation(model_identifier)));
        xml.inside(("UnitDefinitions", vec![]), |xml| units(xml, description));
        xml.inside(("TypeDefinitions", vec![]), |xml| types(xml, description));
        xml.inside(("LogCategories", vec![]), |xml| {
            for (name, text) in LOG_CATEGORIES {
                xml.empty(("Category", vec![("name", name.to_owned()), ("description", text.to_owned())]));
            }
        });
        let experiment = description.experiment;
        xml.empty((
            "DefaultExperiment",
            vec![
                ("startTime", number(experiment.start)),
                ("stopTime", number(experiment.stop)),
                ("tolerance", number(experiment.tolerance)),
                ("stepSize", number(experiment.step)),
            ],
        ));
        xml.inside(("ModelVariables", vec![]), |xml| {
            for (reference, variable) in description.variables.iter().enumerate() {
                scalar_variable(xml, description, reference, variable);
            }
        });
        xml.inside(("ModelStructure", vec![]), |xml| {
            xml.inside(("Outputs", vec![]), |xml| {
                unknowns(xml, description, |variable| &variable.dependencies)
            });
            let derivatives = description.state_derivatives();
            if !derivatives.is_empty() {
                xml.inside(("Derivatives", vec![]), |xml| whole(xml, derivatives.clone()));
            }
            xml.inside(("InitialUnknowns", vec![]), |xml| {
                unknowns(xml, description, |variable| &variable.initial_dependencies);
                whole(xml, description.states().start..derivatives.end);
            });
        });
    });
    xml.text()
}

fn model_exchange(model_identifier: &str) -> Vec<(&'static str, String)> {
    let flags = [
        ("needsExecutionTool", false),
        ("completedIntegratorStepNotNeeded", false),
        ("canBeInstantiatedOnlyOncePerProcess", false),
        ("canNotUseMemoryManagementFunctions", true),
        ("canGetAndSetFMUstate", true),
        ("canSerializeFMUstate", true),
        ("providesDirectionalDerivative", false),
    ];
    let mut attributes = vec![("modelIdentifier", model_identifier.to_owned())];
    attributes.extend(flags.map(|(name, flag)| (name, flag.to_string())));
    attributes
}

fn co_simulation(model_identifier: &str) -> Vec<(&'static str, String)> {
    let flags = [
        ("needsExecutionTool", false),
        ("canHandleVariableCommunicationStepSize", true),
        ("canInterpolateInputs", true),
        ("canRunAsynchronuously", false),
        ("canBeInstantiatedOnlyOncePerProcess", false),
        ("canNotUseMemoryManagementFunctions", true),
        ("canGetAndSetFMUstate", true),
        ("canSerializeFMUstate", true),
        ("providesDirectionalDerivative", true),
    ];
    let mut attributes = vec![("modelIdentifier", model_identifier.to_owned())];
    attributes.extend(flags.map(|(name, flag)| (name, flag.to_string())));
    attributes.push(("maxOutputDerivativeOrder", DERIVATIVE_ORDER.to_string()));
    attributes
}

/// The units that occur.
fn units(xml: &mut Xml, description: &Description) {
    for (name, exponents) in UNITS {
        if description.variables.iter().any(|variable| variable.quantity.unit == name) {
            xml.inside(("Unit", vec![("name", name.to_owned())]), |xml| {
                let pairs = BASES.into_iter().zip(exponents);
                let base = pairs.filter(|(_, exponent)| *exponent != 0);
                xml.empty(("BaseUnit", base.map(|(unit, exponent)| (unit, exponent.to_string())).collect()));
                for (name, factor) in display_units(name) {
                    let attributes = vec![("name", (*name).to_owned()), ("factor", number(*factor))];
                    xml.empty(("DisplayUnit", attributes));
                }
            });
        }
    }
}

/// The types that occur. A model whose variables are all without a unit has none, which no model is.
fn types(xml: &mut Xml, description: &Description) {
    for Type { name, quantity, unit } in crate::units::types(description) {
        xml.inside(("SimpleType", vec![("name", name.to_owned())]), |xml| {
            xml.empty(("Real", vec![("quantity", quantity.to_owned()), ("unit", unit.to_owned())]));
        });
    }
}

fn scalar_variable(xml: &mut Xml, description: &Description, reference: usize, variable: &Variable) {
    let causality = match variable.causality {
        Causality::Parameter => "parameter",
        Causality::Input => "input",
        Causality::Output => "output",
        Causality::Local => "local",
    };
    let variability = match variable.variability() {
        Variability::Fixed => "fixed",
        Variability::Discrete => "discrete",
        Variability::Continuous => "continuous",
    };
    let mut attributes = vec![
        ("name", variable.name.to_string()),
        ("valueReference", reference.to_string()),
        ("description", variable.description.to_string()),
        ("causality", causality.to_owned()),
        ("variability", variability.to_owned()),
    ];
    attributes.extend(variable.initial().map(|initial| {
        let initial = match initial {
            Initial::Exact => "exact",
            Initial::Calculated => "calculated",
        };
        ("initial", initial.to_owned())
    }));
    let real = variable.variable_type == VariableType::Real;
    let mut of_type = Vec::new();
    of_type.extend(type_of(variable).map(|known| ("declaredType", known.name.to_owned())));
    if real {
        of_type.push(("unit", variable.quantity.unit.to_owned()));
        of_type.extend(display_unit(variable.quantity).map(|unit| ("displayUnit", unit.to_owned())));
    }
    let (min, max) = variable.allowed_range();
    of_type.extend(min.map(|min| ("min", number(min))));
    of_type.extend(max.map(|max| ("max", number(max))));
    if real {
        of_type.push(("nominal", number(variable.quantity.nominal)));
    }
    of_type.extend(variable.start().map(|start| ("start", number(start))));
    let (states, derivatives) = (description.states(), description.state_derivatives());
    if derivatives.contains(&(reference as u32)) {
        let state = states.start + reference as u32 - derivatives.start;
        of_type.push(("derivative", (state + 1).to_string()));
    }
    xml.inside(("ScalarVariable", attributes), |xml| {
        xml.empty((if real { "Real" } else { "Integer" }, of_type));
    });
}

/// Unknowns that depend on anything.
fn whole(xml: &mut Xml, rows: std::ops::Range<u32>) {
    for row in rows {
        xml.empty(("Unknown", vec![("index", (row + 1).to_string())]));
    }
}

fn unknowns(xml: &mut Xml, description: &Description, of: impl Fn(&Variable) -> &Vec<Dependency>) {
    for reference in description.references(Causality::Output) {
        let dependencies = of(&description.variables[reference as usize]);
        // Indices count from 1.
        let indices = dependencies.iter().map(|dependency| (dependency.on + 1).to_string());
        let kinds = dependencies.iter().map(|dependency| match dependency.kind {
            DependencyKind::Dependent => "dependent",
            DependencyKind::Fixed => "fixed",
        });
        let attributes = vec![
            ("index", (reference + 1).to_string()),
            ("dependencies", indices.collect::<Vec<_>>().join(" ")),
            ("dependenciesKind", kinds.collect::<Vec<_>>().join(" ")),
        ];
        xml.empty(("Unknown", attributes));
    }
}

/// The shortest decimal that reads back as the same number, as an `xs:double`; whole numbers of type
/// Integer read the same way.
pub(crate) fn number(value: f64) -> String {
    let magnitude = value.abs();
    if value != 0.0 && !(1e-4..1e7).contains(&magnitude) { format!("{value:e}") } else { value.to_string() }
}

/// A writer into memory, which cannot fail.
pub(crate) struct Xml(Writer<Vec<u8>>);

impl Xml {
    /// A document without an element.
    pub(crate) fn new() -> Self {
        let mut xml = Self(Writer::new_with_indent(Vec::new(), b' ', 2));
        xml.event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)));
        xml
    }

    /// What was written.
    pub(crate) fn text(self) -> String {
        let mut text = String::from_utf8(self.0.into_inner()).unwrap_or_default();
        text.push('\n');
        text
    }

    fn event(&mut self, event: Event<'_>) {
        // Memory that runs out aborts the program before it comes here.
        let _ = self.0.write_event(event);
    }

    fn tag((name, attributes): Element<'_>) -> BytesStart<'_> {
        let mut tag = BytesStart::new(name);
        for (key, value) in &attributes {
            tag.push_attribute((*key, value.as_str()));
        }
        tag
    }

    pub(crate) fn empty(&mut self, element: Element<'_>) {
        self.event(Event::Empty(Self::tag(element)));
    }

    pub(crate) fn inside(&mut self, element: Element<'_>, content: impl FnOnce(&mut Self)) {
        let name = element.0.to_owned();
        self.event(Event::Start(Self::tag(element)));
        content(self);
        self.event(Event::End(BytesEnd::new(name)));
    }
}

#[cfg(test)]
mod tests {
    use stickslip::vocabulary::ALL;

    use super::exponents;

    /// A validator refuses an FMU that names a unit that it does not define.
    #[test]
    fn every_quantity_has_a_unit_that_is_defined() {
        for quantity in ALL {
            assert!(exponents(quantity.unit).is_some(), "{}: {}", quantity.name, quantity.unit);
        }
    }
}
