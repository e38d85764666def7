//! Resonances tracked over level and contact parameters, against closed forms, scaling laws and the exact
//! event-driven solution of the two-mass system with friction.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, CubicSpring, Jenkins, Unilateral};
use stickslip::harmonic::{
    Assembly, AssemblyAt, Control, Curve, CurveSettings, Ending, HarmonicError, Point, TrackedQuantity,
    Tracking, parameter_response, periodic_response, track_levels, track_parameter,
};

use crate::common::oscillator::{in_contact, settings, single, two_masses, under_load};

/// All points of a curve that comes to its end.
fn whole(curve: Result<Curve, HarmonicError>) -> Vec<Point> {
    let curve = curve.unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    curve.points
}

fn over_levels(
    assembly: &Assembly,
    tracking: &Tracking,
    levels: &[f64],
    settings: &CurveSettings,
) -> Result<Curve, HarmonicError> {
    track_levels(assembly, tracking, levels, settings, &mut |_| true)
}

fn over_values(at: &AssemblyAt, tracking: &Tracking, values: &[f64], harmonics: usize) -> Vec<Point> {
    whole(track_parameter(at, 0.4, tracking, values, &settings(harmonics), &mut |_| true))
}

/// The node's largest displacement over a period by the level.
fn receptance(point: &Point, node: usize) -> f64 {
    point.amplitude[node] / point.level
}

const fn tracking(quantity: TrackedQuantity, node: usize, angular_frequency: f64) -> Tracking {
    Tracking { quantity, node, angular_frequency }
}

/// Values evenly spaced by ratio.
fn spaced(first: f64, last: f64, count: usize) -> Vec<f64> {
    (0..count).map(|k| first * (last / first).powf(k as f64 / (count - 1) as f64)).collect()
}

#[test]
fn a_linear_oscillator_peaks_below_and_is_in_phase_resonance_at_its_natural_frequency() {
    let (stiffness, damping, contact) = (1.0, 0.3, 0.44);
    let structure = single(1.0, damping, stiffness, 1);
    let law = CubicSpring::new(contact, 0.0).unwrap();
    let assembly = in_contact(&structure, law);
    let levels = [0.01, 1.0, 50.0];
    let square: f64 = stiffness + contact;
    let follow = |quantity| whole(over_levels(&assembly, &tracking(quantity, 0, 0.8), &levels, &settings(3)));
    for (phase, level) in follow(TrackedQuantity::Phase).iter().zip(levels) {
        assert!((phase.angular_frequency / square.sqrt() - 1.0).abs() < 1e-9);
        assert!((receptance(phase, 0) * damping * square.sqrt() - 1.0).abs() < 1e-9);
        assert!((phase.level - level).abs() < 1e-12 * level);
    }
    for peak in follow(TrackedQuantity::Peak) {
        let at = (square - 0.5 * damping * damping).sqrt();
        assert!((peak.angular_frequency / at - 1.0).abs() < 1e-7, "{}", peak.angular_frequency);
        let height = 1.0 / (damping * (square - 0.25 * damping * damping).sqrt());
        assert!((receptance(&peak, 0) / height - 1.0).abs() < 1e-9);
    }
}

#[test]
fn two_mass_peaks_are_those_of_the_exact_solution() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    // Node, start, ω, x, y, D of the event-driven exact solution at A = 0.4.
    let peaks = [
        (0, 0.50, 0.527394, 1.008048920, 2.162370912, 0.1649896730),
        (1, 0.56, 0.540850, 0.978549958, 2.227637379, 0.1702109903),
        (0, 1.25, 1.305808, 2.550916521, 1.058804403, 0.0767043522),
        (1, 1.33, 1.300160, 2.535184036, 1.065182030, 0.0772145624),
    ];
    for (node, start, omega, x, y, dissipated) in peaks {
        let tracking = tracking(TrackedQuantity::Peak, node, start);
        let point = whole(over_levels(&assembly, &tracking, &[0.4], &settings(41))).remove(0);
        assert!((point.angular_frequency - omega).abs() < 2e-6, "{} {omega}", point.angular_frequency);
        assert!((point.amplitude[node] / [x, y][node] - 1.0).abs() < 1e-6);
        for (value, exact) in
            [(point.amplitude[0], x), (point.amplitude[1], y), (point.dissipated_energy(), dissipated)]
        {
            assert!((value / exact - 1.0).abs() < 3e-6, "{value} {exact}");
        }
    }
}

