//! The call table of FMI 2.0.4, section 4.2.4, for co-simulation without asynchronous steps.

use stickslip::fmi::Stage;

/// States of a component as the table's columns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum State {
    /// Stages of the instance.
    Stage(Stage),
    /// A call panicked: nothing is known about the instance any more.
    Poisoned,
}

impl State {
    fn column(self) -> usize {
        match self {
            State::Stage(stage) => stage as usize,
            State::Poisoned => 5,
        }
    }
}

macro_rules! calls {
    ($($function:ident $name:literal $columns:literal)*) => {
        /// The 44 functions.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        // Two functions need no component, and so no look into the table.
        #[allow(dead_code)]
        pub enum Function { $($function),* }

        /// Names and columns, in the order of [`Function`].
        pub const TABLE: &[(&str, &str)] = &[$(($name, $columns)),*];

        #[cfg(test)]
        pub const FUNCTIONS: &[Function] = &[$(Function::$function),*];

        const LEGAL: [[bool; 6]; TABLE.len()] = [$(columns($columns)),*];
    };
}

// Columns: Instantiated, Initialization, step Complete, step Failed, Terminated, Poisoned.
// `StepInProgress` and `StepCanceled` do not occur: steps are synchronous.
calls! {
    //                                                                    INCFTP
    GetTypesPlatform             "fmi2GetTypesPlatform"                  "xxxxxx"
    GetVersion                   "fmi2GetVersion"                        "xxxxxx"
    SetDebugLogging              "fmi2SetDebugLogging"                   "xxxxx."
    Instantiate                  "fmi2Instantiate"                       "xxxxxx"
    FreeInstance                 "fmi2FreeInstance"                      "xxxxxx"
    SetupExperiment              "fmi2SetupExperiment"                   "x....."
    EnterInitializationMode      "fmi2EnterInitializationMode"           "x....."
    ExitInitializationMode       "fmi2ExitInitializationMode"            ".x...."
    Terminate                    "fmi2Terminate"                         "..xx.."
    Reset                        "fmi2Reset"                             "xxxxx."
    GetReal                      "fmi2GetReal"                           ".xxxx."
    GetInteger                   "fmi2GetInteger"                        ".xxxx."
    GetBoolean                   "fmi2GetBoolean"                        ".xxxx."
    GetString                    "fmi2GetString"                         ".xxxx."
    SetReal                      "fmi2SetReal"                           "xxx..."
    SetInteger                   "fmi2SetInteger"                        "xxx..."
    SetBoolean                   "fmi2SetBoolean"                        "xxx..."
    SetString                    "fmi2SetString"                         "xxx..."
    GetFMUstate                  "fmi2GetFMUstate"                       "xxxxx."
    SetFMUstate                  "fmi2SetFMUstate"                       "xxxxx."
    FreeFMUstate                 "fmi2FreeFMUstate"                      "xxxxxx"
    SerializedFMUstateSize       "fmi2SerializedFMUstateSize"            "xxxxx."
    SerializeFMUstate            "fmi2SerializeFMUstate"                 "xxxxx."
    DeSerializeFMUstate          "fmi2DeSerializeFMUstate"               "xxxxx."
    GetDirectionalDerivative     "fmi2GetDirectionalDerivative"          ".xxxx."
    SetRealInputDerivatives      "fmi2SetRealInputDerivatives"           "xxx..."
    GetRealOutputDerivatives     "fmi2GetRealOutputDerivatives"          "..xxx."
    DoStep                       "fmi2DoStep"                            "..x..."
    CancelStep                   "fmi2CancelStep"                        "......"
    GetStatus                    "fmi2GetStatus"                         "..xxx."
    GetRealStatus                "fmi2GetRealStatus"                     "..xxx."
    GetIntegerStatus             "fmi2GetIntegerStatus"                  "..xxx."
    GetBooleanStatus             "fmi2GetBooleanStatus"                  "..xxx."
    GetStringStatus              "fmi2GetStringStatus"                   "..xxx."
    // Model exchange only.
    EnterEventMode               "fmi2EnterEventMode"                    "......"
    NewDiscreteStates            "fmi2NewDiscreteStates"                 "......"
    EnterContinuousTimeMode      "fmi2EnterContinuousTimeMode"           "......"
    CompletedIntegratorStep      "fmi2CompletedIntegratorStep"           "......"
    SetTime                      "fmi2SetTime"                           "......"
    SetContinuousStates          "fmi2SetContinuousStates"               "......"
    GetDerivatives               "fmi2GetDerivatives"                    "......"
    GetEventIndicators           "fmi2GetEventIndicators"                "......"
    GetContinuousStates          "fmi2GetContinuousStates"               "......"
    GetNominalsOfContinuousStates "fmi2GetNominalsOfContinuousStates"    "......"
}

impl Function {
    /// The name in C.
    pub fn name(self) -> &'static str {
        TABLE[self as usize].0
    }

    /// Whether the table allows the call in `state`.
    #[inline]
    pub fn is_legal_in(self, state: State) -> bool {
        LEGAL[self as usize][state.column()]
    }

    /// Why a call is refused in `state`.
    pub fn refusal(self, state: State) -> String {
        match (self, state) {
            (_, State::Poisoned) => {
                "the instance failed inside an earlier call and can only be freed".to_owned()
            }
            (Self::CancelStep, _) => "steps are synchronous, there is none to cancel".to_owned(),
            _ if self as usize >= Self::EnterEventMode as usize => {
                "a function of model exchange; this FMU is for co-simulation".to_owned()
            }
            (_, State::Stage(stage)) => format!("not allowed in state {}", state_name(stage)),
        }
    }
}

fn state_name(stage: Stage) -> &'static str {
    match stage {
        Stage::Instantiated => "instantiated",
        Stage::Initialization => "initialization mode",
        Stage::StepComplete => "step complete",
        Stage::StepFailed => "step failed",
        Stage::Terminated => "terminated",
    }
}

const fn columns(text: &str) -> [bool; 6] {
    let bytes = text.as_bytes();
    assert!(bytes.len() == 6);
    let mut legal = [false; 6];
    let mut column = 0;
    while column < 6 {
        legal[column] = bytes[column] == b'x';
        column += 1;
    }
    legal
}
