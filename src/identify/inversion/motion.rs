//! What was measured, and what is thought of the measuring chain.

/// What was measured in a steady state, by its harmonics.
#[derive(Debug, Clone, PartialEq)]
pub struct SteadyMotion {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Coefficients `[a0, c1, s1, …]` of the excitation (N).
    pub excitation: Vec<f64>,
    /// Standard error of each of these; 0 for what is certain.
    pub excitation_errors: Vec<f64>,
    /// Of the acceleration at each of the beam's sensors (m/s²), as many harmonics each; means are not read.
    pub accelerations: Vec<Vec<f64>>,
    /// Standard error of each of these.
    pub errors: Vec<Vec<f64>>,
}

/// What is thought of the measuring chain beforehand: standard deviations, 0 for what is certain.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Doubts {
    /// Of the load cell's gain (1).
    pub excitation_gain: f64,
    /// Of each accelerometer's gain (1).
    pub sensor_gain: f64,
    /// Of the mass at each sensor (kg).
    pub sensor_mass: f64,
    /// Of each coefficient of the contact's force (N): what keeps at zero what the records do not tell.
    pub force: f64,
}
