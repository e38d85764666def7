//! Changes of the data by small amounts of effects that the model's own parameters cannot produce: the part of
//! their sensitivities that is orthogonal to those of the base parameters and of the records' starts.

use nalgebra::DMatrix;

use super::candidates::Candidate;
use super::confound;
use super::detectable;
use super::select::Search;
use crate::diagnose::diagnosis::{Confounding, Detectable};
use crate::diagnose::measurements::weighted_dataset::WeightedDataset;
use crate::diagnose::refit::trial;
use crate::effects::Range;
use crate::model::Model;

/// Fraction of a sensitivity that must be left when the base parameters have taken theirs; below, these data
/// cannot show the effect, whatever its size.
const VISIBLE: f64 = 1e-6;

/// A small amount of an effect.
struct Probe {
    candidate: Candidate,
    /// The first parameter's value that the probe stands for.
    size: f64,
    /// Value of the first parameter at which there is no effect.
    neutral: f64,
}

/// What the sensitivities say.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::diagnose) struct Sensitivities {
    pub confounding: Vec<Confounding>,
    pub detectable: Vec<Detectable>,
    /// Ids of effects that these data cannot show.
    pub invisible: Vec<&'static str>,
}

/// Around `model`, over the fitted records. `chi_square` is the mean square of the weighted residuals there.
pub(in crate::diagnose) fn around(
    search: &Search,
    model: &Model,
    candidates: &[Candidate],
    chi_square: f64,
) -> Result<Sensitivities, String> {
    let bench: &WeightedDataset = search.bench;
    if bench.interrupted() {
        return Err("interrupted".to_owned());
    }
    let mut probes = Vec::new();
    let mut models = Vec::new();
    for candidate in candidates {
        let ranges = candidate.ranges(search.scales, bench.dataset);
        let (values, probe) = probe(candidate, &ranges);
        let mut with = model.clone();
        let mut applied = candidate.applied(&ranges, 0);
        applied.values = values;
        with.effects.push(applied);
        // Effects that a law does not take cannot be probed either.
        if with.check().is_ok() {
            probes.push(probe);
            models.push(with);
        }
    }
    let unknowns = search.unknowns(model);
    let Gram { sizes, projected, variances, samples } =
        gram(bench, model, &unknowns, &search.parts.fit, &models)?;
    let mut found = Sensitivities::default();
    let noise = detectable::Noise { samples, chi_square };
    for (k, probe) in probes.iter().enumerate() {
        let visible = sizes[k] > 0.0 && projected[(k, k)] > VISIBLE * sizes[k];
        let id = probe.candidate.effect.id;
        if !visible && !found.invisible.contains(&id) {
            found.invisible.push(id);
        }
        let multiple = visible.then(|| detectable::multiple(projected[(k, k)], variances[k], &noise));
        let size = multiple.map(|multiple| {
            if probe.neutral.is_infinite() {
                probe.size / multiple
            } else {
                (probe.size - probe.neutral).abs() * multiple
            }
        });
        detectable::smaller(&mut found.detectable, &probe.candidate, size);
    }
    for a in 0..probes.len() {
        for b in 0..a {
            let product = (projected[(a, a)] * projected[(b, b)]).sqrt();
            let seen = |k: usize| projected[(k, k)] > VISIBLE * sizes[k];
            if seen(a) && seen(b) {
                let ids = [probes[b].candidate.effect.id, probes[a].candidate.effect.id];
                confound::note(&mut found.confounding, ids, (projected[(a, b)] / product).clamp(-1.0, 1.0));
            }
        }
    }
    Ok(found)
}

/// A tenth of the first start, where zero means none; the start itself elsewhere.
fn probe(candidate: &Candidate, ranges: &[Range]) -> (Vec<f64>, Probe) {
    let mut values: Vec<f64> = ranges.iter().map(|range| range.starts[0]).collect();
    let neutral = candidate.effect.neutral();
    if neutral.is_finite() {
        values[0] = neutral + 0.1 * (values[0] - neutral);
        values[0] = values[0].clamp(ranges[0].lower, ranges[0].upper);
    }
    let probe = Probe { candidate: candidate.clone(), size: values[0], neutral };
    (values, probe)
}

/// Squares and products of the probes' changes.
struct Gram {
    /// Square of each, as it is.
    sizes: Vec<f64>,
    /// Products with the base projected off.
    projected: DMatrix<f64>,
    /// Variance of the residuals' product with each, their correlation in time taken into account.
    variances: Vec<f64>,
    samples: usize,
}

fn gram(
    bench: &WeightedDataset,
    model: &Model,
    unknowns: &[trial::Unknown],
    records: &[usize],
    probes: &[Model],
) -> Result<Gram, String> {
    let (products, base) = trial::products(bench, model, unknowns, records, probes)?;
    let (all, samples) = (&products.curvature, products.count);
    let total = all.nrows();
    let sizes: Vec<f64> = (base..total).map(|k| all[(k, k)]).collect();
    // Columns of length one; those that change nothing stay out.
    let kept: Vec<usize> = (0..base).filter(|k| all[(*k, *k)] > 0.0).collect();
    let length = |k: usize| all[(k, k)].sqrt();
    let own = DMatrix::from_fn(kept.len(), kept.len(), |a, b| {
        all[(kept[a], kept[b])] / (length(kept[a]) * length(kept[b])) + if a == b { 1e-10 } else { 0.0 }
    });
    let cross = DMatrix::from_fn(kept.len(), total - base, |a, k| all[(kept[a], base + k)] / length(kept[a]));
    // What of each unknown a probe's change can be made of.
    let made =
        own.cholesky().map_or_else(|| DMatrix::zeros(kept.len(), total - base), |own| own.solve(&cross));
    let taken = cross.transpose() * &made;
    let projected =
        DMatrix::from_fn(total - base, total - base, |a, b| all[(base + a, base + b)] - taken[(a, b)]);
    // The gradient along the part that the base cannot produce, and its variance.
    let rest = DMatrix::from_fn(total, total - base, |row, k| match kept.iter().position(|at| *at == row) {
        Some(a) => -made[(a, k)] / length(row),
        None if row == base + k => 1.0,
        None => 0.0,
    });
    let variances = products.variances(&rest);
    Ok(Gram { sizes, projected, variances, samples })
}
