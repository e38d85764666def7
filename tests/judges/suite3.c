/* Calls that no importer makes, on the library of an FMU of FMI 3.0: suite3 LIBRARY TOKEN RESOURCES COUNT
 *
 * Every function in every state, which must succeed where the standard allows it and be an error everywhere else; arguments that are
 * wrong; states that go on bit by bit in the same and in another instance, also by their bytes; MANY instances at once, freed in
 * any state; COUNT random calls in any order with odd arguments; saved states with changed bytes; threads; memory over
 * resets. Prints figures, one row of a table, and ends with 1 where a promise is broken. Deterministic but for the memory. */
#include "suite3.h"

static fmi3Instance in_state(char state) {
    fmi3Instance one = strchr("INST", state) ? slave() : model();
    if (strchr("Nn", state) && enter_initialization(one)) fail("no initialization mode");
    if (strchr("STEct", state)) start(one);
    if (state == 'c' && EnterContinuousTimeMode(one)) fail("no continuous-time mode");
    if (strchr("Tt", state) && Terminate(one)) fail("no end");
    return one;
}

/* Every instance is freed in the state that it is in. */
static void mask(void) {
    int cells = 0;
    for (const cell *row = MASK; row < MASK + sizeof MASK / sizeof *MASK; row++) {
        if (row->call(NULL) != fmi3Error) fail("a call without an instance is no error");
        for (const char *state = STATES; *state; state++, cells++) {
            fmi3Instance one = in_state(*state);
            fmi3Status status = row->call(one), expected = strchr(row->allowed, *state) ? fmi3OK : fmi3Error;
            if (status != expected) {
                printf("%s in state %c: status %d, not %d", row->name, *state, status, expected);
                fail("");
            }
            if (status == fmi3Error && cells % 2 && Reset(one)) fail("no reset after an error");
            FreeInstance(one);
        }
    }
    FreeInstance(NULL);
    printf("%d | ", cells);
}

enum { WRONG = 33 };

/* A call with something wrong. */
static fmi3Status wrong(fmi3Instance one, int which) {
    const fmi3ValueReference unknown = 4000000000u;
    fmi3FMUState state = &seed;
    fmi3Byte bytes[8] = {0};
    fmi3Int64 integer;
    fmi3Int32 orders[] = {-1, 1000};
    double value = NAN, two[2] = {0.0, 0.0};
    bool flag;
    switch (which) {
    case 0: return GetFloat64(one, NULL, 1, &value, 1);
    case 1: return GetFloat64(one, &output, 1, NULL, 1);
    case 2: return GetFloat64(one, &output, 1, two, 2);
    case 3: return GetFloat64(one, &output, 1, two, 0);
    case 4: return GetFloat64(one, &unknown, 1, &value, 1);
    case 5: return GetInt64(one, &output, 1, &integer, 1);
    case 6: return GetInt64(one, &unknown, 1, &integer, 1);
    case 7: return SetFloat64(one, &input, 1, &value, 1);
    case 8: return SetFloat64(one, &output, 1, two, 1);
    case 9: return SetFloat64(one, &unknown, 1, two, 1);
    case 10: return SetFloat64(one, &input, 1, NULL, 1);
    case 11: return SetFloat64(one, &input, 1, two, 2);
    case 12: return SetFloat64(one, NULL, 1, two, 1);
    case 13: return SetString(one, &input, 1, NULL, 1);
    case 14: return GetFMUState(one, NULL);
    case 15: return SetFMUState(one, NULL);
    case 16: return SetFMUState(one, state);
    case 17: return FreeFMUState(one, &state);
    case 18: return SerializedFMUStateSize(one, NULL, NULL);
    case 19: return SerializeFMUState(one, NULL, bytes, 8);
    case 20: return DeserializeFMUState(one, NULL, 8, &state);
    case 21: return DeserializeFMUState(one, bytes, 8, NULL);
    case 22: return GetDirectionalDerivative(one, &output, 1, &unknown, 1, two, 1, &value, 1);
    case 23: return GetDirectionalDerivative(one, &output, 1, &input, 1, two, 2, &value, 1);
    case 24: return GetAdjointDerivative(one, &output, 1, &input, 1, NULL, 1, &value, 1);
    case 25: return GetOutputDerivatives(one, &output, 1, &orders[0], &value, 1);
    case 26: return GetOutputDerivatives(one, &output, 1, &orders[1], &value, 1);
    case 27: return DoStep(one, 0.0, 1e-5, true, NULL, &flag, &flag, &value);
    case 28: return DoStep(one, 0.0, 1e-5, true, &flag, &flag, &flag, NULL);
    case 29: return step(one, 0.0, -1.0);
    case 30: return step(one, 0.0, NAN);
    case 31: return step(one, 1.0, 1e-5);
    default: return SetDebugLogging(one, true, 1, NULL);
    }
}

