//! Inputs that the importer tells within a step.

use super::fixture::{Importer, Running};
use crate::calls::State;
use crate::ffi::{Bool, Handle, Status};
use crate::fmi3::lifecycle::{fmi3FreeInstance, fmi3Reset};
use crate::fmi3::values::{fmi3GetFloat64, fmi3SetFloat64};
use crate::tests::fixture::JENKINS;
use std::ffi::c_void;
use std::ptr::null_mut;
use stickslip::fmi::Stage;

const BEAM: &str = include_str!("../../../../modelDescription/ModalBeam.toml");
const EXCITATION: u32 = 0;
const CONTACT_FORCE: u32 = 1;
/// First output: the displacement at the contact.
const DISPLACEMENT: u32 = 2;

/// The importer within a step.
struct Teller {
    handle: Handle,
    /// What it tells: which input, and how it runs.
    input: u32,
    course: fn(f64) -> f64,
    /// What it also tries.
    mischief: bool,
    times: Vec<f64>,
    read: Vec<f64>,
    statuses: Vec<Status>,
}

unsafe extern "C" fn update(
    environment: *mut c_void,
    time: f64,
    set_requested: Bool,
    get_allowed: Bool,
    step_finished: Bool,
    can_return_early: Bool,
    _early_return_requested: *mut Bool,
    _early_return_time: *mut f64,
) {
    let teller = unsafe { &mut *environment.cast::<Teller>() };
    assert_eq!((can_return_early, get_allowed, set_requested), (0, step_finished, 1 - step_finished));
    teller.times.push(time);
    let mut value = (teller.course)(time);
    unsafe {
        if teller.mischief {
            fmi3FreeInstance(teller.handle);
            teller.statuses.push(fmi3Reset(teller.handle));
            return;
        }
        if set_requested == 1 {
            teller.statuses.push(fmi3SetFloat64(teller.handle, &teller.input, 1, &value, 1));
        } else {
            teller.statuses.push(fmi3GetFloat64(teller.handle, &DISPLACEMENT, 1, &mut value, 1));
            teller.read.push(value);
        }
    }
}

fn teller(course: fn(f64) -> f64) -> Box<Teller> {
    let (times, read, statuses) = (Vec::new(), Vec::new(), Vec::new());
    Box::new(Teller {
        handle: null_mut(),
        input: CONTACT_FORCE,
        course,
        mischief: false,
        times,
        read,
        statuses,
    })
}

/// The displacement of a beam at 4 ms under a contact force that runs as `course`, told within each of its steps.
fn told(importer: &Importer, course: fn(f64) -> f64, steps: usize) -> f64 {
    let mut teller = teller(course);
    let environment: *mut Teller = &mut *teller;
    let running = importer.asked(&[CONTACT_FORCE, DISPLACEMENT], Some(update), environment.cast());
    teller.handle = running.handle;
    running.set(CONTACT_FORCE, course(0.0));
    running.initialize();
    let step = 4e-3 / steps as f64;
    for k in 0..steps {
        assert_eq!(running.do_step(k as f64 * step, step), Status::Ok);
    }
    assert!(teller.statuses.iter().all(|status| *status == Status::Ok));
    assert_eq!(teller.times.len(), 4 * steps);
    assert_eq!(teller.read.last(), Some(&running.get(DISPLACEMENT)));
    running.get(DISPLACEMENT)
}

fn held(importer: &Importer, course: fn(f64) -> f64, steps: usize) -> f64 {
    let running = importer.slave();
    running.set(CONTACT_FORCE, course(0.0));
    running.initialize();
    let step = 4e-3 / steps as f64;
    for k in 0..steps {
        running.set(CONTACT_FORCE, course((k as f64 + 0.5) * step));
        assert_eq!(running.do_step(k as f64 * step, step), Status::Ok);
    }
    running.get(DISPLACEMENT)
}

#[test]
fn inputs_told_within_steps_are_of_third_order_at_least() {
    let importer = Importer::new(BEAM);
    let course = |time: f64| 5.0 * (1500.0 * time).sin();
    let exact = told(&importer, course, 512);
    let errors = [8, 16, 32].map(|steps| (told(&importer, course, steps) - exact).abs());
    let orders: Vec<f64> = errors.windows(2).map(|pair| (pair[0] / pair[1]).log2()).collect();
    assert!(orders.iter().all(|order| *order > 2.8), "{errors:?} {orders:?}");
    assert!(errors[2] < 0.01 * (held(&importer, course, 32) - exact).abs(), "{errors:?}");
}

#[test]
fn a_cubic_is_followed_as_it_is_whatever_the_step() {
    let importer = Importer::new(BEAM);
    let course = |time: f64| 3.0 + 2e2 * time - 9e4 * time * time + 2e7 * time.powi(3);
    let [one, many] = [1, 40].map(|steps| told(&importer, course, steps));
    assert!((one - many).abs() <= 1e-5 * many.abs(), "{one} {many}");
}

#[test]
fn values_that_are_none_and_calls_that_free_the_instance_are_refused() {
    let importer = Importer::new(BEAM);
    let mut other = teller(|_| f64::NAN);
    let environment: *mut Teller = &mut *other;
    let running = importer.asked(&[CONTACT_FORCE], Some(update), environment.cast());
    other.handle = running.handle;
    running.initialize();
    // NaN is not taken: the step goes on with the value that was set. What is not required cannot be read after it.
    assert_eq!(running.do_step(0.0, 1e-4), Status::Ok);
    assert_eq!(running.component().state(), State::Stage(Stage::Terminated));
    assert_eq!(other.statuses, [Status::Discard, Status::Discard, Status::Discard, Status::Error]);

    for (input, expected) in [(EXCITATION, Status::Error), (CONTACT_FORCE, Status::Ok)] {
        let mut other = teller(|_| 1.0);
        other.input = input;
        let environment: *mut Teller = &mut *other;
        let running = importer.asked(&[CONTACT_FORCE, DISPLACEMENT], Some(update), environment.cast());
        other.handle = running.handle;
        running.initialize();
        assert_eq!(running.do_step(0.0, 1e-4), expected);
    }

    let mut other = teller(|_| 1.0);
    other.mischief = true;
    let environment: *mut Teller = &mut *other;
    let running = importer.asked(&[CONTACT_FORCE], Some(update), environment.cast());
    other.handle = running.handle;
    running.initialize();
    assert_eq!(running.do_step(0.0, 1e-4), Status::Error);
    assert_eq!(other.statuses[0], Status::Error);
    assert_eq!(unsafe { fmi3Reset(running.handle) }, Status::Ok);
}

#[test]
fn nothing_is_asked_before_a_step_that_is_none() {
    let importer = Importer::new(JENKINS);
    let mut other = teller(|_| 1.0);
    let environment: *mut Teller = &mut *other;
    let running: Running<'_> = importer.asked(&[0], Some(update), environment.cast());
    other.handle = running.handle;
    running.initialize();
    assert_eq!(running.do_step(0.0, -1.0), Status::Error);
    assert!(other.times.is_empty());
}
