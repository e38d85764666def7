//! `stickslip import`

use std::fs;

use crate::support::{CONTACT, entries, error, read_json, stdout, stickslip};

/// A loop as a German laboratory program writes it: preamble, decimal commas, mm and kN, another code page.
fn measured() -> Vec<u8> {
    let mut text =
        String::from("Messung 12.03.2026;;\r\nBediener: Müller;;\r\n\r\nZeit;Weg;Kraft\r\n[s];[mm];[kN]\r\n");
    for k in 0..400 {
        let t = f64::from(k) * 0.005;
        let row = format!("{t:.4};{:.5};{:.5}\r\n", 0.02 * (6.0 * t).sin(), 0.05 * (6.0 * t + 0.3).sin());
        text += &row.replace('.', ",");
    }
    text.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect()
}

#[test]
fn a_table_as_it_was_exported_becomes_a_dataset_that_is_compared() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.toml"), CONTACT).unwrap();
    fs::write(folder.path().join("probe 1.csv"), measured()).unwrap();
    let output = stickslip(folder.path(), &["import", "probe 1.csv", "-o", "data"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    // What was guessed is shown, and stays with the data.
    let dataset = fs::read_to_string(folder.path().join("data/dataset.toml")).unwrap();
    for told in ["windows-1252", "decimal comma", "`Kraft` was read as force [kN]", "unknown-initial-state"] {
        assert!(stdout(&output).contains(told) && dataset.contains(told), "{told}: {dataset}");
    }
    let output = stickslip(folder.path(), &["compare", "model.toml", "data", "--no-fit", "--json", "c.json"]);
    assert_eq!(output.status.code(), Some(0), "{}", error(&output));
    // The loop dissipates 50 N · sin 0.3 over 20 µm, whatever the units of the file.
    let force = &read_json(folder.path(), "c.json")["stages"][0]["records"][0]["channels"]["force"];
    assert!(force["rms"].as_f64().is_some_and(|rms| rms < 100.0), "{force}");
}

#[test]
fn what_cannot_be_imported_writes_nothing() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a.csv"), measured()).unwrap();
    fs::write(folder.path().join("c.mat"), format!("MATLAB 5.0 MAT-file{}", " ".repeat(120))).unwrap();
    fs::write(folder.path().join("d.csv"), "time,force\n0,1\n1,2\n").unwrap();
    let before = entries(folder.path());
    for (files, hint) in [
        (vec!["c.mat"], "MAT file"),
        (vec!["a.csv", "d.csv"], "unit"),
        (vec!["none.csv"], "none.csv"),
        (vec!["a.csv", "a.csv"], "rename"),
    ] {
        let output = stickslip(folder.path(), &[&["import", "-o", "data"][..], &files].concat());
        assert!(output.status.code() == Some(2) && error(&output).contains(hint), "{}", error(&output));
        assert_eq!(entries(folder.path()), before);
    }
}
