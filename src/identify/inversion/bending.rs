//! One record's structure in bending: forces in, modes out.

use nalgebra::{Complex, DMatrix, DVector};

use super::found::ContactPeriod;
use super::motion::SteadyMotion;
use super::springs::Springs;
use super::structure::{Direction, Structure};
use crate::identify::IdentificationError;
use crate::numeric::fourier::{Basis, coefficient_count, time_derivative};

/// Standard deviation (m) of the mean height of a pin that rests on its support: no accelerometer shows a mean, but so far it
/// neither rises nor sinks.
const REST: f64 = 1e-5;

/// One record's structure in bending: forces in, modes out.
pub(in crate::identify) struct Bending<'p> {
    pub structure: &'p Structure,
    pub motion: &'p SteadyMotion,
    /// Harmonics of the modes.
    pub kept: usize,
    /// Coefficients of a force in one direction.
    count: usize,
    /// Places of the excitation's coefficients that are not certain.
    doubted: Vec<usize>,
    basis: Basis,
    springs: Springs,
}

impl<'p> Bending<'p> {
    pub fn new(
        structure: &'p Structure,
        motion: &'p SteadyMotion,
        harmonics: usize,
    ) -> Result<Self, IdentificationError> {
        let SteadyMotion { accelerations, errors, .. } = motion;
        let kept = accelerations.iter().map(|a| a.len() / 2).max().unwrap_or(0).max(harmonics);
        let sensors = structure.sensors.len();
        let alike = accelerations.iter().zip(errors).all(|(a, e)| a.len() == e.len() && a.len() > 2);
        if accelerations.len() != sensors || errors.len() != sensors || !alike {
            return Err(IdentificationError::Failed(format!(
                "{sensors} accelerations are needed, with an error each"
            )));
        }
        // A product of force and slope has the harmonics of both.
        let springs = Springs::new(structure, motion.angular_frequency, kept);
        let certain = |k: usize| motion.excitation_errors.get(k).is_none_or(|error| *error <= 0.0);
        let doubted = (1..coefficient_count(kept)).filter(|k| !certain(*k)).collect();
        let (count, basis) = (coefficient_count(harmonics), Basis::new(kept, 8 * (kept + 1)));
        Ok(Self { structure, motion, kept, count, doubted, basis, springs })
    }

    /// Standard deviations beforehand of this record's own unknowns, if that of the contact's force is `force` (N): its
    /// coefficients, direction after direction, and how much more than was shown the uncertain coefficients of the excitation are.
    pub fn spreads(&self, force: f64) -> Vec<f64> {
        let forces = std::iter::repeat_n(force, self.structure.directions.len() * self.count);
        forces.chain(self.doubted.iter().map(|k| self.motion.excitation_errors[*k])).collect()
    }

