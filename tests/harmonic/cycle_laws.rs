//! Contacts carried over a period: derivatives, symmetry, energy, Masing's rule, whatever the motion.

use std::f64::consts::PI;

use proptest::prelude::*;
use stickslip::contact::{
    Backlash, ContactLaw, CubicSpring, Inputs, Iwan, IwanSpacing, Response, Slider, SlipState, StateTangents,
    Tangents, Unilateral, Valanis,
};
use stickslip::harmonic::{HarmonicSet, contact_cycle};

use crate::common::contact::{self, LOAD};
use crate::common::cycle::{Sliders, cases, differences, evaluated, largest, motions, slider};

#[test]
fn jacobian_is_the_derivative_of_the_force() {
    for (name, sliders) in cases() {
        let law = Sliders(sliders);
        for compliance in [0.0, 0.2] {
            for (motion, u) in motions() {
                let set = HarmonicSet::full(5);
                let map = evaluated(&law, compliance, set, &u);
                let expected = differences(&law, compliance, set, &u, 1e-5);
                let error = (map.jacobian() - &expected).abs().max();
                assert!(error < 1e-7, "{name}, {motion}, {compliance}: {error:e}");
            }
        }
    }
}

#[test]
fn valanis_jacobian_is_the_derivative_of_the_force() {
    let law = Valanis::from_lambda(7.9e6, 2e5, 0.3, 8.7e4, LOAD).unwrap();
    for compliance in [0.0, 1.5e-8] {
        for (motion, u) in motions() {
            let u: Vec<f64> = u.iter().map(|x| 2e-5 * x).collect();
            let set = HarmonicSet::full(5);
            let map = evaluated(&law, compliance, set, &u);
            let expected = differences(&law, compliance, set, &u, 2e-10);
            let error = (map.jacobian() - &expected).abs().max() / expected.abs().max();
            assert!(error < 1e-7, "{motion}, {compliance}: {error:e}");
        }
    }
}

#[test]
fn odd_set_equals_full_set_for_odd_motions() {
    let (odd, full) = (HarmonicSet::odd(5), HarmonicSet::full(5));
    let mut laws: Vec<(&str, Box<dyn ContactLaw>, f64)> =
        vec![("valanis", Box::new(contact::published()), 3e-5)];
    for (name, sliders) in cases() {
        laws.push((name, Box::new(Sliders(sliders)), 1.0));
    }
    for (name, law, scale) in &laws {
        let u: Vec<f64> = [0.7, 0.4, -0.5, 0.6, 0.3, -0.2].iter().map(|x| scale * x).collect();
        let mut wide = vec![0.0; full.len()];
        odd.convert(&u, full, &mut wide);
        for compliance in [0.0, 1e-8] {
            let mut a = evaluated(law.as_ref(), compliance, odd, &u);
            let mut b = evaluated(law.as_ref(), compliance, full, &wide);
            let size = largest(b.force().iter().copied());
            let mut back = vec![0.0; odd.len()];
            full.convert(b.force(), odd, &mut back);
            let error = largest(back.iter().zip(a.force()).map(|(a, b)| a - b));
            assert!(error < 1e-10 * size, "{name}: {error:e}");
            if law.is_odd() {
                let even = (0..full.len()).filter(|i| i.div_ceil(2) % 2 == 0).map(|i| b.force()[i]);
                assert!(largest(even) < 1e-10 * size, "{name}");
            }
            let (a, b) = (a.summary(), b.summary());
            assert!(
                (a.dissipated_energy - b.dissipated_energy).abs() <= 1e-9 * b.dissipated_energy,
                "{name}"
            );
            assert!((a.equivalent_stiffness / b.equivalent_stiffness - 1.0).abs() < 1e-9, "{name}");
            assert_eq!(a.stick_fraction.is_some(), b.stick_fraction.is_some());
            if let (Some(a), Some(b)) = (a.stick_fraction, b.stick_fraction) {
                assert!((a - b).abs() < 1e-9, "{name}: {a} {b}");
            }
        }
    }
}

