//! `modelDescription.xml` of FMI 3.0 from the variable table and what lies beyond it.

use stickslip::fmi::{
    Causality, DERIVATIVE_ORDER, Dependency, DependencyKind, Description, Further, Initial, Shows,
    Variability, Variable, VariableType,
};
use stickslip::vocabulary::Quantity;

use crate::Stamp;
use crate::units::{Type, display_unit, display_units, type_of, types};
use crate::xml::{BASES, LOG_CATEGORIES, UNITS, Xml, number};

/// Type of the slip state.
const SLIP_STATE: &str = "SlipState";
/// Its items.
const SLIP_STATES: [(&str, &str); 3] =
    [("stick", "The contact sticks"), ("slip", "All of it slips"), ("separated", "The bodies are apart")];

/// The XML of `description` for an FMU of FMI 3.0 called `model_identifier`.
///
/// ```
/// use stickslip::fmi::Instance;
/// let (name, model_toml) = stickslip_fmu_package::standard_models()[0];
/// let xml = stickslip_fmu_package::model_description_xml3(name, Instance::new(model_toml)?.description());
/// assert!(xml.contains("fmiVersion=\"3.0\""));
/// # Ok::<(), stickslip::fmi::Error>(())
/// ```
pub fn model_description_xml3(model_identifier: &str, description: &Description) -> String {
    stamped_xml3(model_identifier, description, &Stamp::default())
}

