//! Every function in every state.

use super::fixture::{DISPLACEMENT, FORCE, Importer, JENKINS, Running};
use crate::calls::{Call, FUNCTIONS, Function, State, TABLE};
use crate::exports::{lifecycle::*, model_exchange::*, states::*, stepping::*, values::*};
use crate::ffi::{DO_STEP_STATUS, LAST_SUCCESSFUL_TIME, PENDING_STATUS, Status, TERMINATED};
use crate::guard::guarded;
use std::ptr::{null, null_mut};
use stickslip::fmi::Stage;

use Function as F;

/// The standard's table read by state: what may be called, besides what may be called anywhere.
fn legal(state: State) -> Vec<Function> {
    let anywhere = [
        F::SetDebugLogging,
        F::Reset,
        F::GetFMUstate,
        F::SetFMUstate,
        F::SerializedFMUstateSize,
        F::SerializeFMUstate,
        F::DeSerializeFMUstate,
    ];
    let get = [F::GetReal, F::GetInteger, F::GetBoolean, F::GetString, F::GetDirectionalDerivative];
    let set = [F::SetReal, F::SetInteger, F::SetBoolean, F::SetString, F::SetRealInputDerivatives];
    let status =
        [F::GetStatus, F::GetRealStatus, F::GetIntegerStatus, F::GetBooleanStatus, F::GetStringStatus];
    let mut legal =
        vec![F::GetTypesPlatform, F::GetVersion, F::Instantiate, F::FreeInstance, F::FreeFMUstate];
    let State::Stage(stage) = state else { return legal };
    legal.extend(anywhere);
    let look =
        [F::GetDerivatives, F::GetEventIndicators, F::GetContinuousStates, F::GetNominalsOfContinuousStates];
    match stage {
        Stage::Instantiated => {
            legal.extend(set);
            legal.extend([F::SetupExperiment, F::EnterInitializationMode]);
        }
        Stage::Initialization => {
            legal.extend(get.into_iter().chain(set));
            legal.extend(look);
            legal.push(F::ExitInitializationMode);
        }
        Stage::StepComplete => {
            legal.extend(get.into_iter().chain(set).chain(status));
            legal.extend([F::DoStep, F::Terminate, F::GetRealOutputDerivatives]);
        }
        Stage::StepFailed => {
            legal.extend(get.into_iter().chain(status));
            legal.extend([F::Terminate, F::GetRealOutputDerivatives]);
        }
        Stage::Terminated => {
            legal.extend(get.into_iter().chain(status).chain(look));
            legal.push(F::GetRealOutputDerivatives);
        }
        Stage::Event => {
            legal.extend([F::GetReal, F::GetInteger, F::GetBoolean, F::GetString].into_iter().chain(look));
            legal.extend([F::SetReal, F::SetInteger, F::SetBoolean, F::SetString]);
            legal.extend([F::NewDiscreteStates, F::EnterContinuousTimeMode, F::SetTime, F::Terminate]);
        }
        Stage::ContinuousTime => {
            legal.extend([F::GetReal, F::GetInteger, F::GetBoolean, F::GetString].into_iter().chain(look));
            legal.extend([F::SetReal, F::SetTime, F::SetContinuousStates, F::CompletedIntegratorStep]);
            legal.extend([F::EnterEventMode, F::Terminate]);
        }
    }
    legal
}

/// A component in `state`.
fn in_state(importer: &Importer, state: State) -> Running<'_> {
    let continuous = matches!(state, State::Stage(Stage::Event | Stage::ContinuousTime));
    let running = if continuous { importer.continuous() } else { importer.component() };
    let handle = running.handle;
    unsafe {
        match state {
            State::Stage(Stage::Event) => running.initialize(),
            State::Stage(Stage::ContinuousTime) => {
                running.initialize();
                fmi2EnterContinuousTimeMode(handle);
            }
            State::Stage(Stage::Instantiated) => {}
            State::Stage(Stage::Initialization) => {
                fmi2EnterInitializationMode(handle);
            }
            State::Stage(Stage::StepComplete) => running.initialize(),
            State::Stage(Stage::StepFailed) => {
                running.initialize();
                // A contact's step cannot fail; a saved state may say that it did.
                let mut bytes = running.bytes();
                bytes[20..24].copy_from_slice(&(Stage::StepFailed as u32).to_le_bytes());
                super::saved_states::seal(&mut bytes);
                assert_eq!(running.set_bytes(&bytes), Status::Ok);
            }
            State::Stage(Stage::Terminated) => {
                running.initialize();
                fmi2Terminate(handle);
            }
            State::Intermediate => unreachable!("of FMI 3.0 only"),
            State::Poisoned => {
                running.initialize();
                guarded(handle, F::DoStep, |_| panic!("on purpose"));
            }
        }
    }
    assert_eq!(running.component().state(), state);
    running
}

