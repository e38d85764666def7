//! Floquet multipliers of periodic responses against closed forms, Mathieu's equation, Duffing's folds and the
//! monodromy of shooting.

use std::f64::consts::TAU;

use nalgebra::{Complex, DMatrix, DVector};
use stickslip::contact::JointChanges;
use stickslip::contact::{ContactLaw, CubicSpring, Jenkins, Joint, ParallelSliders, Unilateral, Valanis};
use stickslip::harmonic::fourier::from_samples;
use stickslip::harmonic::stability::{Multipliers, Undecided, decide, floquet};
use stickslip::time::{Excitation, LoadedContact, OscillatorFlow, ShootingSettings, shoot};

use crate::common::oscillator::{chain, single, two_masses};

fn attached(law: &dyn ContactLaw) -> LoadedContact<'_> {
    LoadedContact { law, normal_load: 1.0 }
}

/// Multipliers `exp(λT)` of one mass with viscous damping.
fn assert_linear(found: &Multipliers, damping: f64, stiffness: f64, period: f64, tolerance: f64) {
    let root = Complex::new(0.25 * damping * damping - stiffness, 0.0).sqrt();
    for sign in [1.0, -1.0] {
        let expected = ((root * sign - 0.5 * damping) * period).exp();
        let nearest = found.values.iter().map(|m| (m - expected).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < tolerance, "{expected} not among {:?}", found.values);
    }
}

#[test]
fn a_linear_system_has_the_multipliers_of_its_eigenvalues() {
    let omega = 1.3;
    let displacement: &[f64] = &[0.0, 0.4, 0.2];
    let structure = single(1.0, 0.06, 1.0, 1);
    let spring = CubicSpring::new(0.7, 0.0).unwrap();
    let found = floquet(&structure, &[attached(&spring)], &[displacement], omega).unwrap();
    assert_linear(&found, 0.06, 1.7, TAU / omega, 1e-9);
    let stuck = Jenkins::new(0.7, 5.0).unwrap();
    let found = floquet(&structure, &[attached(&stuck)], &[displacement], omega).unwrap();
    assert_linear(&found, 0.06, 1.7, TAU / omega, 1e-13);
    // A contact that slips nearly always: two short sticking stretches are all that differs.
    let sliding = Jenkins::new(0.7, 1e-9).unwrap();
    let found = floquet(&structure, &[attached(&sliding)], &[displacement], omega).unwrap();
    assert_linear(&found, 0.06, 1.0, TAU / omega, 1e-3);
    assert!(found.stable());
}

#[test]
fn multipliers_do_not_depend_on_where_the_period_begins() {
    let structure = single(1.0, 0.1, 1.0, 1);
    let law = Jenkins::new(0.4, 0.1).unwrap();
    let multipliers = |shift: f64| {
        let displacement = [0.0, shift.cos(), shift.sin()];
        floquet(&structure, &[attached(&law)], &[&displacement], 0.8).unwrap()
    };
    let reference = multipliers(0.7).values;
    // With a turning point at phase zero, to the last digit and nearly, and at its opposite.
    for shift in [0.0, 1e-16, -1e-16, 1e-12, 0.5 * TAU, 2.0] {
        let found = multipliers(shift).values;
        for expected in &reference {
            let nearest = found.iter().map(|m| (m - expected).norm()).fold(f64::INFINITY, f64::min);
            assert!(nearest < 1e-9, "{shift}: {expected} not among {found:?}");
        }
    }
}

#[test]
fn a_contact_that_sticks_beside_a_smooth_one_is_a_spring() {
    let (hardening, stuck) = (CubicSpring::new(0.5, 0.1).unwrap(), Jenkins::new(0.5, 100.0).unwrap());
    let linear = CubicSpring::new(0.0, 0.1).unwrap();
    let displacement: &[f64] = &[0.0, 0.3, 0.1];
    let alone = floquet(&single(1.0, 0.1, 1.0, 1), &[attached(&hardening)], &[displacement], 0.9).unwrap();
    let contacts = [attached(&linear), attached(&stuck)];
    let beside = floquet(&single(1.0, 0.1, 1.0, 2), &contacts, &[displacement; 2], 0.9).unwrap();
    assert!(alone.stable() && beside.stable(), "{:?}", beside.values);
    for multiplier in &alone.values {
        let nearest = beside.values.iter().map(|m| (m - multiplier).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-8, "{multiplier} not among {:?}", beside.values);
    }
}

