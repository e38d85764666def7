/* Loads the library of an FMU, steps it, and prints its outputs: step LIBRARY GUID RESOURCES < PROTOCOL
 *
 * The protocol: the numbers of inputs, of outputs and of steps, the step (s); the value references of the inputs and of
 * the outputs; for each step the inputs. A line of outputs is printed for each step. Half way the state is saved, and
 * the next step is made twice; another result of the second ends the program. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
typedef HMODULE Module;
#define OPEN(file) LoadLibraryA(file)
#define FIND(module, name) ((void *)GetProcAddress(module, name))
#else
#include <dlfcn.h>
typedef void *Module;
#define OPEN(file) dlopen(file, RTLD_NOW | RTLD_LOCAL)
#define FIND(module, name) dlsym(module, name)
#endif

typedef void *Component;
typedef void *State;

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void *finished;
    void *environment;
} Callbacks;

static void say(void *environment, const char *instance, int status, const char *category, const char *message, ...) {
    va_list arguments;
    (void)environment;
    va_start(arguments, message);
    fprintf(stderr, "%s %d %s: ", instance, status, category);
    vfprintf(stderr, message, arguments);
    fputc('\n', stderr);
    va_end(arguments);
}

static void fail(const char *what) {
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}

static double number(void) {
    double value;
    if (scanf("%lf", &value) != 1) fail("reading the protocol");
    return value;
}

static unsigned *references(size_t count) {
    unsigned *list = calloc(count + 1, sizeof *list);
    for (size_t k = 0; k < count; ++k) list[k] = (unsigned)number();
    return list;
}

#define FUNCTION(result, name, ...) \
    result (*name)(__VA_ARGS__) = (result (*)(__VA_ARGS__))FIND(module, "fmi2" #name); \
    if (!name) fail("looking up fmi2" #name)
#define CALL(call) \
    if (call) fail(#call)

int main(int count, char **arguments) {
    if (count != 4) fail("reading LIBRARY GUID RESOURCES");
    Module module = OPEN(arguments[1]);
    if (!module) fail("loading the library");
    FUNCTION(Component, Instantiate, const char *, int, const char *, const char *, const Callbacks *, int, int);
    FUNCTION(int, SetupExperiment, Component, int, double, double, int, double);
    FUNCTION(int, EnterInitializationMode, Component);
    FUNCTION(int, ExitInitializationMode, Component);
    FUNCTION(int, SetReal, Component, const unsigned *, size_t, const double *);
    FUNCTION(int, GetReal, Component, const unsigned *, size_t, double *);
    FUNCTION(int, DoStep, Component, double, double, int);
    FUNCTION(int, GetFMUstate, Component, State *);
    FUNCTION(int, SetFMUstate, Component, State);
    FUNCTION(int, FreeFMUstate, Component, State *);
    FUNCTION(int, Terminate, Component);
    FUNCTION(void, FreeInstance, Component);

    size_t inputs = (size_t)number(), outputs = (size_t)number(), steps = (size_t)number();
    double step = number();
    unsigned *in = references(inputs), *out = references(outputs);
    double *set = calloc(inputs + 1, sizeof *set), *got = calloc(outputs + 1, sizeof *got);
    double *again = calloc(outputs + 1, sizeof *again);

    Callbacks callbacks = {say, calloc, free, NULL, NULL};
    Component fmu = Instantiate("fmu", 1, arguments[2], arguments[3], &callbacks, 0, 0);
    if (!fmu) fail("fmi2Instantiate");
    CALL(SetupExperiment(fmu, 0, 0.0, 0.0, 0, 0.0));
    CALL(EnterInitializationMode(fmu));
    CALL(ExitInitializationMode(fmu));
    for (size_t k = 0; k < steps; ++k) {
        State saved = NULL;
        for (size_t input = 0; input < inputs; ++input) set[input] = number();
        if (k == steps / 2) CALL(GetFMUstate(fmu, &saved));
        CALL(SetReal(fmu, in, inputs, set));
        CALL(DoStep(fmu, (double)k * step, step, 1));
        CALL(GetReal(fmu, out, outputs, got));
        if (saved) {
            CALL(SetFMUstate(fmu, saved));
            CALL(FreeFMUstate(fmu, &saved));
            CALL(SetReal(fmu, in, inputs, set));
            CALL(DoStep(fmu, (double)k * step, step, 1));
            CALL(GetReal(fmu, out, outputs, again));
            if (memcmp(got, again, outputs * sizeof *got)) fail("repeating a step from a saved state");
        }
        for (size_t output = 0; output < outputs; ++output) printf("%.17g ", got[output]);
        printf("\n");
    }
    CALL(Terminate(fmu));
    FreeInstance(fmu);
    return 0;
}
