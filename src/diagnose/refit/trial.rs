//! A joint refit: a model's free parameters, those of its effects, and every record's unknown start at once.

use rayon::prelude::*;

use crate::diagnose::diagnosis::Estimate;
use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::diagnose::residual::blocks;
use crate::fit::predict::{Direction, NUISANCE_STEP, ObservedSimulation, Seed, inward};
use crate::fit::{Coordinate, Limits, Parameter, SumOfSquares, Sums, minimise, student_quantile};
use crate::harmonic::steady::Start;
use crate::model::Model;
use nalgebra::DMatrix;

/// A number of the model that a fit may change.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::diagnose) struct Unknown {
    /// Path in the model.
    pub path: String,
    /// Start, bounds, scale.
    pub parameter: Parameter,
    /// SI unit.
    pub unit: &'static str,
}

/// The result of a refit.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Fitted {
    /// The model with the parameters found.
    pub model: Model,
    /// ½ Σ of the squared weighted residuals of the fitted records.
    pub cost: f64,
    /// One per unknown, in their order, with 95 % intervals.
    pub estimates: Vec<Estimate>,
    /// Simulations of single records.
    pub simulations: usize,
    /// Where motions are solved for, those of the fitted records, by the records' indices.
    pub solutions: Vec<(usize, Start)>,
}

impl Fitted {
    /// Where a simulation of the record at `index` under the model found starts from, if the fit solved for it.
    pub fn seed(&self, index: usize) -> Option<Seed> {
        let found = self.solutions.iter().find(|(record, _)| *record == index);
        found.map(|(_, solution)| Seed::Near(solution.clone()))
    }
}

/// Longest step of differences in a parameter, in its coordinate of size one. Where that changes the predictions by more
/// than their noise, the step is shorter: beside a resonance or a fold, responses are straight over no more.
const STEP: f64 = 1e-5;
/// Shortest: what rounding leaves of the differences is still small.
const SHORTEST_STEP: f64 = 1e-8;

/// How thoroughly a fit is made.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) enum Effort {
    /// As it stands.
    None,
    /// Enough to see which start is best.
    Screen,
    /// Near to the minimum.
    Rough,
    /// To the minimum.
    Full,
    /// To the minimum, unless it can no longer be hoped to have a cost below this.
    Below(f64),
}

impl Effort {
    fn limits(self) -> Limits {
        let (iterations, tolerance) = match self {
            Self::None => (0, 1e-3),
            Self::Screen => (6, 1e-3),
            Self::Rough => (20, 1e-4),
            Self::Full | Self::Below(_) => (40, 1e-6),
        };
        let useful = if let Self::Below(useful) = self { useful } else { f64::INFINITY };
        Limits { iterations, tolerance, useful, ..Limits::default() }
    }
}

/// Fits `unknowns` of `model` to `records`.
///
/// # Errors
/// Why the start cannot be evaluated.
pub(in crate::diagnose) fn fit(
    bench: &WeightedDataset,
    model: &Model,
    unknowns: &[Unknown],
    records: &[usize],
    effort: Effort,
) -> Result<Fitted, String> {
    // Who interrupts waits for the end; what was begun is finished roughly, nothing more is tried.
    if effort != Effort::Full && bench.interrupted() {
        return Err("interrupted".to_owned());
    }
    let mut joint = Joint::new(bench, model, unknowns, records)?;
    let (lower, upper): (Vec<f64>, Vec<f64>) = joint.coordinates().map(|c| (c.lower, c.upper)).unzip();
    let start = vec![0.0; lower.len()];
    // A failure at the start says why; within the fit it is a rejected step.
    joint.model(&start)?;
    let end = minimise(&mut joint, start, &lower, &upper, effort.limits());
    let end =
        end.ok_or_else(|| joint.failure.clone().unwrap_or_else(|| "the fit cannot start".to_owned()))?;
    let model = joint.model(&end.y)?;
    let estimates = match effort {
        Effort::Screen | Effort::Rough => Vec::new(),
        // What is no minimum has no intervals.
        _ if end.ending.is_none() || effort == Effort::None || bench.interrupted() => {
            let none = vec![None; joint.shared.len()];
            joint.estimates_with(&end.y, &none)
        }
        _ => joint.estimates(&end.y, &lower, &upper),
    };
    let found = joint.records.iter().filter_map(|slot| Some((slot.index, slot.shown.solution()?.clone())));
    let solutions = found.collect();
    let simulations = joint.simulations;
    bench.count(simulations);
    bench.count_refit();
    Ok(Fitted { model, cost: end.sums.cost, estimates, simulations, solutions })
}

