//! Cases as files: the same name, the same bytes.

use std::fs;

use stickslip_hidden_effects::case::{Case, Kind, sealed};
use stickslip_hidden_effects::files;

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
fn the_truth_tells_names_and_parameters() {
    let truth = files::truth(&few()[2]).unwrap();
    assert_eq!(truth["effect"], "backlash");
    assert!(truth["parameters"]["backlash"]["half_gap"].as_f64().unwrap() > 0.0);
}
