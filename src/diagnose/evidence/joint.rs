//! A model's unknowns, those of the records' starts and of a discrepancy, as one sum of squares over whitened residuals.

use nalgebra::{DMatrix, DVector, DVectorView};
use rayon::prelude::*;

use super::latent::Latent;
use super::measured::{Measured, NoiseModel};
use super::noise_prior::NoisePrior;
use super::posterior::Extent;
use super::slot::Slot;
use super::unknown::{Coordinate, Unknown};
use crate::fit::{Limits, SumOfSquares, Sums, minimise};
use crate::model::Model;

/// Where a joint has been.
#[derive(Default)]
struct Points {
    /// The last that was tried.
    tried: Vec<f64>,
    /// The last that was linearised, its derivatives taken by differences or corrected.
    linearised: Vec<f64>,
    /// Where they were taken by differences, and with which steps.
    differenced: Vec<f64>,
    steps: Vec<f64>,
    /// Corrections since.
    corrections: usize,
}

/// What was linearised at a point.
#[derive(Debug, Clone)]
pub(super) struct Tangents {
    at: Vec<f64>,
    /// Steps of the secants that were taken, and of those to be taken next.
    steps: [Vec<f64>; 2],
    /// Per record and unknown.
    derivatives: Vec<Vec<Vec<f64>>>,
}

/// Ratio of steps that are alike.
const LEAST_ALIKE: f64 = 0.1;
/// Times that derivatives of a motion from rest are corrected by what trials showed before they are taken anew.
const CORRECTIONS: usize = 3;

pub(super) struct Joint<'a, 'd> {
    pub data: &'a Measured<'a, 'd>,
    pub base: &'a Model,
    unknowns: &'a [Unknown],
    pub slots: Vec<Slot<'d>>,
    steps: Vec<f64>,
    points: Points,
    pub noise: NoiseModel,
    pub priors: Vec<Vec<NoisePrior>>,
    latent: &'a Latent,
    pub simulations: usize,
    /// Steps that a minimisation may take yet.
    left: usize,
    pub failure: Option<String>,
}

/// Steps of the first secants, in prior deviations, and bounds of all.
const FIRST_STEP: f64 = 1e-2;
const LONGEST_STEP: f64 = 0.3;
const SHORTEST_STEP: f64 = 1e-6;
/// Bounds of the weights of a discrepancy, in prior deviations.
const LARGEST_WEIGHT: f64 = 50.0;

impl<'a, 'd> Joint<'a, 'd> {
    pub fn new(
        data: &'a Measured<'a, 'd>,
        base: &'a Model,
        unknowns: &'a [Unknown],
        latent: &'a Latent,
    ) -> Result<Self, String> {
        let slot = |index: &usize| Ok(Slot::new(data.bench.lanes[*index].shown(base)?));
        let slots = data.records.par_iter().map(slot).collect::<Result<Vec<_>, String>>()?;
        Ok(Self {
            data,
            base,
            unknowns,
            slots,
            steps: vec![FIRST_STEP; unknowns.len()],
            points: Points::default(),
            noise: NoiseModel::white(data),
            priors: data.channels.iter().map(|c| c.iter().map(|c| c.prior).collect()).collect(),
            latent,
            simulations: 0,
            left: 0,
            failure: None,
        })
    }

    /// Unknowns that all records share: parameters, then weights.
    pub fn shared(&self) -> usize {
        self.unknowns.len() + self.latent.count
    }

    pub fn model(&self, y: &[f64]) -> Result<Model, String> {
        let mut model = self.base.clone();
        let pairs: Vec<(&str, f64)> =
            self.unknowns.iter().zip(y).map(|(u, y)| (u.path.as_str(), u.coordinate.value(*y))).collect();
        model.set_all(&pairs).map_err(|error| error.to_string())?;
        Ok(model)
    }