/// A spring that hardens with the cube of the displacement, and a damper: no memory.
#[derive(Debug)]
struct Memoryless {
    cubic: f64,
    damping: f64,
}

impl ContactLaw for Memoryless {
    fn state_len(&self) -> usize {
        0
    }

    fn set_state(&self, _displacement: f64, _normal_load: f64, _force: f64, _state: &mut [f64]) {}

    fn step(&self, _state: &[f64], inputs: Inputs, _next: &mut [f64]) -> Response {
        let u = inputs.displacement;
        Response {
            force: self.cubic * u * u * u + self.damping * inputs.velocity,
            tangents: Tangents {
                displacement: 3.0 * self.cubic * u * u,
                velocity: self.damping,
                normal_load: 0.0,
            },
            dissipated_energy: 0.0,
            slip_state: SlipState::Stick,
        }
    }

    fn state_tangents(&self, _state: &[f64], _inputs: Inputs, out: &mut StateTangents) {
        out.reset(0);
    }

    fn limit(&self, _normal_load: f64) -> f64 {
        f64::INFINITY
    }
}

#[test]
fn memoryless_law_has_its_closed_form() {
    // u = c cos θ: u³ = c³ (¾ cos θ + ¼ cos 3θ), and the damper −d Ω c sin θ.
    let law = Memoryless { cubic: 2.0, damping: 0.01 };
    for set in [HarmonicSet::full(3), HarmonicSet::odd(3)] {
        let mut u = vec![0.0; set.len()];
        let (first, third) = (set.place(1).unwrap(), set.place(3).unwrap());
        u[first] = 1.3;
        let map = evaluated(&law, 0.0, set, &u);
        let cube = 2.0 * 1.3f64.powi(3);
        let force = map.force();
        assert!((force[first] - 0.75 * cube).abs() < 1e-12, "{force:?}");
        assert!((force[third] - 0.25 * cube).abs() < 1e-12);
        assert!((force[first + 1] + 0.01 * 300.0 * 1.3).abs() < 1e-12);
        assert!((map.by_frequency()[first + 1] + 0.01 * 1.3).abs() < 1e-14);
        let expected = differences(&law, 0.0, set, &u, 1e-5);
        assert!((map.jacobian() - expected).abs().max() < 1e-7);
    }
}

/// Work of the force over a period from the coefficients alone.
fn work(set: HarmonicSet, force: &[f64], u: &[f64]) -> f64 {
    let works = set.orders().filter(|(order, _)| *order > 0);
    PI * works.map(|(h, p)| h as f64 * (force[p] * u[p + 1] - force[p + 1] * u[p])).sum::<f64>()
}

#[test]
fn laws_of_the_library_do_the_work_they_dissipate() {
    let laws: Vec<(&str, Box<dyn ContactLaw>)> = vec![
        ("iwan", Box::new(Iwan::new(2.0, 1.0 / LOAD, -0.5, 1.0, 20, IwanSpacing::Equal).unwrap())),
        ("backlash", Box::new(Backlash::new(2.0, 0.4 / LOAD, 0.2).unwrap())),
        ("unilateral", Box::new(Unilateral::new(2.0, 0.2).unwrap())),
        ("cubic", Box::new(CubicSpring::new(2.0, 0.7).unwrap())),
    ];
    for (name, law) in &laws {
        for compliance in [0.0, 0.15] {
            for (motion, u) in motions() {
                let set = HarmonicSet::full(5);
                let mut map = evaluated(law.as_ref(), compliance, set, &u);
                let summary = map.summary();
                let error = summary.dissipated_energy - work(set, map.force(), &u);
                assert!(error.abs() < 1e-11, "{name}, {motion}, {compliance}: {error:e}");
                let expected = differences(law.as_ref(), compliance, set, &u, 1e-5);
                let error = (map.jacobian() - expected).abs().max();
                assert!(error < 1e-7, "{name}, {motion}, {compliance}: Jacobian {error:e}");
            }
        }
    }
}

