//! One periodic response: all that a solution of the balance says.

use crate::harmonic::stability::Undecided;

/// A contact at a point of a curve.
#[derive(Debug, Clone, PartialEq)]
pub struct Contacting {
    /// Energy the contact takes per cycle (J).
    pub dissipated_energy: f64,
    /// Slope of the loop from tip to tip (N/m); NaN where nothing moves.
    pub equivalent_stiffness: f64,
    /// Fraction of the period in stick; `None` for a law without a distinct stick.
    pub stick_fraction: Option<f64>,
    /// Coefficients `[a0, c1, s1, …]` of the contact's displacement (m).
    pub displacement: Vec<f64>,
    /// Coefficients `[a0, c1, s1, …]` of the restoring force (N).
    pub force: Vec<f64>,
}

/// One periodic response.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// Fundamental Ω (rad/s).
    pub angular_frequency: f64,
    /// Factor of the excitation; for an excitation of unit amplitude its amplitude (N).
    pub level: f64,
    /// Value of the parameter varied; 0 where there is none.
    pub parameter: f64,
    /// Largest magnitude of each node's displacement over a period (m).
    pub amplitude: Vec<f64>,
    /// Coefficients `[a0, c1, s1, …]` of each node's displacement (m).
    pub nodes: Vec<Vec<f64>>,
    /// The contacts.
    pub contacts: Vec<Contacting>,
    /// Work of the excitation per cycle (J).
    pub work: f64,
    /// Whether a small disturbance dies out; `None` where this was not requested or cannot be determined.
    pub stable: Option<bool>,
    /// Why stability cannot be determined; `None` where it was not requested or is known.
    pub undecided: Option<Undecided>,
    /// Estimated error of the displacements from the harmonics left out, as a fraction of the amplitude of
    /// the node it is largest at.
    pub error_estimate: f64,
    /// Whether `error_estimate` meets the requested tolerance, or [`UNRESOLVED`](crate::harmonic::UNRESOLVED) where
    /// none is. An unknown error (NaN) is not resolved.
    pub resolved: bool,
    /// Highest harmonic of the unknowns.
    pub harmonics: usize,
    /// Newton steps it took.
    pub iterations: usize,
}

impl Point {
    /// A place to look for a response: the contacts have these displacements (m), by coefficients.
    pub(crate) fn moved(angular_frequency: f64, displacements: Vec<Vec<f64>>) -> Self {
        let contact = |displacement: Vec<f64>| Contacting {
            dissipated_energy: 0.0,
            equivalent_stiffness: f64::NAN,
            stick_fraction: None,
            force: vec![0.0; displacement.len()],
            displacement,
        };
        Self {
            angular_frequency,
            level: 1.0,
            parameter: 0.0,
            amplitude: Vec::new(),
            nodes: Vec::new(),
            contacts: displacements.into_iter().map(contact).collect(),
            work: 0.0,
            stable: None,
            undecided: None,
            error_estimate: f64::NAN,
            resolved: false,
            harmonics: 0,
            iterations: 0,
        }
    }

    /// Amplitude of the first harmonic of each node's displacement (m).
    pub fn first_harmonic(&self) -> Vec<f64> {
        self.nodes.iter().map(|c| if c.len() > 2 { c[1].hypot(c[2]) } else { 0.0 }).collect()
    }

    /// Stores whether the point is stable, or why that cannot be determined.
    pub(crate) fn settle(&mut self, stable: Result<bool, Undecided>) {
        (self.stable, self.undecided) = (stable.ok(), stable.err());
    }

    /// Energy all contacts take per cycle (J).
    pub fn dissipated_energy(&self) -> f64 {
        self.contacts.iter().map(|contact| contact.dissipated_energy).sum()
    }
}