#[test]
fn receptance_at_the_peak_is_least_at_a_medium_level() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let least = |node| {
        let levels = spaced(0.01, 2.0, 60);
        let tracking = tracking(TrackedQuantity::Peak, node, 0.67);
        let peaks = whole(over_levels(&assembly, &tracking, &levels, &settings(9)));
        // Stuck, nothing depends on the level.
        let receptance: Vec<f64> = peaks.iter().map(|peak| receptance(peak, node)).collect();
        assert!((receptance[1] / receptance[0] - 1.0).abs() < 1e-9);
        let least = (0..60).min_by(|a, b| receptance[*a].total_cmp(&receptance[*b])).unwrap();
        assert!(receptance[least] < 0.8 * receptance[59], "{receptance:?}");
        levels[least]
    };
    let (x, y) = (least(0), least(1));
    assert!((0.070..0.085).contains(&x), "{x}");
    assert!((0.058..0.068).contains(&y), "{y}");
}

#[test]
fn dissipation_at_a_fixed_frequency_is_largest_at_a_medium_friction() {
    let structure = two_masses(0.1);
    for (friction, lost) in [(0.05, 0.2910), (0.06, 0.2994), (0.07, 0.2939)] {
        let assembly = in_contact(&structure, Jenkins::new(0.2, friction).unwrap());
        let point = periodic_response(&assembly, 0.54, &Control::Level(0.4), &settings(21), None).unwrap();
        assert!((point.dissipated_energy() - lost).abs() < 5.1e-5, "{friction}");
    }
}

#[test]
fn load_and_level_together_only_scale_the_response() {
    // Lengths enter through the limit alone: N and A times c is the same response times c.
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let loads = [1.0, 0.5, 0.25, 2.0, 8.0];
    for quantity in [TrackedQuantity::Peak, TrackedQuantity::Phase] {
        let node = if quantity == TrackedQuantity::Peak { 0 } else { 1 };
        let tracking = tracking(quantity, node, 0.53);
        let over = |load: f64| Ok(under_load(&structure, Arc::new(Jenkins::new(0.2, 0.02)?), load));
        let by_load = over_values(&over, &tracking, &loads, 9);
        let levels: Vec<f64> = loads.iter().map(|load| 0.4 / load).collect();
        let by_level = whole(over_levels(&assembly, &tracking, &levels, &settings(9)));
        for (a, b) in by_load.iter().zip(&by_level) {
            let (left, right) = (a.angular_frequency, b.angular_frequency);
            assert!((left / right - 1.0).abs() < 1e-6, "{quantity:?} {}: {left} {right}", a.parameter);
            let (left, right) = (receptance(a, node), receptance(b, node));
            assert!((left / right - 1.0).abs() < 1e-8, "{left} {right}");
        }
    }
}

#[test]
fn duffing_peaks_are_followed_past_the_fold() {
    // One harmonic: `(¾ k₃ a² + k − ω²)² a² + (c ω a)² = A²`; at the peak `k + ¾ k₃ a² − ω² = c²/2`.
    let (damping, cubic) = (0.05, 1.0);
    let structure = single(1.0, damping, 1.0, 1);
    let law = CubicSpring::new(0.0, cubic).unwrap();
    let levels = spaced(1e-3, 0.3, 9);
    let peak = tracking(TrackedQuantity::Peak, 0, 0.98);
    for peak in whole(over_levels(&in_contact(&structure, law), &peak, &levels, &settings(1))) {
        let (a, omega) = (peak.amplitude[0], peak.angular_frequency);
        let bent = 1.0 + 0.75 * cubic * a * a;
        assert!((omega * omega / (bent - 0.5 * damping * damping) - 1.0).abs() < 1e-6, "{omega} {a}");
        let force = a * (0.25 * damping.powi(4) + (damping * omega).powi(2)).sqrt();
        assert!((force / peak.level - 1.0).abs() < 1e-8, "{force} {}", peak.level);
    }
}

