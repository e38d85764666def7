//! Time integration refuses what it cannot do with an error, and leaves the motion as it was.

use stickslip::contact::{ContactLaw, Inputs, Jenkins, Response, SlipState, StateTangents, Tangents};
use stickslip::system::StructureError;
use stickslip::time::{IntegrationError, Integrator, Outputs, Ramp, Settings, SystemError};

use crate::common::beam::{one_mode, steel_beam};
use crate::common::time::{at_end, held, loaded, rest, supported, tolerance};

/// A law whose force is not a number beyond a displacement.
#[derive(Debug)]
struct Broken;

impl ContactLaw for Broken {
    fn state_len(&self) -> usize {
        1
    }
    fn set_state(&self, displacement: f64, _: f64, _: f64, state: &mut [f64]) {
        state[0] = displacement;
    }
    fn step(&self, _: &[f64], inputs: Inputs, next: &mut [f64]) -> Response {
        next[0] = inputs.displacement;
        Response {
            force: if inputs.displacement.abs() > 1e-6 { f64::NAN } else { 0.0 },
            tangents: Tangents::default(),
            dissipated_energy: 0.0,
            slip_state: SlipState::Stick,
        }
    }
    fn state_tangents(&self, _: &[f64], _: Inputs, _: &mut StateTangents) {}
    fn limit(&self, _: f64) -> f64 {
        1.0
    }
}

#[test]
fn inputs_that_are_no_numbers_are_named_and_change_nothing() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut integrator = supported(&steel_beam(2, 0.003), law, 150.0);
    let mut motion = rest(&mut integrator);
    integrator.advance(&mut motion, 1e-3, &held(5.0, 150.0), &Settings::default()).unwrap();
    let before = motion.clone();
    let settings = Settings::default();
    let mut out = Outputs::default();
    for (name, duration, inputs, settings) in [
        ("excitation", 1e-3, held(f64::NAN, 150.0), settings),
        ("normal_load", 1e-3, held(5.0, f64::INFINITY), settings),
        ("duration", 0.0, held(5.0, 150.0), settings),
        ("duration", -1e-3, held(5.0, 150.0), settings),
        ("duration", f64::NAN, held(5.0, 150.0), settings),
        ("tolerance", 1e-3, held(5.0, 150.0), tolerance(f64::NAN)),
        ("tolerance", 1e-3, held(5.0, 150.0), tolerance(0.0)),
    ] {
        match integrator.advance(&mut motion, duration, &inputs, &settings) {
            Err(IntegrationError::Input { name: found, .. }) => assert_eq!(found, name),
            other => panic!("{name}: {other:?}"),
        }
        assert_eq!(motion, before, "{name}");
        if name != "tolerance" {
            assert!(integrator.outputs(&motion, duration, &inputs, &mut out).is_err(), "{name}");
        }
    }
    let mut integrator = loaded(&steel_beam(2, 0.003));
    let mut motion = rest(&mut integrator);
    let inputs = [Ramp::held(0.0), Ramp::line(0.0, f64::NEG_INFINITY)];
    let error = integrator.advance(&mut motion, 1e-3, &inputs, &settings).unwrap_err();
    assert!(error.to_string().contains("contact_force"), "{error}");
}

#[test]
fn too_little_work_allowed_is_an_error_and_changes_nothing() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut integrator = supported(&steel_beam(6, 0.003), law, 150.0);
    let mut motion = rest(&mut integrator);
    let before = motion.clone();
    let settings = Settings { tolerance: 1e-9, step_limit: 3 };
    let error = integrator.advance(&mut motion, 1.0, &held(50.0, 150.0), &settings).unwrap_err();
    assert!(matches!(error, IntegrationError::TooManySteps { limit: 3, .. }), "{error}");
    assert_eq!(motion, before);
}

