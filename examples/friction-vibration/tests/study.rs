//! The study's data, against time integration and reference values of an independent program.

use std::fs;
use std::process::Command;

use serde_json::Value;

fn close(found: &Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().unwrap();
    assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
}

#[test]
fn the_study_agrees_with_time_integration_and_names_the_statements_that_fail() {
    let folder = tempfile::tempdir().unwrap();
    let results = folder.path().join("results");
    let program = env!("CARGO_BIN_EXE_friction-vibration");
    let output = Command::new(program).arg(&results).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let json: Value =
        serde_json::from_slice(&fs::read(results.join("friction-vibration.json")).unwrap()).unwrap();
    assert_eq!(json["schema"], "stickslip.study/1");
    let sections = json["sections"].as_array().unwrap();
    let section = |id: &str| sections.iter().find(|section| section["id"] == id).unwrap();
    // Harmonic balance against time integration, at every row.
    for row in section("response")["tables"][0]["rows"].as_array().unwrap() {
        assert!(row[6].as_f64().unwrap() < 2e-6, "{row}");
    }
    // Reference values of an independent program: minima and maximum of the equivalent stiffness, end of slip.
    let extremes = &section("stiffness")["tables"][0]["rows"];
    for (row, (omega, value)) in
        [(0.54085, 0.008978), (1.010, 0.04958), (1.3002, 0.018776), (1.62492169, 0.2)].iter().enumerate()
    {
        close(&extremes[row][1], *omega, 1e-4);
        close(&extremes[row][2], *value, 1e-4);
    }
    let failing = section("statements")["tables"][0].to_string();
    for number in ["0.01739 N", "0.062 N for y", "0.2994", "0.460"] {
        assert!(failing.contains(number), "no {number} in {failing}");
    }
    for number in ["4", "5", "6", "7", "8", "9", "10", "12", "13", "14"] {
        let figures = sections.iter().flat_map(|section| section["figures"].as_array().unwrap());
        let mut captions = figures.map(|figure| figure["caption"].as_str().unwrap().to_owned());
        let found = captions.any(|caption| {
            caption.starts_with(&format!("Figure {number}.")) || caption.starts_with("Figures 4 and 5.")
        });
        assert!(found, "no figure {number}");
    }
    let page = fs::read_to_string(results.join("friction-vibration.html")).unwrap();
    assert!(page.contains("not supported") && page.matches("plotly.js v3").count() == 1);
}
