//! The seam between the equations of a structure with contacts and what follows their solutions.

use nalgebra::DMatrix;

use super::HarmonicError;

/// Numbers besides the Fourier coefficients on which the balance depends.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Operating {
    /// Fundamental Ω (rad/s).
    pub angular_frequency: f64,
    /// Factor of the excitation's coefficients.
    pub level: f64,
    /// ζ of the artificial negative damping `−2 ζ Ω M q̇` that sustains a free vibration (extended periodic
    /// motion concept, Krack 2015); 0 under excitation.
    pub self_excitation: f64,
    /// Value of the model's parameter being varied, if the system has one.
    pub parameter: f64,
}

/// One of the numbers of [`Operating`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    AngularFrequency,
    Level,
    SelfExcitation,
    Parameter,
}

/// Displacement harmonic of an output, and its derivatives.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Observation {
    /// Cosine and sine coefficient (m); of the bias only the first counts.
    pub value: [f64; 2],
    /// Their derivatives by the unknowns.
    pub by_unknowns: [Vec<f64>; 2],
    /// Their derivatives by the scalars, in the order angular frequency, level, self-excitation, parameter.
    pub by_scalars: [[f64; 4]; 2],
}

/// Balance equations `r(x; operating) = 0` with their derivatives, in buffers of their own.
pub(crate) trait PeriodicSystem {
    /// Number of unknowns and of equations.
    fn unknowns(&self) -> usize;

    /// Evaluates residual and derivatives, by `scalars` too. Returns the size of the terms that make up
    /// the residual, to judge it by.
    fn evaluate(&mut self, x: &[f64], at: &Operating, scalars: &[Scalar]) -> Result<f64, HarmonicError>;

    /// Residual of the last evaluation.
    fn residual(&self) -> &[f64];

    /// ∂residual/∂unknowns of the last evaluation.
    fn jacobian(&self) -> &DMatrix<f64>;

    /// ∂residual/∂scalar of the last evaluation; valid for the scalars it was asked for.
    fn by(&self, scalar: Scalar) -> &[f64];

    /// Displacement harmonic `order` of output `node` at the last evaluation.
    fn observe(&mut self, node: usize, order: usize, out: &mut Observation);

    /// Makes the next evaluation depend on its arguments alone.
    fn forget(&mut self);
}
