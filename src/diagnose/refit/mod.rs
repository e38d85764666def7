//! Joint refits: a model with unknowns comes in, the parameters that fit all records best go out, with intervals.
//!
//! [`trial`] is the fit; [`prediction_covariance`] follows the uncertainty of its parameters into predictions of other records.

pub(super) mod prediction_covariance;
pub(super) mod trial;
