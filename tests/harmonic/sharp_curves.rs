//! Response curves of lightly damped structures arrive, with every resonance on them; the beam's truncation
//! estimate follows its true error.

use stickslip::contact::Jenkins;
use stickslip::harmonic::{Assembly, Control, Ending, frequency_response, periodic_response};
use stickslip::system::{LinearStructure, Output};

use crate::common::contact::{self, LOAD, loaded};
use crate::common::oscillator::{in_contact, settings};

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
        let assembly = Assembly::new(structure.system(Vec::new()));
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
            let assembly = Assembly::new(structure.system(Vec::new()));
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
            let assembly = in_contact(&structure, law);
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
    let beam = crate::common::finite_elements::published_beam(4, 60);
    let assembly = Assembly::new(beam.system(loaded(contact::published(), LOAD)).unwrap());
    for omega in [330.0, 339.0, 350.0] {
        let response = |harmonics: usize| {
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

/// Every mass of a chain is observed.
fn watched(structure: LinearStructure) -> LinearStructure {
    let outputs = (0..structure.size).map(|k| Output { name: format!("m{k}"), row: vec![(k, 1.0)] });
    LinearStructure { outputs: outputs.collect(), ..structure }
}

#[test]
fn a_curve_has_points_on_every_resonance_however_sharp() {
    for (masses, damping) in [(1, 1e-4), (2, 1e-3), (10, 0.01)] {
        let structure = watched(chain(masses, 4.0, damping));
        let assembly = Assembly::new(structure.system(Vec::new()));
        let control = Control::Level(1.0);
        let curve = frequency_response(&assembly, 0.01, 5.0, &control, &settings(1), &mut |_| true).unwrap();
        assert_eq!(curve.ending, Ending::Complete);
        assert!(curve.points.is_sorted_by(|a, b| a.angular_frequency < b.angular_frequency));
        let shapes = structure.natural_modes().unwrap();
        for (mode, frequency) in shapes.angular_frequency.iter().enumerate() {
            let ratio = 0.5 * frequency * damping / 4.0;
            let near = |point: &&stickslip::harmonic::Point| {
                (point.angular_frequency / frequency - 1.0).abs() < 2.0 * ratio
            };
            assert!(curve.points.iter().filter(near).count() >= 8, "{masses}, mode {mode}");
        }
        // The first mode shows at every mass as a peak of the table and as a point of the curve.
        let (frequency, shape) = (shapes.angular_frequency[0], shapes.shapes.column(0));
        for node in 0..masses {
            let close = |at: f64| (at / frequency - 1.0).abs() < 1e-4;
            let peak = curve.peaks.iter().find(|peak| peak.node == node && close(peak.angular_frequency));
            let peak = peak.unwrap_or_else(|| panic!("{masses}: no peak of mass {node}"));
            let exact = (shape[0] * shape[node]).abs() / (frequency.powi(3) * damping / 4.0);
            assert!(
                (peak.amplitude / exact - 1.0).abs() < 1e-3,
                "{masses} {node}: {} {exact}",
                peak.amplitude
            );
            let most = curve.points.iter().filter(|point| close(point.angular_frequency));
            let most = most.fold(0.0, |most: f64, point| most.max(point.amplitude[node]));
            assert!((most / peak.amplitude - 1.0).abs() < 1e-5, "{masses} {node}: {most}");
        }
    }
}

#[test]
fn a_linear_response_held_takes_the_force_of_its_receptance() {
    for (masses, damping) in [(1, 1e-4), (2, 1e-3)] {
        let structure = watched(chain(masses, 1.0, damping));
        let assembly = Assembly::new(structure.system(Vec::new()));
        let held = Control::Held { node: 0, order: 1, derivative: 0, amplitude: 1.0 };
        let curve = frequency_response(&assembly, 0.05, 5.0, &held, &settings(1), &mut |_| true).unwrap();
        assert_eq!(curve.ending, Ending::Complete, "{masses}");
        assert!(curve.folds.is_empty());
        for point in &curve.points {
            let at = point.angular_frequency;
            let unit = periodic_response(&assembly, at, &Control::Level(1.0), &settings(1), None).unwrap();
            let force = 1.0 / unit.first_harmonic()[0];
            assert!((point.level / force - 1.0).abs() < 1e-6, "{at}: {} {force}", point.level);
        }
        let least = curve.points.iter().fold(f64::INFINITY, |least, point| least.min(point.level));
        if masses == 1 {
            assert!((0.99e-4..1.05e-4).contains(&least), "{least}");
        }
    }
}

#[test]
fn the_peak_that_meets_a_point_of_the_curve_is_listed() {
    let mut structure = watched(chain(10, 4.0, 0.01));
    structure.contacts = vec![vec![(5, 1.0)]];
    let law = Jenkins::new(2.0, 0.1).unwrap();
    let assembly = in_contact(&structure, law);
    let control = Control::Level(1e-4);
    let curve = frequency_response(&assembly, 0.8, 1.05, &control, &settings(21), &mut |_| true).unwrap();
    // All stick: a linear structure, whose masses pass one resonance here.
    for node in 0..10 {
        let most = curve.points.iter().map(|point| point.amplitude[node]).fold(0.0, f64::max);
        let peak = curve.peaks.iter().find(|peak| peak.node == node);
        let amplitude = peak.map_or_else(|| panic!("no peak of mass {node}"), |peak| peak.amplitude);
        assert!((amplitude / most - 1.0).abs() < 1e-4, "{node}: {amplitude} {most}");
    }
}
