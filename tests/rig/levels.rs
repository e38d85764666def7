//! Frequency responses at held levels, measured on the rig and fitted as the paper does (its figure 3): about every resonance a
//! band of 1 Hz, noise of 1 %.
//!
//! Items to verify: the resonance falls over the level; its peak dips, and rises again; each is what an independent program's
//! harmonic balance of the same beam says.

use stickslip::data::Dataset;
use stickslip::identify::{IdentifyOptions, Level, LevelSource, identify};
use stickslip::rig::{Chain, ChannelFault, Frequencies, NoiseLevel, Plan, SteppedSine, TestKind, test_on};

use crate::{SENSORS, published, test};

/// Acceleration held (m/s²), frequency (Hz) and acceleration over force (1/kg) at its phase resonance: four modes, five
/// harmonics, the contact integrated by Runge–Kutta.
const REFERENCE: [[f64; 3]; 8] = [
    [0.5, 54.04412, 24.84903],
    [10.0, 53.28555, 4.06899],
    [20.0, 51.63627, 2.87647],
    [30.0, 50.60267, 3.13879],
    [40.0, 50.07023, 3.62118],
    [50.0, 49.75739, 4.13795],
    [60.0, 49.55415, 4.65492],
    [70.0, 49.41326, 5.16371],
];
/// Records about each resonance.
const COUNT: usize = 5;

fn levels() -> Vec<Level> {
    let model = published(4, |text| text);
    let mut plan = Plan::of_sensors(&SENSORS);
    let fault = ChannelFault { noise: NoiseLevel::Fraction(0.01), ..ChannelFault::default() };
    let accelerometers = vec![fault; SENSORS.len()];
    plan.chain = Chain { excitation: fault, accelerometers, noise_told: true, ..Chain::default() };
    let frequencies = Frequencies::AroundResonance { band: 1.0, count: COUNT };
    let sine = SteppedSine { frequencies, ..SteppedSine::at(REFERENCE.map(|row| row[0]).to_vec()) };
    plan.tests.push(test("level", TestKind::SteppedSine(sine)));
    let dataset = Dataset { title: None, records: test_on(&model, &plan, &mut |_| true).unwrap() };
    identify(&model, &dataset, &IdentifyOptions::default()).unwrap().levels
}

#[test]
fn over_the_level_the_resonance_falls_and_its_peak_dips_and_rises() {
    let levels = levels();
    assert_eq!(levels.len(), REFERENCE.len());
    for (level, [amplitude, frequency, peak]) in levels.iter().zip(REFERENCE) {
        let found = level.peak.unwrap();
        println!(
            "{:.1} m/s²: {:.3} Hz ({frequency:.3}), {found:.3} 1/kg ({peak:.3})",
            amplitude, level.frequency
        );
        assert!(
            matches!(&level.source, LevelSource::Stepped(records) if records.len() == COUNT),
            "{level:?}"
        );
        assert!((level.amplitude / amplitude - 1.0).abs() < 0.01, "{level:?}");
        // At 10 m/s² the contact stiffens over the band, which no linear mode does.
        assert!((level.frequency - frequency).abs() < 0.08, "{level:?}");
        assert!((found / peak - 1.0).abs() < 0.02, "{level:?}");
    }
    assert!(levels.is_sorted_by(|a, b| a.frequency > b.frequency), "softening");
    let peaks: Vec<f64> = levels.iter().map(|level| level.peak.unwrap()).collect();
    // The dip is at 20 m/s².
    assert!(peaks[..3].is_sorted_by(|a, b| a > b) && peaks[2..].is_sorted_by(|a, b| a < b), "{peaks:?}");
    let stiffness: Vec<f64> =
        levels.iter().map(|level| *level.rotational_stiffness.as_ref().unwrap()).collect();
    assert!(stiffness.is_sorted_by(|a, b| a > b), "{stiffness:?}");
    let dampings: Vec<f64> = levels.iter().map(|level| level.damping_ratio.unwrap()).collect();
    assert!(
        dampings[..3].is_sorted_by(|a, b| a < b) && dampings[2..].is_sorted_by(|a, b| a > b),
        "{dampings:?}"
    );
}
