/* The least that an FMU of FMI 2.0 can be: a spring of one input and one output, without any check. What calls cost by themselves. */
#include <stdlib.h>

typedef struct { double value[2]; } Spring;

#define FMU __attribute__((visibility("default")))

FMU void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const void *callbacks,
                          int visible, int logging) {
    (void)name, (void)type, (void)guid, (void)resources, (void)callbacks, (void)visible, (void)logging;
    return calloc(1, sizeof(Spring));
}
FMU void fmi2FreeInstance(void *instance) { free(instance); }
FMU int fmi2SetupExperiment(void *instance, int told, double tolerance, double start, int ends, double stop) {
    (void)instance, (void)told, (void)tolerance, (void)start, (void)ends, (void)stop;
    return 0;
}
FMU int fmi2EnterInitializationMode(void *instance) { (void)instance; return 0; }
FMU int fmi2ExitInitializationMode(void *instance) { (void)instance; return 0; }
FMU int fmi2SetReal(void *instance, const unsigned *references, size_t count, const double *values) {
    for (size_t i = 0; i < count; i++) ((Spring *)instance)->value[references[i]] = values[i];
    return 0;
}
FMU int fmi2GetReal(void *instance, const unsigned *references, size_t count, double *values) {
    for (size_t i = 0; i < count; i++) values[i] = ((Spring *)instance)->value[references[i]];
    return 0;
}
FMU int fmi2DoStep(void *instance, double time, double step, int new_point) {
    (void)time, (void)step, (void)new_point;
    Spring *spring = instance;
    spring->value[1] = 7e6 * spring->value[0];
    return 0;
}
