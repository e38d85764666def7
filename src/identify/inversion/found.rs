//! What an inversion finds.

use nalgebra::{DMatrix, DVector};

use crate::identify::WIDE;
use crate::numeric::fourier::{value, work_per_cycle};

/// The contact over a period of each record, and the measuring chain.
#[derive(Debug, Clone, PartialEq)]
pub struct Inversion {
    /// The contact along the beam, in the order of the records.
    pub periods: Vec<ContactPeriod>,
    /// The contact across the beam in the same records: of a rig whose contact slaps, otherwise empty.
    pub normal: Vec<ContactPeriod>,
    /// Logarithm of what the load cell shows over what there is (1), and its standard error.
    pub excitation_gain: [f64; 2],
    /// The same of every accelerometer.
    pub sensor_gains: Vec<[f64; 2]>,
    /// Mass at every sensor beyond that of the beam's description (kg), and its standard error.
    pub sensor_masses: Vec<[f64; 2]>,
    /// Largest over smallest singular value of the weighted equations.
    pub conditioning: f64,
    /// Root mean square of what remains, over what the errors let expect.
    pub misfit: f64,
}

/// The contact over a period, in one direction.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactPeriod {
    /// Fundamental (rad/s).
    pub angular_frequency: f64,
    /// Coefficients of the restoring force (N).
    pub force: Vec<f64>,
    /// Their covariance (N²), all doubts included.
    pub covariance: DMatrix<f64>,
    /// Coefficients of the contact's own displacement (m), the flexibility in series taken off.
    pub displacement: Vec<f64>,
    /// Their covariance (m²), all doubts included.
    pub displacement_covariance: DMatrix<f64>,
    /// Covariance of each of these (rows) with each coefficient of the force (m N).
    pub cross_covariance: DMatrix<f64>,
    /// Of its velocity (m/s).
    pub velocity: Vec<f64>,
    /// Modal coordinates (m √kg), mode after mode.
    pub modes: Vec<Vec<f64>>,
    /// Accelerations that the force does not explain, as a fraction of the measured ones.
    pub unexplained: f64,
}

impl ContactPeriod {
    /// Displacement (m), velocity (m/s) and force (N) at `time` (s), counted as in the record.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let phase = self.angular_frequency * time;
        [&self.displacement, &self.velocity, &self.force].map(|coefficients| value(coefficients, phase))
    }

    /// Standard errors of force (N), displacement (m) and velocity (m/s), root mean square over the period, means left out.
    pub fn deviations(&self) -> [f64; 3] {
        // Over a period each harmonic's variance counts by half.
        let deviation = |covariance: &DMatrix<f64>, order: i32| {
            let faster = |k: usize| (k.div_ceil(2) as f64 * self.angular_frequency).powi(2 * order);
            let variance = (1..covariance.nrows()).map(|k| 0.5 * covariance[(k, k)] * faster(k)).sum::<f64>();
            variance.max(0.0).sqrt()
        };
        let displacement = &self.displacement_covariance;
        [deviation(&self.covariance, 0), deviation(displacement, 0), deviation(displacement, 1)]
    }

    /// Energy that the contact takes in a period (J).
    pub fn work(&self) -> f64 {
        work_per_cycle(&self.force, &self.displacement)
    }

    /// Its standard error.
    pub fn work_deviation(&self) -> f64 {
        // It is linear in the force and in the displacement.
        let along = |count: usize, of: &dyn Fn(&[f64]) -> f64| {
            let unit = |k: usize| (0..count).map(|i| f64::from(u8::from(i == k))).collect::<Vec<f64>>();
            DVector::from_fn(count, |k, _| of(&unit(k)))
        };
        let by_force = along(self.force.len(), &|unit| work_per_cycle(unit, &self.displacement));
        let by_displacement = along(self.displacement.len(), &|unit| work_per_cycle(&self.force, unit));
        let both = by_displacement.dot(&(&self.cross_covariance * &by_force));
        let variance = by_force.dot(&(&self.covariance * &by_force))
            + by_displacement.dot(&(&self.displacement_covariance * &by_displacement))
            + 2.0 * both;
        variance.max(0.0).sqrt()
    }

    /// Energy that the contact gives in a period (J), where it gives any for sure (95 %).
    pub fn given(&self) -> Option<f64> {
        let given = -self.work();
        (given > WIDE * self.work_deviation()).then_some(given)
    }
}
