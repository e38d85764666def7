//! Exact modes of the Euler–Bernoulli beam divided at its point masses.
//!
//! "Nonlinear model identification of a frictional contact support", Mechanical Systems and Signal
//! Processing (received 2009), section 4: Eq. 5 is the beam between two masses, Eq. 6 its boundary
//! conditions, with the shear jumping by `ω² m w` at each mass and everything else continuous. The
//! paper writes the four parts of its beam as one determinant; here the parts are swept one after the
//! other (see `sweep`), which is the same characteristic equation in a form that stays
//! well conditioned beyond 40 modes.
//!
//! Two corrections to the print: Eq. 6's spring must read `EI w''(L) = −k_θ w'(L)` for `k_θ > 0` to be
//! restoring, and the orthonormality of Eq. A8 holds with the point masses included.

use std::f64::consts::PI;

use super::checks::{check_mechanics, check_mode_count};
use super::krylov::{State, krylov_duncan, scale};
use super::sweep::{Arrival, DividedBeam, Part, Triangle};
use crate::system::Beam;
use crate::system::StructureError;

/// Points and weights of the 8-point Gauss rule on (−1, 1), positive half. Over one piece of the
/// highest mode (phase 2) its error for a product of two modes is below 1e-13.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_48),
    (0.960_289_856_497_536_2, 0.101_228_536_290_376_26),
];

/// Steps allowed to a root search: halving alone needs about 55, the interpolation far fewer.
const MOST_STEPS: usize = 200;

/// Mass-normalised modes of a beam: `∫ ρA φᵢφⱼ dx + Σ m φᵢφⱼ = δᵢⱼ`.
///
/// Signs are fixed by a positive slope at x = L, which no mode lacks: a motion with
/// `w(L) = w'(L) = w''(L) = 0` grows away from the pin and meets no clamp.
#[derive(Debug, Clone, PartialEq)]
pub struct BeamModes {
    length: f64,
    angular_frequency: Vec<f64>,
    shapes: Vec<Shape>,
    shortening: Vec<f64>,
}

/// A mode as its states at the nodes of its own division of the beam.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::system) struct Shape {
    wave_number: f64,
    /// Node positions (fraction of the length) and states to the right of them; the last is x = L.
    nodes: Vec<(f64, State)>,
}

impl BeamModes {
    /// The first `count` modes of a validated beam.
    ///
    /// The beam's own `modes`, damping, sensors and excitation play no part.
    ///
    /// # Errors
    /// Values out of bounds as in [`ModalBeam::new`](crate::system::ModalBeam::new), or
    /// [`StructureError::Unresolved`] where double precision cannot separate two frequencies.
    pub fn new(beam: &Beam, count: usize) -> Result<Self, StructureError> {
        check_mechanics(beam)?;
        check_mode_count(count)?;
        let scales = Scales::of(beam)?;
        let divided = divide(beam, &scales);
        let tip = beam.rotational_stiffness * scales.rotational_flexibility;
        let mut angular_frequency = Vec::with_capacity(count);
        let mut shapes = Vec::with_capacity(count);
        let mut wave_number = 0.0;
        for mode in 1..=count {
            wave_number = divided.wave_number(mode, wave_number, tip)?;
            angular_frequency.push(scales.angular_frequency * wave_number * wave_number);
            shapes.push(Shape::new(&divided, wave_number, tip));
        }
        let mut shortening = normalise(&divided, wave_number, &mut shapes, &scales, |_| 0.0);
        shortening.iter_mut().for_each(|product| *product /= beam.length);
        Ok(Self { length: beam.length, angular_frequency, shapes, shortening })
    }

    /// ωᵢ (rad/s), ascending.
    pub fn angular_frequency(&self) -> &[f64] {
        &self.angular_frequency
    }

    /// φᵢ(x) (kg^-1/2); `mode` counts from 0, `x` (m) is taken into the beam if outside.
    ///
    /// `None` when there is no such mode.
    pub fn displacement(&self, mode: usize, x: f64) -> Option<f64> {
        Some(self.shapes.get(mode)?.at(x / self.length).0)
    }

    /// φᵢ'(x) (kg^-1/2 m^-1); arguments as for [`displacement`](Self::displacement).
    pub fn slope(&self, mode: usize, x: f64) -> Option<f64> {
        Some(self.shapes.get(mode)?.at(x / self.length).1 / self.length)
    }

    /// φᵢ'(L) of every mode (kg^-1/2 m^-1), positive.
    pub fn tip_slopes(&self) -> impl Iterator<Item = f64> + '_ {
        self.shapes.iter().map(|shape| shape.at(1.0).1 / self.length)
    }

    /// Gᵢⱼ = ∫ φᵢ' φⱼ' dx (1/(kg m)), row-major, as in Eq. 3.
    pub fn shortening(&self) -> &[f64] {
        &self.shortening
    }
}

