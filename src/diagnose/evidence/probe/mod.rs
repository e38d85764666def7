//! What small and large amounts of each candidate would change about a fitted hypothesis, to first order: which candidates
//! are worth a fit, and from where; `planes`: the same of two at once.

mod planes;

pub(super) use planes::{Plane, planes};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::joint::{Joint, Tangents, dot};
use super::latent::Latent;
use super::measured::Measured;
use super::posterior::{HERE, Posterior, white_round};
use super::unknown::{Coordinate, Unknown};
use crate::data::Dataset;
use crate::diagnose::assumptions::Assumptions;
use crate::diagnose::candidates::{Brought, Candidate};
use crate::effects::Scales;
use crate::model::Model;
use crate::vocabulary::Quantity;

/// A candidate with the priors of its parameters.
#[derive(Debug, Clone)]
pub(in crate::diagnose) struct Prepared {
    pub candidate: Candidate,
    pub quantities: Vec<&'static Quantity>,
    pub coordinates: Vec<Coordinate>,
    /// Where the coordinates behind the first are looked at.
    others: Vec<Vec<f64>>,
}

impl Prepared {
    /// `model` with it at these coordinates.
    pub fn added_to(&self, model: &Model, y: &[f64]) -> Model {
        let values: Vec<f64> = self.coordinates.iter().zip(y).map(|(c, y)| c.value(*y)).collect();
        self.candidate.added_to(model, &values)
    }

    /// `model` with one prior deviation of its first number, at all starts of the others.
    fn models_at(&self, model: &Model) -> Vec<Model> {
        self.others.iter().filter_map(|others| self.beside(model, &at(1.0, others))).collect()
    }

    /// Whether it is looked at in several places of a second number.
    pub fn has_places(&self) -> bool {
        self.others.len() > 1
    }

    /// The same where that is a legal model.
    pub fn beside(&self, model: &Model, y: &[f64]) -> Option<Model> {
        Some(self.added_to(model, y)).filter(|model| model.check().is_ok())
    }

    /// The unknowns that it brings as candidate number `owner` to `model`, to which it was added last.
    pub fn unknowns(&self, model: &Model, owner: usize) -> impl Iterator<Item = Unknown> {
        let path = self.candidate.path(model);
        self.quantities.iter().zip(&self.coordinates).map(move |(quantity, coordinate)| Unknown {
            path: format!("{path}{}", quantity.name),
            unit: quantity.unit,
            coordinate: coordinate.clone(),
            owner: Some(owner),
        })
    }
}

/// Sizes of the first parameter that are looked at, in prior deviations; and those where little is missing.
pub(super) const SIZES: &[f64] = &[0.3, 1.0];
pub(super) const SMALL: &[f64] = SIZES.split_at(1).0;
/// Rounds in which the size of a prior is sought, and the change that is none.
const ROUNDS: usize = 5;
const NOTHING: f64 = 1e-9;

/// Candidates sorted by what they change.
pub(super) struct Sorted {
    /// What changes the predictions, with its priors.
    pub prepared: Vec<Prepared>,
    /// What does not, whatever its size.
    pub silent: Vec<Candidate>,
    /// What nothing can be predicted with.
    pub unpredictable: Vec<Candidate>,
}

