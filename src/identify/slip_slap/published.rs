//! The published way to both forces: nonlinear modes (equations 14 to 20) and Galerkin's projection (equation 10).
//!
//! The bracket of the string's stretch has the wrong sign in equation 10 as printed; here all terms come from the rig's
//! energies. Of a stiff normal direction this way sees next to nothing: see [`PublishedSlipSlap::trusted`].

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector, Matrix2, Vector2};

use super::modal;
use crate::identify::inversion::{Bending, Structure};
use crate::identify::steady::Steady;
use crate::identify::{ContactPeriod, IdentificationError, SteadyMotion};
use crate::numeric::fourier::{coefficient_count, time_derivative};
use crate::system::{PinRig, PinRigModes};

/// Linear modes that the motion is expanded in, sensors permitting, and harmonics that make a nonlinear mode each.
const EXPANDED: usize = 3;
const TONES: [usize; 2] = [1, 3];
/// Harmonics that are kept of the forces.
const KEPT: usize = 5;
/// Normal motion of a nonlinear mode at the contact over its largest deflection, below which the projection does not see the
/// normal force.
const SEEN: f64 = 0.02;
/// Intervals along the beam in which a shape is told.
const PLACES: usize = 40;
/// Linear modes with less than this part of the largest amplitude have no phase to speak of.
const SMALL: f64 = 0.05;
/// Relative step of the assumed normal stiffness by which an echo is measured.
const STEP: f64 = 0.01;

/// What the published way finds in a dual-mode record.
#[derive(Debug, Clone, PartialEq)]
pub struct PublishedSlipSlap {
    /// Frequencies of the linear modes that the motion was expanded in (Hz).
    pub frequencies: Vec<f64>,
    /// Largest over smallest singular value of their shapes at the sensors (equation 16).
    pub conditioning: f64,
    /// The nonlinear modes of the first and the third harmonic.
    pub modes: [NonlinearMode; 2],
    /// Coefficients of the acceleration (m/s²) at the sensor nearest to the excitation: measured, and that of both modes.
    pub acceleration: [Vec<f64>; 2],
    /// Coefficients of S and N (N), up to the fifth harmonic; their means are not read.
    pub forces: [Vec<f64>; 2],
    /// Of ξ and η (m).
    pub displacements: [Vec<f64>; 2],
    /// Root mean square of the difference from the inverted S and N over those, means left out.
    pub difference: [f64; 2],
    /// By how many per cent η changes where the assumed normal stiffness is one per cent larger: −1 of a mere echo.
    pub echo: f64,
}

/// A nonlinear mode: linear modes in the proportions of one harmonic.
#[derive(Debug, Clone, PartialEq)]
pub struct NonlinearMode {
    /// Part of every linear mode (equation 20), signed.
    pub parts: Vec<f64>,
    /// Largest difference (rad) of a linear mode's phase from the common one.
    pub phase_scatter: f64,
    /// Positions (m) and its shape there (kg^-1/2).
    pub shape: Vec<[f64; 2]>,
    /// Its normal motion at the contact over its largest deflection.
    pub normal_ratio: f64,
    /// Coefficients of its coordinate (m √kg).
    pub coordinate: Vec<f64>,
}

impl PublishedSlipSlap {
    /// Whether both nonlinear modes move the contact across the beam enough for the projection to see the normal force.
    pub fn trusted(&self) -> bool {
        self.modes.iter().all(|mode| mode.normal_ratio.abs() >= SEEN)
    }
}

/// The published way to the forces in `record`, beside the inverted ones in `periods`.
pub(super) fn published(
    rig: &PinRig,
    record: &Steady,
    periods: [&ContactPeriod; 2],
) -> Result<PublishedSlipSlap, IdentificationError> {
    let mut found = expanded(rig, record)?;
    let mut stiffer = rig.clone();
    stiffer.stuck_stiffness[1] *= 1.0 + STEP;
    let norm = |values: &[f64]| values[1..].iter().map(|x| x * x).sum::<f64>().sqrt();
    let size = |found: &PublishedSlipSlap| norm(&found.displacements[1]);
    found.echo = (size(&expanded(&stiffer, record)?) / size(&found) - 1.0) / STEP;
    found.difference = [0, 1].map(|place| {
        let at = |k: usize| found.forces[place].get(k).copied().unwrap_or(0.0);
        let inverted = &periods[place].force;
        let off: Vec<f64> = inverted.iter().enumerate().map(|(k, force)| at(k) - force).collect();
        norm(&off) / norm(inverted)
    });
    Ok(found)
}

