//! What could not have been seen, and what looks alike: changes by small amounts of effects that the model's own parameters
//! cannot produce.

use nalgebra::{DMatrix, DVector};

use super::joint::{Joint, dot};
use super::latent::Latent;
use super::measured::Measured;
use super::posterior::{HERE, Posterior, white_round};
use super::probe::Prepared;
use crate::diagnose::assumptions::Assumptions;
use crate::diagnose::diagnosis::{Confounding, Detectable};
use crate::model::Model;
use crate::numeric::student::normal_within;

/// Fraction of a change that must be left when the base parameters have taken theirs; below, these data cannot show
/// the effect, whatever its size.
const VISIBLE: f64 = 1e-6;
/// Size of the probes in prior deviations.
const SMALL: f64 = 0.1;

/// What the sensitivities say.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::diagnose) struct Sensitivities {
    /// Correlations of candidates' changes.
    pub confounding: Vec<Confounding>,
    /// The smallest sizes that would have been found.
    pub detectable: Vec<Detectable>,
    /// Ids of effects that the base parameters or the starts can imitate.
    pub invisible: Vec<&'static str>,
}

/// A candidate's change beyond what the hypothesis can make itself.
struct Change<'c> {
    prepared: &'c Prepared,
    /// Whitened, one record after the other, with what the hypothesis can make taken off.
    apart: Vec<f64>,
    /// Squares with and without that, and the distance of the predictions.
    square: f64,
    left: f64,
    distance: f64,
    /// Product with the residual.
    along: f64,
}

/// Around `posterior`, of the `candidates` that are not in it, under the noise that it leaves.
pub(in crate::diagnose) fn around(
    data: &Measured,
    posterior: &Posterior,
    candidates: &[Prepared],
    present: &[usize],
) -> Result<Sensitivities, String> {
    let latent = Latent::default();
    let unknowns = &posterior.unknowns;
    let mut joint = Joint::new(data, &posterior.model, unknowns, &latent)?;
    let y = white_round(&mut joint, &posterior.y[..unknowns.len()], HERE)?;
    joint.noise.renew(data, &joint.priors, &joint.residuals(), true);
    let (mut probes, mut models): (Vec<&Prepared>, Vec<Model>) = (Vec::new(), Vec::new());
    let mut lost = Vec::new();
    for prepared in absent(candidates, present) {
        let mut place = vec![0.0; prepared.coordinates.len()];
        place[0] = SMALL;
        match prepared.beside(&posterior.model, &place) {
            Some(model) => {
                probes.push(prepared);
                models.push(model);
            }
            None => lost.push(prepared),
        }
    }
    let changes = joint.changes(&y, &models);
    data.bench.count(joint.simulations);
    let mut seen = Vec::new();
    for (probe, change) in probes.into_iter().zip(changes) {
        match change {
            Some(change) => seen.push((probe, change)),
            None => lost.push(probe),
        }
    }
    let changes = projected(data, &joint, &y, seen.into_iter())?;
    let mut found = told(&changes, candidates.len(), data.assumptions());
    lost.into_iter().for_each(|prepared| smaller(&mut found.detectable, prepared, None, Some(1.0)));
    Ok(found)
}

/// Candidates by laws of the model that are no form of what is `present`.
fn absent<'c>(candidates: &'c [Prepared], present: &[usize]) -> impl Iterator<Item = &'c Prepared> {
    candidates.iter().filter(|prepared| {
        let own = prepared.candidate.law.is_none();
        own && !present.iter().any(|k| candidates[*k].candidate.is_form_of(&prepared.candidate))
    })
}

impl Sensitivities {
    /// Where nothing could be predicted around a hypothesis: any of the `candidates` beside what is `present` may be there, and
    /// matter.
    pub fn unknown(candidates: &[Prepared], present: &[usize]) -> Self {
        let mut found = Self::default();
        absent(candidates, present).for_each(|one| smaller(&mut found.detectable, one, None, Some(1.0)));
        found
    }
}

fn projected<'c>(
    data: &Measured,
    joint: &Joint,
    y: &[f64],
    seen: impl Iterator<Item = (&'c Prepared, Vec<Vec<f64>>)>,
) -> Result<Vec<Change<'c>>, String> {
    let sums = joint.sums_here(y);
    let n = y.len();
    let factor = DMatrix::from_row_slice(n, n, &sums.curvature).cholesky().ok_or("no curvature")?;
    let whitened = joint.whitened();
    let residuals: Vec<f64> = joint
        .residuals()
        .iter()
        .enumerate()
        .flat_map(|(k, residuals)| joint.noise.whiten(data, k, residuals))
        .collect();
    let project = |(prepared, change): (&'c Prepared, Vec<Vec<f64>>)| {
        // Of what nothing is seen, over all records together: in the quietest of them almost anything could matter.
        let distance = data.size(&change);
        let white: Vec<Vec<f64>> =
            change.iter().enumerate().map(|(k, change)| joint.noise.whiten(data, k, change)).collect();
        let mut cross = DVector::zeros(n);
        for (white, record) in white.iter().zip(&whitened) {
            record.columns.iter().for_each(|(i, column)| cross[*i] += dot(column, white));
        }
        let made = factor.solve(&cross);
        let square = white.iter().map(|white| dot(white, white)).sum();
        let mut apart = Vec::new();
        for (white, record) in white.into_iter().zip(&whitened) {
            let mut rest = white;
            for (i, column) in &record.columns {
                rest.iter_mut().zip(column).for_each(|(r, c)| *r -= made[*i] * c);
            }
            apart.extend(rest);
        }
        let (left, along) = (dot(&apart, &apart), dot(&apart, &residuals));
        Change { prepared, apart, square, left, distance, along }
    };
    Ok(seen.map(project).collect())
}

