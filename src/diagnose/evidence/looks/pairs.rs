//! First looks at sets of two members where no single effect explains all: what explains little alone may end anywhere when it is
//! fitted alone, and promises little of the other from there.

use rayon::prelude::*;

use super::{WORTH, moved_all, promising};
use crate::diagnose::evidence::measured::Measured;
use crate::diagnose::evidence::posterior::{Posterior, Start, glance};
use crate::diagnose::evidence::probe::{self, Plane, Probe, SIZES};
use crate::diagnose::evidence::search::{Search, TWICE};
use crate::diagnose::evidence::set::{Set, best_of_each, evidence, of_size};

/// Sets that are glanced at, at most: beside those of one member, and on planes.
const GLANCED: usize = 64;
const PLANES: usize = 32;

impl Search<'_, '_, '_> {
    /// Sets of two members of what planes about none promise, and of what lines do about the `parents` or, where all motions are
    /// solved for, about each of the `sets` of one member as it fits those that were measured.
    pub(in crate::diagnose::evidence) fn paired(&self, sets: &[Set], parents: Vec<Set>) -> Vec<Set> {
        let mut empty = sets[0].clone();
        let solved = |record: &usize| self.data.bench.lanes[*record].seed.is_some();
        let Some(looks) = self.looks.filter(|_| self.data.records.iter().all(solved)) else {
            self.whiten(&mut empty);
            let lines = self.around(parents, false);
            return best_of_each(lines.into_iter().chain(self.on_planes(self.data, &empty)));
        };
        empty.posterior.y.fill(0.0);
        let (mut lines, mut planes) = (self.beside_each(looks, sets), self.on_planes(looks, &empty));
        // From the model as it was given the way is longer.
        lines.truncate(2 * TWICE);
        planes.truncate(TWICE);
        lines.extend(planes);
        lines.par_iter_mut().for_each(|set| Self::screened(looks, set));
        best_of_each(lines.into_iter())
    }

    /// Sets of two members where lines about all `sets` of one promise most of those motions that were measured, glanced at.
    fn beside_each(&self, looks: &Measured, sets: &[Set]) -> Vec<Set> {
        let mut singles = of_size(sets, 1);
        self.different(sets, &mut singles);
        let singles = moved_all(looks, singles.into_iter().map(|k| sets[k].clone()).collect());
        let mut starts: Vec<(f64, usize, Probe)> = Vec::new();
        for (k, single) in singles.iter().enumerate() {
            let mut probes = self.probed(looks, single, &self.beside(single), SIZES).probes;
            probes.retain(|probe| probe.gain > WORTH);
            let promised = |probe: Probe| (evidence(single) + probe.gain, k, probe);
            starts.extend(promising(probes).into_iter().map(promised));
        }
        starts.sort_by(|a, b| b.0.total_cmp(&a.0));
        starts.truncate(GLANCED);
        let glanced = |(_, k, probe): &(f64, usize, Probe)| self.glanced(looks, &singles[*k], None, probe);
        best_of_each(starts.par_iter().filter_map(glanced).collect::<Vec<_>>().into_iter())
    }

    /// Sets of two members where planes about `empty` promise most, glanced at.
    fn on_planes(&self, data: &Measured, empty: &Set) -> Vec<Set> {
        let planes = probe::planes(data, &empty.posterior, self.candidates, &self.beside(empty));
        let mut planes = planes.unwrap_or_default();
        planes.truncate(PLANES);
        let glanced = |Plane { probes, .. }: &Plane| {
            let mut from = empty.posterior.clone();
            for probe in probes {
                let start = probe.start(&self.candidates[probe.candidate].coordinates[0]);
                let (model, unknowns, y) = self.extended(&from, probe.candidate, &start);
                from = Posterior { model, unknowns, y, ..from };
            }
            let Posterior { model, unknowns, y, .. } = &from;
            let posterior = glance(data, &Start { model, unknowns, y }, None).ok()?;
            probes
                .iter()
                .for_each(|probe| (self.report)(self.candidates[probe.candidate].candidate.effect.id));
            let members = probes.iter().map(|probe| probe.candidate).collect();
            Some(Set { members, discrepancy: None, posterior, screened: true })
        };
        best_of_each(planes.par_iter().filter_map(glanced).collect::<Vec<_>>().into_iter())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::Dataset;
    use crate::diagnose::evidence::samples::{beam, moved, searching, slider, steady_at};
    use crate::model::Model;

    /// What is found first beside `given`, of sets of two of these `effects`, where the only one known of one member is the third.
    fn found_together(dataset: &Dataset, given: &Model, effects: [&str; 3]) -> Vec<&'static str> {
        searching(given, dataset, &effects, 2, |search, base| {
            let candidates = search.candidates;
            let id = |member: &usize| candidates[*member].candidate.effect.id;
            let empty = Set { members: Vec::new(), discrepancy: None, posterior: base, screened: false };
            let misled = (0..candidates.len()).find(|member| id(member) == effects[2]).unwrap();
            let mut sets = vec![empty];
            let start = &probe::amounts(candidates, &[misled], &[0.3])[0];
            sets.push(search.glanced(search.data, &sets[0], None, start).unwrap());
            let grown = search.grown(&sets, &[1], false);
            let mut named: Vec<&str> = grown[0].members.iter().map(id).collect();
            named.sort_unstable();
            named
        })
    }

    #[test]
    fn two_effects_are_found_together_where_none_that_is_known_leads_to_them() {
        let write = |effects: &[(&str, &str, f64)]| -> String {
            let one = |(id, number, value): &(&str, &str, f64)| {
                format!("[[effect]]\nid = \"{id}\"\n{number} = {value}\n")
            };
            effects.iter().map(one).collect()
        };
        for (spread, stiffness) in [(0.7, 8e5), (0.9, 5e5)] {
            let hidden = write(&[
                ("micro_slip", "spread", spread),
                ("residual_stiffness", "residual_stiffness", stiffness),
            ]);
            let levels = [(1.0, 47.0), (4.0, 52.0), (9.0, 50.0), (15.0, 55.0), (20.0, 49.0)];
            let dataset = steady_at(&beam(1.94e11, 0.4, &hidden), &levels);
            let effects = ["micro_slip", "residual_stiffness", "added_mass"];
            let named = found_together(&dataset, &beam(1.95e11, 0.36, ""), effects);
            assert_eq!(named, effects[..2], "{spread}");
        }
        for (asymmetry, stiffness) in [(0.1, 2e5), (-0.2, 1e5)] {
            let hidden = write(&[
                ("asymmetry", "asymmetry", asymmetry),
                ("residual_stiffness", "residual_stiffness", stiffness),
            ]);
            let mut random = fastrand::Rng::with_seed(2);
            let record = |level: f64| {
                let motion = |i: u32| 2.5e-5 * level * (0.05 * f64::from(i)).sin();
                let mut record = moved(&slider(&hidden), 400, 1e-3, motion);
                record.channels[2].values.iter_mut().for_each(|force| *force += random.f64() - 0.5);
                record
            };
            let dataset = Dataset { title: None, records: [0.8, 2.0, 5.0].map(record).to_vec() };
            let effects = ["asymmetry", "residual_stiffness", "backlash"];
            assert_eq!(found_together(&dataset, &slider(""), effects), effects[..2], "{asymmetry}");
        }
    }
}
