//! Curves through the corner at which a contact begins to slip: followed to their ends, and no peak.

use stickslip::contact::Jenkins;
use stickslip::harmonic::{Control, Ending, TrackedQuantity, Tracking, frequency_response, track_levels};

use crate::common::oscillator::{in_contact, settings, single};

/// Damping, stiffness and limit of the contact, level: the level makes the contact slip about the resonance.
const CASES: [(f64, f64, f64, f64); 8] = [
    (0.01, 0.1, 0.05, 0.01),
    (0.01, 0.5, 0.1, 0.005),
    (0.01, 2.0, 0.05, 0.02),
    (0.05, 2.0, 0.05, 0.02),
    (0.05, 2.0, 0.1, 0.05),
    (0.01, 8.0, 0.05, 0.002),
    (0.05, 8.0, 0.1, 0.02),
    (0.2, 8.0, 0.05, 0.02),
];

#[test]
fn a_curve_passes_the_corners_at_which_slip_begins_and_ends() {
    for (damping, stiffness, limit, level) in CASES {
        let structure = single(1.0, damping, 1.0, 1);
        let law = Jenkins::new(stiffness, limit).unwrap();
        let assembly = in_contact(&structure, law);
        let settings = settings(3);
        let control = Control::Level(level);
        let curve = frequency_response(&assembly, 0.6, 3.5, &control, &settings, &mut |_| true).unwrap();
        let last = curve.points.last().unwrap().angular_frequency;
        assert_eq!(curve.ending, Ending::Complete, "{damping} {stiffness} {limit} {level}: {last}");
        assert!(curve.points.iter().any(|point| point.dissipated_energy() > 0.0));
        // The corner lies where the spring carries the limit, below the peak.
        let peaks: Vec<f64> = curve.peaks.iter().map(|peak| peak.amplitude).collect();
        let highest = peaks.iter().copied().fold(0.0, f64::max);
        assert!(highest > limit / stiffness, "{peaks:?}");
        for start in [0.95, 1.3] {
            let tracking = Tracking { quantity: TrackedQuantity::Peak, node: 0, angular_frequency: start };
            let found = track_levels(&assembly, &tracking, &[level], &settings, &mut |_| true).unwrap();
            let amplitude = found.points[0].amplitude[0];
            let nearest = peaks.iter().map(|peak| (amplitude / peak - 1.0).abs()).fold(f64::MAX, f64::min);
            assert!(nearest < 1e-6, "{damping} {stiffness} {limit} {level}: {amplitude} not in {peaks:?}");
        }
    }
}