#[test]
fn parameter_sweeps_pass_turning_points_of_a_duffing_oscillator() {
    // One harmonic at a fixed frequency and level: every amplitude below the largest belongs to two cubic
    // stiffnesses, `¾ k₃ a² = ω² − k ± √(A²/a² − c² ω²)`.
    let (damping, omega, level): (f64, f64, f64) = (0.05, 1.3, 0.2);
    let structure = single(1.0, damping, 1.0, 1);
    let over = |cubic: f64| Ok(under_load(&structure, Arc::new(CubicSpring::new(0.0, cubic)?), 1.0));
    let curve = parameter_response(&over, omega, level, [0.01, 2.0], &settings(1), &mut |_| true).unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    let mut turned = 0;
    for pair in curve.points.windows(2) {
        let (a, cubic) = (pair[1].amplitude[0], pair[1].parameter);
        let stiff = 1.0 + 0.75 * cubic * a * a - omega * omega;
        let force = a * (stiff * stiff + (damping * omega).powi(2)).sqrt();
        assert!((force / level - 1.0).abs() < 1e-8, "{cubic} {a}: {force}");
        turned += usize::from(pair[1].parameter < pair[0].parameter);
    }
    let most = curve.points.iter().map(|varied| varied.amplitude[0]).fold(0.0, f64::max);
    assert!(turned > 2, "the curve turns back between its two turning points");
    // The parameter stands still there while the amplitude goes on.
    assert_eq!(curve.folds.len(), 2);
    for fold in &curve.folds {
        let (square, cubic) = (fold.amplitude[0].powi(2), fold.parameter);
        let stiff = 1.0 + 0.75 * cubic * square - omega * omega;
        let turning = stiff * stiff + (damping * omega).powi(2) + 1.5 * cubic * square * stiff;
        assert!(turning.abs() < 1e-6 * (damping * omega).powi(2), "{fold:?}: {turning}");
    }
    assert!(most <= level / (damping * omega) * (1.0 + 1e-9) && most > 0.9 * level / (damping * omega));
}

#[test]
fn a_parameter_sweep_and_single_values_agree() {
    let structure = two_masses(0.1);
    let over = |friction: f64| Ok(under_load(&structure, Arc::new(Jenkins::new(0.2, friction)?), 1.0));
    let curve = parameter_response(&over, 0.54, 0.4, [0.02, 0.12], &settings(9), &mut |_| true).unwrap();
    let last = curve.points.last().map(|varied| (varied.parameter, varied.dissipated_energy()));
    assert_eq!(curve.ending, Ending::Complete, "{last:?}");
    let picked: Vec<&Point> = curve.points.iter().step_by(7).collect();
    for swept in &picked {
        let assembly = over(swept.parameter).unwrap();
        let alone = periodic_response(&assembly, 0.54, &Control::Level(0.4), &settings(9), None).unwrap();
        assert!((swept.amplitude[1] / alone.amplitude[1] - 1.0).abs() < 1e-8, "{}", swept.parameter);
        assert!((swept.dissipated_energy() - alone.dissipated_energy()).abs() < 1e-9);
    }
    assert!(picked.len() > 5);
}

#[test]
fn harmonics_grow_until_a_tracked_peak_is_resolved() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let adaptive = CurveSettings {
        harmonics: 3,
        truncation: Some(1e-5),
        max_harmonics: 101,
        ..CurveSettings::default()
    };
    let tracking = tracking(TrackedQuantity::Peak, 0, 0.5);
    let peaks = whole(over_levels(&assembly, &tracking, &[0.4, 0.3], &adaptive));
    assert!(peaks.iter().all(|peak| peak.resolved && peak.error_estimate <= 1e-5));
    assert!((peaks[0].amplitude[0] / 1.008048920 - 1.0).abs() < 1e-5, "{}", peaks[0].amplitude[0]);
    assert!(peaks[0].harmonics > 5);
}

#[test]
fn a_resonance_that_ends_ends_its_curve() {
    // Friction damps the first mass so much that its phase stops passing a quarter period near the first mode.
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let levels = spaced(0.8, 0.02, 20);
    let tracking = tracking(TrackedQuantity::Phase, 0, 0.55);
    let curve = over_levels(&in_contact(&structure, law), &tracking, &levels, &settings(9)).unwrap();
    assert!(curve.ending == Ending::Stuck && curve.points.len() > 5 && curve.points.len() < 20);
    for pair in curve.points.windows(2) {
        let change = pair[1].angular_frequency / pair[0].angular_frequency - 1.0;
        assert!(change.abs() < 0.15, "{change}");
    }
}

