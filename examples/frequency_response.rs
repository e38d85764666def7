//! From a model file to its response curve: two masses, one of them on a rough ground, under 0.4 N.
//!
//! `cargo run --release -p stickslip --example frequency_response`

use stickslip::prelude::*;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = Model::parse(include_str!("friction-vibration/model.toml")).map_err(|error| error.message)?;
    let system = Assembly::new(model.system()?);

    // 0.2 to 2 rad/s, 21 harmonics, the error estimated at every point. The closure sees each point and may stop.
    let settings = CurveSettings { harmonics: 21, ..CurveSettings::default() };
    let curve = frequency_response(&system, 0.2, 2.0, &Control::Level(0.4), &settings, &mut |_| true)?;

    for peak in &curve.peaks {
        let node = &curve.nodes[peak.node];
        println!("{node}: peak of {:.5} m at {:.5} rad/s", peak.amplitude, peak.angular_frequency);
    }
    let worst = curve.points.iter().map(|point| point.error_estimate).fold(0.0, f64::max);
    println!("{} points, truncation error at most {worst:.1e}", curve.points.len());
    Ok(())
}
