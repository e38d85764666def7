//! Laws of Valanis' endochronic contact.

use stickslip::contact::{
    ContactLaw, Inputs, Jenkins, LawError, Period, PeriodicSolver, SlipState, Valanis, periodic_state,
};

use crate::common::contact::{close, go};

const STIFFNESS: f64 = 7.9e6;
const SMOOTHNESS: f64 = 0.3;
const LAMBDA: f64 = 8.7e4;
const LOAD: f64 = 147.15;
const SATURATION: f64 = STIFFNESS / LAMBDA;

/// Table 3 of the beam with a frictional support.
fn published() -> Valanis {
    Valanis::from_lambda(STIFFNESS, 0.0, SMOOTHNESS, LAMBDA, LOAD).unwrap()
}

fn fresh(law: &Valanis) -> [f64; 4] {
    let mut state = [0.0; 4];
    law.set_state(0.0, LOAD, 0.0, &mut state);
    state
}

/// Tip force and dissipated energy of the closed loop between ±`amplitude`.
fn closed_loop(law: &Valanis, amplitude: f64) -> (f64, f64) {
    let period = Period { displacement: &[-amplitude, amplitude], velocity: &[], normal_load: &[LOAD] };
    let (mut state, mut force) = (fresh(law), [0.0; 2]);
    let mut solver = PeriodicSolver::new();
    solver.solve(law, &period, &mut state).unwrap();
    let dissipated = solver.trace(law, &period, &mut state, &mut force).unwrap();
    close(force[0], -force[1], 1e-10 * force[1]);
    (force[1], dissipated)
}

/// The published table: amplitude, force of the initial loading, periodic tip force, dissipated energy.
const REFERENCE: [(f64, f64, f64, f64); 5] = [
    (1e-6, 7.660241, 7.886058, 6.40993067e-7),
    (10e-6, 56.581491, 66.332303, 5.82422872e-4),
    (20e-6, 79.786231, 87.961333, 3.22016858e-3),
    (50e-6, 90.526093, 90.802885, 1.39860743e-2),
    (100e-6, 90.804040, 90.804598, 3.21469150e-2),
];

#[test]
fn reference_virgin_force_tip_force_and_loop_area() {
    for (amplitude, initial, tip, area) in REFERENCE {
        let law = published();
        let force = go(&law, &mut fresh(&law), amplitude, LOAD).force;
        close(force / initial, 1.0, 1e-6);
        let (found_tip, found_area) = closed_loop(&law, amplitude);
        close(found_tip / tip, 1.0, 1e-6);
        close(found_area / area, 1.0, 1e-6);
    }
}

/// Periodic loop of amplitude `amplitude` by the printed closed form: tip of the hysteretic force and
/// dissipated energy.
fn loop_by_formula(law: &Valanis, amplitude: f64) -> (f64, f64) {
    let (e0, e_t, kappa) = (law.tangential_stiffness(), law.residual_stiffness(), law.smoothness());
    let (a, p, r) = (law.lambda(LOAD) / e0, e0 - e_t, e0 - kappa * e_t);
    let c2 = e0 * (1.0 - kappa) / (r * r);
    // Solved for h = atanh(r x/p), which keeps its digits next to saturation.
    let (mut low, mut high) = (0.0, a * amplitude / c2);
    for _ in 0..200 {
        let middle: f64 = 0.5 * (low + high);
        let reached = kappa / r * (p / r) * middle.tanh() + c2 * middle;
        if reached < a * amplitude { low = middle } else { high = middle }
    }
    let h = 0.5 * (low + high);
    let x = p / r * h.tanh();
    (x / a, 4.0 * c2 / (a * a) * (p / r * h - x))
}

