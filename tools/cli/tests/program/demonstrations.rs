//! The examples that ship with the program.

use std::fs;

use crate::support::{entries, error, read_json, stdout, stickslip};

fn rms_of(stage: &serde_json::Value) -> f64 {
    stage["records"][0]["channels"]["frequency"]["rms"].as_f64().unwrap()
}

#[test]
fn the_demonstration_lets_the_error_fall_and_exports_the_best_model() {
    let folder = tempfile::tempdir().unwrap();
    // Without a command the program runs the demonstration.
    let output = stickslip(folder.path(), &[]);
    assert!(output.status.success(), "{}", error(&output));
    let results = folder.path().join("stickslip-demo");
    let json = read_json(&results, "comparison.json");
    let rms: Vec<f64> = json["stages"].as_array().unwrap().iter().map(rms_of).collect();
    // An independent program: 1.80 Hz (linear), 0.80 Hz (its frequencies with the printed parameters), 0.15
    // and 0.10 Hz refitted. Jenkins has no independent number.
    for (stage, expected) in rms.iter().zip([1.81, 1.07, 0.80, 0.23, 0.15, 0.10]) {
        assert!((stage - expected).abs() < 0.01, "{rms:?}");
    }
    assert!(rms.is_sorted_by(|before, after| before > after));
    // One frequency for all levels is at best their mean.
    assert!(
        (json["stages"][1]["error"].as_f64().unwrap() - 1.0).abs() < 1e-4,
        "{}",
        json["stages"][1]["error"]
    );
    // F of nested fits to eight values, from the errors alone; slip is significant, what follows is not.
    let steps = json["steps"].as_array().unwrap();
    assert_eq!(steps.len(), 3);
    for (step, [before, after, free]) in steps.iter().zip([[1, 3, 2], [3, 4, 3], [4, 5, 4]]) {
        let ratio = (rms[before].powi(2) / rms[after].powi(2) - 1.0) * (8 - free) as f64;
        assert!((step["f"].as_f64().unwrap() / ratio - 1.0).abs() < 1e-6, "{step} {ratio}");
    }
    let chances: Vec<f64> = steps.iter().map(|step| step["chance"].as_f64().unwrap()).collect();
    assert!(chances[0] < 1e-3 && chances[1] > 0.01 && chances[2] > 0.01, "{chances:?}");
    assert!(stdout(&output).contains("FrictionalSupport.fmu"));
    let page = fs::read_to_string(results.join("report.html")).unwrap();
    assert!(page.contains("plotly.js v3") && (500_000..1_600_000).contains(&page.len()));
    // The last picture: a level that an identified contact had not seen.
    let said = stdout(&output);
    let within = said.split("predicts 45 m/s², as an FMU, within ").nth(1).unwrap();
    let within: f64 = within.split_whitespace().next().unwrap().parse().unwrap();
    assert!(within < 2.0, "{within}");
    assert!(page.contains("a level that it has not seen") && page.contains("acceleration:x=0.3, FMU"));
    assert!(results.join("IdentifiedSupport.fmu").is_file());
    // What was exported is what was fitted: read back from the FMU it makes the same error.
    let again = stickslip(
        &results,
        &["compare", "FrictionalSupport.fmu", "frictional-support", "--no-fit", "--json", "again.json"],
    );
    assert!(again.status.success(), "{}", error(&again));
    let again = read_json(&results, "again.json");
    assert_eq!(rms_of(&again["stages"][0]), rms[5]);
}

#[test]
fn the_demonstration_does_not_replace_a_changed_file() {
    let folder = tempfile::tempdir().unwrap();
    let example = folder.path().join("stickslip-demo/frictional-support");
    fs::create_dir_all(&example).unwrap();
    fs::write(example.join("jenkins.toml"), "my own").unwrap();
    let output = stickslip(folder.path(), &["demo"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("jenkins.toml"));
    assert_eq!(fs::read_to_string(example.join("jenkins.toml")).unwrap(), "my own");
    assert_eq!(entries(&example).len(), 1);
}
