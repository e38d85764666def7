//! The study of two masses with a Jenkins element: each figure's data, and what the text makes of them.

mod draw;
mod response;
mod statements;
mod sweeps;
mod system;
mod time_domain;

use stickslip_report::document::{Document, scientific};

pub use self::system::MODEL;
use self::system::System;
use crate::{Failure, progress};

/// Schema of the study's data.
pub const SCHEMA: &str = "stickslip.study/1";

/// Computes everything.
pub fn friction_vibration() -> Result<Document, Failure> {
    let bar = progress::spinner("friction-vibration");
    let started = std::time::Instant::now();
    let system = System::new()?;
    let mut sections = vec![response::system_section(&system)?];
    bar.set_message("figures 4 to 6");
    let (section, deviation) = response::response_section(&system)?;
    sections.push(section);
    sections.push(response::loop_section(&system)?);
    bar.set_message("figures 7 and 8");
    let forces = sweeps::over_force(&system)?;
    sections.push(sweeps::force_section(&system, &forces)?);
    bar.set_message("figures 9 and 10");
    let frictions = sweeps::over_friction(&system)?;
    sections.push(sweeps::friction_section(&system, &frictions)?);
    bar.set_message("figures 12 to 14");
    sections.push(sweeps::stiffness_section(&system)?);
    bar.set_message("statements");
    let (statements, failing) = statements::section(&system, &forces, &frictions)?;
    sections.insert(0, statements);
    bar.finish_and_clear();
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
