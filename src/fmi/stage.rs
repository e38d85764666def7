//! The stages of a simulation, and its frame.

/// Where an instance is in a simulation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Stage {
    /// New or reset: parameters and inputs may be set.
    Instantiated = 0,
    /// Between [`enter_initialization`](super::Instance::enter_initialization) and
    /// [`exit_initialization`](super::Instance::exit_initialization).
    Initialization = 1,
    /// Ready for the next step.
    StepComplete = 2,
    /// The last step failed; the state is that before it.
    StepFailed = 3,
    /// The simulation is over.
    Terminated = 4,
    /// Between continuous times, where the importer integrates.
    Event = 5,
    /// The importer integrates.
    ContinuousTime = 6,
}

impl Stage {
    /// Every stage.
    pub const ALL: [Self; 7] = [
        Self::Instantiated,
        Self::Initialization,
        Self::StepComplete,
        Self::StepFailed,
        Self::Terminated,
        Self::Event,
        Self::ContinuousTime,
    ];

    pub(super) fn from_number(number: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|stage| *stage as u32 == number)
    }
}

/// The frame of a simulation.
///
/// ```
/// use stickslip::fmi::Setup;
/// let setup = Setup { stop: Some(0.2), ..Setup::default() };
/// assert_eq!((setup.start, setup.tolerance), (0.0, None));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Setup {
    /// Relative tolerance of the integration inside; 1e-6 where absent.
    pub tolerance: Option<f64>,
    /// Start (s).
    pub start: f64,
    /// Stop (s); no step may go beyond.
    pub stop: Option<f64>,
}