/// Calls `function` with arguments that are right wherever it is legal.
fn call(running: &Running<'_>, function: Function) -> Status {
    let handle = running.handle;
    let mut state = null_mut();
    let (mut size, mut integer, mut real, mut text) = (0, 0, 0.0, null());
    unsafe {
        match function {
            F::GetTypesPlatform | F::GetVersion | F::Instantiate | F::FreeInstance => Status::Ok,
            F::SetDebugLogging => fmi2SetDebugLogging(handle, 1, 0, null()),
            F::SetupExperiment => fmi2SetupExperiment(handle, 0, 0.0, 0.0, 0, 0.0),
            F::EnterInitializationMode => fmi2EnterInitializationMode(handle),
            F::ExitInitializationMode => fmi2ExitInitializationMode(handle),
            F::Terminate => fmi2Terminate(handle),
            F::Reset => fmi2Reset(handle),
            F::GetReal => fmi2GetReal(handle, &FORCE, 1, &mut real),
            F::GetInteger => fmi2GetInteger(handle, null(), 0, null_mut()),
            F::GetBoolean => fmi2GetBoolean(handle, null(), 0, null_mut()),
            F::GetString => fmi2GetString(handle, null(), 0, null_mut()),
            F::SetReal => fmi2SetReal(handle, &0, 1, &1e-6),
            F::SetInteger => fmi2SetInteger(handle, null(), 0, null()),
            F::SetBoolean => fmi2SetBoolean(handle, null(), 0, null()),
            F::SetString => fmi2SetString(handle, null(), 0, null()),
            F::GetFMUstate => {
                let status = fmi2GetFMUstate(handle, &mut state);
                fmi2FreeFMUstate(handle, &mut state);
                status
            }
            F::SetFMUstate => fmi2SetFMUstate(handle, null_mut()),
            F::FreeFMUstate => fmi2FreeFMUstate(handle, null_mut()),
            F::SerializedFMUstateSize => fmi2SerializedFMUstateSize(handle, null_mut(), &mut size),
            F::SerializeFMUstate => fmi2SerializeFMUstate(handle, null_mut(), null_mut(), 0),
            F::DeSerializeFMUstate => fmi2DeSerializeFMUstate(handle, null(), 0, &mut state),
            F::GetDirectionalDerivative => {
                fmi2GetDirectionalDerivative(handle, &FORCE, 1, &DISPLACEMENT, 1, &1.0, &mut real)
            }
            F::SetRealInputDerivatives => fmi2SetRealInputDerivatives(handle, &DISPLACEMENT, 1, &1, &0.1),
            F::GetRealOutputDerivatives => fmi2GetRealOutputDerivatives(handle, &FORCE, 1, &1, &mut real),
            F::DoStep => fmi2DoStep(handle, 0.0, 1e-3, 1),
            F::CancelStep => fmi2CancelStep(handle),
            F::GetStatus => fmi2GetStatus(handle, DO_STEP_STATUS, &mut integer),
            F::GetRealStatus => fmi2GetRealStatus(handle, LAST_SUCCESSFUL_TIME, &mut real),
            F::GetIntegerStatus => fmi2GetIntegerStatus(handle, DO_STEP_STATUS, &mut integer),
            F::GetBooleanStatus => fmi2GetBooleanStatus(handle, TERMINATED, &mut integer),
            F::GetStringStatus => fmi2GetStringStatus(handle, PENDING_STATUS, &mut text),
            F::EnterEventMode => fmi2EnterEventMode(handle),
            F::NewDiscreteStates => fmi2NewDiscreteStates(handle, null_mut()),
            F::EnterContinuousTimeMode => fmi2EnterContinuousTimeMode(handle),
            F::CompletedIntegratorStep => fmi2CompletedIntegratorStep(handle, 1, &mut integer, &mut integer),
            F::SetTime => fmi2SetTime(handle, 0.0),
            F::SetContinuousStates => fmi2SetContinuousStates(handle, null(), 0),
            F::GetDerivatives => fmi2GetDerivatives(handle, null_mut(), 0),
            F::GetEventIndicators => fmi2GetEventIndicators(handle, null_mut(), 0),
            F::GetContinuousStates => fmi2GetContinuousStates(handle, null_mut(), 0),
            F::GetNominalsOfContinuousStates => fmi2GetNominalsOfContinuousStates(handle, null_mut(), 0),
        }
    }
}

#[test]
fn every_cell_of_the_call_table_is_as_in_the_standard() {
    let importer = Importer::new(JENKINS);
    let states = Stage::ALL.map(State::Stage).into_iter().chain([State::Poisoned]);
    for state in states {
        let legal = legal(state);
        for function in FUNCTIONS.iter().copied() {
            let running = in_state(&importer, state);
            let before = importer.count();
            let status = call(&running, function);
            let refusal = format!("{}: {}", function.name(), function.refusal(state));
            let heard = importer.messages.lock().unwrap()[before..].to_vec();
            let refused = heard.iter().any(|(_, _, message)| *message == refusal);
            let cell = format!("{} in {state:?}: {status:?}, {heard:?}", function.name());
            assert_eq!(!refused, legal.contains(&function), "{cell}");
            if [F::SetRealInputDerivatives, F::GetRealOutputDerivatives, F::GetDirectionalDerivative]
                .contains(&function)
            {
                assert_eq!(status == Status::Ok, !refused, "{cell}");
            }
            if refused {
                let expected = if state == State::Poisoned { Status::Fatal } else { Status::Error };
                assert_eq!(status, expected, "{cell}");
                assert_eq!(running.component().state(), state, "{cell}");
            }
        }
    }
}

#[test]
fn the_table_has_the_44_functions_of_the_standard() {
    assert_eq!(TABLE.len(), 44);
    let mut names: Vec<&str> = TABLE.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 44);
    assert!(names.iter().all(|name| name.starts_with("fmi2")));
}

#[test]
fn a_failed_step_can_be_left_by_a_saved_state_or_a_reset() {
    let importer = Importer::new(JENKINS);
    let good = importer.running().bytes();
    let failed = in_state(&importer, State::Stage(Stage::StepFailed));
    assert_eq!(failed.do_step(0.0, 1e-3), Status::Error);
    assert_eq!(failed.set_bytes(&good), Status::Ok);
    assert_eq!(failed.do_step(0.0, 1e-3), Status::Ok);

    let failed = in_state(&importer, State::Stage(Stage::StepFailed));
    assert_eq!(unsafe { fmi2Reset(failed.handle) }, Status::Ok);
    failed.initialize();
    assert_eq!(failed.do_step(0.0, 1e-3), Status::Ok);
}
