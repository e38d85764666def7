//! Exact modes: the beam carried from its clamp to its end, and what is fixed there.
//!
//! At a frequency the beam resists its end's deflection and slope by a 2 × 2 dynamic stiffness; with that of what is fixed
//! there ([`End`]) it makes a 5 × 5 matrix that is singular at a natural frequency. Wittrick and Williams' count of the
//! frequencies below, that of the beam with its end held and the matrix's negative eigenvalues, finds each of them.

use std::f64::consts::PI;

use nalgebra::{Matrix2, Matrix5, Vector2};

use super::PinRig;
use super::end::{End, EndMotion, inertia};
use crate::system::StructureError;
use crate::system::beam::characteristic::{Scales, Shape, divide, normalise};
use crate::system::beam::sweep::{Arrival, DividedBeam};

/// Bisections; each halves the interval.
const BISECTIONS: usize = 200;

/// A mode is the beam's if so much of its kinetic energy is.
const BEAMS_OWN: f64 = 0.5;

/// Mass-normalised modes of the base linear system: beam, pin, string and a contact that is two springs.
///
/// Each has a positive slope at the end of the beam. Pendulum and bounce of the hanging mass are among them; by the
/// kinetic energy of the beam they are told from its own.
#[derive(Debug, Clone, PartialEq)]
pub struct PinRigModes {
    length: f64,
    angular_frequency: Vec<f64>,
    shapes: Vec<Shape>,
    ends: Vec<EndMotion>,
    shortening: Vec<f64>,
    beam_fraction: Vec<f64>,
}

/// The equations of the rig at its end.
struct Equations {
    divided: DividedBeam,
    scales: Scales,
    length: f64,
    /// EI/L³ (N/m).
    bending: f64,
    end: End,
}

impl PinRigModes {
    /// The first `count` modes.
    ///
    /// # Errors
    /// Values out of bounds; [`StructureError::Unresolved`] where double precision cannot separate two frequencies.
    pub fn new(rig: &PinRig, count: usize) -> Result<Self, StructureError> {
        rig.check(count)?;
        let equations = Equations::of(rig)?;
        let (mut angular_frequency, mut shapes, mut ends) = (Vec::new(), Vec::new(), Vec::new());
        let mut wave_number = 0.0;
        for mode in 1..=count {
            wave_number = equations.wave_number(mode, wave_number)?;
            let (shape, end) = equations.shape(wave_number).ok_or(StructureError::Unresolved { mode })?;
            angular_frequency.push(equations.scales.angular_frequency * wave_number * wave_number);
            shapes.push(shape);
            ends.push(end);
        }
        let Equations { divided, scales, end: fixed, .. } = &equations;
        let slope = |shape: &Shape| shape.at(1.0).1;
        let before: Vec<f64> = shapes.iter().map(slope).collect();
        let beside = |mode: usize| fixed.modal_mass(&ends[mode]) / scales.mass;
        let mut shortening = normalise(divided, wave_number, &mut shapes, scales, beside);
        shortening.iter_mut().for_each(|product| *product /= rig.beam.length);
        for ((end, shape), before) in ends.iter_mut().zip(&shapes).zip(before) {
            *end *= slope(shape) / before;
        }
        let beam_fraction = ends.iter().map(|end| 1.0 - fixed.modal_mass(end)).collect();
        Ok(Self { length: rig.beam.length, angular_frequency, shapes, ends, shortening, beam_fraction })
    }

    /// ωᵢ (rad/s), ascending.
    pub fn angular_frequency(&self) -> &[f64] {
        &self.angular_frequency
    }

    /// φᵢ(x) (kg^-1/2); `mode` counts from 0, `x` (m) is taken into the beam if outside. `None` when there is no such mode.
    pub fn displacement(&self, mode: usize, x: f64) -> Option<f64> {
        Some(self.shapes.get(mode)?.at(x / self.length).0)
    }

    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major.
    pub fn shortening(&self) -> &[f64] {
        &self.shortening
    }

