//! Numbers that a user takes away: parameters with intervals, what the noise says, tables of samples, notes.

use std::fs;

use crate::support::{CONTACT, error, example, read_json, stdout, stickslip};

/// A loop of a contact of 3e6 N/m and 60 N with backlash-free motion and noise of 0.3 N that alternates as the rows do.
fn noisy_loop(folder: &std::path::Path, amplitude: f64) {
    let (mut slider, mut text) = (0.0_f64, "time [s],displacement [m],force [N]\n".to_owned());
    for index in 0..800 {
        let time = f64::from(index) * 0.0025;
        let displacement = amplitude * (std::f64::consts::TAU * 2.0 * time).sin();
        let force = (3e6 * (displacement - slider)).clamp(-60.0, 60.0);
        slider = displacement - force / 3e6;
        let noise = 0.3 * (f64::from(index * index % 977) / 488.5 - 1.0) * 3.0_f64.sqrt();
        text += &format!("{time},{displacement},{}\n", force + noise);
    }
    fs::write(folder.join("data/loop.csv"), text).unwrap();
    let dataset = "schema = \"stickslip.dataset/1\"\n[[record]]\nfile = \"loop.csv\"\nregime = \"from-rest\"\n\
                   noise = { force = 0.3 }\n";
    fs::write(folder.join("data/dataset.toml"), dataset).unwrap();
}

#[test]
fn every_fitted_parameter_is_told_with_its_old_value_and_interval_everywhere() {
    let folder = example();
    noisy_loop(folder.path(), 50e-6);
    let output =
        stickslip(&folder, &["compare", "model.toml", "data", "--json", "c.json", "--report", "r.html"]);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "c.json");
    for (path, from, truth) in
        [("contact.tangential_stiffness", 2e6, 3e6), ("contact.friction_coefficient", 0.5, 0.6)]
    {
        let one = &json["stages"][1]["parameters"][path];
        assert_eq!((one["fitted"].as_bool(), one["fitted_from"].as_f64()), (Some(true), Some(from)), "{one}");
        let [low, high] = ["low", "high"].map(|end| one[end].as_f64().unwrap());
        assert!(low < truth && truth < high && high - low < 0.02 * truth, "{one}");
        assert_eq!((one["at_bound"].as_bool(), one["unseen"].as_bool()), (Some(false), Some(false)));
        assert!(stdout(&output).contains(&format!("{path}: ")), "{}", stdout(&output));
    }
    assert!(
        stdout(&output).contains("2\u{a0}MN/m → 3.") || stdout(&output).contains("2\u{a0}MN/m → 2.9"),
        "{}",
        stdout(&output)
    );
    // The head of the page has them before everything else.
    let page = fs::read_to_string(folder.path().join("r.html")).unwrap();
    let at = |text: &str| page.find(text).unwrap_or_else(|| panic!("no {text}"));
    assert!(at("What was fitted") < at("Error of each stage"));
    // The verdict against the noise: the residual is noise, and before the fit it was not.
    assert_eq!(json["against_noise"]["verdict"], "noise", "{}", json["against_noise"]);
    assert!(json["verdict"].as_str().unwrap().contains("no more than noise"));
    let as_it_is = stickslip(&folder, &["compare", "model.toml", "data", "--no-fit", "--json", "-"]);
    let json: serde_json::Value = serde_json::from_slice(&as_it_is.stdout).unwrap();
    assert_eq!(json["against_noise"]["verdict"], "more-than-noise");
}

#[test]
fn samples_are_written_as_measured_predicted_and_residual() {
    let folder = example();
    for arguments in [
        &["compare", "model.toml", "data", "--csv", "out/first"][..],
        &["add", "model.toml", "contact_damping", "--fit", "data", "-o", "new.toml", "--csv", "out/second"],
    ] {
        let output = stickslip(&folder, arguments);
        assert!(output.status.success(), "{}", error(&output));
        let file = folder.path().join(arguments[arguments.len() - 1]).join("loop-compared.csv");
        let text = fs::read_to_string(file).unwrap();
        let mut lines = text.lines();
        let header = "time [s],displacement [m],force measured [N],force predicted [N],force residual [N]";
        assert_eq!(lines.next(), Some(header));
        let rows: Vec<Vec<f64>> =
            lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
        assert_eq!(rows.len(), 400);
        assert!(rows.iter().all(|row| row[4] == row[2] - row[3] && row[4].abs() < 0.1));
        assert!(rows.iter().any(|row| row[2] == 60.0));
    }
    // Named before the fit, not after it.
    let refused = stickslip(&folder, &["compare", "model.toml", "data", "--csv", "model.toml"]);
    assert_eq!(refused.status.code(), Some(2));
    assert!(error(&refused).contains("--csv"), "{}", error(&refused));
}