/// `Π (μᵢ − 1)` over all multipliers: zero where a periodic solution turns round or branches, and smooth along a curve,
/// where single multipliers are not.
fn fold_function(multipliers: &Multipliers) -> f64 {
    multipliers.values.iter().map(|multiplier| multiplier - 1.0).product::<Complex<f64>>().re
}

/// `ÿ + (a − 2q cos 2t) y = 0` as a cubic spring along `u = A sin t`.
fn mathieu(a: f64, q: f64) -> Multipliers {
    let law = CubicSpring::new(0.0, 4.0 * q / 3.0).unwrap();
    floquet(&single(1.0, 0.0, a - 2.0 * q, 1), &[attached(&law)], &[&[0.0, 0.0, 1.0]], 1.0).unwrap()
}

/// Characteristic values from tables (Abramowitz & Stegun, 20.4).
#[test]
fn mathieu_equation_changes_its_stability_at_its_characteristic_values() {
    for (a, q) in
        [(1.859_108_072_514_363_4, 1.0), (-0.110_248_816_992_097_1, 1.0), (3.917_024_772_998_471, 1.0)]
    {
        let at = mathieu(a, q);
        assert!(fold_function(&at).abs() < 1e-8, "a = {a}: {:?}", at.values);
    }
    let largest = |a| mathieu(a, 1.0).values[0];
    assert!(largest(1.0).re > 1.1, "between b1 and a1: {}", largest(1.0));
    assert!((largest(2.5).norm() - 1.0).abs() < 1e-9, "between a1 and b2: {}", largest(2.5));
    assert!(largest(4.1).re > 1.001, "between b2 and a2: {}", largest(4.1));
}

const ZETA: f64 = 0.05;
const CUBIC: f64 = 0.5;
const FORCE: f64 = 0.3;
const ORDERS: [usize; 8] = [1, 3, 5, 7, 9, 11, 13, 15];
const SAMPLES: usize = 96;

/// Harmonic balance of Duffing's oscillator at a given phase lag of the first harmonic: coefficients of the
/// odd harmonics, and the frequency as last unknown.
fn duffing(lag: f64, x: &mut DVector<f64>) {
    let m = 2 * ORDERS.len();
    let basis = |k: usize, j: usize| {
        let angle = TAU * (k * ORDERS[j / 2] % SAMPLES) as f64 / SAMPLES as f64;
        if j.is_multiple_of(2) { angle.cos() } else { angle.sin() }
    };
    for _ in 0..60 {
        let (mut residual, mut jacobian) = (DVector::zeros(m + 1), DMatrix::zeros(m + 1, m + 1));
        let omega = x[m];
        for (i, order) in ORDERS.iter().enumerate() {
            let (c, s, h) = (2 * i, 2 * i + 1, *order as f64);
            let (inertia, damper) = (1.0 - h * h * omega * omega, 2.0 * ZETA * h * omega);
            residual[c] = inertia * x[c] + damper * x[s];
            residual[s] = inertia * x[s] - damper * x[c];
            jacobian[(c, c)] = inertia;
            jacobian[(c, s)] = damper;
            jacobian[(s, c)] = -damper;
            jacobian[(s, s)] = inertia;
            jacobian[(c, m)] = -2.0 * h * h * omega * x[c] + 2.0 * ZETA * h * x[s];
            jacobian[(s, m)] = -2.0 * h * h * omega * x[s] - 2.0 * ZETA * h * x[c];
        }
        residual[0] -= FORCE;
        for k in 0..SAMPLES {
            let basis: Vec<f64> = (0..m).map(|j| basis(k, j)).collect();
            let q: f64 = x.iter().zip(&basis).map(|(x, b)| x * b).sum();
            for i in 0..m {
                let weight = 2.0 / SAMPLES as f64 * basis[i];
                residual[i] += weight * CUBIC * q * q * q;
                for j in 0..m {
                    jacobian[(i, j)] += weight * 3.0 * CUBIC * q * q * basis[j];
                }
            }
        }
        residual[m] = x[0] * lag.sin() - x[1] * lag.cos();
        (jacobian[(m, 0)], jacobian[(m, 1)]) = (lag.sin(), -lag.cos());
        let step = jacobian.lu().solve(&residual).unwrap();
        *x -= &step;
        if step.amax() < 1e-13 {
            return;
        }
    }
    panic!("no balance at phase {lag}");
}

