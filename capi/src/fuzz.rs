//! Calls by the hundred thousand with arguments as if by chance: nothing panics, and what fails changes nothing.
//!
//! `FUZZ_RUNS=10000000 cargo test --release -p stickslip-capi fuzz -- --nocapture` makes ten million calls.

use crate::*;
use std::ffi::{CStr, CString, c_int};
use std::ptr::{null, null_mut};
use stickslip_fuzz::{Rng, fuzz, mutate};

const MODELS: [&str; 3] = [
    include_str!("../../modelDescription/JenkinsContact.toml"),
    include_str!("../../modelDescription/SlipSlapContact.toml"),
    include_str!("../../modelDescription/FrictionalBeam.toml"),
];
/// Calls of a trial.
const CALLS: u64 = 60;
/// More than any of the models has inputs, outputs or elements of a tangent.
const ROOM: usize = 200;

/// A number: mostly one that makes sense with `scale`, now and then one that never does.
fn number(chance: &mut Rng, scale: f64) -> f64 {
    const ODD: [f64; 9] =
        [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 0.0, 1e300, -1e308, 5e-324, -1.0, 1e12];
    if chance.u8(0..16) == 0 { ODD[chance.usize(..ODD.len())] } else { scale * (chance.f64() - 0.4) }
}

/// The length of a step. Of those that are too long only absurd ones: what is just short of the limit, a million attempts, takes
/// minutes, as it is documented.
fn step(chance: &mut Rng) -> f64 {
    let step = number(chance, 1e-3).abs();
    if step > 1.0 && step < 1e12 { f64::INFINITY } else { step }
}

/// A model of C, and its one saved state.
struct Subject {
    model: *mut Object,
    state: *mut State,
}

impl Drop for Subject {
    fn drop(&mut self) {
        unsafe {
            stickslip_free(self.model);
            stickslip_state_free(self.state);
        }
    }
}

impl Subject {
    fn copy(base: &Self) -> Self {
        let mut model = null_mut();
        assert_eq!(unsafe { stickslip_copy(base.model, &mut model) }, Status::Ok);
        Self { model, state: null_mut() }
    }

    fn new(text: &str) -> Self {
        let (text, mut model) = (CString::new(text).unwrap(), null_mut());
        assert_eq!(unsafe { stickslip_create(text.as_ptr(), &mut model) }, Status::Ok);
        Self { model, state: null_mut() }
    }

    /// All that the model remembers.
    fn bytes(&self) -> Vec<u8> {
        let mut state = null_mut();
        unsafe {
            assert_eq!(stickslip_save(self.model, &mut state), Status::Ok);
            let mut bytes = vec![0; stickslip_state_size(state)];
            assert_eq!(stickslip_state_write(state, bytes.as_mut_ptr(), bytes.len()), Status::Ok);
            stickslip_state_free(state);
            bytes
        }
    }

    /// A call that runs the model.
    fn run(&self, chance: &mut Rng) -> Status {
        let inputs: [f64; ROOM] = std::array::from_fn(|place| {
            if place < 4 { number(chance, if place == 2 { 300.0 } else { 1e-4 }) } else { 0.0 }
        });
        let given = if chance.u8(0..8) > 0 { inputs.as_ptr() } else { null() };
        let mut results = [0.0; ROOM];
        let into = if chance.u8(0..8) > 0 { results.as_mut_ptr() } else { null_mut() };
        let odd = chance.u8(0..64) == 0;
        let model = if odd { null_mut() } else { self.model };
        unsafe {
            match chance.u8(0..8) {
                0 => stickslip_start(model, given, number(chance, 1e-4).abs(), into),
                1 => stickslip_tangent(model, into),
                2 => stickslip_time(model, into),
                _ => stickslip_step(model, given, step(chance), into),
            }
        }
    }

