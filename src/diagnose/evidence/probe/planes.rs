//! What two candidates promise together about a hypothesis, to first order: where neither explains much alone, lines about what
//! one was fitted to mislead, and what both change tells at once.

use std::collections::HashSet;

use rayon::prelude::*;

use super::{Change, Prepared, Probe, SIZES, changes, dot, places};
use crate::diagnose::evidence::joint::Joint;
use crate::diagnose::evidence::latent::Latent;
use crate::diagnose::evidence::measured::Measured;
use crate::diagnose::evidence::posterior::{HERE, Posterior, white_round};

/// Part of what each of two changes that the other does not, of its square, below which they are one.
const ONE: f64 = 1e-6;

/// Amounts of two candidates beside a hypothesis.
#[derive(Debug, Clone)]
pub(in crate::diagnose::evidence) struct Plane {
    /// Gain of log likelihood that the plane through them promises, under white noise of the size of the residuals.
    pub gain: f64,
    /// Both, with the multiples at which it is best.
    pub probes: [Probe; 2],
}

/// The best plane of each two of the candidates in `which` about `parent`, unless they are forms of one; the most promising first.
pub(in crate::diagnose::evidence) fn planes(
    data: &Measured,
    parent: &Posterior,
    candidates: &[Prepared],
    which: &[usize],
) -> Result<Vec<Plane>, String> {
    let latent = Latent::default();
    let mut joint = Joint::new(data, &parent.model, &parent.unknowns, &latent)?;
    let y = white_round(&mut joint, &parent.y, HERE)?;
    let of =
        |candidate: usize| places(&candidates[candidate], SIZES).into_iter().map(move |y| (candidate, y));
    let first = which.iter().flat_map(|candidate| of(*candidate)).collect();
    let found = changes(&mut joint, &y, candidates, first, |change| change);
    data.bench.count(joint.simulations);
    let found = found?;
    let of = |k: usize| &candidates[found[k].probe.candidate].candidate;
    let pairs = (0..found.len()).flat_map(|j| (0..j).map(move |k| (k, j)));
    let pairs: Vec<(usize, usize)> = pairs.filter(|(k, j)| !of(*k).is_form_of(of(*j))).collect();
    let best = |(k, j): (usize, usize)| {
        let wanted = !data.bench.interrupted();
        wanted.then(|| plane(&found[k], &found[j])).flatten()
    };
    let mut planes: Vec<Plane> = pairs.into_par_iter().filter_map(best).collect();
    planes.sort_by(|a, b| b.gain.total_cmp(&a.gain));
    let mut known = HashSet::new();
    planes.retain(|plane| known.insert(plane.probes.each_ref().map(|probe| probe.candidate)));
    Ok(planes)
}

