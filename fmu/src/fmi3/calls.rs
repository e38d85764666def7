//! The call table of FMI 3.0.1, sections 2.3, 3.2 and 4.2, for co-simulation without event mode and for model exchange.

use crate::calls::{Call, State, calls, not_allowed};
use crate::guard::Component;

// Columns: Instantiated, Initialization, Step mode, step Discarded, Terminated, Event, continuous tiMe, intermediate
// Update, Poisoned. The first two and the fifth are those of both interfaces, of which an instance has one.
// What no cell allows is not provided: `refusal` says why.
calls! {
    9 columns;
    //                                                                      INSDTEMUP
    GetVersion                     "fmi3GetVersion"                        "xxxxxxxxx"
    SetDebugLogging                "fmi3SetDebugLogging"                   "xxxxxxxx."
    InstantiateModelExchange       "fmi3InstantiateModelExchange"          "xxxxxxxxx"
    InstantiateCoSimulation        "fmi3InstantiateCoSimulation"           "xxxxxxxxx"
    InstantiateScheduledExecution  "fmi3InstantiateScheduledExecution"     "xxxxxxxxx"
    FreeInstance                   "fmi3FreeInstance"                      "xxxxxxx.x"
    EnterInitializationMode        "fmi3EnterInitializationMode"           "x........"
    ExitInitializationMode         "fmi3ExitInitializationMode"            ".x......."
    EnterEventMode                 "fmi3EnterEventMode"                    "......x.."
    Terminate                      "fmi3Terminate"                         "..xx.xx.."
    Reset                          "fmi3Reset"                             "xxxxxxx.."
    GetFloat32                     "fmi3GetFloat32"                        "xxxxxxxx."
    GetFloat64                     "fmi3GetFloat64"                        "xxxxxxxx."
    GetInt8                        "fmi3GetInt8"                           "xxxxxxxx."
    GetUInt8                       "fmi3GetUInt8"                          "xxxxxxxx."
    GetInt16                       "fmi3GetInt16"                          "xxxxxxxx."
    GetUInt16                      "fmi3GetUInt16"                         "xxxxxxxx."
    GetInt32                       "fmi3GetInt32"                          "xxxxxxxx."
    GetUInt32                      "fmi3GetUInt32"                         "xxxxxxxx."
    GetInt64                       "fmi3GetInt64"                          "xxxxxxx.."
    GetUInt64                      "fmi3GetUInt64"                         "xxxxxxxx."
    GetBoolean                     "fmi3GetBoolean"                        "xxxxxxxx."
    GetString                      "fmi3GetString"                         "xxxxxxxx."
    GetBinary                      "fmi3GetBinary"                         "xxxxxxxx."
    GetClock                       "fmi3GetClock"                          "xxxxxxxx."
    SetFloat32                     "fmi3SetFloat32"                        "xxx..xxx."
    SetFloat64                     "fmi3SetFloat64"                        "xxx..xxx."
    SetInt8                        "fmi3SetInt8"                           "xxx..x..."
    SetUInt8                       "fmi3SetUInt8"                          "xxx..x..."
    SetInt16                       "fmi3SetInt16"                          "xxx..x..."
    SetUInt16                      "fmi3SetUInt16"                         "xxx..x..."
    SetInt32                       "fmi3SetInt32"                          "xxx..x..."
    SetUInt32                      "fmi3SetUInt32"                         "xxx..x..."
    SetInt64                       "fmi3SetInt64"                          "xxx..x..."
    SetUInt64                      "fmi3SetUInt64"                         "xxx..x..."
    SetBoolean                     "fmi3SetBoolean"                        "xxx..x..."
    SetString                      "fmi3SetString"                         "xxx..x..."
    SetBinary                      "fmi3SetBinary"                         "xxx..x..."
    SetClock                       "fmi3SetClock"                          "xxx..x..."
    GetNumberOfVariableDependencies "fmi3GetNumberOfVariableDependencies"  "........."
    GetVariableDependencies        "fmi3GetVariableDependencies"           "........."
    GetFMUState                    "fmi3GetFMUState"                       "xxxxxxx.."
    SetFMUState                    "fmi3SetFMUState"                       "xxxxxxx.."
    FreeFMUState                   "fmi3FreeFMUState"                      "xxxxxxx.x"
    SerializedFMUStateSize         "fmi3SerializedFMUStateSize"            "xxxxxxx.."
    SerializeFMUState              "fmi3SerializeFMUState"                 "xxxxxxx.."
    DeserializeFMUState            "fmi3DeserializeFMUState"               "xxxxxxx.."
    GetDirectionalDerivative       "fmi3GetDirectionalDerivative"          ".xxxx...."
    GetAdjointDerivative           "fmi3GetAdjointDerivative"              ".xxxx...."
    EnterConfigurationMode         "fmi3EnterConfigurationMode"            "........."
    ExitConfigurationMode          "fmi3ExitConfigurationMode"             "........."
    GetIntervalDecimal             "fmi3GetIntervalDecimal"                "........."
    GetIntervalFraction            "fmi3GetIntervalFraction"               "........."
    GetShiftDecimal                "fmi3GetShiftDecimal"                   "........."
    GetShiftFraction               "fmi3GetShiftFraction"                  "........."
    SetIntervalDecimal             "fmi3SetIntervalDecimal"                "........."
    SetIntervalFraction            "fmi3SetIntervalFraction"               "........."
    SetShiftDecimal                "fmi3SetShiftDecimal"                   "........."
    SetShiftFraction               "fmi3SetShiftFraction"                  "........."
    EvaluateDiscreteStates         "fmi3EvaluateDiscreteStates"            "........."
    UpdateDiscreteStates           "fmi3UpdateDiscreteStates"              ".....x..."
    // Model exchange only.
    EnterContinuousTimeMode        "fmi3EnterContinuousTimeMode"           ".....x..."
    CompletedIntegratorStep        "fmi3CompletedIntegratorStep"           "......x.."
    SetTime                        "fmi3SetTime"                           ".....xx.."
    SetContinuousStates            "fmi3SetContinuousStates"               "......x.."
    GetContinuousStateDerivatives  "fmi3GetContinuousStateDerivatives"     ".x..xxx.."
    GetEventIndicators             "fmi3GetEventIndicators"                ".x..xxx.."
    GetContinuousStates            "fmi3GetContinuousStates"               ".x..xxx.."
    GetNominalsOfContinuousStates  "fmi3GetNominalsOfContinuousStates"     ".x..xxx.."
    GetNumberOfEventIndicators     "fmi3GetNumberOfEventIndicators"        "xx..xxx.."
    GetNumberOfContinuousStates    "fmi3GetNumberOfContinuousStates"       "xx..xxx.."
    // Co-simulation only.
    EnterStepMode                  "fmi3EnterStepMode"                     "........."
    GetOutputDerivatives           "fmi3GetOutputDerivatives"              "..xxx..x."
    DoStep                         "fmi3DoStep"                            "..x......"
    // Scheduled execution only.
    ActivateModelPartition         "fmi3ActivateModelPartition"            "........."
}

