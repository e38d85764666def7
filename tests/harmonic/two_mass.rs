//! The two-mass oscillator with a Jenkins element: published parameters, values of an event-driven exact
//! solution (periodicity 2e-14).

use stickslip::contact::Jenkins;
use stickslip::harmonic::{
    Control, Curve, CurveSettings, Ending, Point, fourier, frequency_response, level_response,
    periodic_response,
};

use crate::common::oscillator::{in_contact, settings, two_masses};

const LEVEL: f64 = 0.4;

/// ω, x, y, dissipated, work.
const FIXED: [(f64, f64, f64, f64, Option<f64>); 5] = [
    (0.5, 0.9273567601, 1.7803402056, 0.1344272164, Some(0.76577446)),
    (0.541, 0.9778816042, 2.2276289719, 0.1702103178, None),
    (1.0, 0.3905353959, 0.4036689866, 0.0242935189, Some(0.12323090)),
    (1.3, 2.5342914047, 1.0651770248, 0.0772141620, Some(3.16311847)),
    (2.0, 0.1643969548, 0.0248630093, 0.0, Some(0.01736957)),
];

/// Node, ω, amplitude.
const PEAKS: [(usize, f64, f64); 4] = [
    (0, 0.527394, 1.008048920),
    (1, 0.540850, 2.227637379),
    (0, 1.305808, 2.550916521),
    (1, 1.300160, 1.065182030),
];

fn law() -> Jenkins {
    Jenkins::new(0.2, 0.02).unwrap()
}

fn response(omega: f64, level: f64, settings: &CurveSettings) -> Point {
    let (structure, law) = (two_masses(0.1), law());
    let assembly = in_contact(&structure, law);
    periodic_response(&assembly, omega, &Control::Level(level), settings, None).unwrap()
}

fn curve(settings: &CurveSettings) -> Curve {
    let (structure, law) = (two_masses(0.1), law());
    let assembly = in_contact(&structure, law);
    frequency_response(&assembly, 0.2, 2.0, &Control::Level(LEVEL), settings, &mut |_| true).unwrap()
}

/// Largest relative errors of x, y, dissipated energy and work.
fn errors(settings: &CurveSettings) -> [f64; 4] {
    let mut worst = [0.0_f64; 4];
    for (omega, x, y, dissipated, work) in FIXED {
        let point = response(omega, LEVEL, settings);
        let found = [point.amplitude[0], point.amplitude[1], point.dissipated_energy(), point.work];
        let exact = [x, y, dissipated, work.unwrap_or(point.work)];
        for k in 0..4 {
            let error = if exact[k] == 0.0 { found[k].abs() } else { (found[k] / exact[k] - 1.0).abs() };
            worst[k] = worst[k].max(error);
        }
    }
    worst
}

#[test]
fn responses_equal_the_exact_solution() {
    let [x, y, dissipated, work] = errors(&settings(21));
    assert!(x < 1e-6 && y < 1e-6 && dissipated < 1e-6 && work < 1e-6, "{x} {y} {dissipated} {work}");
    // The work is known to eight digits.
    let [x, y, dissipated, work] = errors(&settings(101));
    assert!(x < 1e-8 && y < 1e-8 && dissipated < 1e-8 && work < 5e-8, "{x} {y} {dissipated} {work}");
}

#[test]
fn even_harmonics_do_not_change_a_symmetric_response() {
    let all = CurveSettings { all_harmonics: true, ..settings(9) };
    for omega in [0.5, 1.0, 1.3] {
        let (odd, full) = (response(omega, LEVEL, &settings(9)), response(omega, LEVEL, &all));
        for (a, b) in odd.nodes.iter().flatten().zip(full.nodes.iter().flatten()) {
            assert!((a - b).abs() < 1e-9, "{omega}: {a} {b}");
        }
    }
}

#[test]
fn curve_has_the_peaks_of_the_exact_solution() {
    let curve = curve(&settings(21));
    assert_eq!(curve.ending, Ending::Complete);
    assert!(curve.folds.is_empty());
    assert_eq!(curve.points.first().map(|p| p.angular_frequency), Some(0.2));
    assert_eq!(curve.points.last().map(|p| p.angular_frequency), Some(2.0));
    for (node, omega, amplitude) in PEAKS {
        let near = |a: f64| (a - omega).abs();
        let peaks = curve.peaks.iter().filter(|peak| peak.node == node);
        let peak = peaks.min_by(|a, b| near(a.angular_frequency).total_cmp(&near(b.angular_frequency)));
        let peak = peak.unwrap();
        assert!(near(peak.angular_frequency) < 1e-5, "{peak:?}");
        assert!((peak.amplitude / amplitude - 1.0).abs() < 1e-6, "{peak:?}");
    }
}

/// Energy the dampers of both masses take per cycle (J).
fn viscous_energy(point: &Point) -> f64 {
    let mut sum = 0.0;
    for node in &point.nodes {
        for (k, pair) in node[1..].chunks_exact(2).enumerate() {
            sum += ((k + 1) * (k + 1)) as f64 * (pair[0] * pair[0] + pair[1] * pair[1]);
        }
    }
    std::f64::consts::PI * 0.1 * point.angular_frequency * sum
}

