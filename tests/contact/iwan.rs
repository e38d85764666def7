//! Laws of the four-parameter Iwan element: its measurable parameters are exact, its dissipation
//! follows the power law, and it converges with the number of sliders.

use stickslip::contact::{ContactLaw, Inputs, Iwan, IwanSpacing, LawError};

use crate::common::contact::{ContactHistory, LOADS, check_derivatives, check_energy_balance, close};

const STIFFNESS: f64 = 5e6;
const FRICTION: f64 = 0.5;
const LOAD: f64 = 120.0;
const SHAPES: [(f64, f64); 5] = [(0.0, 0.0), (-0.3, 0.0), (-0.5, 1.7), (-0.9, 0.3), (0.0, 5.0)];

fn iwan((exponent, ratio): (f64, f64), intervals: usize, spacing: IwanSpacing) -> Iwan {
    Iwan::new(STIFFNESS, FRICTION, exponent, ratio, intervals, spacing).unwrap()
}

fn spacings() -> [IwanSpacing; 3] {
    [IwanSpacing::Equal, IwanSpacing::Geometric { growth: 1.2 }, IwanSpacing::Geometric { growth: 3.0 }]
}

/// The smooth element's loading curve: `∫₀^u ρφ dφ + u ∫_u^φmax ρ dφ + S u`.
fn smooth_force(law: &Iwan, u: f64) -> f64 {
    let (chi, largest) = (law.exponent(), law.macro_slip_displacement(LOAD));
    let scale = law.distribution_scale(LOAD);
    let terminal = law.ratio() * scale * largest.powf(chi + 1.0) / (chi + 1.0);
    let yielded = scale * u.powf(chi + 2.0) / (chi + 2.0);
    let stuck = scale * (largest.powf(chi + 1.0) - u.powf(chi + 1.0)) / (chi + 1.0);
    yielded + u * stuck + terminal * u
}

/// `4 R X^(χ+3)/[(χ+2)(χ+3)]`.
fn smooth_dissipation(law: &Iwan, amplitude: f64) -> f64 {
    let chi = law.exponent();
    4.0 * law.distribution_scale(LOAD) * amplitude.powf(chi + 3.0) / ((chi + 2.0) * (chi + 3.0))
}

#[test]
fn stiffness_and_macro_slip_force_are_exact_for_any_number_of_sliders() {
    for shape in SHAPES {
        for spacing in spacings() {
            for intervals in [1, 2, 7, 100, 2000] {
                let law = iwan(shape, intervals, spacing);
                close(law.sliders_alone().tangential_stiffness() / STIFFNESS, 1.0, 1e-12);
                close(law.limit(LOAD) / (FRICTION * LOAD), 1.0, 1e-12);
                let mut contact = ContactHistory::at_rest(&law, LOAD);
                let largest = law.macro_slip_displacement(LOAD);
                let slipping = contact.go(1.000_001 * largest, LOAD);
                close(slipping.force / (FRICTION * LOAD), 1.0, 1e-12);
                assert_eq!(slipping.tangents.displacement, 0.0);
            }
        }
    }
}

#[test]
fn four_parameters_satisfy_segalmans_relations() {
    for shape in SHAPES {
        let law = iwan(shape, 10, IwanSpacing::Equal);
        let (chi, largest) = (law.exponent(), law.macro_slip_displacement(LOAD));
        let scale = law.distribution_scale(LOAD);
        let terminal = law.ratio() * scale * largest.powf(chi + 1.0) / (chi + 1.0);
        close((scale * largest.powf(chi + 1.0) / (chi + 1.0) + terminal) / STIFFNESS, 1.0, 1e-12);
        let slip_force = scale * largest.powf(chi + 2.0) / (chi + 2.0) + terminal * largest;
        close(slip_force / (FRICTION * LOAD), 1.0, 1e-12);
    }
}

