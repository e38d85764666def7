//! Data of an independent simulator with something hidden in them: the program finds it, names nothing where
//! nothing is hidden, and the model with the effect added works everywhere the old one did.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Cursor, Read as _};
use std::path::Path;

use serde_json::Value;
use stickslip::contact::Inputs;
use stickslip::model::Model;
use stickslip_fmi_host::{Library, Slave};
use stickslip_fmu_package::library;
use stickslip_hidden_effects::cases::case::{Case, Kind, Noise, Strength};
use stickslip_hidden_effects::cases::files;
use stickslip_hidden_effects::motion::drive::Drive;
use stickslip_hidden_effects::rigs::setting::Setting;
use tempfile::TempDir;

use crate::support::{error, read_json, stickslip};

/// Runs the program, which has to end with `code`.
fn run(folder: &Path, arguments: &[&str], code: i32) {
    let output = stickslip(folder, arguments);
    let said = error(&output);
    assert_eq!(output.status.code(), Some(code), "{arguments:?}: {said}");
}

/// A case at full strength with white noise of `fraction`: `model.toml`, `dataset.toml` and eight records.
fn hidden(effects: &[&'static str], fraction: f64) -> TempDir {
    hidden_in(Kind::Contact, effects, fraction)
}

fn hidden_in(kind: Kind, effects: &[&'static str], fraction: f64) -> TempDir {
    let case = Case {
        kind,
        effects: effects.to_vec(),
        strength: Strength::Full,
        noise: Noise { share: fraction, coloured: false },
        drive: Drive::Stationary,
        setting: Setting::Usual,
        replica: 1,
    };
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files::texts(&case.draw().unwrap()) {
        fs::write(folder.path().join(name), text).unwrap();
    }
    folder
}

/// The diagnosis of `folder`, whose exit code belongs to its verdict.
fn diagnose(folder: &Path) -> Value {
    let output = stickslip(folder, &["diagnose", "model.toml", ".", "--json", "d.json", "-o", "found.toml"]);
    let diagnosis = read_json(folder, "d.json");
    let code = match diagnosis["verdict"].as_str().unwrap() {
        "nothing-missing" => 0,
        "effect-found" if diagnosis["noise_known"] == true => 10,
        "effect-found" => 14,
        "not-distinguishable" => 11,
        "unexplained" => 12,
        "insufficient-data" => 13,
        other => panic!("{other}"),
    };
    assert_eq!(output.status.code(), Some(code), "{diagnosis:#}");
    diagnosis
}

/// Verdict, effects and what was seen of them, for messages.
fn found(effects: &[&'static str], fraction: f64) -> Value {
    let folder = hidden(effects, fraction);
    let diagnosis = diagnose(folder.path());
    serde_json::json!([diagnosis["verdict"], diagnosis["effects"], diagnosis["evidence"]])
}

#[test]
fn where_nothing_is_hidden_nothing_is_found() {
    for fraction in [0.003, 0.03] {
        let found = found(&[], fraction);
        assert_eq!(found[0], "nothing-missing", "{fraction}: {found}");
    }
}

/// Effects whose signature is in the measured loops themselves, and what is said of them.
const IN_THE_LOOP: [(&str, &str); 7] = [
    ("micro_slip", "bends over gradually"),
    ("residual_stiffness", "inclined"),
    ("normal_load_variation", "follows the measured normal load"),
    ("velocity_weakening", "from the slowest to the fastest"),
    ("wear", "per millimetre of slip"),
    ("backlash", "stays near zero"),
    ("asymmetry", "upper and lower plateaus differ"),
];

/// Whether the effect alone is found, and its evidence, where it shows in the loop, says what was seen.
fn is_named(effect: &str, found: &Value) -> bool {
    let seen =
        |said: &str| {
            found[2].as_array().unwrap().iter().any(|evidence| {
                evidence["effect"] == effect && evidence["seen"].as_str().unwrap().contains(said)
            })
        };
    found[0] == "effect-found"
        && found[1] == serde_json::json!([effect])
        && IN_THE_LOOP.iter().all(|(id, said)| *id != effect || seen(said))
}

#[test]
fn every_effect_of_a_contact_is_found_and_its_evidence_is_reported() {
    let wrong: Vec<String> = Kind::Contact
        .effects()
        .iter()
        .copied()
        .map(|effect| (effect, found(&[effect], 0.01)))
        .filter(|(effect, found)| !is_named(effect, found))
        .map(|(effect, found)| format!("{effect}: {found}"))
        .collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
}

/// From the refitted model without it, and from most starts, the fit of a resonator ends in a false minimum: over long
/// records a wrong frequency falls out of step.
#[test]
fn a_resonator_is_found_though_its_frequency_is_unknown() {
    let folder = hidden_in(Kind::Oscillator, &["hanging_mass"], 0.01);
    let tried = "hanging_mass,added_mass,residual_stiffness";
    let arguments = ["diagnose", "model.toml", ".", "--effects", tried, "--json", "d.json"];
    run(folder.path(), &arguments, 10);
    let diagnosis = read_json(folder.path(), "d.json");
    assert_eq!(diagnosis["effects"], serde_json::json!(["hanging_mass"]), "{diagnosis:#}");
    let error = |name: &str| diagnosis["error"][name].as_f64().unwrap();
    assert!(error("untouched") < 1.15 * error("noise_floor"), "{}", diagnosis["error"]);
}

#[test]
fn the_parameters_reported_are_those_of_the_model_with_all_effects_found() {
    let folder = hidden(&["backlash", "stiffening"], 0.03);
    let diagnosis = diagnose(folder.path());
    assert_eq!(diagnosis["verdict"], "effect-found", "{diagnosis:#}");
    let model = Model::parse(&fs::read_to_string(folder.path().join("found.toml")).unwrap()).unwrap();
    for (place, effect) in diagnosis["effects"].as_array().unwrap().iter().enumerate() {
        let candidates = diagnosis["candidates"].as_array().unwrap();
        let candidate = candidates.iter().find(|one| one["effect"] == *effect).unwrap();
        for (name, told) in candidate["parameters"].as_object().unwrap() {
            let path = format!("effect.{}.{name}", place + 1);
            assert_eq!(diagnosis["parameters"][&path], *told, "{path}");
            let written = model.get(&path).unwrap();
            assert!(
                (told["value"].as_f64().unwrap() / written - 1.0).abs() < 1e-9,
                "{path}: {told} {written}"
            );
            assert!((told["low"].as_f64().unwrap()..told["high"].as_f64().unwrap()).contains(&written));
        }
    }
}

#[test]
fn what_no_entry_of_the_catalogue_explains_is_not_given_a_name() {
    let found = found(&["unknown:position_dependent_friction"], 0.003);
    assert_eq!(found[0], "unexplained", "{found}");
    assert_eq!(found[1], serde_json::json!([]), "{found}");
}

#[test]
fn the_effect_found_is_added_the_error_falls_and_the_new_model_runs_as_an_fmu() {
    let folder = hidden(&["backlash"], 0.03);
    let path = folder.path();
    let diagnosis = diagnose(path);
    assert_eq!(diagnosis["effects"], serde_json::json!(["backlash"]), "{diagnosis:#}");
    let of = |value: &Value| value.as_f64().unwrap();
    let error = &diagnosis["error"];
    assert!(of(&error["final"]) < 0.5 * of(&error["refitted"]), "{error}");
    run(path, &["add", "model.toml", "backlash", "--fit", ".", "-o", "new.toml"], 0);
    // The model that the diagnosis wrote is the one it tells of; one that `add` fits to all records is as good.
    for (model, tolerance) in [("found.toml", 1e-3), ("new.toml", 0.01)] {
        run(path, &["compare", model, ".", "--no-fit", "--json", "c.json"], 0);
        let after = of(&read_json(path, "c.json")["error"]["baseline"]);
        assert!((after / of(&error["final"]) - 1.0).abs() < tolerance, "{model}: {after}, {error}");
    }
    run(path, &["export", "new.toml", "-o", "New.fmu"], 0);
    let text = fs::read_to_string(path.join("new.toml")).unwrap();
    // The first record starts from rest below the level of slip, the third far above it.
    for record in ["r0.csv", "r2.csv"] {
        let columns = columns(&fs::read_to_string(path.join(record)).unwrap());
        let native = native(&Model::parse(&text).unwrap(), &columns);
        let fmu = through_fmu(path, &columns);
        let largest = native.iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
        for (index, (one, other)) in native.iter().zip(&fmu).enumerate() {
            assert!((one - other).abs() <= 1e-12 * largest, "{record}, row {index}: {one} and {other}");
        }
        let left = normalised_error(&fmu, &columns["force"]);
        assert!(left < 2.0 * of(&error["final"]), "{record}: {left}, {error}");
    }
}

/// Columns of a table by quantity, in the units of the file, which are SI.
fn columns(text: &str) -> BTreeMap<String, Vec<f64>> {
    let mut lines = text.lines();
    let names: Vec<&str> =
        lines.next().unwrap().split(',').map(|name| name.split(" [").next().unwrap()).collect();
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for line in lines {
        for (name, value) in names.iter().zip(line.split(',')) {
            columns.entry((*name).to_owned()).or_default().push(value.parse().unwrap());
        }
    }
    columns
}

/// Force of the model's law along the measured displacement.
fn native(model: &Model, columns: &BTreeMap<String, Vec<f64>>) -> Vec<f64> {
    let law = model.law().unwrap().unwrap();
    let normal_load = model.contact.as_ref().unwrap().normal_load;
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, normal_load, 0.0, &mut state);
    let mut next = state.clone();
    let mut step = |displacement: &f64| {
        let inputs = Inputs { displacement: *displacement, velocity: 0.0, normal_load };
        let force = law.step(&state, inputs, &mut next).force;
        std::mem::swap(&mut state, &mut next);
        force
    };
    columns["displacement"].iter().map(&mut step).collect()
}

/// The same through the functions of the exported FMU.
fn through_fmu(path: &Path, columns: &BTreeMap<String, Vec<f64>>) -> Vec<f64> {
    let unpacked = tempfile::tempdir().unwrap();
    let file = unpacked.path().join(format!("New.{}", library().extension));
    fs::write(&file, entry(path, &format!("binaries/{}/New.{}", library().platform, library().extension)))
        .unwrap();
    fs::write(unpacked.path().join("model.toml"), entry(path, "resources/model.toml")).unwrap();
    let description = String::from_utf8(entry(path, "modelDescription.xml")).unwrap();
    let reference = |name: &str| -> u32 {
        let variable = description.split("<ScalarVariable").find(|v| v.contains(&format!("name=\"{name}\"")));
        attribute(variable.unwrap(), "valueReference").parse().unwrap()
    };
    let (input, output) = (reference("displacement"), reference("force"));
    let library = Library::load(&file).unwrap();
    let mut slave = Slave::new(library, "new", attribute(&description, "guid"), unpacked.path()).unwrap();
    let (time, displacement) = (&columns["time"], &columns["displacement"]);
    slave.set_up(None, time[0]).unwrap();
    slave.enter_initialization().unwrap();
    slave.set_real(&[input], &displacement[..1]).unwrap();
    slave.exit_initialization().unwrap();
    let mut force = [0.0];
    slave.get_real(&[output], &mut force).unwrap();
    let mut forces = vec![force[0]];
    for index in 1..time.len() {
        slave.set_real(&[input], &displacement[index..=index]).unwrap();
        slave.do_step(time[index - 1], time[index] - time[index - 1]).unwrap();
        slave.get_real(&[output], &mut force).unwrap();
        forces.push(force[0]);
    }
    forces
}

/// A file in the exported FMU.
fn entry(path: &Path, name: &str) -> Vec<u8> {
    let mut archive = zip::ZipArchive::new(Cursor::new(fs::read(path.join("New.fmu")).unwrap())).unwrap();
    let mut bytes = Vec::new();
    archive.by_name(name).unwrap().read_to_end(&mut bytes).unwrap();
    bytes
}

/// Value of the first attribute called `name`.
fn attribute<'t>(text: &'t str, name: &str) -> &'t str {
    let start = text.find(&format!("{name}=\"")).unwrap() + name.len() + 2;
    text[start..].split('"').next().unwrap()
}

/// Root mean square of the difference over the standard deviation of what was measured.
fn normalised_error(predicted: &[f64], measured: &[f64]) -> f64 {
    let mean = measured.iter().sum::<f64>() / measured.len() as f64;
    let left: f64 = predicted.iter().zip(measured).map(|(p, m)| (p - m).powi(2)).sum();
    let all: f64 = measured.iter().map(|m| (m - mean).powi(2)).sum();
    (left / all).sqrt()
}