fn full(x: &DVector<f64>) -> Vec<f64> {
    let mut out = vec![0.0; 2 * ORDERS[ORDERS.len() - 1] + 1];
    for (i, order) in ORDERS.iter().enumerate() {
        out[2 * order - 1] = x[2 * i];
        out[2 * order] = x[2 * i + 1];
    }
    out
}

/// The phase lag grows all along the response curve; the frequency has its extremes at the folds, and
/// there a multiplier passes +1.
#[test]
fn a_multiplier_passes_one_at_the_folds_of_duffing() {
    const STEP: f64 = 0.05;
    let law = CubicSpring::new(0.0, CUBIC).unwrap();
    let structure = single(1.0, 2.0 * ZETA, 1.0, 1);
    let m = 2 * ORDERS.len();
    let mut x = DVector::zeros(m + 1);
    (x[0], x[1], x[m]) = (0.48, 0.05, 0.62);
    let multipliers = |lag: f64, x: &mut DVector<f64>| {
        duffing(lag, x);
        floquet(&structure, &[attached(&law)], &[&full(x)], x[m]).unwrap()
    };
    let slope = |lag: f64, x: &DVector<f64>| {
        let (h, mut up, mut down) = (1e-4, x.clone(), x.clone());
        duffing(lag + h, &mut up);
        duffing(lag - h, &mut down);
        (up[m] - down[m]) / (2.0 * h)
    };
    let bisect = |mut low: f64, mut high: f64, above: &dyn Fn(f64) -> bool| {
        let start = above(low);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if above(middle) == start { low = middle } else { high = middle }
        }
        low
    };
    let (mut folds, mut lag) = (vec![], 0.1);
    let mut before = multipliers(lag, &mut x);
    assert!(before.stable());
    while lag < 2.95 {
        lag += STEP;
        let here = multipliers(lag, &mut x);
        if here.stable() != before.stable() {
            let by_multiplier =
                bisect(lag - STEP, lag, &|at| fold_function(&multipliers(at, &mut x.clone())) > 0.0);
            let by_slope = bisect(lag - 1.5 * STEP, lag + 0.5 * STEP, &|at| slope(at, &x) > 0.0);
            assert!((by_multiplier / by_slope - 1.0).abs() < 1e-6, "{by_multiplier} {by_slope}");
            let mut at = x.clone();
            let multiplier = multipliers(by_multiplier, &mut at).values[0];
            assert!((multiplier - 1.0).norm() < 1e-6, "{multiplier}");
            folds.push(at[m]);
        }
        before = here;
    }
    assert!(before.stable(), "stable again beyond the second fold");
    assert_eq!(folds.len(), 2);
    assert!(folds[0] > folds[1] + 0.1, "a hardening spring leans to the right: {folds:?}");
}

/// Coefficients of the displacement of contact 0 in the periodic motion that shooting finds.
fn contact_displacement(
    flow: &mut OscillatorFlow,
    excitation: &Excitation,
    omega: f64,
    degree: usize,
    harmonics: usize,
) -> (Vec<f64>, Vec<Complex<f64>>) {
    let found = shoot(flow, excitation, None, &ShootingSettings::default()).unwrap();
    let mut motion = found.start.clone();
    let samples: Vec<f64> = (0..4096)
        .map(|_| {
            let u = flow.displacement(&motion)[degree];
            flow.advance(&mut motion, TAU / omega / 4096.0, excitation).unwrap();
            u
        })
        .collect();
    (from_samples(&samples, 1, harmonics), found.multipliers)
}

fn assert_same(found: &Multipliers, expected: &[Complex<f64>], tolerance: f64) {
    for expected in expected.iter().filter(|m| m.norm() > 1e-3) {
        let nearest = found.values.iter().map(|m| (m - expected).norm()).fold(f64::INFINITY, f64::min);
        assert!(nearest < tolerance, "{expected} is {nearest:e} away from all of {:?}", found.values);
    }
}

