//! The beginnings of records of a structure at rest, for fits that start far from the data: the longer a record is, the
//! more a wrong frequency falls out of step, and the more false minima there are. What fits the beginning is near enough
//! for the whole.

use crate::data::{Channel, Dataset, Record, Regime};
use crate::model::{Model, Structure};

/// Fractions of a record that are beginnings: what fits one is near enough for the next.
const FRACTIONS: [f64; 2] = [0.2, 0.45];
/// Fewest samples of one.
const LEAST: usize = 200;

/// `dataset` with its records from rest cut to beginnings, the shortest first; none where none can be cut.
pub(in crate::diagnose) fn of(model: &Model, dataset: &Dataset) -> Vec<Dataset> {
    if model.structure == Structure::Prescribed {
        return Vec::new();
    }
    let cut = FRACTIONS.map(|fraction| Dataset {
        title: dataset.title.clone(),
        records: dataset.records.iter().map(|record| beginning(record, fraction)).collect(),
    });
    cut.into_iter().filter(|cut| cut != dataset).collect()
}

fn beginning(record: &Record, fraction: f64) -> Record {
    if record.regime != Regime::FromRest {
        return record.clone();
    }
    let count = LEAST.max((fraction * record.len() as f64) as usize);
    let channel = |channel: &Channel| Channel {
        values: channel.values.iter().copied().take(count).collect(),
        ..channel.clone()
    };
    Record { channels: record.channels.iter().map(channel).collect(), ..record.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OSCILLATOR: &str = include_str!("../../../examples/friction-vibration/model.toml");

    fn record(count: usize, regime: Regime) -> Record {
        let time = (0..count).map(|i| i as f64 * 1e-3).collect();
        let channels = vec![Channel { name: "time".into(), unit: "s", values: time, noise: None }];
        Record { name: "r".into(), regime, use_for: None, channels }
    }

    #[test]
    fn only_long_records_from_rest_of_a_structure_are_cut_and_begin_as_they_did() {
        let model = Model::parse(OSCILLATOR).unwrap();
        let long = record(2400, Regime::FromRest);
        let records =
            vec![long.clone(), record(150, Regime::FromRest), record(2400, Regime::UnknownInitialState)];
        let dataset = Dataset { title: None, records };
        let cut = of(&model, &dataset);
        for (cut, count) in cut.iter().zip([480, 1080]) {
            let lengths: Vec<usize> = cut.records.iter().map(Record::len).collect();
            assert_eq!(lengths, [count, 150, 2400]);
            assert_eq!(cut.records[0].time().unwrap(), &long.time().unwrap()[..count]);
        }
        assert_eq!(cut.len(), 2);
        let short = Dataset { title: None, records: dataset.records[1..].to_vec() };
        assert_eq!(of(&model, &short), []);
        let bare = Model { structure: Structure::Prescribed, ..model };
        assert_eq!(of(&bare, &dataset), []);
    }
}
