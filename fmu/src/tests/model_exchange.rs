//! Importers that integrate: what they may not pass, and what they get back.

use super::fixture::*;
use super::saved_states::seal;
use crate::calls::State;
use crate::exports::lifecycle::*;
use crate::exports::model_exchange::*;
use crate::ffi::Status;
use std::ptr::null_mut;
use stickslip::fmi::Stage;

const BEAM: &str = include_str!("../../../modelDescription/FrictionalBeam.toml");
const INDICATORS: usize = 3;

/// In continuous time.
fn integrating(importer: &Importer) -> Running<'_> {
    let running = importer.continuous();
    running.initialize();
    assert_eq!(unsafe { fmi2EnterContinuousTimeMode(running.handle) }, Status::Ok);
    running
}

fn states_of(running: &Running<'_>) -> usize {
    running.component().instance.description().states().len()
}

/// Numbers from 0 to 1 that follow each other as if by chance.
pub struct Chance(pub u64);

impl Chance {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn below(&mut self, count: usize) -> usize {
        (self.next() * count as f64) as usize
    }
}

#[test]
fn wrong_lengths_null_and_numbers_that_are_none_are_refused_and_change_nothing() {
    let importer = Importer::new(BEAM);
    let running = integrating(&importer);
    let count = states_of(&running);
    let before = running.bytes();
    let mut values = vec![0.0; count + 1];
    let states = {
        let mut states = vec![0.0; count];
        states[3] = f64::NAN;
        states
    };
    unsafe {
        let handle = running.handle;
        assert_eq!(fmi2GetDerivatives(handle, values.as_mut_ptr(), count + 1), Status::Error);
        assert_eq!(fmi2GetContinuousStates(handle, values.as_mut_ptr(), count - 1), Status::Error);
        assert_eq!(fmi2GetEventIndicators(handle, values.as_mut_ptr(), INDICATORS + 1), Status::Error);
        assert_eq!(fmi2GetDerivatives(handle, null_mut(), count), Status::Error);
        assert!(importer.last().2.contains("derivatives is NULL"), "{:?}", importer.last());
        assert_eq!(fmi2SetContinuousStates(handle, states.as_ptr(), count), Status::Error);
        assert!(importer.last().2.contains("modal_displacement:mode=4"), "{:?}", importer.last());
        assert_eq!(fmi2SetTime(handle, f64::INFINITY), Status::Error);
        assert_eq!(fmi2CompletedIntegratorStep(handle, 1, null_mut(), null_mut()), Status::Error);
    }
    assert_eq!(running.bytes(), before);
}

#[test]
fn a_slave_says_that_it_is_none_that_is_integrated() {
    let importer = Importer::new(JENKINS);
    let running = importer.component();
    unsafe { assert_eq!(fmi2EnterInitializationMode(running.handle), Status::Ok) };
    assert_eq!(unsafe { fmi2GetDerivatives(running.handle, null_mut(), 0) }, Status::Error);
    assert!(importer.last().2.contains("it is for co-simulation"), "{:?}", importer.last());
}

#[test]
fn saved_states_are_of_one_interface() {
    let importer = Importer::new(JENKINS);
    let (slave, integrated) = (importer.running(), integrating(&importer));
    let (of_slave, of_integrated) = (slave.bytes(), integrated.bytes());
    assert_eq!(slave.set_bytes(&of_integrated), Status::Error);
    assert_eq!(integrated.set_bytes(&of_slave), Status::Error);
    // A stage that the interface does not have, under a right checksum.
    for (running, bytes, stage) in
        [(&slave, of_slave, Stage::ContinuousTime), (&integrated, of_integrated, Stage::StepComplete)]
    {
        let mut bytes = bytes;
        bytes[20..24].copy_from_slice(&(stage as u32).to_le_bytes());
        seal(&mut bytes);
        let before = running.bytes();
        assert_eq!(running.set_bytes(&bytes), Status::Error);
        assert_eq!(running.bytes(), before);
    }
}

/// One call with numbers as if by chance; its status.
fn call(running: &Running<'_>, chance: &mut Chance, count: usize) -> Status {
    let handle = running.handle;
    let mut values = vec![0.0; count.max(INDICATORS)];
    let (mut enter, mut end) = (0, 0);
    let odd = chance.next() < 0.02;
    let number = |chance: &mut Chance, scale: f64| {
        if odd {
            [f64::NAN, f64::INFINITY, 1e300, -1e308][chance.below(4)]
        } else {
            scale * (chance.next() - 0.4)
        }
    };
    unsafe {
        match chance.below(9) {
            0 => fmi2SetTime(handle, number(chance, 1.0)),
            1 => {
                let states: Vec<f64> = (0..count).map(|_| number(chance, 1e-4)).collect();
                fmi2SetContinuousStates(handle, states.as_ptr(), count)
            }
            2 => running.set(chance.below(2) as u32, number(chance, 300.0)),
            3 => fmi2GetDerivatives(handle, values.as_mut_ptr(), count),
            4 => fmi2GetEventIndicators(handle, values.as_mut_ptr(), INDICATORS),
            5 => fmi2CompletedIntegratorStep(handle, 1, &mut enter, &mut end),
            6 => fmi2EnterEventMode(handle),
            7 => fmi2EnterContinuousTimeMode(handle),
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

#[test]
fn calls_as_if_by_chance_leave_an_instance_that_goes_on_alike_from_its_saved_state() {
    for model in [JENKINS, VALANIS, BEAM] {
        let importer = Importer::new(model);
        let running = integrating(&importer);
        let (count, mut chance) = (states_of(&running), Chance(7));
        for round in 0..40 {
            for _ in 0..100 {
                call(&running, &mut chance, count);
                assert_ne!(running.component().state(), State::Poisoned, "{:?}", importer.last());
            }
            let saved = running.bytes();
            let [first, second] = [0, 1].map(|_| {
                assert_eq!(running.set_bytes(&saved), Status::Ok);
                let mut again = Chance(round);
                let statuses: Vec<Status> = (0..30).map(|_| call(&running, &mut again, count)).collect();
                (statuses, running.bytes())
            });
            assert_eq!(first, second);
        }
    }
}
