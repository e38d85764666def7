//! The place of an effect.

use std::fmt;

use crate::data::{self, ChannelName};
use crate::system::Place;

/// The place of an effect: `at = "m2"`, `at = "x=0.55"`, `channel = "force"`.
#[derive(Debug, Clone, PartialEq)]
pub enum Location {
    /// A mass of an oscillator.
    Mass(String),
    /// A position on a beam (m from the clamp).
    Position(f64),
    /// A measured channel, by its name in the canonical spelling of [`ChannelName`].
    Channel(String),
}

/// The text is not a place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not a place: write a mass's name, `x=0.55` on a beam, or the name of a channel")]
pub struct LocationError(pub String);

impl Location {
    /// Reads what follows `at =`: a mass's name, or `x=` and a position in metres.
    ///
    /// # Errors
    /// Empty text, or `x=` without a finite number.
    ///
    /// ```
    /// use stickslip::effects::Location;
    /// assert_eq!(Location::parse_at("x=0.55")?, Location::Position(0.55));
    /// assert_eq!(Location::parse_at("m2")?, Location::Mass("m2".into()));
    /// # Ok::<(), stickslip::effects::LocationError>(())
    /// ```
    pub fn parse_at(text: &str) -> Result<Self, LocationError> {
        let refused = || LocationError(text.to_owned());
        match text.trim().strip_prefix("x=") {
            Some(number) => {
                let position: f64 = number.trim().parse().map_err(|_| refused())?;
                if position.is_finite() { Ok(Self::Position(position)) } else { Err(refused()) }
            }
            None if text.trim().is_empty() => Err(refused()),
            None => Ok(Self::Mass(text.trim().to_owned())),
        }
    }

    /// Reads what follows `channel =`.
    ///
    /// # Errors
    /// A name that no column can have.
    pub fn parse_channel(text: &str) -> Result<Self, LocationError> {
        let name = ChannelName::parse(text).map_err(|_| LocationError(text.to_owned()))?;
        Ok(Self::Channel(name.to_string()))
    }

    /// The place a channel was measured at, as a place on the structure.
    pub fn of_channel(name: &ChannelName) -> Option<Self> {
        match &name.place {
            data::Place::Unnamed => None,
            data::Place::Mass(mass) => Some(Self::Mass(mass.clone())),
            data::Place::Position(position) => Some(Self::Position(*position)),
        }
    }

    /// The place on the structure; `None` for a channel.
    pub fn place(&self) -> Option<Place> {
        match self {
            Self::Mass(name) => Some(Place::Mass(name.clone())),
            Self::Position(position) => Some(Place::Position(*position)),
            Self::Channel(_) => None,
        }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mass(name) | Self::Channel(name) => formatter.write_str(name),
            Self::Position(position) => write!(formatter, "x={position}"),
        }
    }
}
