//! From the records of a beam to its contact, and to the FMU that holds it.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use serde_json::Value;
use stickslip::contact::Valanis;
use stickslip::harmonic::fourier::{time_derivative, value};
use stickslip::harmonic::{CurveSettings, Resonance, phase_resonance};
use stickslip::model::{Model, Structure};
use stickslip::system::ModalBeam;
use stickslip_hidden_effects::cases::case::{Case, Kind, Noise, Strength};
use stickslip_hidden_effects::cases::files;
use stickslip_hidden_effects::motion::drive::Drive;
use stickslip_hidden_effects::rigs::setting::Setting;
use tempfile::TempDir;

use crate::support::{entries, error, read_json, stdout, stickslip};

/// The published beam with a contact that nobody has measured.
const MODEL: &str = r#"schema = "stickslip.model/1"
kind = "beam"

[beam]
length = 0.6
width = 0.04
thickness = 0.005
density = 7850.0
youngs_modulus = 197.1e9
modes = 4
damping_ratio = 0.003
point_mass = [{ position = 0.55, mass = 0.02515 }, { position = 0.3, mass = 0.005 }, { position = 0.1, mass = 0.005 }]

[support]
offset = 0.006

[excitation]
position = 0.55

[contact]
law = "jenkins"
tangential_stiffness = 1.0e6
friction_coefficient = 0.1
normal_load = 147.15
"#;

/// The published amplitudes (m/s²).
const LEVELS: [f64; 6] = [20.0, 30.0, 40.0, 50.0, 60.0, 70.0];
const HARMONICS: usize = 9;
const PERIODS: usize = 16;
/// Samples of a period.
const SAMPLES: usize = 256;

/// Table 3.
const STIFFNESS: f64 = 7.9e6;
const RATE: f64 = 8.7e4;
const SMOOTHNESS: f64 = 0.3;
const LOAD: f64 = 147.15;

fn beam() -> ModalBeam {
    let Structure::Beam(mut beam) = Model::parse(MODEL).unwrap().structure else { panic!("a beam") };
    (beam.modes, beam.static_correction) = (30, true);
    ModalBeam::new(&beam).unwrap()
}

fn resonance(beam: &ModalBeam, level: f64) -> Resonance {
    let law = Arc::new(Valanis::from_lambda(STIFFNESS, 0.0, SMOOTHNESS, RATE, LOAD).unwrap());
    let settings = CurveSettings { harmonics: HARMONICS, ..CurveSettings::default() };
    phase_resonance(&beam.system(Some((law, LOAD))).unwrap(), level, &settings, None).unwrap()
}

/// A folder with `model.toml` and records of the published levels, with `noise` as a part of each channel's root mean square
/// and gains of the accelerometers and the load cell; and the truth.
fn measured(noise: f64, gains: [f64; 4]) -> (TempDir, Vec<Resonance>) {
    let beam = beam();
    let truths: Vec<Resonance> = LEVELS.iter().map(|level| resonance(&beam, *level)).collect();
    let mut random = fastrand::Rng::with_seed(8);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let folder = tempfile::tempdir().unwrap();
    let mut dataset = "schema = \"stickslip.dataset/1\"\n".to_owned();
    for (level, truth) in LEVELS.iter().zip(&truths) {
        let modes: Vec<&[f64]> = truth.coefficients.chunks_exact(2 * HARMONICS + 1).collect();
        let mut channels = vec![vec![0.0, gains[3] * truth.force_amplitude, 0.0]];
        for (sensor, gain) in beam.sensors.iter().zip(gains) {
            let moved = |k| gain * sensor.shape.iter().zip(&modes).map(|(s, q)| s * q[k]).sum::<f64>();
            let moved: Vec<f64> = (0..=2 * HARMONICS).map(moved).collect();
            channels.push(time_derivative(&moved, 2, truth.angular_frequency));
        }
        let mut text = "time [s],excitation [N]".to_owned();
        beam.sensors.iter().for_each(|at| write!(text, ",acceleration:x={} [m/s^2]", at.position).unwrap());
        for k in 0..PERIODS * SAMPLES {
            let phase = TAU * k as f64 / SAMPLES as f64;
            write!(text, "\n{:.9}", phase / truth.angular_frequency).unwrap();
            for channel in &channels {
                let size = (channel.iter().map(|x| x * x).sum::<f64>() / 2.0).sqrt();
                write!(text, ",{:.9e}", value(channel, phase) + noise * size * normal()).unwrap();
            }
        }
        fs::write(folder.path().join(format!("level-{level}.csv")), text).unwrap();
        write!(dataset, "\n[[record]]\nfile = \"level-{level}.csv\"\nregime = \"steady\"\n").unwrap();
    }
    fs::write(folder.path().join("dataset.toml"), dataset).unwrap();
    fs::write(folder.path().join("model.toml"), MODEL).unwrap();
    (folder, truths)
}

