//! Training, validation and test records.

use crate::data::{Dataset, Record, Use};

/// Fewest records that can be split by record.
const FEWEST_RECORDS: usize = 3;

/// The records by use.
#[derive(Debug, Clone, PartialEq, Default)]
pub(in crate::diagnose) struct Parts {
    /// Parameters are fitted to these.
    pub fit: Vec<usize>,
    /// Models are chosen by these.
    pub select: Vec<usize>,
    /// Read once.
    pub test: Vec<usize>,
}

impl Parts {
    /// The use of each of `count` records.
    pub fn uses(&self, count: usize) -> Vec<Use> {
        (0..count)
            .map(|index| {
                if self.test.contains(&index) {
                    Use::Confirm
                } else if self.select.contains(&index) {
                    Use::Select
                } else {
                    Use::Fit
                }
            })
            .collect()
    }

    /// The records seen before the end, in order.
    pub fn seen(&self) -> Vec<usize> {
        let mut seen = [self.fit.clone(), self.select.clone()].concat();
        seen.sort_unstable();
        seen
    }

    /// All records, in order.
    pub fn all(&self) -> Vec<usize> {
        let mut all = [self.seen(), self.test.clone()].concat();
        all.sort_unstable();
        all
    }
}

/// Why `dataset` so split cannot carry an answer, if it cannot.
pub(in crate::diagnose) fn too_little(dataset: &Dataset, parts: &Parts) -> Option<String> {
    let count = dataset.records.len();
    if count < FEWEST_RECORDS {
        return Some(format!(
            "{count} record{} cannot be split into records to fit, to choose by and to confirm with; three are \
             needed, and levels that differ",
            if count == 1 { "" } else { "s" }
        ));
    }
    for (part, use_for) in [(&parts.fit, "fit"), (&parts.select, "select"), (&parts.test, "confirm")] {
        if part.is_empty() {
            return Some(format!(
                "no record has `use = \"{use_for}\"`; mark at least one record so, or leave out `use` everywhere"
            ));
        }
    }
    None
}

/// Whether `dataset` is tables of resonances alone, and too few of them to be split by record.
pub(in crate::diagnose) fn is_table(dataset: &Dataset) -> bool {
    let records = &dataset.records;
    (1..FEWEST_RECORDS).contains(&records.len())
        && records.iter().all(|record| record.regime.is_table() && record.use_for.is_none())
}

/// The whole table, of which no point can be spared for a test.
pub(in crate::diagnose) fn whole(dataset: &Dataset) -> Parts {
    Parts { fit: (0..dataset.records.len()).collect(), ..Parts::default() }
}

/// Where a record stands among the others: each coordinate about one across the dataset.
type Place = [f64; 3];

/// By the records' marks where any is marked for choosing or confirming: a record without a mark is then fitted.
/// Otherwise half are fitted, those marked so among them: the largest motion, the smallest, of ten or so records the fastest and the slowest, then always the one farthest from those already taken in level,
/// frequency and regime; the others are dealt out in the order of regime and level.
pub(in crate::diagnose) fn split(dataset: &Dataset, driver: impl Fn(&Record) -> Vec<f64>) -> Parts {
    let records = &dataset.records;
    if records.iter().any(|record| record.use_for.is_some_and(|use_for| use_for != Use::Fit)) {
        let of = |use_for: Use| {
            let marked = |index: &usize| records[*index].use_for.unwrap_or(Use::Fit) == use_for;
            (0..records.len()).filter(marked).collect()
        };
        return Parts { fit: of(Use::Fit), select: of(Use::Select), test: of(Use::Confirm) };
    }
    // Copies of a record stay together: no part may see what another was fitted to.
    let originals = originals(records);
    let distinct: Vec<usize> = (0..records.len()).filter(|index| originals[*index] == *index).collect();
    let marked =
        |index: &usize| (0..records.len()).any(|i| originals[i] == *index && records[i].use_for.is_some());
    let begun: Vec<usize> = distinct.iter().copied().filter(marked).collect();
    let places = places(records, driver);
    let fitted = distinct.len().div_ceil(2).min(distinct.len().saturating_sub(2)).max(1);
    let fit = spread(&places, &distinct, begun, fitted);
    let mut rest: Vec<usize> = distinct.into_iter().filter(|index| !fit.contains(index)).collect();
    rest.sort_by(|a, b| {
        let key = |index: &usize| (places[*index][2], places[*index][0]);
        let (left, right) = (key(a), key(b));
        left.0.total_cmp(&right.0).then(left.1.total_cmp(&right.1)).then(a.cmp(b))
    });
    let mut parts = Parts { fit, ..Parts::default() };
    parts.fit.sort_unstable();
    for (position, index) in rest.into_iter().enumerate() {
        if position % 2 == 0 { parts.select.push(index) } else { parts.test.push(index) }
    }
    for part in [&mut parts.fit, &mut parts.select, &mut parts.test] {
        let copies = (0..records.len()).filter(|index| originals[*index] != *index);
        let more: Vec<usize> = copies.filter(|index| part.contains(&originals[*index])).collect();
        part.extend(more);
        part.sort_unstable();
    }
    parts
}

