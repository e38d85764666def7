//! Response curves of lightly damped structures arrive, with every resonance on them; the beam's truncation
//! estimate follows its true error.

mod harmonic_support;

use stickslip::contact::{Jenkins, Valanis};
use stickslip::harmonic::{
    Assembly, AttachedContact, Body, Control, CurveSettings, Ending, frequency_response, periodic_response,
};
use stickslip::structure::{LinearStructure, Output};

fn settings(harmonics: usize) -> CurveSettings {
    CurveSettings { harmonics, ..CurveSettings::default() }
}

/// Masses of 1 kg in a chain from the ground, springs of `stiffness` (N/m), dampers proportional to them.
fn chain(masses: usize, stiffness: f64, damping: f64) -> LinearStructure {
    let band = |value: f64| {
        let mut entries = Vec::new();
        for i in 0..masses {
            for j in i.saturating_sub(1)..(i + 2).min(masses) {
                let held = if i + 1 < masses { 2.0 } else { 1.0 };
                entries.push((i, j, if i == j { held * value } else { -value }));
            }
        }
        entries
    };
    LinearStructure {
        size: masses,
        mass: (0..masses).map(|i| (i, i, 1.0)).collect(),
        damping: band(damping),
        stiffness: band(stiffness),
        contacts: Vec::new(),
        excitation: vec![(0, 1.0)],
        outputs: vec![Output { name: "end".into(), row: vec![(masses - 1, 1.0)] }],
    }
}

#[test]
fn the_resonance_of_one_mass_is_met_however_sharp() {
    for damping in [1e-6, 1e-4, 0.01, 0.03, 0.1, 1.0] {
        let structure = chain(1, 100.0, damping);
        let assembly = Assembly::new(Body::Linear(&structure), Vec::new());
        let control = Control::Level(1.0);
        let curve = frequency_response(&assembly, 1.0, 40.0, &control, &settings(1), &mut |_| true).unwrap();
        assert_eq!(curve.ending, Ending::Complete, "{damping}");
        let [peak] = curve.peaks[..] else { panic!("{damping}: {:?}", curve.peaks) };
        let ratio = damping / 20.0;
        let omega = 10.0 * (1.0 - 2.0 * ratio * ratio).sqrt();
        assert!((peak.angular_frequency / omega - 1.0).abs() < 1e-9, "{damping}");
        let amplitude = 1.0 / (200.0 * ratio * (1.0 - ratio * ratio).sqrt());
        assert!((peak.amplitude / amplitude - 1.0).abs() < 1e-9, "{damping}");
    }
}

#[test]
fn chains_show_as_many_resonances_as_masses() {
    for masses in [2, 3, 5, 8] {
        for damping in [1e-3, 0.02, 0.1] {
            let structure = chain(masses, 100.0, damping);
            let assembly = Assembly::new(Body::Linear(&structure), Vec::new());
            let control = Control::Level(1.0);
            let curve =
                frequency_response(&assembly, 0.5, 21.0, &control, &settings(3), &mut |_| true).unwrap();
            assert_eq!(curve.ending, Ending::Complete, "{masses} {damping}");
            assert_eq!(curve.peaks.len(), masses, "{masses} {damping}: {:?}", curve.peaks);
        }
    }
}

#[test]
fn a_jenkins_contact_does_not_end_a_lightly_damped_curve() {
    let law = Jenkins::new(50.0, 0.1).unwrap();
    for (masses, damping) in [(1, 0.01), (2, 0.03), (3, 0.02), (5, 0.05)] {
        for level in [0.01, 0.1, 1.0] {
            let mut structure = chain(masses, 100.0, damping);
            structure.contacts = vec![vec![(masses - 1, 1.0)]];
            let contacts = vec![AttachedContact { law: &law, normal_load: 1.0 }];
            let assembly = Assembly::new(Body::Linear(&structure), contacts);
            let control = Control::Level(level);
            let curve =
                frequency_response(&assembly, 2.0, 25.0, &control, &settings(5), &mut |_| true).unwrap();
            println!(
                "{masses} {damping} {level} {:?} {} at {} {:?} {}",
                curve.ending,
                curve.points.len(),
                curve.points.last().unwrap().angular_frequency,
                curve.points.last().unwrap().amplitude,
                curve.points.last().unwrap().contacts[0].stick_fraction.unwrap()
            );
        }
    }
}

#[test]
fn the_estimate_of_the_beam_follows_its_true_error() {
    let beam = harmonic_support::published_beam(4, 60);
    let law = Valanis::from_lambda(7.9e6, 0.0, 0.3, 8.7e4, 147.15).unwrap();
    let contacts = || vec![AttachedContact { law: &law, normal_load: 147.15 }];
    for omega in [330.0, 339.0, 350.0] {
        let response = |harmonics: usize| {
            let assembly = Assembly::new(Body::Beam(&beam), contacts());
            periodic_response(&assembly, omega, &Control::Level(10.0), &settings(harmonics), None).unwrap()
        };
        let exact = response(31);
        for harmonics in [1, 3, 5, 9] {
            let point = response(harmonics);
            let mut worst = 0.0_f64;
            for (node, (found, amplitude)) in point.nodes.iter().zip(&exact.amplitude).enumerate() {
                let place = |k: usize| found.get(k).copied().unwrap_or(0.0);
                let coefficients = exact.nodes[node].iter().enumerate();
                let differences: Vec<f64> = coefficients.map(|(k, x)| x - place(k)).collect();
                let sum = differences[0].abs()
                    + differences[1..].chunks_exact(2).map(|d| d[0].hypot(d[1])).sum::<f64>();
                worst = worst.max(sum / amplitude);
            }
            let ratio = point.error_estimate / worst;
            // One harmonic says little about the next ones.
            let bounds = if harmonics == 1 { 0.1..10.0 } else { 0.5..2.5 };
            assert!(bounds.contains(&ratio), "{omega} {harmonics}: {worst:e} {ratio}");
        }
    }
}
