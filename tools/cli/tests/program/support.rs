//! What the tests of the program use: the program, its answers, and a measured loop.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;
use tempfile::TempDir;

pub fn stickslip(folder: impl AsRef<Path>, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_stickslip")).current_dir(folder).args(arguments).output().unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into_owned()
}

pub fn error(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

pub fn read_json(folder: impl AsRef<Path>, name: &str) -> Value {
    serde_json::from_slice(&fs::read(folder.as_ref().join(name)).unwrap()).unwrap()
}

pub fn entries(folder: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.sort();
    all
}

pub const CONTACT: &str = r#"schema = "stickslip.model/1"
kind = "contact"

[contact]
law = "jenkins"
tangential_stiffness = 2.0e6
friction_coefficient = 0.5
normal_load = 100.0
"#;

const DATASET: &str = r#"schema = "stickslip.dataset/1"

[[record]]
file = "loop.csv"
regime = "from-rest"
"#;

/// A folder with `model.toml`, `data/dataset.toml` and a loop measured on a contact of 3e6 N/m and 60 N.
pub fn example() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("model.toml"), CONTACT).unwrap();
    fs::create_dir(folder.path().join("data")).unwrap();
    fs::write(folder.path().join("data/dataset.toml"), DATASET).unwrap();
    fs::write(folder.path().join("data/loop.csv"), measured_loop()).unwrap();
    folder
}

/// Jenkins' element stepped by hand, in millimetres and kilonewtons.
pub fn measured_loop() -> String {
    let (mut slider, mut text) = (0.0_f64, "time [s],displacement [mm],force [kN]\n".to_owned());
    for index in 0..400 {
        let time = f64::from(index) * 0.0025;
        let displacement = 50e-6 * (std::f64::consts::TAU * 2.0 * time).sin();
        let force = (3e6 * (displacement - slider)).clamp(-60.0, 60.0);
        slider = displacement - force / 3e6;
        text += &format!("{time},{},{}\n", displacement * 1e3, force * 1e-3);
    }
    text
}
