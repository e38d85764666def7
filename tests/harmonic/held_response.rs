//! Frequency responses of the published beam at held acceleration of its exciter, against the reference
//! values of independent programs; and how they converge with the modes.

use std::f64::consts::TAU;

use stickslip::harmonic::{
    Assembly, Control, CurveSettings, Ending, Method, backbone, frequency_response, phase_resonance,
};
use stickslip::model::{Beam, Damping, Model, Structure};
use stickslip::system::ModalBeam;

use crate::common::contact::{self, LOAD, loaded};

fn published(modes: usize, static_correction: bool) -> ModalBeam {
    let model = Model::parse(include_str!("../../examples/frictional-support/published.toml")).unwrap();
    let Structure::Beam(beam) = model.structure else { panic!("the example is a beam") };
    let damping = Damping::Uniform(0.003);
    ModalBeam::new(&Beam { modes, static_correction, damping, ..beam }).unwrap()
}

/// A held response: where the force is in quadrature with the displacement (Hz), acceleration per force there,
/// and the largest acceleration per force along the curve (1/kg).
fn held_response(beam: &ModalBeam, acceleration: f64, harmonics: usize, around: f64) -> (f64, f64, f64) {
    let law = contact::published();
    let assembly = Assembly::new(beam.system(loaded(law, LOAD)).unwrap());
    let node = beam.sensors.len();
    let control = Control::Held { node, order: 1, derivative: 2, amplitude: acceleration };
    let settings = CurveSettings { harmonics, max_step: 0.1, ..CurveSettings::default() };
    let (from, to) = (TAU * (around - 0.15), TAU * (around + 0.15));
    let curve = frequency_response(&assembly, from, to, &control, &settings, &mut |_| true).unwrap();
    assert_eq!(curve.ending, Ending::Complete);
    for point in &curve.points {
        let held = point.first_harmonic()[node] * point.angular_frequency.powi(2);
        assert!((held / acceleration - 1.0).abs() < 1e-8, "{held} m/s² at {}", point.angular_frequency);
    }
    let in_phase = |k: usize| curve.points[k].nodes[node][1] / curve.points[k].first_harmonic()[node];
    let crossing = (1..curve.points.len()).find(|k| in_phase(k - 1) > 0.0 && in_phase(*k) <= 0.0).unwrap();
    let (before, after) = (&curve.points[crossing - 1], &curve.points[crossing]);
    let fraction = in_phase(crossing - 1) / (in_phase(crossing - 1) - in_phase(crossing));
    let between = |a: f64, b: f64| a + fraction * (b - a);
    let frequency = between(before.angular_frequency, after.angular_frequency) / TAU;
    let least = curve.points.iter().map(|point| point.level).fold(f64::INFINITY, f64::min);
    (frequency, acceleration / between(before.level, after.level), acceleration / least)
}

/// Acceleration held (m/s²), frequency (Hz), peak of acceleration over force (1/kg) of another program's harmonic balance,
/// whose contact is integrated by Runge–Kutta.
const FOUR_MODES_FIVE_HARMONICS: [(f64, f64, f64); 8] = [
    (0.5, 54.04412, 24.84903),
    (10.0, 53.28555, 4.06899),
    (20.0, 51.63627, 2.87647),
    (30.0, 50.60267, 3.13879),
    (40.0, 50.07023, 3.62118),
    (50.0, 49.75739, 4.13795),
    (60.0, 49.55415, 4.65492),
    (70.0, 49.41326, 5.16371),
];
const SIX_MODES_NINE_HARMONICS: [(f64, f64, f64); 8] = [
    (0.5, 53.95325, 24.49039),
    (10.0, 53.23153, 4.13327),
    (20.0, 51.62029, 2.89262),
    (30.0, 50.59552, 3.14603),
    (40.0, 50.06640, 3.62738),
    (50.0, 49.75714, 4.14649),
    (60.0, 49.55560, 4.66400),
    (70.0, 49.41478, 5.17085),
];

#[test]
fn phase_resonance_at_held_acceleration_has_the_reference_frequencies_and_peaks() {
    let law = contact::published();
    let contact = loaded(law, LOAD);
    for (modes, harmonics, reference) in [(4, 5, FOUR_MODES_FIVE_HARMONICS), (6, 9, SIX_MODES_NINE_HARMONICS)]
    {
        let beam = published(modes, false);
        let settings = CurveSettings { harmonics, ..CurveSettings::default() };
        let found = backbone(&beam.system(contact.clone()).unwrap(), &reference.map(|r| r.0), &settings, &[])
            .unwrap();
        for ((level, frequency, ratio), found) in reference.into_iter().zip(found) {
            let hertz = found.angular_frequency / TAU;
            assert!((hertz - frequency).abs() < 5e-4, "{modes} modes, {level} m/s²: {hertz} Hz");
            let peak = level / found.force_amplitude;
            assert!((peak / ratio - 1.0).abs() < 5e-4, "{modes} modes, {level} m/s²: {peak} /kg");
        }
    }
}

