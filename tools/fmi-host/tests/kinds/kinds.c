/* An FMU of FMI 3.0 whose outputs are its inputs of every type, held over a step, and their arrays. Its `level` follows the
 * rate that is told within steps, by the trapezoidal rule of ten parts. */
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef uint32_t Reference;
typedef void (*Log)(void *, int, const char *, const char *);
typedef void (*Update)(void *, double, bool, bool, bool, bool, bool *, double *);

enum { PARTS = 10 };

typedef struct {
    double f64, list[3], rate, level, limit;
    float f32;
    int8_t i8;
    uint8_t u8;
    int16_t i16;
    uint16_t u16;
    int32_t i32;
    uint32_t u32;
    int64_t i64, mode;
    uint64_t u64;
    bool boolean;
    char text[64];
} Values;

typedef struct {
    Values in, out;
    double time;
    Log log;
    Update update;
    void *environment;
    bool stepping, told;
    int failed;
} Instance;

static int fail(Instance *m, const char *message) {
    m->log(m->environment, 3, "logStatusError", message);
    m->failed = 1;
    return 3;
}

void *fmi3InstantiateCoSimulation(const char *name, const char *token, const char *path, bool visible, bool logging,
                                  bool event_mode, bool early_return, const Reference *required, size_t count,
                                  void *environment, Log log, Update update) {
    (void)name; (void)path; (void)visible; (void)logging; (void)early_return; (void)required;
    if (strcmp(token, "kinds-token") != 0) {
        log(environment, 3, "logStatusError", "the instantiationToken is another");
        return NULL;
    }
    if (event_mode) return NULL;
    Instance *m = calloc(1, sizeof *m);
    m->log = log;
    m->update = count > 0 ? update : NULL;
    m->environment = environment;
    m->in = (Values){.f64 = 1.0, .limit = 1e3, .list = {1.0, 2.0, 3.0}};
    return m;
}
void fmi3FreeInstance(void *c) { free(c); }
int fmi3EnterInitializationMode(void *c, bool d, double t, double start, bool e, double stop) {
    (void)d; (void)t; (void)e; (void)stop;
    ((Instance *)c)->time = start;
    return 0;
}
int fmi3ExitInitializationMode(void *c) { Instance *m = c; m->out = m->in; m->out.level = 0.0; return 0; }
int fmi3Terminate(void *c) { return ((Instance *)c)->failed ? 3 : 0; }

