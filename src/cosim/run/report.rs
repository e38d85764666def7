//! The report of a run, and why it ended.

use crate::cosim::slave::{Severity, SlaveError};
use crate::cosim::system::Unwatched;
use crate::cosim::system::power::EnergyResidual;

/// The results of a run besides the values at its communication points.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Report {
    /// Time reached (s).
    pub time: f64,
    /// Communication steps done.
    pub steps: u64,
    /// Steps that were rejected and repeated with a shorter length.
    pub rejected: u64,
    /// How often loops were stepped, repetitions included.
    pub evaluations: u64,
    /// Steps accepted although a measure was beyond its tolerance, because they could not be shorter.
    pub forced: u64,
    /// Where the step is adapted: what was beyond its tolerance, and how often that rejected a step or would have; the
    /// most frequent first.
    pub limits: Vec<(String, u64)>,
    /// Steps whose repetition did not end within its tolerance.
    pub unconverged: u64,
    /// The first of them.
    pub examples: Vec<Unconverged>,
    /// One for each power connection.
    pub energy: Vec<EnergyResidual>,
    /// Couplings of two slaves whose energy residual is not known.
    pub unwatched: Vec<Unwatched>,
    /// Notes: what slaves cannot do, and how this changes the accuracy.
    pub notes: Vec<String>,
    /// The observer ended it.
    pub interrupted: bool,
}

/// A step whose repetition did not end within its tolerance; the best that was found is used.
#[derive(Debug, Clone, PartialEq)]
pub struct Unconverged {
    /// Beginning of the step (s).
    pub time: f64,
    /// Largest difference left between assumed and given values, relative to the largest of each so far.
    pub residual: f64,
    /// A slave of the loop.
    pub slave: String,
}

/// Why a run ended early.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("at {time} s: {cause}")]
pub struct RunError {
    /// Beginning of the step (s).
    pub time: f64,
    /// What happened.
    #[source]
    pub cause: Cause,
}

/// What ended a run.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// A slave failed.
    #[error(transparent)]
    Slave(#[from] SlaveError),
    /// A slave gave up on a step that cannot be repeated.
    #[error("{slave} gave up on the step at {reached} s, and the step cannot be repeated: {reason}")]
    GaveUp {
        /// The slave.
        slave: String,
        /// Time it reached (s).
        reached: f64,
        /// Why not.
        reason: String,
    },
    /// The coupling itself adds more than half of the energy that passes through it: the values are wrong.
    #[error(
        "the coupling of {force} and {motion} explodes: it has added {:.0} % of the energy that passed; try a shorter \
         step, or repeat each step until the values agree (strong coupling)",
        100.0 * .fraction
    )]
    Unstable {
        /// `slave.variable` that takes the force.
        force: String,
        /// `slave.variable` that takes the motion.
        motion: String,
        /// Energy added over the energy exchanged.
        fraction: f64,
    },
    /// The initial values do not agree.
    #[error(
        "the initial values of {} do not settle: they still change by {residual:e} of their size",
        .variables.join(", ")
    )]
    InitialLoop {
        /// Inputs of the loop, as `slave.variable`.
        variables: Vec<String>,
        /// Largest change left, relative to the size of each.
        residual: f64,
    },
}

impl Cause {
    /// How bad it is for the slaves.
    pub fn severity(&self) -> Severity {
        match self {
            Self::Slave(error) => error.severity,
            Self::GaveUp { .. } => Severity::Slave,
            Self::InitialLoop { .. } | Self::Unstable { .. } => Severity::Call,
        }
    }
}

/// A run that ended early: why, and its results so far. Points that the observer has received stay valid.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("{error}")]
pub struct Failure {
    /// Why.
    #[source]
    pub error: RunError,
    /// The run up to there.
    pub report: Box<Report>,
}

/// A communication point.
#[derive(Debug, Clone, Copy)]
pub struct Point<'a> {
    /// s
    pub time: f64,
    /// The step that ended here (s); 0 at the start.
    pub step: f64,
    /// Values in the order of [`Master::observed`](super::Master::observed).
    pub values: &'a [f64],
    /// Energy residuals so far, one for each power connection.
    pub energy: &'a [EnergyResidual],
}

/// What is reported at communication points.
#[derive(Debug, Clone, PartialEq)]
pub struct Observed {
    /// The slave's name.
    pub slave: String,
    /// The variable's name.
    pub variable: String,
    /// Its unit as the slave writes it.
    pub unit: Option<String>,
    /// What kind of number.
    pub kind: crate::cosim::Kind,
}