/// The problem: shared coordinates first, then each record's own.
struct Joint<'a, 'd> {
    bench: &'a WeightedDataset<'d>,
    base: &'a Model,
    unknowns: &'a [Unknown],
    shared: Vec<Coordinate>,
    /// Step of differences in each of them.
    steps: Vec<f64>,
    records: Vec<Slot<'d>>,
    simulations: usize,
    failure: Option<String>,
}

/// A record within the problem.
struct Slot<'d> {
    index: usize,
    shown: ObservedSimulation<'d>,
    /// Coordinates of its own unknowns, and where the first of them stands.
    own: Vec<Coordinate>,
    offset: usize,
    predictions: Vec<f64>,
    derivatives: Vec<Vec<f64>>,
}

impl<'a, 'd> Joint<'a, 'd> {
    fn new(
        bench: &'a WeightedDataset<'d>,
        base: &'a Model,
        unknowns: &'a [Unknown],
        records: &[usize],
    ) -> Result<Self, String> {
        let shared = unknowns
            .iter()
            .enumerate()
            .map(|(index, unknown)| coordinate(index, &unknown.parameter))
            .collect::<Result<Vec<_>, _>>()?;
        let start = set(base, unknowns, unknowns.iter().map(|unknown| unknown.parameter.start))?;
        let mut slots: Vec<Slot> = records
            .par_iter()
            .map(|&index| {
                let mut shown = bench.lanes[index].shown(base)?;
                let own = shown.nuisances(&start)?;
                let own =
                    own.iter().enumerate().map(|(i, p)| coordinate(i, p)).collect::<Result<Vec<_>, _>>()?;
                Ok(Slot { index, shown, own, offset: 0, predictions: Vec::new(), derivatives: Vec::new() })
            })
            .collect::<Result<_, String>>()?;
        let mut offset = shared.len();
        for slot in &mut slots {
            slot.offset = offset;
            offset += slot.own.len();
        }
        let steps = vec![STEP; shared.len()];
        Ok(Self { bench, base, unknowns, shared, steps, records: slots, simulations: 0, failure: None })
    }

    /// Makes the starts that fit each record best under `model` the middle of its own coordinates.
    fn settle(&mut self, model: &Model) -> Result<(), String> {
        let lanes = &self.bench.lanes;
        self.records.par_iter_mut().filter(|slot| !slot.own.is_empty()).try_for_each(|slot| {
            let lane = &lanes[slot.index];
            let mut parameters = slot.shown.nuisances(model)?;
            let settled = slot.shown.settle_from(model, &parameters, &lane.measured, &lane.weights);
            for (index, (parameter, value)) in parameters.iter_mut().zip(settled).enumerate() {
                parameter.start = value;
                slot.own[index] = coordinate(index, parameter)?;
            }
            Ok(())
        })
    }

    fn coordinates(&self) -> impl Iterator<Item = &Coordinate> {
        self.shared.iter().chain(self.records.iter().flat_map(|slot| &slot.own))
    }

    fn model(&self, y: &[f64]) -> Result<Model, String> {
        set(self.base, self.unknowns, self.shared.iter().zip(y).map(|(c, y)| c.value(*y)))
    }