/// The same with the author and date of `stamp`.
pub(crate) fn stamped_xml3(model_identifier: &str, description: &Description, stamp: &Stamp) -> String {
    let further = description.further();
    let mut xml = Xml::new();
    let root = vec![
        ("fmiVersion", "3.0".to_owned()),
        ("modelName", description.name.to_owned()),
        ("instantiationToken", format!("{{{}}}", description.guid())),
        ("description", description.summary.to_owned()),
        ("author", stamp.author.clone()),
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("license", "MIT OR Apache-2.0".to_owned()),
        ("generationTool", concat!("stickslip ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("generationDateAndTime", stamp.date.clone()),
        ("variableNamingConvention", "flat".to_owned()),
    ];
    xml.inside(("fmiModelDescription", root), |xml| {
        xml.empty(("ModelExchange", model_exchange(model_identifier)));
        xml.empty(("CoSimulation", co_simulation(model_identifier)));
        xml.inside(("UnitDefinitions", vec![]), |xml| units(xml, description, &further));
        xml.inside(("TypeDefinitions", vec![]), |xml| {
            for Type { name, quantity, unit } in types(description) {
                let attributes = [("name", name), ("quantity", quantity), ("unit", unit)];
                let attributes = attributes.map(|(name, text)| (name, text.to_owned())).to_vec();
                xml.empty(("Float64Type", attributes));
            }
            if description.variables.iter().any(is_enumeration) {
                slip_states(xml);
            }
        });
        xml.inside(("LogCategories", vec![]), |xml| {
            for (name, text) in LOG_CATEGORIES {
                let text = text.replace("fmi2", "fmi3");
                xml.empty(("Category", vec![("name", name.to_owned()), ("description", text)]));
            }
        });
        let experiment = description.experiment;
        let experiment = [
            ("startTime", experiment.start),
            ("stopTime", experiment.stop),
            ("tolerance", experiment.tolerance),
            ("stepSize", experiment.step),
        ];
        xml.empty(("DefaultExperiment", experiment.map(|(name, value)| (name, number(value))).to_vec()));
        xml.inside(("ModelVariables", vec![]), |xml| variables(xml, description, &further));
        xml.inside(("ModelStructure", vec![]), |xml| structure(xml, description, &further));
    });
    xml.text()
}

fn is_enumeration(variable: &Variable) -> bool {
    variable.variable_type == VariableType::Integer
}

fn model_exchange(model_identifier: &str) -> Vec<(&'static str, String)> {
    let flags = [
        ("needsExecutionTool", false),
        ("canBeInstantiatedOnlyOncePerProcess", false),
        ("canGetAndSetFMUState", true),
        ("canSerializeFMUState", true),
        ("providesDirectionalDerivatives", false),
        ("providesAdjointDerivatives", false),
        ("providesPerElementDependencies", false),
        ("needsCompletedIntegratorStep", true),
        ("providesEvaluateDiscreteStates", false),
    ];
    let mut attributes = vec![("modelIdentifier", model_identifier.to_owned())];
    attributes.extend(flags.map(|(name, flag)| (name, flag.to_string())));
    attributes
}

fn co_simulation(model_identifier: &str) -> Vec<(&'static str, String)> {
    let flags = [
        ("needsExecutionTool", false),
        ("canBeInstantiatedOnlyOncePerProcess", false),
        ("canGetAndSetFMUState", true),
        ("canSerializeFMUState", true),
        ("providesDirectionalDerivatives", true),
        ("providesAdjointDerivatives", true),
        ("providesPerElementDependencies", false),
        ("canHandleVariableCommunicationStepSize", true),
        ("providesIntermediateUpdate", true),
        ("mightReturnEarlyFromDoStep", false),
        ("canReturnEarlyAfterIntermediateUpdate", false),
        ("hasEventMode", false),
        ("providesEvaluateDiscreteStates", false),
    ];
    let mut attributes = vec![("modelIdentifier", model_identifier.to_owned())];
    attributes.extend(flags.map(|(name, flag)| (name, flag.to_string())));
    attributes.push(("maxOutputDerivativeOrder", DERIVATIVE_ORDER.to_string()));
    attributes
}

/// The units that occur.
fn units(xml: &mut Xml, description: &Description, further: &[Further]) {
    let of_rows = description.variables.iter().map(|variable| variable.quantity.unit);
    let used: Vec<&str> = of_rows.chain(further.iter().map(|other| other.quantity.unit)).collect();
    for (name, exponents) in UNITS.into_iter().filter(|(name, _)| used.contains(name)) {
        xml.inside(("Unit", vec![("name", name.to_owned())]), |xml| {
            let base = BASES.into_iter().zip(exponents).filter(|(_, exponent)| *exponent != 0);
            xml.empty(("BaseUnit", base.map(|(unit, exponent)| (unit, exponent.to_string())).collect()));
            for (shown, factor) in display_units(name) {
                let attributes = vec![("name", (*shown).to_owned()), ("factor", number(*factor))];
                xml.empty(("DisplayUnit", attributes));
            }
        });
    }
}

fn slip_states(xml: &mut Xml) {
    let description = "What a contact does".to_owned();
    let attributes = vec![("name", SLIP_STATE.to_owned()), ("description", description)];
    xml.inside(("EnumerationType", attributes), |xml| {
        for (value, (name, text)) in SLIP_STATES.into_iter().enumerate() {
            let attributes = vec![
                ("name", name.to_owned()),
                ("value", value.to_string()),
                ("description", text.to_owned()),
            ];
            xml.empty(("Item", attributes));
        }
    });
}

fn variables(xml: &mut Xml, description: &Description, further: &[Further]) {
    for (reference, variable) in description.variables.iter().enumerate() {
        row(xml, description, reference, variable);
    }
    for (place, other) in further.iter().enumerate() {
        let (causality, initial) = match other.shows {
            Shows::Time => ("independent", None),
            Shows::Indicator(_) => ("local", Some("calculated")),
            Shows::Rows(_) => ("output", Some("calculated")),
        };
        let mut attributes = vec![
            ("name", other.name.clone()),
            ("valueReference", (description.variables.len() + place).to_string()),
            ("description", other.description.clone()),
            ("causality", causality.to_owned()),
            ("variability", "continuous".to_owned()),
        ];
        attributes.extend(initial.map(|initial| ("initial", initial.to_owned())));
        attributes.extend(unit(other.quantity));
        match &other.shows {
            Shows::Rows(rows) => {
                attributes.push(("intermediateUpdate", "true".to_owned()));
                attributes.push(("nominal", number(other.quantity.nominal)));
                xml.inside(("Float64", attributes), |xml| {
                    xml.empty(("Dimension", vec![("start", rows.len().to_string())]));
                });
            }
            Shows::Time | Shows::Indicator(_) => xml.empty(("Float64", attributes)),
        }
    }
}

fn unit(quantity: &Quantity) -> Vec<(&'static str, String)> {
    let shown = display_unit(quantity).map(|shown| ("displayUnit", shown.to_owned()));
    std::iter::once(("unit", quantity.unit.to_owned())).chain(shown).collect()
}

/// A row of the table.
fn row(xml: &mut Xml, description: &Description, reference: usize, variable: &Variable) {
    let (causality, initial) = match (variable.causality, variable.initial()) {
        (Causality::Parameter, _) => ("parameter", "exact"),
        // In FMI 3.0 inputs have one, too.
        (Causality::Input, _) => ("input", "exact"),
        (Causality::Output, Some(Initial::Exact)) => ("output", "exact"),
        (Causality::Output, _) => ("output", "calculated"),
        (Causality::Local, _) => ("local", "calculated"),
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
    if variability == "continuous" && matches!(variable.causality, Causality::Input | Causality::Output) {
        attributes.push(("intermediateUpdate", "true".to_owned()));
    }
    attributes.push(("initial", initial.to_owned()));
    if is_enumeration(variable) {
        attributes.push(("declaredType", SLIP_STATE.to_owned()));
        xml.empty(("Enumeration", attributes));
        return;
    }
    attributes.extend(type_of(variable).map(|known| ("declaredType", known.name.to_owned())));
    attributes.extend(unit(variable.quantity));
    let (min, max) = variable.allowed_range();
    attributes.extend(min.map(|min| ("min", number(min))));
    attributes.extend(max.map(|max| ("max", number(max))));
    attributes.push(("nominal", number(variable.quantity.nominal)));
    attributes.extend(variable.start().map(|start| ("start", number(start))));
    let (states, derivatives) = (description.states(), description.state_derivatives());
    if derivatives.contains(&(reference as u32)) {
        let state = states.start + reference as u32 - derivatives.start;
        attributes.push(("derivative", state.to_string()));
    }
    xml.empty(("Float64", attributes));
}

fn structure(xml: &mut Xml, description: &Description, further: &[Further]) {
    let arrays = || {
        let places = further.iter().enumerate().filter(|(_, other)| !other.rows().is_empty());
        places.map(|(place, other)| (description.variables.len() + place, other.rows()))
    };
    let outputs = |xml: &mut Xml, element: &'static str, of: fn(&Variable) -> &Vec<Dependency>| {
        for reference in description.references(Causality::Output) {
            let dependencies = of(&description.variables[reference as usize]);
            unknown(xml, element, reference as usize, Some(dependencies));
        }
        for (reference, rows) in arrays() {
            let dependencies = description.dependencies_of_rows(rows, of);
            unknown(xml, element, reference, Some(&dependencies));
        }
    };
    outputs(xml, "Output", |variable| &variable.dependencies);
    for reference in description.state_derivatives() {
        unknown(xml, "ContinuousStateDerivative", reference as usize, None);
    }
    outputs(xml, "InitialUnknown", |variable| &variable.initial_dependencies);
    for reference in description.states().start..description.state_derivatives().end {
        unknown(xml, "InitialUnknown", reference as usize, None);
    }
    for (place, other) in further.iter().enumerate() {
        if matches!(other.shows, Shows::Indicator(_)) {
            unknown(xml, "EventIndicator", description.variables.len() + place, None);
        }
    }
}

/// An unknown, which depends on anything where no dependencies are given.
fn unknown(xml: &mut Xml, element: &'static str, reference: usize, dependencies: Option<&Vec<Dependency>>) {
    let mut attributes = vec![("valueReference", reference.to_string())];
    if let Some(dependencies) = dependencies {
        let references: Vec<String> = dependencies.iter().map(|one| one.on.to_string()).collect();
        let kinds: Vec<&str> = dependencies
            .iter()
            .map(|one| match one.kind {
                DependencyKind::Dependent => "dependent",
                DependencyKind::Fixed => "fixed",
            })
            .collect();
        attributes.push(("dependencies", references.join(" ")));
        attributes.push(("dependenciesKind", kinds.join(" ")));
    }
    xml.empty((element, attributes));
}
