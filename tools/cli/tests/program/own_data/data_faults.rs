//! Faults put into simulated measurements are named before anything is fitted, and clean ones have none.

use std::fs;

use stickslip::data::{Channel, Dataset, Record, Regime};
use stickslip::fit::checks::check;
use stickslip::model::Model;
use stickslip_hidden_effects::cases::case::{Case, Kind, Noise, Strength};
use stickslip_hidden_effects::cases::files;
use stickslip_hidden_effects::motion::drive::Drive;
use stickslip_hidden_effects::rigs::setting::Setting;
use tempfile::TempDir;

use crate::support::{error, read_json, stdout, stickslip};

/// Hidden effects and noise of the cases by kind: what is hidden must not look like a fault of the measurement.
fn cases() -> Vec<Case> {
    let contacts: [&[&'static str]; 6] = [
        &[],
        &["backlash"],
        &["micro_slip"],
        &["sensor_delay"],
        &["sensor_offset"],
        &["normal_load_variation"],
    ];
    let oscillators: [&[&'static str]; 3] = [&[], &["sensor_offset"], &["added_mass"]];
    let of = |kind, effects: &[&'static str], share, coloured| Case {
        kind,
        effects: effects.to_vec(),
        strength: Strength::Full,
        noise: Noise { share, coloured },
        drive: Drive::Stationary,
        setting: Setting::Usual,
        replica: 11,
    };
    let mut cases = Vec::new();
    for (share, coloured) in [(0.003, false), (0.01, true), (0.03, false)] {
        cases.extend(contacts.iter().map(|effects| of(Kind::Contact, effects, share, coloured)));
    }
    cases.extend(oscillators.iter().map(|effects| of(Kind::Oscillator, effects, 0.01, false)));
    cases.push(of(Kind::Beam, &[], 0.01, false));
    cases
}

fn folder(case: &Case) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files::texts(&case.draw().unwrap()) {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The channel that a fault is put into: what is measured and compared.
fn measured(record: &mut Record) -> &mut Channel {
    let place = ["force", "acceleration", "displacement"]
        .iter()
        .find_map(|quantity| record.channels.iter().position(|channel| channel.quantity() == *quantity));
    &mut record.channels[place.unwrap()]
}

/// The channel with the sign convention: the contact's force, or the excitation.
fn force(record: &mut Record) -> &mut Channel {
    let place = record.channels.iter().position(|one| ["force", "excitation"].contains(&one.quantity()));
    &mut record.channels[place.unwrap()]
}

type Put = fn(&mut Record);

/// Each fault as it is named, and how it comes about.
const FAULTS: [(&str, Put); 13] = [
    ("reversed-sign", |record| force(record).values.iter_mut().for_each(|value| *value = -*value)),
    ("scale", |record| measured(record).values.iter_mut().for_each(|value| *value *= 1e3)),
    ("scale", |record| measured(record).values.iter_mut().for_each(|value| *value *= 1e-3)),
    ("scale", |record| force(record).values.iter_mut().for_each(|value| *value *= 1e3)),
    ("time-gap", |record| {
        let half = record.len() / 2;
        record.channels.iter_mut().for_each(|channel| drop(channel.values.drain(half..half + 20)));
    }),
    ("outlier", |record| {
        let values = &mut measured(record).values;
        // A lost decimal point shows where there is something to lose.
        let middle = values.len() / 3..values.len() / 2;
        let place = middle.max_by(|a, b| values[*a].abs().total_cmp(&values[*b].abs())).unwrap();
        values[place] *= 10.0;
    }),
    // A single lost sample, and the code of an error.
    ("time-gap", |record| {
        let half = record.len() / 2;
        record.channels.iter_mut().for_each(|channel| {
            _ = channel.values.remove(half);
        });
    }),
    ("outlier", |record| {
        let values = &mut measured(record).values;
        let half = values.len() / 2;
        let code = -999.0 * values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        values[half..half + 5].fill(code);
    }),
    ("clipping", |record| {
        let values = &mut measured(record).values;
        let limit = 0.7 * values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        values.iter_mut().for_each(|value| *value = value.clamp(-limit, limit));
    }),
    ("quantisation", |record| {
        let values = &mut measured(record).values;
        let step = values.iter().fold(0.0_f64, |most, value| most.max(value.abs())) / 16.0;
        values.iter_mut().for_each(|value| *value = (*value / step).round() * step);
    }),
    ("drop-outs", |record| {
        let values = &mut measured(record).values;
        let count = values.len();
        for place in [2, 4, 5, 7, 8] {
            values[place * count / 10..][..7].fill(0.0);
        }
    }),
    ("mains-hum", |record| {
        let time = record.time().unwrap().to_vec();
        let values = &mut measured(record).values;
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let deviation = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / values.len() as f64;
        let hum = |t: f64| 0.1 * deviation.sqrt() * (std::f64::consts::TAU * 50.0 * t).sin();
        values.iter_mut().zip(time).for_each(|(value, t)| *value += hum(t));
    }),
    ("copy-of-channel", |record| {
        let copy = measured(record).clone();
        let name = match copy.name.split_once(':') {
            Some((quantity, _)) => format!("{quantity}:m9"),
            None => "normal_load".to_owned(),
        };
        record.channels.push(Channel { name, ..copy });
    }),
];

#[test]
fn faults_of_measurements_are_named_and_clean_ones_have_none() {
    let (mut tried, mut missed) = (0, Vec::new());
    for case in cases() {
        let folder = folder(&case);
        let model = Model::parse(&fs::read_to_string(folder.path().join("model.toml")).unwrap()).unwrap();
        let clean = stickslip_readers::read_dataset(folder.path()).unwrap();
        assert_eq!(check(&model, &clean), [], "{}", case.name());
        let mut expect = |id: &str, records: Vec<Record>| {
            let found = check(&model, &Dataset { title: None, records });
            tried += 1;
            if !found.iter().any(|one| one.fault.id() == id) {
                missed.push(format!("{id} in {}: {found:?}", case.name()));
            }
        };
        for (id, put) in FAULTS {
            let mut records = clean.records.clone();
            records.iter_mut().for_each(put);
            expect(id, records);
        }
        let mut twice = clean.records.clone();
        twice.push(Record { name: "again.csv".into(), ..twice[0].clone() });
        expect("given-twice", twice);
        let mut moving = clean.records.clone();
        for record in &mut moving {
            record.regime = Regime::FromRest;
            let third = record.len() / 3;
            record.channels.iter_mut().for_each(|one| drop(one.values.drain(..third)));
        }
        expect("moving-at-start", moving);
    }
    println!("{} of {tried} named", tried - missed.len());
    assert!(missed.len() * 20 <= tried, "{} of {tried} missed:\n{}", missed.len(), missed.join("\n"));
}

/// In the headline of the terminal, in the JSON and in the report, and before the fit.
#[test]
fn a_fault_stands_in_the_headline_the_json_and_the_report() {
    let folder = folder(&cases()[0]);
    let dataset = fs::read_to_string(folder.path().join("dataset.toml")).unwrap();
    let file = fs::read_dir(folder.path()).unwrap().filter_map(|entry| {
        let path = entry.unwrap().path();
        (path.extension().is_some_and(|ext| ext == "csv")).then_some(path)
    });
    for path in file {
        let text = fs::read_to_string(&path).unwrap();
        let column =
            text.lines().next().unwrap().split(',').position(|one| one.starts_with("force")).unwrap();
        let reversed = |line: &str| {
            let mut cells: Vec<String> = line.split(',').map(str::to_owned).collect();
            if let Ok(value) = cells[column].parse::<f64>() {
                cells[column] = (-value).to_string();
            }
            cells.join(",")
        };
        fs::write(path, text.lines().map(reversed).collect::<Vec<_>>().join("\n")).unwrap();
    }
    assert!(dataset.contains("[[record]]"));
    let output =
        stickslip(folder.path(), &["compare", "model.toml", ".", "--json", "c.json", "--report", "c.html"]);
    let (said, told) = (stdout(&output), error(&output));
    let head: String = said.lines().take(12).collect::<Vec<_>>().join(" ");
    assert!(
        head.contains("its sign is reversed") && told.contains("warning: r0.csv: `force`"),
        "{told}\n{said}"
    );
    assert_eq!(read_json(folder.path(), "c.json")["checks"][0]["fault"], "reversed-sign");
    let page = fs::read_to_string(folder.path().join("c.html")).unwrap();
    assert!(page[..page.find("<main").unwrap()].contains("its sign is reversed"));
}

/// The key and the likely cause, at once.
#[test]
fn a_beam_in_the_wrong_units_is_told_by_its_key() {
    let folder = tempfile::tempdir().unwrap();
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/frictional-support");
    let text = fs::read_to_string(format!("{example}/valanis.toml")).unwrap();
    for (from, to, key) in
        [("197.1e9", "197.1", "beam.youngs_modulus"), ("length = 0.6 ", "length = 600.0 ", "beam.length")]
    {
        assert!(text.contains(from), "{text}");
        let told = text.replacen(from, to, 1);
        fs::write(folder.path().join("model.toml"), told).unwrap();
        let output = stickslip(folder.path(), &["compare", "model.toml", example, "--no-fit"]);
        let said = error(&output);
        assert!(said.contains(key) && said.contains("expected"), "{said}");
    }
}