/// Of every record the first that is the same measurement.
fn originals(records: &[Record]) -> Vec<usize> {
    let same = |a: usize, b: usize| records[a].channels == records[b].channels;
    (0..records.len()).map(|index| (0..index).find(|other| same(*other, index)).unwrap_or(index)).collect()
}

/// Which records are copies of others, in words.
pub(in crate::diagnose) fn copies(dataset: &Dataset) -> Option<String> {
    let names: Vec<String> = originals(&dataset.records)
        .into_iter()
        .enumerate()
        .filter(|(index, original)| index != original)
        .map(|(index, original)| {
            format!("{} of {}", dataset.records[index].name, dataset.records[original].name)
        })
        .collect();
    (!names.is_empty()).then(|| {
        format!("some records are copies, and count as one each with what they copy: {}", names.join(", "))
    })
}

/// Level, frequency and regime of every record.
fn places(records: &[Record], driver: impl Fn(&Record) -> Vec<f64>) -> Vec<Place> {
    let raw: Vec<Place> = records
        .iter()
        .map(|record| {
            let values = driver(record);
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            let level = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64;
            let change = values.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)).sum::<f64>()
                / values.len().max(1) as f64;
            let step = record.sample_step().unwrap_or(1.0);
            let logarithm = |square: f64| if square > 0.0 { 0.5 * square.ln() } else { 0.0 };
            let rate = if level > 0.0 { logarithm(change / level) - step.ln() } else { 0.0 };
            [logarithm(level), rate, f64::from(record.regime as u8)]
        })
        .collect();
    let mut places = raw.clone();
    for k in 0..3 {
        let low = raw.iter().map(|place| place[k]).fold(f64::INFINITY, f64::min);
        let high = raw.iter().map(|place| place[k]).fold(f64::NEG_INFINITY, f64::max);
        let range = if high - low > 1e-9 { high - low } else { 1.0 };
        for place in &mut places {
            place[k] = (place[k] - low) / range;
        }
    }
    places
}

