//! What the three kinds of experiment have in common.

use crate::records::record::{Record, Regime};
use crate::rigs::effect::Hidden;

/// An experiment: a true system, and what is done to it.
pub trait Rig {
    /// The records that ideal instruments would take.
    fn respond(&self) -> Vec<Record>;

    /// The parameters that a fit of the base model may change, all above zero.
    fn base(&self) -> Vec<f64>;

    /// The same experiment with other values of [`Rig::base`].
    fn with_base(&self, values: &[f64]) -> Box<dyn Rig>;

    /// The same experiment with nothing hidden.
    fn plain(&self) -> Box<dyn Rig>;

    /// The model file of an engineer who knows of nothing hidden and is off in the base parameters by the
    /// factors `off`.
    fn model(&self, off: &[f64]) -> String;

    /// Factors by which an engineer's base parameters are off.
    fn ignorance(&self) -> Vec<f64>;

    /// What is hidden, with its parameters.
    fn hidden(&self) -> &[Hidden];

    /// Whether the dataset file tells the standard deviation of the noise of records that begin so.
    fn tells_noise(&self, regime: Regime) -> bool;
}
