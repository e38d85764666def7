//! Newton's method on balance equations with conditions on top.
//!
//! In comes a [`PeriodicSystem`](system::PeriodicSystem), residual and Jacobian over Fourier coefficients and a few
//! scalars ([`Operating`](system::Operating)), and as many [`condition`]s as there are free scalars; out goes a
//! solution ([`problem`]), and what it says about the response: a [`Point`].

pub(crate) mod condition;
mod point;
pub(crate) mod problem;
pub(crate) mod system;

pub use point::{Contacting, Point};
