//! Every function of FMI 3.0 in every state.

use super::fixture::{Importer, Running};
use crate::calls::{Call, State};
use crate::ffi::{Bool, Status};
use crate::fmi3::calls::{FUNCTIONS, Function, TABLE};
use crate::fmi3::{
    absent::*, lifecycle::*, model_exchange::*, partial::*, states::*, stepping::*, values::*,
};
use crate::guard::guarded;
use crate::tests::fixture::{DISPLACEMENT, FORCE, JENKINS};
use crate::tests::saved_states::seal;
use std::ptr::{null, null_mut};
use stickslip::fmi::Stage;

use Function as F;

const GET: [F; 14] = [
    F::GetFloat32,
    F::GetFloat64,
    F::GetInt8,
    F::GetUInt8,
    F::GetInt16,
    F::GetUInt16,
    F::GetInt32,
    F::GetUInt32,
    F::GetInt64,
    F::GetUInt64,
    F::GetBoolean,
    F::GetString,
    F::GetBinary,
    F::GetClock,
];
const SET: [F; 14] = [
    F::SetFloat32,
    F::SetFloat64,
    F::SetInt8,
    F::SetUInt8,
    F::SetInt16,
    F::SetUInt16,
    F::SetInt32,
    F::SetUInt32,
    F::SetInt64,
    F::SetUInt64,
    F::SetBoolean,
    F::SetString,
    F::SetBinary,
    F::SetClock,
];

/// The standard's lists read by state.
fn legal(state: State) -> Vec<Function> {
    let mut legal = vec![
        F::GetVersion,
        F::InstantiateModelExchange,
        F::InstantiateCoSimulation,
        F::InstantiateScheduledExecution,
    ];
    let State::Stage(stage) = state else {
        legal.extend([F::FreeInstance, F::FreeFMUState]);
        return legal;
    };
    legal.extend([
        F::FreeInstance,
        F::SetDebugLogging,
        F::Reset,
        F::GetFMUState,
        F::SetFMUState,
        F::FreeFMUState,
        F::SerializedFMUStateSize,
        F::SerializeFMUState,
        F::DeserializeFMUState,
    ]);
    legal.extend(GET);
    let look = [
        F::GetContinuousStateDerivatives,
        F::GetEventIndicators,
        F::GetContinuousStates,
        F::GetNominalsOfContinuousStates,
    ];
    let numbers = [F::GetNumberOfContinuousStates, F::GetNumberOfEventIndicators];
    let partial = [F::GetDirectionalDerivative, F::GetAdjointDerivative];
    match stage {
        Stage::Instantiated => {
            legal.extend(SET.into_iter().chain(numbers));
            legal.push(F::EnterInitializationMode);
        }
        Stage::Initialization => {
            legal.extend(SET.into_iter().chain(numbers).chain(look).chain(partial));
            legal.push(F::ExitInitializationMode);
        }
        Stage::StepComplete => {
            legal.extend(SET.into_iter().chain(partial));
            legal.extend([F::DoStep, F::Terminate, F::GetOutputDerivatives]);
        }
        Stage::StepFailed => {
            legal.extend(partial);
            legal.extend([F::Terminate, F::GetOutputDerivatives]);
        }
        Stage::Terminated => {
            legal.extend(partial.into_iter().chain(look).chain(numbers));
            legal.push(F::GetOutputDerivatives);
        }
        Stage::Event => {
            legal.extend(SET.into_iter().chain(look).chain(numbers));
            legal.extend([F::UpdateDiscreteStates, F::EnterContinuousTimeMode, F::SetTime, F::Terminate]);
        }
        Stage::ContinuousTime => {
            legal.extend(look.into_iter().chain(numbers));
            legal.extend([F::SetFloat32, F::SetFloat64, F::SetTime, F::SetContinuousStates]);
            legal.extend([F::CompletedIntegratorStep, F::EnterEventMode, F::Terminate]);
        }
    }
    legal
}