#[test]
fn add_tells_the_gain_of_the_refit_and_of_the_effect() {
    let folder = example();
    let output = stickslip(
        &folder,
        &[
            "add",
            "model.toml",
            "backlash",
            "--fit",
            "data",
            "-o",
            "new.toml",
            "--json",
            "a.json",
            "--report",
            "a.html",
        ],
    );
    assert!(output.status.success(), "{}", error(&output));
    let json = &read_json(&folder, "a.json")["comparison"];
    let gains = json["gains"].as_array().unwrap();
    assert_eq!(
        gains.iter().map(|gain| gain["stage"].as_str().unwrap()).collect::<Vec<_>>(),
        ["refitted", "backlash"]
    );
    assert!(gains[0]["before"].as_f64() > gains[0]["after"].as_f64());
    let verdict = json["verdict"].as_str().unwrap();
    assert!(verdict.contains("Step by step: refitted ") && verdict.contains("; backlash "), "{verdict}");
    assert!(json["stages"][2]["parameters"]["effect.1.half_gap"]["fitted"].as_bool().unwrap());
    let page = fs::read_to_string(folder.path().join("a.html")).unwrap();
    assert!(page.contains("Step by step: refitted "));
}

#[test]
fn a_parameter_that_the_data_do_not_show_keeps_its_value_and_the_results_say_so() {
    let folder = example();
    // A motion in which the contact never slips: its friction coefficient changes nothing.
    noisy_loop(folder.path(), 8e-6);
    fs::write(folder.path().join("model.toml"), CONTACT.replace("0.5", "0.73")).unwrap();
    let runs: [(&[&str], &str); 2] = [
        (&["compare", "model.toml", "data", "-o", "new.toml", "--json", "c.json", "--report", "r.html"], ""),
        (
            &[
                "add",
                "model.toml",
                "contact_damping",
                "--fit",
                "data",
                "-o",
                "new.toml",
                "--json",
                "c.json",
                "--report",
                "r.html",
            ],
            "comparison",
        ),
    ];
    for (arguments, inside) in runs {
        let output = stickslip(&folder, arguments);
        assert!(output.status.success(), "{}", error(&output));
        let written = fs::read_to_string(folder.path().join("new.toml")).unwrap();
        assert!(written.contains("friction_coefficient = 0.73"), "{written}");
        let json = read_json(&folder, "c.json");
        let json = if inside.is_empty() { &json } else { &json[inside] };
        let note = "no fitted record depends on `contact.friction_coefficient`, which keeps its value 0.73";
        assert!(json["notes"].to_string().contains(note), "{}", json["notes"]);
        assert!(
            fs::read_to_string(folder.path().join("r.html")).unwrap().contains("which keeps its value 0.73")
        );
        let one =
            &json["stages"].as_array().unwrap().last().unwrap()["parameters"]["contact.friction_coefficient"];
        assert!(one["unseen"].as_bool().unwrap() && one["low"].is_null(), "{one}");
    }
}

#[test]
fn what_ends_at_its_bound_is_told_and_not_taken_for_what_changes_nothing() {
    let folder = example();
    noisy_loop(folder.path(), 50e-6);
    let model = CONTACT.replace("jenkins\"", "valanis\"\nsmoothness = 0.5\nresidual_stiffness = 1e4");
    fs::write(folder.path().join("model.toml"), model).unwrap();
    let output = stickslip(&folder, &["compare", "model.toml", "data", "--json", "c.json"]);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "c.json");
    let one = &json["stages"][1]["parameters"]["contact.smoothness"];
    // A slider alone is Valanis' law at a smoothness of one, which no fit goes to.
    assert_eq!((one["at_bound"].as_bool(), one["unseen"].as_bool()), (Some(true), Some(false)), "{one}");
    assert!(stdout(&output).contains("ended at its"), "{}", stdout(&output));
}

#[test]
fn measurements_without_a_title_are_called_as_their_folder() {
    let folder = example();
    for (place, path) in [("data", "."), ("data", "dataset.toml"), ("", "data"), ("", "data/dataset.toml")] {
        let model = folder.path().join("model.toml");
        let results = folder.path().join("c.json");
        let arguments =
            ["compare", model.to_str().unwrap(), path, "--no-fit", "--json", results.to_str().unwrap()];
        let output = stickslip(folder.path().join(place), &arguments);
        assert!(output.status.success(), "{}", error(&output));
        assert_eq!(read_json(&folder, "c.json")["title"], "data", "{path}");
        fs::remove_file(results).unwrap();
    }
}