#[test]
fn periodic_loop_equals_the_closed_form_with_residual_stiffness() {
    for (e_t, kappa) in [(0.0, 0.0), (0.0, 0.9), (5.3e5, 0.67), (4e6, 0.3)] {
        let law = Valanis::from_lambda(STIFFNESS, e_t, kappa, LAMBDA, LOAD).unwrap();
        for amplitude in [1e-6, 10e-6, 25e-6] {
            let (tip, area) = loop_by_formula(&law, amplitude);
            let (found_tip, found_area) = closed_loop(&law, amplitude);
            close(found_tip / (tip + e_t * amplitude), 1.0, 1e-9);
            close(found_area / area, 1.0, 1e-9);
        }
    }
}

#[test]
fn periodic_state_at_1_micrometre_is_solved_for_not_marched_to() {
    let law = published();
    let (tip, _) = loop_by_formula(&law, 1e-6);
    let mut state = fresh(&law);
    let info = periodic_state(&law, &[-1e-6, 1e-6], &[LOAD], &mut state).unwrap();
    close(state[0] / tip, 1.0, 1e-9);
    assert!(info.iterations <= 6 && info.residual < 1e-12, "{info:?}");
    // Two marched periods are what the reference warns of: 1.8 % off.
    let mut marched = fresh(&law);
    for displacement in [1e-6, -1e-6, 1e-6, -1e-6, 1e-6] {
        go(&law, &mut marched, displacement, LOAD);
    }
    assert!((marched[0] / tip - 1.0).abs() > 0.005);
}

#[test]
fn loop_area_limits_for_small_and_large_amplitude() {
    let law = published();
    for amplitude in [1e-9_f64, 1e-8] {
        let small = 4.0 / 3.0 * STIFFNESS * LAMBDA * (1.0 - SMOOTHNESS) * amplitude.powi(3);
        close(closed_loop(&law, amplitude).1 / small, 1.0, 1e-5);
    }
    for amplitude in [300e-6, 1e-2] {
        let large = 4.0 * SATURATION * (amplitude - 1.0 / LAMBDA);
        close(closed_loop(&law, amplitude).1 / large, 1.0, 1e-12);
    }
}

#[test]
fn kappa_towards_1_approaches_jenkins() {
    let jenkins = Jenkins::new(STIFFNESS, published().friction_coefficient()).unwrap();
    let mut error_before = f64::INFINITY;
    for gap in [1e-2, 1e-4, 1e-6] {
        let law = Valanis::from_lambda(STIFFNESS, 0.0, 1.0 - gap, LAMBDA, LOAD).unwrap();
        let (mut state, mut slider, mut next) = (fresh(&law), [0.0; 3], [0.0; 3]);
        jenkins.set_state(0.0, LOAD, 0.0, &mut slider);
        let mut error: f64 = 0.0;
        let (mut dissipated, mut expected) = (0.0, 0.0);
        for (displacement, normal_load) in [
            (8e-6, LOAD),
            (11.6e-6, LOAD),
            (30e-6, LOAD),
            (20e-6, LOAD),
            (-40e-6, LOAD),
            (-30e-6, -LOAD),
            (-10e-6, LOAD),
            (-2e-6, LOAD),
        ] {
            let other = jenkins.step(&slider, Inputs { displacement, velocity: 0.0, normal_load }, &mut next);
            slider = next;
            let response = go(&law, &mut state, displacement, normal_load);
            error = error.max((response.force - other.force).abs() / SATURATION);
            if normal_load > 0.0 {
                dissipated += response.dissipated_energy;
                expected += other.dissipated_energy;
            }
        }
        assert!(error < 8.0 * gap && error < 0.1 * error_before, "1 − κ = {gap:e}: {error:e}");
        close(dissipated / expected, 1.0, 10.0 * gap);
        error_before = error;
    }
}

#[test]
fn minor_loops_do_not_close() {
    let law = published();
    let mut state = fresh(&law);
    for (displacement, force) in [(20e-6, 79.79), (15e-6, 26.84), (20e-6, 52.10)] {
        close(go(&law, &mut state, displacement, LOAD).force, force, 0.005);
    }
}