/// What turns a beam with dimensions into one without.
#[derive(Debug, Clone, Copy)]
pub(in crate::system) struct Scales {
    /// √(EI/ρA)/L² (rad/s): ω = this · (βL)².
    pub angular_frequency: f64,
    /// L/EI (rad/(N m)).
    pub rotational_flexibility: f64,
    /// ρAL (kg).
    pub mass: f64,
}

impl Scales {
    pub fn of(beam: &Beam) -> Result<Self, StructureError> {
        let area = beam.width * beam.thickness;
        let bending = beam.youngs_modulus * area * beam.thickness * beam.thickness / 12.0;
        let per_length = beam.density * area;
        let computable = |quantity, value: f64| {
            if value.is_normal() { Ok(value) } else { Err(StructureError::NotComputable { quantity, value }) }
        };
        Ok(Self {
            angular_frequency: computable(
                "frequency scale",
                (bending / per_length).sqrt() / (beam.length * beam.length),
            )?,
            rotational_flexibility: computable("bending flexibility", beam.length / bending)?,
            mass: computable("mass", per_length * beam.length)?,
        })
    }
}

/// Divides the beam at its masses. Masses at one place add up; those at the ends do not move.
pub(in crate::system) fn divide(beam: &Beam, scales: &Scales) -> DividedBeam {
    let mut masses: Vec<(f64, f64)> = beam
        .point_masses
        .iter()
        .map(|point| (point.position / beam.length, point.mass / scales.mass))
        .filter(|&(position, _)| position > 0.0 && position < 1.0)
        .collect();
    masses.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut parts: Vec<Part> = Vec::with_capacity(masses.len() + 1);
    let mut start = 0.0;
    for (position, mass) in masses {
        match parts.last_mut() {
            Some(last) if position == start => last.end_mass += mass,
            _ => parts.push(Part { start, length: position - start, end_mass: mass }),
        }
        start = position;
    }
    parts.push(Part { start, length: 1.0 - start, end_mass: 0.0 });
    let clamp = beam.clamp_stiffness.map_or(f64::INFINITY, |value| value * scales.rotational_flexibility);
    DividedBeam { parts, clamp }
}

impl DividedBeam {
    /// One sweep without a visitor.
    pub fn arrive(&self, wave_number: f64) -> Arrival {
        self.sweep(wave_number, |_, _, _| {})
    }

    /// βL of mode `mode` (from 1), given that of the mode before (0 for the first).
    pub fn wave_number(&self, mode: usize, before: f64, tip: f64) -> Result<f64, StructureError> {
        // Masses only lower and springs only raise a frequency up to that of rigid ends, so the bare
        // clamped–clamped beam, (mode + 1/2)π and 0.018 more for the first, bounds it from above.
        let (mut low, mut high) = (before, (mode as f64 + 0.51) * PI);
        // Ends of an interval that holds this root alone, with the determinants there.
        let (mut below, mut above) = (None, None);
        let mut next = high;
        for _ in 0..MOST_STEPS {
            let arrival = self.arrive(next);
            let (count, determinant) = (arrival.count(tip), arrival.determinant(tip));
            if !determinant.is_finite() {
                break;
            }
            if count < mode {
                low = next;
                below = (count + 1 == mode).then_some((next, determinant));
            } else {
                high = next;
                above = (count == mode).then_some((next, determinant));
            }
            if let (Some(below), Some(above)) = (below, above) {
                return Ok(self.refine(tip, below, above));
            }
            next = 0.5 * (low + high);
            if next <= low || next >= high {
                break;
            }
        }
        Err(StructureError::Unresolved { mode })
    }

    /// The root between two wave numbers where the determinant has opposite signs (Chandrupatla 1997:
    /// inverse quadratic interpolation where it is safe, halving elsewhere).
    fn refine(&self, tip: f64, first: (f64, f64), second: (f64, f64)) -> f64 {
        let ((mut b, mut at_b), (mut a, mut at_a)) = (first, second);
        let (mut c, mut at_c);
        let mut fraction = 0.5;
        for _ in 0..MOST_STEPS {
            let x = a + fraction * (b - a);
            let at_x = self.arrive(x).determinant(tip);
            if (at_x < 0.0) == (at_a < 0.0) {
                (c, at_c) = (a, at_a);
            } else {
                (c, at_c) = (b, at_b);
                (b, at_b) = (a, at_a);
            }
            (a, at_a) = (x, at_x);
            let (best, at_best) = if at_a.abs() < at_b.abs() { (a, at_a) } else { (b, at_b) };
            let smallest = 2.0 * f64::EPSILON * best / (b - a).abs();
            if smallest > 0.5 || at_best == 0.0 {
                return best;
            }
            let (position, value) = ((a - b) / (c - b), (at_a - at_b) / (at_c - at_b));
            fraction = if value * value < position && (1.0 - value).powi(2) < 1.0 - position {
                let toward_b = at_a / (at_b - at_a) * at_c / (at_b - at_c);
                let toward_c = (c - a) / (b - a) * at_a / (at_c - at_a) * at_b / (at_c - at_b);
                (toward_b + toward_c).clamp(smallest, 1.0 - smallest)
            } else {
                0.5
            };
        }
        a
    }
}

