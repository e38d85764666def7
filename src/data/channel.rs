//! Names of columns: a quantity, and where it was measured.

use std::fmt;

use thiserror::Error;

use crate::document::suggestion;
use crate::vocabulary::{self as v, Quantity};

/// What a CSV column can hold.
pub const COLUMNS: &[&Quantity] = &[
    &v::TIME,
    &v::DISPLACEMENT,
    &v::VELOCITY,
    &v::ACCELERATION,
    &v::FORCE,
    &v::CONTACT_FORCE,
    &v::NORMAL_LOAD,
    &v::NORMAL_DISPLACEMENT,
    &v::EXCITATION,
    &v::AMPLITUDE,
    &v::FREQUENCY,
    &v::DAMPING_RATIO,
    &v::FREQUENCY_INTERVAL,
    &v::DAMPING_INTERVAL,
    &v::WINDOW,
    &v::PHASE,
];

/// Those of [`COLUMNS`] that are measured at a mass or at a position.
const PLACED: &[&str] = &["displacement", "velocity", "acceleration", "excitation", "amplitude", "phase"];

/// A column's name, parsed: `force`, `displacement:m1`, `acceleration:x=0.55`.
#[derive(Debug, Clone, PartialEq)]
pub struct ChannelName {
    /// What was measured.
    pub quantity: &'static Quantity,
    /// Where.
    pub place: Place,
}

/// Where a channel was measured.
#[derive(Debug, Clone, PartialEq)]
pub enum Place {
    /// The name gives no place: the contact, or the only place there is.
    Unnamed,
    /// At a mass of an oscillator, by its name.
    Mass(String),
    /// At a position of a beam (m from the clamp).
    Position(f64),
}

/// Why a column's name was refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ChannelNameError {
    /// The quantity is not one of [`COLUMNS`].
    #[error("unknown column `{name}`")]
    Quantity {
        /// The quantity as written.
        name: String,
        /// The nearest legal name and the list of all.
        help: String,
    },
    /// The quantity is not measured at places.
    #[error("`{quantity}` takes no place, but the column is called `{name}`")]
    Unplaced {
        /// The column's name as written.
        name: String,
        /// The quantity.
        quantity: &'static str,
    },
    /// What follows the colon is neither a mass's name nor `x=` with a number.
    #[error("`{place}` is not a place: write a mass's name (`:m1`) or a position in metres (`:x=0.55`)")]
    Place {
        /// The place as written.
        place: String,
    },
}

impl ChannelName {
    /// Parses `name`, `name:mass` or `name:x=position`.
    ///
    /// # Errors
    /// An unknown quantity, a place that is not one, or a place where the quantity has none.
    ///
    /// ```
    /// use stickslip::data::{ChannelName, Place};
    ///
    /// let name = ChannelName::parse("acceleration:x=0.550")?;
    /// assert_eq!(name.place, Place::Position(0.55));
    /// assert_eq!(name.to_string(), "acceleration:x=0.55");
    /// # Ok::<(), stickslip::data::ChannelNameError>(())
    /// ```
    pub fn parse(name: &str) -> Result<Self, ChannelNameError> {
        let (quantity_name, place) = match name.split_once(':') {
            None => (name.trim(), None),
            Some((quantity, place)) => (quantity.trim(), Some(place.trim())),
        };
        let Some(&quantity) = COLUMNS.iter().find(|quantity| quantity.name == quantity_name) else {
            let names: Vec<_> = COLUMNS.iter().map(|quantity| quantity.name).collect();
            return Err(ChannelNameError::Quantity {
                name: quantity_name.to_owned(),
                help: suggestion(quantity_name, &names, "columns"),
            });
        };
        let place = match place {
            None => Place::Unnamed,
            Some(_) if !PLACED.contains(&quantity.name) => {
                return Err(ChannelNameError::Unplaced { name: name.to_owned(), quantity: quantity.name });
            }
            Some(place) => {
                parse_place(place).ok_or_else(|| ChannelNameError::Place { place: place.to_owned() })?
            }
        };
        Ok(ChannelName { quantity, place })
    }
}

fn parse_place(place: &str) -> Option<Place> {
    if let Some(position) = place.strip_prefix("x=") {
        let position: f64 = position.trim().parse().ok()?;
        return position.is_finite().then_some(Place::Position(position));
    }
    let is_name = |letter: char| letter.is_alphanumeric() || letter == '_' || letter == '-';
    (!place.is_empty() && place.chars().all(is_name)).then(|| Place::Mass(place.to_owned()))
}

impl fmt::Display for ChannelName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = self.quantity.name;
        match &self.place {
            Place::Unnamed => formatter.write_str(name),
            Place::Mass(mass) => write!(formatter, "{name}:{mass}"),
            Place::Position(position) => write!(formatter, "{name}:x={position}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_reads_back_as_it_is_written() {
        for quantity in COLUMNS {
            for place in [Place::Unnamed, Place::Mass("m2".to_owned()), Place::Position(0.1 + 0.2)] {
                let name = ChannelName { quantity, place };
                let parsed = ChannelName::parse(&name.to_string());
                if name.place == Place::Unnamed || PLACED.contains(&quantity.name) {
                    assert_eq!(parsed, Ok(name));
                } else {
                    assert!(matches!(parsed, Err(ChannelNameError::Unplaced { .. })), "{name}");
                }
            }
        }
    }

    #[test]
    fn what_is_no_name_is_refused() {
        for name in
            ["", ":", "x=0.5", "farce", "force ", "acceleration:", "acceleration:x=", "acceleration:x=inf"]
        {
            let legal = name.trim() == "force";
            assert_eq!(ChannelName::parse(name).is_ok(), legal, "{name}");
        }
        let error = ChannelName::parse("aceleration:x=1").unwrap_err();
        let ChannelNameError::Quantity { help, .. } = error else { panic!("{error}") };
        assert!(help.contains("did you mean `acceleration`"), "{help}");
    }
}