#[test]
fn unloading_from_saturation_starts_at_2_e0_over_1_plus_kappa() {
    for kappa in [0.0, 0.3, 0.9] {
        let law = Valanis::from_lambda(STIFFNESS, 0.0, kappa, LAMBDA, LOAD).unwrap();
        let mut state = fresh(&law);
        let top = go(&law, &mut state, 1e-2, LOAD);
        close(top.force, SATURATION, 1e-12);
        close(top.tangents.displacement, 0.0, 1e-3);
        let slope = 2.0 * STIFFNESS / (1.0 + kappa);
        let mut probe = state;
        let back = go(&law, &mut probe, 1e-2 - 1e-12, LOAD);
        close(back.tangents.displacement / slope, 1.0, 1e-6);
        // At rest the tangent is that of unloading.
        close(go(&law, &mut state, 1e-2, LOAD).tangents.displacement / slope, 1.0, 1e-12);
    }
}

#[test]
fn virgin_tangent_is_e0_and_macro_slip_keeps_the_residual_stiffness() {
    let law = Valanis::new(STIFFNESS, 0.6, 0.5, 5e5).unwrap();
    let mut state = fresh(&law);
    close(go(&law, &mut state, 0.0, LOAD).tangents.displacement / STIFFNESS, 1.0, 1e-14);
    close(go(&law, &mut state, 1e-3, LOAD).tangents.displacement / 5e5, 1.0, 1e-12);
    close(state[0], law.limit(LOAD), 1e-12);
}

/// The rate law as printed, integrated over the displacement by Runge–Kutta's fourth order.
fn integrate_rate(law: &Valanis, force: f64, from: f64, to: f64, steps: usize) -> f64 {
    let (e0, e_t, kappa) = (law.tangential_stiffness(), law.residual_stiffness(), law.smoothness());
    let lambda = law.lambda(LOAD);
    let sign = (to - from).signum();
    let slope = |u: f64, t: f64| {
        let x = lambda / e0 * sign * (e_t * u - t);
        e0 * (1.0 + x) / (1.0 + kappa * x)
    };
    let h = (to - from) / steps as f64;
    let (mut t, mut u) = (force, from);
    for i in 0..steps {
        let k1 = slope(u, t);
        let k2 = slope(u + 0.5 * h, t + 0.5 * h * k1);
        let k3 = slope(u + 0.5 * h, t + 0.5 * h * k2);
        let k4 = slope(u + h, t + h * k3);
        t += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        u = from + (i + 1) as f64 * h;
    }
    t
}

#[test]
fn closed_form_equals_the_integrated_rate_law() {
    for (e_t, kappa) in [(0.0, 0.0), (0.0, 0.3), (5.3e5, 0.67), (3e6, 0.3), (1e6, 0.0)] {
        let law = Valanis::from_lambda(STIFFNESS, e_t, kappa, LAMBDA, LOAD).unwrap();
        let (mut state, mut integrated, mut from) = (fresh(&law), 0.0, 0.0);
        for to in [20e-6, 15e-6, 23e-6, -30e-6, -29e-6, -31e-6, 60e-6] {
            integrated = integrate_rate(&law, integrated, from, to, 20_000);
            let force = go(&law, &mut state, to, LOAD).force;
            close(force, integrated, 1e-9);
            from = to;
        }
    }
}

#[test]
fn one_step_equals_many_in_the_same_direction() {
    for (e_t, kappa) in [(0.0, 0.0), (0.0, 0.3), (5.3e5, 0.67), (0.0, 0.999)] {
        let law = Valanis::from_lambda(STIFFNESS, e_t, kappa, LAMBDA, LOAD).unwrap();
        let (mut once, mut often) = (fresh(&law), fresh(&law));
        let mut from = 0.0;
        for to in [5e-6, 30e-6, 29e-6, -50e-6, 300e-6, -10e-6] {
            let whole = go(&law, &mut once, to, LOAD);
            let mut dissipated = 0.0;
            for i in 1..=53 {
                let part = go(&law, &mut often, from + (to - from) * i as f64 / 53.0, LOAD);
                dissipated += part.dissipated_energy;
            }
            close(once[0], often[0], 1e-11);
            close(dissipated / whole.dissipated_energy, 1.0, 1e-9);
            from = to;
        }
    }
}