impl Shape {
    /// The mode at a natural frequency, not yet normalised, with positive slope at the pin.
    fn new(divided: &DividedBeam, wave_number: f64, tip: f64) -> Self {
        Self::ending(divided, wave_number, |arrival| {
            let coefficients = arrival.mode_coefficients(tip);
            let mut end = arrival.basis.combine(coefficients);
            pin(&mut end, tip / scale(wave_number));
            // Spring and slope pull the same way, so this sign is sound for a free pin and a clamped end alike.
            let sign = (end[1] - end[2]).signum();
            (coefficients.map(|value| sign * value), end.map(|value| sign * value))
        })
    }

    /// The motion at a wave number with the coefficients of the basis at x = L, and the state there, that `end` gives.
    pub fn ending(
        divided: &DividedBeam,
        wave_number: f64,
        end: impl FnOnce(&Arrival) -> ([f64; 2], State),
    ) -> Self {
        let mut passed = Vec::new();
        let arrival =
            divided.sweep(wave_number, |start, basis, triangle| passed.push((start, *basis, *triangle)));
        let (mut coefficients, end) = end(&arrival);
        let mut nodes = vec![(1.0, end)];
        for (start, basis, Triangle([a, b, c])) in passed.into_iter().rev() {
            let second = coefficients[1] / c;
            coefficients = [(coefficients[0] - b * second) / a, second];
            nodes.push((start, basis.combine(coefficients)));
        }
        nodes.reverse();
        Self { wave_number, nodes }
    }

    /// Deflection and slope (per beam length) at a fraction of the length.
    pub fn at(&self, position: f64) -> (f64, f64) {
        let position = position.clamp(0.0, 1.0);
        let index = self.nodes.partition_point(|node| node.0 <= position).saturating_sub(1);
        let (start, [w, slope, curvature, third]) = self.nodes[index];
        let scale = scale(self.wave_number);
        let step = scale * (position - start);
        let ratio = (self.wave_number / scale).powi(4);
        let [k0, k1, k2, k3] = krylov_duncan(self.wave_number * (position - start));
        // Rows one and two of the transfer, nested so that no power is formed.
        let bent = step * (k2 * curvature + step * k3 * third);
        let turned = step * (k1 * curvature + step * k2 * third);
        (
            k0 * w + step * (k1 * slope + bent),
            scale * (k0 * slope + turned + ratio * step * step * step * k3 * w),
        )
    }
}

/// Rids the state at the pin of rounding: no deflection, and under a stiff spring the slope that its moment
/// leaves, which the sweep knows only as the difference of larger numbers.
fn pin(end: &mut State, spring: f64) {
    end[0] = 0.0;
    if spring > 1.0 {
        end[1] = -end[2] / spring;
    }
}

/// Gives every mode unit modal mass (kg, Eq. A8 with the point masses) and returns
/// ∫ φᵢ' φⱼ' over the fraction of the length (1/kg), row-major. `beside` is the modal mass of what is fixed to the end, as
/// a fraction of the beam's mass, of the mode that is counted from 0.
pub(in crate::system) fn normalise(
    divided: &DividedBeam,
    highest: f64,
    shapes: &mut [Shape],
    scales: &Scales,
    beside: impl Fn(usize) -> f64,
) -> Vec<f64> {
    let rule: Vec<(f64, f64)> = quadrature(divided, highest).collect();
    let mut slopes: Vec<Vec<f64>> = Vec::with_capacity(shapes.len());
    for (mode, shape) in shapes.iter_mut().enumerate() {
        let mut sampled = Vec::with_capacity(rule.len());
        let mut mass = beside(mode);
        for &(position, weight) in &rule {
            let (w, slope) = shape.at(position);
            mass += weight * w * w;
            sampled.push(weight.sqrt() * slope);
        }
        for part in divided.parts.iter().filter(|part| part.end_mass > 0.0) {
            let w = shape.at(part.start + part.length).0;
            mass += part.end_mass * w * w;
        }
        let factor = 1.0 / (mass * scales.mass).sqrt();
        for (_, state) in &mut shape.nodes {
            *state = state.map(|entry| factor * entry);
        }
        sampled.iter_mut().for_each(|slope| *slope *= factor);
        slopes.push(sampled);
    }
    let mut shortening = Vec::with_capacity(shapes.len() * shapes.len());
    for a in &slopes {
        shortening.extend(slopes.iter().map(|b| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>()));
    }
    shortening
}

/// Gauss points and weights over all pieces, fine enough for the highest wave number.
fn quadrature(divided: &DividedBeam, highest: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
    divided.parts.iter().flat_map(move |part| {
        let pieces = part.pieces(highest);
        let half = 0.5 * part.length / pieces as f64;
        (0..pieces).flat_map(move |piece| {
            let middle = part.start + (2 * piece + 1) as f64 * half;
            GAUSS.into_iter().flat_map(move |(point, weight)| {
                [(middle - half * point, half * weight), (middle + half * point, half * weight)]
            })
        })
    })
}
