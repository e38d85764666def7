//! Response curves as a user asks for them, and what the program says when the input is wrong.

use std::fs;
use std::process::Output;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::{entries, error, read_json, stickslip};

const MODEL: &str = include_str!("../../../../examples/friction-vibration/model.toml");

/// A folder with the two masses as `model.toml` and the beam as `beam.toml`.
fn example() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    let beam = include_str!("../../../../examples/frictional-support/published.toml");
    fs::write(folder.path().join("beam.toml"), beam).unwrap();
    folder
}

/// Runs `frf` on the two masses from 0.2 to 2 rad/s and reads its JSON.
fn response(more: &[&str]) -> (TempDir, Output, Value) {
    let folder = example();
    let mut arguments = vec!["frf", "model.toml", "--from", "0.2", "--to", "2.0", "--unit", "rad/s"];
    arguments.extend(more);
    arguments.extend(["--json", "frf.json"]);
    let output = stickslip(folder.path(), &arguments);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "frf.json");
    (folder, output, json)
}

fn close(found: &Value, expected: f64, tolerance: f64) {
    let found = found.as_f64().unwrap();
    assert!((found / expected - 1.0).abs() < tolerance, "{found} instead of {expected}");
}

#[test]
fn the_peaks_are_those_of_an_exact_time_integration() {
    let (folder, output, json) = response(&["--force", "0.4", "--report", "frf.html"]);
    assert_eq!(json["schema"], "stickslip.frf/1");
    // Event-driven time integration of an independent program.
    let expected = [
        ("m1", 0.527394, 1.008048920),
        ("m1", 1.305808, 2.550916521),
        ("m2", 0.540850, 2.227637379),
        ("m2", 1.300160, 1.065182030),
    ];
    let mut peaks = json["peaks"].as_array().unwrap().clone();
    peaks.sort_by_key(|peak| peak["node"].as_str().unwrap().to_owned());
    // Below 0.3 rad/s the third harmonic meets the first resonance and makes small peaks of its own.
    peaks.retain(|peak| peak["omega"].as_f64().unwrap() > 0.3);
    assert_eq!(peaks.len(), expected.len(), "{peaks:?}");
    for (node, omega, amplitude) in expected {
        let near = |peak: &&Value| {
            peak["node"] == node && (peak["omega"].as_f64().unwrap() / omega - 1.0).abs() < 0.01
        };
        let peak = peaks.iter().find(near).unwrap();
        close(&peak["omega"], omega, 1e-5);
        close(&peak["amplitude"], amplitude, 1e-6);
        close(&peak["frequency_hz"], omega / std::f64::consts::TAU, 1e-5);
        assert_eq!(peak["level"], 0.4);
    }
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(said.contains("0.5408") && said.contains("rad/s") && said.contains("wrote frf.json"), "{said}");
    let page = fs::read_to_string(folder.path().join("frf.html")).unwrap();
    assert_eq!(page.matches("plotly.js v3").count(), 1);
    assert!(page.contains("Loops at the peaks") && page.contains("Truncation error"));
}

#[test]
fn every_point_keeps_the_balance_of_energy() {
    let (_folder, _, json) = response(&["--force", "0.4"]);
    let points = json["points"].as_array().unwrap();
    assert!(points.len() > 100);
    for point in points {
        let number = |key: &str| point[key].as_f64().unwrap();
        let (omega, dissipated) = (number("omega"), number("dissipated"));
        assert!((0.2..=2.0 + 1e-9).contains(&omega));
        assert!(dissipated >= 0.0 && dissipated <= number("work") * (1.0 + 1e-9), "{point}");
        let stiffness = number("equivalent_stiffness");
        assert!(stiffness > 0.0 && stiffness <= 0.2 * (1.0 + 1e-9));
        // The closed form of the loop, with the amplitude found. Stuck throughout above 1.6249 rad/s.
        let slip = point["amplitude"]["m2"].as_f64().unwrap() - 0.02 / 0.2;
        assert!((dissipated - 4.0 * 0.02 * slip.max(0.0)).abs() < 1e-9, "{point}");
        assert_eq!(omega > 1.6249217, dissipated == 0.0, "{omega}");
        assert_eq!(point["level"], 0.4);
        assert_ne!(point["stable"], false);
        assert!((0.0..=1.0).contains(&number("stick_fraction")));
        assert!(number("error_estimate") >= 0.0);
        assert!(point["harmonic1"]["m1"].as_f64().unwrap() > 0.0);
    }
    assert_eq!(json["complete"], true);
}

