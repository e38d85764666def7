//! How far the likelihood reaches. Its curvature at the top tells that only where it is smooth: a slider that turns one sample
//! earlier gives it a corner, and those of many sliders a rough top, on which a fit stops at the first small peak with an
//! interval as narrow as that. Where it falls less than the curvature promises, it is followed along that axis of the
//! covariance: its mean there and its deviation are those told.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::costs::Costs;
use super::driven::widen;
use crate::diagnose::evidence::joint::{Joint, Whitened, dot, minus};
use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::Measured;
use crate::diagnose::evidence::posterior::{HERE, Posterior, ROUND, white_round};
use crate::fit::SumOfSquares;
use crate::fit::predict::WRONG_BRANCH;

/// How far from the top, in deviations, the likelihood must have fallen, and by how much of what its curvature promises there: far
/// away no more is asked than that it has no other top.
const REACHES: [(f64, f64); 3] = [(4.0, 0.64), (8.0, 0.4), (16.0, 0.4)];
/// The nearest place that says anything, in deviations: a fit ends a little off its top.
const NEAREST: f64 = 2.0;
/// How far it is followed at most, where its best place is the last one.
const FARTHEST: f64 = 64.0;
/// How much worse than the best place, in natural units of the logarithm, the mean may fit to be told.
const WORSE: f64 = 2.0;

/// Moves `posterior` to the middle of the likelihood and makes its deviations as wide as that is, where it falls less than its
/// curvature promises; whether it does, and what is to be said of it.
pub(super) fn follow(data: &Measured, posterior: &mut Posterior) -> (bool, Option<String>) {
    try_to_follow(data, posterior).unwrap_or_else(|reason| {
        (false, Some(format!("the intervals are those of the curvature at the best fit alone: {reason}")))
    })
}

fn try_to_follow(data: &Measured, posterior: &mut Posterior) -> Result<(bool, Option<String>), String> {
    data.bench.unless_interrupted()?;
    let (latent, count) = (Latent::default(), posterior.unknowns.len());
    let Posterior { model, unknowns, y, .. } = posterior.clone();
    let mut profile = Profile::new(Joint::new(data, &model, &unknowns, &latent)?, &y[..count])?;
    let axes = profile.in_order();
    let is_followed = axes.into_iter().filter(|k| profile.follow(*k)).count() > 0;
    data.bench.count(profile.joint.simulations);
    if is_followed {
        profile.tell(posterior)?;
    }
    let beyond = profile.beyond.map(|k| {
        let path = &unknowns[profile.most_moved(k)].path;
        format!("a better fit may lie beyond the interval of {path}: the likelihood still rises there")
    });
    Ok((is_followed, beyond))
}

/// Costs along axes through the end of a fit.
struct Profile<'a, 'd> {
    joint: Joint<'a, 'd>,
    parameters: usize,
    /// The end of the fit.
    end: DVector<f64>,
    /// Covariance there.
    covariance: DMatrix<f64>,
    /// Columns that make up that of the parameters, one deviation long each, and for each parameter at its bound its own change
    /// inwards; the rest of the unknowns goes with them.
    axes: DMatrix<f64>,
    /// How many of them are not of a parameter at its bound.
    free: usize,
    /// Unknowns at their bounds.
    held: Vec<usize>,
    linear: Vec<Whitened>,
    predictions: Vec<Vec<f64>>,
    /// The middle of the likelihood, and its deviations, along the axes.
    middle: DVector<f64>,
    deviations: DVector<f64>,
    /// An axis at whose end the likelihood still rises.
    beyond: Option<usize>,
}