static void wrong_arguments(void) {
    for (int which = 0; which < WRONG; which++) {
        fmi3Instance one = slave();
        start(one);
        fmi3Status status = wrong(one, which);
        if (status != fmi3Error && status != fmi3Discard) fail("a wrong argument is neither an error nor discarded");
        FreeInstance(one);
    }
    fmi3String other[] = {NULL, "", "{00000000-0000-0000-0000-000000000000}"};
    for (int k = 0; k < 3; k++)
        if (InstantiateCoSimulation("one", other[k], resources, false, false, false, false, NULL, 0, NULL, told, NULL)
            || InstantiateModelExchange("one", token, other[k], false, false, NULL, NULL))
            fail("an instance of another model, or from nowhere");
    if (InstantiateScheduledExecution("one", token, resources, false, false, NULL, told, NULL, NULL, NULL)) fail("a wrong interface");
    printf("%d | ", WRONG + 7);
}

/* Steps, and the digest of all numbers after each. */
static uint64_t go(fmi3Instance one, int from, int to) {
    uint64_t all = NOTHING;
    for (int k = from; k < to; k++) {
        double value = 4e-5 * sin(0.05 * k), values[ROWS];
        if (SetFloat64(one, &input, 1, &value, 1) || step(one, k * 1e-4, 1e-4)) fail("a step");
        if (GetFloat64(one, numbers, number_count, values, number_count)) fail("no numbers");
        for (size_t n = 0; n < number_count; n++) all = digest(all, values[n]);
    }
    return all;
}

static void *run(void *result) {
    fmi3Instance one = slave();
    start(one);
    *(uint64_t *)result = go(one, 0, 2 * STEPS);
    FreeInstance(one);
    return NULL;
}

/* The bytes of the state of an instance. */
static fmi3Byte *bytes_of(fmi3Instance one, fmi3FMUState *state, size_t *size) {
    if (GetFMUState(one, state) || SerializedFMUStateSize(one, *state, size)) fail("no state");
    fmi3Byte *bytes = malloc(*size);
    if (SerializeFMUState(one, *state, bytes, *size)) fail("no bytes");
    return bytes;
}

static void saved_states(long corrupted) {
    fmi3Instance one = slave(), other = slave();
    fmi3FMUState state = NULL, again = NULL;
    size_t size, size_again;
    start(one);
    go(one, 0, STEPS);
    fmi3Byte *bytes = bytes_of(one, &state, &size);
    uint64_t first = go(one, STEPS, 2 * STEPS);
    if (SetFMUState(one, state) || go(one, STEPS, 2 * STEPS) != first) fail("a restored state goes on otherwise");
    if (DeserializeFMUState(other, bytes, size, &again) || SetFMUState(other, again)) fail("the bytes were refused");
    fmi3Byte *changed = bytes_of(other, &again, &size_again);
    if (size_again != size || memcmp(bytes, changed, size)) fail("the state has other bytes");
    if (go(other, STEPS, 2 * STEPS) != first) fail("a state from bytes goes on otherwise");
    for (long k = 0; k < corrupted; k++) {
        memcpy(changed, bytes, size);
        changed[any() % size] ^= (fmi3Byte)(1 + any() % 255);
        size_t length = any() % 8 ? size : any() % size;
        if (DeserializeFMUState(other, changed, length, &again) < fmi3Discard) fail("a corrupted state was taken");
        /* An error ends the instance. */
        if (Reset(other)) fail("no reset after an error");
    }
    FreeFMUState(other, &state);
    FreeFMUState(other, &again);
    FreeInstance(one);
    FreeInstance(other);
    free(bytes);
    free(changed);
    printf("%ld | ", corrupted);
}

