//! Whether residuals repeat: what they are on average at each place of the motion in the records that were fitted
//! is taken off those that were not. Noise, coloured or not, is no smaller for it.

use super::blocks::{self, Gain};
use crate::data::Record;
use crate::diagnose::measurements::noise::driver;
use crate::diagnose::measurements::weighted_dataset::{Scored, WeightedDataset};
use crate::fit::predict::Motion;

/// Cells of a map along the motion, in each direction.
const CELLS: usize = 16;
/// Samples that count for a map to have nothing at a place: sparse cells are drawn towards zero.
const NOTHING: f64 = 20.0;
/// Standard errors above which a residual repeats beyond chance.
const BEYOND: f64 = 4.0;
/// Fraction of the squared residual below which it is not worth telling.
const WORTH: f64 = 0.03;

/// A view in which the residual repeats from record to record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::diagnose) struct Repeated {
    /// What it follows, in words.
    pub view: &'static str,
    /// What the map takes off the records that it was not made from.
    pub gain: Gain,
}

/// Where a map's cells lie.
#[derive(Clone, Copy)]
enum View {
    /// In the range of all records' motion.
    Place,
    /// In each record's own range.
    Cycle,
}

/// The view in which the residuals of the `test` records are most like those of the `seen`, if in any beyond
/// chance. Both are scores of one model.
pub(in crate::diagnose) fn repeated(
    bench: &WeightedDataset,
    seen: &[Scored],
    test: &[Scored],
) -> Option<Repeated> {
    let views = [(View::Place, "the displacement and its direction"), (View::Cycle, "the part of the cycle")];
    let gains = views.into_iter().filter_map(|(view, words)| {
        let range = range(bench, seen.iter().chain(test), view);
        let mut left: Vec<Scored> = test.to_vec();
        for name in names(bench) {
            let map = Map::of(bench, seen, name, range);
            left.iter_mut().for_each(|one| map.take_off(bench, one, name, range));
        }
        let gain = blocks::gain(bench, test, &left);
        (gain.z > BEYOND && gain.fraction > WORTH).then_some(Repeated { view: words, gain })
    });
    gains.max_by(|a, b| a.gain.fraction.total_cmp(&b.gain.fraction))
}

fn names<'b>(bench: &'b WeightedDataset) -> Vec<&'b str> {
    let mut names: Vec<&str> =
        bench.lanes.iter().flat_map(|lane| lane.channels.iter().map(|(name, _)| *name)).collect();
    names.sort_unstable();
    names.dedup();
    names
}

/// The range of all motions; `None` where each record has its own.
fn range<'s>(
    bench: &WeightedDataset,
    scored: impl Iterator<Item = &'s Scored>,
    view: View,
) -> Option<[f64; 2]> {
    match view {
        View::Cycle => None,
        View::Place => {
            let motions = scored.filter_map(|one| driver(bench.lanes[one.record].record));
            motions.map(|motion| ends(&motion.values)).reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])])
        }
    }
}

fn ends(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
}

/// Sum and number of the residuals at each place.
struct Map([(f64, f64); 2 * CELLS]);

impl Map {
    fn of(bench: &WeightedDataset, scored: &[Scored], name: &str, range: Option<[f64; 2]>) -> Self {
        let mut map = Self([(0.0, 0.0); 2 * CELLS]);
        for one in scored {
            each(bench, one, name, range, |index, cell| {
                map.0[cell].0 += one.residuals[index];
                map.0[cell].1 += 1.0;
            });
        }
        map
    }

    fn take_off(&self, bench: &WeightedDataset, one: &mut Scored, name: &str, range: Option<[f64; 2]>) {
        let mut changed = one.residuals.clone();
        each(bench, one, name, range, |index, cell| {
            let (sum, count) = self.0[cell];
            changed[index] -= sum / (count + NOTHING);
        });
        one.residuals = changed;
    }
}

/// Calls `visit` with every sample of the channel and its cell.
fn each(
    bench: &WeightedDataset,
    one: &Scored,
    name: &str,
    range: Option<[f64; 2]>,
    mut visit: impl FnMut(usize, usize),
) {
    let lane = &bench.lanes[one.record];
    let Some(samples) =
        lane.channels.iter().find(|(channel, _)| *channel == name).map(|(_, range)| range.clone())
    else {
        return;
    };
    let Some(cells) = cells(lane.record, range).filter(|cells| cells.len() == samples.len()) else { return };
    samples.zip(cells).for_each(|(index, cell)| visit(index, cell));
}

fn cells(record: &Record, range: Option<[f64; 2]>) -> Option<Vec<usize>> {
    let drive = &driver(record)?.values;
    let motion = Motion::even(drive, 1.0);
    let [low, high] = range.unwrap_or_else(|| ends(&motion.values));
    let width = (high - low).max(f64::MIN_POSITIVE) / CELLS as f64;
    let cell = |(value, rate): (&f64, &f64)| {
        let place = (((value - low) / width) as usize).min(CELLS - 1);
        place + if *rate < 0.0 { CELLS } else { 0 }
    };
    Some(motion.values.iter().zip(&motion.rates).map(cell).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Dataset, Regime};
    use crate::model::Model;
    use std::f64::consts::TAU;

    fn dataset() -> Dataset {
        let channel =
            |name: &str, values: Vec<f64>| Channel { name: name.into(), unit: "m", values, noise: None };
        let record = |level: f64| {
            let wave: Vec<f64> = (0..1200).map(|i| level * (TAU * f64::from(i) / 400.0).sin()).collect();
            let time = (0..1200).map(|i| f64::from(i) * 1e-3).collect();
            let channels =
                vec![channel("time", time), channel("force", wave.clone()), channel("displacement", wave)];
            Record { name: "r".into(), regime: Regime::FromRest, use_for: None, channels }
        };
        Dataset { title: None, records: vec![record(1e-5), record(2e-5), record(1.5e-5)] }
    }

    /// Residuals of deviation one, correlated over about ten samples, and what else is in them.
    fn scored(record: usize, more: impl Fn(usize) -> f64) -> Scored {
        // A fork, since the numbers of neighbouring seeds resemble each other.
        let mut numbers = fastrand::Rng::with_seed(7 + record as u64).fork();
        let mut noise = 0.0;
        let residuals = (0..1200)
            .map(|index| {
                noise = 0.9 * noise + 0.436 * ((0..12).map(|_| numbers.f64()).sum::<f64>() - 6.0);
                noise + more(index)
            })
            .collect();
        Scored { record, predictions: vec![0.0; 1200], residuals }
    }

    #[test]
    fn what_repeats_from_record_to_record_is_seen_and_coloured_noise_is_not() {
        let data = dataset();
        let text = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                    tangential_stiffness = 5e6\nfriction_coefficient = 0.5\nnormal_load = 100.0\n";
        let bench = WeightedDataset::new(&Model::parse(text).unwrap(), &data, None).unwrap();
        let of = |more: &dyn Fn(usize) -> f64| {
            let [a, b, c] = [0, 1, 2].map(|record| scored(record, more));
            repeated(&bench, &[a, b], &[c])
        };
        assert_eq!(of(&|_| 0.0), None);
        // A record of so slow a noise holds about sixty values: what repeats must be larger than it to be beyond chance.
        let found = of(&|i| if i % 400 < 200 { 2.0 } else { -2.0 }).unwrap();
        assert!((0.4..0.8).contains(&found.gain.fraction), "{found:?}");
    }
}
