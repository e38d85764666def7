//! Cases as files: the same name, the same bytes.

use std::fs;

use stickslip_hidden_effects::cases::case::{Case, Kind};
use stickslip_hidden_effects::cases::files;
use stickslip_hidden_effects::cases::sealed::sealed;
use stickslip_hidden_effects::motion::drive::Drive;

/// Six quick cases.
fn few() -> Vec<Case> {
    let wanted =
        ["none", "micro_slip", "backlash", "velocity_weakening", "sensor_delay", "normal_load_variation"];
    let pick = |id: &&str| {
        let named = |case: &Case| if *id == "none" { case.effects.is_empty() } else { case.effects == [*id] };
        sealed().into_iter().find(|case| case.kind == Kind::Contact && named(case)).unwrap()
    };
    wanted.iter().map(pick).collect()
}

#[test]
fn the_same_name_gives_the_same_bytes() {
    let mut all = Vec::new();
    for case in few() {
        let once = files::texts(&case.draw().unwrap());
        assert!(once == files::texts(&case.draw().unwrap()), "{}", case.name());
        all.push(once);
    }
    // And another name others.
    assert!((1..all.len()).all(|index| all[index] != all[index - 1]));
}

/// FNV-1a of a text.
fn fingerprint(text: &str) -> String {
    let hash = text
        .bytes()
        .fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3));
    format!("{hash:016x}")
}

fn named(name: &str) -> Case {
    sealed().into_iter().find(|case| case.name() == name).unwrap()
}

#[test]
fn a_name_gives_the_bytes_that_it_has_always_given() {
    for (name, files) in [
        ("contact-backlash-full-1%-white-1", ["371c24a34624e9c3", "5739d6e143aef3c2"]),
        ("contact-sensor_delay-full-0.3%-coloured-1", ["c2f0658de876a93e", "1e55f197aba28656"]),
        ("contact-wear-full-1%-white-1-moving", ["5bb2a23c54d65ec3", "7d28453328835d25"]),
    ] {
        let texts = files::texts(&named(name).draw().unwrap());
        let found = |wanted: &str| {
            let (_, text) = texts.iter().find(|(name, _)| name == wanted).unwrap();
            fingerprint(text)
        };
        assert_eq!([found("r2.csv"), found("r5.csv")], files, "{name}");
    }
}

#[test]
fn moving_records_are_sampled_evenly_and_begin_at_rest_where_they_say_so() {
    let drawn = named("contact-backlash-full-1%-white-1-moving").draw().unwrap();
    let records = drawn.rig.respond();
    let regimes: Vec<&str> = records.iter().map(|record| record.regime.word()).collect();
    let stationary = few()[0].draw().unwrap().rig.respond();
    assert_eq!(regimes, stationary.iter().map(|record| record.regime.word()).collect::<Vec<_>>());
    for record in records {
        let [times, displacement, force] = [0, 1, 2].map(|index| &record.columns[index].values);
        let period = times[times.len() - 1] / (times.len() - 1) as f64;
        assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - period).abs() < 1e-9 * period));
        if record.regime.word() == "from-rest" {
            let largest = displacement.iter().fold(0.0_f64, |largest, place| largest.max(place.abs()));
            assert!(displacement[0] == 0.0 && force[0].abs() < 1e-15);
            assert!((displacement[1] - displacement[0]).abs() < 2e-4 * largest);
        }
    }
}

#[test]
fn where_no_motion_repeats_the_noise_of_standstill_is_stated() {
    let drawn = named("contact-backlash-full-1%-white-1-moving").draw().unwrap();
    for record in drawn.measure() {
        assert_eq!(record.told.len(), usize::from(record.regime.word() == "from-rest"));
    }
    let untold = named("contact-backlash-full-1%-white-1-moving-untold");
    for case in [&few()[2], &untold] {
        assert!(case.draw().unwrap().measure().iter().all(|record| record.told.is_empty()));
    }
}

#[test]
fn moving_records_stick_and_slip() {
    let case = sealed()
        .into_iter()
        .find(|case| case.drive == Drive::Moving && case.effects.is_empty() && case.noise.share == 0.01)
        .unwrap();
    let drawn = case.draw().unwrap();
    let (base, records) = (drawn.rig.base(), drawn.rig.respond());
    let share_at_the_limit: Vec<f64> = records
        .iter()
        .map(|record| {
            let [forces, loads] = [2, 3].map(|index| &record.columns[index].values);
            let at = forces.iter().zip(loads).filter(|(force, load)| force.abs() > 0.999 * base[1] * *load);
            at.count() as f64 / forces.len() as f64
        })
        .collect();
    assert_eq!(share_at_the_limit[0], 0.0);
    assert!(share_at_the_limit[1] < 0.4 && share_at_the_limit.iter().all(|share| *share < 0.95));
    assert!(share_at_the_limit[2..].iter().all(|share| *share > 0.25), "{share_at_the_limit:?}");
}

#[test]
fn only_bare_contacts_have_moving_records() {
    let beam = Case { kind: Kind::Beam, drive: Drive::Moving, ..few()[0].clone() };
    assert!(beam.draw().is_err());
}

#[test]
fn a_case_is_written_once_with_model_dataset_and_eight_records() {
    let root = tempfile::tempdir().unwrap();
    let case = &few()[0];
    let folder = files::write(root.path(), case).unwrap();
    let mut names: Vec<String> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    let expected = "dataset.toml model.toml r0.csv r1.csv r2.csv r3.csv r4.csv r5.csv r6.csv r7.csv";
    assert_eq!(names.join(" "), expected);
    let record = fs::read_to_string(folder.join("r0.csv")).unwrap();
    assert!(record.starts_with("time [s],displacement [m],force [N],normal_load [N]\n0,"));
    assert_eq!(record.lines().count(), 1202);
    // One that is there is not touched.
    fs::write(folder.join("r0.csv"), "mine").unwrap();
    files::write(root.path(), case).unwrap();
    assert_eq!(fs::read_to_string(folder.join("r0.csv")).unwrap(), "mine");
    assert_eq!(fs::read_dir(root.path()).unwrap().count(), 1);
}

#[test]
fn records_from_rest_begin_at_rest_and_noise_has_its_size() {
    let case = &few()[2];
    let drawn = case.draw().unwrap();
    let (clean, measured) = (drawn.rig.respond(), drawn.measure());
    for (clean, measured) in clean.iter().zip(&measured) {
        let [clean_force, force] = [clean, measured].map(|record| &record.columns[2].values);
        if clean.regime.word() == "from-rest" {
            assert!(clean_force[0].abs() < 1e-15 && clean.columns[1].values[0].abs() < 1e-15);
        }
        let count = force.len() as f64;
        let noise = force.iter().zip(clean_force).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / count;
        let size = clean_force.iter().map(|a| a * a).sum::<f64>() / count;
        assert!(((noise / size).sqrt() / case.noise.share - 1.0).abs() < 0.1);
    }
}

#[test]
fn the_truth_holds_names_and_parameters() {
    let truth = files::truth(&few()[2]).unwrap();
    assert_eq!(truth["effect"], "backlash");
    assert!(truth.get("moving").is_none());
    assert_eq!(files::truth(&named("contact-wear-full-1%-white-1-moving")).unwrap()["moving"], true);
    assert!(truth["parameters"]["backlash"]["half_gap"].as_f64().unwrap() > 0.0);
}