#[test]
fn sliders_have_the_multipliers_of_the_exact_flow() {
    let jenkins = Jenkins::new(0.2, 0.02).unwrap();
    let sliders = ParallelSliders::new(&[(0.1, 0.005), (0.1, 0.02), (0.1, 0.06)]).unwrap();
    for law in [&jenkins as &dyn ContactLaw, &sliders] {
        for omega in [0.5, 1.0, 1.3] {
            let contacts = [attached(law)];
            let mut flow = OscillatorFlow::new(&two_masses(0.1), &contacts).unwrap();
            let excitation = Excitation::cosine(omega, 0.4);
            let (u, expected) = contact_displacement(&mut flow, &excitation, omega, 1, 101);
            let found = floquet(&two_masses(0.1), &contacts, &[&u], omega).unwrap();
            assert_same(&found, &expected, 1e-5);
            assert_eq!(decide(&two_masses(0.1), &contacts, &[&u], omega), Ok(true));
        }
    }
}

#[test]
fn valanis_near_one_has_the_multipliers_of_its_limit_jenkins() {
    // κ → 1 is Jenkins: the way by tangents against the way by regimes.
    let omega = 1.0;
    let jenkins = Jenkins::new(0.2, 0.02).unwrap();
    let mut flow = OscillatorFlow::new(&two_masses(0.1), &[attached(&jenkins)]).unwrap();
    let (u, expected) = contact_displacement(&mut flow, &Excitation::cosine(omega, 0.4), omega, 1, 31);
    let mut errors = vec![];
    for smoothness in [0.9, 0.95] {
        let valanis = Valanis::new(0.2, 0.02, smoothness, 0.0).unwrap();
        let found = floquet(&two_masses(0.1), &[attached(&valanis)], &[&u], omega).unwrap();
        let worst = expected
            .iter()
            .filter(|m| m.norm() > 1e-3)
            .map(|expected| found.values.iter().map(|m| (m - expected).norm()).fold(f64::INFINITY, f64::min));
        errors.push(worst.fold(0.0, f64::max));
    }
    println!("{errors:?}");
    assert!(errors[1] < 0.6 * errors[0] && errors[1] < 0.02, "{errors:?}");
}

#[test]
fn structures_too_large_and_lists_that_do_not_fit_are_not_judged() {
    let law = Jenkins::new(1.0, 1.0).unwrap();
    let hardening = CubicSpring::new(1.0, 1.0).unwrap();
    let large = chain(61, 0.01);
    let u: &[f64] = &[0.0, 1.0, 0.0];
    assert_eq!(decide(&large, &[attached(&hardening); 2], &[u, u], 1.0), Err(Undecided::TooLarge));
    let small = chain(6, 0.01);
    assert_eq!(decide(&small, &[attached(&law)], &[u], 1.0), Err(Undecided::NotSettled));
    assert_eq!(decide(&small, &[attached(&law); 2], &[u, &[f64::NAN]], 1.0), Err(Undecided::NotSettled));
    assert_eq!(decide(&small, &[attached(&law); 2], &[u, u], 1.0), Ok(true));
    // Stuck throughout: the neutral positions of the sliders are not counted.
    let half: &[f64] = &[0.0, 0.5, 0.0];
    assert_eq!(decide(&small, &[attached(&law); 2], &[half, half], 1.0), Ok(true));
}

/// No disturbance of sliders without play grows where the structure gains energy nowhere.
#[test]
fn friction_on_a_passive_structure_is_stable_at_any_frequency_and_size() {
    let law = Jenkins::new(1.0, 0.1).unwrap();
    let u: &[f64] = &[0.0, 1.0, 0.2];
    for masses in [6, 61, 2000] {
        for omega in [1e-9, 1e-3, 1.0, 1e6] {
            assert_eq!(decide(&chain(masses, 0.01), &[attached(&law); 2], &[u, u], omega), Ok(true));
        }
    }
    // As the multipliers have it, which are computed in full.
    for omega in [0.2, 0.9] {
        assert!(floquet(&chain(6, 0.01), &[attached(&law); 2], &[u, u], omega).unwrap().stable());
    }
    let mut linear = chain(3, 0.0);
    linear.contacts.clear();
    assert_eq!(decide(&linear, &[], &[], 1e-6), Ok(true));
}