/// Root mean square of `found` less `truth` over that of `truth`, means left out.
fn off(found: &[f64], truth: &[f64]) -> f64 {
    let without = |values: &[f64]| -> Vec<f64> {
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        values.iter().map(|value| value - mean).collect()
    };
    let (found, truth) = (without(found), without(truth));
    let squares = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    (squares(&mut found.iter().zip(&truth).map(|(a, b)| a - b)) / squares(&mut truth.iter().copied())).sqrt()
}

/// The table of a level against what was simulated: force and the contact's own displacement.
fn check_loop(folder: &Path, level: f64, truth: &Resonance, flexibility: f64, bound: f64) {
    let text = fs::read_to_string(folder.join(format!("contact/level-{level}-contact.csv"))).unwrap();
    let mut lines = text.lines();
    assert_eq!(lines.next(), Some("time [s],displacement [m],velocity [m/s],force [N]"));
    let rows: Vec<Vec<f64>> =
        lines.map(|line| line.split(',').map(|cell| cell.parse().unwrap()).collect()).collect();
    let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
    let at = |coefficients: &[f64]| -> Vec<f64> {
        column(0).iter().map(|time| value(coefficients, truth.angular_frequency * time)).collect()
    };
    assert!(off(&column(3), &at(&truth.contact_force)) < bound, "{level}");
    let own =
        truth.contact_displacement.iter().zip(&truth.contact_force).map(|(u, force)| u - flexibility * force);
    let own: Vec<f64> = own.collect();
    assert!(off(&column(1), &at(&own)) < bound, "{level}");
    let velocity = time_derivative(&own, 1, truth.angular_frequency);
    assert!(off(&column(2), &at(&velocity)) < bound, "{level}");
}

#[test]
fn table_3_comes_back_through_files_and_becomes_an_fmu() {
    for (noise, gains, bound) in [(0.0, [1.0; 4], 0.02), (0.01, [1.01, 0.99, 1.01, 0.99], 0.05)] {
        let (folder, truths) = measured(noise, gains);
        let files = ["--json", "i.json", "--report", "i.html", "--csv", "contact", "-o", "new.toml"];
        let output = stickslip(folder.path(), &[&["identify", "model.toml", "."][..], &files].concat());
        assert!(output.status.success(), "{}", error(&output));
        let json = read_json(&folder, "i.json");
        assert_eq!(json["schema"], "stickslip.identification/1");
        assert_eq!((&json["method"], &json["best"]), (&"receptance-inversion".into(), &"valanis".into()));
        let law = json["laws"].as_array().unwrap().iter().find(|law| law["law"] == "valanis").unwrap();
        let value = |name: &str| law["parameters"][name]["value"].as_f64().unwrap();
        let rate = value("tangential_stiffness") / (value("friction_coefficient") * LOAD);
        for (found, truth) in
            [(value("tangential_stiffness"), STIFFNESS), (rate, RATE), (value("smoothness"), SMOOTHNESS)]
        {
            assert!((found / truth - 1.0).abs() < 0.02, "{found} {truth}");
        }
        // One level was fitted, the others predicted.
        assert_eq!(law["fitted_records"], serde_json::json!(["level-70.csv"]));
        let errors: Vec<f64> =
            law["error"].as_object().unwrap().values().map(|error| error.as_f64().unwrap()).collect();
        assert!(errors.len() == LEVELS.len() && errors.iter().all(|error| *error < bound), "{errors:?}");
        let flexibility = beam().axial_flexibility;
        for (level, truth) in LEVELS.iter().zip(&truths) {
            check_loop(folder.path(), *level, truth, flexibility, bound);
        }
        let untold: Vec<&str> =
            json["unidentified"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
        assert!(untold.contains(&"normal_stiffness"), "{untold:?}");
        // Page, text and files say the same.
        let page = fs::read_to_string(folder.path().join("i.html")).unwrap();
        for expected in ["Measuring chain", "Resonance over the amplitude", "normal_stiffness"] {
            assert!(page.contains(expected) && stdout(&output).contains(expected), "{expected}");
        }
        let new = Model::parse(&fs::read_to_string(folder.path().join("new.toml")).unwrap()).unwrap();
        assert_eq!(new.get("contact.tangential_stiffness"), Some(value("tangential_stiffness")));
        let exported = stickslip(folder.path(), &["export", "new.toml", "-o", "Support.fmu"]);
        assert!(exported.status.success(), "{}", error(&exported));
    }
}

#[test]
fn levels_are_fitted_as_asked() {
    let (folder, _) = measured(0.001, [1.0; 4]);
    let arguments = ["identify", "model.toml", ".", "--fit", "level-30,level-60.csv", "--json", "i.json"];
    let output = stickslip(folder.path(), &arguments);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "i.json");
    assert_eq!(json["laws"][0]["fitted_records"], serde_json::json!(["level-30.csv", "level-60.csv"]));
}

