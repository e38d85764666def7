//! Calls of all kinds in any order: nothing panics, and a saved state goes on alike.

use super::fixture::{Importer, Running};
use crate::calls::State;
use crate::ffi::Status;
use crate::fmi3::lifecycle::*;
use crate::fmi3::model_exchange::*;
use crate::fmi3::partial::*;
use crate::fmi3::stepping::fmi3GetOutputDerivatives;
use crate::fmi3::values::*;
use crate::tests::fixture::{JENKINS, VALANIS};
use crate::tests::model_exchange::Chance;
use crate::tests::saved_states::seal;
use stickslip::fmi::Stage;

pub const BEAM: &str = include_str!("../../../../modelDescription/FrictionalBeam.toml");
pub const SLIP_SLAP: &str = include_str!("../../../../modelDescription/SlipSlapContact.toml");

/// Numbers of values that are offered, among them too few and too many.
const ROOM: usize = 80;

/// One call, with numbers and value references as if by chance; its status.
fn call(running: &Running<'_>, chance: &mut Chance, references: usize) -> Status {
    let handle = running.handle;
    let odd = chance.next() < 0.03;
    let number = |chance: &mut Chance, scale: f64| match odd {
        true => [f64::NAN, f64::INFINITY, 1e300, -1e308, 0.0][chance.below(5)],
        false => scale * (chance.next() - 0.4),
    };
    // Beyond the last variable now and then.
    let some = |chance: &mut Chance| -> Vec<u32> {
        (0..chance.below(4)).map(|_| chance.below(references + usize::from(odd)) as u32).collect()
    };
    let (known, unknown) = (some(chance), some(chance));
    let instance = &running.component().instance;
    let size =
        |list: &[u32]| list.iter().map(|reference| instance.size(*reference).unwrap_or(1)).sum::<usize>();
    let (of_known, of_unknown) = (size(&known) + usize::from(odd), size(&unknown));
    let given: Vec<f64> = (0..of_known).map(|_| number(chance, 1e-4)).collect();
    let mut values = [0.0; ROOM];
    let (mut long, mut flags) = ([0_i64; 4], [0_u8; 5]);
    let time = running.component().instance.time();
    let states = instance.description().states().len();
    let (k, u, into) = (known.as_ptr(), unknown.as_ptr(), values.as_mut_ptr());
    unsafe {
        match chance.below(20) {
            0..=2 => running.set(chance.below(3) as u32, number(chance, 300.0)),
            3..=6 => running.do_step(time, number(chance, 1e-3).abs()),
            7 => fmi3GetFloat64(handle, u, unknown.len(), into, of_unknown),
            8 => fmi3SetFloat64(handle, k, known.len(), given.as_ptr(), of_known),
            9 => fmi3GetInt64(handle, u, unknown.len(), long.as_mut_ptr(), unknown.len()),
            10 => fmi3GetDirectionalDerivative(
                handle,
                u,
                unknown.len(),
                k,
                known.len(),
                given.as_ptr(),
                of_known,
                into,
                of_unknown,
            ),
            11 => fmi3GetAdjointDerivative(
                handle,
                k,
                known.len(),
                u,
                unknown.len(),
                given.as_ptr(),
                of_known,
                into,
                of_unknown,
            ),
            12 => fmi3GetOutputDerivatives(handle, u, unknown.len(), [1; 4].as_ptr(), into, of_unknown),
            13 => fmi3EnterInitializationMode(handle, 1, number(chance, 1e-4).abs(), 0.0, 0, 0.0),
            14 => fmi3ExitInitializationMode(handle),
            15 => {
                let given: Vec<f64> = (0..states).map(|_| number(chance, 1e-5)).collect();
                fmi3SetContinuousStates(handle, given.as_ptr(), states)
            }
            16 => {
                let [event, terminate, ..] = &mut flags;
                fmi3CompletedIntegratorStep(handle, 1, event, terminate)
            }
            17 => fmi3EnterContinuousTimeMode(handle),
            18 => fmi3EnterEventMode(handle),
            _ => {
                let mut bytes = running.bytes();
                let at = 48 + 8 * chance.below((bytes.len() - 56) / 8);
                if odd {
                    bytes[at..at + 8].copy_from_slice(&number(chance, 1.0).to_le_bytes());
                    seal(&mut bytes);
                }
                running.set_bytes(&bytes)
            }
        }
    }
}

/// `count` calls by chance, none of which may panic; how many of them were legal.
pub fn wander(running: &Running<'_>, chance: &mut Chance, count: usize) -> Result<usize, String> {
    let description = running.component().instance.description();
    let references = description.variables.len() + description.further().len();
    let mut legal = 0;
    for _ in 0..count {
        legal += usize::from(call(running, chance, references) == Status::Ok);
        let state = running.component().state();
        if state == State::Poisoned {
            return Err(format!("poisoned: {:?}", running.importer.last()));
        }
        if state == State::Stage(Stage::Terminated) {
            assert_eq!(unsafe { fmi3Reset(running.handle) }, Status::Ok);
            if chance.next() < 0.9 {
                running.initialize();
            }
        }
    }
    Ok(legal)
}

/// Saves, makes `count` calls by chance twice from there, and compares the two.
pub fn goes_on_alike(running: &Running<'_>, seed: u64, count: usize) -> Result<(), String> {
    let description = running.component().instance.description();
    let references = description.variables.len() + description.further().len();
    let saved = running.bytes();
    let [first, second] = [0, 1].map(|_| {
        assert_eq!(running.set_bytes(&saved), Status::Ok);
        assert_eq!(running.bytes(), saved);
        let mut again = Chance(seed);
        let statuses: Vec<Status> = (0..count).map(|_| call(running, &mut again, references)).collect();
        (statuses, running.bytes())
    });
    if first == second { Ok(()) } else { Err("from a saved state it goes on otherwise".to_owned()) }
}

#[test]
fn calls_in_any_order_panic_nowhere_and_a_saved_state_goes_on_alike() {
    let mut legal = 0;
    for model in [JENKINS, VALANIS, SLIP_SLAP, BEAM] {
        let importer = Importer::new(model);
        for continuous in [false, true] {
            let running = if continuous { importer.continuous() } else { importer.slave() };
            let mut chance = Chance(11);
            for round in 0..60 {
                legal += wander(&running, &mut chance, 60).unwrap();
                goes_on_alike(&running, round, 20).unwrap();
            }
        }
    }
    assert!(legal > 5000, "{legal}");
}
