//! Work that is asked to end keeps what it has found.

use std::sync::atomic::{AtomicUsize, Ordering};

use stickslip::contact::Jenkins;
use stickslip::harmonic::{
    Assembly, Control, CurveSettings, Ending, HarmonicError, Interrupt, ModeRange, TrackedQuantity, Tracking,
    frequency_response, nonlinear_mode, periodic_response, track_levels,
};

use crate::common::oscillator::{in_contact, two_masses};

/// Looks that are left until the work is asked to end.
static LEFT: AtomicUsize = AtomicUsize::new(0);

fn asked() -> bool {
    LEFT.fetch_update(Ordering::SeqCst, Ordering::SeqCst, |left| left.checked_sub(1)).is_err()
}

fn slider() -> Assembly {
    in_contact(&two_masses(0.01), Jenkins::new(0.2, 0.05).unwrap())
}

/// Settings under which the work is asked to end after so many looks.
fn after(looks: usize) -> CurveSettings {
    LEFT.store(looks, Ordering::SeqCst);
    CurveSettings { interrupt: Some(Interrupt(asked)), ..CurveSettings::default() }
}

/// One test, since what is asked is one number.
#[test]
fn what_was_found_before_an_interrupt_is_kept() {
    let system = slider();
    let force = Control::Level(0.4);
    // Before the first point there is nothing to keep.
    for looks in [0, 1] {
        let curve = frequency_response(&system, 0.2, 2.0, &force, &after(looks), &mut |_| true);
        assert_eq!(curve.unwrap_err(), HarmonicError::Interrupted);
    }
    assert_eq!(
        periodic_response(&system, 0.6, &force, &after(1), None).unwrap_err(),
        HarmonicError::Interrupted
    );
    // Then the points are: the more of them the later it was asked, and none is asked for after that.
    let mut before = 0;
    for looks in [20, 200, 500] {
        let curve = frequency_response(&system, 0.2, 2.0, &force, &after(looks), &mut |_| true).unwrap();
        assert_eq!(curve.ending, Ending::Interrupted);
        assert!(curve.points.len() > before, "{} points after {looks} looks", curve.points.len());
        before = curve.points.len();
    }
    let tracking = Tracking { quantity: TrackedQuantity::Phase, node: 0, angular_frequency: 0.6 };
    let levels: Vec<f64> = (1..200).map(|k| 0.01 * k as f64).collect();
    let curve = track_levels(&system, &tracking, &levels, &after(100), &mut |_| true).unwrap();
    assert!(curve.ending == Ending::Interrupted && !curve.points.is_empty());
    let range = ModeRange { mode: 0, node: 1, amplitudes: [1e-3, 10.0], points: 200 };
    let mode = nonlinear_mode(&system, &range, &after(100), &mut |_| true).unwrap();
    assert!((1..200).contains(&mode.points.len()) && mode.lost.is_none());
}
