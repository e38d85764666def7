//! Functions of what this library does not have: each returns `fmi3Error`, with a message that says why.

use super::calls::Function;
use crate::ffi::{Handle, Status, ValueReference};
use crate::guard::seldom;
use std::ffi::c_int;

macro_rules! absent {
    ($($name:ident($($argument:ident: $of:ty),*) $function:ident)*) => {$(
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(handle: Handle $(, $argument: $of)*) -> Status {
            // SAFETY: the importer's promise. The call table allows it nowhere.
            unsafe { seldom(handle, Function::$function, nothing) }
        }
    )*};
}

fn nothing(_: &mut crate::guard::Component) -> Result<(), crate::guard::Failure> {
    Ok(())
}

type References = *const ValueReference;

absent! {
    fmi3GetNumberOfVariableDependencies(_reference: ValueReference, _count: *mut usize)
        GetNumberOfVariableDependencies
    fmi3GetVariableDependencies(
        _dependent: ValueReference, _elements: *mut usize, _independents: *mut ValueReference,
        _elements_of_independents: *mut usize, _kinds: *mut c_int, _count: usize
    ) GetVariableDependencies
    fmi3EnterConfigurationMode() EnterConfigurationMode
    fmi3ExitConfigurationMode() ExitConfigurationMode
    fmi3GetIntervalDecimal(_references: References, _count: usize, _intervals: *mut f64, _qualifiers: *mut c_int)
        GetIntervalDecimal
    fmi3GetIntervalFraction(
        _references: References, _count: usize, _counters: *mut u64, _resolutions: *mut u64, _qualifiers: *mut c_int
    ) GetIntervalFraction
    fmi3GetShiftDecimal(_references: References, _count: usize, _shifts: *mut f64) GetShiftDecimal
    fmi3GetShiftFraction(_references: References, _count: usize, _counters: *mut u64, _resolutions: *mut u64)
        GetShiftFraction
    fmi3SetIntervalDecimal(_references: References, _count: usize, _intervals: *const f64) SetIntervalDecimal
    fmi3SetIntervalFraction(_references: References, _count: usize, _counters: *const u64, _resolutions: *const u64)
        SetIntervalFraction
    fmi3SetShiftDecimal(_references: References, _count: usize, _shifts: *const f64) SetShiftDecimal
    fmi3SetShiftFraction(_references: References, _count: usize, _counters: *const u64, _resolutions: *const u64)
        SetShiftFraction
    fmi3EvaluateDiscreteStates() EvaluateDiscreteStates
    fmi3EnterStepMode() EnterStepMode
    fmi3ActivateModelPartition(_clock: ValueReference, _time: f64) ActivateModelPartition
}
