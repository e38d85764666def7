//! A published study of two masses with a Jenkins element, computed again with the library: each figure's data, and
//! which statements of the text its own model supports.
//!
//! `cargo run --release -p friction-vibration [FOLDER]` writes `friction-vibration.html` and `.json` to the folder
//! (`stickslip-demo` unless given).

mod draw;
mod response;
mod statements;
mod sweeps;
mod system;
mod time_domain;

use std::path::PathBuf;

use sha2::{Digest as _, Sha256};
use stickslip_report::document::{Document, document_html, document_json, scientific};
use stickslip_report::{InputFile, Settings};

use self::system::{MODEL, System};

/// Why there is no result.
type Failure = Box<dyn std::error::Error>;

/// Schema of the study's data.
const SCHEMA: &str = "stickslip.study/1";

fn main() -> Result<(), Failure> {
    let folder = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("stickslip-demo"), PathBuf::from);
    std::fs::create_dir_all(&folder)?;
    let study = friction_vibration()?;
    println!("{}\n{}\n", study.title, study.lead);
    let model = "examples/friction-vibration/model.toml";
    let hash = Sha256::digest(MODEL).iter().map(|byte| format!("{byte:02x}")).collect();
    let settings = Settings {
        command: "cargo run --release -p friction-vibration".into(),
        version: env!("CARGO_PKG_VERSION").into(),
        files: vec![InputFile { name: model.into(), sha256: hash }],
        date: None,
    };
    let data = document_json(&study, SCHEMA);
    for (name, text) in [
        ("friction-vibration.json", format!("{data}\n")),
        ("friction-vibration.html", document_html(&study, &settings)),
    ] {
        std::fs::write(folder.join(name), text)?;
        println!("wrote {}", folder.join(name).display());
    }
    Ok(())
}

/// Computes everything.
fn friction_vibration() -> Result<Document, Failure> {
    let started = std::time::Instant::now();
    let system = System::new()?;
    let forces = sweeps::over_force(&system)?;
    let frictions = sweeps::over_friction(&system)?;
    let (statements, failing) = statements::section(&system, &forces, &frictions)?;
    let (response, deviation) = response::response_section(&system)?;
    let sections = vec![
        statements,
        response::system_section(&system)?,
        response,
        response::loop_section(&system)?,
        sweeps::force_section(&system, &forces)?,
        sweeps::friction_section(&system, &frictions)?,
        sweeps::stiffness_section(&system)?,
    ];
    Ok(Document {
        title: "Two masses, one of them on a rough ground".into(),
        lead: format!(
            "Harmonic balance and time integration agree to {} of each quantity; {failing} statements of the paper do not \
             hold in its own model.",
            scientific(deviation)
        ),
        warnings: Vec::new(),
        scope: format!(
            "The system of “A numerical study on the interaction between friction and vibration in a friction-involved \
             dynamical system” (doi:10.1088/1742-6596/2909/1/012023). Figures are numbered as there; all of them are computed here, \
             in {:.1} s.",
            started.elapsed().as_secs_f64()
        ),
        sections,
    })
}