#[test]
fn iwan_loops_obey_masing() {
    // The loop's tip lies on the initial loading curve of twenty sliders; its area is that of the sliders passed.
    let law = Iwan::new(2.0, 1.0 / LOAD, -0.5, 1.0, 20, IwanSpacing::Geometric { growth: 1.2 }).unwrap();
    let mut sliders = Vec::new();
    assert!(law.sliders(LOAD, &mut sliders));
    for amplitude in [0.1, 0.5, 0.9, 2.0] {
        let cycle = contact_cycle(&law, LOAD, 1.0, &[amplitude, 0.0], HarmonicSet::odd(1)).unwrap();
        let initial: f64 = sliders.iter().map(|slider| slider.step(0.0, amplitude).0).sum();
        assert!((cycle.summary.equivalent_stiffness * amplitude / initial - 1.0).abs() < 1e-13);
        let slip = |s: &Slider| s.upper_limit * (amplitude - s.upper_limit / s.stiffness).max(0.0);
        let area: f64 = 4.0 * sliders.iter().map(slip).sum::<f64>();
        assert!((cycle.summary.dissipated_energy / area - 1.0).abs() < 1e-12, "{amplitude}");
    }
}

#[test]
fn hundreds_of_sliders_are_the_sum_of_each() {
    let sliders: Vec<_> =
        (1..=256).map(|i| Slider::jenkins(0.01 * f64::from(i), 2e-5 * f64::from(i * i))).collect();
    let u = motions()[2].1;
    let set = HarmonicSet::full(5);
    let mut sum = vec![0.0; set.len()];
    for one in &sliders {
        let map = evaluated(&Sliders(vec![*one]), 0.0, set, &u);
        sum.iter_mut().zip(map.force()).for_each(|(s, f)| *s += f);
    }
    let all = Sliders(sliders);
    // The stiffness of all is 329: so stiff a spring behind them changes the force by that fraction.
    for compliance in [0.0, 1e-12] {
        let together = evaluated(&all, compliance, set, &u);
        let error = largest(sum.iter().zip(together.force()).map(|(a, b)| a - b));
        assert!(
            error < 2.0 * 329.0 * compliance * largest(sum.iter().copied()) + 1e-11,
            "{compliance}: {error:e}"
        );
    }
}

/// A knee between the nodes of a panel, which three Legendre coefficients alone happened to miss.
#[test]
fn a_sharp_valanis_contact_dissipates_the_work_done_on_it() {
    let set = HarmonicSet::full(5);
    let mut u = [0.0; 11];
    (u[4], u[7], u[9]) = (4.598_06e-4, 1.352_97e-5, 1.252_98e-6);
    for smoothness in [0.95, 0.971_445_66, 0.98] {
        let law = Valanis::from_lambda(7.9e6, 0.0, smoothness, 8.7e4, LOAD).unwrap();
        for compliance in (0..400).map(|i| 6e-7 + 5e-10 * f64::from(i)) {
            let mut map = evaluated(&law, compliance, set, &u);
            let size = largest(map.force().iter().copied()) * largest(u);
            let error = map.summary().dissipated_energy - work(set, map.force(), &u);
            assert!(error.abs() <= 1e-8 * size, "{smoothness}, {compliance:e}: {error:e} of {size:e}");
        }
    }
}

/// Memory that fades slowly beside a displacement by which the force is known in large numbers.
#[test]
fn a_small_vibration_far_from_the_origin_has_a_periodic_state() {
    let law = Valanis::from_lambda(7.9e6, 0.0, 0.0, 8.7e4, LOAD).unwrap();
    let mut u = [0.0; 11];
    (u[0], u[7]) = (3.1e-3, -1e-14);
    let map = evaluated(&law, 0.0, HarmonicSet::full(5), &u);
    // All mean force fades away.
    assert!(map.force()[0].abs() < 1e-4 * law.limit(LOAD), "{}", map.force()[0]);
}

