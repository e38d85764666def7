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
    /// The contact law that the data were made with and that describes it best; empty for none in particular.
    pub law: String,
}

impl Hidden {
    /// Something hidden nowhere in particular.
    pub fn new(id: &str, parameters: &[(&'static str, f64)]) -> Self {
        Self::at(id, String::new(), parameters)
    }

    /// Something hidden at a place.
    pub fn at(id: &str, place: String, parameters: &[(&'static str, f64)]) -> Self {
        Self { id: id.to_owned(), place, parameters: parameters.to_vec(), law: String::new() }
    }

    /// Something hidden that another contact law shows.
    pub fn of_law(id: &str, law: &str) -> Self {
        Self { law: law.to_owned(), ..Self::new(id, &[]) }
    }
}

impl Hidden {
    /// As an `[[effect]]` of a model file; `None` outside the catalogue, and where it is another law.
    pub fn entry(&self) -> Option<String> {
        if self.id.starts_with(UNKNOWN) || !self.law.is_empty() {
            return None;
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
}

/// What begins the name of an effect that no catalogue has.
pub const UNKNOWN: &str = "unknown:";

/// What begins the name of micro-slip that is another contact law; the law follows.
pub const MICRO_SLIP_OF: &str = "micro_slip:";