#[test]
fn several_levels_give_a_curve_each() {
    let (_folder, _, json) = response(&["--levels", "0.002, 0.4", "--no-stability", "--harmonics", "9"]);
    assert_eq!(json["curves"].as_array().unwrap().len(), 2);
    assert_eq!(json["settings"]["levels"], serde_json::json!([0.002, 0.4]));
    let points = json["points"].as_array().unwrap();
    assert!(points.iter().all(|point| point["stable"].is_null()));
    assert!(
        points.iter().any(|point| point["level"] == 0.002)
            && points.iter().any(|point| point["level"] == 0.4)
    );
    // At the small force the contact sticks: a linear resonance, near the natural frequency of the stuck system.
    let stuck =
        json["peaks"].as_array().unwrap().iter().find(|peak| peak["level"] == 0.002 && peak["node"] == "m2");
    let stuck = stuck.unwrap();
    close(&stuck["omega"], 0.6780026, 0.01);
}

#[test]
fn a_held_response_is_held_and_its_force_found() {
    let (_folder, _, json) = response(&["--hold", "displacement:m2=1.0"]);
    assert_eq!(json["settings"]["held"], "displacement:m2");
    for point in json["points"].as_array().unwrap() {
        close(&point["harmonic1"]["m2"], 1.0, 1e-8);
        assert_eq!(point["held"], 1.0);
        assert!(point["level"].as_f64().unwrap() > 0.0);
    }
}

/// Sticking and slipping take energy out: where nothing hardens or softens enough to fold, every response is stable.
#[test]
fn the_stability_of_a_beam_is_reported() {
    let folder = example();
    let arguments =
        ["frf", "beam.toml", "--from", "53.5", "--to", "54.5", "--force", "1", "--harmonics", "3"];
    let output = stickslip(folder.path(), &[&arguments[..], &["--json", "frf.json"]].concat());
    assert!(output.status.success(), "{output:?}");
    let json = read_json(&folder, "frf.json");
    let points = json["points"].as_array().unwrap();
    assert!(points.len() > 20 && points.iter().all(|point| point["stable"] == true), "{}", points.len());
    assert!(String::from_utf8_lossy(&output.stdout).contains("unstable"));
}

#[test]
fn the_phase_is_that_of_the_work() {
    let (_folder, _, json) = response(&["--force", "0.4"]);
    for point in json["points"].as_array().unwrap() {
        let phase = point["phase1"]["m1"].as_f64().unwrap();
        // Only what lags takes work, and that is all the work there is: π F A sin(−φ).
        let amplitude = point["harmonic1"]["m1"].as_f64().unwrap();
        close(&point["work"], -std::f64::consts::PI * 0.4 * amplitude * phase.sin(), 1e-8);
    }
}