/// `count` of the places `among`, spread out, those `taken` among them.
fn spread(places: &[Place], among: &[usize], mut taken: Vec<usize>, count: usize) -> Vec<usize> {
    let extreme = |coordinate: usize, sign: f64| {
        let size = |index: &usize| sign * places[*index][coordinate];
        among.iter().copied().max_by(|a, b| size(a).total_cmp(&size(b)).then(b.cmp(a)))
    };
    // The largest and the smallest level; where there is room, neither the fastest nor the slowest is left to be
    // extrapolated to.
    for (coordinate, sign, room) in [(0, 1.0, 1), (0, -1.0, 2), (1, 1.0, 5), (1, -1.0, 5)] {
        let next = extreme(coordinate, sign).filter(|next| !taken.contains(next));
        if let Some(next) = next.filter(|_| count >= room && taken.len() < count) {
            taken.push(next);
        }
    }
    let distance = |a: usize, b: usize| -> f64 {
        // A regime is a smaller difference than a level or a speed.
        let weights = [1.0, 1.0, 0.5];
        (0..3).map(|k| (weights[k] * (places[a][k] - places[b][k])).powi(2)).sum()
    };
    while taken.len() < count {
        let nearest = |index: usize| taken.iter().map(|t| distance(index, *t)).fold(f64::INFINITY, f64::min);
        let next = among
            .iter()
            .copied()
            .filter(|index| !taken.contains(index))
            .max_by(|a, b| nearest(*a).total_cmp(&nearest(*b)).then(b.cmp(a)));
        match next {
            Some(next) => taken.push(next),
            None => break,
        }
    }
    taken
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::{Channel, Regime};

    fn record(level: f64, regime: Regime, step: f64) -> Record {
        let channel =
            |name: &str, values: Vec<f64>| Channel { name: name.into(), unit: "m", values, noise: None };
        let wave = (0..100).map(|i| level * (0.2 * f64::from(i)).sin()).collect();
        let time = (0..100).map(|i| step * f64::from(i)).collect();
        Record {
            name: "r".into(),
            regime,
            use_for: None,
            channels: vec![channel("time", time), channel("displacement", wave)],
        }
    }

    fn driver(record: &Record) -> Vec<f64> {
        record.channel("displacement").unwrap().values.clone()
    }

    #[test]
    fn every_record_has_one_use_and_the_extremes_are_fitted() {
        for count in 3..12 {
            let records = (0..count).map(|i| record(1.0 + i as f64, Regime::Steady, 0.1)).collect();
            let dataset = Dataset { title: None, records };
            let parts = split(&dataset, driver);
            assert_eq!(parts.all(), (0..count).collect::<Vec<_>>());
            assert!(parts.fit.contains(&(count - 1)) && !parts.select.is_empty() && !parts.test.is_empty());
            assert!(parts.fit.len() == 1 || parts.fit.contains(&0), "{parts:?}");
        }
    }

    #[test]
    fn every_part_sees_both_regimes_where_there_are_enough() {
        let records = [1.0, 2.0, 4.0, 8.0]
            .iter()
            .flat_map(|level| {
                [record(*level, Regime::FromRest, 0.1), record(1.1 * level, Regime::Steady, 0.1)]
            })
            .collect();
        let dataset = Dataset { title: None, records };
        let parts = split(&dataset, driver);
        for part in [&parts.fit, &parts.select, &parts.test] {
            let steady = part.iter().filter(|i| dataset.records[**i].regime == Regime::Steady).count();
            assert!(steady > 0 && steady < part.len(), "{parts:?}");
        }
    }

    #[test]
    fn of_many_records_the_fastest_and_the_slowest_are_fitted() {
        let records = (0..10)
            .map(|i| {
                record(1.0 + f64::from((i * 3) % 10), Regime::UnknownInitialState, 0.1 * f64::from(1 + i))
            })
            .collect();
        let dataset = Dataset { title: None, records };
        let parts = split(&dataset, driver);
        assert!(parts.fit.contains(&0) && parts.fit.contains(&9) && parts.fit.len() == 5, "{parts:?}");
    }

    #[test]
    fn what_is_marked_to_be_fitted_is_and_the_rest_is_split() {
        let mut records: Vec<Record> =
            (0..8).map(|i| record(1.0 + f64::from(i), Regime::Steady, 0.1)).collect();
        records[3].use_for = Some(Use::Fit);
        records[4].use_for = Some(Use::Fit);
        let parts = split(&Dataset { title: None, records }, driver);
        assert!(
            [0, 3, 4, 7].iter().all(|index| parts.fit.contains(index)) && parts.fit.len() == 4,
            "{parts:?}"
        );
        assert_eq!(parts.all(), (0..8).collect::<Vec<_>>());
    }

    #[test]
    fn copies_of_a_record_stay_in_one_part() {
        let once: Vec<Record> = (0..5).map(|i| record(1.0 + f64::from(i), Regime::Steady, 0.1)).collect();
        let records = [once.clone(), once].concat();
        let parts = split(&Dataset { title: None, records }, driver);
        for part in [&parts.fit, &parts.select, &parts.test] {
            assert!(
                !part.is_empty() && part.iter().all(|index| part.contains(&((index + 5) % 10))),
                "{parts:?}"
            );
        }
        assert_eq!(parts.all(), (0..10).collect::<Vec<_>>());
    }

    #[test]
    fn marks_are_obeyed() {
        let mut records: Vec<Record> =
            (0..4).map(|i| record(1.0 + f64::from(i), Regime::Steady, 0.1)).collect();
        records[3].use_for = Some(Use::Confirm);
        records[1].use_for = Some(Use::Select);
        let parts = split(&Dataset { title: None, records }, driver);
        assert_eq!(parts, Parts { fit: vec![0, 2], select: vec![1], test: vec![3] });
    }
}
