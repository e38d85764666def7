/* What the calls of an FMU of FMI 2.0 cost: measure LIBRARY GUID RESOURCES STEP OUTPUT [INPUT AMPLITUDE]
   Prints nanoseconds of fmi2DoStep (inputs held), of fmi2SetReal + fmi2DoStep + fmi2GetReal (input moving), of these without
   the step, of fmi2GetDirectionalDerivative of the output by the input after a step (where the FMU has it), microseconds from
   fmi2Instantiate to the end of the initialization and fmi2FreeInstance, and bytes of the heap that an instance takes. Times are the
   shortest and the median of many batches. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

typedef struct {
    void (*logger)(void *, const char *, int, const char *, const char *, ...);
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

static void logger(void *environment, const char *name, int status, const char *category, const char *text, ...) {
    (void)environment;
    fprintf(stderr, "%s %d %s: %s\n", name, status, category, text);
}

static Callbacks callbacks = {logger, calloc, free, NULL, NULL};
static void *(*instantiate)(const char *, int, const char *, const char *, const void *, int, int);
static void (*release)(void *);
static int (*set_up)(void *, int, double, double, int, double);
static int (*enter)(void *);
static int (*leave)(void *);
static int (*set_real)(void *, const unsigned *, size_t, const double *);
static int (*get_real)(void *, const unsigned *, size_t, double *);
static int (*do_step)(void *, double, double, int);
static int (*derive)(void *, const unsigned *, size_t, const unsigned *, size_t, const double *, double *);
static const char *guid, *resources;

enum { BATCHES = 401, CALLS = 2000, INSTANCES = 400 };

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return 1e9 * (double)time.tv_sec + (double)time.tv_nsec;
}

static void check(int failed, const char *what) {
    if (failed) {
        fprintf(stderr, "%s fails\n", what);
        exit(1);
    }
}

static void *ready(void) {
    void *instance = instantiate("one", 1, guid, resources, &callbacks, 0, 0);
    check(instance == NULL, "fmi2Instantiate");
    check(set_up(instance, 0, 0.0, 0.0, 0, 0.0) != 0, "fmi2SetupExperiment");
    check(enter(instance) != 0, "fmi2EnterInitializationMode");
    check(leave(instance) != 0, "fmi2ExitInitializationMode");
    return instance;
}

static int by_size(const void *one, const void *other) {
    double difference = *(const double *)one - *(const double *)other;
    return (difference > 0.0) - (difference < 0.0);
}

static void tell(const char *name, double *times, int count, double each) {
    qsort(times, (size_t)count, sizeof *times, by_size);
    printf("\"%s\": [%.4g, %.4g], ", name, times[0] / each, times[count / 2] / each);
}

static unsigned input, output;
static double step, amplitude;
static long done;

static void take_step(void *instance) {
    check(do_step(instance, (double)done++ * step, step, 1) != 0, "fmi2DoStep");
}

static void held(void *instance) {
    for (int call = 0; call < CALLS; call++) take_step(instance);
}

static void set_and_get(void *instance, int call, int steps) {
    int place = call % 64;
    double moved = amplitude * (place < 32 ? place / 16.0 - 1.0 : 3.0 - place / 16.0), value;
    check(set_real(instance, &input, 1, &moved) != 0, "fmi2SetReal");
    if (steps) take_step(instance);
    check(get_real(instance, &output, 1, &value) != 0, "fmi2GetReal");
}

static void moving(void *instance) {
    for (int call = 0; call < CALLS; call++) set_and_get(instance, call, 1);
}

static void around(void *instance) {
    for (int call = 0; call < CALLS; call++) set_and_get(instance, call, 0);
}

static void derivative(void *instance) {
    double direction = 1.0, change;
    for (int call = 0; call < CALLS; call++)
        check(derive(instance, &output, 1, &input, 1, &direction, &change) != 0, "fmi2GetDirectionalDerivative");
}

static void made(void *instance) {
    (void)instance;
    for (int call = 0; call < 10; call++) release(ready());
}

static void batches(const char *name, void (*batch)(void *), void *instance, double each) {
    double times[BATCHES];
    for (int k = 0; k < BATCHES; k++) {
        double start = now();
        batch(instance);
        times[k] = now() - start;
    }
    tell(name, times, BATCHES, each);
}

static void tell_heap(void) {
    static void *all[INSTANCES];
    size_t before = mallinfo2().uordblks + mallinfo2().hblkhd;
    for (int i = 0; i < INSTANCES; i++) all[i] = ready();
    size_t after = mallinfo2().uordblks + mallinfo2().hblkhd;
    printf("\"bytes\": %.0f}\n", (double)(after - before) / INSTANCES);
    for (int i = 0; i < INSTANCES; i++) release(all[i]);
}

static int find(void *library) {
#define FIND(function, name) check((*(void **)&function = dlsym(library, name)) == NULL, name)
    FIND(instantiate, "fmi2Instantiate");
    FIND(release, "fmi2FreeInstance");
    FIND(set_up, "fmi2SetupExperiment");
    FIND(enter, "fmi2EnterInitializationMode");
    FIND(leave, "fmi2ExitInitializationMode");
    FIND(set_real, "fmi2SetReal");
    FIND(get_real, "fmi2GetReal");
    FIND(do_step, "fmi2DoStep");
    *(void **)&derive = dlsym(library, "fmi2GetDirectionalDerivative");
    return derive != NULL;
}

int main(int count, char **words) {
    if (count != 6 && count != 8) {
        fprintf(stderr, "measure LIBRARY GUID RESOURCES STEP OUTPUT [INPUT AMPLITUDE]\n");
        return 2;
    }
    void *library = dlopen(words[1], RTLD_NOW | RTLD_LOCAL);
    if (library == NULL) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    int moves = count > 7, derives = find(library) && moves;
    guid = words[2], resources = words[3];
    step = atof(words[4]), output = (unsigned)atoi(words[5]);
    if (moves) input = (unsigned)atoi(words[6]), amplitude = atof(words[7]);
    void *instance = ready();
    double unknown = 1.0, change;
    printf("{");
    batches("held", held, instance, CALLS);
    if (moves) batches("moving", moving, instance, CALLS);
    if (moves) batches("around", around, instance, CALLS);
    /* Where it fails, the instance may be of no use any more. */
    derives = derives && derive(instance, &output, 1, &input, 1, &unknown, &change) == 0;
    if (derives) batches("derivative", derivative, instance, CALLS);
    release(instance);
    batches("instance", made, NULL, 10 * 1e3);
    tell_heap();
    return 0;
}