/// Friction damps the first mode by 3 % at 10 m/s². Such a mode's largest acceleration per force lies beside
/// its phase resonance, by the square of that (−0.06 Hz here), and is larger by as little: what the
/// reference lists is the phase resonance.
#[test]
fn held_frequency_responses_have_the_reference_resonances_and_peaks() {
    for (modes, harmonics, reference) in [(4, 5, FOUR_MODES_FIVE_HARMONICS), (6, 9, SIX_MODES_NINE_HARMONICS)]
    {
        let beam = published(modes, false);
        for (level, frequency, ratio) in reference {
            let (hertz, at_quadrature, peak) = held_response(&beam, level, harmonics, frequency);
            let case =
                format!("{modes} modes, {level} m/s²: {hertz} Hz, {at_quadrature} /kg, peak {peak} /kg");
            println!("{case}");
            assert!((hertz - frequency).abs() < 0.01, "{case}");
            assert!((at_quadrature / ratio - 1.0).abs() < 0.01, "{case}");
            assert!((peak / ratio - 1.0).abs() < 0.01, "{case}");
        }
    }
}

/// Frequency (Hz) at phase resonance of the four-mode beam at 20 m/s².
fn resonance_at_20(settings: CurveSettings) -> f64 {
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let found =
        phase_resonance(&published(4, false).system(contact).unwrap(), 20.0, &settings, None).unwrap();
    found.angular_frequency / TAU
}

#[test]
fn the_sampled_contact_converges_to_the_exact_one_with_the_square_of_its_step() {
    let exact = resonance_at_20(CurveSettings { harmonics: 5, ..CurveSettings::default() });
    let off = |samples| {
        let method = Method::Sampled { samples };
        (resonance_at_20(CurveSettings { harmonics: 5, method, ..CurveSettings::default() }) - exact).abs()
    };
    let (coarse, fine) = (off(128), off(512));
    println!("sampled contact: {coarse} Hz at 128 samples, {fine} Hz at 512");
    assert!(coarse < 0.01 && fine < coarse / 10.0, "{coarse} {fine}");
}

#[test]
fn five_harmonics_are_enough_for_the_resonance() {
    let [five, fifteen] =
        [5, 15].map(|harmonics| resonance_at_20(CurveSettings { harmonics, ..CurveSettings::default() }));
    println!("5 harmonics: {five} Hz, 15: {fifteen} Hz");
    assert!((five - fifteen).abs() < 1e-4, "{five} {fifteen}");
}

/// Frequencies (Hz) at phase resonance.
fn resonances(modes: usize, static_correction: bool) -> [f64; 3] {
    let law = contact::published();
    let contact = loaded(law, LOAD);
    let settings = CurveSettings { harmonics: 5, ..CurveSettings::default() };
    let beam = published(modes, static_correction);
    let found = backbone(&beam.system(contact.clone()).unwrap(), &[0.5, 20.0, 70.0], &settings, &[]).unwrap();
    std::array::from_fn(|k| found[k].angular_frequency / TAU)
}

#[test]
fn static_correction_converges_where_pinned_modes_are_slow() {
    const MODES: [usize; 5] = [4, 6, 10, 20, 40];
    let plain = MODES.map(|modes| resonances(modes, false));
    let corrected = MODES.map(|modes| resonances(modes, true));
    for (modes, (plain, corrected)) in MODES.iter().zip(plain.iter().zip(&corrected)) {
        println!("{modes:2} modes: {plain:.4?} Hz, corrected {corrected:.4?} Hz");
    }
    let best = corrected[4];
    let off = |found: [f64; 3], level: usize| (found[level] - best[level]).abs();
    // In stick the end's flexibility is all that the truncated modes lack.
    for (plain, corrected) in plain.iter().zip(&corrected) {
        assert!(off(*corrected, 0) <= 0.01 * off(*plain, 0), "{plain:?} {corrected:?}");
    }
    // In slip their inertia and their own shortening count too.
    for level in 0..3 {
        assert!(off(corrected[3], level) < 1e-3, "{corrected:?}");
        assert!(off(corrected[3], level) < 0.2 * off(plain[3], level), "{plain:?} {corrected:?}");
        assert!(off(plain[4], level) < 0.6 * off(plain[3], level), "both ways lead to the same: {plain:?}");
    }
}
