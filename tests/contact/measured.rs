//! The measured map: a tabulated loading curve.

use stickslip::contact::{ContactLaw, Measured};

use crate::common::contact::{LOAD, go};

/// Falls of the slope (N/m) at the knots of a range (m), and the law of them.
fn table() -> ([f64; Measured::KNOTS], f64, Measured) {
    let falls = [0.0, 2e5, 0.0, 1e6, 3e6, 0.0, 2e5, 5e5, 0.0, 0.0, 2e4, 1e4];
    let range = 80e-6;
    let [stiffness, friction, kept @ ..] = Measured::values_of(&falls, range, LOAD).unwrap();
    (falls, range, Measured::new(stiffness, friction, &kept).unwrap())
}

#[test]
fn values_and_table_say_the_same() {
    let (falls, range, law) = table();
    assert!((law.range(LOAD) / range - 1.0).abs() < 1e-9);
    let mut state = vec![0.0; law.state_len()];
    law.set_state(0.0, LOAD, 0.0, &mut state);
    // Loading and, from its end, unloading: the same curve at twice its size.
    let curve = |u: f64| -> f64 {
        falls.iter().zip(Measured::knots()).map(|(fall, knot)| fall * u.min(knot * range)).sum()
    };
    for part in [0.01, 0.05, 0.3, 0.9, 1.0] {
        let force = go(&law, &mut state, part * range, LOAD).force;
        assert!((force / curve(part * range) - 1.0).abs() < 1e-9, "{force}");
    }
    for part in [0.02, 0.3, 0.7, 1.0] {
        let force = go(&law, &mut state, (1.0 - 2.0 * part) * range, LOAD).force;
        let expected = curve(range) - 2.0 * curve(part * range);
        assert!((force - expected).abs() < 1e-9 * curve(range), "{force} {expected}");
    }
}

#[test]
fn beyond_its_range_the_force_stays_and_under_another_load_all_is_in_proportion() {
    let (_, range, law) = table();
    let at = |displacement: f64, load: f64| {
        let mut state = vec![0.0; law.state_len()];
        law.set_state(0.0, load, 0.0, &mut state);
        go(&law, &mut state, displacement, load).force
    };
    assert!((at(3.0 * range, LOAD) - law.limit(LOAD)).abs() < 1e-9 * law.limit(LOAD));
    assert!((at(range, LOAD) - law.limit(LOAD)).abs() < 1e-9 * law.limit(LOAD));
    assert!((at(0.1 * range, 2.0 * LOAD) / at(0.05 * range, LOAD) - 2.0).abs() < 1e-9);
    assert_eq!(law.range(2.0 * LOAD), 2.0 * law.range(LOAD));
}

#[test]
fn a_table_that_nothing_resists_is_none() {
    assert_eq!(Measured::values_of(&[0.0; Measured::KNOTS], 1e-5, LOAD), None);
    assert!(Measured::new(1e6, 0.5, &[1.5; Measured::KNOTS - 1]).is_err());
}
