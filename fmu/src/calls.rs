//! The call tables of FMI 2.0.4, sections 3.2.3 and 4.2.4, for model exchange and for co-simulation without asynchronous steps.

use crate::guard::Component;
use stickslip::fmi::Stage;

/// States of a component as the table's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Stages of the instance.
    Stage(Stage),
    /// The importer is asked for inputs within a step; FMI 3.0 only.
    Intermediate,
    /// A call panicked: nothing is known about the instance any more.
    Poisoned,
}

impl State {
    /// The column of a table of which the last is that of [`State::Poisoned`].
    pub fn column(self, columns: usize) -> usize {
        match self {
            State::Stage(stage) => stage as usize,
            State::Intermediate => columns - 2,
            State::Poisoned => columns - 1,
        }
    }
}

/// A function of one version of FMI, as [`guarded`](crate::guard::guarded) knows it.
pub trait Call: Copy {
    /// Marks the components of this version: one of another must not be taken for it.
    const MAGIC: u64;

    /// The name in C.
    fn name(self) -> &'static str;

    /// Whether the table allows the call in `state`.
    fn is_legal_in(self, state: State) -> bool;

    /// Why a call is refused in `state`.
    fn refusal(self, state: State) -> String;

    /// What an error does to a component.
    fn failed(_component: &mut Component) {}
}

macro_rules! calls {
    ($number:literal columns; $($function:ident $name:literal $columns:literal)*) => {
        /// The functions.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        // Some functions need no component, and so no look into the table.
        #[allow(dead_code)]
        pub enum Function { $($function),* }

        /// How many states the table knows.
        const COLUMNS: usize = $number;

        /// Names and columns, in the order of [`Function`].
        pub const TABLE: &[(&str, &str)] = &[$(($name, $columns)),*];

        #[cfg(test)]
        pub const FUNCTIONS: &[Function] = &[$(Function::$function),*];

        const LEGAL: [u16; TABLE.len()] = [$($crate::calls::columns($columns, COLUMNS)),*];
    };
}
pub(crate) use calls;

