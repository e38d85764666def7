/* The functions of FMI 3.0, and a call of each with arguments that are right. */
#include "suite.h"

#include <fmi3FunctionTypes.h>

#define FUNCTIONS(X)                                                                                               \
    X(GetVersion) X(SetDebugLogging) X(InstantiateModelExchange) X(InstantiateCoSimulation)                        \
    X(InstantiateScheduledExecution) X(FreeInstance) X(EnterInitializationMode) X(ExitInitializationMode)          \
    X(EnterEventMode) X(Terminate) X(Reset) X(GetFloat32) X(GetFloat64) X(GetInt32) X(GetInt64) X(GetUInt64)       \
    X(GetBoolean) X(GetString) X(GetBinary) X(GetClock) X(SetFloat32) X(SetFloat64) X(SetInt64) X(SetBoolean)      \
    X(SetString) X(GetNumberOfVariableDependencies) X(GetFMUState) X(SetFMUState) X(FreeFMUState)                  \
    X(SerializedFMUStateSize) X(SerializeFMUState) X(DeserializeFMUState) X(GetDirectionalDerivative)              \
    X(GetAdjointDerivative) X(EnterConfigurationMode) X(ExitConfigurationMode) X(GetIntervalDecimal)               \
    X(EvaluateDiscreteStates) X(UpdateDiscreteStates) X(EnterContinuousTimeMode) X(CompletedIntegratorStep)        \
    X(SetTime) X(SetContinuousStates) X(GetContinuousStateDerivatives) X(GetEventIndicators)                       \
    X(GetContinuousStates) X(GetNominalsOfContinuousStates) X(GetNumberOfEventIndicators)                          \
    X(GetNumberOfContinuousStates) X(EnterStepMode) X(GetOutputDerivatives) X(DoStep) X(ActivateModelPartition)
#define DECLARE(name) static fmi3##name##TYPE *name;
FUNCTIONS(DECLARE)

enum { WIDE = 4, MANY = 1000, STEPS = 100, ROWS = 256, SIZES = 256 };
static const char *token, *resources;
/* The value references of all Float64 that are one number. */
static fmi3ValueReference numbers[ROWS];
static size_t number_count;
/* One of them that is an output with derivatives. */
static fmi3ValueReference output;
/* The first input, which is a Float64 in every standard FMU. */
static const fmi3ValueReference input = 0;

static void told(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String text) {
    (void)environment, (void)category;
    /* An internal error is told; what is refused is as it should be. */
    if (status == fmi3Fatal) printf("%s: ", text);
}

static fmi3Instance slave(void) {
    fmi3Instance one = InstantiateCoSimulation("one", token, resources, false, false, false, false, NULL, 0, NULL, told, NULL);
    if (one == NULL) fail("no instance");
    return one;
}

static fmi3Instance model(void) {
    fmi3Instance one = InstantiateModelExchange("one", token, resources, false, false, NULL, told);
    if (one == NULL) fail("no instance for model exchange");
    return one;
}

static void start(fmi3Instance one) {
    if (EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0) || ExitInitializationMode(one)) fail("no start");
}

static fmi3Status step(fmi3Instance one, double time, double size) {
    bool event, terminate, early;
    double last;
    return DoStep(one, time, size, true, &event, &terminate, &early, &last);
}

/* The calls of the mask, with arguments that are right. */

#define ONLY(name) static fmi3Status only_##name(fmi3Instance one) { return name(one); }
ONLY(ExitInitializationMode) ONLY(EnterEventMode) ONLY(Terminate) ONLY(Reset) ONLY(EnterConfigurationMode) ONLY(ExitConfigurationMode)
ONLY(EvaluateDiscreteStates) ONLY(EnterContinuousTimeMode) ONLY(EnterStepMode)

static fmi3Status set_logging(fmi3Instance one) { return SetDebugLogging(one, false, 0, NULL); }
static fmi3Status enter_initialization(fmi3Instance one) { return EnterInitializationMode(one, true, 1e-6, 0.0, true, 1.0); }

static fmi3Status get_number(fmi3Instance one) {
    double value;
    return GetFloat64(one, &output, 1, &value, 1);
}

static fmi3Status set_number(fmi3Instance one) {
    double value = 1e-6;
    return SetFloat64(one, &input, 1, &value, 1);
}

static fmi3Status get_none(fmi3Instance one) {
    fmi3Status all[] = {
        GetFloat32(one, NULL, 0, NULL, 0), GetInt32(one, NULL, 0, NULL, 0), GetInt64(one, NULL, 0, NULL, 0),
        GetUInt64(one, NULL, 0, NULL, 0), GetBoolean(one, NULL, 0, NULL, 0), GetString(one, NULL, 0, NULL, 0),
        GetBinary(one, NULL, 0, NULL, NULL, 0), GetClock(one, NULL, 0, NULL),
    };
    fmi3Status worst = fmi3OK;
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        if (all[k] > worst) worst = all[k];
    return worst;
}

static fmi3Status set_integer(fmi3Instance one) { return SetInt64(one, NULL, 0, NULL, 0); }
static fmi3Status set_string(fmi3Instance one) { return SetString(one, NULL, 0, NULL, 0); }

static fmi3Status dependencies(fmi3Instance one) {
    size_t count;
    return GetNumberOfVariableDependencies(one, output, &count);
}