#[test]
fn what_cannot_be_followed_is_refused() {
    let structure = two_masses(0.1);
    let law = Jenkins::new(0.2, 0.02).unwrap();
    let assembly = in_contact(&structure, law);
    let follow = |tracking: Tracking, levels: &[f64]| over_levels(&assembly, &tracking, levels, &settings(5));
    let refused = [
        follow(tracking(TrackedQuantity::Peak, 2, 0.5), &[0.4]),
        follow(tracking(TrackedQuantity::Peak, 0, 0.0), &[0.4]),
        follow(tracking(TrackedQuantity::Peak, 0, f64::NAN), &[0.4]),
        follow(tracking(TrackedQuantity::Peak, 0, 0.5), &[0.0]),
        follow(tracking(TrackedQuantity::Peak, 0, 0.5), &[]),
    ];
    for result in refused {
        assert!(matches!(result, Err(HarmonicError::InvalidInput(_))), "{result:?}");
    }
    let over = |friction: f64| Ok(under_load(&structure, Arc::new(Jenkins::new(0.2, friction)?), 1.0));
    let peak = tracking(TrackedQuantity::Peak, 0, 0.5);
    let result = track_parameter(&over, 0.4, &peak, &[0.02, -1.0], &settings(5), &mut |_| true);
    assert!(matches!(result, Err(HarmonicError::Law(_))), "{result:?}");
}

#[test]
fn a_tracked_resonance_can_be_interrupted() {
    let structure = two_masses(0.1);
    let assembly = in_contact(&structure, Jenkins::new(0.2, 0.02).unwrap());
    let peak = tracking(TrackedQuantity::Peak, 0, 0.5);
    let mut left = 2;
    let mut watch = |_: &Point| {
        left -= 1;
        left > 0
    };
    let curve = track_levels(&assembly, &peak, &[0.4, 0.41, 0.42], &settings(5), &mut watch).unwrap();
    assert_eq!((curve.ending, curve.points.len()), (Ending::Interrupted, 2));
}

#[test]
fn a_parameter_sweep_passes_the_corner_where_the_contact_sticks_for_good() {
    let structure = two_masses(0.1);
    let over = |friction: f64| Ok(under_load(&structure, Arc::new(Jenkins::new(0.2, friction)?), 1.0));
    for (harmonics, most) in [(1, 0.5), (3, 1.0), (9, 0.3), (9, 2.0), (21, 0.5)] {
        let ends = [0.02, most];
        let curve = parameter_response(&over, 0.54, 0.4, ends, &settings(harmonics), &mut |_| true).unwrap();
        let last = curve.points.last().unwrap();
        assert_eq!(curve.ending, Ending::Complete, "{harmonics} {most}: ends at {}", last.parameter);
        // Stuck for good, the contact is a spring; the limit it then needs is where it began to stick.
        let stuck = last.amplitude[1];
        let away = |varied: &&Point| (varied.parameter / (0.2 * stuck) - 1.0).abs() > 1e-7;
        for varied in curve.points.iter().filter(away) {
            let slips = varied.parameter < 0.2 * stuck;
            assert_eq!(varied.dissipated_energy() > 0.0, slips, "{} {stuck}", varied.parameter);
        }
    }
}

#[test]
fn a_contact_that_loses_its_symmetry_on_the_way_is_refused() {
    let structure = single(1.0, 0.1, 1.0, 1);
    let over = |stiffness: f64| {
        let law: Arc<dyn ContactLaw> = if stiffness < 0.5 {
            Arc::new(CubicSpring::new(stiffness, 0.0)?)
        } else {
            Arc::new(Unilateral::new(stiffness, 0.0)?)
        };
        Ok(under_load(&structure, law, 1.0))
    };
    let curve = parameter_response(&over, 0.8, 0.4, [0.1, 1.0], &settings(5), &mut |_| true);
    assert!(matches!(curve, Err(HarmonicError::InvalidInput(_))), "{curve:?}");
}