/// The linear modes that take part: their places among the rig's, and their shapes at the sensors.
struct Linear {
    places: Vec<usize>,
    shapes: DMatrix<f64>,
}

/// Expansion and projection, with nothing to compare them with yet.
fn expanded(rig: &PinRig, record: &Steady) -> Result<PublishedSlipSlap, IdentificationError> {
    let fail = |error: String| IdentificationError::Failed(error);
    let all = PinRigModes::new(rig, rig.beam.modes).map_err(|error| fail(error.to_string()))?;
    let modal = modal(rig, rig.beam.modes, &record.positions)?;
    let structure = Structure::from(&modal);
    let count = EXPANDED.min(record.positions.len());
    let places: Vec<usize> = all.beam_modes().into_iter().take(count).collect();
    if places.len() < TONES.len() {
        return Err(fail("the published way needs two sensors and two of the beam's own modes".to_owned()));
    }
    let shapes =
        DMatrix::from_fn(record.positions.len(), places.len(), |k, l| structure.sensors[k][places[l]]);
    let linear = Linear { places, shapes };
    let singular = linear.shapes.singular_values();
    let parts = TONES.map(|tone| linear.parts(&record.motion, tone));
    let coordinates = linear.coordinates(&record.motion, &parts)?;
    let bending = Bending::new(&structure, &record.motion, KEPT)?;
    let moved = linear.moved(&parts, &coordinates, modal.angular_frequency.len());
    let speed = record.motion.angular_frequency;
    let along = |shape: &[f64]| -> Vec<f64> {
        let sum = |k: usize| shape.iter().zip(&moved).map(|(shape, q)| shape * q[k]).sum();
        (0..moved[0].len()).map(sum).collect()
    };
    let mode = |place: usize| {
        let (parts, phase_scatter) = parts[place].clone();
        let deflection = |x: f64| -> f64 {
            let shapes = linear.places.iter().map(|mode| all.displacement(*mode, x).unwrap_or(0.0));
            parts.iter().zip(shapes).map(|(part, shape)| part * shape).sum()
        };
        let positions = (0..=PLACES).map(|k| rig.beam.length * k as f64 / PLACES as f64);
        let shape: Vec<[f64; 2]> = positions.map(|x| [x, deflection(x)]).collect();
        let largest = shape.iter().map(|[_, w]| w.abs()).fold(0.0, f64::max);
        let normal = linear.combined(&parts, &modal.normal_shape);
        let coordinate = coordinates[place].clone();
        NonlinearMode { parts, phase_scatter, shape, normal_ratio: normal / largest, coordinate }
    };
    Ok(PublishedSlipSlap {
        frequencies: linear.places.iter().map(|place| modal.angular_frequency[*place] / TAU).collect(),
        conditioning: singular.max() / singular.min(),
        acceleration: [
            record.motion.accelerations[record.nearest].clone(),
            time_derivative(&along(&structure.sensors[record.nearest]), 2, speed),
        ],
        forces: linear.projected(&bending, &parts, &moved),
        displacements: [0, 1].map(|place| bending.displacement(place, &moved, &bending.samples(&[]))),
        modes: [mode(0), mode(1)],
        difference: [0.0; 2],
        echo: 0.0,
    })
}

type Parts = (Vec<f64>, f64);

impl Linear {
    /// Signed parts of the linear modes in one harmonic of the acceleration (equations 16, 17 and 20), of unit norm, and the
    /// largest difference of their phases from the common one.
    fn parts(&self, motion: &SteadyMotion, harmonic: usize) -> Parts {
        let amplitude = |values: &Vec<f64>| {
            let pair = values.get(2 * harmonic - 1..=2 * harmonic);
            pair.map_or(Complex::default(), |pair| Complex::new(pair[0], -pair[1]))
        };
        let measured: Vec<Complex<f64>> = motion.accelerations.iter().map(amplitude).collect();
        let part = |of: fn(&Complex<f64>) -> f64| {
            let values = DVector::from_iterator(measured.len(), measured.iter().map(of));
            self.solved(&values)
        };
        let (real, imaginary) = (part(|a| a.re), part(|a| a.im));
        let amplitudes: Vec<Complex<f64>> =
            real.iter().zip(imaginary.iter()).map(|(re, im)| Complex::new(*re, *im)).collect();
        let square: Complex<f64> = amplitudes.iter().map(|a| a * a).sum();
        let turned: Vec<Complex<f64>> =
            amplitudes.iter().map(|a| a * Complex::from_polar(1.0, -0.5 * square.arg())).collect();
        let norm = turned.iter().map(|a| a.re * a.re).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        let largest = turned.iter().map(|a| a.norm()).fold(0.0, f64::max);
        let seen = turned.iter().filter(|a| a.norm() > SMALL * largest);
        let scatter = seen.map(|a| (a.im.abs() / a.re.abs()).atan()).fold(0.0, f64::max);
        (turned.iter().map(|a| a.re / norm).collect(), scatter)
    }