    pub fn samples(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; self.basis.at_samples.ncols()];
        self.basis.evaluate(&padded(coefficients, self.kept), &mut out);
        out
    }

    pub fn projected(&self, samples: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; coefficient_count(self.kept)];
        self.basis.project(samples, &mut out);
        out
    }

    /// `Σⱼ Gᵢⱼ qⱼ` of every mode over the period.
    pub fn slopes(&self, modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let count = modes.len();
        let samples: Vec<Vec<f64>> = modes.iter().map(|mode| self.samples(mode)).collect();
        let slope = |i: usize, k: usize| {
            (0..count).map(|j| self.structure.shortening[i * count + j] * samples[j][k]).sum::<f64>()
        };
        (0..count).map(|i| (0..self.basis.at_samples.ncols()).map(|k| slope(i, k)).collect()).collect()
    }

    /// Displacement coefficients of all modes under those of the forces on each.
    fn moved(&self, forces: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let speed = self.motion.angular_frequency;
        let mode = |(i, force): (usize, &Vec<f64>)| {
            let mut out = Vec::with_capacity(force.len());
            let natural = self.structure.angular_frequency[i];
            out.push(force[0] / (natural * natural));
            for (h, pair) in force[1..].chunks_exact(2).enumerate() {
                let omega = (h + 1) as f64 * speed;
                let moved = Complex::new(pair[0], -pair[1]) / self.structure.stiffness(i, omega);
                out.extend([moved.re, -moved.im]);
            }
            out
        };
        let mut modes: Vec<Vec<f64>> = forces.iter().enumerate().map(mode).collect();
        self.springs.hold(&mut modes);
        modes
    }

    /// All modes under a force that acts on each by `shape`.
    fn under(&self, force: &[f64], shape: &[f64]) -> Vec<Vec<f64>> {
        let on = |shape: &f64| force.iter().map(|f| f * shape).collect();
        self.moved(&shape.iter().map(on).collect::<Vec<_>>())
    }

    /// Coefficients of what the contact's `force` (samples) in a direction is on every mode of a beam with these `slopes`.
    pub fn modal_forces(&self, direction: &Direction, force: &[f64], slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let on = |i: usize| -> Vec<f64> {
            let lever = |k: usize| direction.lever(i, slopes[i][k]);
            force.iter().enumerate().map(|(k, f)| -f * lever(k)).collect()
        };
        (0..slopes.len()).map(|i| self.projected(&on(i))).collect()
    }

    /// What the contact's `force` in a direction does to every mode of a beam with these `slopes`.
    fn under_contact(&self, direction: &Direction, force: &[f64], slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        self.moved(&self.modal_forces(direction, &self.samples(force), slopes))
    }

    /// What a unit of each of the record's own unknowns does to every mode.
    fn under_units(&self, slopes: &[Vec<f64>], shared: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let unit = |direction: &Direction, k: usize| {
            let mut force = vec![0.0; self.count];
            force[k] = 1.0;
            self.under_contact(direction, &force, slopes)
        };
        let all = |direction| (0..self.count).map(move |k| unit(direction, k));
        let contact = self.structure.directions.iter().flat_map(all);
        contact.chain(self.under_doubted(shared)).collect()
    }

    /// What a unit more of each uncertain coefficient of the excitation does to every mode.
    fn under_doubted(&self, shared: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let unit = |k: &usize| {
            let mut force = vec![0.0; coefficient_count(self.kept)];
            force[*k] = (-shared[0]).exp();
            self.under(&force, &self.structure.excitation_shape)
        };
        self.doubted.iter().map(unit).collect()
    }

    /// What a unit of each shared unknown does to the modes about `shared`: the excitation less than was shown, and inertia
    /// of the motion measured; a sensor's own gain moves nothing.
    fn under_shared(&self, shared: &[f64]) -> Vec<Vec<Vec<f64>>> {
        let mut excitation = self.under_excitation(shared);
        excitation.iter_mut().flatten().for_each(|q| *q = -*q);
        let inertia = |((k, measured), shape): ((usize, &Vec<f64>), &Vec<f64>)| {
            let true_motion = |a: &f64| -a * (-shared[1 + k]).exp();
            let force: Vec<f64> = padded(measured, self.kept).iter().map(true_motion).collect();
            self.under(&force, shape)
        };
        let masses = self.motion.accelerations.iter().enumerate().zip(&self.structure.sensors).map(inertia);
        let still = vec![vec![0.0; coefficient_count(self.kept)]; excitation.len()];
        let gains = vec![still; self.structure.sensors.len()];
        std::iter::once(excitation).chain(gains).chain(masses).collect()
    }

    /// The modes under the excitation that the load cell has seen.
    pub fn under_excitation(&self, shared: &[f64]) -> Vec<Vec<f64>> {
        let factor = (-shared[0]).exp();
        let force: Vec<f64> = padded(&self.motion.excitation, self.kept).iter().map(|f| f * factor).collect();
        self.under(&force, &self.structure.excitation_shape)
    }

    /// Coefficients of the pull on every mode of a hanging mass, which the shortening of a beam that moves by `modes` makes, and by
    /// which it bends that beam.
    fn hanging_forces(&self, modes: &[Vec<f64>], slopes: &[Vec<f64>]) -> Option<Vec<Vec<f64>>> {
        let hanging = self.structure.hanging.as_ref()?;
        let second =
            |motion: &[f64]| self.samples(&time_derivative(motion, 2, self.motion.angular_frequency));
        let samples: Vec<Vec<f64>> = modes.iter().map(|mode| self.samples(mode)).collect();
        let sum = |k: usize| samples.iter().zip(slopes).map(|(q, slope)| 0.5 * q[k] * slope[k]).sum::<f64>();
        let shortening = second(&self.projected(&(0..samples[0].len()).map(sum).collect::<Vec<_>>()));
        let along = second(&combined(&hanging.shape, modes));
        let on = |(shape, slope): (&f64, &Vec<f64>)| {
            let pull =
                |k: usize| hanging.mass * (shape * shortening[k] + slope[k] * (along[k] - shortening[k]));
            self.projected(&(0..slope.len()).map(pull).collect::<Vec<_>>())
        };
        Some(hanging.shape.iter().zip(slopes).map(on).collect())
    }

    /// Coefficients of what every mode that moves by `modes` without damping lacks, its inertia and stiffness less the forces on it,
    /// if the contact's forces are left out.
    pub fn without_contact(&self, modes: &[Vec<f64>], slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let Structure { excitation_shape, springs, .. } = self.structure;
        let excitation = padded(&self.motion.excitation, self.kept);
        let pull = self.hanging_forces(modes, slopes);
        let stretched: Vec<Vec<f64>> = springs.iter().map(|(_, row)| combined(row, modes)).collect();
        let lacking = |i: usize, k: usize| {
            let omega = k.div_ceil(2) as f64 * self.motion.angular_frequency;
            let own = self.structure.stiffness(i, omega).re * modes[i].get(k).copied().unwrap_or(0.0);
            let held = springs.iter().zip(&stretched);
            let held: f64 = held.map(|((k_s, row), y)| k_s * row[i] * y.get(k).copied().unwrap_or(0.0)).sum();
            own + held - excitation_shape[i] * excitation[k] - pull.as_ref().map_or(0.0, |pull| pull[i][k])
        };
        let count = coefficient_count(self.kept);
        (0..modes.len()).map(|i| (0..count).map(|k| lacking(i, k)).collect()).collect()
    }

    /// The modes under what is known beside the contact's forces; the hanging mass pulls as in `modes`.
    fn under_known(&self, shared: &[f64], modes: &[Vec<f64>], slopes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let mut out = self.under_excitation(shared);
        let pull = self.hanging_forces(modes, slopes).map(|forces| self.moved(&forces));
        pull.into_iter().for_each(|pull| add(&mut out, 1.0, &pull));
        out
    }

    /// The modes under the record's `own` and the shared unknowns, the slopes as they are in `modes`.
    pub fn modes_under(&self, own: &[f64], shared: &[f64], modes: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let slopes = self.slopes(modes);
        let directions = &self.structure.directions;
        let (forces, more) = own.split_at(directions.len() * self.count);
        let each = directions.iter().zip(forces.chunks_exact(self.count));
        let mut parts = each.map(|(direction, force)| self.under_contact(direction, force, &slopes));
        let mut out = parts.next().unwrap_or_default();
        parts.for_each(|part| add(&mut out, 1.0, &part));
        add(&mut out, 1.0, &self.under_known(shared, modes, &slopes));
        let first_mass = 1 + self.structure.sensors.len();
        for (factor, part) in shared.iter().zip(self.under_shared(shared)).skip(first_mass) {
            add(&mut out, *factor, &part);
        }
        for (factor, part) in more.iter().zip(self.under_doubted(shared)) {
            add(&mut out, *factor, &part);
        }
        out
    }

    /// The harmonics that every sensor shows, from the first on, over their errors; last, if it rests on something, the mean
    /// height of the pin.
    fn shown(&self, modes: &[Vec<f64>]) -> Vec<f64> {
        let mut out = Vec::new();
        for (shape, errors) in self.structure.sensors.iter().zip(&self.motion.errors) {
            let moved = time_derivative(&combined(shape, modes), 2, self.motion.angular_frequency);
            out.extend((1..errors.len()).map(|k| moved[k] / errors[k]));
        }
        let across = self.structure.directions.get(1);
        out.extend(across.map(|across| combined(&across.shape, modes)[0] / REST));
        out
    }

    /// The equations of the shared unknowns and of the record's own, about `shared` and `modes`, linear, over the errors.
    pub fn equations(&self, modes: &[Vec<f64>], shared: &[f64]) -> (DMatrix<f64>, DVector<f64>) {
        let slopes = self.slopes(modes);
        let sensors = self.motion.accelerations.iter().zip(&self.motion.errors).enumerate();
        let rows = sensors.flat_map(|(k, (a, e))| (1..a.len()).map(move |i| (Some(k), a[i] / e[i])));
        let height = self.structure.directions.get(1).map(|_| (None, 0.0));
        let (sensor, measured): (Vec<Option<usize>>, Vec<f64>) = rows.chain(height).unzip();
        let mut columns: Vec<Vec<f64>> =
            self.under_shared(shared).iter().map(|part| self.shown(part)).collect();
        let moved = self.shown(modes);
        for (i, k) in sensor.iter().enumerate().filter_map(|(i, k)| Some((i, (*k)?))) {
            columns[1 + k][i] = moved[i];
        }
        columns.extend(self.under_units(&slopes, shared).iter().map(|part| self.shown(part)));
        let without = self.shown(&self.under_known(shared, modes, &slopes));
        let shift = |i: usize| sensor[i].map_or(0.0, |k| shared[1 + k]);
        let gain = |i: usize| shift(i).exp();
        let known = |i: usize| without[i] - shared[0] * columns[0][i] - shift(i) * moved[i];
        let matrix = DMatrix::from_fn(measured.len(), columns.len(), |i, k| gain(i) * columns[k][i]);
        (matrix, DVector::from_fn(measured.len(), |i, _| measured[i] - gain(i) * known(i)))
    }

    /// What a unit of each unknown of [`equations`](Self::equations) does to the coefficients of the contact's displacement in
    /// direction `place`.
    fn displacements(&self, place: usize, modes: &[Vec<f64>], shared: &[f64]) -> DMatrix<f64> {
        let (direction, slopes) = (&self.structure.directions[place], self.slopes(modes));
        let moved = |parts: &[Vec<f64>], pull: Vec<f64>| {
            let parts: Vec<_> = parts.iter().map(|part| self.samples(part)).collect();
            let lever = |i: usize, k: usize| direction.lever(i, slopes[i][k]);
            let along = |k: usize| (0..parts.len()).map(|i| lever(i, k) * parts[i][k]).sum::<f64>();
            let own = |k: usize| along(k) - direction.flexibility * pull[k];
            DVector::from_vec(self.projected(&(0..pull.len()).map(own).collect::<Vec<_>>()))
        };
        let mut columns: Vec<DVector<f64>> =
            self.under_shared(shared).iter().map(|parts| moved(parts, self.samples(&[0.0]))).collect();
        let unit = |(k, parts): (usize, &Vec<Vec<f64>>)| {
            let mut force = vec![0.0; self.count];
            force[k % self.count] = if k / self.count == place { 1.0 } else { 0.0 };
            moved(parts, self.samples(&force))
        };
        columns.extend(self.under_units(&slopes, shared).iter().enumerate().map(unit));
        DMatrix::from_columns(&columns)
    }

    /// Coefficients of the contact's displacement in direction `place` under `modes` and its force `pull` (samples).
    pub fn displacement(&self, place: usize, modes: &[Vec<f64>], pull: &[f64]) -> Vec<f64> {
        let (direction, slopes) = (&self.structure.directions[place], self.slopes(modes));
        let samples: Vec<Vec<f64>> = modes.iter().map(|mode| self.samples(mode)).collect();
        let displacement = |(k, pull): (usize, &f64)| {
            let along = |i: usize| direction.lever(i, 0.5 * slopes[i][k]) * samples[i][k];
            (0..modes.len()).map(along).sum::<f64>() - direction.flexibility * pull
        };
        self.projected(&pull.iter().enumerate().map(displacement).collect::<Vec<_>>())
    }

    /// The contact in direction `place` under the record's `own` unknowns and `modes`; `covariance` is that of the shared and of these.
    pub fn period(
        &self,
        place: usize,
        (own, shared): (&[f64], &[f64]),
        covariance: &DMatrix<f64>,
        modes: &[Vec<f64>],
        left: &DVector<f64>,
    ) -> ContactPeriod {
        let (start, count) = (place * self.count, self.count);
        let force = &own[start..][..count];
        let derivatives = self.displacements(place, modes, shared);
        let first = shared.len() + start;
        let displacement = self.displacement(place, modes, &self.samples(force));
        let pairs = self.motion.accelerations.iter().zip(&self.motion.errors);
        let measured: f64 =
            pairs.flat_map(|(a, e)| (1..a.len()).map(|k| (a[k] / e[k]).powi(2)).collect::<Vec<_>>()).sum();
        ContactPeriod {
            angular_frequency: self.motion.angular_frequency,
            velocity: time_derivative(&displacement, 1, self.motion.angular_frequency),
            displacement,
            cross_covariance: (&derivatives * covariance).columns(first, count).into_owned(),
            displacement_covariance: &derivatives * covariance * derivatives.transpose(),
            force: force.to_vec(),
            covariance: covariance.view((first, first), (count, count)).into_owned(),
            modes: modes.to_vec(),
            unexplained: left.norm() / measured.sqrt(),
        }
    }
}

/// Displacement of the modes by `shape`.
fn combined(shape: &[f64], modes: &[Vec<f64>]) -> Vec<f64> {
    let mut out = vec![0.0; modes.first().map_or(0, Vec::len)];
    for (shape, mode) in shape.iter().zip(modes) {
        out.iter_mut().zip(mode).for_each(|(w, q)| *w += shape * q);
    }
    out
}

fn add(to: &mut [Vec<f64>], factor: f64, part: &[Vec<f64>]) {
    for (mode, more) in to.iter_mut().zip(part) {
        mode.iter_mut().zip(more).for_each(|(q, more)| *q += factor * more);
    }
}

/// `coefficients` with zeros up to `harmonics`.
fn padded(coefficients: &[f64], harmonics: usize) -> Vec<f64> {
    let mut out = coefficients.to_vec();
    out.resize(coefficient_count(harmonics), 0.0);
    out
}