/* All at once, each with the numbers of one alone, freed in the states that they are in. */
static void many(void) {
    static fmi3Instance all[MANY];
    uint64_t first = 0;
    for (int k = 0; k < MANY; k++) all[k] = in_state(STATES[k % (sizeof STATES - 1)]);
    for (int k = 2; k < MANY; k += sizeof STATES - 1) {
        uint64_t found = go(all[k], 0, 5);
        if (k > 2 && found != first) fail("one of many instances has other numbers");
        first = found;
    }
    for (int k = MANY - 1; k >= 0; k--) FreeInstance(all[k]);
    printf("%d | ", MANY);
}

/* The arguments of one random call. */
typedef struct {
    fmi3ValueReference references[WIDE], others[WIDE];
    double values[SIZES], more[WIDE];
    fmi3Int64 integers[WIDE];
    fmi3Int32 orders[WIDE];
    bool flags[5];
    size_t count, other_count;
} arguments;

static void odd_arguments(arguments *a) {
    a->count = any() % (WIDE + 1);
    a->other_count = any() % 8 ? a->count : any() % (WIDE + 1);
    for (int k = 0; k < WIDE; k++) {
        a->references[k] = any() % 16 ? numbers[any() % number_count] : (fmi3ValueReference)any();
        a->others[k] = (fmi3ValueReference)(any() % 3);
        a->values[k] = odd_number();
        a->more[k] = odd_number();
        a->integers[k] = (fmi3Int64)any();
        a->orders[k] = any() % 4 ? 1 : (fmi3Int32)any();
    }
}

typedef struct {
    fmi3Instance one;
    fmi3FMUState state;
    bool continuous;
    double time;
} subject;

/* What an importer does within a step may be as wrong. */
static void within(
    fmi3InstanceEnvironment environment, double time, bool set, bool get, bool finished, bool can, bool *early, double *when
) {
    (void)time, (void)set, (void)get, (void)finished, (void)can, (void)early, (void)when;
    subject *s = environment;
    double value = odd_number();
    switch (any() % 8) {
    case 0: GetFloat64(s->one, &output, 1, &value, 1); break;
    case 1: Reset(s->one); break;
    case 2: FreeInstance(s->one); break;
    case 3: step(s->one, time, 1e-5); break;
    default: SetFloat64(s->one, &input, 1, &value, 1);
    }
}

static void renew(subject *s) {
    if (s->one != NULL) {
        FreeFMUState(s->one, &s->state);
        FreeInstance(s->one);
    }
    *s = (subject){NULL, NULL, any() % 3 == 0, 0.0};
    fmi3ValueReference listed[] = {input, output};
    s->one = s->continuous ? model()
                           : InstantiateCoSimulation("one", token, resources, false, any() % 2, false, any() % 2, listed, any() % 3, s, told, within);
    if (s->one == NULL) fail("no instance");
}

static fmi3Status call_of_lifecycle(subject *s, arguments *a) {
    switch (any() % 8) {
    case 0: return EnterInitializationMode(s->one, any() % 2, a->values[0], 0.0, any() % 2, a->values[1]);
    case 1: return ExitInitializationMode(s->one);
    case 2: return any() % 8 ? EnterStepMode(s->one) : Terminate(s->one);
    case 3: s->time = 0.0; return Reset(s->one);
    case 4: return MASK[any() % (sizeof MASK / sizeof *MASK)].call(s->one);
    case 5: return EnterEventMode(s->one);
    default: return EnterContinuousTimeMode(s->one);
    }
}

static fmi3Status call_of_values(subject *s, arguments *a) {
    const fmi3ValueReference *known = any() % 16 ? a->references : NULL;
    size_t count = a->count, other = a->other_count;
    switch (any() % 8) {
    case 0: return GetFloat64(s->one, known, count, a->values, other);
    case 1: return SetFloat64(s->one, any() % 4 ? a->others : known, count, a->values, other);
    case 2: return GetInt64(s->one, known, count, a->integers, other);
    case 3: return SetInt64(s->one, known, count, a->integers, other);
    case 4: return GetDirectionalDerivative(s->one, known, count, a->others, count, a->more, other, a->values, count);
    case 5: return GetAdjointDerivative(s->one, known, count, a->others, count, a->more, other, a->values, count);
    case 6: return GetOutputDerivatives(s->one, known, count, a->orders, a->values, other);
    default: return SetBoolean(s->one, known, count, a->flags, other);
    }
}

