//! What is followed and how, and who judges what is found.

use super::{Ending, Location};
use crate::harmonic::HarmonicError;
use crate::harmonic::newton::problem::{Newton, Stopping};
use crate::harmonic::newton::system::{PeriodicSystem, Scalar};

/// What is followed, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Route {
    /// The scalar continued.
    pub along: Scalar,
    /// Where it starts.
    pub from: f64,
    /// Where it is to arrive.
    pub to: f64,
    /// When a point is good enough.
    pub stopping: Stopping,
    /// Longest step, as a fraction of the range.
    pub max_step: f64,
}

/// Judgement of a point that Newton's method found.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Verdict {
    /// Good. What the caller watches turned by this fraction of what is tolerable, in second order of the step:
    /// above 1 the step was too long, unless it is as short as steps at corners.
    Keep(f64),
    /// To be solved again with so many harmonics.
    Harmonics(usize),
}

/// Judges a point that the system and the solver have just left; the last argument is what is free, the scalar
/// continued first.
pub(crate) type Judge<'j> = dyn FnMut(&mut dyn PeriodicSystem, &mut Newton, &Location, &[Scalar]) -> Result<Verdict, HarmonicError>
    + 'j;

/// Looks at a location as a [`Judge`] does.
pub(crate) type See<'s, T> =
    dyn FnMut(&mut dyn PeriodicSystem, &mut Newton, &Location, &[Scalar]) -> Option<T> + 's;

/// Outcome of one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Advance {
    /// A point was found.
    Going,
    /// A point was found, the last one.
    Arrived(Ending),
    /// No point was found.
    Stuck,
}
