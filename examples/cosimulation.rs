//! A beam and its contact as two slaves that repeat each step until they agree, and the energy that the coupling feeds in.
//!
//! `cargo run --release -p stickslip --example cosimulation`

use std::ops::ControlFlow;

use stickslip::cosim::{Algorithm, Master, Method, NativeSlave, Settings, Source, Strong, System};
use stickslip::model::Model;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut system = System::new();
    system.add(Box::new(Source::new("shaker", "force", "N", |time| 60.0 * (324.0 * time).sin())))?;
    for (name, text) in [
        ("beam", include_str!("../modelDescription/ModalBeam.toml")),
        ("contact", include_str!("../modelDescription/ValanisContact.toml")),
    ] {
        let model = Model::parse(text).map_err(|error| error.message)?;
        system.add(Box::new(NativeSlave::new(name, &model)?))?;
    }
    system.connect(("shaker", "force"), ("beam", "excitation"), 1.0, 0.0)?;
    system.connect(("beam", "displacement"), ("contact", "displacement"), 1.0, 0.0)?;
    system.connect(("beam", "velocity"), ("contact", "velocity"), 1.0, 0.0)?;
    system.connect(("contact", "force"), ("beam", "contact_force"), 1.0, 0.0)?;
    system.observe("contact", "force")?;
    let method = Method::Anderson { depth: 5 };
    let algorithm = Algorithm::Strong(Strong { method, tolerance: 1e-9, iterations: 40 });
    let mut largest = 0.0_f64;
    let report = Master::new(system, Settings::new(algorithm, 1e-4, 0.1))?.run(|point| {
        largest = largest.max(point.values[0].abs());
        ControlFlow::Continue(())
    })?;
    let power = &report.energy[0];
    println!("largest friction force {largest:.1} N");
    println!("energy fed in {:.1e} J of {:.1e} J exchanged", power.sum, power.exchanged);
    Ok(())
}
