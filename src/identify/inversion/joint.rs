//! All records together, with the unknowns that they share.

use nalgebra::{DMatrix, DVector};

use super::bending::Bending;
use super::found::Inversion;
use super::motion::Doubts;
use crate::identify::IdentificationError;

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
    /// Per record: its own unknowns, the forces first, direction after direction, and the modes under them.
    own: Vec<Vec<f64>>,
    modes: Vec<Vec<Vec<f64>>>,
    /// Logarithms of the gains of the load cell and of the sensors, and masses (kg).
    shared: Vec<f64>,
    /// Standard deviations of these beforehand, and of each record's own.
    pub spreads: Vec<f64>,
    own_spreads: Vec<Vec<f64>>,
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
    pub fn new(records: Vec<Bending<'p>>, doubts: &Doubts) -> Self {
        let sensors = records[0].structure.sensors.len();
        let own_spreads: Vec<Vec<f64>> = records.iter().map(|record| record.spreads(doubts.force)).collect();
        let own = own_spreads.iter().map(|spreads| vec![0.0; spreads.len()]).collect();
        let shared = vec![0.0; 1 + 2 * sensors];
        let modes = records.iter().map(|record| record.under_excitation(&shared)).collect();
        Self { records, own, modes, shared, spreads: doubts.spreads(sensors), own_spreads, trust: 1.0 }
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
        let spreads: Vec<f64> =
            self.spreads.iter().chain(self.own_spreads.iter().flatten()).copied().collect();
        let count = spreads.len();
        let mut curvature = DMatrix::<f64>::identity(count, count);
        let mut gradient = DVector::<f64>::zeros(count);
        let mut blocks = Vec::new();
        for (r, record) in self.records.iter().enumerate() {
            let (matrix, right) = record.equations(&self.modes[r], &self.shared);
            let (mut matrix, right) = (matrix * self.trust, right * self.trust);
            let places = self.places(r);
            matrix.column_iter_mut().zip(&places).for_each(|(mut column, place)| column *= spreads[*place]);
            let (square, product) = (matrix.transpose() * &matrix, matrix.transpose() * &right);
            for (i, to) in places.iter().enumerate() {
                gradient[*to] += product[i];
                places.iter().enumerate().for_each(|(k, from)| curvature[(*to, *from)] += square[(i, k)]);
            }
            blocks.push((matrix, right, places));
        }
        let factor = curvature.clone().cholesky().ok_or_else(|| {
            IdentificationError::Failed(
                "the equations have no solution: motions and force do not belong to this model; `stickslip check MODEL DATASET` looks \
                 for wrong units and signs"
                    .to_owned(),
            )
        })?;
        let scaled = factor.solve(&gradient);
        let rest = |(matrix, right, places): &(DMatrix<f64>, DVector<f64>, Vec<usize>)| {
            let its = DVector::from_iterator(places.len(), places.iter().map(|place| scaled[*place]));
            (right - matrix * its) / self.trust
        };
        let left: Vec<DVector<f64>> = blocks.iter().map(rest).collect();
        let inverse = factor.inverse();
        let told: f64 = (0..count).map(|k| 1.0 - inverse[(k, k)]).sum();
        let equations: usize = left.iter().map(DVector::len).sum();
        let squares: f64 = left.iter().map(DVector::norm_squared).sum();
        Ok(Solved {
            unknowns: DVector::from_fn(count, |k, _| scaled[k] * spreads[k]),
            covariance: DMatrix::from_fn(count, count, |i, k| inverse[(i, k)] * spreads[i] * spreads[k]),
            curvature,
            left,
            misfit: (squares / (equations as f64 - told).max(1.0)).sqrt(),
        })
    }

    /// Where the unknowns of record `r` are among all: the shared ones, then its own.
    fn places(&self, r: usize) -> Vec<usize> {
        let shared = self.spreads.len();
        let start = shared + self.own[..r].iter().map(Vec::len).sum::<usize>();
        (0..shared).chain(start..start + self.own[r].len()).collect()
    }

    /// Takes a step; the change of the forces over their size.
    fn take(&mut self, solved: &Solved) -> f64 {
        let shared = self.spreads.len();
        let all = solved.unknowns.as_slice();
        self.shared.copy_from_slice(&all[..shared]);
        let (mut change, mut size, mut rest) = (0.0, 0.0, &all[shared..]);
        for (r, own) in self.own.iter_mut().enumerate() {
            let (new, after) = rest.split_at(own.len());
            change += own.iter().zip(new).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
            size += new.iter().map(|x| x * x).sum::<f64>();
            self.modes[r] = self.records[r].modes_under(new, &self.shared, &self.modes[r]);
            own.copy_from_slice(new);
            rest = after;
        }
        (change / size.max(f64::MIN_POSITIVE)).sqrt()
    }

    pub fn told(&self, solved: &Solved) -> Inversion {
        let shared = self.spreads.len();
        let sensors = (shared - 1) / 2;
        let one = |k: usize| [solved.unknowns[k], solved.covariance[(k, k)].sqrt()];
        let period = |direction: usize, (r, record): (usize, &Bending)| {
            let places = self.places(r);
            let both = |i: usize, k: usize| solved.covariance[(places[i], places[k])];
            let covariance = DMatrix::from_fn(places.len(), places.len(), both);
            let found = (self.own[r].as_slice(), self.shared.as_slice());
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