    /// Fraction of each mode's kinetic energy that is the beam's and its masses'.
    pub fn beam_fraction(&self) -> &[f64] {
        &self.beam_fraction
    }

    /// The modes, counted from 0, whose kinetic energy is mostly the beam's.
    pub fn beam_modes(&self) -> Vec<usize> {
        (0..self.beam_fraction.len()).filter(|mode| self.beam_fraction[*mode] > BEAMS_OWN).collect()
    }

    /// What the end of the beam, and what is fixed there, does in each mode.
    pub(super) fn ends(&self) -> &[EndMotion] {
        &self.ends
    }
}

impl Equations {
    fn of(rig: &PinRig) -> Result<Self, StructureError> {
        let beam = &rig.beam;
        let scales = Scales::of(beam)?;
        let bending = beam.youngs_modulus * beam.width * beam.thickness.powi(3) / 12.0;
        Ok(Self {
            divided: divide(beam, &scales),
            scales,
            length: beam.length,
            bending: bending / beam.length.powi(3),
            end: End::of(rig),
        })
    }

    /// Deflection and slope (m and rad) at the end by the two motions that the clamp allows, by columns.
    fn kinematic(&self, arrival: &Arrival) -> Matrix2<f64> {
        let [a, b] = arrival.basis.0;
        let slope = arrival.scale / self.length;
        Matrix2::new(a[0], b[0], slope * a[1], slope * b[1])
    }

    /// The dynamic stiffness at the end.
    fn stiffness(&self, wave_number: f64, arrival: &Arrival) -> Option<Matrix5<f64>> {
        let omega = self.scales.angular_frequency * wave_number * wave_number;
        let mut matrix = self.end.stiffness - self.end.mass * (omega * omega);
        let ([a, b], s) = (arrival.basis.0, arrival.scale);
        let square = s * s;
        // Shear and moment that hold the end.
        let forces = Matrix2::new(
            -s * square * a[3],
            -s * square * b[3],
            self.length * square * a[2],
            self.length * square * b[2],
        );
        let of_beam = self.bending * forces * self.kinematic(arrival).try_inverse()?;
        let of_beam = 0.5 * (of_beam + of_beam.transpose());
        let mut corner = matrix.fixed_view_mut::<2, 2>(0, 0);
        corner += of_beam;
        Some(matrix)
    }

    /// Natural frequencies below a wave number.
    fn count(&self, wave_number: f64) -> Option<usize> {
        let arrival = self.divided.arrive(wave_number);
        let (negative, _) = inertia(&self.stiffness(wave_number, &arrival)?)?;
        Some(arrival.held_count + negative)
    }

    /// βL of mode `mode` (from 1), given that of the mode before (0 for the first).
    fn wave_number(&self, mode: usize, before: f64) -> Result<f64, StructureError> {
        // The beam with its end held bounds the frequencies from above.
        let (mut low, mut high) = (before, (mode as f64 + 0.51) * PI);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                break;
            }
            let count = self.count(middle).ok_or(StructureError::Unresolved { mode })?;
            *(if count < mode { &mut low } else { &mut high }) = middle;
        }
        Ok(0.5 * (low + high))
    }

    /// The mode at a natural frequency, not yet normalised, with positive slope at the end.
    fn shape(&self, wave_number: f64) -> Option<(Shape, EndMotion)> {
        let arrival = self.divided.arrive(wave_number);
        let (_, end) = inertia(&self.stiffness(wave_number, &arrival)?)?;
        let end = if end[1] < 0.0 { -end } else { end };
        let coefficients = self.kinematic(&arrival).try_inverse()? * Vector2::new(end[0], end[1]);
        let coefficients = [coefficients[0], coefficients[1]];
        let shape = Shape::ending(&self.divided, wave_number, |arrival| {
            (coefficients, arrival.basis.combine(coefficients))
        });
        Some((shape, end))
    }
}