static fmi3Status call_of_time(subject *s, arguments *a) {
    if (!s->continuous) {
        static const double steps[] = {1e-4, 1e-4, 1e-4, 1e-5, 0.0, -1.0, NAN, INFINITY, 1e-300};
        double size = steps[any() % 9], time = any() % 16 ? s->time : odd_number();
        fmi3Status status = step(s->one, time, size);
        if (status < fmi3Discard) s->time = time + size;
        return status;
    }
    size_t count = any() % 16 ? states : any() % SIZES;
    switch (any() % 8) {
    case 0: return SetTime(s->one, any() % 4 ? s->time += 1e-5 : odd_number());
    case 1: return SetContinuousStates(s->one, a->values, count);
    case 2: return GetContinuousStates(s->one, a->values, count);
    case 3: return GetContinuousStateDerivatives(s->one, a->values, count);
    case 4: return GetNominalsOfContinuousStates(s->one, a->values, count);
    case 5: return GetEventIndicators(s->one, a->values, any() % 16 ? indicators : count);
    case 6: return completed(s->one);
    default: return update(s->one);
    }
}

static fmi3Status call_of_states(subject *s, arguments *a) {
    size_t size = 0;
    switch (any() % 5) {
    case 0: return GetFMUState(s->one, &s->state);
    case 1: return SetFMUState(s->one, s->state);
    case 2: return FreeFMUState(s->one, &s->state);
    case 3: return SerializedFMUStateSize(s->one, s->state, any() % 8 ? &size : NULL);
    default: {
        fmi3Byte bytes[64] = {0};
        return DeserializeFMUState(s->one, bytes, a->count * 16, &s->state);
    }
    }
}

/* An error ends an instance, so that most of them begin again at once. */
static void begin_again(subject *s) {
    s->time = 0.0;
    if (Reset(s->one)) fail("no reset after an error");
    if (any() % 8 == 0) return;
    start(s->one);
    if (s->continuous && EnterContinuousTimeMode(s->one)) fail("no continuous-time mode");
}

static void random_calls(long count) {
    long refused = 0;
    subject s = {0};
    arguments a = {0};
    renew(&s);
    for (long k = 0; k < count; k++) {
        odd_arguments(&a);
        if (any() % 5000 == 0) renew(&s);
        uint64_t kind = any() % 16;
        fmi3Status status = kind == 0  ? call_of_lifecycle(&s, &a)
                            : kind < 3 ? call_of_states(&s, &a)
                            : kind < 9 ? call_of_values(&s, &a)
                                       : call_of_time(&s, &a);
        if (status == fmi3Fatal) fail("a call was fatal");
        refused += status >= fmi3Discard;
        if (status == fmi3Error && any() % 8) begin_again(&s);
    }
    FreeFMUState(s.one, &s.state);
    FreeInstance(s.one);
    printf("%ld | %ld | ", count, refused);
}

static void start_step_and_reset(void *one) {
    start(one);
    if (step(one, 0.0, 1e-5) || Reset(one)) fail("a reset");
}

/* What the suite has to know of the model. */
static void explore(void) {
    fmi3Instance one = slave();
    for (fmi3ValueReference row = 0; row < ROWS; row++) {
        double value;
        start(one);
        if (GetFloat64(one, &row, 1, &value, 1) == fmi3OK) numbers[number_count++] = row;
        Reset(one);
    }
    for (size_t n = 0; n < number_count && output == 0; n++) {
        output = numbers[n];
        start(one);
        if (directional(one) || output_derivatives(one)) output = 0;
        Reset(one);
    }
    if (output == 0) fail("no output");
    FreeInstance(one);
    one = model();
    if (GetNumberOfContinuousStates(one, &states) || GetNumberOfEventIndicators(one, &indicators)) fail("no sizes");
    if (states > SIZES || indicators > SIZES) fail("too large for this suite");
    FreeInstance(one);
}

int main(int argc, char **argv) {
    if (argc != 5) fail("usage: suite3 LIBRARY TOKEN RESOURCES COUNT");
    void *library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) fail(dlerror());
#define FIND(name) \
    if ((*(void **)&name = dlsym(library, "fmi3" #name)) == NULL) fail("fmi3" #name " is missing");
    FUNCTIONS(FIND)
    if (strcmp(GetVersion(), "3.0")) fail("another version");
    token = argv[2];
    resources = argv[3];
    long count = atol(argv[4]);
    explore();
    mask();
    wrong_arguments();
    random_calls(count);
    saved_states(count / 10);
    many();
    threads(run);
    fmi3Instance one = slave();
    memory(start_step_and_reset, one, count / 5);
    FreeInstance(one);
    printf("\n");
    return 0;
}