#[test]
fn work_equals_dissipated_and_viscous_energy() {
    for point in curve(&settings(7)).points {
        let lost = point.dissipated_energy() + viscous_energy(&point);
        assert!(
            (point.work - lost).abs() < 1e-8 * point.work,
            "{}: {}",
            point.angular_frequency,
            point.work - lost
        );
    }
}

#[test]
fn equivalent_stiffness_is_least_where_the_second_mass_moves_most() {
    let settings = settings(21);
    let stiffness = |omega: f64| response(omega, LEVEL, &settings).contacts[0].equivalent_stiffness;
    for (omega, value) in [(0.54085, 0.008978), (1.3002, 0.018776)] {
        assert!((stiffness(omega) / value - 1.0).abs() < 1e-4, "{omega}: {}", stiffness(omega));
        assert!(stiffness(omega - 0.01) > stiffness(omega) && stiffness(omega + 0.01) > stiffness(omega));
    }
    assert!((stiffness(1.010) / 0.04958 - 1.0).abs() < 1e-3);
    assert!(stiffness(0.98) < stiffness(1.010) && stiffness(1.04) < stiffness(1.010));
    // From tip to tip, limit over amplitude; in stick that of the spring.
    let point = response(0.5, LEVEL, &settings);
    assert!((point.contacts[0].equivalent_stiffness * point.amplitude[1] / 0.02 - 1.0).abs() < 1e-9);
    assert!((stiffness(2.0) / 0.2 - 1.0).abs() < 1e-9);
}

/// Amplitudes of the masses per unit force with the contact stuck.
fn stuck(omega: f64) -> [f64; 2] {
    let square = omega * omega;
    let (a, b, d) = ((1.5 - square, 0.1 * omega), -0.5, (0.7 - square, 0.1 * omega));
    let determinant = (a.0 * d.0 - a.1 * d.1 - b * b, a.0 * d.1 + a.1 * d.0);
    let size = determinant.0.hypot(determinant.1);
    [d.0.hypot(d.1) / size, b.abs() / size]
}

#[test]
fn a_stuck_contact_is_a_spring() {
    // It sticks as long as the second mass moves by less than the limit over the stiffness, 0.1 m.
    let edge = 1.62492169;
    assert!((LEVEL * stuck(edge)[1] - 0.1).abs() < 1e-8);
    for omega in [edge + 1e-5, 1.7, 1.9, 2.5] {
        let point = response(omega, LEVEL, &settings(7));
        let expected = stuck(omega).map(|amplitude| LEVEL * amplitude);
        (0..2).for_each(|k| assert!((point.amplitude[k] / expected[k] - 1.0).abs() < 1e-9, "{omega}"));
        assert_eq!(point.dissipated_energy(), 0.0);
        assert_eq!(point.contacts[0].stick_fraction, Some(1.0));
    }
    assert!(response(edge - 1e-4, LEVEL, &settings(7)).dissipated_energy() > 0.0);
    // Onset of slip under a growing force.
    let onset = 0.1 / stuck(0.677)[1];
    assert!((onset - 0.01739).abs() < 1e-5, "{onset}");
    assert_eq!(response(0.677, onset * 0.9999, &settings(7)).dissipated_energy(), 0.0);
    assert!(response(0.677, onset * 1.001, &settings(7)).dissipated_energy() > 0.0);
}

#[test]
fn a_level_is_followed_from_rest() {
    let (structure, law) = (two_masses(0.1), law());
    let assembly = in_contact(&structure, law);
    let curve = level_response(&assembly, 0.54, 0.0, LEVEL, &settings(7), &mut |_| true).unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    assert_eq!(curve.points[0].amplitude, [0.0, 0.0]);
    let (last, direct) = (curve.points.last().unwrap(), response(0.54, LEVEL, &settings(7)));
    assert!((last.amplitude[1] - direct.amplitude[1]).abs() < 1e-8);
    let dissipated: Vec<f64> = curve.points.iter().map(Point::dissipated_energy).collect();
    assert!(dissipated.windows(2).all(|pair| pair[1] >= pair[0]));
}

#[test]
fn a_held_response_has_its_amplitude_at_every_point() {
    let (structure, law) = (two_masses(0.1), law());
    let assembly = in_contact(&structure, law);
    let control = Control::Held { node: 0, order: 1, derivative: 2, amplitude: 0.1 };
    let curve = frequency_response(&assembly, 0.4, 1.5, &control, &settings(7), &mut |_| true).unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    for point in &curve.points {
        let acceleration = point.first_harmonic()[0] * point.angular_frequency.powi(2);
        assert!((acceleration / 0.1 - 1.0).abs() < 1e-9, "{acceleration}");
    }
    // The force found makes the same response when it is given.
    let point = &curve.points[curve.points.len() / 2];
    let again = response(point.angular_frequency, point.level, &settings(7));
    assert!((again.amplitude[1] / point.amplitude[1] - 1.0).abs() < 1e-7);
}