// Columns: Instantiated, Initialization, step Complete, step Failed, Terminated, Event, continuous tiMe, Poisoned. The first
// two and the fifth are those of both interfaces, of which an instance has one.
// `StepInProgress` and `StepCanceled` do not occur: steps are synchronous.
calls! {
    8 columns;
    //                                                                    INCFTEMP
    GetTypesPlatform             "fmi2GetTypesPlatform"                  "xxxxxxxx"
    GetVersion                   "fmi2GetVersion"                        "xxxxxxxx"
    SetDebugLogging              "fmi2SetDebugLogging"                   "xxxxxxx."
    Instantiate                  "fmi2Instantiate"                       "xxxxxxxx"
    FreeInstance                 "fmi2FreeInstance"                      "xxxxxxxx"
    SetupExperiment              "fmi2SetupExperiment"                   "x......."
    EnterInitializationMode      "fmi2EnterInitializationMode"           "x......."
    ExitInitializationMode       "fmi2ExitInitializationMode"            ".x......"
    Terminate                    "fmi2Terminate"                         "..xx.xx."
    Reset                        "fmi2Reset"                             "xxxxxxx."
    GetReal                      "fmi2GetReal"                           ".xxxxxx."
    GetInteger                   "fmi2GetInteger"                        ".xxxxxx."
    GetBoolean                   "fmi2GetBoolean"                        ".xxxxxx."
    GetString                    "fmi2GetString"                         ".xxxxxx."
    SetReal                      "fmi2SetReal"                           "xxx..xx."
    SetInteger                   "fmi2SetInteger"                        "xxx..x.."
    SetBoolean                   "fmi2SetBoolean"                        "xxx..x.."
    SetString                    "fmi2SetString"                         "xxx..x.."
    GetFMUstate                  "fmi2GetFMUstate"                       "xxxxxxx."
    SetFMUstate                  "fmi2SetFMUstate"                       "xxxxxxx."
    FreeFMUstate                 "fmi2FreeFMUstate"                      "xxxxxxxx"
    SerializedFMUstateSize       "fmi2SerializedFMUstateSize"            "xxxxxxx."
    SerializeFMUstate            "fmi2SerializeFMUstate"                 "xxxxxxx."
    DeSerializeFMUstate          "fmi2DeSerializeFMUstate"               "xxxxxxx."
    GetDirectionalDerivative     "fmi2GetDirectionalDerivative"          ".xxxx..."
    SetRealInputDerivatives      "fmi2SetRealInputDerivatives"           "xxx....."
    GetRealOutputDerivatives     "fmi2GetRealOutputDerivatives"          "..xxx..."
    DoStep                       "fmi2DoStep"                            "..x....."
    CancelStep                   "fmi2CancelStep"                        "........"
    GetStatus                    "fmi2GetStatus"                         "..xxx..."
    GetRealStatus                "fmi2GetRealStatus"                     "..xxx..."
    GetIntegerStatus             "fmi2GetIntegerStatus"                  "..xxx..."
    GetBooleanStatus             "fmi2GetBooleanStatus"                  "..xxx..."
    GetStringStatus              "fmi2GetStringStatus"                   "..xxx..."
    // Model exchange only.
    EnterEventMode               "fmi2EnterEventMode"                    "......x."
    NewDiscreteStates            "fmi2NewDiscreteStates"                 ".....x.."
    EnterContinuousTimeMode      "fmi2EnterContinuousTimeMode"           ".....x.."
    CompletedIntegratorStep      "fmi2CompletedIntegratorStep"           "......x."
    SetTime                      "fmi2SetTime"                           ".....xx."
    SetContinuousStates          "fmi2SetContinuousStates"               "......x."
    GetDerivatives               "fmi2GetDerivatives"                    ".x..xxx."
    GetEventIndicators           "fmi2GetEventIndicators"                ".x..xxx."
    GetContinuousStates          "fmi2GetContinuousStates"               ".x..xxx."
    GetNominalsOfContinuousStates "fmi2GetNominalsOfContinuousStates"    ".x..xxx."
}

impl Call for Function {
    const MAGIC: u64 = u64::from_le_bytes(*b"stkslip2");

    fn name(self) -> &'static str {
        TABLE[self as usize].0
    }

    #[inline]
    fn is_legal_in(self, state: State) -> bool {
        LEGAL[self as usize] & 1 << state.column(COLUMNS) != 0
    }

    fn refusal(self, state: State) -> String {
        match (self, state) {
            (Self::CancelStep, State::Stage(_)) => {
                "steps are synchronous, there is none to cancel".to_owned()
            }
            _ => not_allowed(state),
        }
    }
}

/// Why nothing is allowed in a state that allows other calls.
pub fn not_allowed(state: State) -> String {
    match state {
        State::Poisoned => "the instance failed inside an earlier call and can only be freed".to_owned(),
        State::Intermediate => "not allowed in state intermediate update mode".to_owned(),
        State::Stage(stage) => format!("not allowed in state {}", state_name(stage)),
    }
}

fn state_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Instantiated => "instantiated",
        Stage::Initialization => "initialization mode",
        Stage::StepComplete => "step complete",
        Stage::StepFailed => "step failed",
        Stage::Terminated => "terminated",
        Stage::Event => "event mode",
        Stage::ContinuousTime => "continuous-time mode",
    }
}

/// The cells of one row, a bit each.
pub const fn columns(text: &str, count: usize) -> u16 {
    let bytes = text.as_bytes();
    assert!(bytes.len() == count);
    let mut legal = 0;
    let mut column = 0;
    while column < count {
        legal |= ((bytes[column] == b'x') as u16) << column;
        column += 1;
    }
    legal
}
