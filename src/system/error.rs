//! What can be wrong with a structure, as data.

use crate::vocabulary::Quantity;

/// Why a structure has no modes, or not the ones asked for.
///
/// `path` is the value's place in the model file, e.g. `beam.point_mass[1].mass` (counted from 0).
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StructureError {
    /// A list of a beam in modal coordinates does not have one entry per mode.
    #[error("{field} has {found} entries, expected {expected}")]
    Entries {
        /// Field of the beam.
        field: &'static str,
        /// Entries needed.
        expected: usize,
        /// Entries present.
        found: usize,
    },
    /// Numbers that make no law.
    #[error(transparent)]
    Law(#[from] crate::contact::LawError),
    /// A value is outside the bounds of its quantity, or not a finite number.
    #[error("{path} = {value} is not a legal {} ({})", quantity.name, quantity.unit)]
    OutOfBounds {
        /// Where the value stands.
        path: String,
        /// The value (SI).
        value: f64,
        /// What it should be: unit and bounds.
        quantity: &'static Quantity,
    },
    /// A position is beyond the end of the beam.
    #[error("{path} = {position} m is beyond the end of the beam at {length} m")]
    BeyondTheEnd {
        /// Where the position stands.
        path: String,
        /// The position (m from the clamp).
        position: f64,
        /// Length of the beam (m).
        length: f64,
    },
    /// An effect at a place that a beam does not have.
    #[error("`{place}` is no place on a beam: write `x=` and the distance from the clamp in metres")]
    NotOnTheBeam {
        /// The place as written.
        place: String,
    },
    /// The number of modes is zero or beyond what the beam theory is good for.
    #[error("{modes} modes are requested; between 1 and {most} are possible")]
    ModeCount {
        /// Modes asked for.
        modes: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// One damping ratio per mode is needed.
    #[error("{given} damping ratios given for {modes} modes")]
    DampingRatioCount {
        /// Ratios given.
        given: usize,
        /// Modes of the model.
        modes: usize,
    },
    /// No rotational spring gives the beam this first frequency.
    #[error(
        "no rotational stiffness gives {frequency} Hz: a free pin gives {lowest} Hz, a clamped end {highest} Hz"
    )]
    FrequencyOutOfReach {
        /// The frequency asked for (Hz).
        frequency: f64,
        /// First frequency with a free pin (Hz), the lowest possible.
        lowest: f64,
        /// First frequency with a clamped end (Hz), approached but not reached.
        highest: f64,
    },
    /// A finite-element mesh too coarse for the modes, or too large for a dense solver.
    #[error("{elements} elements are requested; between {least} and {most} are possible")]
    ElementCount {
        /// Elements asked for.
        elements: usize,
        /// The smallest number that has the modes asked for.
        least: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// The values are legal one by one, but a quantity derived from them overflows or vanishes.
    #[error("the {quantity} is {value}, beyond what can be computed")]
    NotComputable {
        /// The derived quantity, in words.
        quantity: &'static str,
        /// Its value.
        value: f64,
    },
    /// A reference to a mass that the oscillator does not have.
    #[error("{path} names mass {mass} (counted from 0) of {count}")]
    UnknownMass {
        /// Where the reference stands.
        path: String,
        /// The mass referred to, counted from 0.
        mass: usize,
        /// Number of masses.
        count: usize,
    },
    /// An effect at a mass that the oscillator does not have.
    #[error("there is no mass \"{place}\" on the oscillator")]
    NoSuchMass {
        /// The place as written.
        place: String,
    },
    /// Something is hung at the contact of a structure that has none.
    #[error("a mass hangs at the contact, and the model has no contact")]
    NothingToHangAt,
    /// The mass matrix is not positive definite: something moves without inertia, and has no modes.
    #[error("the mass matrix is not positive definite: something moves without inertia")]
    NoInertia,
    /// Too many degrees of freedom for all modes.
    #[error("all modes of {size} degrees of freedom are requested; at most {most} are possible")]
    TooManyModes {
        /// Degrees of freedom.
        size: usize,
        /// The largest number allowed.
        most: usize,
    },
    /// A row or a matrix names a degree of freedom that is not there.
    #[error("degree of freedom {index} (counted from 0) of {size}")]
    NoSuchFreedom {
        /// The degree of freedom.
        index: usize,
        /// How many there are.
        size: usize,
    },
    /// A matrix that must be symmetric is not: one triangle may be missing.
    #[error("the {matrix} matrix is not symmetric: entries ({row}, {column}) and ({column}, {row}) differ")]
    NotSymmetric {
        /// Which matrix.
        matrix: &'static str,
        /// Row of an entry that differs from its mirror image, counted from 0.
        row: usize,
        /// Its column.
        column: usize,
    },
    /// Compliances cannot be computed by the method requested.
    #[error("the compliances cannot be computed by the {method} method: {reason}")]
    Unavailable {
        /// The method.
        method: &'static str,
        /// Why not.
        reason: &'static str,
    },
    /// Nothing holds a part of the structure in place: a constant force moves it without end.
    #[error(
        "{part} is not connected to the ground by springs, so its mean position is undetermined; \
         give it a spring, or ask for odd harmonics alone"
    )]
    FreeBody {
        /// The outputs that move with it.
        part: String,
    },
    /// An undamped structure is driven at a natural frequency.
    #[error(
        "the structure without its contacts has a natural frequency of {angular_frequency} rad/s and no \
         damping there: its response is unbounded"
    )]
    UndampedResonance {
        /// Angular frequency of the harmonic (rad/s).
        angular_frequency: f64,
    },
    /// The search for a natural frequency did not separate it from its neighbour.
    #[error("mode {mode} cannot be distinguished from its neighbour in double precision")]
    Unresolved {
        /// The mode, counted from 1.
        mode: usize,
    },
}