    pub fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let shared = self.unknowns.iter().map(|u| u.coordinate.bounds());
        let latent = std::iter::repeat_n((-LARGEST_WEIGHT, LARGEST_WEIGHT), self.latent.count);
        shared
            .chain(latent)
            .chain(self.slots.iter().flat_map(|slot| slot.own.iter().map(Coordinate::bounds)))
            .unzip()
    }

    /// Has the unknowns that are at their bounds at `y` stay there under `curvature`; which they are.
    pub fn hold(&self, y: &[f64], curvature: &mut DMatrix<f64>) -> Vec<usize> {
        let (lower, upper) = self.bounds();
        let held: Vec<usize> = (0..y.len()).filter(|i| y[*i] <= lower[*i] || y[*i] >= upper[*i]).collect();
        for i in &held {
            curvature.row_mut(*i).fill(0.0);
            curvature.column_mut(*i).fill(0.0);
            curvature[(*i, *i)] = 1.0;
        }
        held
    }

    /// The models a secant away along each parameter, with the steps.
    pub fn moved(&self, y: &[f64]) -> Result<Vec<(Model, f64)>, String> {
        (0..self.unknowns.len())
            .map(|j| {
                let (lower, upper) = self.unknowns[j].coordinate.bounds();
                // Away from the nearer bound.
                let sign = if upper - y[j] >= y[j] - lower { 1.0 } else { -1.0 };
                let step = sign * self.steps[j];
                let mut moved = y[..self.unknowns.len()].to_vec();
                moved[j] = y[j] + step;
                match self.model(&moved) {
                    Ok(model) => Ok((model, step)),
                    // Rules that join parameters may refuse one side.
                    Err(_) => {
                        moved[j] = y[j] - step;
                        Ok((self.model(&moved)?, -step))
                    }
                }
            })
            .collect()
    }

    /// What was linearised at `y`, for hypotheses with more unknowns; `None` where records have unknowns of their own, or where
    /// solutions bring their derivatives.
    pub fn tangents(&self, y: &[f64]) -> Option<Tangents> {
        let shared = y.len() == self.unknowns.len();
        (shared && self.is_stepped()).then(|| Tangents {
            at: y.to_vec(),
            steps: [self.points.steps.clone(), self.steps.clone()],
            derivatives: self.slots.iter().map(|slot| slot.derivatives.clone()).collect(),
        })
    }

    /// Linearises at `y`, whose first unknowns are those of the `known` tangents: the derivatives by the others alone are taken
    /// by differences.
    pub fn extend(&mut self, y: &[f64], known: &Tangents) -> Result<(), String> {
        let (model, count) = (self.model(y)?, known.at.len());
        let moved = self.moved(y)?.split_off(count);
        let data = self.data;
        let beside = |(slot, derivatives): (&mut Slot, &Vec<Vec<f64>>)| {
            data.bench.unless_interrupted()?;
            slot.linearise(&model, &moved, y, &[])?;
            slot.take();
            slot.derivatives.splice(0..0, derivatives.iter().cloned());
            Ok(())
        };
        first_failure(self.slots.par_iter_mut().zip(&known.derivatives).map(beside))?;
        self.simulations += self.slots.len() * (1 + moved.len());
        let [taken, next] = &known.steps;
        let steps = [&taken[..], &self.steps[count..]].concat();
        self.steps[..count].copy_from_slice(next);
        // Most derivatives are of a point without what the others bring.
        let mut differenced = known.at.clone();
        differenced.resize(y.len(), 0.0);
        self.points = Points { linearised: y.to_vec(), differenced, steps, ..Points::default() };
        Ok(())
    }

    /// Linearises at `y`, with the derivatives that are there as long as they are near.
    fn linearise(&mut self, y: &[f64]) -> Result<(), String> {
        if self.points.linearised == y {
            return Ok(());
        }
        if self.points.tried == y
            && self.is_correctable()
            && (self.points.corrections < CORRECTIONS || self.is_near(y))
        {
            self.correct(y);
            return Ok(());
        }
        self.difference(y)?;
        self.points.linearised = y.to_vec();
        self.points.differenced = y.to_vec();
        self.points.steps.clone_from(&self.steps);
        self.points.corrections = 0;
        Ok(())
    }

    /// Whether trials tell as much as differences: a solution that is solved for brings its own derivatives.
    fn is_correctable(&self) -> bool {
        self.is_stepped() && !self.points.differenced.is_empty()
    }

    fn is_stepped(&self) -> bool {
        let stepped = self.data.records.iter().all(|record| self.data.bench.lanes[*record].seed.is_none());
        stepped && self.latent.count == 0
    }

    /// Whether no unknown is farther than a step from where derivatives were taken by differences, with steps alike.
    fn is_near(&self, y: &[f64]) -> bool {
        let Points { differenced, steps, .. } = &self.points;
        let near = |j: usize| (y[j] - differenced[j]).abs() <= self.steps[j];
        let alike = |j: usize| (LEAST_ALIKE..1.0 / LEAST_ALIKE).contains(&(steps[j] / self.steps[j]));
        y.len() == differenced.len() && (0..steps.len()).all(|j| near(j) && alike(j))
    }

    /// Corrects the derivatives by the last trial, which was at `y` (Broyden 1965).
    fn correct(&mut self, y: &[f64]) {
        let step: Vec<f64> = y.iter().zip(&self.points.linearised).map(|(a, b)| a - b).collect();
        let (parameters, steps) = (self.unknowns.len(), &self.steps);
        self.slots.par_iter_mut().for_each(|slot| slot.correct(parameters, &step, steps));
        self.points.linearised = y.to_vec();
        self.points.corrections += 1;
    }

    fn difference(&mut self, y: &[f64]) -> Result<(), String> {
        let model = self.model(y)?;
        let moved = self.moved(y)?;
        self.steps.resize(y.len(), FIRST_STEP);
        let (latent, weights, steps) = (self.latent, &y[self.unknowns.len()..], &self.steps);
        let data = self.data;
        let anew = |slot: &mut Slot| {
            data.bench.unless_interrupted()?;
            slot.linearise(&model, &moved, y, steps)
        };
        first_failure(self.slots.par_iter_mut().map(anew))?;
        for (k, slot) in self.slots.iter_mut().enumerate() {
            slot.take();
            latent.add(k, weights, &mut slot.linearised);
        }
        self.simulations += self.slots.iter().map(|slot| 1 + moved.len() + slot.own.len()).sum::<usize>();
        Ok(())
    }

    /// Predictions minus measurements at the last point that was linearised.
    pub fn residuals(&self) -> Vec<Vec<f64>> {
        let of = |(k, slot): (usize, &Slot)| minus(&slot.linearised, &self.data.lane(k).measured);
        self.slots.iter().enumerate().map(of).collect()
    }

    /// The residuals a `step` of all unknowns away from the last linearised point, to first order.
    pub fn residuals_after(&self, step: &DVector<f64>) -> Vec<Vec<f64>> {
        let mut residuals = self.residuals();
        for (k, residuals) in residuals.iter_mut().enumerate() {
            let slot = &self.slots[k];
            for (i, column) in
                self.latent.columns_with(k, &slot.derivatives, self.unknowns.len(), slot.offset)
            {
                residuals.iter_mut().zip(column).for_each(|(r, c)| *r += step[i] * c);
            }
        }
        residuals
    }

    pub fn predictions(&self) -> Vec<Vec<f64>> {
        self.slots.iter().map(|slot| slot.linearised.clone()).collect()
    }

    /// Minimises from `y`; the last linearised point is the end.
    pub fn minimise(&mut self, y: &mut Vec<f64>, extent: Extent) -> Result<(), String> {
        let Extent { steps, tolerance, trials } = extent;
        let (lower, upper) = self.bounds();
        self.left = steps;
        let mut renewed = false;
        loop {
            let before = self.left;
            let limits = Limits { iterations: self.left, tolerance, trials, ..Limits::default() };
            let end = minimise(self, y.clone(), &lower, &upper, limits);
            let end =
                end.ok_or_else(|| self.failure.clone().unwrap_or_else(|| "the fit cannot start".to_owned()))?;
            if !end.sums.cost.is_finite() {
                return Err("the fit has no finite end".to_owned());
            }
            let promise = end.promise(&lower, &upper);
            *y = end.y;
            let converged = self.is_near(y) && promise <= tolerance * end.sums.cost;
            let fresh = self.points.differenced == *y || renewed && self.left == before;
            let ended = self.left == 0 || converged || fresh;
            // A step whose derivatives could not be made is taken back.
            let lost = self.points.linearised != *y;
            if lost {
                y.clone_from(&self.points.linearised);
            }
            if ended || lost || self.interrupted() {
                return Ok(());
            }
            // Derivatives that were only corrected, or taken with other steps, tell no end.
            self.forget_linearised();
            renewed = true;
        }
    }

    /// Has the next linearisation made by differences, wherever it is.
    pub fn forget_linearised(&mut self) {
        self.points = Points::default();
    }

    /// The last linearised point of every record, whitened.
    pub fn whitened(&self) -> Vec<Whitened> {
        let (data, noise, latent) = (self.data, &self.noise, self.latent);
        let parameters = self.unknowns.len();
        // A simulation stays on its thread; what it left can be read from any.
        let left = self.slots.iter().map(Left::of).collect::<Vec<_>>();
        left.into_par_iter()
            .enumerate()
            .map(|(k, Left { linearised, derivatives, offset })| {
                let raw = latent.columns_with(k, derivatives, parameters, offset);
                let columns = raw.map(|(i, column)| (i, noise.whiten(data, k, column))).collect();
                let residuals = noise.whiten(data, k, &minus(linearised, &data.lane(k).measured));
                Whitened { residuals, columns }
            })
            .collect()
    }

    /// The sums at the last linearised point, which is `y`, under the present noise.
    pub fn sums_here(&self, y: &[f64]) -> Sums {
        let n = y.len();
        let mut sums = Sums { cost: 0.5 * dot(y, y), gradient: y.to_vec(), curvature: vec![0.0; n * n] };
        (0..n).for_each(|i| sums.curvature[i * n + i] = 1.0);
        let parts: Vec<Sums> = self.whitened().par_iter().map(|record| record.sums(n)).collect();
        for part in &parts {
            sums.cost += part.cost;
            sums.gradient.iter_mut().zip(&part.gradient).for_each(|(sum, part)| *sum += part);
            sums.curvature.iter_mut().zip(&part.curvature).for_each(|(sum, part)| *sum += part);
        }
        sums
    }

    /// The changes of all predictions along `probes`, at the point `y` that was linearised; `None` for those that
    /// cannot be predicted.
    pub fn changes(&mut self, y: &[f64], probes: &[Model]) -> Vec<Option<Vec<Vec<f64>>>> {
        let Ok(model) = self.model(y) else { return vec![None; probes.len()] };
        self.simulations += self.slots.len() * probes.len();
        let bench = self.data.bench;
        let mut per_record: Vec<Vec<Option<Vec<f64>>>> =
            self.slots.par_iter_mut().map(|slot| slot.changes(&model, probes, y, bench)).collect();
        (0..probes.len())
            .map(|p| per_record.iter_mut().map(|changes| changes[p].take()).collect::<Option<Vec<_>>>())
            .collect()
    }
}

