//! Random calls and changed states by the hundred thousand: nothing panics, saved states go on bit by bit.
//!
//! `FUZZ_RUNS=10000000 cargo test --release -p stickslip-fmu fuzz -- --nocapture --test-threads 1` makes ten million
//! executions of each; an execution is one call, or one changed state.

use super::fixture::{Importer, JENKINS, Running, VALANIS};
use super::fmi3::chance::{BEAM, SLIP_SLAP, goes_on_alike, wander};
use super::fmi3::fixture as three;
use super::model_exchange::Chance;
use super::saved_states::seal;
use crate::calls::State;
use crate::exports::lifecycle::*;
use crate::exports::model_exchange::*;
use crate::exports::states::*;
use crate::exports::stepping::*;
use crate::exports::values::*;
use crate::ffi::{StateHandle, Status};
use std::ptr::{null, null_mut};
use stickslip::fmi::Stage;
use stickslip_fuzz::{Rng, fuzz};

const MODELS: [&str; 4] = [JENKINS, VALANIS, SLIP_SLAP, BEAM];
/// Most values of a call.
const WIDE: usize = 4;
/// Room for states and the like.
const ROOM: usize = 80;

/// A number: mostly one that makes sense with `scale`, now and then one that never does.
fn number(chance: &mut Rng, scale: f64) -> f64 {
    const ODD: [f64; 12] = [
        f64::NAN,
        f64::INFINITY,
        f64::NEG_INFINITY,
        0.0,
        -0.0,
        1e300,
        -1e308,
        5e-324,
        f64::MIN_POSITIVE,
        1e30,
        -1.0,
        1e9,
    ];
    match chance.u8(0..12) {
        0 => ODD[chance.usize(..ODD.len())],
        _ => scale * (chance.f64() - 0.4),
    }
}

/// The length of a step. Of those that are too long only absurd ones: what is just short of the limit, fifty thousand attempts,
/// takes most of a second.
fn step(chance: &mut Rng) -> f64 {
    let step = number(chance, 3e-4).abs();
    if step > 1.0 && step < 1e12 { f64::INFINITY } else { step }
}

/// The arguments of one call.
struct Arguments {
    known: [u32; WIDE],
    unknown: [u32; WIDE],
    values: [f64; WIDE],
    whole: [i32; WIDE],
    count: usize,
    states: [f64; ROOM],
    length: usize,
}

impl Arguments {
    fn new(running: &Running<'_>, chance: &mut Rng) -> Self {
        let description = running.component().instance.description();
        let (rows, states) = (description.variables.len() as u32, description.states().len());
        let mut reference = || if chance.u8(0..32) == 0 { chance.u32(..) } else { chance.u32(..rows + 1) };
        let [known, unknown] = [0, 1].map(|_| std::array::from_fn(|_| reference()));
        let scale = *chance.choice([1e-4, 1e-4, 1.0, 300.0].iter()).unwrap_or(&1.0);
        Self {
            known,
            unknown,
            values: std::array::from_fn(|_| number(chance, scale)),
            whole: std::array::from_fn(|_| if chance.u8(0..4) > 0 { 1 } else { chance.i32(..) }),
            count: chance.usize(..=WIDE),
            states: std::array::from_fn(|_| number(chance, 1e-5)),
            length: if chance.u8(0..8) > 0 { states } else { chance.usize(..ROOM) },
        }
    }
}

/// A call about the stage, or about the status.
fn lifecycle(running: &Running<'_>, chance: &mut Rng) -> Status {
    let handle = running.handle;
    let (mut whole, mut real, mut text) = (0, 0.0, null());
    let kind = chance.i32(-1..6);
    let name = c"logAll".as_ptr();
    let seldom = chance.u8(0..8) == 0;
    unsafe {
        match chance.u8(0..14) {
            0 => {
                let (tolerance, stop) = (number(chance, 1e-4), number(chance, 1.0));
                fmi2SetupExperiment(handle, chance.i32(0..2), tolerance, 0.0, chance.i32(0..2), stop)
            }
            1 | 2 => fmi2EnterInitializationMode(handle),
            3 | 4 => fmi2ExitInitializationMode(handle),
            5 if seldom => fmi2Terminate(handle),
            6 if seldom => fmi2Reset(handle),
            7 => {
                let categories = [name, if seldom { null() } else { c"other".as_ptr() }];
                fmi2SetDebugLogging(handle, 0, chance.usize(..3), categories.as_ptr())
            }
            8 => fmi2GetStatus(handle, kind, if seldom { null_mut() } else { &mut whole }),
            9 => fmi2GetRealStatus(handle, kind, if seldom { null_mut() } else { &mut real }),
            10 => fmi2GetIntegerStatus(handle, kind, &mut whole),
            11 => fmi2GetBooleanStatus(handle, kind, &mut whole),
            12 => fmi2GetStringStatus(handle, kind, &mut text),
            _ => fmi2CancelStep(handle),
        }
    }
}