#[test]
fn a_file_without_a_dataset_is_identified_as_it_is_with_one() {
    let (folder, _) = measured(0.001, [1.0; 4]);
    let alone =
        "schema = \"stickslip.dataset/1\"\n[[record]]\nfile = \"level-60.csv\"\nregime = \"steady\"\n";
    fs::write(folder.path().join("dataset.toml"), alone).unwrap();
    let found = |data: &[&str]| {
        let arguments = [&["identify", "model.toml", "--json", "i.json"][..], data].concat();
        let output = stickslip(folder.path(), &arguments);
        assert!(output.status.success(), "{}", error(&output));
        read_json(&folder, "i.json")
    };
    let (listed, lone) = (found(&["."]), found(&["level-60.csv", "--regime", "steady"]));
    assert_eq!(listed["records"], lone["records"]);
    assert_eq!(listed["laws"], lone["laws"]);
    assert!(lone["best"].is_string());
    // What was guessed stands in the results, too.
    let table = fs::read_to_string(folder.path().join("level-60.csv")).unwrap();
    fs::write(folder.path().join("dialect.csv"), table.replace(',', ";")).unwrap();
    let arguments = [
        "identify",
        "model.toml",
        "dialect.csv",
        "--regime",
        "steady",
        "--json",
        "i.json",
        "--report",
        "i.html",
    ];
    let output = stickslip(folder.path(), &arguments);
    let told = error(&output);
    let told: Vec<&str> = told.lines().filter_map(|line| line.strip_prefix("note: ")).collect();
    let page = fs::read_to_string(folder.path().join("i.html")).unwrap();
    assert!(told.iter().any(|note| note.starts_with("dialect.csv: ")), "{told:?}");
    assert_eq!(read_json(&folder, "i.json")["notes"], serde_json::json!(told));
    assert!(page.contains("How the measurements were read"));
    assert!(!String::from_utf8_lossy(&output.stdout).contains("How the measurements"));
}

/// What the program says of bad input; it writes nothing.
fn refused(folder: &TempDir, more: &[&str]) -> String {
    let before = entries(folder.path());
    let arguments =
        [&["identify", "model.toml", ".", "--json", "i.json", "--csv", "contact"][..], more].concat();
    let output = stickslip(folder.path(), &arguments);
    assert_eq!(output.status.code(), Some(2), "{}", error(&output));
    assert_eq!(entries(folder.path()), before);
    error(&output)
}

