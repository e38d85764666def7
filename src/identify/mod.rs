//! What a contact did, from measurements of the structure that it supports: no law is assumed.
//!
//! Steady records come in, the contact's force and motion over a period go out, with what could not be identified. The stages,
//! each a function of its own:
//!
//! - `harmonics`: coefficients of a record's channels, with their noise (equations 8 and 9 of the paper); `steady`: those of all
//!   channels of steady records;
//! - `inversion`: the force that makes the linear beam move as measured, and the contact's displacement under it;
//! - `expansion`: the published way to the same, in two modes;
//! - `laws`: contact laws fitted at some levels and predicted at the others; `measured`: the map itself as one;
//!   `weights`: what they may leave;
//! - `spectra`, `poles`, `resonance`: frequency responses, linear modes, and one resonance from a few points;
//! - `stiffness`: of the pin rig's contact, from natural frequencies;
//! - `identification`: all of them, from a model and a dataset;
//! - `slip_slap`: both forces of a contact in two directions, of the pin rig under dual-mode excitation.
//!
//! Source: "Nonlinear model identification of a frictional contact support", Mechanical Systems and Signal Processing
//! (received 2009).

mod expansion;
mod harmonics;
mod identification;
mod inversion;
mod laws;
mod measured;
mod poles;
mod resonance;
mod slip_slap;
mod spectra;
mod steady;
mod stiffness;
mod weights;

pub use expansion::{Expansion, expand};
pub use harmonics::{Harmonics, harmonics};
pub use identification::{
    AmplitudeMode, ContactRecord, Identification, IdentifyOptions, Level, LevelResponse, LevelSource,
    LinearRecord, ModeCount, Published, Unidentified, identify,
};
pub use inversion::{ContactPeriod, Doubts, Inversion, SteadyMotion, invert, invert_slip_slap};
pub use laws::{IdentifiedLaw, IdentifiedParameter, fit_law, force_under};
pub use measured::tabulate;
pub use poles::{Pole, poles};
pub use resonance::{ResonanceFit, resonance_of};
pub use slip_slap::{
    Coupling, LoopSlopes, NonlinearMode, PublishedSlipSlap, SlipSlapIdentification, SlipSlapRecord,
    identify_slip_slap,
};
pub use spectra::{FrequencyResponse, frequency_response_of};
pub use stiffness::{ContactStiffness, Estimate, MeasuredFrequencies, beam_frequencies, contact_stiffness};

/// Standard errors of a 95 % interval.
const WIDE: f64 = 1.96;

/// Why nothing was identified.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum IdentificationError {
    /// The model, the options or the records do not serve.
    #[error("{0}")]
    Failed(String),
    /// A record that laws were to be fitted to could not be used.
    #[error("laws cannot be fitted to `{record}`: {reason}")]
    NotIdentified {
        /// Its name in the dataset.
        record: String,
        /// What stood in the way.
        reason: String,
    },
}
