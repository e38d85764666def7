//! Harmonic balance: periodic responses of structures with contacts.
//!
//! Displacements are sums of harmonics, bias and even harmonics included where symmetry does not exclude
//! them (the end of a bending beam moves inwards twice per cycle). The rooms, from below:
//!
//! - `period`: a contact over a period, coefficients of its displacement in, of its force out;
//! - `stability`: whether a small disturbance of a response dies out;
//! - `newton`: Newton's method on balance equations with conditions on top;
//! - `continuation`: a branch of solutions followed by its arc length;
//! - `balance`: the equations of a structure with its contacts;
//! - `response`: responses, curves, resonances; `modes`: free vibrations; `steady`: records of a beam.
//!
//! Coefficients are laid out `[a0, c1, s1, …, cH, sH]` per mode, mode after mode; see [`fourier`].

mod balance;
mod continuation;
mod error;
mod modal_system;
mod modes;
mod newton;
mod period;
mod response;
mod settings;
pub mod stability;
pub(crate) mod steady;

pub use crate::contact::LoadedContact;
pub use crate::numeric::{HarmonicSet, common_periods, excited_harmonics, fourier, whole_periods};
pub use balance::assembly::{Assembly, Control};
pub use balance::varied::AssemblyAt;
pub use continuation::Ending;
pub use error::HarmonicError;
pub use modes::{ModePoint, ModeRange, NonlinearMode, nonlinear_mode};
pub(crate) use modes::{mode_at, mode_at_rest, mode_near};
pub use newton::{Contacting, Point};
pub use period::CycleSummary;
pub use period::contact_cycle::{ContactCycle, ContactMapping, contact_cycle};
pub use response::dual::{DualTone, HeldTone, dual_tone_response};
pub use response::resonance::{Resonance, backbone, phase_resonance};
pub use response::sweep::{frequency_response, level_response, parameter_response, periodic_response};
pub use response::tracking::{TrackedQuantity, Tracking, track_levels, track_parameter};
pub use response::{Curve, Fold, Peak};
pub use settings::{CurveSettings, Interrupt, Method, UNRESOLVED};
