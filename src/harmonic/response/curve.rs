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
    /// Value of the parameter there, of a curve over one.
    pub parameter: f64,
}

/// A turning point of a curve: what is followed (frequency, level, parameter) goes back there.
#[derive(Debug, Clone, PartialEq)]
pub struct Fold {
    /// Ω (rad/s).
    pub angular_frequency: f64,
    /// Level there.
    pub level: f64,
    /// Value of the parameter there, of a curve over one.
    pub parameter: f64,
    /// Each node's amplitude there (m): largest magnitude over a period.
    pub amplitude: Vec<f64>,
}

/// Periodic responses along a curve, in the order they were followed.
///
/// ```
/// use stickslip::prelude::*;
/// # let model = Model::parse(
/// #     r#"
/// #     schema = "stickslip.model/1"
/// #     kind = "oscillator"
/// #     mass = [{ name = "m1", mass = 1.0 }]
/// #     spring = [{ between = ["ground", "m1"], stiffness = 9.0, damping = 0.1 }]
/// #     contact = { at = "m1", law = "jenkins", tangential_stiffness = 7.0, friction_coefficient = 0.5, normal_load = 2.0 }
/// #     "#,
/// # )?;
/// let system = Assembly::new(model.system()?);
/// let curve =
///     frequency_response(&system, 2.0, 5.0, &Control::Level(2.0), &CurveSettings::default(), &mut |_| true)?;
/// let m1 = curve.nodes.iter().position(|name| name == "m1").expect("the mass is a node");
/// let peak = curve.peaks.iter().find(|peak| peak.node == m1).expect("it has a resonance");
/// let largest = curve.points.iter().map(|point| point.amplitude[m1]).fold(0.0, f64::max);
/// assert!(peak.amplitude >= largest * (1.0 - 1e-9)); // located between the points
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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

impl Curve {
    /// Nothing yet: points come in, and the ending changes where it is another.
    pub(crate) fn empty(nodes: Vec<String>) -> Self {
        Self { nodes, points: Vec::new(), peaks: Vec::new(), folds: Vec::new(), ending: Ending::Complete }
    }
}
