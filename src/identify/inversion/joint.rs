//! All records together, with the unknowns that they share.

use nalgebra::{DMatrix, DVector};

use super::bending::Bending;
use super::found::Inversion;
use super::motion::Doubts;
use crate::identify::IdentificationError;
use crate::numeric::fourier::coefficient_count;

/// Rounds in which the slope's part in the force is found, and the change of the forces that ends them.
const ROUNDS: usize = 50;
const SETTLED: f64 = 1e-9;
const NEARLY: f64 = 1e-6;

impl Doubts {
    /// In the order of the shared unknowns.
    pub(super) fn spreads(&self, sensors: usize) -> Vec<f64> {
        let each = |doubt| std::iter::repeat_n(doubt, sensors);
        let load_cell = std::iter::once(self.excitation_gain);
        load_cell.chain(each(self.sensor_gain)).chain(each(self.sensor_mass)).collect()
    }
}

/// All records with the unknowns that they share: the gain of the load cell, gains and masses of the sensors.
pub(super) struct Joint<'p> {
    records: Vec<Bending<'p>>,
    /// Per record: the forces, direction after direction, and the modes under them.
    forces: Vec<Vec<f64>>,
    modes: Vec<Vec<Vec<f64>>>,
    /// Logarithms of the gains of the load cell and of the sensors, and masses (kg).
    shared: Vec<f64>,
    /// Standard deviations of these beforehand, and of a force.
    pub spreads: Vec<f64>,
    force: f64,
    /// Errors told over errors seen, at most 1: what remains counts as noise.
    trust: f64,
}

pub(super) struct Solved {
    unknowns: DVector<f64>,
    covariance: DMatrix<f64>,
    /// Of the scaled unknowns.
    curvature: DMatrix<f64>,
    /// The residual of each record, over the errors told; root mean square in all.
    left: Vec<DVector<f64>>,
    misfit: f64,
}

impl<'p> Joint<'p> {
    pub fn new(records: Vec<Bending<'p>>, harmonics: usize, doubts: &Doubts) -> Self {
        let sensors = records[0].structure.sensors.len();
        let own = records[0].structure.directions.len() * coefficient_count(harmonics);
        let forces = vec![vec![0.0; own]; records.len()];
        let shared = vec![0.0; 1 + 2 * sensors];
        let modes = records.iter().map(|record| record.under_excitation(&shared)).collect();
        Self {
            records,
            forces,
            modes,
            shared,
            spreads: doubts.spreads(sensors),
            force: doubts.force,
            trust: 1.0,
        }
    }

    /// Steps until nothing changes.
    pub fn settle(&mut self, interrupted: &dyn Fn() -> bool) -> Result<Solved, IdentificationError> {
        let mut before = f64::INFINITY;
        for round in 0..ROUNDS {
            if interrupted() {
                return Err(IdentificationError::Failed("interrupted".to_owned()));
            }
            let solved = self.solve()?;
            let change = self.take(&solved);
            self.trust = 1.0 / solved.misfit.max(1.0);
            // What rounding leaves does not become less.
            if change <= SETTLED || round > ROUNDS / 2 && change < NEARLY && change >= before {
                return Ok(solved);
            }
            before = change;
        }
        Err(IdentificationError::Failed(
            "force and slope of the beam do not settle: the motion is too large for this beam".to_owned(),
        ))
    }

