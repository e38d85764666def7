//! Numerical methods without physics, for every layer above.
//!
//! Linear equations: [`lu`] (dense factors), [`elimination`] (small systems that may be singular),
//! [`gmres`] (iterations with a product alone), `nonnegative` (least squares). Signals over a period: [`fourier`], the harmonics a signal may have
//! ([`HarmonicSet`]), products ([`multiplication`]), where it is largest ([`extremum`]), between samples (`band_limited`), their lines under a window (`spectrum`), and how many periods a record holds ([`periods`]). Roots:
//! [`bracket`]. Statistics: [`student`], [`random`]. Matrices: [`exponential`], [`balancing`]. Implicit derivatives: [`implicit`].

pub(crate) mod balancing;
#[cfg(feature = "analysis")]
pub(crate) mod band_limited;
pub(crate) mod bracket;
pub(crate) mod elimination;
pub(crate) mod exponential;
pub(crate) mod extremum;
pub mod fourier;
pub(crate) mod gmres;
mod harmonic_set;
pub(crate) mod implicit;
pub(crate) mod lu;
pub(crate) mod multiplication;
#[cfg(feature = "analysis")]
pub(crate) mod nonnegative;
mod periods;
pub(crate) mod random;
#[cfg(feature = "analysis")]
pub(crate) mod spectrum;
pub(crate) mod student;

/// A product of views with strides needs more rows, columns and terms than this: up to here nalgebra 0.35 takes their columns for
/// slices, and reads and writes beyond them (its issue 1616).
#[cfg(feature = "analysis")]
pub(crate) const SMALL_PRODUCT: usize = 5;

pub use harmonic_set::HarmonicSet;
pub use periods::{common_periods, excited_harmonics, whole_periods};
