//! The published way: motion expanded in the modes of the beam at that amplitude.

use std::f64::consts::TAU;

use super::Setup;
use crate::identify::steady::Steady;
use crate::identify::{ContactPeriod, expand};
use crate::numeric::fourier::time_derivative;
use crate::system::{Beam, ModalBeam, rotational_stiffness_from_frequency};

/// Modes that the force is balanced in, and those that the motion is expanded in, sensors permitting.
const BALANCED: usize = 2;
const EXPANDED: usize = 3;
/// Intervals along the beam in which a shape is told.
const PLACES: usize = 40;

/// What the published way finds in a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Rotational stiffness (N m/rad) that gives the beam the record's frequency.
    pub rotational_stiffness: f64,
    /// The beam's modes with it.
    pub modes: Vec<AmplitudeMode>,
    /// Largest over smallest singular value of the mode shapes at the sensors (equation 7).
    pub conditioning: f64,
    /// Coefficients of the acceleration (m/s²) at the sensor nearest to the excitation: measured, and that of the first two modes.
    pub acceleration: [Vec<f64>; 2],
    /// Coefficients of the contact's force (N), balanced in two modes.
    pub force: Vec<f64>,
    /// Root mean square of its difference from the inverted force over that force, means left out.
    pub difference: f64,
}

/// A mode of the beam at an amplitude.
#[derive(Debug, Clone, PartialEq)]
pub struct AmplitudeMode {
    /// Its frequency (Hz).
    pub frequency: f64,
    /// Positions (m) and its shape there (1/√kg), of unit modal mass.
    pub shape: Vec<[f64; 2]>,
    /// Coefficients of its coordinate in the record (m √kg).
    pub coordinate: Vec<f64>,
}

/// The published way to the force in `record`; `None` where the beam cannot have its frequency.
pub(super) fn published(setup: &Setup, record: &Steady, period: &ContactPeriod) -> Option<Published> {
    let with = |modes: usize, sensors: Vec<f64>| Beam { modes, sensors, ..setup.beam.clone() };
    let changed = with(EXPANDED, record.positions.clone()).changed(&setup.changes).ok()?;
    let rotational_stiffness = rotational_stiffness_from_frequency(&changed, record.frequency).ok()?;
    let harmonics = period.force.len() / 2;
    let of = |modes: usize| Beam {
        rotational_stiffness,
        modes: modes.min(record.positions.len()),
        ..changed.clone()
    };
    let balanced = expand(&of(BALANCED), &record.motion, harmonics).ok()?;
    let expanded = expand(&of(EXPANDED), &record.motion, harmonics).ok()?;
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let off = squares(&mut balanced.force.iter().zip(&period.force).skip(1).map(|(a, b)| a - b));
    let difference = (off / squares(&mut period.force.iter().skip(1).copied())).sqrt();
    Some(Published {
        rotational_stiffness,
        acceleration: accelerations(&of(EXPANDED), record, &expanded.modes)?,
        modes: modes(&of(EXPANDED), expanded.modes)?,
        conditioning: expanded.conditioning,
        force: balanced.force,
        difference,
    })
}

/// The modes of `beam` with their `coordinates`.
fn modes(beam: &Beam, coordinates: Vec<Vec<f64>>) -> Option<Vec<AmplitudeMode>> {
    let places: Vec<f64> = (0..=PLACES).map(|k| beam.length * k as f64 / PLACES as f64).collect();
    let plain = Beam { static_correction: false, sensors: places.clone(), ..beam.clone() };
    let modal = ModalBeam::new(&plain).ok()?;
    let mode = |(i, coordinate): (usize, Vec<f64>)| AmplitudeMode {
        frequency: modal.angular_frequency[i] / TAU,
        shape: places.iter().zip(&modal.sensors).map(|(x, sensor)| [*x, sensor.shape[i]]).collect(),
        coordinate,
    };
    Some(coordinates.into_iter().enumerate().map(mode).collect())
}

/// At the sensor nearest to the excitation: as measured, and as the first modes of `beam` have it.
fn accelerations(beam: &Beam, record: &Steady, coordinates: &[Vec<f64>]) -> Option<[Vec<f64>; 2]> {
    let plain = Beam { static_correction: false, ..beam.clone() };
    let modal = ModalBeam::new(&plain).ok()?;
    let far = |k: &usize| (record.positions[*k] - beam.excitation_position).abs();
    let nearest = (0..record.positions.len()).min_by(|a, b| far(a).total_cmp(&far(b)))?;
    let shape = &modal.sensors[nearest].shape;
    let parts = shape.iter().zip(coordinates).take(BALANCED);
    let mut moved = vec![0.0; coordinates.first()?.len()];
    parts.for_each(|(s, q)| moved.iter_mut().zip(q).for_each(|(w, q)| *w += s * q));
    let reconstructed = time_derivative(&moved, 2, record.motion.angular_frequency);
    Some([record.motion.accelerations[nearest].clone(), reconstructed])
}