#[test]
fn work_equals_stored_plus_dissipated_on_a_fine_history() {
    for (e_t, kappa) in [(0.0, 0.3), (5.3e5, 0.67)] {
        let law = Valanis::from_lambda(STIFFNESS, e_t, kappa, LAMBDA, LOAD).unwrap();
        let mut state = fresh(&law);
        let (mut work, mut dissipated, mut force) = (0.0, 0.0, 0.0);
        let samples = 40_000;
        for i in 1..=samples {
            let t = 6.0 * i as f64 / samples as f64;
            let displacement = 20e-6 * (1.7 * t).sin() + 10e-6 * (5.1 * t).sin();
            let before = state[1];
            let response = go(&law, &mut state, displacement, LOAD);
            work += 0.5 * (force + response.force) * (displacement - before);
            force = response.force;
            dissipated += response.dissipated_energy;
        }
        close(work / (law.stored_energy(&state) + dissipated), 1.0, 1e-6);
    }
}

#[test]
fn dissipation_of_tiny_steps_keeps_its_digits() {
    // From rest D grows with the cube of the step, X³ e0 λ (1 − κ)/3: sixteen digits below the energy
    // kept for the smallest of these.
    let law = published();
    for step in [1e-13_f64, 1e-12, 1e-11, 1e-10, 1e-9] {
        let cubic = STIFFNESS * LAMBDA * (1.0 - SMOOTHNESS) / 3.0 * step.powi(3);
        let response = go(&law, &mut fresh(&law), step, LOAD);
        close(response.dissipated_energy / cubic, 1.0, 1e-3);
    }
}

#[test]
fn a_change_of_load_creates_no_force() {
    let law = published();
    let mut state = fresh(&law);
    let before = go(&law, &mut state, 5e-6, LOAD).force;
    for load in [1e4, 100.0, 1e9, LOAD] {
        let response = go(&law, &mut state, 5e-6, load);
        assert_eq!((response.force, response.dissipated_energy), (before, 0.0));
    }
    let cut = go(&law, &mut state, 5e-6, 10.0);
    close(cut.force, law.limit(10.0), 1e-14);
    let lost = (before * before - cut.force * cut.force) / (2.0 * STIFFNESS);
    close(cut.dissipated_energy / lost, 1.0, 1e-12);
}

#[test]
fn separation_releases_everything_and_re_contact_remembers_nothing() {
    let law = Valanis::new(STIFFNESS, 0.6, 0.5, 5e5).unwrap();
    let mut state = fresh(&law);
    go(&law, &mut state, 400e-6, LOAD);
    close(state[0], law.limit(LOAD), 1e-9);
    let kept = law.stored_energy(&state);
    let apart = go(&law, &mut state, 405e-6, -LOAD);
    assert_eq!((apart.force, apart.slip_state, law.stored_energy(&state)), (0.0, SlipState::Separated, 0.0));
    // N = 0 half-way. Until then the contact, saturated at the start, does work against the mean limit and
    // the residual spring.
    let work = 0.5 * law.limit(LOAD) * 2.5e-6 + 0.5 * 5e5 * (402.5e-6_f64.powi(2) - 400e-6_f64.powi(2));
    close(apart.dissipated_energy / (kept + work), 1.0, 1e-6);
    // N = 0 half-way: only the second half of the motion counts, from an unstressed start.
    let response = go(&law, &mut state, 407e-6, LOAD);
    close(state[3], 406e-6, 1e-16);
    let mut other = [0.0, 406e-6, 0.0, 406e-6];
    close(response.force, go(&law, &mut other, 407e-6, LOAD).force, 1e-9);
}

