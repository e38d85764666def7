//! Response curves of one mass against closed forms.

use std::sync::Arc;

use stickslip::contact::{ContactLaw, CubicSpring, Jenkins, Unilateral};
use stickslip::harmonic::{
    Assembly, Control, Curve, CurveSettings, Ending, HarmonicError, Method, frequency_response,
    periodic_response,
};
use stickslip::system::LinearStructure;

use crate::common::oscillator::{settings, single};

fn assembly<L: ContactLaw + 'static>(
    structure: &LinearStructure,
    laws: impl IntoIterator<Item = L>,
) -> Assembly {
    let attach = |law: L| -> (Arc<dyn ContactLaw>, f64) { (Arc::new(law), 1.0) };
    Assembly::new(structure.system(laws.into_iter().map(attach).collect()))
}

fn alone(structure: &LinearStructure) -> Assembly {
    Assembly::new(structure.system(Vec::new()))
}

fn curve(assembly: &Assembly, from: f64, to: f64, level: f64, settings: &CurveSettings) -> Curve {
    frequency_response(assembly, from, to, &Control::Level(level), settings, &mut |_| true).unwrap()
}

#[test]
fn a_linear_oscillator_peaks_where_the_textbook_says() {
    for zeta in [0.1, 0.003] {
        let structure = single(1.0, 2.0 * zeta, 1.0, 0);
        let curve = curve(&alone(&structure), 0.5, 1.5, 1.0, &settings(3));
        assert_eq!((curve.ending, curve.peaks.len()), (Ending::Complete, 1), "{zeta}");
        let peak = curve.peaks[0];
        assert!((peak.angular_frequency - (1.0 - 2.0 * zeta * zeta).sqrt()).abs() < 1e-9, "{peak:?}");
        let amplitude = 1.0 / (2.0 * zeta * (1.0 - zeta * zeta).sqrt());
        assert!((peak.amplitude / amplitude - 1.0).abs() < 1e-9, "{peak:?}");
    }
}

/// `x″ + 0.1 x′ + x + γ x³ = 0.2 cos Ωt` with one harmonic: `A [(1 + ¾ γ A − Ω²)² + (0.1 Ω)²] = 0.2²`,
/// `A = a²`; it turns where the derivative by A vanishes.
#[test]
fn duffing_turns_where_one_harmonic_turns_in_closed_form() {
    for (gamma, from, to) in [(0.5, 0.5, 2.5), (0.5, 2.5, 0.5), (-0.08, 1.5, 0.3)] {
        let (structure, law) = (single(1.0, 0.1, 1.0, 1), CubicSpring::new(0.0, gamma).unwrap());
        let curve = curve(&assembly(&structure, [law]), from, to, 0.2, &settings(1));
        assert_eq!(curve.ending, Ending::Complete);
        assert_eq!(curve.folds.len(), 2, "{gamma}");
        for fold in &curve.folds {
            let (a, s) = (fold.amplitude[0].powi(2), fold.angular_frequency.powi(2));
            let detuning = 1.0 + 0.75 * gamma * a - s;
            let balance = a * (detuning * detuning + 0.01 * s) / 0.04;
            assert!((balance - 1.0).abs() < 1e-8, "{fold:?}: {balance}");
            let turning = detuning * detuning + 0.01 * s + 1.5 * gamma * a * detuning;
            assert!(turning.abs() < 1e-6 * detuning * detuning, "{fold:?}: {turning}");
        }
        // The curve turns back between the folds.
        let backwards = curve
            .points
            .windows(2)
            .any(|pair| (pair[1].angular_frequency - pair[0].angular_frequency) * (to - from) < 0.0);
        assert!(backwards);
        // The same curve from the other side.
        for point in &curve.points {
            let (a, s) = (point.amplitude[0].powi(2), point.angular_frequency.powi(2));
            let balance = a * ((1.0 + 0.75 * gamma * a - s).powi(2) + 0.01 * s);
            assert!((balance / 0.04 - 1.0).abs() < 1e-7);
        }
    }
}

