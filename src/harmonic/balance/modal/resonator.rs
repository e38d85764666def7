//! A resonator as the dynamic stiffness that it has at its port: no unknowns of its own.

use std::ops::Range;

use nalgebra::{Complex, DMatrix};

use crate::harmonic::newton::system::{Operating, Scalar};

/// Least dynamic stiffness of a resonator whose port is held, as a fraction of its spring: where nothing damps it there
/// is a harmonic at which it holds the port.
const LEAST: f64 = 1e-12;

/// A mass on a spring, at the unknowns of its port.
#[derive(Debug, Clone)]
pub(super) struct Resonator {
    pub rows: Range<usize>,
    mass: f64,
    stiffness: f64,
    damping: f64,
}

impl Resonator {
    /// At `rows`, of a mass (kg) with the natural frequency (rad/s) and damping ratio.
    pub fn new(rows: Range<usize>, mass: f64, angular_frequency: f64, damping_ratio: f64) -> Self {
        let stiffness = mass * angular_frequency * angular_frequency;
        Self { rows, mass, stiffness, damping: 2.0 * damping_ratio * angular_frequency * mass }
    }

    /// k (N/m).
    pub fn stiffness(&self) -> f64 {
        self.stiffness
    }

    /// Natural frequency (rad/s), the port held and undamped.
    pub fn natural(&self) -> f64 {
        (self.stiffness / self.mass).sqrt()
    }

    /// Dynamic stiffness of the mass and its damper, without the spring, in harmonic `order`.
    fn of_mass(&self, at: &Operating, order: usize) -> Complex<f64> {
        let speed = order as f64 * at.angular_frequency;
        let sustained = 2.0 * at.self_excitation * at.angular_frequency * self.mass;
        Complex::new(-self.mass * speed * speed, (self.damping - sustained) * speed)
    }

    /// That of mass and spring, the port held.
    fn held(&self, of_mass: Complex<f64>) -> Complex<f64> {
        let held = self.stiffness + of_mass;
        if held.norm() > LEAST * self.stiffness { held } else { Complex::from(LEAST * self.stiffness) }
    }

    /// Displacement of the mass over that of the port in harmonic `order`, as `c − i s`.
    pub fn transmitted(&self, at: &Operating, order: usize) -> Complex<f64> {
        self.stiffness / self.held(self.of_mass(at, order))
    }

    /// Force (N) over displacement (m) of the port in harmonic `order`, as `c − i s`.
    pub fn dynamic_stiffness(&self, at: &Operating, order: usize) -> Complex<f64> {
        let of_mass = self.of_mass(at, order);
        self.stiffness * of_mass / self.held(of_mass)
    }

    /// ∂[`Self::dynamic_stiffness`]/∂`scalar`; zero where it does not depend on it.
    fn rate(&self, at: &Operating, order: usize, scalar: Scalar) -> Complex<f64> {
        let (order_here, speed) = (order as f64, order as f64 * at.angular_frequency);
        let of_mass = match scalar {
            Scalar::AngularFrequency => {
                let sustained = 4.0 * at.self_excitation * at.angular_frequency * self.mass;
                Complex::new(-2.0 * self.mass * speed, self.damping - sustained) * order_here
            }
            Scalar::SelfExcitation => Complex::new(0.0, -2.0 * self.mass * at.angular_frequency * speed),
            Scalar::Level | Scalar::Parameter => return Complex::from(0.0),
        };
        let transmitted = self.transmitted(at, order);
        of_mass * transmitted * transmitted
    }

    /// Coefficients of the coordinate of unit mass up to harmonic `highest`, the port moving by the coefficients `u`.
    pub fn coordinate(&self, at: &Operating, u: &[f64], highest: usize) -> Vec<f64> {
        let root = self.mass.sqrt();
        let mut coefficients = vec![root * u[0]];
        for (place, pair) in u[1..].chunks_exact(2).take(highest).enumerate() {
            let moved = root * self.transmitted(at, place + 1) * Complex::new(pair[0], -pair[1]);
            coefficients.extend([moved.re, -moved.im]);
        }
        coefficients
    }

    /// Work (J) per cycle that its damper takes from a motion of its port by the coefficients `u`.
    pub fn lost(&self, at: &Operating, u: &[f64]) -> f64 {
        let pairs = u[1..].chunks_exact(2).enumerate();
        let power = pairs.map(|(place, pair)| {
            let order = place + 1;
            self.dynamic_stiffness(at, order).im * order as f64 * (pair[0] * pair[0] + pair[1] * pair[1])
        });
        std::f64::consts::PI * power.sum::<f64>()
    }

    /// Adds the force for the unknowns `x` of all ports.
    pub fn act(&self, at: &Operating, x: &[f64], forces: &mut [f64]) {
        self.add(x, forces, |order| self.dynamic_stiffness(at, order));
    }

    /// Adds ∂force/∂`scalar` at fixed unknowns `x`.
    pub fn add_rates(&self, at: &Operating, scalar: Scalar, x: &[f64], rates: &mut [f64]) {
        self.add(x, rates, |order| self.rate(at, order, scalar));
    }

    fn add(&self, x: &[f64], to: &mut [f64], factor: impl Fn(usize) -> Complex<f64>) {
        for (order, c) in self.rows.clone().skip(1).step_by(2).enumerate() {
            let moved = factor(order + 1) * Complex::new(x[c], -x[c + 1]);
            to[c] += moved.re;
            to[c + 1] -= moved.im;
        }
    }

    /// Adds ∂forces/∂unknowns.
    pub fn differentiate(&self, at: &Operating, matrix: &mut DMatrix<f64>) {
        for (order, c) in self.rows.clone().skip(1).step_by(2).enumerate() {
            let Complex { re, im } = self.dynamic_stiffness(at, order + 1);
            matrix[(c, c)] += re;
            matrix[(c + 1, c + 1)] += re;
            matrix[(c, c + 1)] += im;
            matrix[(c + 1, c)] -= im;
        }
    }
}