/// Largest deviation of any node over a period, as a fraction of its amplitude.
fn deviation(a: &Point, exact: &Point) -> f64 {
    let mut worst = 0.0_f64;
    for (node, (a, b)) in a.nodes.iter().zip(&exact.nodes).enumerate() {
        let difference: Vec<f64> =
            b.iter().enumerate().map(|(k, b)| b - a.get(k).copied().unwrap_or(0.0)).collect();
        let phases = (0..256).map(|k| std::f64::consts::TAU * k as f64 / 256.0);
        let largest = phases.fold(0.0_f64, |m, phase| m.max(fourier::value(&difference, phase).abs()));
        worst = worst.max(largest / exact.amplitude[node]);
    }
    worst
}

#[test]
fn truncation_estimate_follows_the_true_error() {
    let frequencies: Vec<f64> = (0..24).map(|k| 0.2 + 1.4 * k as f64 / 23.0).collect();
    let exact: Vec<Point> = frequencies.iter().map(|omega| response(*omega, LEVEL, &settings(101))).collect();
    for harmonics in [3, 7, 21] {
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for (omega, exact) in frequencies.iter().zip(&exact) {
            let point = response(*omega, LEVEL, &settings(harmonics));
            let ratio = point.error_estimate / deviation(&point, exact);
            (least, most) = (least.min(ratio), most.max(ratio));
        }
        println!("{harmonics} harmonics: estimate over error {least:.2} … {most:.2}");
        assert!(least > 0.9 && most < 2.5, "{harmonics}: {least} {most}");
    }
}

/// Friction so stiff that it is Coulomb's: its force jumps where the motion turns, and what is beyond twice the harmonics
/// counts as much as what is below.
#[test]
fn the_truncation_estimate_is_not_low_where_the_force_jumps() {
    let (structure, law) = (two_masses(0.1), Jenkins::new(1e6, 0.02).unwrap());
    let assembly = in_contact(&structure, law);
    for omega in [0.65, 0.8, 1.3] {
        let response = |harmonics: usize| {
            let settings = settings(harmonics);
            periodic_response(&assembly, omega, &Control::Level(LEVEL), &settings, None).unwrap()
        };
        let (point, exact) = (response(21), response(101));
        let ratio = point.error_estimate / deviation(&point, &exact);
        assert!((0.9..2.0).contains(&ratio), "{omega}: {ratio}");
    }
}

#[test]
fn harmonics_adapt_to_the_error_asked_for() {
    let adaptive = CurveSettings { truncation: Some(1e-5), max_harmonics: 61, ..settings(3) };
    let curve = curve(&adaptive);
    assert_eq!(curve.ending, Ending::Complete);
    assert!(curve.points.iter().all(|point| point.resolved && point.error_estimate <= 1e-5));
    let least = curve.points.iter().map(|point| point.harmonics).min();
    let most = curve.points.iter().map(|point| point.harmonics).max();
    assert!(least <= Some(7) && most > Some(13), "{least:?} {most:?}");
    // With too few to reach it, the point says so.
    let few = CurveSettings { truncation: Some(1e-5), max_harmonics: 5, ..settings(3) };
    let point = response(0.3, LEVEL, &few);
    assert!(!point.resolved && point.harmonics == 5 && point.error_estimate > 1e-5);
}

#[test]
fn watching_can_end_a_curve() {
    let (structure, law) = (two_masses(0.1), law());
    let assembly = in_contact(&structure, law);
    let mut seen = 0;
    let mut watch = |_: &Point| {
        seen += 1;
        seen < 5
    };
    let control = Control::Level(LEVEL);
    let curve = frequency_response(&assembly, 0.2, 2.0, &control, &settings(3), &mut watch).unwrap();
    assert_eq!((curve.ending, curve.points.len()), (Ending::Interrupted, 5));
}

#[test]
fn arguments_that_do_not_fit_are_refused() {
    let (structure, law) = (two_masses(0.1), law());
    let assembly = in_contact(&structure, law);
    let held = |node, order, amplitude| Control::Held { node, order, derivative: 0, amplitude };
    for control in [Control::Level(f64::NAN), held(2, 1, 1.0), held(0, 0, 1.0), held(0, 1, 0.0)] {
        assert!(periodic_response(&assembly, 0.5, &control, &settings(3), None).is_err(), "{control:?}");
    }
    let level = Control::Level(1.0);
    assert!(periodic_response(&assembly, -0.5, &level, &settings(3), None).is_err());
    assert!(periodic_response(&assembly, 0.5, &level, &settings(0), None).is_err());
    assert!(frequency_response(&assembly, 0.5, 0.5, &level, &settings(3), &mut |_| true).is_err());
    let mut nowhere = assembly.clone();
    nowhere.system.ports.pop();
    assert!(periodic_response(&nowhere, 0.5, &level, &settings(3), None).is_err());
}