impl Function {
    /// Why no state allows the call.
    fn absence(self) -> Option<&'static str> {
        use Function as F;
        Some(match self {
            F::GetNumberOfVariableDependencies | F::GetVariableDependencies => {
                "dependencies are those of the model description, providesPerElementDependencies is false"
            }
            F::EnterConfigurationMode | F::ExitConfigurationMode => "there are no structural parameters",
            F::GetIntervalDecimal
            | F::GetIntervalFraction
            | F::GetShiftDecimal
            | F::GetShiftFraction
            | F::SetIntervalDecimal
            | F::SetIntervalFraction
            | F::SetShiftDecimal
            | F::SetShiftFraction
            | F::ActivateModelPartition => "there are no clocks",
            F::EvaluateDiscreteStates => "not provided, providesEvaluateDiscreteStates is false",
            F::EnterStepMode => "co-simulation has no event mode, hasEventMode is false",
            _ => return None,
        })
    }
}

impl Call for Function {
    const MAGIC: u64 = u64::from_le_bytes(*b"stkslip3");

    fn name(self) -> &'static str {
        TABLE[self as usize].0
    }

    #[inline]
    fn is_legal_in(self, state: State) -> bool {
        LEGAL[self as usize] & 1 << state.column(COLUMNS) != 0
    }

    fn refusal(self, state: State) -> String {
        let absent = self.absence().filter(|_| state != State::Poisoned);
        absent.map_or_else(|| not_allowed(state), str::to_owned)
    }

    fn failed(component: &mut Component) {
        component.instance.fail();
    }
}
