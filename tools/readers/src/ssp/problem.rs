//! What keeps a system structure from being simulated.

use thiserror::Error;

use crate::units::UnitMismatch;

/// What can be wrong with a system structure.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SspProblem {
    /// A package without its description.
    #[error("there is no `SystemStructure.ssd` in the package")]
    NoStructure,
    /// Another version of SSP.
    #[error("the file is of SSP version `{0}`; versions 1.x are read")]
    Version(String),
    /// Two things of one name.
    #[error("{what} `{name}` is listed twice")]
    Twice {
        /// `the element`, `the connector`, `the parameter`.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// An element that a connection names and the system does not have.
    #[error("there is no element `{0}` in the system")]
    UnknownElement(String),
    /// A connector that a connection names and the element does not have.
    #[error("{element} has no connector `{connector}`")]
    UnknownConnector {
        /// `the system` or the element's name.
        element: String,
        /// The connector.
        connector: String,
    },
    /// Neither or both of the ends give a value.
    #[error("the connection between `{start}` and `{end}` does not lead from an output to an input")]
    Direction {
        /// One end.
        start: String,
        /// The other.
        end: String,
    },
    /// Two connections that set one input.
    #[error("`{0}` is set by two connections")]
    TwoSources(String),
    /// Connections in a circle that no component is in.
    #[error("the value of `{0}` comes from itself")]
    Circle(String),
    /// Something of SSP that is not done here.
    #[error("{0} are not supported")]
    Unsupported(String),
    /// A file that the description names.
    #[error("`{source_uri}` cannot be used: {reason}")]
    Source {
        /// As it is named.
        source_uri: String,
        /// Why.
        reason: String,
    },
    /// A unit that the file does not define.
    #[error("the unit `{0}` is not among the units of the file")]
    UnknownUnit(String),
    /// Units that do not fit.
    #[error(transparent)]
    Unit(#[from] UnitMismatch),
    /// An element in the standard's namespace that the standard does not have.
    #[error(
        "SSP has no element {element} in {parent}{}",
        .meant.map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"))
    )]
    UnknownStandardElement {
        /// Its name.
        element: String,
        /// What it is in.
        parent: String,
        /// What may be meant.
        meant: Option<&'static str>,
    },
    /// An attribute of an element of the standard that the standard does not have.
    #[error(
        "SSP has no attribute `{attribute}` of {element}{}",
        .meant.map_or_else(String::new, |meant| format!("; did you mean `{meant}`?"))
    )]
    UnknownAttribute {
        /// Its name.
        attribute: String,
        /// What has it.
        element: String,
        /// What may be meant.
        meant: Option<&'static str>,
    },
    /// An element of the standard in another namespace than its own.
    #[error("{element} belongs to the namespace `{right}`, not to `{found}`")]
    Namespace {
        /// Its name.
        element: String,
        /// Where it is.
        found: String,
        /// Where it should be.
        right: String,
    },
    /// A mapping of truths where numbers flow.
    #[error("a BooleanMappingTransformation cannot be applied to `{0}`, which is no Boolean")]
    BooleanMapping(String),
    /// An item that its enumeration does not have.
    #[error("no enumeration has the item `{0}`")]
    UnknownItem(String),
}

impl SspProblem {
    /// What would be right, if there is more to say.
    pub fn help(&self) -> Option<String> {
        let help = match self {
            SspProblem::NoStructure => "an .ssp file is a zip archive with that file at its top",
            SspProblem::Unit(_) => {
                "write suppressUnitConversion=\"true\" and a LinearTransformation if the numbers are meant as they are"
            }
            SspProblem::BooleanMapping(_) => "a LinearTransformation is what changes numbers",
            SspProblem::TwoSources(_) => {
                "forces of several contacts need an input each, or a component that adds them"
            }
            _ => return None,
        };
        Some(help.to_owned())
    }
}
