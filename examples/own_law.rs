//! A contact law of your own: a cubic spring that no file of the library knows, in a structure, by harmonic balance.
//!
//! `cargo run --release -p stickslip --example own_law`

use std::sync::Arc;

use stickslip::prelude::*;

/// `T = k3 u³`, without memory.
#[derive(Debug)]
struct Hardening(f64);

impl ContactLaw for Hardening {
    fn state_len(&self) -> usize {
        0
    }
    fn set_state(&self, _displacement: f64, _normal_load: f64, _force: f64, _state: &mut [f64]) {}
    fn step(&self, _state: &[f64], inputs: Inputs, _next: &mut [f64]) -> Response {
        let u = inputs.displacement;
        let tangents = Tangents { displacement: 3.0 * self.0 * u * u, ..Tangents::default() };
        Response { force: self.0 * u * u * u, tangents, dissipated_energy: 0.0, slip_state: SlipState::Stick }
    }
    fn state_tangents(&self, _state: &[f64], _inputs: Inputs, out: &mut StateTangents) {
        out.reset(0);
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::parse(include_str!("friction-vibration/model.toml")).map_err(|error| error.message)?;
    let mut system = model.system()?;
    if let [Element::Law { law, .. }] = &mut system.elements[..] {
        *law = Arc::new(Hardening(0.05)); // instead of the law of the model's one contact
    }
    let (force, settings) = (Control::Level(0.1), CurveSettings::default());
    let curve = frequency_response(&Assembly::new(system), 0.4, 1.0, &force, &settings, &mut |_| true)?;
    for peak in &curve.peaks {
        println!("mass {}: {:.4} m at {:.4} rad/s", peak.node + 1, peak.amplitude, peak.angular_frequency);
    }
    Ok(())
}