    /// The models a small step away along each shared coordinate, with the steps.
    fn moved(&self, y: &[f64]) -> Result<Vec<(Model, f64)>, String> {
        (0..self.shared.len())
            .map(|j| {
                let mut moved = y[..self.shared.len()].to_vec();
                let step = inward(y[j], self.shared[j].upper, self.steps[j]);
                moved[j] += step;
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

    /// Leaves predictions and derivatives at `y` in every slot.
    fn linearise(&mut self, y: &[f64]) -> Result<(), String> {
        let model = self.model(y)?;
        let moved = self.moved(y)?;
        self.records.par_iter_mut().try_for_each(|slot| slot.linearise(&model, &moved, y))?;
        self.simulations += self.records.iter().map(|slot| 1 + moved.len() + slot.own.len()).sum::<usize>();
        Ok(())
    }

    /// Estimates with 95 % intervals. The residuals' correlation in time is taken into account: the
    /// gradient's variance is that of its sums over blocks longer than the correlation.
    fn estimates(&mut self, y: &[f64], lower: &[f64], upper: &[f64]) -> Vec<Estimate> {
        let deviation = match self.linearise(y) {
            Ok(()) => self.deviations(y, lower, upper),
            Err(_) => vec![None; self.shared.len()],
        };
        self.estimates_with(y, &deviation)
    }

    /// Estimates with the half-widths `deviation` of their intervals.
    fn estimates_with(&self, y: &[f64], deviation: &[Option<f64>]) -> Vec<Estimate> {
        let one = |index: usize| {
            let (unknown, coordinate) = (&self.unknowns[index], self.shared[index]);
            let value = coordinate.value(y[index]);
            let ends = deviation[index]
                .map(|reach| [coordinate.value(y[index] - reach), coordinate.value(y[index] + reach)]);
            Estimate {
                name: unknown.path.clone(),
                value,
                low: ends.map(|ends| ends[0]),
                high: ends.map(|ends| ends[1]),
                unit: unknown.unit,
            }
        };
        (0..self.shared.len()).map(one).collect()
    }

    /// The sums over all records that variances are made of, each of the `n` unknowns where `place` puts the
    /// `k`-th column of a record.
    fn products(&self, n: usize, place: impl Fn(&Slot, usize) -> usize) -> Products {
        let lanes = &self.bench.lanes;
        let residuals: Vec<Vec<f64>> =
            self.records.iter().map(|slot| lanes[slot.index].residuals(&slot.predictions)).collect();
        let length = blocks::length(residuals.iter().map(Vec::as_slice));
        let zeros = || DMatrix::<f64>::zeros(n, n);
        let mut sums = Products {
            curvature: zeros(),
            outer: zeros(),
            neighbours: zeros(),
            count: 0,
            blocks: 0,
            square: 0.0,
        };
        for (slot, residuals) in self.records.iter().zip(&residuals) {
            let lane = &lanes[slot.index];
            let columns: Vec<(usize, &[f64])> = slot
                .derivatives
                .iter()
                .enumerate()
                .map(|(k, column)| (place(slot, k), column.as_slice()))
                .collect();
            for (_, range) in &lane.channels {
                let mut before = vec![0.0; columns.len()];
                for block in blocks::within(range.clone(), length) {
                    let mut gradient = vec![0.0; columns.len()];
                    for i in block {
                        for (a, (_, da)) in columns.iter().enumerate() {
                            gradient[a] += da[i] * lane.weights[i] * residuals[i];
                        }
                        sums.square += residuals[i] * residuals[i];
                        sums.count += 1;
                    }
                    for (a, (ja, _)) in columns.iter().enumerate() {
                        for (b, (jb, _)) in columns.iter().enumerate() {
                            sums.outer[(*ja, *jb)] += gradient[a] * gradient[b];
                            sums.neighbours[(*ja, *jb)] += gradient[a] * before[b] + before[a] * gradient[b];
                        }
                    }
                    before = gradient;
                    sums.blocks += 1;
                }
            }
            slot.add_curvature(&columns, &lane.weights, &mut sums.curvature);
        }
        sums
    }

    /// Half-widths of the intervals of the shared coordinates; `None` where the data do not determine one.
    fn deviations(&self, y: &[f64], lower: &[f64], upper: &[f64]) -> Vec<Option<f64>> {
        let n = y.len();
        let place = |slot: &Slot, k: usize| slot.place(k, self.shared.len());
        let sums = self.products(n, place);
        let Products { curvature, count, blocks, square, .. } = &sums;
        let (count, blocks) = (*count, *blocks);
        let free: Vec<usize> =
            (0..n).filter(|&j| curvature[(j, j)] > 0.0 && y[j] > lower[j] && y[j] < upper[j]).collect();
        let mut result = vec![None; self.shared.len()];
        if count <= free.len() || blocks <= free.len() + 1 {
            return result;
        }
        let size: Vec<f64> = free.iter().map(|&j| curvature[(j, j)].sqrt()).collect();
        let scaled = DMatrix::from_fn(free.len(), free.len(), |a, b| {
            curvature[(free[a], free[b])] / (size[a] * size[b]) + if a == b { 1e-12 } else { 0.0 }
        });
        let Some(inverse) = scaled.try_inverse() else { return result };
        // Each estimate is the gradient along one direction.
        let mut along = DMatrix::zeros(n, free.len());
        for (a, &j) in free.iter().enumerate() {
            (0..free.len()).for_each(|b| along[(j, b)] = inverse[(a, b)] / size[a]);
        }
        let sandwich = sums.variances(&along);
        let variance = square / (count - free.len()) as f64;
        let correction = blocks as f64 / (blocks - free.len()) as f64;
        let quantile = student_quantile(0.975, blocks - free.len());
        for (a, &j) in free.iter().enumerate() {
            let larger = (variance * inverse[(a, a)]).max(correction * sandwich[a]);
            let reach = quantile * larger.sqrt() / size[a];
            // Wider than the range itself is no determination.
            let determined = reach.is_finite() && inverse[(a, a)] < 1e10;
            if j < result.len() && determined {
                result[j] = Some(reach);
            }
        }
        result
    }
}

/// Sums over records of products of weighted changes.
pub(in crate::diagnose) struct Products {
    /// Of every two unknowns' changes.
    pub curvature: DMatrix<f64>,
    /// Of what the residuals make of every two unknowns' gradients, block by block.
    outer: DMatrix<f64>,
    /// The same of blocks side by side: noise does not end where a block does.
    neighbours: DMatrix<f64>,
    /// Samples, blocks of them that count as independent, and the sum of squared residuals.
    pub count: usize,
    blocks: usize,
    square: f64,
}

impl Products {
    /// Variance of what the residuals make of the gradient along each column of `along`: of its sums over blocks
    /// longer than their correlation, and of what neighbouring blocks have in common where that adds to it. Noise of
    /// a correlation that falls by 1/e in a fifth of a block has a third of its variance there.
    pub fn variances(&self, along: &DMatrix<f64>) -> Vec<f64> {
        let of = |sums: &DMatrix<f64>| (along.transpose() * sums * along).diagonal();
        of(&self.outer).iter().zip(&of(&self.neighbours)).map(|(own, shared)| own + shared.max(0.0)).collect()
    }
}

/// Products of the weighted changes along every unknown of `model` (those of the records' starts among them), then
/// of the whole change to each of `probes`; and where the probes begin.
pub(in crate::diagnose) fn products(
    bench: &WeightedDataset,
    model: &Model,
    unknowns: &[Unknown],
    records: &[usize],
    probes: &[Model],
) -> Result<(Products, usize), String> {
    let mut joint = Joint::new(bench, model, unknowns, records)?;
    joint.settle(model)?;
    let base = joint.coordinates().count();
    let start = vec![0.0; base];
    let here = joint.model(&start)?;
    let mut moved = joint.moved(&start)?;
    moved.extend(probes.iter().map(|probe| (probe.clone(), 1.0)));
    joint.records.par_iter_mut().try_for_each(|slot| slot.linearise(&here, &moved, &start))?;
    joint.simulations += joint.records.len() * (1 + moved.len());
    let shared = joint.shared.len();
    let place = |slot: &Slot, k: usize| match k {
        k if k < shared => k,
        k if k < shared + probes.len() => base + k - shared,
        k => slot.offset + k - shared - probes.len(),
    };
    let sums = joint.products(base + probes.len(), place);
    bench.count(joint.simulations);
    Ok((sums, base))
}

/// The value of every unknown put into a copy of `base`.
pub(in crate::diagnose) fn set(
    base: &Model,
    unknowns: &[Unknown],
    values: impl Iterator<Item = f64>,
) -> Result<Model, String> {
    let mut model = base.clone();
    let pairs: Vec<(&str, f64)> = unknowns.iter().map(|unknown| unknown.path.as_str()).zip(values).collect();
    model.set_all(&pairs).map_err(|error| error.to_string())?;
    Ok(model)
}

fn coordinate(index: usize, parameter: &Parameter) -> Result<Coordinate, String> {
    Coordinate::new(parameter).map_err(|what| format!("parameter {index}: {what}"))
}

impl Slot<'_> {
    fn own_values(&self, y: &[f64]) -> Vec<f64> {
        self.own.iter().zip(&y[self.offset..]).map(|(c, y)| c.value(*y)).collect()
    }

    fn linearise(&mut self, model: &Model, moved: &[(Model, f64)], y: &[f64]) -> Result<(), String> {
        let nuisances = self.own_values(y);
        let mut directions: Vec<Direction> = moved
            .iter()
            .map(|(model, step)| Direction {
                model: model.clone(),
                nuisances: nuisances.clone(),
                step: *step,
            })
            .collect();
        for (k, coordinate) in self.own.iter().enumerate() {
            let here = y[self.offset + k];
            let step = inward(here, coordinate.upper, NUISANCE_STEP);
            let mut nuisances = nuisances.clone();
            nuisances[k] = coordinate.value(here + step);
            directions.push(Direction { model: model.clone(), nuisances, step });
        }
        let (predictions, derivatives) = (&mut self.predictions, &mut self.derivatives);
        self.shown.linearise(model, &nuisances, &directions, predictions, derivatives)
    }

    /// The unknown that the `k`-th derivative belongs to.
    fn place(&self, k: usize, shared: usize) -> usize {
        if k < shared { k } else { self.offset + k - shared }
    }

    /// The derivatives with the index of the unknown each belongs to.
    fn columns(&self, shared: usize) -> Vec<(usize, &[f64])> {
        let place = |k| self.place(k, shared);
        self.derivatives.iter().enumerate().map(|(k, column)| (place(k), column.as_slice())).collect()
    }

    fn add_curvature(&self, columns: &[(usize, &[f64])], weights: &[f64], curvature: &mut DMatrix<f64>) {
        for (a, (ja, da)) in columns.iter().enumerate() {
            for (jb, db) in &columns[..=a] {
                let sum: f64 = da.iter().zip(*db).zip(weights).map(|((x, y), w)| x * y * w * w).sum();
                curvature[(*ja, *jb)] += sum;
                if ja != jb {
                    curvature[(*jb, *ja)] += sum;
                }
            }
        }
    }

    fn cost(
        &mut self,
        model: &Model,
        y: &[f64],
        lanes: &[crate::diagnose::measurements::weighted_dataset::RecordResiduals],
    ) -> Result<f64, String> {
        let nuisances = self.own_values(y);
        self.shown.predict(model, &nuisances, &mut self.predictions)?;
        let lane = &lanes[self.index];
        let pairs = self.predictions.iter().zip(&lane.measured).zip(&lane.weights);
        Ok(0.5 * pairs.map(|((value, measured), weight)| ((value - measured) * weight).powi(2)).sum::<f64>())
    }
}

impl SumOfSquares for Joint<'_, '_> {
    fn cost(&mut self, y: &[f64]) -> Option<f64> {
        let model = self.model(y).ok()?;
        self.simulations += self.records.len();
        let lanes = &self.bench.lanes;
        let costs: Result<Vec<f64>, String> =
            self.records.par_iter_mut().map(|slot| slot.cost(&model, y, lanes)).collect();
        match costs {
            Ok(costs) => Some(costs.iter().sum::<f64>()).filter(|cost| cost.is_finite()),
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
        let n = y.len();
        let mut gradient = vec![0.0; n];
        let mut curvature = DMatrix::zeros(n, n);
        let mut cost = 0.0;
        for slot in &self.records {
            let lane = &self.bench.lanes[slot.index];
            let residuals = lane.residuals(&slot.predictions);
            cost += 0.5 * residuals.iter().map(|r| r * r).sum::<f64>();
            let columns = slot.columns(self.shared.len());
            for (j, column) in &columns {
                let terms = column.iter().zip(&residuals).zip(&lane.weights);
                gradient[*j] += terms.map(|((d, r), w)| d * r * w).sum::<f64>();
            }
            slot.add_curvature(&columns, &lane.weights, &mut curvature);
        }
        for (j, step) in self.steps.iter_mut().enumerate() {
            *step = (1.0 / f64::sqrt(curvature[(j, j)])).clamp(SHORTEST_STEP, STEP);
        }
        let finite = cost.is_finite() && gradient.iter().all(|g| g.is_finite());
        finite.then(|| Sums { cost, gradient, curvature: curvature.transpose().as_slice().to_vec() })
    }

    fn interrupted(&self) -> bool {
        self.bench.interrupted()
    }
}