#[test]
fn loading_curve_meets_the_smooth_one_at_the_ends_of_the_intervals() {
    for shape in SHAPES {
        let law = iwan(shape, 8, IwanSpacing::Equal);
        let largest = law.macro_slip_displacement(LOAD);
        for i in 1..=8 {
            let u = largest * f64::from(i) / 8.0;
            close(ContactHistory::at_rest(&law, LOAD).go(u, LOAD).force / smooth_force(&law, u), 1.0, 1e-11);
            let between = u - largest / 16.0;
            let above =
                ContactHistory::at_rest(&law, LOAD).go(between, LOAD).force - smooth_force(&law, between);
            assert!(above > 0.0);
        }
    }
}

#[test]
fn dissipation_is_the_power_law_with_second_order_convergence() {
    for shape in SHAPES {
        // At an interval's end for all these numbers.
        let error = |intervals: usize| {
            let law = iwan(shape, intervals, IwanSpacing::Equal);
            let amplitude = 0.5 * law.macro_slip_displacement(LOAD);
            let (dissipated, _) = ContactHistory::at_rest(&law, LOAD).last_loop(amplitude, LOAD, 2);
            dissipated / smooth_dissipation(&law, amplitude) - 1.0
        };
        let errors = [16, 32, 64, 128].map(error);
        assert!(errors.iter().all(|error| *error > 0.0), "{errors:?}");
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!((order - 2.0).abs() < 0.25, "order {order}, errors {errors:?}, {shape:?}");
        }
        assert!(errors[3] < 1e-3);
    }
}

#[test]
fn excess_dissipation_is_the_spread_within_the_intervals() {
    // χ = 0: ρ is even, and the spread of an interval of length h is R h³/12.
    let law = iwan((0.0, 0.0), 10, IwanSpacing::Equal);
    let largest = law.macro_slip_displacement(LOAD);
    for passed in 1..=9 {
        let amplitude = largest * f64::from(passed) / 10.0;
        let (dissipated, _) = ContactHistory::at_rest(&law, LOAD).last_loop(amplitude, LOAD, 2);
        let spread = law.distribution_scale(LOAD) * (largest / 10.0).powi(3) / 12.0;
        let expected = smooth_dissipation(&law, amplitude) + 4.0 * f64::from(passed) * spread;
        close(dissipated / expected, 1.0, 1e-11);
    }
}

#[test]
fn geometric_spacing_keeps_the_power_law_over_decades() {
    for shape in SHAPES {
        let law = iwan(shape, 80, IwanSpacing::Geometric { growth: 1.2 });
        for decade in [1e-4, 1e-3, 1e-2, 1e-1, 0.9] {
            let amplitude = decade * law.macro_slip_displacement(LOAD);
            let (dissipated, _) = ContactHistory::at_rest(&law, LOAD).last_loop(amplitude, LOAD, 2);
            close(dissipated / smooth_dissipation(&law, amplitude), 1.0, 0.02);
        }
    }
}

#[test]
fn beyond_macro_slip_each_further_displacement_costs_4_limits() {
    for shape in SHAPES {
        let law = iwan(shape, 400, IwanSpacing::Equal);
        let (largest, limit) = (law.macro_slip_displacement(LOAD), law.limit(LOAD));
        let (near, _) = ContactHistory::at_rest(&law, LOAD).last_loop(1.1 * largest, LOAD, 2);
        let (far, _) = ContactHistory::at_rest(&law, LOAD).last_loop(3.1 * largest, LOAD, 2);
        close((far - near) / (8.0 * limit * largest), 1.0, 1e-11);
        // Up to macro-slip the loop follows the power law; the terminal slider then joins in.
        let start = near - 0.4 * limit * largest;
        close(start / smooth_dissipation(&law, largest), 1.0, 1e-3);
    }
}

