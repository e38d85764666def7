/* The official FMI 2 headers, the functions and types of the FMU library as its sources have them, and stickslip.h, in one
 * unit: whatever drifts apart does not compile. `fmu_functions.h` declares each function again, with the official names of its types,
 * as far as the sources use these; `fmu_types.h` has its structures and numbers under names of their own.
 */
#include <stddef.h>
#include <stdint.h>

#include <fmi2Functions.h>

#include "fmu_functions.h"
#include "fmu_types.h"
#include <stickslip.h>

#define SAME_SIZE(ours, official) _Static_assert(sizeof(ours) == sizeof(official), #ours " is not " #official)
#define SAME_PLACE(ours, member, official, officially)                                                        \
    _Static_assert(offsetof(ours, member) == offsetof(official, officially), #member " is not " #officially); \
    _Static_assert(sizeof(((ours *)0)->member) == sizeof(((official *)0)->officially), #member " is not " #officially)
#define SAME_NUMBER(ours, official) _Static_assert((int)(ours) == (int)(official), #ours " is not " #official)

SAME_SIZE(fmu_Handle, fmi2Component);
SAME_SIZE(fmu_StateHandle, fmi2FMUstate);
SAME_SIZE(fmu_ValueReference, fmi2ValueReference);
SAME_SIZE(fmu_Real, fmi2Real);
SAME_SIZE(fmu_Integer, fmi2Integer);
SAME_SIZE(fmu_Boolean, fmi2Boolean);
SAME_SIZE(fmu_Byte, fmi2Byte);
SAME_SIZE(fmu_FmiString, fmi2String);
SAME_SIZE(int, fmi2Type);
SAME_SIZE(int, fmi2StatusKind);
_Static_assert(_Generic((fmu_Real)0, fmi2Real: 1, default: 0), "fmi2Real");
_Static_assert(_Generic((fmu_Integer)0, fmi2Integer: 1, default: 0), "fmi2Integer");
_Static_assert(_Generic((fmu_Boolean)0, fmi2Boolean: 1, default: 0), "fmi2Boolean");
_Static_assert(_Generic((fmu_Byte)0, fmi2Byte: 1, default: 0), "fmi2Byte");
_Static_assert(_Generic((fmu_ValueReference)0, fmi2ValueReference: 1, default: 0), "fmi2ValueReference");

SAME_NUMBER(fmu_Status_Ok, fmi2OK);
SAME_NUMBER(fmu_Status_Warning, fmi2Warning);
SAME_NUMBER(fmu_Status_Discard, fmi2Discard);
SAME_NUMBER(fmu_Status_Error, fmi2Error);
SAME_NUMBER(fmu_Status_Fatal, fmi2Fatal);
SAME_NUMBER(fmu_Status_Pending, fmi2Pending);
SAME_NUMBER(fmu_MODEL_EXCHANGE, fmi2ModelExchange);
SAME_NUMBER(fmu_CO_SIMULATION, fmi2CoSimulation);
SAME_NUMBER(fmu_DO_STEP_STATUS, fmi2DoStepStatus);
SAME_NUMBER(fmu_PENDING_STATUS, fmi2PendingStatus);
SAME_NUMBER(fmu_LAST_SUCCESSFUL_TIME, fmi2LastSuccessfulTime);
SAME_NUMBER(fmu_TERMINATED, fmi2Terminated);
SAME_NUMBER(fmu_TRUE, fmi2True);
SAME_NUMBER(fmu_FALSE, fmi2False);

SAME_SIZE(fmu_CallbackFunctions, fmi2CallbackFunctions);
SAME_PLACE(fmu_CallbackFunctions, logger, fmi2CallbackFunctions, logger);
SAME_PLACE(fmu_CallbackFunctions, allocate_memory, fmi2CallbackFunctions, allocateMemory);
SAME_PLACE(fmu_CallbackFunctions, free_memory, fmi2CallbackFunctions, freeMemory);
SAME_PLACE(fmu_CallbackFunctions, step_finished, fmi2CallbackFunctions, stepFinished);
SAME_PLACE(fmu_CallbackFunctions, component_environment, fmi2CallbackFunctions, componentEnvironment);

SAME_SIZE(fmu_EventInfo, fmi2EventInfo);
SAME_PLACE(fmu_EventInfo, new_discrete_states_needed, fmi2EventInfo, newDiscreteStatesNeeded);
SAME_PLACE(fmu_EventInfo, terminate_simulation, fmi2EventInfo, terminateSimulation);
SAME_PLACE(fmu_EventInfo, nominals_of_continuous_states_changed, fmi2EventInfo, nominalsOfContinuousStatesChanged);
SAME_PLACE(fmu_EventInfo, values_of_continuous_states_changed, fmi2EventInfo, valuesOfContinuousStatesChanged);
SAME_PLACE(fmu_EventInfo, next_event_time_defined, fmi2EventInfo, nextEventTimeDefined);
SAME_PLACE(fmu_EventInfo, next_event_time, fmi2EventInfo, nextEventTime);

/* The C interface has numbers of its own; only success is the same. */
SAME_NUMBER(STICKSLIP_STATUS_OK, fmi2OK);
