//! From the clamp to the pin: all motions that satisfy the clamp, carried across the divided beam.
//!
//! At one frequency the motions that satisfy the boundary conditions at x = 0 form a plane in the
//! four-dimensional state. The sweep carries an orthonormal basis of that plane from piece to piece
//! (exact transfer, then Gram–Schmidt), so nothing grows however high the mode, and nothing cancels
//! however close two masses are. The characteristic determinant is what the pin makes of the basis at
//! x = L: free of poles, with simple zeros exactly at the natural frequencies.
//!
//! On the way the sweep counts the natural frequencies below the current one, as Wittrick and Williams
//! (1971) do: the negative eigenvalues of the dynamic stiffness, one node after the other. Pieces are
//! too short to have a clamped–clamped frequency of their own, so the count needs no second term. A
//! root search that keeps this count beside the determinant cannot miss a root, which finite-element
//! frequencies as brackets would not guarantee for close pairs.

use super::krylov::{LARGEST_PHASE, State, Transfer, scale};

/// A spring's condition `stiffness · slope + moment = 0` as two weights that stay finite for a rigid one.
fn spring_weights(stiffness: f64) -> (f64, f64) {
    if stiffness.is_infinite() {
        (1.0, 0.0)
    } else {
        (stiffness / (1.0 + stiffness), 1.0 / (1.0 + stiffness))
    }
}

/// A piece of the beam between two masses or ends; lengths as fractions of the beam's length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::system) struct Part {
    pub start: f64,
    pub length: f64,
    /// Mass at the far end as a fraction of the beam's mass.
    pub end_mass: f64,
}

impl Part {
    /// How many equal pieces make each short enough for a wave number.
    pub fn pieces(&self, wave_number: f64) -> usize {
        (wave_number * self.length / LARGEST_PHASE).ceil().max(1.0) as usize
    }
}

/// A beam without dimensions: length, bending stiffness and mass per length are one.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::system) struct DividedBeam {
    /// Parts in order, all of positive length, from 0 to 1.
    pub parts: Vec<Part>,
    /// Rotational spring at x = 0 (times L/EI); infinite for a rigid clamp.
    pub clamp: f64,
}

/// An orthonormal basis of the motions the clamp allows, at one section.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) struct Basis(pub [State; 2]);

/// The triangle with which Gram–Schmidt made a basis: `old = new · [[a, b], [0, c]]`.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) struct Triangle(pub [f64; 3]);

fn dot(a: &State, b: &State) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

impl Basis {
    fn at_clamp(clamp: f64, scale: f64) -> Self {
        // w = 0 and curvature = clamp · slope; the third derivative is free.
        let (slope_weight, moment_weight) = spring_weights(clamp / scale);
        let (basis, _) = Self([[0.0, moment_weight, slope_weight, 0.0], [0.0, 0.0, 0.0, 1.0]]).orthonormal();
        basis
    }

    /// Gram–Schmidt with positive diagonal, which keeps the orientation and thus every sign.
    fn orthonormal(self) -> (Self, Triangle) {
        let Self([mut first, mut second]) = self;
        let a = dot(&first, &first).sqrt();
        first = first.map(|entry| entry / a);
        let b = dot(&first, &second);
        for (entry, direction) in second.iter_mut().zip(first) {
            *entry -= b * direction;
        }
        let c = dot(&second, &second).sqrt();
        (Self([first, second.map(|entry| entry / c)]), Triangle([a, b, c]))
    }

    /// The 2×2 determinant of deflection and slope: no motion vanishes here unless it is zero.
    fn kinematic_determinant(&self) -> f64 {
        let Self([first, second]) = self;
        first[0] * second[1] - second[0] * first[1]
    }

    /// The motion with this pair of coefficients.
    pub fn combine(&self, [a, b]: [f64; 2]) -> State {
        let Self([first, second]) = self;
        std::array::from_fn(|row| a * first[row] + b * second[row])
    }
}

/// Result of one sweep: the reduced problem at the pin.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) struct Arrival {
    /// Natural frequencies below this one if the pin's rotation were held as well.
    pub held_count: usize,
    /// The motions the clamp allows, at x = 1.
    pub basis: Basis,
    pub scale: f64,
}