impl<'a, 'd> Profile<'a, 'd> {
    /// About the `parameters` at the end of a fit.
    fn new(mut joint: Joint<'a, 'd>, parameters: &[f64]) -> Result<Self, String> {
        let mut y = white_round(&mut joint, parameters, HERE)?;
        joint.noise.renew(joint.data, &joint.priors, &joint.residuals(), true);
        // Records' own starts were scanned, not fitted, and all secants are those of a first look.
        joint.forget_linearised();
        let extent = if y.len() > parameters.len() { ROUND } else { HERE };
        joint.minimise(&mut y, extent)?;
        joint.noise.renew(joint.data, &joint.priors, &joint.residuals(), true);
        let (n, count) = (y.len(), parameters.len());
        let mut curvature = DMatrix::from_row_slice(n, n, &joint.sums_here(&y).curvature);
        let unheld = curvature.clone();
        let held = joint.hold(&y, &mut curvature);
        let covariance = curvature.cholesky().ok_or("the curvature is not positive")?.inverse();
        let free: Vec<usize> = (0..count).filter(|i| !held.contains(i)).collect();
        let mut axes = principal(&covariance, &free);
        let (lower, upper) = joint.bounds();
        for i in held.iter().copied().take_while(|i| *i < count) {
            let sign = if upper[i] - y[i] < y[i] - lower[i] { -1.0 } else { 1.0 };
            axes.extend(std::iter::once(sign * alone(i, &held, &unheld, &covariance)));
        }
        Ok(Self {
            linear: joint.whitened(),
            predictions: joint.predictions(),
            joint,
            parameters: count,
            end: DVector::from_vec(y),
            covariance,
            middle: DVector::zeros(axes.ncols()),
            deviations: DVector::from_element(axes.ncols(), 1.0),
            axes,
            free: free.len(),
            held,
            beyond: None,
        })
    }