/// Detection limits and correlations.
fn told(changes: &[Change], candidates: usize, assumed: &Assumptions) -> Sensitivities {
    let mut found = Sensitivities::default();
    let visible = |change: &Change| change.square > 0.0 && change.left > VISIBLE * change.square;
    for change in changes {
        let effect = change.prepared.candidate.effect;
        if !visible(change) && !found.invisible.contains(&effect.id) {
            found.invisible.push(effect.id);
        }
        let size = visible(change).then(|| limit(change, candidates, assumed));
        let relevant = visible(change).then(|| is_relevant(change, assumed));
        smaller(&mut found.detectable, change.prepared, size, relevant);
    }
    for (index, a) in changes.iter().enumerate() {
        for b in changes[..index].iter().filter(|b| visible(a) && visible(b)) {
            let ids = [b.prepared.candidate.effect.id, a.prepared.candidate.effect.id];
            let correlation = dot(&a.apart, &b.apart) / (a.left * b.left).sqrt();
            note(&mut found.confounding, ids, correlation.clamp(-1.0, 1.0));
        }
    }
    found
}

/// The distance from neutral (or the value, where that is infinite) whose evidence would reach certainty against none, and
/// which would be relevant.
fn limit(change: &Change, candidates: usize, assumed: &Assumptions) -> f64 {
    let volume = 0.5 * (1.0 + change.left / (SMALL * SMALL)).ln();
    let prior = (candidates as f64 + 1.0).ln() - assumed.odds.ln();
    let needed = assumed.certainty() + volume + prior;
    let seen = SMALL * (2.0 * needed / change.left).sqrt();
    change.prepared.coordinates[0].distance(coordinate(change, seen).max(relevant(change, assumed)))
}

/// The coordinate from which a change is relevant when all else is refitted.
fn relevant(change: &Change, assumed: &Assumptions) -> f64 {
    let linear = SMALL * assumed.relevant / (change.distance * (change.left / change.square).sqrt());
    coordinate(change, linear)
}

/// The coordinate at which there is as much more of it than at a small one as `linear` says.
fn coordinate(change: &Change, linear: f64) -> f64 {
    change.prepared.coordinates[0].times(SMALL, linear / SMALL)
}

/// Probability that the coordinate is at least that, its prior and the data to first order together.
fn is_relevant(change: &Change, assumed: &Assumptions) -> f64 {
    let precision = 1.0 + change.left / (SMALL * SMALL);
    let (mean, deviation) = (-change.along / SMALL / precision, precision.sqrt().recip());
    let of = |(low, high): (f64, f64)| ((low - mean) / deviation, (high - mean) / deviation);
    let limit = relevant(change, assumed);
    let within = normal_within(of((-limit, limit)), of(change.prepared.coordinates[0].bounds()));
    if within.is_finite() { 1.0 - within.clamp(0.0, 1.0) } else { 1.0 }
}

/// Notes the size for the effect, the smallest where it can be at several places.
fn smaller(found: &mut Vec<Detectable>, prepared: &Prepared, size: Option<f64>, relevant: Option<f64>) {
    let (effect, parameter) = (prepared.candidate.effect, prepared.quantities[0]);
    match found.iter_mut().find(|known| known.effect == effect.id) {
        Some(known) => {
            known.value = match (known.value, size) {
                (Some(a), Some(b)) => Some(a.min(b)),
                (a, b) => a.or(b),
            };
            known.relevant = match (known.relevant, relevant) {
                (Some(a), Some(b)) => Some(a.max(b)),
                (a, b) => a.or(b),
            };
        }
        None => found.push(Detectable {
            effect: effect.id,
            parameter: parameter.name,
            value: size,
            unit: parameter.unit,
            relevant,
        }),
    }
}

/// Notes a correlation; of several places of the same pair the strongest.
fn note(found: &mut Vec<Confounding>, effects: [&'static str; 2], correlation: f64) {
    if effects[0] == effects[1] {
        return;
    }
    match found.iter_mut().find(|known| known.effects == effects) {
        Some(known) if known.correlation.abs() < correlation.abs() => known.correlation = correlation,
        Some(_) => {}
        None => found.push(Confounding { effects, correlation }),
    }
}