fn any_slider() -> impl Strategy<Value = Slider> {
    let limit = || prop_oneof![2 => 0.01..2.0, 1 => Just(f64::INFINITY), 1 => Just(0.0)];
    let play = || prop_oneof![2 => Just(0.0), 1 => 0.0..0.5];
    (0.1..5.0, play(), play(), limit(), limit(), any::<bool>()).prop_map(
        |(k, below, above, low, up, even)| {
            if even { slider(k, (-above, above), (up, up)) } else { slider(k, (-below, above), (low, up)) }
        },
    )
}

fn any_motion() -> impl Strategy<Value = Vec<f64>> {
    let scale = prop_oneof![Just(1.0), Just(1e-3), Just(1e-9), Just(0.0)];
    (proptest::collection::vec((-1.0..1.0_f64, scale), 11), 0.0..2.0).prop_map(
        |(pairs, decay): (Vec<(f64, f64)>, f64)| {
            let falls = |i: usize| (-decay * i.div_ceil(2) as f64).exp();
            pairs.iter().enumerate().map(|(i, (x, scale))| x * scale * falls(i)).collect()
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn sliders_dissipate_the_work_done_on_them(
        sliders in proptest::collection::vec(any_slider(), 1..5),
        u in any_motion(),
        compliance in prop_oneof![Just(0.0), 0.0..0.5],
    ) {
        let set = HarmonicSet::full(5);
        let law = Sliders(sliders);
        let mut map = evaluated(&law, compliance, set, &u);
        let summary = map.summary();
        prop_assert!(summary.dissipated_energy >= 0.0);
        let error = summary.dissipated_energy - work(set, map.force(), &u);
        prop_assert!(error.abs() < 1e-11, "{error:e} of {:e}", summary.dissipated_energy);
        prop_assert!(map.jacobian().iter().all(|x| x.is_finite()));
        let stick = summary.stick_fraction.unwrap();
        prop_assert!((0.0..=1.0).contains(&stick));
    }

    #[test]
    fn odd_motions_are_the_same_on_both_sets(
        sliders in proptest::collection::vec(any_slider(), 1..5),
        u in any_motion(),
        compliance in prop_oneof![Just(0.0), 0.0..0.5],
    ) {
        let (odd, full) = (HarmonicSet::odd(5), HarmonicSet::full(5));
        let law = Sliders(sliders);
        // Behind a spring lopsided sliders remember the way they were loaded, upwards or downwards first; both
        // are equally far.
        let compliance = if law.is_odd() { compliance } else { 0.0 };
        let mut wide = vec![0.0; 11];
        odd.convert(&u[..6], full, &mut wide);
        let a = evaluated(&law, compliance, odd, &u[..6]);
        let b = evaluated(&law, compliance, full, &wide);
        let mut back = vec![0.0; 6];
        full.convert(b.force(), odd, &mut back);
        let error = largest(back.iter().zip(a.force()).map(|(a, b)| a - b));
        prop_assert!(error < 1e-9, "{error:e}");
    }

    #[test]
    fn valanis_dissipates_the_work_done_on_it(
        u in any_motion(),
        exponent in -12.0..-2.0_f64,
        smoothness in prop_oneof![Just(0.0), 0.0..0.98],
        residual in prop_oneof![Just(0.0), 0.0..5e6],
        compliance in prop_oneof![Just(0.0), 0.0..1e-6],
    ) {
        let law = Valanis::from_lambda(7.9e6, residual, smoothness, 8.7e4, LOAD).unwrap();
        let set = HarmonicSet::full(5);
        let u: Vec<f64> = u.iter().map(|x| x * 10f64.powf(exponent)).collect();
        let mut map = evaluated(&law, compliance, set, &u);
        let dissipated = map.summary().dissipated_energy;
        prop_assert!(dissipated >= 0.0);
        let size = largest(map.force().iter().copied()) * largest(u.iter().copied());
        let error = dissipated - work(set, map.force(), &u);
        // Memory that a period fades by less than 1e-9 counts as unfading.
        prop_assert!(error.abs() <= 1e-8 * size, "{error:e} of {size:e}");
    }
}