/// What the last linearisation left of a record.
struct Left<'s> {
    linearised: &'s [f64],
    derivatives: &'s [Vec<f64>],
    offset: usize,
}

impl<'s> Left<'s> {
    fn of(slot: &'s Slot) -> Self {
        Self { linearised: &slot.linearised, derivatives: &slot.derivatives, offset: slot.offset }
    }
}

/// A record's residuals and what every unknown changes of them, in standard deviations of the noise.
pub(super) struct Whitened {
    pub residuals: Vec<f64>,
    /// Each with its unknown.
    pub columns: Vec<(usize, Vec<f64>)>,
}

impl Whitened {
    /// What the record adds to the sums of `n` unknowns.
    fn sums(&self, n: usize) -> Sums {
        let Self { residuals, columns } = self;
        let cost = 0.5 * dot(residuals, residuals);
        let mut sums = Sums { cost, gradient: vec![0.0; n], curvature: vec![0.0; n * n] };
        for (a, (i, column)) in columns.iter().enumerate() {
            sums.gradient[*i] += dot(column, residuals);
            for (j, other) in &columns[..=a] {
                let product = dot(column, other);
                sums.curvature[i * n + j] += product;
                if i != j {
                    sums.curvature[j * n + i] += product;
                }
            }
        }
        sums
    }
}

