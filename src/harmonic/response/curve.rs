//! Response curves: what is known along them.

use crate::harmonic::continuation::Ending;
use crate::harmonic::newton::Point;

/// A local maximum of a node's amplitude along a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Which node.
    pub node: usize,
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// Amplitude there (m): largest magnitude over a period.
    pub amplitude: f64,
    /// Level there.
    pub level: f64,
}

/// A turning point of a curve: what is followed (frequency, level) goes back there.
#[derive(Debug, Clone, PartialEq)]
pub struct Fold {
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// Level there.
    pub level: f64,
    /// Each node's amplitude there (m): largest magnitude over a period.
    pub amplitude: Vec<f64>,
}

/// Periodic responses along a curve, in the order they were followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Curve {
    /// Names of the nodes.
    pub nodes: Vec<String>,
    /// The points; with turning points the frequency runs back and forth.
    pub points: Vec<Point>,
    /// Peaks of every node between the ends, located to the solver's accuracy.
    pub peaks: Vec<Peak>,
    /// Turning points between the ends, located to the solver's accuracy.
    pub folds: Vec<Fold>,
    /// How it ended.
    pub ending: Ending,
}
