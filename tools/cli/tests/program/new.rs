//! Models to begin with, and what is said of a model before anything is fitted.

use std::fs;

use serde_json::Value;
use stickslip::model::reference;

use crate::support::{entries, error, example, stdout, stickslip};

fn checked(folder: &std::path::Path, arguments: &[&str], code: i32) -> Value {
    let output = stickslip(folder, &[&["check"], arguments, &["--json", "-"]].concat());
    assert_eq!(output.status.code(), Some(code), "{}", error(&output));
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn every_kind_has_a_model_to_begin_with_in_which_nothing_is_wrong() {
    let folder = tempfile::tempdir().unwrap();
    for kind in ["contact", "oscillator", "beam", "pin_rig"] {
        let (model, data) = (format!("{kind}.toml"), format!("{kind}-data"));
        let output = stickslip(&folder, &["new", kind, "-o", &model, "--template", &data]);
        assert_eq!(output.status.code(), Some(0), "{}", error(&output));
        let json = checked(folder.path(), &[&model], 0);
        assert_eq!(json["checks"].as_array().unwrap().len(), 0);
        let limit = json["model"]["friction limit"]["values"][0].as_f64().unwrap();
        assert!(limit > 1.0 && json["model"]["slip displacement"]["values"][0].as_f64().unwrap() < 1e-3);
        if kind != "contact" {
            let first = |name: &str| json["model"][name]["values"][0].as_f64().unwrap();
            let [free, stuck] =
                ["free", "stuck"].map(|how| first(&format!("natural frequencies, contact {how}")));
            // The pin rig's lowest mode is that of the mass on its string.
            assert!(
                free < stuck || kind == "pin_rig" && free <= stuck * (1.0 + 1e-9),
                "{kind}: {free} {stuck}"
            );
        }
        // The dataset wants rows, and says so by its line.
        let empty = stickslip(&folder, &["check", &model, &data]);
        assert_eq!(empty.status.code(), Some(2));
        assert!(error(&empty).contains("record-1.csv"), "{}", error(&empty));
        // Nothing is replaced.
        assert_eq!(stickslip(&folder, &["new", kind, "-o", &model]).status.code(), Some(2));
        // Standard output, where no file is named.
        let printed = stickslip(&folder, &["new", kind]);
        assert_eq!(stdout(&printed), fs::read_to_string(folder.path().join(&model)).unwrap());
    }
    assert_eq!(stickslip(&folder, &["new", "rotor", "-o", "x.toml"]).status.code(), Some(2));
    assert_eq!(entries(folder.path()).len(), 8);
}

#[test]
fn a_check_says_what_the_data_can_and_cannot_show() {
    let folder = example();
    let json = checked(folder.path(), &["model.toml", "data"], 0);
    assert_eq!(json["model"]["friction limit"]["values"][0], 50.0);
    assert_eq!(json["model"]["slip displacement"]["values"][0], 25e-6);
    let motion = json["data"]["loop.csv: motion over the slip displacement"]["values"][0].as_f64().unwrap();
    assert!((motion - 2.0).abs() < 1e-3);
    assert!(json["visible"]["contact.friction_coefficient"]["change"].as_f64().unwrap() > 0.05);
    assert!(json["limits"].to_string().contains("one record"), "{}", json["limits"]);
    // A contact that never slips shows nothing of its friction.
    let model = fs::read_to_string(folder.path().join("model.toml")).unwrap();
    fs::write(folder.path().join("model.toml"), model.replace("0.5", "5.0")).unwrap();
    let json = checked(folder.path(), &["model.toml", "data"], 0);
    assert_eq!(json["visible"]["contact.friction_coefficient"]["change"], 0.0);
    assert!(json["limits"].to_string().contains("never slips"), "{}", json["limits"]);
    // What is wrong gives exit code 1.
    fs::write(folder.path().join("model.toml"), model.replace("2.0e6", "2.0e3")).unwrap();
    let json = checked(folder.path(), &["model.toml", "data"], 1);
    assert_eq!(json["checks"][0]["fault"], "scale");
}

#[test]
fn the_reference_in_the_guide_is_that_of_the_parser() {
    let page = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/file-reference.md");
    let wanted = stickslip_report::file_reference(&reference());
    if std::env::var_os("STICKSLIP_BLESS").is_some() {
        fs::write(page, &wanted).unwrap();
    }
    let written = fs::read_to_string(page).unwrap_or_default().replace("\r\n", "\n");
    assert!(
        written == wanted,
        "docs/file-reference.md is not that of the parser: STICKSLIP_BLESS=1 cargo test -p stickslip-cli --test program reference"
    );
}