    /// Those of parameters at their bounds first, for what they move the others by to first order alone; the widest first.
    fn in_order(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.axes.ncols()).collect();
        let wide = |k: &usize| self.axes.column(*k).norm();
        order.sort_by(|a, b| (*a < self.free).cmp(&(*b < self.free)).then(wide(b).total_cmp(&wide(a))));
        order
    }

    /// The parameter that is at its bound, or that moves most along axis `k`.
    fn most_moved(&self, k: usize) -> usize {
        let of_held = k.checked_sub(self.free).map(|place| self.held[place]);
        of_held.unwrap_or_else(|| self.axes.column(k).rows(0, self.parameters).iamax())
    }

    /// `place` deviations from the middle along axis `k`; the records' own unknowns go along as far as they may.
    fn point(&self, k: usize, place: f64) -> Vec<f64> {
        let mut along = self.middle.clone();
        along[k] += place;
        let (lower, upper) = self.joint.bounds();
        let point = &self.end + &self.axes * along;
        (0..point.len()).map(|i| point[i].clamp(lower[i], upper[i])).collect()
    }

    /// The farthest place within the bounds of the parameters, at most as far as `place`.
    fn inside(&self, k: usize, place: f64) -> f64 {
        let (lower, upper) = self.joint.bounds();
        let here = self.point(k, 0.0);
        let within = |i: usize| {
            let by = place * self.axes[(i, k)];
            let room = if by > 0.0 { upper[i] - here[i] } else { here[i] - lower[i] };
            if room < by.abs() { room.max(0.0) / by.abs() } else { 1.0 }
        };
        place * (0..self.parameters).map(within).fold(1.0, f64::min)
    }

    /// The cost there, with all other unknowns at their best to first order; infinite where another response is, or none.
    fn cost(&mut self, k: usize, place: f64) -> f64 {
        let y = self.point(k, place);
        let Some(cost) = self.joint.cost(&y) else { return f64::INFINITY };
        let (data, slots) = (self.joint.data, &self.joint.slots);
        let apart = |k: usize| data.size_of(k, &minus(&slots[k].predictions, &self.predictions[k]));
        let is_solved = |k: usize| data.lane(k).seed.is_some();
        if (0..slots.len()).any(|k| is_solved(k) && apart(k) > WRONG_BRANCH) {
            return f64::INFINITY;
        }
        let gradient = self.gradient(&y);
        // What the axis itself changes is no other.
        let own = if k < self.free { self.axes.column(k).dot(&gradient) } else { 0.0 };
        cost - 0.5 * (gradient.dot(&(&self.covariance * &gradient)) - own * own)
    }

    /// Of the cost at `y`, which was tried last, by the derivatives at the end of the fit.
    fn gradient(&self, y: &[f64]) -> DVector<f64> {
        let Joint { data, noise, slots, .. } = &self.joint;
        let there: Vec<&Vec<f64>> = slots.iter().map(|slot| &slot.predictions).collect();
        let of_record = |(k, record): (usize, &Whitened)| {
            let residual = noise.whiten(data, k, &minus(there[k], &data.lane(k).measured));
            record.columns.iter().map(|(i, column)| (*i, dot(column, &residual))).collect::<Vec<_>>()
        };
        let parts: Vec<Vec<(usize, f64)>> = self.linear.par_iter().enumerate().map(of_record).collect();
        let mut gradient = DVector::from_column_slice(y);
        parts.iter().flatten().for_each(|(i, part)| gradient[*i] += part);
        self.held.iter().for_each(|i| gradient[*i] = 0.0);
        gradient
    }

    /// Follows the likelihood along axis `k` if it falls less than its curvature promises; whether it does.
    fn follow(&mut self, k: usize) -> bool {
        let Some(mut along) = self.slower(k) else { return false };
        let mut ends = [-1.0, 1.0].map(|sign| sign * REACHES[REACHES.len() - 1].0);
        while let Some(side) = along.rises_at(ends) {
            ends[side] *= 2.0;
            if ends[side].abs() > FARTHEST {
                self.beyond = Some(k);
                break;
            }
            let place = self.inside(k, ends[side]);
            along.add(place, self.cost(k, place));
        }
        along.fill(|place| self.cost(k, place));
        let Some([mean, deviation]) = along.moments() else { return false };
        let at_mean = self.cost(k, mean);
        if self.joint.data.bench.interrupted() {
            return false;
        }
        let [best, least] = along.best();
        let middle = if at_mean <= least + WORSE { mean } else { best };
        self.middle[k] += middle;
        // What noise of the inputs does to it makes a likelihood narrow, too.
        self.deviations[k] = deviation.hypot(mean - middle).max(1.0);
        true
    }

    /// The costs along axis `k`, if they rise less than the curvature promises.
    fn slower(&mut self, k: usize) -> Option<Costs> {
        let here = self.cost(k, 0.0);
        let mut along = Costs::at([0.0, here]);
        let mut is_slower = false;
        for (reach, least) in REACHES {
            for place in
                [-reach, reach].map(|place| self.inside(k, place)).into_iter().filter(|at| *at != 0.0)
            {
                let cost = self.cost(k, place);
                is_slower |= place.abs() > NEAREST && cost - here < least * 0.5 * place * place;
                along.add(place, cost);
            }
        }
        (is_slower && here.is_finite()).then_some(along)
    }

    /// Takes the middle and its deviations over.
    fn tell(&self, posterior: &mut Posterior) -> Result<(), String> {
        let y = self.point(0, 0.0);
        posterior.model = self.joint.model(&y[..self.parameters])?;
        posterior.y[..self.parameters].copy_from_slice(&y[..self.parameters]);
        let more = self.deviations.map(|deviation| deviation * deviation - 1.0);
        widen(posterior, &(&self.axes * DMatrix::from_diagonal(&more) * self.axes.transpose()));
        Ok(())
    }
}

/// Columns that make up the `covariance` of the unknowns `free`, one deviation long each.
fn principal(covariance: &DMatrix<f64>, free: &[usize]) -> DMatrix<f64> {
    let of_free = covariance.select_columns(free);
    if free.is_empty() {
        return of_free;
    }
    let eigen = of_free.select_rows(free).symmetric_eigen();
    let scaled = |i: usize, k: usize| eigen.eigenvectors[(i, k)] / eigen.eigenvalues[k].sqrt();
    of_free * DMatrix::from_fn(free.len(), free.len(), scaled)
}