#[test]
fn masing_branches_are_the_loading_curve_at_twice_its_size() {
    for shape in SHAPES {
        let law = iwan(shape, 25, IwanSpacing::Geometric { growth: 1.3 });
        for fraction in [0.03, 0.4, 1.3] {
            let amplitude = fraction * law.macro_slip_displacement(LOAD);
            let tip = ContactHistory::at_rest(&law, LOAD).go(amplitude, LOAD).force;
            for part in [0.1, 0.37, 0.8, 1.0] {
                let loading = ContactHistory::at_rest(&law, LOAD).go(part * amplitude, LOAD).force;
                let mut contact = ContactHistory::at_rest(&law, LOAD);
                contact.go(amplitude, LOAD);
                let branch = contact.go(amplitude * (1.0 - 2.0 * part), LOAD).force;
                close(branch, tip - 2.0 * loading, 1e-11 * tip);
            }
        }
    }
}

#[test]
fn strengths_follow_the_load_and_stiffnesses_stay() {
    let law = iwan((-0.4, 1.0), 20, IwanSpacing::Equal);
    let largest = law.macro_slip_displacement(LOAD);
    close(law.macro_slip_displacement(3.0 * LOAD) / largest, 3.0, 1e-14);
    // Similar loops: three times the load and the displacement is three times the force.
    let small = ContactHistory::at_rest(&law, LOAD).go(0.3 * largest, LOAD).force;
    let large = ContactHistory::at_rest(&law, 3.0 * LOAD).go(0.9 * largest, 3.0 * LOAD).force;
    close(large / small, 3.0, 1e-12);
    // More load on a contact at rest creates no force.
    let mut contact = ContactHistory::at_rest(&law, LOAD);
    let before = contact.go(0.3 * largest, LOAD).force;
    close(contact.go(0.3 * largest, 5.0 * LOAD).force, before, 1e-12);
}

#[test]
fn state_tangents_equal_finite_differences() {
    let law = iwan((-0.4, 1.0), 4, IwanSpacing::Equal);
    for (start_load, end_load) in LOADS {
        for fraction in [-0.7, 0.0, 0.4] {
            for travel in [-21e-6, -3.1e-6, 0.13e-6, 9.3e-6] {
                let mut start =
                    ContactHistory::from(&law, 2e-6, start_load, fraction * law.limit(start_load));
                start.state[2..].iter_mut().for_each(|z| *z *= 0.995);
                let inputs = Inputs { displacement: 2e-6 + travel, velocity: 0.0, normal_load: end_load };
                check_derivatives(&law, &start.state, inputs, &|index| index != 1);
            }
        }
    }
}

#[test]
fn work_of_a_fine_history_equals_stored_plus_dissipated() {
    let law = iwan((-0.5, 1.7), 12, IwanSpacing::Geometric { growth: 1.2 });
    check_energy_balance(&law, &|state| law.sliders_alone().stored_energy(state));
}

#[test]
fn bad_parameters_are_named() {
    let make = |chi, beta, count, spacing| Iwan::new(1e6, 0.5, chi, beta, count, spacing);
    let name = |result: Result<Iwan, LawError>| match result.unwrap_err() {
        LawError::OutOfBounds { parameter, .. } => parameter,
        other => panic!("{other}"),
    };
    let equal = IwanSpacing::Equal;
    for chi in [-1.0, 0.1, f64::NAN] {
        assert_eq!(name(make(chi, 0.0, 5, equal)), "exponent");
    }
    assert_eq!(name(make(0.0, -0.1, 5, equal)), "ratio");
    assert_eq!(name(make(0.0, 0.1, 0, equal)), "intervals");
    assert_eq!(name(make(0.0, 0.1, 10_001, equal)), "intervals");
    for growth in [1.0, 0.5, 11.0, f64::NAN] {
        assert_eq!(name(make(0.0, 0.1, 5, IwanSpacing::Geometric { growth })), "growth");
    }
    // Extremes that are legal make a law.
    for chi in [-0.999_999, 0.0] {
        assert!(make(chi, 1e12, 10_000, IwanSpacing::Geometric { growth: 10.0 }).is_ok());
    }
}
