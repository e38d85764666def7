//! The two-mass oscillator with a Jenkins element: published parameters, values of an event-driven exact
//! solution.

mod two_mass_support;

use stickslip::harmonic::{Control, CurveSettings, frequency_response, periodic_response};
use two_mass_support::{TwoMass, settings};

/// ω, x, y, dissipated, work.
const FIXED: [(f64, f64, f64, f64, Option<f64>); 5] = [
    (0.5, 0.9273567601, 1.7803402056, 0.1344272164, Some(0.76577446)),
    (0.541, 0.9778816042, 2.2276289719, 0.1702103178, None),
    (1.0, 0.3905353959, 0.4036689866, 0.0242935189, Some(0.12323090)),
    (1.3, 2.5342914047, 1.0651770248, 0.0772141620, Some(3.16311847)),
    (2.0, 0.1643969548, 0.0248630093, 0.0, Some(0.01736957)),
];

fn worst_of_fixed(settings: &CurveSettings) -> [f64; 4] {
    let model = TwoMass::default();
    let mut worst = [0.0_f64; 4];
    for (omega, x, y, dissipated, work) in FIXED {
        let assembly = model.assembly();
        let point = periodic_response(&assembly, omega, &Control::Level(0.4), settings, None).unwrap();
        let found = [point.amplitude[0], point.amplitude[1], point.dissipated_energy(), point.work];
        let exact = [x, y, dissipated, work.unwrap_or(point.work)];
        for k in 0..4 {
            let error = if exact[k] == 0.0 { found[k].abs() } else { (found[k] / exact[k] - 1.0).abs() };
            eprintln!("{omega} {k}: {} {error:.1e}", found[k]);
            worst[k] = worst[k].max(error);
        }
    }
    worst
}

#[test]
fn responses_equal_the_exact_solution_at_21_harmonics() {
    let worst = worst_of_fixed(&settings(21));
    eprintln!("{worst:?}");
    assert!(worst[0] < 1e-6 && worst[1] < 1e-6, "{worst:?}");
}

#[test]
fn curve_is_complete() {
    let model = TwoMass::default();
    let assembly = model.assembly();
    let curve =
        frequency_response(&assembly, 0.2, 2.0, &Control::Level(0.4), &settings(21), &mut |_| true).unwrap();
    eprintln!("{} {:?}", curve.points.len(), curve.ending);
    let its: usize = curve.points.iter().map(|p| p.iterations).sum();
    eprintln!("iterations {its}");
    for peak in &curve.peaks {
        eprintln!("{peak:?}");
    }
    for p in curve.points.iter().step_by(10) {
        eprintln!("{:.5} {:?} {:.1e} {}", p.angular_frequency, p.amplitude, p.error_estimate, p.iterations);
    }
}