impl Arrival {
    /// What the pin's spring (times L/EI) leaves over for each basis vector: zero where satisfied.
    fn spring_residual(&self, tip: f64) -> [f64; 2] {
        let (slope_weight, moment_weight) = spring_weights(tip / self.scale);
        self.basis.0.map(|state| slope_weight * state[1] + moment_weight * state[2])
    }

    /// The characteristic determinant with a spring `tip` at the pin; at most one in size.
    pub fn determinant(&self, tip: f64) -> f64 {
        let [first, second] = self.spring_residual(tip);
        let Basis([a, b]) = &self.basis;
        a[0] * second - b[0] * first
    }

    /// Natural frequencies below this one with a spring `tip` at the pin.
    pub fn count(&self, tip: f64) -> usize {
        let agrees = (self.determinant(tip) < 0.0) == (self.basis.kinematic_determinant() < 0.0);
        self.held_count + usize::from(!agrees)
    }

    /// Coefficients of the motion that does not deflect at the pin and best satisfies its spring.
    pub fn mode_coefficients(&self, tip: f64) -> [f64; 2] {
        let deflection = self.basis.0.map(|state| state[0]);
        let spring = self.spring_residual(tip);
        let size = |[a, b]: [f64; 2]| a.hypot(b);
        // Both rows are equivalent at a natural frequency: take the larger one.
        let [a, b] = if size(deflection) >= size(spring) { deflection } else { spring };
        [b, -a]
    }

    /// Slope and curvature at the pin (in units of 1/L and 1/L²) of the one motion that does not deflect.
    pub fn slope_and_curvature_without_deflection(&self) -> (f64, f64) {
        let Basis([a, b]) = &self.basis;
        let state = self.basis.combine([b[0], -a[0]]);
        (state[1] * self.scale, state[2] * self.scale * self.scale)
    }
}

impl DividedBeam {
    /// Sweeps at a wave number; `visit` sees each piece's start, the basis there and the triangle at its end.
    pub fn sweep(&self, wave_number: f64, mut visit: impl FnMut(f64, &Basis, &Triangle)) -> Arrival {
        let scale = scale(wave_number);
        // ω² m w is the jump of the shear at a mass; here per unit of scaled deflection.
        let inertia = wave_number * (wave_number / scale).powi(3);
        let mut basis = Basis::at_clamp(self.clamp, scale);
        let mut held_count = 0;
        let mut at_clamp = true;
        for part in &self.parts {
            let pieces = part.pieces(wave_number);
            let length = part.length / pieces as f64;
            let transfer = Transfer::new(wave_number, length);
            for piece in 0..pieces {
                let Basis([first, second]) = basis;
                let mut next = Basis([transfer.apply(&first), transfer.apply(&second)]);
                if !at_clamp {
                    held_count += negative_eigenvalues(&basis, &next, &transfer);
                }
                at_clamp = false;
                if piece + 1 == pieces {
                    for state in &mut next.0 {
                        state[3] += inertia * part.end_mass * state[0];
                    }
                }
                let (next, triangle) = next.orthonormal();
                visit(part.start + piece as f64 * length, &basis, &triangle);
                basis = next;
            }
        }
        Arrival { held_count, basis, scale }
    }
}

/// Negative eigenvalues of the dynamic stiffness of one node (deflection and slope), all nodes before it
/// free and the next one held: the transfer matrix's way to a step of a block LDLᵀ factorisation.
fn negative_eigenvalues(before: &Basis, after: &Basis, transfer: &Transfer) -> usize {
    let determinant = before.kinematic_determinant();
    if (determinant < 0.0) != (after.kinematic_determinant() < 0.0) {
        return 1;
    }
    // Both or none: the diagonal entry of the deflection decides. To the right, the shear that moves a
    // node whose far side is held; to the left, that of the motion w = 1, w' = 0 the clamp allows.
    let [u0, u1, u2, u3] = transfer.upper;
    let right = (u1 * u0 - u2 * transfer.lower[3]) / (u2 * u2 - u1 * u3);
    let Basis([a, b]) = before;
    let left = (a[3] * b[1] - b[3] * a[1]) / determinant;
    if right - left < 0.0 { 2 } else { 0 }
}