/* Save, serialize, make of the bytes, restore, free. */
static fmi3Status save_and_restore(fmi3Instance one) {
    fmi3FMUState state = NULL, other = NULL;
    fmi3Status status = GetFMUState(one, &state);
    if (status != fmi3OK) return status;
    size_t size = 0;
    if (SerializedFMUStateSize(one, state, &size)) fail("no size of a state");
    fmi3Byte *bytes = malloc(size);
    if (SerializeFMUState(one, state, bytes, size) || DeserializeFMUState(one, bytes, size, &other)) fail("no bytes of a state");
    free(bytes);
    if (SetFMUState(one, other) || FreeFMUState(one, &other) || FreeFMUState(one, &state)) fail("a state is not restored");
    return fmi3OK;
}

static fmi3Status directional(fmi3Instance one) {
    double along = 1.0, value;
    return GetDirectionalDerivative(one, &output, 1, &input, 1, &along, 1, &value, 1);
}

static fmi3Status adjoint(fmi3Instance one) {
    double weight = 1.0, value;
    return GetAdjointDerivative(one, &output, 1, &input, 1, &weight, 1, &value, 1);
}

static fmi3Status output_derivatives(fmi3Instance one) {
    fmi3Int32 order = 1;
    double value;
    return GetOutputDerivatives(one, &output, 1, &order, &value, 1);
}

static fmi3Status interval(fmi3Instance one) { return GetIntervalDecimal(one, NULL, 0, NULL, NULL); }

static fmi3Status update(fmi3Instance one) {
    bool flags[5];
    double next;
    return UpdateDiscreteStates(one, flags, flags + 1, flags + 2, flags + 3, flags + 4, &next);
}

static fmi3Status completed(fmi3Instance one) {
    bool event, terminate;
    return CompletedIntegratorStep(one, true, &event, &terminate);
}

static fmi3Status set_time(fmi3Instance one) { return SetTime(one, 0.0); }
static fmi3Status first_step(fmi3Instance one) { return step(one, 0.0, 1e-5); }
static fmi3Status activate(fmi3Instance one) { return ActivateModelPartition(one, 0, 0.0); }

static fmi3Status state_count(fmi3Instance one) {
    size_t count;
    return GetNumberOfContinuousStates(one, &count);
}

static fmi3Status indicator_count(fmi3Instance one) {
    size_t count;
    return GetNumberOfEventIndicators(one, &count);
}

static size_t states, indicators;
static fmi3Status get_states(fmi3Instance one) { double all[SIZES]; return GetContinuousStates(one, all, states); }
static fmi3Status get_nominals(fmi3Instance one) { double all[SIZES]; return GetNominalsOfContinuousStates(one, all, states); }
static fmi3Status set_states(fmi3Instance one) { double all[SIZES] = {0}; return SetContinuousStates(one, all, states); }
static fmi3Status get_slopes(fmi3Instance one) { double all[SIZES]; return GetContinuousStateDerivatives(one, all, states); }
static fmi3Status get_indicators(fmi3Instance one) { double all[SIZES]; return GetEventIndicators(one, all, indicators); }

/* Of co-simulation Instantiated, iNitialization mode, Step mode, Terminated; of model exchange the same with i, n and t, Event mode,
 * Continuous-time mode: where the standard allows the call (FMI 3.0.1, 2.3, 3.2, 4.2), for what the description claims. */
static const char STATES[] = "INSTinEct";
typedef struct {
    fmi3Status (*call)(fmi3Instance);
    const char *name, *allowed;
} cell;

static const cell MASK[] = {
    {set_logging, "SetDebugLogging", "INSTinEct"},
    {enter_initialization, "EnterInitializationMode", "Ii"},
    {only_ExitInitializationMode, "ExitInitializationMode", "Nn"},
    {only_EnterEventMode, "EnterEventMode", "c"},
    {only_Terminate, "Terminate", "SEc"},
    {only_Reset, "Reset", "INSTinEct"},
    {get_number, "GetFloat64", "INSTinEct"},
    {set_number, "SetFloat64", "INSinEc"},
    {get_none, "Get of other types", "INSTinEct"},
    {set_integer, "SetInt64", "INSinE"},
    {set_string, "SetString", "INSinE"},
    {dependencies, "GetNumberOfVariableDependencies", ""},
    {save_and_restore, "GetFMUState", "INSTinEct"},
    {directional, "GetDirectionalDerivative", "NST"},
    {adjoint, "GetAdjointDerivative", "NST"},
    {only_EnterConfigurationMode, "EnterConfigurationMode", ""},
    {only_ExitConfigurationMode, "ExitConfigurationMode", ""},
    {interval, "GetIntervalDecimal", ""},
    {only_EvaluateDiscreteStates, "EvaluateDiscreteStates", ""},
    {update, "UpdateDiscreteStates", "E"},
    {only_EnterContinuousTimeMode, "EnterContinuousTimeMode", "E"},
    {completed, "CompletedIntegratorStep", "c"},
    {set_time, "SetTime", "Ec"},
    {set_states, "SetContinuousStates", "c"},
    {get_slopes, "GetContinuousStateDerivatives", "nEct"},
    {get_indicators, "GetEventIndicators", "nEct"},
    {get_states, "GetContinuousStates", "nEct"},
    {get_nominals, "GetNominalsOfContinuousStates", "nEct"},
    {indicator_count, "GetNumberOfEventIndicators", "inEct"},
    {state_count, "GetNumberOfContinuousStates", "inEct"},
    {only_EnterStepMode, "EnterStepMode", ""},
    {output_derivatives, "GetOutputDerivatives", "ST"},
    {first_step, "DoStep", "S"},
    {activate, "ActivateModelPartition", ""},
};
