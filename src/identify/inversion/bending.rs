//! One record's beam in bending: forces in, modes out.

use nalgebra::{Complex, DMatrix, DVector};

use super::found::ContactPeriod;
use super::motion::SteadyMotion;
use crate::identify::IdentificationError;
use crate::numeric::fourier::{Basis, coefficient_count, time_derivative};
use crate::system::{ModalBeam, Sensor};

/// One record's beam in bending: forces in, modes out.
pub(in crate::identify) struct Bending<'p> {
    pub beam: &'p ModalBeam,
    pub motion: &'p SteadyMotion,
    /// Harmonics of the modes.
    pub kept: usize,
    basis: Basis,
}

impl<'p> Bending<'p> {
    pub fn new(
        beam: &'p ModalBeam,
        motion: &'p SteadyMotion,
        harmonics: usize,
    ) -> Result<Self, IdentificationError> {
        let SteadyMotion { accelerations, errors, .. } = motion;
        let kept = accelerations.iter().map(|a| a.len() / 2).max().unwrap_or(0).max(harmonics);
        let sensors = beam.sensors.len();
        let alike = accelerations.iter().zip(errors).all(|(a, e)| a.len() == e.len() && a.len() > 2);
        if accelerations.len() != sensors || errors.len() != sensors || !alike {
            return Err(IdentificationError::Failed(format!(
                "{sensors} accelerations are needed, with an error each"
            )));
        }
        // A product of force and slope has the harmonics of both.
        Ok(Self { beam, motion, kept, basis: Basis::new(kept, 8 * (kept + 1)) })
    }