/// The change of the unknown `i`, one of the `held`, while the others of them stay: one deviation long under the curvature
/// `unheld`, the free ones at their best by their `covariance`.
fn alone(i: usize, held: &[usize], unheld: &DMatrix<f64>, covariance: &DMatrix<f64>) -> DVector<f64> {
    let mut pull = unheld.column(i).into_owned();
    held.iter().for_each(|k| pull[*k] = 0.0);
    let mut change = -(covariance * &pull);
    // Of the prior there is one at least.
    let curvature = (unheld[(i, i)] + pull.dot(&change)).max(1.0);
    change[i] = 1.0;
    change / curvature.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;
    use crate::diagnose::Assumptions;
    use crate::diagnose::evidence::samples::{moved, slider};
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::colour::Colour;
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::model::Model;
    use crate::numeric::random::Random;

    const SAMPLES: u32 = 1200;

    /// A contact moved from rest, slowly changing its pace. Its force is measured with noise that remembers `memory` of itself from
    /// one sample to the next, its displacement with a tenth of that.
    fn measured(truth: &Model, [noise, memory]: [f64; 2], random: &mut Random) -> Dataset {
        const STEP: f64 = 5e-3;
        let record = |amplitude: f64| {
            let motion = |i: u32| {
                let time = STEP * f64::from(i);
                amplitude * (0.4 + 0.1 * time) * (4.0 * time * (1.0 + 0.05 * time)).sin()
            };
            let mut record = moved(truth, SAMPLES, STEP, motion);
            for (channel, of) in [(1, 0.07 * amplitude), (2, 35.0)] {
                let drawn = Colour { deviation: noise * of, memory }.drawn(SAMPLES as usize, random);
                record.channels[channel].values.iter_mut().zip(drawn).for_each(|(x, noise)| *x += noise);
            }
            record
        };
        Dataset { title: None, records: [3e-5, 6e-5, 1.2e-4].map(record).to_vec() }
    }

    /// As fitted from `model`, and as followed.
    fn followed(model: &Model, dataset: &Dataset) -> [Posterior; 2] {
        let bench = WeightedDataset::new(model, dataset, Assumptions::default(), None).unwrap();
        let all: Vec<usize> = (0..dataset.records.len()).collect();
        let data = Measured::new(&bench, &all, &[], &[]);
        let fitted = first(&data, None, model).and_then(|(first, _)| again(&data, &first)).unwrap();
        let mut followed = fitted.clone();
        assert_eq!(follow(&data, &mut followed).1, None);
        [fitted, followed]
    }

    #[test]
    fn intervals_of_many_sliders_are_as_wide_as_the_likelihood() {
        let truth = slider("[[effect]]\nid = \"micro_slip\"\nspread = 0.97\n");
        // Stiffness and spread, each in its deviations.
        let mut off = [[0.0; 2]; 2];
        for seed in 0..12 {
            let both = followed(&truth, &measured(&truth, [0.01, 0.93], &mut Random::new(seed)));
            for (off, of) in off.iter_mut().zip(&both) {
                let square = |k: usize| (of.y[k] / of.deviations[k]).powi(2) / 12.0;
                off.iter_mut().zip([0, 2]).for_each(|(off, k)| *off += square(k));
            }
        }
        let [fitted, followed] = off;
        assert!(fitted.iter().all(|square| *square > 5.0), "{fitted:?}");
        assert!(followed.iter().all(|square| (0.2..1.5).contains(square)), "{followed:?}");
    }

    #[test]
    fn a_smooth_likelihood_is_left_as_it_is() {
        let truth = slider("");
        for seed in 0..4 {
            let mut random = Random::new(seed);
            let mut dataset = measured(&truth, [0.0, 0.0], &mut random);
            let force = dataset.records.iter_mut().flat_map(|record| &mut record.channels[2].values);
            force.for_each(|force| *force += 0.2 * random.normal());
            let [fitted, followed] = followed(&truth, &dataset);
            assert_eq!((fitted.y, fitted.deviations), (followed.y, followed.deviations));
        }
    }

    /// The ends of fits from `model` at which the unknown in place `k` is at its bound, and what became of them when they were
    /// followed, of so many measurements of `truth` with noise `of` its force.
    fn from_bound(truth: &Model, model: &Model, k: usize, of: [f64; 2], count: u64) -> Vec<[Posterior; 2]> {
        let both = |seed| followed(model, &measured(truth, of, &mut Random::new(seed)));
        let at_bound = |of: &Posterior| of.unknowns[k].coordinate.is_at_bound(of.y[k]);
        (0..count).map(both).filter(|[fitted, _]| at_bound(fitted)).collect()
    }

    #[test]
    fn a_fit_that_stuck_at_a_bound_is_followed_from_there() {
        let model = |spread: f64| slider(&format!("[[effect]]\nid = \"micro_slip\"\nspread = {spread}\n"));
        let stuck = from_bound(&model(0.97), &model(1.0), 2, [0.01, 0.93], 12);
        assert!(stuck.len() > 1, "{}", stuck.len());
        let holds = |of: &Posterior| {
            let spread = of.estimates().swap_remove(2);
            spread.low.zip(spread.high).is_some_and(|(low, high)| low < 0.97 && 0.97 < high)
        };
        assert!(stuck.iter().all(|[fitted, followed]| !holds(fitted) && holds(followed)), "{stuck:?}");
    }

    #[test]
    fn a_smooth_likelihood_that_ends_at_a_bound_is_left_as_it_is() {
        let model = Model::parse(
            "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"bouc_wen\"\n\
             tangential_stiffness = 2e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\nsharpness = 2.0\n\
             unloading_ratio = 1.0\n",
        )
        .unwrap();
        let ends = from_bound(&model, &model, 3, [0.003, 0.0], 16);
        assert!(ends.len() > 1, "{}", ends.len());
        for [fitted, followed] in ends {
            assert_eq!((fitted.y, fitted.deviations), (followed.y, followed.deviations));
        }
    }

    #[test]
    fn a_parameter_at_its_bound_takes_the_free_ones_along_and_no_other_that_is_held() {
        let truth = slider("[[effect]]\nid = \"micro_slip\"\nspread = 0.97\n");
        let dataset = measured(&truth, [0.01, 0.0], &mut Random::new(1));
        let bench = WeightedDataset::new(&truth, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let fitted = first(&data, None, &truth).unwrap().0;
        let latent = Latent::default();
        let joint = || Joint::new(&data, &fitted.model, &fitted.unknowns, &latent).unwrap();
        let (lower, upper) = joint().bounds();
        let mut start = [0.0; 3];
        for (place, end, sign) in [(2, upper[2], -1.0), (0, lower[0], 1.0), (1, upper[1], -1.0)] {
            start[place] = end;
            let profile = Profile::new(joint(), &start).unwrap();
            let curvature = profile.joint.sums_here(&start).curvature;
            let curvature = DMatrix::from_row_slice(3, 3, &curvature);
            assert_eq!(profile.axes.ncols(), 3);
            for (k, i) in (profile.free..3).zip(&profile.held) {
                let along = profile.axes.column(k);
                let pull = &curvature * along;
                assert!((along.dot(&pull) - 1.0).abs() < 1e-9, "{along} {pull}");
                let others = profile.held.iter().filter(|other| *other != i);
                assert!(others.into_iter().all(|other| along[*other] == 0.0), "{along}");
                let free = (0..3).filter(|other| !profile.held.contains(other));
                assert!(
                    free.into_iter().all(|other| pull[other].abs() < 1e-6 * pull[*i].abs()),
                    "{along} {pull}"
                );
                if *i == place {
                    assert!(along[place] * sign > 0.0, "{along}");
                    assert_eq!(profile.inside(k, -4.0), 0.0);
                }
                assert_eq!(profile.most_moved(k), *i);
            }
        }
    }
}
