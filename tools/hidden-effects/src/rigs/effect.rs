//! What can be hidden, by its name, with the parameters it was given.

use std::fmt::Write;

/// Something hidden in a case.
#[derive(Debug, Clone, PartialEq)]
pub struct Hidden {
    /// The name in the catalogue, or `unknown:` and a name of its own.
    pub id: String,
    /// Where it sits: a mass, a position or a channel; empty when it sits nowhere in particular.
    pub place: String,
    /// Its parameters by the catalogue's names, SI.
    pub parameters: Vec<(&'static str, f64)>,
    /// The contact law that shows it, if it is one: then the parameters are the law's own.
    pub law: Option<Law>,
}

/// A contact law in the place of the given model's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Law {
    /// Its name.
    pub name: &'static str,
    /// Laws of the catalogue that describe it exactly, the first with the parameters that are told.
    pub described_by: &'static [&'static str],
}

impl Hidden {
    /// Something hidden nowhere in particular.
    pub fn new(id: &str, parameters: &[(&'static str, f64)]) -> Self {
        Self::at(id, String::new(), parameters)
    }

    /// Something hidden at a place.
    pub fn at(id: &str, place: String, parameters: &[(&'static str, f64)]) -> Self {
        Self { id: id.to_owned(), place, parameters: parameters.to_vec(), law: None }
    }

    /// Something hidden that another contact law shows.
    pub fn of_law(id: &str, law: Law, parameters: &[(&'static str, f64)]) -> Self {
        Self { law: Some(law), ..Self::new(id, parameters) }
    }
}

impl Hidden {
    /// As an `[[effect]]` of a model file, nothing where it is another law; `None` outside the catalogue.
    pub fn entry(&self) -> Option<String> {
        if self.id.starts_with(UNKNOWN) {
            return None;
        }
        if self.law.is_some() {
            return Some(String::new());
        }
        let mut text = format!("\n[[effect]]\nid = \"{}\"\n", self.id);
        if !self.place.is_empty() {
            let key = if self.id.starts_with("sensor_") { "channel" } else { "at" };
            let _ = writeln!(text, "{key} = \"{}\"", self.place);
        }
        for (name, value) in &self.parameters {
            let _ = writeln!(text, "{name} = {value:e}");
        }
        Some(text)
    }

    /// As lines of `[contact]`; `None` where it is no law.
    pub fn law_lines(&self) -> Option<String> {
        let mut text = format!("law = \"{}\"", self.law?.described_by.first()?);
        for (name, value) in &self.parameters {
            let _ = write!(text, "\n{name} = {value}");
        }
        Some(text)
    }
}

/// What begins the name of an effect that no catalogue has.
pub const UNKNOWN: &str = "unknown:";

/// What begins the name of micro-slip that is another contact law; the law follows.
pub const MICRO_SLIP_OF: &str = "micro_slip:";