/// The `candidates` by what they change of the predictions about `base`.
pub(super) fn prepare(
    data: &Measured,
    base: &Posterior,
    candidates: &[Candidate],
    scales: &Scales,
    dataset: &Dataset,
) -> Result<Sorted, String> {
    let latent = Latent::default();
    let mut joint = Joint::new(data, &base.model, &base.unknowns, &latent)?;
    let y = white_round(&mut joint, &base.y, HERE)?;
    let brought: Vec<Vec<Brought>> = candidates.iter().map(|c| c.brings(scales, dataset)).collect();
    let mut sizes: Vec<f64> = brought.iter().map(|brought| first_size(&brought[0])).collect();
    let mut found: Vec<Option<f64>> = vec![None; candidates.len()];
    let mut reached = vec![false; candidates.len()];
    let mut open: Vec<usize> = (0..candidates.len()).collect();
    // Sizes and changes of the round before.
    let mut before: Vec<Option<(f64, f64)>> = vec![None; candidates.len()];
    for _ in 0..ROUNDS {
        let at = |&c: &usize| {
            let prepared = of(&candidates[c], &brought[c], sizes[c], data.assumptions());
            prepared.models_at(&base.model)
        };
        let probes: Vec<Vec<Model>> = open.iter().map(at).collect();
        let mut changes = joint.changes(&y, &probes.concat()).into_iter();
        let mut left = Vec::new();
        for (&c, probes) in open.iter().zip(&probes) {
            let changes = changes.by_ref().take(probes.len()).flatten().map(|by| data.size(&by));
            let Some(change) = median(changes.filter(|change| change.is_finite())) else {
                sizes[c] *= 0.3;
                left.push(c);
                continue;
            };
            reached[c] = true;
            if change < NOTHING {
                continue;
            }
            if let Some((size, less)) = before[c].replace((sizes[c], change))
                && change < less * (sizes[c] / size).sqrt()
                && size < sizes[c]
            {
                // It saturates: more of it is no larger an effect.
                found[c] = Some(size);
                continue;
            }
            found[c] = Some(sizes[c]);
            let factor = (data.assumptions().effect_size / change).clamp(0.02, 50.0);
            if (factor - 1.0).abs() > 0.2 {
                let bounded = within(&brought[c][0], sizes[c] * factor.powf(0.8));
                if (bounded / sizes[c] - 1.0).abs() > 1e-3 {
                    sizes[c] = bounded;
                    left.push(c);
                }
            }
        }
        open = left;
        if open.is_empty() {
            break;
        }
    }
    data.bench.count(joint.simulations);
    // What was not looked at is not without effect.
    data.bench.unless_interrupted()?;
    let mut sorted = Sorted { prepared: Vec::new(), silent: Vec::new(), unpredictable: Vec::new() };
    for (c, candidate) in candidates.iter().enumerate() {
        match found[c] {
            Some(size) => sorted.prepared.push(of(candidate, &brought[c], size, data.assumptions())),
            None if reached[c] => sorted.silent.push(candidate.clone()),
            None => sorted.unpredictable.push(candidate.clone()),
        }
    }
    Ok(sorted)
}

fn of(candidate: &Candidate, brought: &[Brought], size: f64, assumed: &Assumptions) -> Prepared {
    let behind = brought.iter().skip(1).map(|one| Coordinate::of_second(one, assumed));
    let coordinates: Vec<Coordinate> =
        std::iter::once(Coordinate::of_first(&brought[0], size)).chain(behind).collect();
    let starts = brought.get(1).map_or(1, |second| second.range.starts.len());
    let behind = || coordinates.iter().zip(brought).skip(1);
    let others =
        (0..starts).map(|start| behind().map(|(c, one)| c.of(one.range.starts[start])).collect()).collect();
    let quantities = brought.iter().map(|one| one.quantity).collect();
    Prepared { candidate: candidate.clone(), quantities, coordinates, others }
}

/// The distance from neutral, or its inverse, of a first number's first start.
fn first_size(brought: &Brought) -> f64 {
    let (start, neutral) = (brought.range.starts[0], brought.neutral.unwrap_or(0.0));
    if neutral.is_infinite() { 1.0 / start } else { (start - neutral).abs() }
}