/// Coulomb friction on an undamped oscillator, motion without stops (Den Hartog 1931): β = 0.8, friction over
/// excitation 0.3.
#[test]
fn a_stiff_jenkins_element_approaches_den_hartogs_coulomb_friction() {
    const EXACT: f64 = 2.62610488;
    let structure = single(1.0, 0.0, 1.0, 1);
    let amplitude = |stiffness: f64, harmonics: usize| {
        let law = Jenkins::new(stiffness, 0.3).unwrap();
        let control = Control::Level(1.0);
        let point =
            periodic_response(&assembly(&structure, [law]), 0.8, &control, &settings(harmonics), None);
        point.unwrap().amplitude[0]
    };
    // The force turns over within a phase that goes with the root of the compliance: two extrapolations in
    // steps of half that root.
    let [soft, middle, stiff] = [25.0, 100.0, 400.0].map(|stiffness| amplitude(stiffness, 101));
    assert!((0.48..0.52).contains(&((stiff - EXACT) / (middle - EXACT))), "{soft} {middle} {stiff}");
    let (first, second) = (2.0 * middle - soft, 2.0 * stiff - middle);
    let limit = (4.0 * second - first) / 3.0;
    assert!((limit / EXACT - 1.0).abs() < 2e-5, "{limit}");
}

#[test]
fn contacts_side_by_side_are_one_contact() {
    let (single, double) = (single(1.0, 0.05, 1.0, 1), single(1.0, 0.05, 1.0, 2));
    let whole = Jenkins::new(0.5, 0.3).unwrap();
    let (a, b) = (Jenkins::new(0.2, 0.12).unwrap(), Jenkins::new(0.3, 0.18).unwrap());
    for omega in [0.6, 1.0, 1.3] {
        let control = Control::Level(0.5);
        let one =
            periodic_response(&assembly(&single, [whole]), omega, &control, &settings(15), None).unwrap();
        let two =
            periodic_response(&assembly(&double, [a, b]), omega, &control, &settings(15), None).unwrap();
        assert!((one.amplitude[0] / two.amplitude[0] - 1.0).abs() < 1e-9, "{omega}");
        assert!((one.dissipated_energy() - two.dissipated_energy()).abs() < 1e-9, "{omega}");
        let apart = (one.error_estimate - two.error_estimate).abs();
        assert!(apart <= 1e-3 * two.error_estimate + 1e-15, "{omega}: {apart}");
    }
}

#[test]
fn a_one_sided_stop_at_rest_makes_a_bias_and_a_bilinear_resonance() {
    // Stiffness 1 on one side and 3 on the other: half a period of each.
    let (structure, law) = (single(1.0, 0.01, 1.0, 1), Unilateral::new(2.0, 0.0).unwrap());
    let assembly = assembly(&structure, [law]);
    let curve = curve(&assembly, 1.0, 1.5, 0.01, &settings(12));
    assert_eq!(curve.ending, Ending::Complete);
    let natural = 2.0 * 3.0_f64.sqrt() / (1.0 + 3.0_f64.sqrt());
    let highest = curve.peaks.iter().max_by(|a, b| a.amplitude.total_cmp(&b.amplitude)).unwrap();
    assert!((highest.angular_frequency / natural - 1.0).abs() < 1e-3, "{highest:?} {natural}");
    for point in &curve.points {
        assert!(point.nodes[0][0] < 0.0, "pushed away from the stop");
        assert!(point.dissipated_energy().abs() < 1e-6 * point.work, "a spring");
    }
    // Without a gap nothing has a size: twice the force, twice the response.
    let response =
        |level| periodic_response(&assembly, 1.1, &Control::Level(level), &settings(12), None).unwrap();
    assert!((response(0.02).amplitude[0] / response(0.01).amplitude[0] - 2.0).abs() < 1e-8);
}

#[test]
fn a_sampled_contact_needs_no_more_samples_for_its_error_than_for_its_response() {
    let structure = single(1.0, 0.1, 1.0, 1);
    let law = Jenkins::new(0.5, 0.2).unwrap();
    let assembly = assembly(&structure, [law]);
    let respond = |method| {
        let settings = CurveSettings { method, ..settings(9) };
        periodic_response(&assembly, 1.1, &Control::Level(0.3), &settings, None).unwrap()
    };
    let (exact, sampled) = (respond(Method::Exact), respond(Method::Sampled { samples: 72 }));
    assert!((sampled.amplitude[0] / exact.amplitude[0] - 1.0).abs() < 1e-2);
    assert!(sampled.error_estimate.is_finite());
}

#[test]
fn an_excitation_beyond_the_harmonics_of_the_response_is_refused() {
    let structure = single(1.0, 0.1, 1.0, 0);
    let mut assembly = alone(&structure);
    assembly.waveform = vec![0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.5];
    let respond =
        |harmonics| periodic_response(&assembly, 0.3, &Control::Level(1.0), &settings(harmonics), None);
    assert!(matches!(respond(2), Err(HarmonicError::InvalidInput(_))));
    assert!(respond(3).is_ok());
}