#[test]
fn at_a_phase_resonance_the_force_alone_gives_the_held_response_a_quarter_period_behind() {
    let (_folder, output, json) = response(&["--hold", "displacement:m1=1.0", "--report", "frf.html"]);
    assert!(String::from_utf8_lossy(&output.stdout).contains("least force"), "said nothing");
    let all = json["phase_resonances"].as_array().unwrap();
    assert!(!all.is_empty());
    for found in all {
        assert_eq!(found["interpolated"], false);
        let number = |key: &str| found[key].as_f64().unwrap();
        let (from, to) = (number("omega").to_string(), (1.001 * number("omega")).to_string());
        let folder = example();
        let level = number("level").to_string();
        let run = ["frf", "model.toml", "--unit", "rad/s", "--from", &from, "--to", &to, "--force", &level];
        let output = stickslip(folder.path(), &[&run[..], &["--json", "f.json"]].concat());
        assert!(output.status.success());
        let at = &read_json(&folder, "f.json")["points"][0];
        close(&at["harmonic1"]["m1"], 1.0, 1e-7);
        close(&at["phase1"]["m1"], -std::f64::consts::FRAC_PI_2, 1e-7);
    }
}

#[test]
fn without_a_tolerance_errors_above_one_per_cent_are_reported() {
    let (_folder, output, json) = response(&["--force", "0.1", "--harmonics", "1"]);
    let points = json["points"].as_array().unwrap();
    let unresolved = points.iter().filter(|point| point["resolved"] == false).count();
    let above = points.iter().filter(|point| point["error_estimate"].as_f64().is_none_or(|e| e > 0.01));
    assert_eq!(unresolved, above.count());
    assert!(unresolved > 0);
    let said = String::from_utf8_lossy(&output.stdout).replace('\n', " ");
    assert!(said.contains(&format!("of {}: the error estimate is above 0.01", points.len())), "{said}");
}

#[test]
fn hertz_are_the_default_unit() {
    let folder = example();
    let arguments = ["frf", "model.toml", "--from", "0.07", "--to", "0.1", "--force=0.4", "--json", "f.json"];
    assert!(stickslip(folder.path(), &arguments).status.success());
    let json = read_json(&folder, "f.json");
    let first = &json["points"][0];
    close(&first["frequency_hz"], 0.07, 1e-9);
    close(&first["omega"], 0.07 * std::f64::consts::TAU, 1e-9);
}