    /// Gauss and Newton's step: all unknowns anew, products with the motion as it was.
    fn solve(&self) -> Result<Solved, IdentificationError> {
        let (shared, own) = (self.spreads.len(), self.forces[0].len());
        let count = shared + own * self.records.len();
        let spread = |k: usize| if k < shared { self.spreads[k] } else { self.force };
        let mut curvature = DMatrix::<f64>::identity(count, count);
        let mut gradient = DVector::<f64>::zeros(count);
        let mut blocks = Vec::new();
        for (r, record) in self.records.iter().enumerate() {
            let each = own / record.structure.directions.len();
            let (matrix, right) = record.equations(&self.modes[r], &self.shared, each);
            let (matrix, right) = (matrix * self.trust, right * self.trust);
            let place = |k: usize| if k < shared { k } else { k + own * r };
            let matrix = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, k| matrix[(i, k)] * spread(k));
            let (square, product) = (matrix.transpose() * &matrix, matrix.transpose() * &right);
            for i in 0..shared + own {
                gradient[place(i)] += product[i];
                (0..shared + own).for_each(|k| curvature[(place(i), place(k))] += square[(i, k)]);
            }
            blocks.push((matrix, right));
        }
        let factor = curvature.clone().cholesky();
        let factor =
            factor.ok_or_else(|| IdentificationError::Failed("the equations have no solution".to_owned()))?;
        let scaled = factor.solve(&gradient);
        let rest = |(r, (matrix, right)): (usize, &(DMatrix<f64>, DVector<f64>))| {
            let its = |k: usize| scaled[if k < shared { k } else { k + own * r }];
            (right - matrix * DVector::from_fn(shared + own, |k, _| its(k))) / self.trust
        };
        let left: Vec<DVector<f64>> = blocks.iter().enumerate().map(rest).collect();
        let inverse = factor.inverse();
        let told: f64 = (0..count).map(|k| 1.0 - inverse[(k, k)]).sum();
        let equations: usize = left.iter().map(DVector::len).sum();
        let squares: f64 = left.iter().map(DVector::norm_squared).sum();
        Ok(Solved {
            unknowns: DVector::from_fn(count, |k, _| scaled[k] * spread(if k < shared { k } else { shared })),
            covariance: DMatrix::from_fn(count, count, |i, k| {
                inverse[(i, k)] * spread(i.min(shared)) * spread(k.min(shared))
            }),
            curvature,
            left,
            misfit: (squares / (equations as f64 - told).max(1.0)).sqrt(),
        })
    }

    /// Takes a step; the change of the forces over their size.
    fn take(&mut self, solved: &Solved) -> f64 {
        let (shared, own) = (self.spreads.len(), self.forces[0].len());
        let all = solved.unknowns.as_slice();
        self.shared.copy_from_slice(&all[..shared]);
        let (mut change, mut size) = (0.0, 0.0);
        for (r, force) in self.forces.iter_mut().enumerate() {
            let new = &all[shared + own * r..shared + own * (r + 1)];
            change += force.iter().zip(new).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            size += new.iter().map(|x| x * x).sum::<f64>();
            self.modes[r] = self.records[r].modes_under(new, &self.shared, &self.modes[r]);
            force.copy_from_slice(new);
        }
        (change / size.max(f64::MIN_POSITIVE)).sqrt()
    }

    pub fn told(&self, solved: &Solved) -> Inversion {
        let (shared, own) = (self.spreads.len(), self.forces[0].len());
        let sensors = (shared - 1) / 2;
        let one = |k: usize| [solved.unknowns[k], solved.covariance[(k, k)].sqrt()];
        let period = |direction: usize, (r, record): (usize, &Bending)| {
            let place = |k: usize| if k < shared { k } else { k + own * r };
            let both = |i: usize, k: usize| solved.covariance[(place(i), place(k))];
            let covariance = DMatrix::from_fn(shared + own, shared + own, both);
            let found = (self.forces[r].as_slice(), self.shared.as_slice());
            record.period(direction, found, &covariance, &self.modes[r], &solved.left[r])
        };
        let all = |direction| self.records.iter().enumerate().map(|one| period(direction, one)).collect();
        let eigenvalues = solved.curvature.symmetric_eigenvalues();
        Inversion {
            periods: all(0),
            normal: if self.records[0].structure.directions.len() > 1 { all(1) } else { Vec::new() },
            excitation_gain: one(0),
            sensor_gains: (1..=sensors).map(one).collect(),
            sensor_masses: (sensors + 1..shared).map(one).collect(),
            conditioning: (eigenvalues.max() / eigenvalues.min()).sqrt(),
            misfit: solved.misfit,
        }
    }
}