#[test]
fn force_is_odd_in_the_history() {
    let law = Valanis::new(STIFFNESS, 0.6, 0.5, 5e5).unwrap();
    let (mut state, mut mirror) = (fresh(&law), fresh(&law));
    for (u, load) in [(50e-6, LOAD), (20e-6, 90.0), (20e-6, 80.0), (-70e-6, -3.0), (4e-6, 80.0), (9e-6, 20.0)]
    {
        let (a, b) = (go(&law, &mut state, u, load), go(&law, &mut mirror, -u, load));
        assert_eq!((a.force, a.dissipated_energy), (-b.force, b.dissipated_energy));
        assert_eq!(a.tangents.displacement, b.tangents.displacement);
        assert_eq!(a.tangents.normal_load, -b.tangents.normal_load);
    }
}

#[test]
fn huge_steps_and_tiny_loads_do_not_overflow() {
    for kappa in [0.0, 0.3, 0.999_999] {
        let law = Valanis::from_lambda(STIFFNESS, 0.0, kappa, LAMBDA, LOAD).unwrap();
        let mut state = fresh(&law);
        for displacement in [1.0, -1e6, 1e300, -1e300] {
            let response = go(&law, &mut state, displacement, LOAD);
            close(response.force, SATURATION * displacement.signum(), 1e-12);
            assert!(response.dissipated_energy.is_finite() && response.dissipated_energy > 0.0);
            assert!(response.tangents.displacement.abs() < 1e-6 && response.tangents.normal_load.is_finite());
        }
        // The reach overflows; what is dissipated is limit times distance all the same.
        law.set_state(0.0, 1e-305, 0.0, &mut state);
        let response = go(&law, &mut state, 1.0, 1e-305);
        close(response.dissipated_energy / law.limit(1e-305), 1.0, 1e-9);
    }
    // A limit that underflows is no contact.
    let law = Valanis::new(STIFFNESS, 0.3, 0.3, 0.0).unwrap();
    assert_eq!(go(&law, &mut fresh(&law), 1.0, 5e-324).slip_state, SlipState::Separated);
}

#[test]
fn not_a_number_is_passed_on() {
    let law = published();
    assert!(go(&law, &mut fresh(&law), f64::NAN, LOAD).force.is_nan());
    assert!(go(&law, &mut fresh(&law), 1e-6, f64::NAN).force.is_nan());
}

#[test]
fn published_constants_convert_back() {
    let law = Valanis::from_lambda(STIFFNESS, 5.3e5, 0.67, LAMBDA, 200.0).unwrap();
    close(law.lambda(200.0) / LAMBDA, 1.0, 1e-14);
    close(law.lambda(100.0) / LAMBDA, 2.0, 1e-14);
    let plain = published();
    close(plain.limit(LOAD) / SATURATION, 1.0, 1e-14);
}

#[test]
fn bad_parameters_are_named_with_value_and_bounds() {
    let name = |result: Result<Valanis, LawError>| match result {
        Err(LawError::OutOfBounds { parameter, .. }) => parameter,
        other => panic!("accepted or another error: {other:?}"),
    };
    for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert_eq!(name(Valanis::new(bad, 0.5, 0.3, 0.0)), "tangential_stiffness");
        assert_eq!(name(Valanis::new(1e6, bad, 0.3, 0.0)), "friction_coefficient");
        assert_eq!(name(Valanis::from_lambda(1e6, 0.0, 0.3, bad, 1.0)), "lambda");
        assert_eq!(name(Valanis::from_lambda(1e6, 0.0, 0.3, 1.0, bad)), "normal_load");
    }
    for bad in [-1e-9, 1.0, f64::NAN] {
        assert_eq!(name(Valanis::new(1e6, 0.5, bad, 0.0)), "smoothness");
    }
    for bad in [-1e-9, 1e6, f64::NAN] {
        assert_eq!(name(Valanis::new(1e6, 0.5, 0.3, bad)), "residual_stiffness");
    }
    let text = Valanis::new(1e6, 0.5, 1.0, 0.0).unwrap_err().to_string();
    assert_eq!(text, "smoothness is 1; it must be a finite number, at least 0, below 1");
}
