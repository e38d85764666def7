//! The contact in all steady records: receptances inverted, and the published way beside it.

use nalgebra::DMatrix;

use super::steady::Steady;
use super::{Identification, IdentifyOptions, Setup};
use crate::identify::{ContactPeriod, Doubts, IdentificationError, SteadyMotion, expand, invert};
use crate::numeric::fourier::{time_derivative, value};
use crate::system::{Beam, ModalBeam, rotational_stiffness_from_frequency};

/// Modes of the published way.
const MODES: usize = 2;
/// Standard errors of a 95 % interval.
pub(super) const WIDE: f64 = 1.96;
/// Accelerations left unexplained, as a part of the measured ones, and over what noise lets expect, that call for a warning.
const UNEXPLAINED: f64 = 0.05;

/// The contact in one steady record; its period is that of the inversion at the same place.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRecord {
    /// Name of the record.
    pub name: String,
    /// Frequency of the excitation (Hz).
    pub frequency: f64,
    /// Amplitude of the acceleration at the excitation (m/s²), first harmonic.
    pub amplitude: f64,
    /// Amplitude of the excitation (N), first harmonic.
    pub force: f64,
    /// Harmonics that stand out of the noise in some channel.
    pub harmonics: usize,
    /// Half-widths of the 95 % intervals of force (N), displacement (m) and velocity (m/s), root mean square over the period,
    /// means left out.
    pub intervals: [f64; 3],
    /// The published way, where the beam can have this frequency.
    pub published: Option<Published>,
    /// What to know beside it.
    pub warnings: Vec<String>,
}

/// The contact's force by the published way: two modes of the amplitude.
#[derive(Debug, Clone, PartialEq)]
pub struct Published {
    /// Coefficients of the force (N).
    pub force: Vec<f64>,
    /// Largest over smallest singular value of the mode shapes at the sensors.
    pub conditioning: f64,
    /// Root mean square of its difference from the inverted force over that force, means left out.
    pub difference: f64,
}

impl ContactPeriod {
    /// Displacement (m), velocity (m/s) and force (N) at `time` (s), counted as in the record.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let phase = self.angular_frequency * time;
        [&self.displacement, &self.velocity, &self.force].map(|coefficients| value(coefficients, phase))
    }
}

/// Inverts `steady` and fills in what it tells.
pub(super) fn identify_contact(
    setup: &Setup,
    steady: &[Steady],
    options: &IdentifyOptions,
    found: &mut Identification,
) -> Result<(), IdentificationError> {
    let beam = Beam { sensors: steady[0].positions.clone(), ..setup.beam.clone() };
    let fail = |error: crate::system::StructureError| IdentificationError(error.to_string());
    let modal = ModalBeam::with_changes(&beam, &setup.changes).map_err(fail)?;
    let doubts = Doubts {
        excitation_gain: options.excitation_gain,
        sensor_gain: options.sensor_gain,
        sensor_mass: options.sensor_mass,
        // A mean force is bounded by friction.
        force: setup.normal_load,
    };
    let motions: Vec<SteadyMotion> = steady.iter().map(|record| record.motion.clone()).collect();
    let harmonics = motions[0].excitation.len() / 2;
    let inversion = invert(&modal, &motions, harmonics, &doubts)?;
    let two = Beam { modes: MODES.min(beam.sensors.len()), ..beam };
    for (record, period) in steady.iter().zip(&inversion.periods) {
        found.records.push(ContactRecord {
            name: record.name.clone(),
            frequency: record.frequency,
            amplitude: record.amplitude,
            force: record.force(),
            harmonics: record.shown,
            intervals: intervals(period),
            published: published(setup, &two, record, period),
            warnings: warnings(period, inversion.misfit),
        });
    }
    if steady.len() == 1 {
        found.warnings.push(
            "One level alone: nothing tells gains of the measuring chain from the force, and no prediction can be checked."
                .to_owned(),
        );
    }
    found.inversion = Some(inversion);
    Ok(())
}

fn intervals(period: &ContactPeriod) -> [f64; 3] {
    // Over a period each harmonic's variance counts by half.
    let wide = |covariance: &DMatrix<f64>, order: i32| {
        let faster = |k: usize| (k.div_ceil(2) as f64 * period.angular_frequency).powi(2 * order);
        let variance = (1..covariance.nrows()).map(|k| 0.5 * covariance[(k, k)] * faster(k)).sum::<f64>();
        WIDE * variance.max(0.0).sqrt()
    };
    let displacement = &period.displacement_covariance;
    [wide(&period.covariance, 0), wide(displacement, 0), wide(displacement, 1)]
}

fn published(setup: &Setup, two: &Beam, record: &Steady, period: &ContactPeriod) -> Option<Published> {
    let changed = two.changed(&setup.changes).ok()?;
    let rotational_stiffness = rotational_stiffness_from_frequency(&changed, record.frequency).ok()?;
    let beam = Beam { rotational_stiffness, ..changed };
    let found = expand(&beam, &record.motion, period.force.len() / 2).ok()?;
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let off = squares(&mut found.force.iter().zip(&period.force).skip(1).map(|(a, b)| a - b));
    let difference = (off / squares(&mut period.force.iter().skip(1).copied())).sqrt();
    Some(Published { force: found.force, conditioning: found.conditioning, difference })
}

fn warnings(period: &ContactPeriod, misfit: f64) -> Vec<String> {
    let mut out = Vec::new();
    if period.unexplained > UNEXPLAINED && misfit > 2.0 {
        out.push(format!(
            "no force at the contact explains {:.1} % of the accelerations: the beam's model does not fit",
            100.0 * period.unexplained
        ));
    }
    let work = work(period);
    if work < 0.0 {
        out.push(format!("the contact gives {:.2e} J a period: phases of the channels do not fit", -work));
    }
    out
}

/// Energy that the contact takes in a period (J).
pub(super) fn work(period: &ContactPeriod) -> f64 {
    let velocity = time_derivative(&period.displacement, 1, 1.0);
    let count = period.force.len().min(velocity.len());
    std::f64::consts::PI * (1..count).map(|k| period.force[k] * velocity[k]).sum::<f64>()
}