/// An instance in `state`.
fn in_state(importer: &Importer, state: State) -> Running<'_> {
    let continuous = matches!(state, State::Stage(Stage::Event | Stage::ContinuousTime));
    let running = if continuous { importer.continuous() } else { importer.slave() };
    let handle = running.handle;
    unsafe {
        match state {
            State::Stage(Stage::Instantiated) => {}
            State::Stage(Stage::Initialization) => {
                fmi3EnterInitializationMode(handle, 0, 0.0, 0.0, 0, 0.0);
            }
            State::Stage(Stage::StepComplete | Stage::Event) => running.initialize(),
            State::Stage(Stage::ContinuousTime) => {
                running.initialize();
                fmi3EnterContinuousTimeMode(handle);
            }
            State::Stage(Stage::StepFailed) => {
                running.initialize();
                let mut bytes = running.bytes();
                bytes[20..24].copy_from_slice(&(Stage::StepFailed as u32).to_le_bytes());
                seal(&mut bytes);
                assert_eq!(running.set_bytes(&bytes), Status::Ok);
            }
            State::Stage(Stage::Terminated) => {
                running.initialize();
                fmi3Terminate(handle);
            }
            State::Poisoned => {
                running.initialize();
                guarded(handle, F::DoStep, |_| panic!("on purpose"));
            }
            State::Intermediate => unreachable!("it lasts as long as a call back; see `intermediate`"),
        }
    }
    assert_eq!(running.component().state(), state);
    running
}

