//! The seam between the equations of a structure with contacts and what follows their solutions.

use nalgebra::DMatrix;

use crate::harmonic::HarmonicError;
use crate::harmonic::newton::Point;
use crate::harmonic::stability::Undecided;
use crate::system::System;

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

impl Operating {
    /// Excitation at `level` and `angular_frequency` (rad/s).
    pub fn forced(angular_frequency: f64, level: f64) -> Self {
        Self { angular_frequency, level, self_excitation: 0.0, parameter: 0.0 }
    }

    /// The numbers in the order of [`Scalar`].
    pub fn scalars(&self) -> [f64; 4] {
        [self.angular_frequency, self.level, self.self_excitation, self.parameter]
    }

    /// One of the numbers.
    pub fn get(&self, scalar: Scalar) -> f64 {
        self.scalars()[scalar.index()]
    }

    /// Sets one of the numbers.
    pub fn set(&mut self, scalar: Scalar, value: f64) {
        match scalar {
            Scalar::AngularFrequency => self.angular_frequency = value,
            Scalar::Level => self.level = value,
            Scalar::SelfExcitation => self.self_excitation = value,
            Scalar::Parameter => self.parameter = value,
        }
    }
}

/// One of the numbers of [`Operating`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    AngularFrequency,
    Level,
    SelfExcitation,
    Parameter,
}

impl Scalar {
    /// Place in arrays of the four.
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// Displacement harmonic of an output, and its derivatives.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Observation {
    /// Cosine and sine coefficient (m); of the bias only the first counts.
    pub value: [f64; 2],
    /// Their derivatives by the unknowns.
    pub by_unknowns: [Vec<f64>; 2],
    /// Their derivatives by the scalars, in the order angular frequency, level, self-excitation, parameter.
    /// By the self-excitation and the parameter they are valid where the last evaluation was asked for them.
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
    fn jacobian(&mut self) -> &DMatrix<f64>;

    /// ∂residual/∂scalar of the last evaluation; valid for the scalars it was asked for, once the Jacobian was.
    fn by(&self, scalar: Scalar) -> &[f64];

    /// Cosine and sine coefficient (m) of output `node` in harmonic `order` at the last evaluation; zeros for a harmonic
    /// that the system has not.
    fn output(&mut self, node: usize, order: usize) -> [f64; 2];

    /// As [`PeriodicSystem::output`], with derivatives.
    fn observe(&mut self, node: usize, order: usize, out: &mut Observation);

    /// Makes the next evaluation depend on its arguments alone.
    fn forget(&mut self);

    /// Number of outputs.
    fn nodes(&self) -> usize;

    /// Highest harmonic of the unknowns.
    fn harmonics(&self) -> usize;

    /// Writes a start for Newton's method at `at`: equivalent linearisation, or what the system has.
    fn guess(&mut self, at: &Operating, x: &mut [f64]) -> Result<(), HarmonicError>;

    /// Size of the residual, as a fraction of its largest term, below which it is rounding at `at`: what the structure is
    /// condensed by is only as good as its condition allows. Leaves the last evaluation alone.
    fn rounding(&mut self, at: &Operating) -> f64 {
        let _ = at;
        0.0
    }

    /// Puts a spring of so many of the contacts' own compliances between each contact and the structure, on the way
    /// to a start; 0 takes it away. A contact then is as strong as ever and no stiffer than the spring. False where
    /// the system cannot.
    fn compliance_homotopy(&mut self, compliances: f64) -> bool {
        let _ = compliances;
        false
    }

    /// The response of the last evaluation, which was at `x` and `at` and solved the balance: everything of
    /// a [`Point`] but stability, error and effort, which are left as unknown, 0, resolved and 0.
    fn describe(&mut self, x: &[f64], at: &Operating) -> Result<Point, HarmonicError>;

    /// Derivatives of the nodes' coefficients (those of [`Point::nodes`]) where the unknowns change by
    /// `unknowns` and the scalars by `scalars`, at the last evaluation or, as Newton's factors, at the last one whose
    /// Jacobian was asked for.
    fn nodes_along(&mut self, unknowns: &[f64], scalars: &[f64; 4], out: &mut [Vec<f64>]) {
        let mut seen = Observation::default();
        for (node, coefficients) in out.iter_mut().enumerate() {
            coefficients.clear();
            coefficients.resize(2 * self.harmonics() + 1, 0.0);
            for (place, coefficient) in coefficients.iter_mut().enumerate() {
                let (order, part) = (place.div_ceil(2), usize::from(place > 0 && place % 2 == 0));
                if part == 0 {
                    self.observe(node, order, &mut seen);
                }
                let along: f64 = seen.by_unknowns[part].iter().zip(unknowns).map(|(a, b)| a * b).sum();
                let rest: f64 = seen.by_scalars[part].iter().zip(scalars).map(|(a, b)| a * b).sum();
                *coefficient = along + rest;
            }
        }
    }

    /// Estimated error of the nodes' displacements from the harmonics left out, as a fraction of the amplitude of
    /// the node it is largest at, at the solution `x`, `point` last evaluated. `solve` turns a residual into
    /// `(∂residual/∂unknowns)⁻¹ residual` in place. 0 where the system has no estimate.
    fn truncation_error(
        &mut self,
        x: &[f64],
        at: &Operating,
        point: &Point,
        solve: &mut dyn FnMut(&mut [f64]),
    ) -> Result<f64, HarmonicError> {
        let _ = (x, at, point, solve);
        Ok(0.0)
    }

    /// Changes the highest harmonic and carries `vectors` of unknowns over; false, with nothing changed,
    /// where the system cannot.
    fn set_harmonics(
        &mut self,
        harmonics: usize,
        vectors: &mut [&mut Vec<f64>],
    ) -> Result<bool, HarmonicError> {
        let _ = (harmonics, vectors);
        Ok(false)
    }

    /// Takes the laws and normal loads of `system`, which is this one but for those.
    fn replace_laws(&mut self, system: &System) -> Result<(), HarmonicError>;

    /// Writes the unknowns of a known response; false where it does not determine them.
    fn resume(&self, point: &Point, x: &mut [f64]) -> bool {
        let _ = (point, x);
        false
    }

    /// Whether a small disturbance of `point`, the solution last evaluated, dies out, or why that cannot be determined.
    fn stable(&mut self, point: &Point) -> Result<bool, Undecided> {
        let _ = point;
        Err(Undecided::NoResponse)
    }
}