/// The plane through two places, unless it is best where one of them is none, or on its other side.
fn plane(a: &Change, b: &Change) -> Option<Plane> {
    let products = a.whitened.iter().zip(&b.whitened).map(|(a, b)| dot(a, b));
    let mixed = products.sum::<f64>() - a.cross.dot(&b.nearest);
    let [of_a, of_b] = [a, b].map(|of| of.apart + of.probe.y[0].powi(2));
    let determinant = of_a * of_b - mixed * mixed;
    if determinant < ONE * of_a * of_b {
        return None;
    }
    let multiples =
        [(mixed * b.pull - of_b * a.pull) / determinant, (mixed * a.pull - of_a * b.pull) / determinant];
    multiples.iter().all(|multiple| *multiple > 0.0).then(|| {
        let at = |of: &Change, multiple: f64| Probe { multiple, ..of.probe.clone() };
        Plane {
            gain: -0.5 * (multiples[0] * a.pull + multiples[1] * b.pull),
            probes: [at(a, multiples[0]), at(b, multiples[1])],
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Dataset, Record};
    use crate::diagnose::evidence::Search;
    use crate::diagnose::evidence::samples::{moved, searching, slider};

    /// The planes of `effects` about the slider that was measured with `hidden` ones, and what their candidates are.
    fn beside(hidden: &str, effects: &[&str], check: impl FnOnce(&[Plane], &[Prepared])) {
        let record = |level: f64| {
            let motion = |i: u32| 2.5e-5 * level * (0.05 * f64::from(i)).sin();
            Record { name: level.to_string(), ..moved(&slider(hidden), 400, 1e-3, motion) }
        };
        let dataset = Dataset { title: None, records: [0.8, 2.0, 5.0].map(record).to_vec() };
        let given = slider("");
        searching(&given, &dataset, effects, 1, |Search { data, candidates, .. }, base| {
            let parent = Posterior { y: vec![0.0; base.y.len()], model: given.clone(), ..base };
            let which: Vec<usize> = (0..candidates.len()).collect();
            check(&planes(data, &parent, candidates, &which).unwrap(), candidates);
        });
    }

    /// Where `plane` is best in `id`.
    fn best(plane: &Plane, candidates: &[Prepared], id: &str) -> f64 {
        let is = |probe: &&Probe| candidates[probe.candidate].candidate.effect.id == id;
        let probe = plane.probes.iter().find(is).unwrap();
        let first = &candidates[probe.candidate].coordinates[0];
        first.value(first.times(probe.y[0], probe.multiple))
    }

    /// What adds to the force in proportion is known from one plane, whatever is looked at.
    #[test]
    fn two_that_a_force_is_linear_in_are_told_apart_by_one_plane() {
        for (stiffness, damping) in [(2e5, 3e2), (5e4, 1e3), (1e5, 1e2)] {
            let hidden = format!(
                "[[effect]]\nid = \"residual_stiffness\"\nresidual_stiffness = {stiffness}\n\
                 [[effect]]\nid = \"contact_damping\"\ndamping = {damping}\n"
            );
            let only = ["residual_stiffness", "contact_damping", "asymmetry", "sensor_offset"];
            beside(&hidden, &only, |planes, candidates| {
                let first = &planes[0];
                let found = ["residual_stiffness", "contact_damping"].map(|id| best(first, candidates, id));
                // Priors of numbers draw them a little towards none.
                for (found, truth) in found.into_iter().zip([stiffness, damping]) {
                    assert!((found / truth - 1.0).abs() < 0.05, "{found} for {truth}");
                }
            });
        }
    }

    #[test]
    fn each_two_candidates_have_one_plane_and_those_that_are_missing_the_first() {
        let hidden = "[[effect]]\nid = \"asymmetry\"\nasymmetry = 0.1\n\
                      [[effect]]\nid = \"residual_stiffness\"\nresidual_stiffness = 1e5\n";
        beside(hidden, &["residual_stiffness", "asymmetry", "contact_damping"], |planes, candidates| {
            let pairs: Vec<[usize; 2]> =
                planes.iter().map(|plane| plane.probes.each_ref().map(|probe| probe.candidate)).collect();
            for (k, pair) in pairs.iter().enumerate() {
                assert!(pair[0] != pair[1] && !pairs[..k].contains(pair), "{pairs:?}");
            }
            assert!(planes.is_sorted_by(|a, b| a.gain >= b.gain) && planes.len() > 1);
            let best =
                planes[0].probes.each_ref().map(|probe| candidates[probe.candidate].candidate.effect.id);
            assert!(best.contains(&"asymmetry") && best.contains(&"residual_stiffness"), "{best:?}");
        });
    }

    /// A change of two values that no hypothesis makes, beside a residual.
    fn change(candidate: usize, of: [f64; 2], residual: [f64; 2]) -> Change {
        let nothing = nalgebra::DVector::zeros(0);
        Change {
            probe: Probe::new(candidate, vec![0.3]),
            whitened: vec![of.to_vec()],
            pull: dot(&of, &residual),
            apart: dot(&of, &of),
            share: 1.0,
            cross: nothing.clone(),
            nearest: nothing,
        }
    }

    #[test]
    fn a_plane_is_best_where_no_other_amounts_leave_less() {
        let (a, b, residual) = ([3.0, 1.0], [0.5, 2.0], [-4.0, -3.0]);
        let found = plane(&change(0, a, residual), &change(1, b, residual)).unwrap();
        // Half the sum of squares of the residual, with what the priors of both amounts add.
        let left = |m: f64, n: f64| {
            let squares = (0..2).map(|k| (residual[k] + m * a[k] + n * b[k]).powi(2)).sum::<f64>();
            0.5 * (squares + (0.3 * m).powi(2) + (0.3 * n).powi(2))
        };
        let [m, n] = found.probes.each_ref().map(|probe| probe.multiple);
        assert!((left(0.0, 0.0) - left(m, n) - found.gain).abs() < 1e-12 * found.gain);
        for (by, and) in [(1e-3, 0.0), (-1e-3, 0.0), (0.0, 1e-3), (0.0, -1e-3)] {
            assert!(left(m + by, n + and) > left(m, n));
        }
        // Two that change the same are one, and what pulls the other way is none.
        assert!(plane(&change(0, [3e3, 1e3], residual), &change(1, [6e3, 2e3], residual)).is_none());
        assert!(plane(&change(0, a, residual), &change(1, b.map(|b| -b), residual)).is_none());
    }
}