/// Calls `function` with arguments that are right wherever it is legal.
fn call(running: &Running<'_>, function: Function) -> Status {
    let handle = running.handle;
    let mut state = null_mut();
    let (mut size, mut real, mut long) = (0, 0.0, 0.0);
    let mut flags: [Bool; 5] = [0; 5];
    unsafe {
        match function {
            F::GetVersion | F::FreeInstance => Status::Ok,
            F::InstantiateModelExchange | F::InstantiateCoSimulation | F::InstantiateScheduledExecution => {
                Status::Ok
            }
            F::SetDebugLogging => fmi3SetDebugLogging(handle, 1, 0, null()),
            F::EnterInitializationMode => fmi3EnterInitializationMode(handle, 0, 0.0, 0.0, 0, 0.0),
            F::ExitInitializationMode => fmi3ExitInitializationMode(handle),
            F::EnterEventMode => fmi3EnterEventMode(handle),
            F::Terminate => fmi3Terminate(handle),
            F::Reset => fmi3Reset(handle),
            F::GetFloat64 => fmi3GetFloat64(handle, &FORCE, 1, &mut real, 1),
            F::SetFloat64 => fmi3SetFloat64(handle, &DISPLACEMENT, 1, &1e-6, 1),
            F::GetInt64 => fmi3GetInt64(handle, null(), 0, null_mut(), 0),
            F::SetInt64 => fmi3SetInt64(handle, null(), 0, null(), 0),
            F::GetFloat32 => fmi3GetFloat32(handle, null(), 0, null_mut(), 0),
            F::GetInt8 => fmi3GetInt8(handle, null(), 0, null_mut(), 0),
            F::GetUInt8 => fmi3GetUInt8(handle, null(), 0, null_mut(), 0),
            F::GetInt16 => fmi3GetInt16(handle, null(), 0, null_mut(), 0),
            F::GetUInt16 => fmi3GetUInt16(handle, null(), 0, null_mut(), 0),
            F::GetInt32 => fmi3GetInt32(handle, null(), 0, null_mut(), 0),
            F::GetUInt32 => fmi3GetUInt32(handle, null(), 0, null_mut(), 0),
            F::GetUInt64 => fmi3GetUInt64(handle, null(), 0, null_mut(), 0),
            F::GetBoolean => fmi3GetBoolean(handle, null(), 0, null_mut(), 0),
            F::GetString => fmi3GetString(handle, null(), 0, null_mut(), 0),
            F::GetBinary => fmi3GetBinary(handle, null(), 0, null_mut(), null_mut(), 0),
            F::GetClock => fmi3GetClock(handle, null(), 0, null_mut()),
            F::SetFloat32 => fmi3SetFloat32(handle, null(), 0, null(), 0),
            F::SetInt8 => fmi3SetInt8(handle, null(), 0, null(), 0),
            F::SetUInt8 => fmi3SetUInt8(handle, null(), 0, null(), 0),
            F::SetInt16 => fmi3SetInt16(handle, null(), 0, null(), 0),
            F::SetUInt16 => fmi3SetUInt16(handle, null(), 0, null(), 0),
            F::SetInt32 => fmi3SetInt32(handle, null(), 0, null(), 0),
            F::SetUInt32 => fmi3SetUInt32(handle, null(), 0, null(), 0),
            F::SetUInt64 => fmi3SetUInt64(handle, null(), 0, null(), 0),
            F::SetBoolean => fmi3SetBoolean(handle, null(), 0, null(), 0),
            F::SetString => fmi3SetString(handle, null(), 0, null(), 0),
            F::SetBinary => fmi3SetBinary(handle, null(), 0, null(), null(), 0),
            F::SetClock => fmi3SetClock(handle, null(), 0, null()),
            F::GetNumberOfVariableDependencies => {
                fmi3GetNumberOfVariableDependencies(handle, FORCE, &mut size)
            }
            F::GetVariableDependencies => {
                fmi3GetVariableDependencies(handle, FORCE, null_mut(), null_mut(), null_mut(), null_mut(), 0)
            }
            F::GetFMUState => {
                let status = fmi3GetFMUState(handle, &mut state);
                fmi3FreeFMUState(handle, &mut state);
                status
            }
            F::SetFMUState => {
                let status = fmi3GetFMUState(handle, &mut state);
                if status != Status::Ok {
                    return fmi3SetFMUState(handle, state);
                }
                let status = fmi3SetFMUState(handle, state);
                fmi3FreeFMUState(handle, &mut state);
                status
            }
            F::FreeFMUState => fmi3FreeFMUState(handle, null_mut()),
            F::SerializedFMUStateSize => fmi3SerializedFMUStateSize(handle, null_mut(), &mut size),
            F::SerializeFMUState => fmi3SerializeFMUState(handle, null_mut(), null_mut(), 0),
            F::DeserializeFMUState => fmi3DeserializeFMUState(handle, null(), 0, &mut state),
            F::GetDirectionalDerivative => {
                fmi3GetDirectionalDerivative(handle, &FORCE, 1, &DISPLACEMENT, 1, &1.0, 1, &mut real, 1)
            }
            F::GetAdjointDerivative => {
                fmi3GetAdjointDerivative(handle, &FORCE, 1, &DISPLACEMENT, 1, &1.0, 1, &mut real, 1)
            }
            F::EnterConfigurationMode => fmi3EnterConfigurationMode(handle),
            F::ExitConfigurationMode => fmi3ExitConfigurationMode(handle),
            F::GetIntervalDecimal => fmi3GetIntervalDecimal(handle, null(), 0, null_mut(), null_mut()),
            F::GetIntervalFraction => {
                fmi3GetIntervalFraction(handle, null(), 0, null_mut(), null_mut(), null_mut())
            }
            F::GetShiftDecimal => fmi3GetShiftDecimal(handle, null(), 0, null_mut()),
            F::GetShiftFraction => fmi3GetShiftFraction(handle, null(), 0, null_mut(), null_mut()),
            F::SetIntervalDecimal => fmi3SetIntervalDecimal(handle, null(), 0, null()),
            F::SetIntervalFraction => fmi3SetIntervalFraction(handle, null(), 0, null(), null()),
            F::SetShiftDecimal => fmi3SetShiftDecimal(handle, null(), 0, null()),
            F::SetShiftFraction => fmi3SetShiftFraction(handle, null(), 0, null(), null()),
            F::EvaluateDiscreteStates => fmi3EvaluateDiscreteStates(handle),
            F::UpdateDiscreteStates => {
                let [a, b, c, d, e] = &mut flags;
                fmi3UpdateDiscreteStates(handle, a, b, c, d, e, &mut long)
            }
            F::EnterContinuousTimeMode => fmi3EnterContinuousTimeMode(handle),
            F::CompletedIntegratorStep => {
                let [a, b, ..] = &mut flags;
                fmi3CompletedIntegratorStep(handle, 1, a, b)
            }
            F::SetTime => fmi3SetTime(handle, 0.0),
            F::SetContinuousStates => fmi3SetContinuousStates(handle, null(), 0),
            F::GetContinuousStateDerivatives => fmi3GetContinuousStateDerivatives(handle, null_mut(), 0),
            F::GetEventIndicators => {
                let mut indicators = [0.0; 3];
                fmi3GetEventIndicators(handle, indicators.as_mut_ptr(), 3)
            }
            F::GetContinuousStates => fmi3GetContinuousStates(handle, null_mut(), 0),
            F::GetNominalsOfContinuousStates => fmi3GetNominalsOfContinuousStates(handle, null_mut(), 0),
            F::GetNumberOfEventIndicators => fmi3GetNumberOfEventIndicators(handle, &mut size),
            F::GetNumberOfContinuousStates => fmi3GetNumberOfContinuousStates(handle, &mut size),
            F::EnterStepMode => fmi3EnterStepMode(handle),
            F::GetOutputDerivatives => fmi3GetOutputDerivatives(handle, &FORCE, 1, &1, &mut real, 1),
            F::DoStep => running.do_step(0.0, 1e-3),
            F::ActivateModelPartition => fmi3ActivateModelPartition(handle, 0, 0.0),
        }
    }
}

