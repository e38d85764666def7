//! Time integration refuses what it cannot do with an error, and leaves the motion as it was.

use crate::common::time::{held, one_mode, steel_beam, tolerance};
use stickslip::contact::{ContactLaw, Inputs, Jenkins, Response, SlipState, StateTangents, Tangents};
use stickslip::time::{BeamError, BeamInputs, BeamIntegrator, Contact, IntegrationError, Ramp, Settings};

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
    let mut integrator = BeamIntegrator::new(&steel_beam(2, 0.003)).unwrap();
    let mut motion = integrator.rest(Some((&law, 150.0)));
    integrator.advance(&mut motion, 1e-3, &held(5.0, &law, 150.0), &Settings::default()).unwrap();
    let before = motion.clone();
    let settings = Settings::default();
    let mut out = integrator.new_outputs();
    for (name, duration, inputs, settings) in [
        ("excitation", 1e-3, held(f64::NAN, &law, 150.0), settings),
        ("normal_load", 1e-3, held(5.0, &law, f64::INFINITY), settings),
        ("duration", 0.0, held(5.0, &law, 150.0), settings),
        ("duration", -1e-3, held(5.0, &law, 150.0), settings),
        ("duration", f64::NAN, held(5.0, &law, 150.0), settings),
        ("tolerance", 1e-3, held(5.0, &law, 150.0), tolerance(f64::NAN)),
        ("tolerance", 1e-3, held(5.0, &law, 150.0), tolerance(0.0)),
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
    let force = BeamInputs {
        excitation: Ramp::held(0.0),
        contact: Contact::Force(Ramp { start: 0.0, end: f64::NEG_INFINITY }),
        at_points: &[],
    };
    let error = integrator.advance(&mut motion, 1e-3, &force, &settings).unwrap_err();
    assert!(error.to_string().contains("contact_force"), "{error}");
}

#[test]
fn too_little_work_allowed_is_an_error_and_changes_nothing() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut integrator = BeamIntegrator::new(&steel_beam(6, 0.003)).unwrap();
    let mut motion = integrator.rest(Some((&law, 150.0)));
    let before = motion.clone();
    let settings = Settings { tolerance: 1e-9, step_limit: 3 };
    let error = integrator.advance(&mut motion, 1.0, &held(50.0, &law, 150.0), &settings).unwrap_err();
    assert!(matches!(error, IntegrationError::TooManySteps { limit: 3, .. }), "{error}");
    assert_eq!(motion, before);
}

#[test]
fn a_law_that_fails_stops_with_an_error_and_changes_nothing() {
    let mut integrator = BeamIntegrator::new(&steel_beam(3, 0.003)).unwrap();
    let mut motion = integrator.rest(Some((&Broken, 150.0)));
    let before = motion.clone();
    let error =
        integrator.advance(&mut motion, 1e-2, &held(50.0, &Broken, 150.0), &Settings::default()).unwrap_err();
    assert!(matches!(error, IntegrationError::StepTooSmall { time, .. } if time > 0.0), "{error}");
    assert_eq!(motion, before);
}

#[test]
fn a_motion_of_another_beam_or_law_is_refused() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut small = BeamIntegrator::new(&steel_beam(2, 0.003)).unwrap();
    let mut large = BeamIntegrator::new(&steel_beam(3, 0.003)).unwrap();
    let mut motion = small.rest(Some((&law, 150.0)));
    let error = large.advance(&mut motion, 1e-3, &held(5.0, &law, 150.0), &Settings::default()).unwrap_err();
    assert!(matches!(error, IntegrationError::MotionLength { .. }), "{error}");
    let mut without = small.rest(None);
    let error = small.advance(&mut without, 1e-3, &held(5.0, &law, 150.0), &Settings::default()).unwrap_err();
    assert!(matches!(error, IntegrationError::MotionLength { .. }), "{error}");

    let mut state = motion.state().to_vec();
    state[1] = f64::NAN;
    assert!(motion.read_state(&state));
    let error = small.advance(&mut motion, 1e-3, &held(5.0, &law, 150.0), &Settings::default()).unwrap_err();
    assert_eq!(error, IntegrationError::MotionNotFinite { index: 1 });
}

#[test]
fn beams_that_make_no_sense_are_refused_by_field() {
    let field = |change: &dyn Fn(&mut stickslip::system::ModalBeam)| {
        let mut beam = steel_beam(2, 0.003);
        change(&mut beam);
        BeamIntegrator::new(&beam).unwrap_err()
    };
    let length = |error| match error {
        BeamError::Length { field, .. } => field,
        other => panic!("{other:?}"),
    };
    let value = |error| match error {
        BeamError::Value { field, .. } => field,
        other => panic!("{other:?}"),
    };
    assert_eq!(length(field(&|b| b.angular_frequency.clear())), "angular_frequency");
    assert_eq!(length(field(&|b| b.damping_ratio.push(0.1))), "damping_ratio");
    assert_eq!(length(field(&|b| b.shortening.truncate(3))), "shortening");
    assert_eq!(length(field(&|b| b.sensors[0].shape.clear())), "sensor shape");
    assert_eq!(value(field(&|b| b.angular_frequency[1] = -1.0)), "angular_frequency");
    assert_eq!(value(field(&|b| b.contact_shape[0] = f64::NAN)), "contact_shape");
    assert_eq!(value(field(&|b| b.axial_flexibility = -1e-9)), "axial_flexibility");
    let asymmetric = field(&|b| b.shortening[1] *= 1.01);
    assert_eq!(asymmetric, BeamError::Asymmetric { row: 1, column: 0 });
    assert_eq!(
        length(
            BeamIntegrator::new(&steel_beam(2, 0.0)).unwrap().moving(&[0.0], &[0.0; 2], None).unwrap_err()
        ),
        "modal displacement"
    );
}

#[test]
fn a_start_beyond_the_limit_is_cut_to_it() {
    let law = Jenkins::new(7.9e6, 0.6).unwrap();
    let mut beam = one_mode(330.0, 0.003, 0.06, 1.2, 1e-7);
    beam.shortening[0] = 20.0;
    let mut integrator = BeamIntegrator::new(&beam).unwrap();
    let motion = integrator.moving(&[1e-3], &[0.0], Some((&law, 150.0, 500.0))).unwrap();
    assert!((motion.contact_force() - 90.0).abs() < 1e-9);
    let displacement = 0.06e-3 - 0.5 * 20.0 * 1e-6 - 1e-7 * 90.0;
    assert!((motion.displacement() - displacement).abs() < 1e-16);
}