    pub fn samples(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.basis.at_samples.ncols()];
        self.basis.evaluate(&padded(coefficients, self.kept), &mut out);
        out
    }

    fn projected(&self, samples: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; coefficient_count(self.kept)];
        self.basis.project(samples, &mut out);
        out
    }

    /// `Σⱼ Gᵢⱼ qⱼ` of every mode over the period.
    pub fn slopes(&self, modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = modes.len();
        let samples: Vec<Vec<f64>> = modes.iter().map(|mode| self.samples(mode)).collect();
        let slope = |i: usize, k: usize| {
            (0..count).map(|j| self.beam.shortening[i * count + j] * samples[j][k]).sum::<f64>()
        };
        (0..count).map(|i| (0..self.basis.at_samples.ncols()).map(|k| slope(i, k)).collect()).collect()
    }

    /// Displacement coefficients of mode `i` under those of a force on it.
    fn mode(&self, i: usize, force: &[f64]) -> Vec<f64> {
        let (natural, damping) = (self.beam.angular_frequency[i], self.beam.damping_ratio[i]);
        let mut out = vec![force[0] / (natural * natural)];
        for (h, pair) in force[1..].chunks_exact(2).enumerate() {
            let omega = (h + 1) as f64 * self.motion.angular_frequency;
            let stiffness = Complex::new(natural * natural - omega * omega, 2.0 * damping * natural * omega);
            let moved = Complex::new(pair[0], -pair[1]) / stiffness;
            out.extend([moved.re, -moved.im]);
        }
        out
    }

    /// All modes under a force that acts on each by `shape`.
    fn under(&self, force: &[f64], shape: &[f64]) -> Vec<Vec<f64>> {
        let on = |shape: f64| force.iter().map(|f| f * shape).collect::<Vec<_>>();
        shape.iter().enumerate().map(|(i, shape)| self.mode(i, &on(*shape))).collect()
    }

    /// Coefficients of what the contact's `force` (samples) is on every mode of a beam with these `slopes`.
    pub fn modal_forces(&self, force: &[f64], slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let on = |i: usize| -> Vec<f64> {
            let lever = |k: usize| self.beam.contact_shape[i] - slopes[i][k];
            force.iter().enumerate().map(|(k, f)| -f * lever(k)).collect()
        };
        (0..slopes.len()).map(|i| self.projected(&on(i))).collect()
    }

    /// What the contact's `force` does to every mode of a beam with these `slopes`.
    fn under_contact(&self, force: &[f64], slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let forces = self.modal_forces(&self.samples(force), slopes);
        forces.iter().enumerate().map(|(i, force)| self.mode(i, force)).collect()
    }

    /// What a unit of each shared unknown does to the modes about `shared`: the excitation less than was shown, and inertia
    /// of the motion measured; a sensor's own gain moves nothing.
    fn under_shared(&self, shared: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let mut excitation = self.under_excitation(shared);
        excitation.iter_mut().flatten().for_each(|q| *q = -*q);
        let inertia = |((k, measured), sensor): ((usize, &Vec<f64>), &Sensor)| {
            let true_motion = |a: &f64| -a * (-shared[1 + k]).exp();
            let force: Vec<f64> = padded(measured, self.kept).iter().map(true_motion).collect();
            self.under(&force, &sensor.shape)
        };
        let masses = self.motion.accelerations.iter().enumerate().zip(&self.beam.sensors).map(inertia);
        let still = vec![vec![0.0; coefficient_count(self.kept)]; excitation.len()];
        let gains = vec![still; self.beam.sensors.len()];
        std::iter::once(excitation).chain(gains).chain(masses).collect()
    }

    /// The modes under the excitation that the load cell has seen.
    pub fn under_excitation(&self, shared: &[f64]) -> Vec<Vec<f64>> {
        let factor = (-shared[0]).exp();
        let force: Vec<f64> = padded(&self.motion.excitation, self.kept).iter().map(|f| f * factor).collect();
        self.under(&force, &self.beam.excitation_shape)
    }

    /// The modes under a force of the contact and the shared unknowns, the slopes as they are in `modes`.
    pub fn modes_under(&self, force: &[f64], shared: &[f64], modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut out = self.under_contact(force, &self.slopes(modes));
        let first_mass = 1 + self.beam.sensors.len();
        let inertia = shared.iter().copied().zip(self.under_shared(shared)).skip(first_mass);
        for (factor, part) in std::iter::once((1.0, self.under_excitation(shared))).chain(inertia) {
            for (mode, more) in out.iter_mut().zip(part) {
                mode.iter_mut().zip(more).for_each(|(q, more)| *q += factor * more);
            }
        }
        out
    }

    /// The harmonics that every sensor shows, from the first on, over their errors.
    fn shown(&self, modes: &[Vec<f64>]) -> Vec<f64> {
        let mut out = Vec::new();
        for (sensor, errors) in self.beam.sensors.iter().zip(&self.motion.errors) {
            let mut moved = vec![0.0; coefficient_count(self.kept)];
            for (shape, mode) in sensor.shape.iter().zip(modes) {
                moved.iter_mut().zip(mode).for_each(|(w, q)| *w += shape * q);
            }
            let moved = time_derivative(&moved, 2, self.motion.angular_frequency);
            out.extend((1..errors.len()).map(|k| moved[k] / errors[k]));
        }
        out
    }

    /// The equations of the shared unknowns and of the force's `count` coefficients about `shared` and `modes`, linear, over
    /// the errors.
    pub fn equations(
        &self,
        modes: &[Vec<f64>],
        shared: &[f64],
        count: usize,
    ) -> (DMatrix<f64>, DVector<f64>) {
        let slopes = self.slopes(modes);
        let sensors = self.motion.accelerations.iter().zip(&self.motion.errors).enumerate();
        let rows = sensors.flat_map(|(k, (a, e))| (1..a.len()).map(move |i| (k, a[i] / e[i])));
        let (sensor, measured): (Vec<usize>, Vec<f64>) = rows.unzip();
        let mut columns: Vec<Vec<f64>> =
            self.under_shared(shared).iter().map(|part| self.shown(part)).collect();
        let moved = self.shown(modes);
        for (i, k) in sensor.iter().enumerate() {
            columns[1 + k][i] = moved[i];
        }
        columns.extend((0..count).map(|k| {
            let mut force = vec![0.0; count];
            force[k] = 1.0;
            self.shown(&self.under_contact(&force, &slopes))
        }));
        let without = self.shown(&self.under_excitation(shared));
        let gain = |i: usize| shared[1 + sensor[i]].exp();
        let known = |i: usize| without[i] - shared[0] * columns[0][i] - shared[1 + sensor[i]] * moved[i];
        let matrix = DMatrix::from_fn(measured.len(), columns.len(), |i, k| gain(i) * columns[k][i]);
        (matrix, DVector::from_fn(measured.len(), |i, _| measured[i] - gain(i) * known(i)))
    }

    /// What a unit of each unknown of [`equations`](Self::equations) does to the coefficients of the contact's displacement.
    fn displacements(&self, modes: &[Vec<f64>], shared: &[f64], count: usize) -> DMatrix<f64> {
        let slopes = self.slopes(modes);
        let moved = |parts: &[Vec<f64>], force: &[f64]| {
            let (parts, pull): (Vec<_>, _) =
                (parts.iter().map(|part| self.samples(part)).collect(), self.samples(force));
            let lever = |i: usize, k: usize| self.beam.contact_shape[i] - slopes[i][k];
            let along = |k: usize| (0..parts.len()).map(|i| lever(i, k) * parts[i][k]).sum::<f64>();
            let own = |k: usize| along(k) - self.beam.axial_flexibility * pull[k];
            DVector::from_vec(self.projected(&(0..pull.len()).map(own).collect::<Vec<_>>()))
        };
        let mut columns: Vec<DVector<f64>> =
            self.under_shared(shared).iter().map(|parts| moved(parts, &[0.0])).collect();
        columns.extend((0..count).map(|k| {
            let mut force = vec![0.0; count];
            force[k] = 1.0;
            moved(&self.under_contact(&force, &slopes), &force)
        }));
        DMatrix::from_columns(&columns)
    }

    /// The contact under `force` and `modes`; `covariance` is that of the shared unknowns and of the force.
    pub fn period(
        &self,
        (force, shared): (&[f64], &[f64]),
        covariance: &DMatrix<f64>,
        modes: &[Vec<f64>],
        left: &DVector<f64>,
    ) -> ContactPeriod {
        let derivatives = self.displacements(modes, shared, force.len());
        let own = (shared.len(), force.len());
        let (slopes, pull) = (self.slopes(modes), self.samples(force));
        let samples: Vec<Vec<f64>> = modes.iter().map(|mode| self.samples(mode)).collect();
        let displacement = |k: usize| {
            let along = |i: usize| (self.beam.contact_shape[i] - 0.5 * slopes[i][k]) * samples[i][k];
            (0..modes.len()).map(along).sum::<f64>() - self.beam.axial_flexibility * pull[k]
        };
        let displacement: Vec<f64> = (0..pull.len()).map(displacement).collect();
        let displacement = self.projected(&displacement);
        let pairs = self.motion.accelerations.iter().zip(&self.motion.errors);
        let measured: f64 =
            pairs.flat_map(|(a, e)| (1..a.len()).map(|k| (a[k] / e[k]).powi(2)).collect::<Vec<_>>()).sum();
        ContactPeriod {
            angular_frequency: self.motion.angular_frequency,
            velocity: time_derivative(&displacement, 1, self.motion.angular_frequency),
            displacement,
            cross_covariance: (&derivatives * covariance).columns(own.0, own.1).into_owned(),
            displacement_covariance: &derivatives * covariance * derivatives.transpose(),
            force: force.to_vec(),
            covariance: covariance.view((own.0, own.0), (own.1, own.1)).into_owned(),
            modes: modes.to_vec(),
            unexplained: left.norm() / measured.sqrt(),
        }
    }
}

/// `coefficients` with zeros up to `harmonics`.
fn padded(coefficients: &[f64], harmonics: usize) -> Vec<f64> {
    let mut out = coefficients.to_vec();
    out.resize(coefficient_count(harmonics), 0.0);
    out
}