/// A call that sets or reads.
fn values(running: &Running<'_>, chance: &mut Rng, with: &mut Arguments) -> Status {
    let handle = running.handle;
    let count = with.count;
    let known = if chance.u8(0..32) > 0 { with.known.as_ptr() } else { null() };
    let (unknown, into) = (with.unknown.as_ptr(), with.values.as_mut_ptr());
    let given = if chance.u8(0..32) > 0 { with.values.as_ptr() } else { null() };
    let mut change = [0.0; WIDE];
    let mut texts = [null(); WIDE];
    unsafe {
        match chance.u8(0..14) {
            0 | 1 => fmi2GetReal(handle, known, count, into),
            2..=4 => fmi2SetReal(handle, known, count, given),
            5 => fmi2SetReal(handle, [0, 1, 2].as_ptr(), count.min(3), given),
            6 => fmi2GetInteger(handle, known, count, with.whole.as_mut_ptr()),
            7 => fmi2SetInteger(handle, known, count, with.whole.as_ptr()),
            8 => fmi2GetBoolean(handle, known, count, with.whole.as_mut_ptr()),
            9 => fmi2SetBoolean(handle, known, count, with.whole.as_ptr()),
            10 => match chance.bool() {
                true => fmi2GetString(handle, known, count, texts.as_mut_ptr()),
                false => fmi2SetString(handle, known, count, texts.as_ptr()),
            },
            11 => fmi2SetRealInputDerivatives(handle, known, count, with.whole.as_ptr(), given),
            12 => fmi2GetRealOutputDerivatives(handle, known, count, with.whole.as_ptr(), into),
            _ => {
                let few = chance.usize(..=WIDE);
                fmi2GetDirectionalDerivative(handle, unknown, few, known, count, given, change.as_mut_ptr())
            }
        }
    }
}

/// A call of an importer that integrates.
fn integration(running: &Running<'_>, chance: &mut Rng, with: &mut Arguments) -> Status {
    let handle = running.handle;
    let (states, length) = (with.states.as_mut_ptr(), with.length);
    let (mut event, mut terminate) = (0, 0);
    // SAFETY: numbers and truths alone.
    let mut information: EventInfo = unsafe { std::mem::zeroed() };
    let time = running.component().instance.time();
    unsafe {
        match chance.u8(0..11) {
            0 => fmi2EnterEventMode(handle),
            1 => fmi2NewDiscreteStates(handle, &mut information),
            2 | 3 => fmi2EnterContinuousTimeMode(handle),
            4 => fmi2CompletedIntegratorStep(handle, 1, &mut event, &mut terminate),
            5 => fmi2SetTime(handle, time + number(chance, 1e-3)),
            6 => fmi2SetContinuousStates(handle, states, length),
            7 => fmi2GetDerivatives(handle, states, length),
            8 => fmi2GetEventIndicators(handle, states, chance.usize(..6)),
            9 => fmi2GetContinuousStates(handle, states, length),
            _ => fmi2GetNominalsOfContinuousStates(handle, states, length),
        }
    }
}

/// A call about the one saved `state`.
fn saved(running: &Running<'_>, chance: &mut Rng, state: &mut StateHandle) -> Status {
    let (handle, mut size) = (running.handle, 0);
    let mut bytes = [0; 64];
    unsafe {
        match chance.u8(0..8) {
            0..=2 => fmi2GetFMUstate(handle, state),
            3 | 4 => fmi2SetFMUstate(handle, *state),
            5 if chance.bool() => fmi2FreeFMUstate(handle, state),
            6 => fmi2SerializedFMUstateSize(handle, *state, &mut size),
            7 => fmi2SerializeFMUstate(handle, *state, bytes.as_mut_ptr(), chance.usize(..64)),
            _ => fmi2DeSerializeFMUstate(handle, bytes.as_ptr(), chance.usize(..64), state),
        }
    }
}

/// One call with arguments as if by chance.
fn call(running: &Running<'_>, chance: &mut Rng, state: &mut StateHandle) -> Status {
    let mut with = Arguments::new(running, chance);
    let time = running.component().instance.time();
    match chance.u8(0..16) {
        0 | 1 => lifecycle(running, chance),
        2 | 3 => saved(running, chance, state),
        4..=6 => integration(running, chance, &mut with),
        7..=10 => {
            running.do_step(if chance.u8(0..16) > 0 { time } else { number(chance, 1.0) }, step(chance))
        }
        _ => values(running, chance, &mut with),
    }
}