    /// A call about variables.
    fn ask(&self, chance: &mut Rng) -> Status {
        let kind: c_int = if chance.u8(0..8) == 0 { chance.i32(..) } else { chance.i32(-1..4) };
        let index = if chance.u8(0..8) == 0 { chance.usize(..) } else { chance.usize(..12) };
        let (mut value, mut place) = (0.0, 0);
        unsafe {
            match chance.u8(0..5) {
                0 => {
                    // Not far from what it is: the motion of a beam of 1e5 m takes minutes to compute.
                    stickslip_parameter(self.model, index, &mut value);
                    let far = chance.u8(0..8) == 0;
                    let value = if far { number(chance, 1.0) } else { value * (0.5 + chance.f64()) };
                    stickslip_set_parameter(self.model, index, value)
                }
                1 => stickslip_parameter(self.model, index, &mut value),
                2 => {
                    let (name, unit) = (
                        stickslip_variable_name(self.model, kind, index),
                        stickslip_variable_unit(self.model, kind, index),
                    );
                    let there = index < stickslip_variable_count(self.model, kind);
                    assert_eq!((name.is_null(), unit.is_null()), (!there, !there));
                    if !there {
                        return Status::Refused;
                    }
                    let found = stickslip_variable_find(self.model, kind, name, &mut place);
                    assert_eq!((found, place), (Status::Ok, index));
                    found
                }
                3 => stickslip_variable_find(self.model, kind, c"nothing".as_ptr(), &mut place),
                _ => stickslip_variable_find(self.model, kind, null(), &mut place),
            }
        }
    }

    /// A call about the saved state.
    fn keep(&mut self, chance: &mut Rng) -> Status {
        unsafe {
            match chance.u8(0..5) {
                0 | 1 => stickslip_save(self.model, &mut self.state),
                2 => stickslip_restore(self.model, self.state),
                3 => {
                    let bytes = mutate(self.bytes(), chance);
                    let mut state = null_mut();
                    let read = stickslip_state_read(self.model, bytes.as_ptr(), bytes.len(), &mut state);
                    // A mutation may change nothing.
                    assert_eq!(read == Status::Ok, !state.is_null());
                    stickslip_state_free(state);
                    read
                }
                _ => stickslip_state_write(self.state, [0; 64].as_mut_ptr(), chance.usize(..64)),
            }
        }
    }
}

/// Calls by chance on a copy of `base`: a call that fails leaves all as it was.
fn calls(base: &Subject, chance: &mut Rng) -> Result<u64, String> {
    let mut subject = Subject::copy(base);
    for _ in 0..CALLS {
        let before = (chance.u8(0..4) == 0).then(|| subject.bytes());
        let status = match chance.u8(0..8) {
            0 => subject.ask(chance),
            1 | 2 => subject.keep(chance),
            _ => subject.run(chance),
        };
        if status == Status::Broken {
            return Err(unsafe { CStr::from_ptr(stickslip_error_text()) }.to_string_lossy().into_owned());
        }
        if let Some(before) = before
            && status != Status::Ok
            && subject.bytes() != before
        {
            return Err(format!("{status:?}, and the model is not as before"));
        }
    }
    // A copy goes on alike.
    let other = Subject::copy(&subject);
    let seed = chance.u64(..);
    let [one, two] = [&subject, &other].map(|subject| {
        let mut again = Rng::with_seed(seed);
        let statuses: Vec<Status> = (0..10).map(|_| subject.run(&mut again)).collect();
        (statuses, subject.bytes())
    });
    if one == two { Ok(CALLS + 20) } else { Err("a copy goes on otherwise".to_owned()) }
}

#[test]
fn fuzz_calls_of_the_c_interface() {
    let bases = MODELS.map(Subject::new);
    fuzz("the C interface", |chance| calls(&bases[chance.usize(..bases.len())], chance));
}

#[test]
fn fuzz_texts_of_models_from_c() {
    fuzz("models as texts of C", |chance| {
        let mut bytes = mutate(MODELS[chance.usize(..MODELS.len())].as_bytes().to_vec(), chance);
        bytes.retain(|byte| *byte != 0);
        let (text, mut model) = (CString::new(bytes).unwrap_or_default(), null_mut());
        let status = unsafe { stickslip_create(text.as_ptr(), &mut model) };
        let subject = Subject { model, state: null_mut() };
        match status {
            Status::Ok => {
                let started = unsafe { stickslip_start(subject.model, null(), 0.0, null_mut()) };
                if started == Status::Broken { Err(format!("broken by {text:?}")) } else { Ok(1) }
            }
            Status::Refused | Status::Failed if subject.model.is_null() => Ok(1),
            other => Err(format!("{other:?} of {text:?}")),
        }
    });
}
