//! A uniform Euler–Bernoulli segment vibrating harmonically, exactly.

use nalgebra::{Matrix4, Vector4};

/// Below this wave number × length the exact coefficients cancel (they are quotients of numbers of the
/// order λ⁴) and the cubic element, whose error is of the order λ⁸, is the more accurate one.
const CUBIC_BELOW: f64 = 0.08;

/// A segment of the beam between two masses.
#[derive(Debug, Clone, Copy)]
pub(super) struct Segment {
    /// Where it begins (m from the clamp).
    pub(super) start: f64,
    /// Its length (m).
    pub(super) length: f64,
    /// EI (N m²).
    pub(super) bending_stiffness: f64,
    /// ρA (kg/m).
    pub(super) mass_per_length: f64,
}

impl Segment {
    /// β with β⁴ = ω² ρA/EI (1/m).
    pub(super) fn wave_number(&self, omega: f64) -> f64 {
        (omega * omega * self.mass_per_length / self.bending_stiffness).powf(0.25)
    }

    /// Forces (shear, moment at both ends) per unit (w₁, θ₁, w₂, θ₂) at angular frequency `omega` (rad/s).
    ///
    /// Numerator and denominator are multiplied by 2 exp(−λ), so that nothing overflows.
    pub(super) fn dynamic_stiffness(&self, omega: f64) -> Matrix4<f64> {
        let beta = self.wave_number(omega);
        let lambda = beta * self.length;
        if lambda < CUBIC_BELOW {
            let (stiffness, mass) = self.cubic_element();
            return stiffness - mass * (omega * omega);
        }
        let (sin, cos) = lambda.sin_cos();
        let decay = (-lambda).exp();
        let (cosh, sinh) = (1.0 + decay * decay, 1.0 - decay * decay); // both × 2 exp(−λ)
        let scale = self.bending_stiffness * beta / (2.0 * decay - cos * cosh);
        let shear = scale * beta * beta * (cos * sinh + sin * cosh);
        let coupling = scale * beta * sin * sinh;
        let far_shear = -scale * beta * beta * (2.0 * decay * sin + sinh);
        let far_coupling = scale * beta * (cosh - 2.0 * decay * cos);
        let moment = scale * (sin * cosh - cos * sinh);
        let far_moment = scale * (sinh - 2.0 * decay * sin);
        Matrix4::new(
            shear,
            coupling,
            far_shear,
            far_coupling, //
            coupling,
            moment,
            -far_coupling,
            far_moment, //
            far_shear,
            -far_coupling,
            shear,
            -coupling, //
            far_coupling,
            far_moment,
            -coupling,
            moment,
        )
    }

    /// Stiffness and consistent mass of the Hermite cubic element.
    pub(super) fn cubic_element(&self) -> (Matrix4<f64>, Matrix4<f64>) {
        let l = self.length;
        let stiffness = Matrix4::new(
            12.0,
            6.0 * l,
            -12.0,
            6.0 * l, //
            6.0 * l,
            4.0 * l * l,
            -6.0 * l,
            2.0 * l * l, //
            -12.0,
            -6.0 * l,
            12.0,
            -6.0 * l, //
            6.0 * l,
            2.0 * l * l,
            -6.0 * l,
            4.0 * l * l,
        ) * (self.bending_stiffness / l.powi(3));
        let mass = Matrix4::new(
            156.0,
            22.0 * l,
            54.0,
            -13.0 * l, //
            22.0 * l,
            4.0 * l * l,
            13.0 * l,
            -3.0 * l * l, //
            54.0,
            13.0 * l,
            156.0,
            -22.0 * l, //
            -13.0 * l,
            -3.0 * l * l,
            -22.0 * l,
            4.0 * l * l,
        ) * (self.mass_per_length * l / 420.0);
        (stiffness, mass)
    }

    /// How many natural frequencies of the segment with both ends clamped lie below `omega`.
    pub(super) fn clamped_count(&self, omega: f64) -> usize {
        let lambda = self.wave_number(omega) * self.length;
        let half_waves = (lambda / std::f64::consts::PI).floor();
        let even = half_waves.rem_euclid(2.0) == 0.0;
        // Sign of 1 − cosh λ cos λ, without the overflow of cosh.
        let decay = (-lambda).exp();
        let positive = 2.0 * decay - lambda.cos() * (1.0 + decay * decay) >= 0.0;
        let correction = match (even, positive) {
            (true, true) | (false, false) => 0.0,
            _ => 1.0,
        };
        (half_waves - correction).max(0.0) as usize
    }

    /// The deflection inside that goes with the end values (w₁, θ₁, w₂, θ₂).
    pub(super) fn shape(&self, omega: f64, ends: Vector4<f64>) -> SegmentShape {
        let beta = self.wave_number(omega);
        let lambda = beta * self.length;
        if lambda < CUBIC_BELOW {
            return SegmentShape { segment: *self, basis: Basis::Cubic, factors: ends };
        }
        let (sin, cos) = lambda.sin_cos();
        let decay = (-lambda).exp();
        let matrix = Matrix4::new(
            1.0, 0.0, 1.0, decay, //
            0.0, 1.0, -1.0, decay, //
            cos, sin, decay, 1.0, //
            -sin, cos, -decay, 1.0,
        );
        let scaled = Vector4::new(ends[0], ends[1] / beta, ends[2], ends[3] / beta);
        // The basis is independent for λ > 0, so the matrix has an inverse.
        let factors = matrix.lu().solve(&scaled).unwrap_or_else(Vector4::zeros);
        SegmentShape { segment: *self, basis: Basis::Exact { beta }, factors }
    }
}

/// Deflection along a [`Segment`].
#[derive(Debug, Clone, Copy)]
pub(super) struct SegmentShape {
    pub(super) segment: Segment,
    basis: Basis,
    factors: Vector4<f64>,
}

#[derive(Debug, Clone, Copy)]
enum Basis {
    /// cos βx, sin βx, exp(−βx), exp(−β(l − x)).
    Exact { beta: f64 },
    /// Hermite cubics; the factors are the end values.
    Cubic,
}

impl SegmentShape {
    /// Deflection and slope at `x` (m from the segment's start).
    pub(super) fn at(&self, x: f64) -> (f64, f64) {
        let length = self.segment.length;
        let (values, slopes) = match self.basis {
            Basis::Exact { beta } => {
                let (sin, cos) = (beta * x).sin_cos();
                let (near, far) = ((-beta * x).exp(), (-beta * (length - x)).exp());
                (Vector4::new(cos, sin, near, far), Vector4::new(-sin, cos, -near, far) * beta)
            }
            Basis::Cubic => {
                let s = x / length;
                let bump = s * (1.0 - s);
                (
                    Vector4::new(
                        (1.0 - s) * (1.0 - s) * (1.0 + 2.0 * s),
                        length * s * (1.0 - s) * (1.0 - s),
                        s * s * (3.0 - 2.0 * s),
                        -length * s * s * (1.0 - s),
                    ),
                    Vector4::new(
                        -6.0 * bump / length,
                        (1.0 - s) * (1.0 - 3.0 * s),
                        6.0 * bump / length,
                        s * (3.0 * s - 2.0),
                    ),
                )
            }
        };
        (self.factors.dot(&values), self.factors.dot(&slopes))
    }
}