/// A component: mostly initialized, now and then as it was made.
fn begun<'a>(importer: &'a Importer, chance: &mut Rng) -> Running<'a> {
    importer.messages.lock().unwrap().clear();
    let running = if chance.u8(0..3) == 0 { importer.continuous() } else { importer.component() };
    if chance.u8(0..8) > 0 {
        running.initialize();
    }
    running
}

/// Calls by chance; those of the last third are made twice from a saved state, and must do the same.
fn calls(importer: &Importer, chance: &mut Rng) -> Result<u64, String> {
    const CALLS: u64 = 120;
    let running = begun(importer, chance);
    let mut state: StateHandle = null_mut();
    let sound = |_: Status| match running.component().state() {
        State::Poisoned => Err(format!("poisoned: {:?}", importer.last())),
        _ => Ok(()),
    };
    for _ in 0..CALLS / 3 {
        sound(call(&running, chance, &mut state))?;
        if running.component().state() == State::Stage(Stage::Terminated) && chance.bool() {
            assert_eq!(unsafe { fmi2Reset(running.handle) }, Status::Ok);
        }
    }
    let before = running.bytes();
    let seed = chance.u64(..);
    let [first, second] = [0, 1].map(|_| {
        let mut own: StateHandle = null_mut();
        assert_eq!(running.set_bytes(&before), Status::Ok, "{:?}", importer.last());
        assert_eq!(running.bytes(), before);
        let mut again = Rng::with_seed(seed);
        let statuses: Vec<Status> = (0..CALLS / 3).map(|_| call(&running, &mut again, &mut own)).collect();
        unsafe { fmi2FreeFMUstate(running.handle, &mut own) };
        (statuses, running.component().instance.snapshot().to_bytes())
    });
    sound(Status::Ok)?;
    unsafe { fmi2FreeFMUstate(running.handle, &mut state) };
    if first != second {
        return Err("from a saved state it goes on otherwise".to_owned());
    }
    Ok(CALLS)
}

/// States with changed bytes: with the checksum that fitted before they are refused, with the right one refused or gone on
/// from; the way back is bit by bit.
fn changed_states(importer: &Importer, chance: &mut Rng) -> Result<u64, String> {
    const STATES: u64 = 50;
    let running = begun(importer, chance);
    let mut state = null_mut();
    for _ in 0..10 {
        call(&running, chance, &mut state);
    }
    let good = running.bytes();
    for _ in 0..STATES {
        let mut bytes = good.clone();
        for _ in 0..chance.usize(1..4) {
            let at = chance.usize(..bytes.len());
            match chance.u8(0..4) {
                0 => bytes[at] = chance.u8(..),
                1 => bytes[at] ^= 1 << chance.u8(0..8),
                2 if chance.u8(0..8) == 0 => bytes.truncate(at.max(8)),
                _ => {
                    let at = 48 + at / 8 * 8;
                    if let Some(place) = bytes.get_mut(at..at + 8) {
                        place.copy_from_slice(&number(chance, 1e-3).to_le_bytes());
                    }
                }
            }
        }
        let sealed = chance.bool();
        if sealed {
            seal(&mut bytes);
        }
        let status = running.set_bytes(&bytes);
        if status == Status::Ok && !sealed && bytes != good {
            return Err(format!("taken with a wrong checksum: {bytes:?}"));
        }
        for _ in 0..3 {
            call(&running, chance, &mut state);
        }
        if running.component().state() == State::Poisoned {
            return Err(format!("poisoned: {:?}", importer.last()));
        }
        if running.set_bytes(&good) != Status::Ok || running.bytes() != good {
            return Err("the way back to a good state is none".to_owned());
        }
    }
    unsafe { fmi2FreeFMUstate(running.handle, &mut state) };
    Ok(STATES)
}

#[test]
fn fuzz_calls_of_fmi_2() {
    let importers = MODELS.map(Importer::new);
    fuzz("calls of FMI 2.0", |chance| calls(&importers[chance.usize(..importers.len())], chance));
}

#[test]
fn fuzz_changed_states() {
    let importers = MODELS.map(Importer::new);
    fuzz("changed states", |chance| changed_states(&importers[chance.usize(..importers.len())], chance));
}

#[test]
fn fuzz_calls_of_fmi_3() {
    let importers = MODELS.map(three::Importer::new);
    fuzz("calls of FMI 3.0", |chance| {
        let importer = &importers[chance.usize(..importers.len())];
        importer.messages.borrow_mut().clear();
        let running = if chance.u8(0..3) == 0 { importer.continuous() } else { importer.slave() };
        if chance.u8(0..8) > 0 {
            running.initialize();
        }
        wander(&running, &mut Chance(chance.u64(..)), 60)?;
        goes_on_alike(&running, chance.u64(..), 30)?;
        Ok(120)
    });
}