/* Inputs have the references 1 to 20, outputs those and 100, the array 13 has three values. */
#define GET_SET(NAME, TYPE, REFERENCE, FIELD)                                                                    \
    int fmi3Get##NAME(void *c, const Reference *r, size_t n, TYPE *v, size_t nv) {                               \
        Instance *m = c;                                                                                         \
        if (nv != n) return fail(m, "lengths of " #NAME);                                                        \
        for (size_t k = 0; k < n; k++) {                                                                         \
            if (r[k] == REFERENCE) v[k] = m->in.FIELD;                                                           \
            else if (r[k] == 100 + REFERENCE) v[k] = m->out.FIELD;                                               \
            else return fail(m, "##no " #NAME " of this reference");                                             \
        }                                                                                                        \
        return 0;                                                                                                \
    }                                                                                                            \
    int fmi3Set##NAME(void *c, const Reference *r, size_t n, const TYPE *v, size_t nv) {                         \
        Instance *m = c;                                                                                         \
        if (nv != n) return fail(m, "lengths of " #NAME);                                                        \
        for (size_t k = 0; k < n; k++) {                                                                         \
            if (r[k] != REFERENCE) return fail(m, #NAME " that cannot be set");                                  \
            m->in.FIELD = v[k];                                                                                  \
        }                                                                                                        \
        return 0;                                                                                                \
    }
GET_SET(Float32, float, 2, f32)
GET_SET(Int8, int8_t, 3, i8)
GET_SET(UInt8, uint8_t, 4, u8)
GET_SET(Int16, int16_t, 5, i16)
GET_SET(UInt16, uint16_t, 6, u16)
GET_SET(Int32, int32_t, 7, i32)
GET_SET(UInt32, uint32_t, 8, u32)
GET_SET(UInt64, uint64_t, 10, u64)
GET_SET(Boolean, bool, 11, boolean)

static int64_t *long_of(Instance *m, Reference r) {
    switch (r) {
    case 9: return &m->in.i64;
    case 109: return &m->out.i64;
    case 12: return &m->in.mode;
    case 112: return &m->out.mode;
    default: return NULL;
    }
}
int fmi3GetInt64(void *c, const Reference *r, size_t n, int64_t *v, size_t nv) {
    if (nv != n) return fail(c, "lengths of Int64");
    for (size_t k = 0; k < n; k++) {
        int64_t *own = long_of(c, r[k]);
        if (!own) return fail(c, "no Int64 of this reference");
        v[k] = *own;
    }
    return 0;
}
int fmi3SetInt64(void *c, const Reference *r, size_t n, const int64_t *v, size_t nv) {
    if (nv != n) return fail(c, "lengths of Int64");
    for (size_t k = 0; k < n; k++) {
        int64_t *own = long_of(c, r[k]);
        if (!own || r[k] > 100) return fail(c, "Int64 that cannot be set");
        *own = v[k];
    }
    return 0;
}

static double *float_of(Instance *m, Reference r, size_t *length) {
    *length = 1;
    switch (r) {
    case 0: return &m->time;
    case 1: return &m->in.f64;
    case 101: return &m->out.f64;
    case 13: *length = 3; return m->in.list;
    case 113: *length = 3; return m->out.list;
    case 14: return &m->in.rate;
    case 115: return &m->out.level;
    case 16: return &m->in.limit;
    default: return NULL;
    }
}
int fmi3GetFloat64(void *c, const Reference *r, size_t n, double *v, size_t nv) {
    size_t at = 0, length;
    for (size_t k = 0; k < n; k++) {
        double *own = float_of(c, r[k], &length);
        if (!own || at + length > nv) return fail(c, "no Float64 of this reference, or too few values");
        memcpy(v + at, own, length * sizeof *v);
        at += length;
    }
    return at == nv ? 0 : fail(c, "too many values");
}
int fmi3SetFloat64(void *c, const Reference *r, size_t n, const double *v, size_t nv) {
    Instance *m = c;
    size_t at = 0, length;
    for (size_t k = 0; k < n; k++) {
        double *own = float_of(m, r[k], &length);
        if (!own || r[k] == 0 || r[k] > 100 || at + length > nv) return fail(m, "Float64 that cannot be set");
        if (m->stepping && r[k] != 14) return fail(m, "within a step only `rate` is set");
        for (size_t i = 0; i < length; i++)
            if (v[at + i] > 1e6) {
                m->log(m->environment, 2, "logStatusDiscard", "#1# is more than 1e6");
                return 2;
            }
        memcpy(own, v + at, length * sizeof *v);
        if (m->stepping) m->told = true;
        at += length;
    }
    return at == nv ? 0 : fail(m, "too many values");
}
int fmi3GetString(void *c, const Reference *r, size_t n, const char **v, size_t nv) {
    Instance *m = c;
    if (n != 1 || nv != 1 || (r[0] != 15 && r[0] != 117)) return fail(m, "no String of this reference");
    *v = m->in.text;
    return 0;
}
int fmi3SetString(void *c, const Reference *r, size_t n, const char *const *v, size_t nv) {
    Instance *m = c;
    if (n != 1 || nv != 1 || r[0] != 15) return fail(m, "no String of this reference");
    snprintf(m->in.text, sizeof m->in.text, "%s", v[0]);
    return 0;
}

int fmi3DoStep(void *c, double time, double step, bool last, bool *event, bool *terminate, bool *early, double *reached) {
    Instance *m = c;
    (void)last;
    *event = *early = *terminate = false;
    double level = m->out.level, before = m->in.rate;
    for (int part = 1; part <= PARTS; part++) {
        double at = time + step * part / PARTS;
        if (m->update) {
            bool wants = false;
            double when = at;
            m->stepping = true;
            m->update(m->environment, at, true, false, false, false, &wants, &when);
            m->stepping = false;
            if (m->failed) return 3;
        }
        level += 0.5 * (before + m->in.rate) * step / PARTS;
        before = m->in.rate;
    }
    m->out = m->in;
    m->out.level = level;
    m->time = *reached = time + step;
    if (m->time > m->in.limit) {
        m->log(m->environment, 0, "logEvents", "the limit is passed");
        *terminate = true;
    }
    return 0;
}
int fmi3GetFMUState(void *c, void **state) {
    if (!*state) *state = malloc(sizeof(Instance));
    memcpy(*state, c, sizeof(Instance));
    return 0;
}
int fmi3SetFMUState(void *c, void *state) { memcpy(c, state, sizeof(Instance)); return 0; }
int fmi3FreeFMUState(void *c, void **state) { (void)c; free(*state); *state = NULL; return 0; }

/* For importers that want to find every function; none is called. */
#define ABSENT(NAME) int fmi3##NAME(void) { return 3; }
ABSENT(SetDebugLogging) ABSENT(InstantiateModelExchange) ABSENT(InstantiateScheduledExecution) ABSENT(EnterEventMode)
ABSENT(Reset) ABSENT(GetBinary) ABSENT(GetClock) ABSENT(SetBinary) ABSENT(SetClock)
ABSENT(GetNumberOfVariableDependencies) ABSENT(GetVariableDependencies) ABSENT(SerializedFMUStateSize)
ABSENT(SerializeFMUState) ABSENT(DeserializeFMUState) ABSENT(GetDirectionalDerivative) ABSENT(GetAdjointDerivative)
ABSENT(EnterConfigurationMode) ABSENT(ExitConfigurationMode) ABSENT(GetIntervalDecimal) ABSENT(GetIntervalFraction)
ABSENT(GetShiftDecimal) ABSENT(GetShiftFraction) ABSENT(SetIntervalDecimal) ABSENT(SetIntervalFraction)
ABSENT(SetShiftDecimal) ABSENT(SetShiftFraction) ABSENT(EvaluateDiscreteStates) ABSENT(UpdateDiscreteStates)
ABSENT(EnterContinuousTimeMode) ABSENT(CompletedIntegratorStep) ABSENT(SetTime) ABSENT(SetContinuousStates)
ABSENT(GetContinuousStateDerivatives) ABSENT(GetEventIndicators) ABSENT(GetContinuousStates)
ABSENT(GetNominalsOfContinuousStates) ABSENT(GetNumberOfEventIndicators) ABSENT(GetNumberOfContinuousStates)
ABSENT(EnterStepMode) ABSENT(GetOutputDerivatives) ABSENT(ActivateModelPartition)
const char *fmi3GetVersion(void) { return "3.0"; }
