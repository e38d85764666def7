//! What an inversion finds.

use nalgebra::DMatrix;

/// The contact over a period of each record, and the measuring chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Inversion {
    /// In the order of the records.
    pub periods: Vec<ContactPeriod>,
    /// Logarithm of what the load cell shows over what there is (1), and its standard error.
    pub excitation_gain: [f64; 2],
    /// The same of every accelerometer.
    pub sensor_gains: Vec<[f64; 2]>,
    /// Mass at every sensor beyond that of the beam's description (kg), and its standard error.
    pub sensor_masses: Vec<[f64; 2]>,
    /// Largest over smallest singular value of the weighted equations.
    pub conditioning: f64,
    /// Root mean square of what remains, over what the errors let expect.
    pub misfit: f64,
}

/// The contact over a period.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPeriod {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Coefficients of the restoring force (N).
    pub force: Vec<f64>,
    /// Their covariance (N²), all doubts included.
    pub covariance: DMatrix<f64>,
    /// Coefficients of the contact's own displacement (m), the flexibility in series taken off.
    pub displacement: Vec<f64>,
    /// Their covariance (m²), all doubts included.
    pub displacement_covariance: DMatrix<f64>,
    /// Covariance of each of these (rows) with each coefficient of the force (m N).
    pub cross_covariance: DMatrix<f64>,
    /// Of its velocity (m/s).
    pub velocity: Vec<f64>,
    /// Modal coordinates (m √kg), mode after mode.
    pub modes: Vec<Vec<f64>>,
    /// Accelerations that the force does not explain, as a fraction of the measured ones.
    pub unexplained: f64,
}