/// All results in order, or the first failure of them: whichever came first in time would depend on the threads.
pub(super) fn first_failure<T: Send>(
    of: impl IndexedParallelIterator<Item = Result<T, String>>,
) -> Result<Vec<T>, String> {
    of.collect::<Vec<_>>().into_iter().collect()
}

pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    DVectorView::from_slice(a, a.len()).dot(&DVectorView::from_slice(b, b.len()))
}

pub(super) fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

impl SumOfSquares for Joint<'_, '_> {
    fn cost(&mut self, y: &[f64]) -> Option<f64> {
        let model = self.model(y).ok()?;
        self.simulations += self.slots.len();
        self.points.tried = y.to_vec();
        let (latent, weights) = (self.latent, &y[self.unknowns.len()..]);
        let (data, noise) = (self.data, &self.noise);
        let part = |(k, slot): (usize, &mut Slot)| {
            data.bench.unless_interrupted()?;
            let nuisances = slot.own_values(y);
            slot.shown.predict(&model, &nuisances, &mut slot.predictions)?;
            latent.add(k, weights, &mut slot.predictions);
            let e = noise.whiten(data, k, &minus(&slot.predictions, &data.lane(k).measured));
            Ok(dot(&e, &e))
        };
        match first_failure(self.slots.par_iter_mut().enumerate().map(part)) {
            Ok(parts) => Some(0.5 * (parts.iter().sum::<f64>() + dot(y, y))).filter(|cost| cost.is_finite()),
            Err(failure) => {
                self.failure.get_or_insert(failure);
                None
            }
        }
    }

    fn sums(&mut self, y: &[f64]) -> Option<Sums> {
        if let Err(failure) = self.linearise(y) {
            self.failure.get_or_insert(failure);
            return None;
        }
        let sums = self.sums_here(y);
        let n = y.len();
        for (j, step) in self.steps.iter_mut().enumerate() {
            *step = (1.0 / sums.curvature[j * n + j].sqrt()).clamp(SHORTEST_STEP, LONGEST_STEP);
        }
        let finite = sums.cost.is_finite() && sums.gradient.iter().all(|g| g.is_finite());
        finite.then_some(sums)
    }

    fn accepted(&mut self, _: usize, _: f64) {
        self.left -= 1;
    }

    fn interrupted(&self) -> bool {
        self.data.bench.interrupted()
    }
}
