//! How far the likelihood reaches. Its curvature at the top tells that only where it is smooth: a slider that turns one sample
//! earlier gives it a corner, and those of many sliders a rough top, on which a fit stops at the first small peak with an
//! interval as narrow as that. Where it falls less than the curvature promises, it is followed along that axis of the
//! covariance: its mean there and its deviation are those told.

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

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
/// Places at which it is evaluated along an axis that is followed.
const PLACES: usize = 32;
/// Parts of a stretch between two of them that its moments are summed by.
const PARTS: usize = 8;
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
    let axes = profile.widest_first();
    let is_followed = axes.into_iter().filter(|k| profile.follow(*k)).count() > 0;
    data.bench.count(profile.joint.simulations);
    if is_followed {
        profile.tell(posterior)?;
    }
    let beyond = profile.beyond.map(|k| {
        let path = &unknowns[profile.axes.column(k).rows(0, count).iamax()].path;
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
    /// Columns that make up that of the parameters, one deviation long each; the rest of the unknowns goes with them.
    axes: DMatrix<f64>,
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
        let held = joint.hold(&y, &mut curvature);
        let covariance = curvature.cholesky().ok_or("the curvature is not positive")?.inverse();
        let free: Vec<usize> = (0..count).filter(|i| !held.contains(i)).collect();
        let of_free = covariance.select_columns(&free);
        let axes = if free.is_empty() {
            of_free
        } else {
            let eigen = of_free.select_rows(&free).symmetric_eigen();
            let scaled = |i: usize, k: usize| eigen.eigenvectors[(i, k)] / eigen.eigenvalues[k].sqrt();
            of_free * DMatrix::from_fn(free.len(), free.len(), scaled)
        };
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
            held,
            beyond: None,
        })
    }

    fn widest_first(&self) -> Vec<usize> {
        let mut order: Vec<usize> = (0..self.axes.ncols()).collect();
        order.sort_by(|a, b| self.axes.column(*b).norm().total_cmp(&self.axes.column(*a).norm()));
        order
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
        let gain = gradient.dot(&(&self.covariance * &gradient)) - self.axes.column(k).dot(&gradient).powi(2);
        cost - 0.5 * gain
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
        for _ in along.0.len()..PLACES {
            let place = along.heaviest();
            along.add(place, self.cost(k, place));
        }
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
        let mut along = Costs(vec![[0.0, here]]);
        let mut is_slower = false;
        for (reach, least) in REACHES {
            for place in [-reach, reach].map(|place| self.inside(k, place)) {
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

/// Places along an axis in order, each with its cost; straight between them.
struct Costs(Vec<[f64; 2]>);

impl Costs {
    /// Unless the place is there already.
    fn add(&mut self, place: f64, cost: f64) {
        let after = self.0.partition_point(|[known, _]| *known < place);
        if self.0.get(after).is_none_or(|[known, _]| *known != place) {
            self.0.insert(after, [place, cost]);
        }
    }

    fn best(&self) -> [f64; 2] {
        self.0.iter().copied().min_by(|[_, a], [_, b]| a.total_cmp(b)).unwrap_or_default()
    }

    /// The side of the `ends` where the last place is both the end and the best one.
    fn rises_at(&self, ends: [f64; 2]) -> Option<usize> {
        (0..2).find(|side| self.best()[0] == ends[*side])
    }

    /// Parts of the stretch after place `k`: where each lies, and its likelihood over that of the best place.
    fn parts(&self, k: usize) -> impl Iterator<Item = [f64; 2]> {
        let least = self.best()[1];
        let ([from, cost], [to, other]) = (self.0[k], self.0[k + 1]);
        (0..PARTS).map(move |part| {
            let share = (part as f64 + 0.5) / PARTS as f64;
            let density = (least - (1.0 - share) * cost - share * other).exp();
            [from + share * (to - from), density * (to - from) / PARTS as f64]
        })
    }

    /// The middle of the stretch in which most of the likelihood lies, or may lie where one end has none.
    fn heaviest(&self) -> f64 {
        let weight = |k: usize| {
            let ([from, cost], [to, other]) = (self.0[k], self.0[k + 1]);
            if cost.is_infinite() != other.is_infinite() {
                (self.best()[1] - cost.min(other)).exp() * (to - from)
            } else {
                self.parts(k).map(|[_, weight]| weight).sum()
            }
        };
        let heaviest = (0..self.0.len().saturating_sub(1)).max_by(|a, b| weight(*a).total_cmp(&weight(*b)));
        heaviest.map_or(0.0, |k| 0.5 * (self.0[k][0] + self.0[k + 1][0]))
    }

    /// The mean and the deviation, if there is any stretch of likelihood.
    fn moments(&self) -> Option<[f64; 2]> {
        let parts = || (0..self.0.len() - 1).flat_map(|k| self.parts(k));
        let sum: f64 = parts().map(|[_, weight]| weight).sum();
        let mean = parts().map(|[place, weight]| place * weight).sum::<f64>() / sum;
        let square = parts().map(|[place, weight]| (place - mean).powi(2) * weight).sum::<f64>() / sum;
        (sum > 0.0 && square.is_finite()).then_some([mean, square.sqrt()])
    }
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

    /// As fitted from the truth, and as followed.
    fn followed(truth: &Model, dataset: &Dataset) -> [Posterior; 2] {
        let bench = WeightedDataset::new(truth, dataset, Assumptions::default(), None).unwrap();
        let all: Vec<usize> = (0..dataset.records.len()).collect();
        let data = Measured::new(&bench, &all, &[], &[]);
        let fitted = first(&data, None, truth).and_then(|(first, _)| again(&data, &first)).unwrap();
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

    /// Costs at the reaches, and at as many more places as are evaluated.
    fn evaluated(cost: impl Fn(f64) -> f64) -> Costs {
        let mut along = Costs(Vec::new());
        [-16.0, -8.0, -4.0, 0.0, 4.0, 8.0, 16.0].into_iter().for_each(|place| along.add(place, cost(place)));
        while along.0.len() < PLACES {
            let place = along.heaviest();
            along.add(place, cost(place));
        }
        along
    }

    #[test]
    fn moments_are_those_of_the_likelihood_wherever_its_top_is() {
        for (top, deviation) in [(0.0, 1.0), (3.0, 2.0), (-9.0, 0.7)] {
            let along = evaluated(|place| 0.5 * ((place - top) / deviation).powi(2) + 3.0);
            let [mean, wide] = along.moments().unwrap();
            assert!((mean - top).abs() < 0.1 * deviation, "{top}: {mean}");
            assert!((wide / deviation - 1.0).abs() < 0.1, "{top}: {wide}");
        }
    }

    #[test]
    fn places_without_a_prediction_weigh_nothing_and_are_approached() {
        for (from, to) in [(-7.9, 7.9), (-3.9, 7.9), (-16.0, 1.0)] {
            let along = evaluated(|place| if (from..=to).contains(&place) { 1.0 } else { f64::INFINITY });
            let [mean, deviation] = along.moments().unwrap();
            assert!((mean - 0.5 * (from + to)).abs() < 0.3, "{from} {to}: {mean}");
            assert!(
                (deviation * 12.0_f64.sqrt() / (to - from) - 1.0).abs() < 0.1,
                "{from} {to}: {deviation}"
            );
        }
        assert_eq!(Costs(vec![[-1.0, f64::INFINITY], [0.0, 2.0], [1.0, f64::INFINITY]]).moments(), None);
    }

    #[test]
    fn an_end_that_is_the_best_place_is_seen_and_a_bound_is_none() {
        let along = evaluated(|place| -place);
        assert_eq!(along.rises_at([-16.0, 16.0]), Some(1));
        assert_eq!(along.rises_at([-16.0, 32.0]), None);
    }

    #[test]
    fn parameters_that_are_all_at_their_bounds_are_not_followed() {
        let truth = slider("");
        let dataset = measured(&truth, [0.01, 0.0], &mut Random::new(1));
        let bench = WeightedDataset::new(&truth, &dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let fitted = first(&data, None, &truth).unwrap().0;
        let latent = Latent::default();
        let joint = Joint::new(&data, &fitted.model, &fitted.unknowns, &latent).unwrap();
        let (lower, _) = joint.bounds();
        let profile = Profile::new(joint, &lower).unwrap();
        assert_eq!(profile.axes.ncols(), 0);
        assert!(profile.widest_first().is_empty());
    }
}