/// `size`, or the largest that the number's bounds leave.
fn within(brought: &Brought, size: f64) -> f64 {
    let (neutral, quantity) = (brought.neutral.unwrap_or(0.0), brought.quantity);
    let bound = if neutral.is_infinite() {
        quantity.min.filter(|least| *least > 0.0).map(|least| 1.0 / least)
    } else {
        let ends = quantity.max.into_iter().chain(quantity.min.filter(|_| quantity.max == Some(neutral)));
        ends.map(|end| (end - neutral).abs()).find(|room| *room > 0.0)
    };
    bound.map_or(size, |bound| size.min(bound))
}

/// The coordinates of a candidate from its first and the others.
fn at(first: f64, others: &[f64]) -> Vec<f64> {
    [&[first], others].concat()
}

/// The larger of the two in the middle of an even number.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// One amount of a candidate beside a hypothesis.
#[derive(Debug, Clone)]
pub(super) struct Probe {
    /// Index of the candidate.
    pub candidate: usize,
    /// Its coordinates.
    pub y: Vec<f64>,
    /// Gain of log likelihood that a line through it promises, under white noise of the size of the residuals.
    pub gain: f64,
    /// Gain of log evidence on that line.
    pub evidence: f64,
    /// How far the best point on that line moves the predictions beyond what the hypothesis can, as a fraction of the
    /// channels.
    pub distance: f64,
    /// The best multiple of it on that line.
    pub multiple: f64,
}

/// Multiples between which a line is best near its probe, and steps towards that: what saturates looks small from far away,
/// and large from too near.
const NEAR: (f64, f64) = (0.3, 3.0);
const AGAIN: usize = 4;
/// How far a step goes, as a multiple.
const STEP: (f64, f64) = (1e-2, 1e2);

impl Probe {
    /// Of which no line is known.
    fn new(candidate: usize, y: Vec<f64>) -> Self {
        Self { candidate, y, gain: 0.0, evidence: 0.0, distance: 0.0, multiple: 1.0 }
    }

    /// Its coordinates, the `first` where the line is best, as far as lines can be trusted and bounds let it.
    pub fn start(&self, first: &Coordinate) -> Vec<f64> {
        let (low, high) = first.bounds();
        at(first.times(self.y[0], self.multiple.clamp(NEAR.0, NEAR.1)).clamp(low, high), &self.y[1..])
    }
}

/// Where the line of `probe` is best, in the first coordinate.
fn best(probe: &Probe) -> f64 {
    probe.y[0] * probe.multiple.clamp(STEP.0, STEP.1)
}

/// Whether that is a place to look at, and far from where it was looked at.
fn is_far(probe: &Probe) -> bool {
    let away = probe.multiple > 0.0 && !(NEAR.0..=NEAR.1).contains(&probe.multiple);
    away && best(probe).abs() <= SIZES[1]
}

/// Probes about a hypothesis, best first.
#[derive(Debug, Default)]
pub(super) struct Probed {
    pub probes: Vec<Probe>,
    /// The derivatives of the hypothesis, for those that begin at one of them.
    pub tangents: Option<Tangents>,
}