/// Exit code 2, one message that holds every one of `hints`, no file written.
fn refused(arguments: &[&str], hints: &[&str]) {
    let folder = example();
    let before = entries(folder.path());
    let arguments = [arguments, &["--json", "c.json", "--report", "r.html"]].concat();
    let output = stickslip(folder.path(), &arguments);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {message}");
    assert_eq!(message.matches("error: ").count(), 1, "{message}");
    for hint in hints {
        assert!(message.contains(hint), "no `{hint}` in\n{message}");
    }
    assert_eq!(entries(folder.path()), before, "something was written");
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let two = ["frf", "model.toml", "--unit", "rad/s"];
    let with = |more: &[&'static str], hints: &[&str]| refused(&[&two[..], more].concat(), hints);
    let range = ["--from", "0.2", "--to", "2"];
    let ranged = |more: &[&'static str], hints: &[&str]| with(&[&range[..], more].concat(), hints);
    with(&["--from", "2", "--to", "0.2"], &["--from 2", "below --to 0.2"]);
    with(&["--from", "1", "--to", "1"], &["below"]);
    with(&["--from", "-1", "--to", "1"], &["positive"]);
    with(&["--from", "0.2", "--to", "inf"], &["positive"]);
    with(&["--from", "0.2"], &["--to"]);
    ranged(&["--force", "-0.4"], &["-0.4", "positive"]);
    ranged(&["--force", "0.4", "--hold", "displacement:m1=1"], &["--force", "--hold"]);
    ranged(&["--force", "0.4", "--levels", "1,2"], &["--force", "--levels"]);
    ranged(&["--levels", "0.4,0"], &["level of 0"]);
    ranged(&["--levels", "0.4,nan"], &["NaN"]);
    ranged(&["--levels", "0.4, many"], &["many", "not a number"]);
    ranged(&["--harmonics", "0"], &["--harmonics 0"]);
    ranged(&["--tolerance", "-0.001"], &["--tolerance"]);
    refused(&["frf", "model.toml", "--from", "1", "--to", "2", "--unit", "rpm"], &["rpm", "rad/s"]);
    ranged(&["--excite", "n1"], &["n1", "did you mean `m1`"]);
}

#[test]
fn what_cannot_be_held_is_refused() {
    let held = |hold: &str, more: &[&str], hints: &[&str]| {
        let all = ["frf", "model.toml", "--from", "0.05", "--to", "0.2", "--hold", hold];
        refused(&[&all[..], more].concat(), hints);
    };
    held("displacement:m3=1", &[], &["no node `m3`", "m1", "m2"]);
    held("displacment:m1=1", &[], &["did you mean `displacement`"]);
    held("displacement:m1=-1", &[], &["-1", "positive"]);
    held("displacement:m1=big", &[], &["big"]);
    held("displacement:m1", &[], &["no amplitude"]);
    held("displacement:m1=1", &["--levels", "1,2"], &["give one of them"]);
    held("m1=1", &[], &["write it as"]);
    refused(
        &["frf", "beam.toml", "--from", "45", "--to", "60", "--hold", "acceleration:x=0.54=70"],
        &["did you mean `x=0.55`"],
    );
}

#[test]
fn models_and_destinations_that_cannot_be_used_are_refused() {
    refused(&["frf", "missing.toml", "--from", "1", "--to", "2"], &["missing.toml"]);
    let folder = example();
    let contact = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n[contact]\nlaw = \"jenkins\"\n\
                   tangential_stiffness = 1.0\nfriction_coefficient = 0.5\nnormal_load = 1.0\n";
    fs::write(folder.path().join("contact.toml"), contact).unwrap();
    let output = stickslip(folder.path(), &["frf", "contact.toml", "--from", "1", "--to", "2"]);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("oscillator"));
    let nowhere = ["frf", "model.toml", "--from", "0.1", "--to", "0.2", "--json", "nowhere/f.json"];
    let output = stickslip(folder.path(), &nowhere);
    assert_eq!(output.status.code(), Some(2));
    assert!(error(&output).contains("nowhere"));
}

/// Runs `frf` on a model of its own and reads the JSON.
fn followed(model: &str, more: &[&str]) -> (String, Value) {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("own.toml"), model).unwrap();
    let run = ["frf", "own.toml", "--unit", "rad/s", "--json", "f.json", "--report", "f.html"];
    let output = stickslip(folder.path(), &[&run[..], more].concat());
    assert!(output.status.success(), "{}", error(&output));
    let page = fs::read_to_string(folder.path().join("f.html")).unwrap();
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).replace('\n', " ");
    (format!("{said}{page}"), read_json(&folder, "f.json"))
}

const FREE: &str = "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n\
    mass = [{ name = \"a\", mass = 1.0 }, { name = \"b\", mass = 2.0 }]\n\
    spring = [{ between = [\"a\", \"b\"], stiffness = 3.0, damping = 0.05 }]\n";

/// Linear systems have no steps to count: a period of 73 days is as good as any, and what floats is stable.
#[test]
fn linear_systems_are_stable_at_any_frequency() {
    let started = std::time::Instant::now();
    for more in
        [&["--from", "1e-6", "--to", "3"][..], &["--from", "0.3", "--to", "3", "--hold", "velocity:a=1"]]
    {
        let (_, json) = followed(FREE, more);
        let points = json["points"].as_array().unwrap();
        assert!(points.len() > 10 && points.iter().all(|point| point["stable"] == true));
    }
    assert!(started.elapsed().as_secs() < 60);
}