    /// By the pseudo-inverse of equation 16.
    fn solved(&self, measured: &DVector<f64>) -> DVector<f64> {
        let zero = || DVector::zeros(self.places.len());
        self.shapes.clone().svd(true, true).solve(measured, 1e-12).unwrap_or_else(|_| zero())
    }

    /// Coefficients of the coordinates of both nonlinear modes (equation 9), twice integrated, up to the harmonic kept.
    fn coordinates(
        &self,
        motion: &SteadyMotion,
        parts: &[Parts; 2],
    ) -> Result<[Vec<f64>; 2], IdentificationError> {
        let parts = DMatrix::from_fn(self.places.len(), 2, |l, i| parts[i].0[l]);
        let svd = (&self.shapes * parts).svd(true, true);
        let mut out = [vec![0.0; coefficient_count(KEPT)], vec![0.0; coefficient_count(KEPT)]];
        for k in 1..coefficient_count(KEPT) {
            let of = |sensor: usize| motion.accelerations[sensor].get(k).copied().unwrap_or(0.0);
            let measured = DVector::from_fn(motion.accelerations.len(), |sensor, _| of(sensor));
            let found = svd.solve(&measured, 1e-12);
            let found = found.map_err(|why| IdentificationError::Failed(why.to_owned()))?;
            let omega = k.div_ceil(2) as f64 * motion.angular_frequency;
            out.iter_mut().zip(found.iter()).for_each(|(out, a)| out[k] = -a / (omega * omega));
        }
        Ok(out)
    }

    /// Coefficients of all `count` modes of the rig.
    fn moved(&self, parts: &[Parts; 2], coordinates: &[Vec<f64>; 2], count: usize) -> Vec<Vec<f64>> {
        let mut moved = vec![vec![0.0; coordinates[0].len()]; count];
        for (l, place) in self.places.iter().enumerate() {
            for ((parts, _), coordinate) in parts.iter().zip(coordinates) {
                moved[*place].iter_mut().zip(coordinate).for_each(|(q, more)| *q += parts[l] * more);
            }
        }
        moved
    }

    /// What a nonlinear mode has of the rig's modes' `values`.
    fn combined(&self, parts: &[f64], values: &[f64]) -> f64 {
        parts.iter().zip(&self.places).map(|(part, place)| part * values[*place]).sum()
    }

    /// S and N at every instant from the projections on both nonlinear modes (equation 10), as harmonics.
    fn projected(&self, bending: &Bending, parts: &[Parts; 2], moved: &[Vec<f64>]) -> [Vec<f64>; 2] {
        let slopes = bending.slopes(moved);
        let known: Vec<Vec<f64>> =
            bending.without_contact(moved, &slopes).iter().map(|force| bending.samples(force)).collect();
        let directions = &bending.structure.directions;
        let mut forces = [vec![0.0; slopes[0].len()], vec![0.0; slopes[0].len()]];
        for k in 0..slopes[0].len() {
            let of = |i: usize, value: &dyn Fn(usize) -> f64| -> f64 {
                parts[i].0.iter().zip(&self.places).map(|(part, place)| part * value(*place)).sum()
            };
            let lever = |i: usize, d: usize| of(i, &|place| directions[d].lever(place, slopes[place][k]));
            let levers = Matrix2::from_fn(lever);
            let right = Vector2::from_fn(|i, _| -of(i, &|place| known[place][k]));
            let solved = levers.lu().solve(&right).unwrap_or_else(Vector2::zeros);
            forces.iter_mut().zip(solved.iter()).for_each(|(force, value)| force[k] = *value);
        }
        forces.map(|force| {
            let mut coefficients = bending.projected(&force);
            coefficients.truncate(coefficient_count(KEPT));
            coefficients
        })
    }
}