/// Probes of the candidates in `which` about `parent`, of these `sizes` first.
pub(super) fn around(
    data: &Measured,
    parent: &Posterior,
    candidates: &[Prepared],
    which: &[usize],
    sizes: &[f64],
) -> Result<Probed, String> {
    let latent = Latent::default();
    let mut joint = Joint::new(data, &parent.model, &parent.unknowns, &latent)?;
    let y = white_round(&mut joint, &parent.y, HERE)?;
    let of =
        |candidate: usize| places(&candidates[candidate], sizes).into_iter().map(move |y| (candidate, y));
    let first: Vec<(usize, Vec<f64>)> = which.iter().flat_map(|candidate| of(*candidate)).collect();
    let (mut found, mut unreached) = (lines(&mut joint, &y, candidates, first)?, Vec::new());
    for _ in 0..AGAIN {
        let (mut far, near): (Vec<Probe>, Vec<Probe>) = found.into_iter().partition(is_far);
        // Several sizes of one may lead to the same place.
        let behind =
            |a: &Probe, b: &Probe| a.y[1..].partial_cmp(&b.y[1..]).unwrap_or(std::cmp::Ordering::Equal);
        let order = |a: &Probe, b: &Probe| {
            a.candidate.cmp(&b.candidate).then(behind(a, b)).then(best(a).total_cmp(&best(b)))
        };
        far.sort_by(order);
        far.dedup_by(|a, b| {
            a.candidate == b.candidate && a.y[1..] == b.y[1..] && (best(a) / best(b)).ln().abs() < 1.0
        });
        found = near;
        if far.is_empty() {
            break;
        }
        let places: Vec<_> = far.iter().map(|p| (p.candidate, at(best(p), &p.y[1..]))).collect();
        let again = lines(&mut joint, &y, candidates, places)?;
        // Where nothing can be predicted there, what was seen from afar is all there is.
        let reached =
            |p: &Probe| again.iter().any(|a| a.candidate == p.candidate && a.y == at(best(p), &p.y[1..]));
        let (_, lost): (Vec<Probe>, Vec<Probe>) = far.into_iter().partition(reached);
        unreached.extend(lost);
        found.extend(again);
    }
    found.extend(unreached);
    data.bench.count(joint.simulations);
    found.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    Ok(Probed { probes: found, tangents: joint.tangents(&y) })
}

/// What lines through `places`, each of a candidate, promise about `y`, at which `joint` is linearised.
fn lines(
    joint: &mut Joint,
    y: &[f64],
    candidates: &[Prepared],
    places: Vec<(usize, Vec<f64>)>,
) -> Result<Vec<Probe>, String> {
    let line = |change: Change| {
        let Change { mut probe, pull, apart, share, .. } = change;
        let left = apart + probe.y[0].powi(2);
        probe.multiple = -pull / left;
        probe.gain = if probe.multiple > 0.0 { 0.5 * pull * pull / left } else { 0.0 };
        probe.evidence = probe.gain - 0.5 * (left / probe.y[0].powi(2)).ln();
        probe.distance = probe.distance * probe.multiple.max(0.0) * share;
        probe
    };
    changes(joint, y, candidates, places, line)
}

/// What a place changes, to first order, under white noise of the size of the residuals.
struct Change {
    /// Its distance is that of the place itself.
    probe: Probe,
    /// Whitened, record by record.
    whitened: Vec<Vec<f64>>,
    /// Sums over the part of it that the hypothesis cannot make: of products with the residual, and of squares.
    pull: f64,
    apart: f64,
    /// Size of that part over that of all.
    share: f64,
    /// Sums of products with the hypothesis' derivatives, and the amounts of these that come nearest to it.
    cross: DVector<f64>,
    nearest: DVector<f64>,
}

/// What `made` makes of the change of each of `places` about `y`, at which `joint` is linearised.
fn changes<T: Send>(
    joint: &mut Joint,
    y: &[f64],
    candidates: &[Prepared],
    places: Vec<(usize, Vec<f64>)>,
    made: impl Fn(Change) -> T + Sync,
) -> Result<Vec<T>, String> {
    let data = joint.data;
    let sums = joint.sums_here(y);
    let n = y.len();
    let factor = DMatrix::from_row_slice(n, n, &sums.curvature).cholesky().ok_or("no curvature")?;
    let gradient = factor.solve(&DVector::from_column_slice(&sums.gradient));
    let own = joint.whitened();
    let here = joint.model(y)?;
    let beside = |(candidate, y): (usize, Vec<f64>)| {
        let model = candidates[candidate].beside(&here, &y)?;
        Some((Probe::new(candidate, y), model))
    };
    let (probes, models): (Vec<Probe>, Vec<Model>) = places.into_iter().filter_map(beside).unzip();
    let changes = joint.changes(y, &models);
    let noise = &joint.noise;
    let change = |(mut probe, change): (Probe, Option<Vec<Vec<f64>>>)| {
        let change = change?;
        probe.distance = data.largest(&change);
        let whitened: Vec<Vec<f64>> =
            change.iter().enumerate().map(|(k, change)| noise.whiten(data, k, change)).collect();
        let (mut square, mut along) = (0.0, 0.0);
        let mut cross = DVector::zeros(n);
        for (change, own) in whitened.iter().zip(&own) {
            square += dot(change, change);
            along += dot(change, &own.residuals);
            own.columns.iter().for_each(|(i, column)| cross[*i] += dot(column, change));
        }
        let nearest = factor.solve(&cross);
        let apart = (square - cross.dot(&nearest)).max(0.0);
        let (pull, share) = (along - cross.dot(&gradient), (apart / square).sqrt());
        Some(made(Change { probe, whitened, pull, apart, share, cross, nearest }))
    };
    Ok(probes.into_par_iter().zip(changes).filter_map(change).collect())
}