/// A hardening spring at a very low frequency: not hung, not guessed.
#[test]
fn stability_that_would_take_too_long_is_reported_as_undetermined() {
    let duffing = "schema = \"stickslip.model/1\"\nkind = \"oscillator\"\n\
        mass = [{ name = \"m\", mass = 1.0 }]\n\
        spring = [{ between = [\"ground\", \"m\"], stiffness = 1.0, damping = 0.1 }]\n\
        [[effect]]\nid = \"geometric_stiffening\"\ncubic_stiffness = 0.05\n";
    let (said, json) = followed(duffing, &["--from", "1e-6", "--to", "2e-6", "--harmonics", "5"]);
    for point in json["points"].as_array().unwrap() {
        assert!(point["stable"].is_null() && point["undecided"].as_str().unwrap().contains("too long"));
        // Nothing is called a contact where there is none.
        assert_eq!(point["dissipated"], 0.0);
        assert!(point["equivalent_stiffness"].is_null() && point["stick_fraction"].is_null());
    }
    assert!(said.contains("cannot be determined (it would take too long"), "{said}");
    assert!(!said.contains("that the contact takes") && !said.contains("Loops at the peaks"));
}

/// Work is what the contact takes, what drag takes and what the dampers take.
#[test]
fn drag_is_not_the_contact() {
    let model = format!("{MODEL}\n[[effect]]\nid = \"quadratic_damping\"\nquadratic_damping = 0.05\n");
    let range = ["--from", "0.9", "--to", "1.5", "--force", "0.4", "--no-stability"];
    let (said, json) = followed(&model, &range);
    let points = json["points"].as_array().unwrap();
    assert!(points.len() > 10);
    for point in points {
        let number = |key: &str| point[key].as_f64().unwrap();
        let (contact, drag) = (number("dissipated"), number("dissipated_by_structure"));
        let all = contact + drag + number("dissipated_by_dampers");
        assert!((all / number("work") - 1.0).abs() < 1e-3, "{point}");
        // The closed form of the contact's loop.
        let slip = point["amplitude"]["m2"].as_f64().unwrap() - 0.02 / 0.2;
        assert!((contact - 4.0 * 0.02 * slip.max(0.0)).abs() < 1e-6 && drag > 0.0, "{point}");
        assert!(number("equivalent_stiffness") <= 0.2 * (1.0 + 1e-9) && number("stick_fraction") <= 1.0);
    }
    assert!(said.contains("nonlinearities (drag) take per cycle") && !said.contains("Contact 2"));
}

#[test]
fn effects_without_a_steady_state_are_refused_and_those_of_sensors_reported() {
    let wear = format!("{MODEL}\n[[effect]]\nid = \"wear\"\nrate = 0.1\n");
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("wear.toml"), wear).unwrap();
    let output = stickslip(folder.path(), &["frf", "wear.toml", "--from", "0.1", "--to", "0.2"]);
    let message = error(&output);
    assert_eq!(output.status.code(), Some(2), "{message}");
    assert!(message.contains("\"wear\" has no steady state"), "{message}");
    let gain =
        format!("{MODEL}\n[[effect]]\nid = \"sensor_gain\"\nchannel = \"displacement:m1\"\ngain = 2.0\n");
    let (said, _) = followed(&gain, &["--from", "0.5", "--to", "0.51", "--no-stability"]);
    assert!(said.contains("\"sensor_gain\" is of the measurement of displacement:m1"), "{said}");
}

#[test]
fn the_place_of_excitation_of_a_beam_can_be_held() {
    let folder = example();
    let run = ["frf", "beam.toml", "--from", "53.9", "--to", "54", "--hold", "velocity:excitation=0.1"];
    let more = ["--harmonics", "3", "--no-stability", "--json", "f.json"];
    let output = stickslip(folder.path(), &[&run[..], &more].concat());
    assert!(output.status.success(), "{}", error(&output));
    for point in read_json(&folder, "f.json")["points"].as_array().unwrap() {
        let omega = point["omega"].as_f64().unwrap();
        close(&point["harmonic1"]["excitation"], 0.1 / omega, 1e-8);
    }
}

#[test]
fn long_numbers_are_written_short() {
    let output = stickslip(example().path(), &["frf", "model.toml", "--from", "1e301", "--to", "1e300"]);
    let message = error(&output);
    assert!(message.contains("--from 1e301 must be below --to 1e300"), "{message}");
}
