/* Calls that no importer makes, on the library of an FMU: suite LIBRARY GUID RESOURCES COUNT
 *
 * COUNT random calls in any order with odd arguments; saved states with changed bytes, which must be refused; threads with an instance each,
 * which must agree bit by bit, before and after the locale has a decimal comma; memory over resets. Prints figures, one row
 * of a table, and ends with 1 where a promise is broken. Deterministic but for the memory. */
#include "suite.h"

#include <fmi2FunctionTypes.h>

#define FUNCTIONS(X)                                                                                           \
    X(Instantiate) X(FreeInstance) X(SetDebugLogging) X(SetupExperiment) X(EnterInitializationMode)           \
    X(ExitInitializationMode) X(Terminate) X(Reset) X(GetReal) X(GetInteger) X(GetBoolean) X(GetString) X(SetReal)        \
    X(SetInteger) X(SetBoolean) X(GetFMUstate) X(SetFMUstate) X(FreeFMUstate) X(SerializedFMUstateSize)       \
    X(SerializeFMUstate) X(DeSerializeFMUstate) X(GetDirectionalDerivative) X(SetRealInputDerivatives)        \
    X(GetRealOutputDerivatives) X(DoStep) X(CancelStep) X(GetStatus) X(GetRealStatus) X(EnterEventMode)       \
    X(SetTime) X(GetContinuousStates) X(GetEventIndicators)
#define DECLARE(name) static fmi2##name##TYPE *name;
FUNCTIONS(DECLARE)

enum { WIDE = 4, THREAD_STEPS = 200, ROWS = 60 };
static const char *guid, *resources;

static void quiet(void *environment, fmi2String instance, fmi2Status status, fmi2String category, fmi2String text, ...) {
    (void)environment, (void)instance, (void)category;
    /* An internal error is told; what is refused is as it should be. */
    if (status == fmi2Fatal) {
        va_list arguments;
        va_start(arguments, text);
        vprintf(text, arguments);
        va_end(arguments);
        printf(": ");
    }
}

static fmi2CallbackFunctions callbacks = {quiet, calloc, free, NULL, NULL};

static fmi2Component create(void) {
    fmi2Component one = Instantiate("one", fmi2CoSimulation, guid, resources, &callbacks, fmi2False, fmi2False);
    if (one == NULL) fail("no instance");
    return one;
}

static void start(fmi2Component one) {
    if (SetupExperiment(one, fmi2False, 0.0, 0.0, fmi2False, 0.0) || EnterInitializationMode(one) || ExitInitializationMode(one))
        fail("no start");
}

/* The arguments of one random call. */
typedef struct {
    fmi2ValueReference references[WIDE], others[WIDE];
    fmi2Real values[WIDE], more[WIDE];
    fmi2Integer integers[WIDE];
    fmi2Boolean booleans[WIDE];
    fmi2String strings[WIDE];
    size_t count;
} arguments;

static arguments odd_arguments(void) {
    arguments a;
    a.count = any() % (WIDE + 1);
    for (int k = 0; k < WIDE; k++) {
        a.references[k] = any() % 8 ? (fmi2ValueReference)(any() % 24) : (fmi2ValueReference)any();
        a.others[k] = (fmi2ValueReference)(any() % 6);
        a.values[k] = odd_number();
        a.more[k] = odd_number();
        a.integers[k] = any() % 4 ? 1 : (fmi2Integer)any();
        a.booleans[k] = (fmi2Boolean)any();
        a.strings[k] = "logAll";
    }
    return a;
}

typedef struct {
    fmi2Component one;
    fmi2FMUstate state;
    double time;
} subject;

static fmi2Status call_of_lifecycle(subject *s, arguments *a) {
    fmi2Status status;
    switch (any() % 8) {
    case 0: return SetupExperiment(s->one, a->booleans[0], a->values[0], 0.0, a->booleans[1], a->values[1]);
    case 1: return EnterInitializationMode(s->one);
    case 2: return ExitInitializationMode(s->one);
    case 3: return any() % 8 ? CancelStep(s->one) : Terminate(s->one);
    case 4:
        status = Reset(s->one);
        s->time = 0.0;
        return status;
    case 5: return SetDebugLogging(s->one, a->booleans[0], a->count, any() % 8 ? a->strings : NULL);
    case 6: return GetRealStatus(s->one, (fmi2StatusKind)(any() % 5), a->values);
    default: return any() % 2 ? EnterEventMode(s->one) : SetTime(s->one, a->values[0]);
    }
}

