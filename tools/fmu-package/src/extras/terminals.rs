//! `terminalsAndIcons.xml`: the flanges at which a model is joined to others.
//!
//! A flange is a place where motion goes one way and force the other: a contact takes the motion and gives the force, a
//! structure gives the motion and takes the force. A model that has both inside has no flange. FMI 2.0.4 took the file over from FMI 3.0, so
//! that it is the same for both.

use stickslip::fmi::{Causality, Description, Variable};

use crate::xml::Xml;

/// Name of the flange's picture.
pub const ICON: &str = "flange";

/// Half of the side of the model's picture, and of a flange's, in the coordinates of the file.
const HALF: f64 = 100.0;
const FLANGE_HALF: f64 = 10.0;

/// A flange: names of its variables.
#[derive(Debug, PartialEq, Eq)]
pub struct Terminal<'a> {
    pub name: String,
    description: &'static str,
    pub position: &'a str,
    pub velocity: Option<&'a str>,
    pub force: &'a str,
    /// The force is an output: of the body that resists.
    resists: bool,
}

/// Directions of a flange: its name, what it is, and the stems of its variables; a contact force is called otherwise where it comes in.
const DIRECTIONS: [(&str, &str, [&str; 2], [&str; 2]); 2] = [
    (
        "tangential",
        "Mechanical flange in the direction of sliding: position, velocity, and the restoring force of the contact",
        ["displacement", "velocity"],
        ["force", "contact_force"],
    ),
    (
        "normal",
        "Mechanical flange in the normal direction, positive where the contact opens: position, velocity, restoring force",
        ["opening", "opening_velocity"],
        ["opening_force", "opening_force"],
    ),
];

/// The flanges of a model.
pub fn terminals(description: &Description) -> Vec<Terminal<'_>> {
    let find = |name: &str| description.variables.iter().find(|variable| variable.name == name);
    let mut found = Vec::new();
    for place in places(description) {
        for (direction, text, [position, velocity], [given, taken]) in DIRECTIONS {
            let at = |stem: &str| find(&format!("{stem}{place}"));
            let Some(position) = at(position) else { continue };
            let resists = position.causality == Causality::Input;
            let force = at(if resists { given } else { taken });
            let Some(force) = force.filter(|force| force.causality == opposite(position)) else { continue };
            let velocity = at(velocity).filter(|velocity| velocity.causality == position.causality);
            found.push(Terminal {
                name: format!("{direction}{place}"),
                description: text,
                position: &position.name,
                velocity: velocity.map(|velocity| &*velocity.name),
                force: &force.name,
                resists,
            });
        }
    }
    found
}

/// What stands behind the names of variables at each place, nothing for the support first.
fn places(description: &Description) -> Vec<String> {
    let mut places = vec![String::new()];
    for variable in &description.variables {
        if let Some((_, place)) = variable.name.split_once(':') {
            let place = format!(":{place}");
            if !places.contains(&place) {
                places.push(place);
            }
        }
    }
    places
}

fn opposite(variable: &Variable) -> Causality {
    match variable.causality {
        Causality::Input => Causality::Output,
        _ => Causality::Input,
    }
}

/// The file's text.
///
/// ```
/// let (_, model_toml) = stickslip_fmu_package::standard_models()[0];
/// let instance = stickslip::fmi::Instance::new(model_toml)?;
/// let xml = stickslip_fmu_package::terminals_and_icons_xml(instance.description());
/// assert!(xml.contains(r#"<Terminal name="tangential" matchingRule="plug""#));
/// # Ok::<(), stickslip::fmi::Error>(())
/// ```
pub fn terminals_and_icons_xml(description: &Description) -> String {
    let mut xml = Xml::new();
    // "3.0" in an FMU of FMI 2.0 too: it is the version of this file's format.
    let root = vec![("fmiVersion", "3.0".to_owned())];
    let square = |half: f64| {
        let [low, high] = [-half, half].map(|end| end.to_string());
        vec![("x1", low.clone()), ("y1", low), ("x2", high.clone()), ("y2", high)]
    };
    xml.inside(("fmiTerminalsAndIcons", root), |xml| {
        xml.inside(("GraphicalRepresentation", vec![]), |xml| {
            let mut system = square(HALF);
            system.push(("suggestedScalingFactorTo_mm", "0.1".to_owned()));
            xml.empty(("CoordinateSystem", system));
            xml.empty(("Icon", square(HALF)));
        });
        let terminals = terminals(description);
        if !terminals.is_empty() {
            xml.inside(("Terminals", vec![]), |xml| {
                for (index, terminal) in terminals.iter().enumerate() {
                    write(xml, terminal, index, terminals.len());
                }
            });
        }
    });
    xml.text()
}

fn write(xml: &mut Xml, terminal: &Terminal<'_>, index: usize, count: usize) {
    let attributes = vec![
        ("name", terminal.name.clone()),
        ("matchingRule", "plug".to_owned()),
        ("description", terminal.description.to_owned()),
    ];
    // The restoring force acts on the body that resists in the direction of its motion, and on the other one against it.
    let force = if terminal.resists { "inflow" } else { "outflow" };
    let members = [
        (Some(terminal.position), "position", "signal"),
        (terminal.velocity, "velocity", "signal"),
        (Some(terminal.force), "force", force),
    ];
    xml.inside(("Terminal", attributes), |xml| {
        for (variable, member, kind) in members {
            let Some(variable) = variable else { continue };
            xml.empty((
                "TerminalMemberVariable",
                vec![
                    ("variableName", variable.to_owned()),
                    ("memberName", member.to_owned()),
                    ("variableKind", kind.to_owned()),
                ],
            ));
        }
        // Contacts are joined at their left, structures at their right, from top to bottom.
        let x = if terminal.resists { -HALF } else { HALF };
        let y = HALF - 2.0 * HALF * (index + 1) as f64 / (count + 1) as f64;
        let edges = [
            ("x1", x - FLANGE_HALF),
            ("y1", y - FLANGE_HALF),
            ("x2", x + FLANGE_HALF),
            ("y2", y + FLANGE_HALF),
        ];
        let mut attributes = vec![
            ("defaultConnectionColor", "27 120 55".to_owned()),
            ("defaultConnectionStrokeSize", "0.5".to_owned()),
        ];
        attributes.extend(edges.map(|(name, edge)| (name, format!("{}", (edge * 10.0).round() / 10.0))));
        attributes.push(("iconBaseName", ICON.to_owned()));
        xml.empty(("TerminalGraphicalRepresentation", attributes));
    });
}
