//! No bytes at all make the readers panic, hang, or return half a result.

use std::fs;
use std::path::Path;

use proptest::prelude::*;
use stickslip_readers::{InputError, read_dataset, read_model};
use tempfile::TempDir;

const MODEL: &[u8] = b"schema = \"stickslip.model/1\"\nkind = \"beam\"\n[beam]\nlength = 0.6\nwidth = 0.04\n\
thickness = 0.005\ndensity = 7850\nyoungs_modulus = 2e11\nmodes = 2\ndamping_ratio = [0.003, 0.004]\n\
[[beam.point_mass]]\nposition = 0.3\nmass = 0.005\n[support]\noffset = 0.006\n[excitation]\nposition = 0.5\n\
[contact]\nlaw = \"valanis\"\ntangential_stiffness = 1e6\nfriction_coefficient = 0.5\nnormal_load = 100\n\
smoothness = 0.3\n[fit]\nfree = [\"contact.*\"]\n";
const DATASET: &[u8] = b"schema = \"stickslip.dataset/1\"\ntitle = \"t\"\n[[record]]\nfile = \"r.csv\"\n\
regime = \"steady\"\nuse = \"fit\"\nnoise = { \"acceleration:x=0.55\" = 0.1 }\n";
const TABLE: &[u8] = b"time [s],excitation [N],acceleration:x=0.55 [mm/s^2],displacement [\xc2\xb5m]\n\
0,1,2,3\n0.1,-2e3,3,4\n0.2,3,4,5\n";

/// A change somewhere in the bytes: some are removed, some come in.
fn mutated(bytes: &'static [u8]) -> impl Strategy<Value = Vec<u8>> {
    let change = (0..bytes.len(), 0usize..6, insertion());
    prop::collection::vec(change, 1..4).prop_map(move |changes| {
        let mut result = bytes.to_vec();
        for (place, removed, inserted) in changes {
            let start = place.min(result.len());
            let end = (start + removed).min(result.len());
            result.splice(start..end, inserted);
        }
        result
    })
}

/// Arbitrary bytes, and the ones that mean something to the formats.
fn insertion() -> impl Strategy<Value = Vec<u8>> {
    prop_oneof![
        prop::collection::vec(any::<u8>(), 0..5),
        "[\\[\\]{}=\",.:;#\r\n\t 0-9eE+\\-^/xµ'\u{feff}\u{2028}]{0,6}".prop_map(String::into_bytes),
        prop::sample::select(vec![
            "nan", "inf", "1e999", "-1", "0", "\"\"\"", "[[", "[fit]", "^9", "e-320", "ñ"
        ])
        .prop_map(|text| text.as_bytes().to_vec()),
    ]
}

/// An error must be one complete message, at a line of the file.
fn tellable(error: &InputError) {
    let text = error.render(false);
    assert!(text.starts_with("error: ") && text.contains("--> "), "{text}");
    assert!(!error.render(true).is_empty() && !error.to_string().is_empty());
    if let (Some(line), Ok(bytes)) = (error.line(), fs::read(&error.path)) {
        let ends = bytes.iter().filter(|byte| matches!(byte, b'\n' | b'\r')).count();
        assert!((1..=ends + 1).contains(&line), "{text}");
    }
}

fn read_both(folder: &Path, dataset: &[u8], table: &[u8]) {
    fs::write(folder.join("dataset.toml"), dataset).unwrap();
    fs::write(folder.join("r.csv"), table).unwrap();
    match read_dataset(folder) {
        Err(error) => tellable(&error),
        Ok(dataset) => {
            for record in &dataset.records {
                assert!(!record.is_empty());
                assert!(record.channels.iter().all(|channel| channel.values.len() == record.len()));
                assert!(
                    record.channels.iter().flat_map(|channel| &channel.values).all(|value| value.is_finite())
                );
                assert!(record.time().is_some_and(|time| time.is_sorted_by(|a, b| a < b)));
            }
        }
    }
}

fn read_model_bytes(folder: &Path, bytes: &[u8]) {
    let path = folder.join("model.toml");
    fs::write(&path, bytes).unwrap();
    match read_model(&path) {
        Err(error) => tellable(&error),
        Ok(model) => assert_eq!(model.check(), Ok(())),
    }
}

#[test]
fn the_seeds_of_the_mutations_are_good() {
    let folder = TempDir::new().unwrap();
    fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    read_model(folder.path().join("model.toml")).unwrap_or_else(|error| panic!("{}", error.render(false)));
    fs::write(folder.path().join("dataset.toml"), DATASET).unwrap();
    fs::write(folder.path().join("r.csv"), TABLE).unwrap();
    read_dataset(folder.path()).unwrap_or_else(|error| panic!("{}", error.render(false)));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn mutated_models_are_read_or_refused(bytes in mutated(MODEL)) {
        read_model_bytes(TempDir::new().unwrap().path(), &bytes);
    }

    #[test]
    fn mutated_datasets_are_read_or_refused(bytes in mutated(DATASET)) {
        read_both(TempDir::new().unwrap().path(), &bytes, TABLE);
    }

    #[test]
    fn mutated_tables_are_read_or_refused(bytes in mutated(TABLE)) {
        read_both(TempDir::new().unwrap().path(), DATASET, &bytes);
    }

    #[test]
    fn arbitrary_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let folder = TempDir::new().unwrap();
        read_model_bytes(folder.path(), &bytes);
        read_both(folder.path(), &bytes, &bytes);
        read_both(folder.path(), DATASET, &bytes);
    }
}

#[test]
fn deep_nesting_and_endless_lines_are_refused() {
    let folder = TempDir::new().unwrap();
    let opening = |opening: &str, count: usize| format!("a = {}", opening.repeat(count)).into_bytes();
    for bytes in [
        opening("[", 30_000),
        opening("{b=", 30_000),
        "[".repeat(30_000).into_bytes(),
        "a.".repeat(30_000).into_bytes(),
        vec![b'a'; 100_000],
        vec![b','; 100_000],
        vec![b'"'; 100_000],
        vec![0; 100_000],
        "time [s],".repeat(20_000).into_bytes(),
    ] {
        read_model_bytes(folder.path(), &bytes);
        read_both(folder.path(), DATASET, &bytes);
    }
}
