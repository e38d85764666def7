//! Periodic motions of lumped oscillators by shooting on the exact flow.

mod oscillator_support;

use oscillator_support::two_mass;
use stickslip::contact::Jenkins;
use stickslip::integrate::{Excitation, LoadedContact, OscillatorFlow, PeriodicMotion, ShootingSettings, shoot};

fn study(omega: f64, amplitude: f64) -> PeriodicMotion {
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let mut flow = OscillatorFlow::new(&two_mass(), &[LoadedContact { law: &law, normal_load: 1.0 }]).unwrap();
    shoot(&mut flow, &Excitation::cosine(omega, amplitude), None, &ShootingSettings::default()).unwrap()
}

/// ω (rad/s), largest x and y (m), energy dissipated in the contact and work of the excitation (J), from an
/// independent event-driven solution.
const FIXED: [(f64, f64, f64, f64, Option<f64>); 5] = [
    (0.5, 0.9273567601, 1.7803402056, 0.1344272164, Some(0.76577446)),
    (0.541, 0.9778816042, 2.2276289719, 0.1702103178, None),
    (1.0, 0.3905353959, 0.4036689866, 0.0242935189, Some(0.12323090)),
    (1.3, 2.5342914047, 1.0651770248, 0.0772141620, Some(3.16311847)),
    (2.0, 0.1643969548, 0.0248630093, 0.0, Some(0.01736957)),
];

#[test]
fn the_two_masses_have_the_reference_responses() {
    for (omega, x, y, dissipated, work) in FIXED {
        let found = study(omega, 0.4);
        let passage = &found.passage;
        println!(
            "{omega}: x {:e} y {:e} D {:e} periods {} mismatch {:e} multipliers {:?}",
            passage.amplitude(0) - x,
            passage.amplitude(1) - y,
            passage.total_dissipated_energy() - dissipated,
            found.periods,
            found.mismatch,
            found.multipliers,
        );
        assert!((passage.amplitude(0) - x).abs() < 1.2e-10, "x at {omega}: {}", passage.amplitude(0));
        assert!((passage.amplitude(1) - y).abs() < 1.2e-10, "y at {omega}: {}", passage.amplitude(1));
        let lost = passage.total_dissipated_energy();
        assert!((lost - dissipated).abs() < 1.2e-10, "energy at {omega}: {lost}");
        if let Some(work) = work {
            assert!((passage.work - work).abs() < 1.2e-8, "work at {omega}: {}", passage.work);
        }
        let taken = lost + passage.viscous_energy;
        assert!((taken - passage.work).abs() < 1e-11 * passage.work, "{taken} {}", passage.work);
        assert!(found.stable);
    }
}