#[test]
fn every_cell_of_the_call_table_is_as_in_the_standard_and_an_error_terminates() {
    let importer = Importer::new(JENKINS);
    let states = Stage::ALL.map(State::Stage).into_iter().chain([State::Poisoned]);
    for state in states {
        let legal = legal(state);
        for function in FUNCTIONS.iter().copied() {
            let running = in_state(&importer, state);
            let before = importer.messages.borrow().len();
            let status = call(&running, function);
            let refusal = format!("{}: {}", function.name(), function.refusal(state));
            let heard = importer.messages.borrow()[before..].to_vec();
            let refused = heard.iter().any(|(_, _, message)| *message == refusal);
            let cell = format!("{} in {state:?}: {status:?}, {heard:?}", function.name());
            assert_eq!(!refused, legal.contains(&function), "{cell}");
            if refused {
                let (expected, after) = match state {
                    State::Poisoned => (Status::Fatal, State::Poisoned),
                    _ => (Status::Error, State::Stage(Stage::Terminated)),
                };
                assert_eq!((status, running.component().state()), (expected, after), "{cell}");
            }
        }
    }
}

#[test]
fn the_table_has_the_75_functions_of_the_standard() {
    assert_eq!(TABLE.len(), 75);
    let mut names: Vec<&str> = TABLE.iter().map(|(name, _)| *name).collect();
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), 75);
    assert!(names.iter().all(|name| name.starts_with("fmi3")));
}

#[test]
fn what_is_not_provided_is_an_error_that_says_why() {
    let importer = Importer::new(JENKINS);
    for (function, why) in [
        (F::EnterStepMode, "hasEventMode is false"),
        (F::GetIntervalDecimal, "no clocks"),
        (F::ActivateModelPartition, "no clocks"),
        (F::EnterConfigurationMode, "no structural parameters"),
        (F::GetVariableDependencies, "providesPerElementDependencies is false"),
        (F::EvaluateDiscreteStates, "providesEvaluateDiscreteStates is false"),
    ] {
        let running = in_state(&importer, State::Stage(Stage::StepComplete));
        assert_eq!(call(&running, function), Status::Error);
        assert!(importer.last().2.contains(why), "{:?}", importer.last());
    }
}