/// The coordinates that a candidate is looked at.
fn places(prepared: &Prepared, sizes: &[f64]) -> Vec<Vec<f64>> {
    let (low, high) = prepared.coordinates[0].bounds();
    let signs = [1.0, -1.0].into_iter().flat_map(|sign| sizes.iter().map(move |size| sign * size));
    let firsts: Vec<f64> = signs.filter(|y| (low..=high).contains(y)).collect();
    firsts.iter().flat_map(|first| prepared.others.iter().map(|others| at(*first, others))).collect()
}

/// Those of `candidates` in `which` at `multiples` of a prior's deviation in both directions, in every place where they are looked
/// at: to start from, whatever lines say.
pub(super) fn amounts(candidates: &[Prepared], which: &[usize], multiples: &[f64]) -> Vec<Probe> {
    let of = |&candidate: &usize| {
        let first = &candidates[candidate].coordinates[0];
        let sizes: Vec<f64> = multiples.iter().map(|multiple| first.times(1.0, *multiple)).collect();
        places(&candidates[candidate], &sizes).into_iter().map(move |y| Probe::new(candidate, y))
    };
    which.iter().flat_map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Record, Regime};
    use crate::diagnose::candidates::tried;
    use crate::diagnose::evidence::posterior::{Start, glance};
    use crate::diagnose::evidence::samples::slider;
    use crate::diagnose::evidence::{again, first};
    use crate::diagnose::measurements::magnitudes;
    use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
    use crate::fit::predict::predict;

    /// A slider with a play of so much of its yield displacement, pulled to and fro within and beyond it, and the model
    /// without.
    fn measured(play: f64) -> (Model, Dataset) {
        let truth = slider(&format!("[[effect]]\nid = \"backlash\"\nhalf_gap = {}\n", 2.5e-5 * play));
        let channel = |name: &str, unit, values| Channel { name: name.into(), unit, values, noise: None };
        let mut noise = fastrand::Rng::with_seed(5);
        let mut record = |level: f64| {
            let place = |i: i32| 2.5e-5 * level * (f64::from(i) * 0.05).sin();
            let channels = vec![
                channel("time", "s", (0..400).map(|i| 1e-3 * f64::from(i)).collect()),
                channel("displacement", "m", (0..400).map(place).collect()),
                channel("force", "N", vec![0.0; 400]),
            ];
            let name = level.to_string();
            let mut record = Record { name, regime: Regime::FromRest, use_for: None, channels };
            let force = &predict(&truth, &record).unwrap()[0].values;
            record.channels[2].values = force.iter().map(|f| f + 0.05 * (noise.f64() - 0.5)).collect();
            record
        };
        let records = [0.8, 2.0, 5.0].map(&mut record).to_vec();
        (slider(""), Dataset { title: None, records })
    }

    /// Has the fit of `model` to `dataset` checked, with `effects` that may stand beside it.
    fn beside_fit(
        model: &Model,
        dataset: &Dataset,
        effects: &[&str],
        check: impl FnOnce(&Measured, &Posterior, &[Prepared]),
    ) {
        let bench = WeightedDataset::new(model, dataset, Assumptions::default(), None).unwrap();
        let data = Measured::new(&bench, &[0, 1, 2], &[], &[]);
        let base = first(&data, None, model).and_then(|(first, _)| again(&data, &first)).unwrap();
        let only: Vec<String> = effects.iter().map(|id| (*id).to_owned()).collect();
        let (tried, _) = tried(model, &bench, Some(&only));
        let scales = magnitudes::of(model, dataset);
        let candidates = prepare(&data, &base, &tried, &scales, dataset).unwrap().prepared;
        check(&data, &base, &candidates);
    }

    #[test]
    fn a_glance_beside_what_was_linearised_ends_where_one_of_its_own_does_in_fewer_simulations() {
        let (model, dataset) = measured(0.1);
        let only = ["backlash", "residual_stiffness", "contact_damping"];
        beside_fit(&model, &dataset, &only, |data, base, candidates| {
            for (owner, candidate) in candidates.iter().enumerate() {
                let probed = around(data, base, candidates, &[owner], SIZES).unwrap();
                let y = probed.probes[0].start(&candidate.coordinates[0]);
                let model = candidate.added_to(&base.model, &y);
                let unknowns: Vec<Unknown> =
                    base.unknowns.iter().cloned().chain(candidate.unknowns(&model, owner)).collect();
                let start = Start { model: &model, unknowns: &unknowns, y: &[&base.y[..], &y].concat() };
                let [beside, own] =
                    [probed.tangents.as_ref(), None].map(|known| glance(data, &start, known).unwrap());
                // Two derivatives of three records the less.
                assert!(
                    beside.simulations + 6 <= own.simulations,
                    "{} {}",
                    beside.simulations,
                    own.simulations
                );
                let gain = own.log_evidence - base.log_evidence;
                let apart = beside.log_evidence - own.log_evidence;
                assert!(apart.abs() < 0.2 * gain.abs(), "{owner}: {apart} of {gain}");
            }
        });
    }

    #[test]
    fn a_little_of_what_saturates_is_looked_at_from_near() {
        for play in [0.01, 0.03, 0.1] {
            let (model, dataset) = measured(play);
            beside_fit(&model, &dataset, &["backlash"], |data, base, candidates| {
                let found = around(data, base, candidates, &[0], SIZES).unwrap().probes;
                let best = &found[0];
                let gap = candidates[0].coordinates[0].value(best.y[0] * best.multiple);
                assert!(best.multiple > 0.3, "{play}: {best:?}");
                assert!((gap / (2.5e-5 * play)).ln().abs() < 1.0, "{play}: {gap} {best:?}");
            });
        }
    }

    #[test]
    fn what_is_looked_at_is_beside_the_numbers_that_are_looked_from() {
        let (mut model, dataset) = measured(0.1);
        model.set_all(&[("contact.friction_coefficient", 0.4)]).unwrap();
        beside_fit(&model, &dataset, &["backlash"], |data, base, candidates| {
            let given = vec![0.0; base.y.len()];
            assert!(base.y.iter().any(|y| y.abs() > 0.3), "{:?}", base.y);
            // As it was given, whatever it was fitted to before.
            let [refitted, untouched] = [&base.model, &model].map(|model| {
                let parent = Posterior { model: model.clone(), y: given.clone(), ..base.clone() };
                let probes = around(data, &parent, candidates, &[0], SIZES).unwrap().probes;
                probes.into_iter().map(|probe| (probe.y, probe.gain)).collect::<Vec<_>>()
            });
            for ((y, gain), (other, as_much)) in refitted.iter().zip(&untouched) {
                assert!(y == other && (gain - as_much).abs() < 1e-6 * as_much, "{y:?} {gain} {as_much}");
            }
        });
    }
}