#[test]
fn a_law_that_fails_stops_with_an_error_and_changes_nothing() {
    let mut integrator = supported(&steel_beam(3, 0.003), Broken, 150.0);
    let mut motion = rest(&mut integrator);
    let before = motion.clone();
    let error = integrator.advance(&mut motion, 1e-2, &held(50.0, 150.0), &Settings::default()).unwrap_err();
    assert!(matches!(error, IntegrationError::StepTooSmall { time, .. } if time > 0.0), "{error}");
    assert_eq!(motion, before);
}

#[test]
fn a_motion_of_another_beam_or_law_is_refused() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut small = supported(&steel_beam(2, 0.003), law, 150.0);
    let mut large = supported(&steel_beam(3, 0.003), law, 150.0);
    let mut motion = rest(&mut small);
    let error = large.advance(&mut motion, 1e-3, &held(5.0, 150.0), &Settings::default()).unwrap_err();
    assert!(matches!(error, IntegrationError::MotionLength { .. }), "{error}");
    let mut without = rest(&mut loaded(&steel_beam(2, 0.003)));
    let error = small.advance(&mut without, 1e-3, &held(5.0, 150.0), &Settings::default()).unwrap_err();
    assert!(matches!(error, IntegrationError::MotionLength { .. }), "{error}");

    let mut state = motion.state().to_vec();
    state[1] = f64::NAN;
    assert!(motion.read_state(&state));
    let error = small.advance(&mut motion, 1e-3, &held(5.0, 150.0), &Settings::default()).unwrap_err();
    assert_eq!(error, IntegrationError::MotionNotFinite { index: 1 });
}

#[test]
fn beams_that_make_no_sense_are_refused_by_field() {
    let system = |change: &dyn Fn(&mut stickslip::system::ModalBeam)| {
        let mut beam = steel_beam(2, 0.003);
        change(&mut beam);
        beam.system(None)
    };
    let length = |change: &dyn Fn(&mut stickslip::system::ModalBeam)| match system(change).unwrap_err() {
        StructureError::Entries { field, .. } => field,
        other => panic!("{other:?}"),
    };
    let refused = |change: &dyn Fn(&mut stickslip::system::ModalBeam)| {
        Integrator::new(&system(change).unwrap()).unwrap_err()
    };
    let value = |change: &dyn Fn(&mut stickslip::system::ModalBeam)| match refused(change) {
        SystemError::Value { field, .. } => field,
        other => panic!("{other:?}"),
    };
    assert_eq!(length(&|b| b.angular_frequency.clear()), "angular_frequency");
    assert_eq!(length(&|b| b.damping_ratio.push(0.1)), "damping_ratio");
    assert_eq!(length(&|b| b.shortening.truncate(3)), "shortening");
    assert_eq!(length(&|b| b.sensors[0].shape.clear()), "sensor shape");
    assert_eq!(value(&|b| b.angular_frequency[1] = -1.0), "angular_frequency");
    assert_eq!(value(&|b| b.contact_shape[0] = f64::NAN), "port contact");
    assert_eq!(value(&|b| b.axial_flexibility = -1e-9), "flexibility of port contact");
    let asymmetric = refused(&|b| b.shortening[1] *= 1.01);
    assert_eq!(asymmetric, SystemError::Asymmetric { field: "shortening", row: 1, column: 0 });
    let moving = loaded(&steel_beam(2, 0.0)).moving(&[0.0], &[0.0; 2], &held(0.0, 0.0), &[]);
    assert_eq!(moving.unwrap_err(), IntegrationError::MotionLength { expected: 2, found: 1 });
}

#[test]
fn a_start_beyond_the_limit_is_cut_to_it() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut beam = one_mode(330.0, 0.003, 0.06, 1.2, 1e-7);
    beam.shortening[0] = 20.0;
    let mut integrator = supported(&beam, law, 150.0);
    let motion = integrator.moving(&[1e-3], &[0.0], &held(0.0, 150.0), &[500.0]).unwrap();
    assert!((at_end(&motion).force - 90.0).abs() < 1e-9);
    let displacement = 0.06e-3 - 0.5 * 20.0 * 1e-6 - 1e-7 * 90.0;
    assert!((at_end(&motion).displacement - displacement).abs() < 1e-16);
}