#[test]
fn what_is_missing_is_named() {
    let (folder, _) = measured(0.001, [1.0; 4]);
    let rewrite = |name: &str, change: &dyn Fn(&str) -> String| {
        let path = folder.path().join(name);
        let before = fs::read_to_string(&path).unwrap();
        fs::write(&path, change(&before)).unwrap();
        before
    };
    let said = refused(&folder, &["--fit", "level-80"]);
    assert!(said.contains("`level-80`") && said.contains("level-70.csv"), "{said}");
    // A contact alone.
    let contact = "schema = \"stickslip.model/1\"\nkind = \"contact\"\n\n[contact]\nlaw = \"jenkins\"\n\
                   tangential_stiffness = 1e6\nfriction_coefficient = 0.1\nnormal_load = 100.0\n";
    let model = rewrite("model.toml", &|_| contact.to_owned());
    assert!(refused(&folder, &[]).contains("must be \"beam\""));
    // No contact, and no load.
    rewrite("model.toml", &|_| model.split("\n[contact]").next().unwrap().to_owned());
    assert!(refused(&folder, &[]).contains("--normal-load"));
    rewrite("model.toml", &|_| model.clone());
    // A record without excitation is left out, with its reason; the others serve.
    rewrite("level-20.csv", &|text| text.replacen("excitation [N]", "force [N]", 1));
    let output = stickslip(folder.path(), &["identify", "model.toml", "."]);
    assert!(
        output.status.success()
            && stdout(&output).contains("level-20.csv: it has no `excitation [N]` column")
    );
    // Asked to fit laws to it, the program cannot.
    let output =
        stickslip(folder.path(), &["identify", "model.toml", ".", "--fit", "level-20", "--json", "i.json"]);
    assert_eq!(output.status.code(), Some(1), "{}", error(&output));
    assert!(
        error(&output).contains("`level-20.csv`: it has no `excitation [N]` column"),
        "{}",
        error(&output)
    );
    assert!(!folder.path().join("i.json").exists());
    // No steady record at all.
    rewrite("dataset.toml", &|text| {
        let first = text.split("\n[[record]]").take(2).collect::<Vec<_>>().join("\n[[record]]");
        first.replace("steady", "unknown-initial-state")
    });
    let said = refused(&folder, &[]);
    assert!(said.contains("nothing excites it") && said.contains("regime \"steady\""), "{said}");
}

/// A beam of another make, at eight held levels: its own modes are those of its model. With `model.toml` in a folder.
fn of_another_make(effect: &'static str) -> (TempDir, Model) {
    let case = Case {
        kind: Kind::Beam,
        effects: vec![effect],
        strength: Strength::Full,
        noise: Noise { share: 0.01, coloured: false },
        drive: Drive::Stationary,
        setting: Setting::HeldLevels,
        replica: 1,
    };
    let folder = tempfile::tempdir().unwrap();
    let drawn = case.draw().unwrap();
    for (name, text) in files::texts(&drawn) {
        fs::write(folder.path().join(name), text).unwrap();
    }
    let true_model = Model::parse(&drawn.true_model().unwrap()).unwrap();
    (folder, true_model)
}

fn law_called<'j>(json: &'j Value, name: &str) -> &'j Value {
    json["laws"].as_array().unwrap().iter().find(|law| law["law"] == name).unwrap()
}

#[test]
fn the_contact_of_a_beam_of_another_make_is_identified() {
    let (folder, true_model) = of_another_make("micro_slip:valanis");
    let arguments = ["identify", "model.toml", ".", "--json", "i.json"];
    let output = stickslip(folder.path(), &arguments);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "i.json");
    assert_eq!((&json["best"], &json["range"]), (&"valanis".into(), &Value::Null));
    assert!(json["beam"].as_str().unwrap().contains("the 6 modes of the model."), "{}", json["beam"]);
    let law = law_called(&json, "valanis");
    // 512 samples of 1 % noise at one level: what they tell, and no more.
    for name in ["tangential_stiffness", "friction_coefficient", "smoothness"] {
        let truth = true_model.get(&format!("contact.{name}")).unwrap();
        let end = |end: &str| law["parameters"][name][end].as_f64().unwrap();
        assert!(end("low") < truth && truth < end("high"), "{name}: {}", law["parameters"][name]);
        assert!((end("value") / truth - 1.0).abs() < 0.05, "{name}: {}", law["parameters"][name]);
    }
    for (record, error) in law["error"].as_object().unwrap() {
        assert!(error.as_f64().unwrap() < 0.03, "{record}: {error}");
    }
}