/// Where no slider changes its branch the poles tell: a spring of −0.5 N/m is held by one of 0.7 N/m, not by 0.2 N/m.
#[test]
fn a_stuck_contact_holds_what_would_fall_alone() {
    let u: &[f64] = &[0.0, 0.4, 0.2];
    let falling = single(1.0, 0.1, -0.5, 1);
    for (stiffness, stable) in [(0.7, true), (0.2, false)] {
        let stuck = Jenkins::new(stiffness, 5.0).unwrap();
        for omega in [1e-7, 1.0, 100.0] {
            assert_eq!(decide(&falling, &[attached(&stuck)], &[u], omega), Ok(stable), "{stiffness} {omega}");
        }
    }
    // A gap that stays open.
    let gap = Unilateral::new(50.0, 1.0).unwrap();
    assert_eq!(decide(&falling, &[attached(&gap)], &[u], 1e-7), Ok(false));
    assert_eq!(decide(&single(1.0, 0.1, 0.5, 1), &[attached(&gap)], &[u], 1e-7), Ok(true));
}

/// A body without ground drifts: two multipliers are one, and rounding must not make them more.
#[test]
fn a_floating_structure_does_not_flicker() {
    let mut floating = chain(3, 0.0);
    let pairs =
        |k: f64| vec![(0, 0, k), (0, 1, -k), (1, 0, -k), (1, 1, 2.0 * k), (1, 2, -k), (2, 1, -k), (2, 2, k)];
    (floating.stiffness, floating.damping) = (pairs(3.0), pairs(0.05));
    floating.contacts = vec![vec![(0, 1.0), (1, -1.0)]];
    let u: &[f64] = &[0.0, 0.4, 0.2];
    let sliding = Jenkins::new(0.7, 0.1).unwrap();
    let smooth = Valanis::new(0.2, 0.02, 0.5, 0.0).unwrap();
    let gap = Unilateral::new(0.5, 0.1).unwrap();
    for k in 1..=12 {
        let omega = 0.21 * f64::from(k);
        for law in [&sliding as &dyn ContactLaw, &smooth, &gap] {
            assert_eq!(decide(&floating, &[attached(law)], &[u], omega), Ok(true), "{omega}");
        }
    }
}

/// A long period costs a few squarings more; where it would cost steps without end, that is said.
#[test]
fn a_long_period_is_judged_or_called_too_long() {
    let u: &[f64] = &[0.0, 0.4, 0.2];
    let structure = chain(6, 0.01);
    let gap = Unilateral::new(0.5, 0.1).unwrap();
    for omega in [1e-2, 1e-4] {
        assert_eq!(decide(&structure, &[attached(&gap); 2], &[u, u], omega), Ok(true));
    }
    let hardening = CubicSpring::new(0.0, 0.1).unwrap();
    let found = decide(&structure, &[attached(&hardening); 2], &[u, u], 1e-6);
    assert_eq!(found, Err(Undecided::TooLong));
}

/// `exp(A t)` of one mass of 1 kg on a spring and a damper.
fn flow(stiffness: f64, damping: f64, time: f64) -> DMatrix<f64> {
    (DMatrix::from_row_slice(2, 2, &[0.0, 1.0, -stiffness, -damping]) * time).exp()
}

#[test]
fn a_damper_that_takes_hold_with_a_velocity_kicks_a_disturbance() {
    let (stiffness, damping, gap, amplitude, omega) = (0.5, 0.3, 0.4, 1.0, 0.8);
    let changes = JointChanges { half_gap: gap, damping, ..JointChanges::default() };
    let law = Joint::new(Jenkins::new(stiffness, 100.0).unwrap(), changes).unwrap();
    let structure = single(1.0, 0.05, 1.0, 1);
    let found = floquet(&structure, &[attached(&law)], &[&[0.0, amplitude, 0.0]], omega).unwrap();
    // From the turning point until the damper would pull, through the play, and from there to the other turning point.
    let (along, across) = (stiffness * amplitude, damping * omega * amplitude);
    let opens = (stiffness * gap / along.hypot(across)).acos() - across.atan2(along);
    let closes = (-gap / amplitude).acos();
    let closed = |phase: f64| flow(1.0 + stiffness, 0.05 + damping, phase / omega);
    let kick = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, -damping, 1.0]);
    let half = closed(std::f64::consts::PI - closes)
        * kick
        * flow(1.0, 0.05, (closes - opens) / omega)
        * closed(opens);
    let expected: Vec<_> = (&half * &half).complex_eigenvalues().iter().copied().collect();
    assert_same(&found, &expected, 1e-8);
}