static fmi2Status call_of_values(subject *s, arguments *a) {
    const fmi2ValueReference *known = any() % 16 ? a->references : NULL;
    fmi2Status status;
    switch (any() % 10) {
    case 0: return GetReal(s->one, known, a->count, a->values);
    case 1: return GetInteger(s->one, known, a->count, a->integers);
    case 2: return GetBoolean(s->one, known, a->count, a->booleans);
    case 3: return SetReal(s->one, any() % 4 ? a->others : known, a->count, a->values);
    case 4: return SetInteger(s->one, known, a->count, a->integers);
    case 5: return GetDirectionalDerivative(s->one, known, a->count, a->others, a->count, a->more, a->values);
    case 6: return SetRealInputDerivatives(s->one, a->others, a->count, a->integers, a->values);
    case 7: return GetRealOutputDerivatives(s->one, known, a->count, a->integers, a->values);
    case 8: return any() % 2 ? GetString(s->one, known, a->count, a->strings) : SetBoolean(s->one, known, a->count, a->booleans);
    default: {
        static const double steps[] = {1e-4, 1e-4, 1e-4, 1e-5, 0.0, -1.0, NAN, INFINITY, 1e-300};
        double step = steps[any() % 9], time = any() % 16 ? s->time : odd_number();
        status = DoStep(s->one, time, step, fmi2False);
        if (status == fmi2OK || status == fmi2Warning) s->time = time + step;
        return status;
    }
    }
}

static fmi2Status call_of_states(subject *s, arguments *a) {
    size_t size = 0;
    switch (any() % 5) {
    case 0: return GetFMUstate(s->one, &s->state);
    case 1: return SetFMUstate(s->one, s->state);
    case 2: return FreeFMUstate(s->one, &s->state);
    case 3: return SerializedFMUstateSize(s->one, s->state, any() % 8 ? &size : NULL);
    default: {
        fmi2Byte bytes[64] = {0};
        return DeSerializeFMUstate(s->one, bytes, a->count * 16, &s->state);
    }
    }
}

static void random_calls(long count) {
    long refused = 0;
    subject s = {create(), NULL, 0.0};
    for (long k = 0; k < count; k++) {
        arguments a = odd_arguments();
        if (any() % 5000 == 0) {
            FreeFMUstate(s.one, &s.state);
            FreeInstance(s.one);
            s = (subject){create(), NULL, 0.0};
        }
        uint64_t kind = any() % 8;
        fmi2Status status = kind == 0 ? call_of_lifecycle(&s, &a) : kind == 1 ? call_of_states(&s, &a) : call_of_values(&s, &a);
        if (status == fmi2Fatal) fail("a call was fatal");
        refused += status >= fmi2Discard;
    }
    FreeFMUstate(s.one, &s.state);
    FreeInstance(s.one);
    printf("%ld | %ld | ", count, refused);
}

static void corrupted_states(long count) {
    fmi2Component one = create();
    start(one);
    fmi2FMUstate state = NULL, other = NULL;
    size_t size;
    if (DoStep(one, 0.0, 1e-4, fmi2False) || GetFMUstate(one, &state) || SerializedFMUstateSize(one, state, &size)) fail("no state");
    fmi2Byte *bytes = malloc(size), *changed = malloc(size);
    if (SerializeFMUstate(one, state, bytes, size)) fail("no bytes");
    if (DeSerializeFMUstate(one, bytes, size, &other)) fail("the state itself was refused");
    for (long k = 0; k < count; k++) {
        memcpy(changed, bytes, size);
        changed[any() % size] ^= (fmi2Byte)(1 + any() % 255);
        size_t length = any() % 8 ? size : any() % size;
        if (DeSerializeFMUstate(one, changed, length, &other) < fmi2Discard) fail("a corrupted state was taken");
    }
    FreeFMUstate(one, &state);
    FreeFMUstate(one, &other);
    FreeInstance(one);
    free(bytes);
    free(changed);
    printf("%ld | ", count);
}

/* A run in a thread; the digest of all its numbers. */
static void *run(void *result) {
    fmi2Component one = create();
    start(one);
    uint64_t all = NOTHING;
    for (int step = 0; step < THREAD_STEPS; step++) {
        fmi2ValueReference reference = 0;
        double input = 4e-5 * sin(0.05 * step);
        if (SetReal(one, &reference, 1, &input) || DoStep(one, step * 1e-4, 1e-4, fmi2False)) fail("a step in a thread");
        for (fmi2ValueReference row = 0; row < ROWS; row++) {
            double value;
            /* Unless it is a whole number, or no variable at all. */
            if (GetReal(one, &row, 1, &value) == fmi2OK) all = digest(all, value);
        }
    }
    FreeInstance(one);
    *(uint64_t *)result = all;
    return NULL;
}

static void start_step_and_reset(void *one) {
    start(one);
    if (DoStep(one, 0.0, 1e-5, fmi2False) || Reset(one)) fail("a reset");
}

int main(int argc, char **argv) {
    if (argc != 5) fail("usage: suite LIBRARY GUID RESOURCES COUNT");
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) fail(dlerror());
#define FIND(name) \
    if ((*(void **)&name = dlsym(library, "fmi2" #name)) == NULL) fail("fmi2" #name " is missing");
    FUNCTIONS(FIND)
    guid = argv[2];
    resources = argv[3];
    long count = atol(argv[4]);
    random_calls(count);
    corrupted_states(count / 10);
    threads(run);
    fmi2Component one = create();
    memory(start_step_and_reset, one, count / 5);
    FreeInstance(one);
    printf("\n");
    return 0;
}