/// Forty sliders of another distribution than any law of the library has: the map of the largest loop predicts the others,
/// which are up to a hundred times as small, and becomes an FMU.
#[test]
fn a_contact_of_no_law_becomes_a_measured_map_and_an_fmu() {
    let (folder, _) = of_another_make("micro_slip");
    let arguments = ["identify", "model.toml", ".", "--json", "i.json", "-o", "new.toml"];
    let output = stickslip(folder.path(), &arguments);
    assert!(output.status.success(), "{}", error(&output));
    let json = read_json(&folder, "i.json");
    assert_eq!(json["best"], "measured");
    let errors = |name: &str| -> Vec<f64> {
        let law = law_called(&json, name)["error"].as_object().unwrap();
        law.iter()
            .filter(|(record, _)| *record != "r7.csv")
            .map(|(_, error)| error.as_f64().unwrap())
            .collect()
    };
    assert_eq!(law_called(&json, "measured")["fitted_records"], serde_json::json!(["r7.csv"]));
    assert!(errors("measured").iter().all(|error| *error < 0.03), "{:?}", errors("measured"));
    for name in ["jenkins", "valanis", "iwan", "bouc_wen"] {
        assert!(errors(name).iter().any(|error| *error > 0.06), "{name} {:?}", errors(name));
    }
    // The range is told, and what lies beyond it.
    let range = json["range"].as_f64().unwrap();
    assert!((50e-6..150e-6).contains(&range), "{range}");
    let said = stdout(&output);
    assert!(said.contains("No law of the library describes") && !said.contains("Beyond the range"), "{said}");
    let output =
        stickslip(folder.path(), &["identify", "model.toml", ".", "--fit", "r4", "--json", "i.json"]);
    assert!(stdout(&output).contains("Beyond the range of the measured map: r5.csv, r6.csv, r7.csv."));
    let smaller = read_json(&folder, "i.json")["range"].as_f64().unwrap();
    assert!(smaller < 0.7 * range, "{smaller}");
    let new = Model::parse(&fs::read_to_string(folder.path().join("new.toml")).unwrap()).unwrap();
    assert_eq!(new.contact.unwrap().law.kind.name, "measured");
    let exported = stickslip(folder.path(), &["export", "new.toml", "-o", "Support.fmu"]);
    assert!(exported.status.success(), "{}", error(&exported));
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupt_ends_within_a_second_and_writes_nothing() {
    use std::process::{Command, Stdio};
    use std::time::{Duration, Instant};

    let (folder, _) = measured(0.01, [1.0; 4]);
    let before = entries(folder.path());
    let child = Command::new(env!("CARGO_BIN_EXE_stickslip"))
        .current_dir(folder.path())
        .args(["identify", "model.toml", ".", "--json", "i.json", "--csv", "contact"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    std::thread::sleep(Duration::from_millis(300));
    let begin = Instant::now();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let output = child.wait_with_output().unwrap();
    // A second of its own, and one for what else the machine does.
    assert!(begin.elapsed() < Duration::from_secs(2), "{:?}", begin.elapsed());
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    assert_eq!(entries(folder.path()), before);
}

#[test]
fn a_free_decay_tells_resonance_and_damping_over_the_amplitude() {
    let example = concat!(env!("CARGO_MANIFEST_DIR"), "/../../examples/frictional-support");
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| format!("{example}/{name}");
    let rig = stickslip(folder.path(), &["rig", &path("ring-down.toml"), "-o", "decay"]);
    assert!(rig.status.success(), "{}", error(&rig));
    let output =
        stickslip(folder.path(), &["identify", &path("published.toml"), "decay", "--json", "i.json"]);
    assert!(output.status.success(), "{}", error(&output));
    assert!(stdout(&output).contains("only resonances"), "{}", stdout(&output));
    let json = read_json(&folder, "i.json");
    let levels = json["levels"].as_array().unwrap();
    let number = |level: &Value, name: &str| level[name].as_f64().unwrap();
    // As the contact slips less and less the support is stiffer and takes less.
    let (small, large) = (&levels[0], &levels[levels.len() - 1]);
    assert!(levels.len() > 8 && number(large, "amplitude") > 20.0 * number(small, "amplitude"), "{levels:?}");
    assert!(number(small, "frequency") > number(large, "frequency") + 2.0, "{levels:?}");
    assert!(number(small, "damping_ratio") < 0.3 * number(large, "damping_ratio"), "{levels:?}");
    assert!(large["frequency_interval"].is_object() || large["frequency_interval"].is_array(), "{large}");
}
