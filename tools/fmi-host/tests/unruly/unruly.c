/* An FMU that does what the parameter `behaviour` says at the first step that ends after 0.45 s. */
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

typedef void (*Logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    Logger logger;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} Callbacks;

typedef struct {
    const Callbacks *callbacks;
    char name[64];
    char text[64];
    double u, y, last;
    int behaviour, flag;
} Instance;

enum { ABORT = 1, SEGMENTATION = 2, EXIT = 3, DISCARD = 4, FAIL = 5, FATAL = 6, FLOOD = 7, PRINT = 8, END = 9, HANG = 10,
       EXIT_ZERO = 11, NO_NUMBER = 12 };

void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources, const Callbacks *callbacks,
                      int visible, int logging) {
    (void)type; (void)resources; (void)visible; (void)logging;
    if (strcmp(guid, "unruly-guid") != 0) {
        callbacks->logger(callbacks->environment, name, 3, "logStatusError", "the GUID is not %s", guid);
        return NULL;
    }
    Instance *instance = callbacks->allocate(1, sizeof *instance);
    instance->callbacks = callbacks;
    strncpy(instance->name, name, sizeof instance->name - 1);
    return instance;
}
void fmi2FreeInstance(void *c) { Instance *i = c; i->callbacks->release(i); }
int fmi2SetupExperiment(void *c, int d, double t, double s, int e, double f) {
    (void)c; (void)d; (void)t; (void)s; (void)e; (void)f; return 0;
}
int fmi2EnterInitializationMode(void *c) { (void)c; return 0; }
int fmi2ExitInitializationMode(void *c) { (void)c; return 0; }
int fmi2Terminate(void *c) { (void)c; return 0; }

static int unknown(Instance *i, unsigned reference) {
    i->callbacks->logger(i->callbacks->environment, i->name, 3, "logStatusError", "no variable %u", reference);
    return 3;
}
int fmi2SetReal(void *c, const unsigned *r, size_t n, const double *v) {
    Instance *i = c;
    for (size_t k = 0; k < n; k++) {
        if (r[k] != 0) return unknown(i, r[k]);
        if (v[k] > 1e6) {
            i->callbacks->logger(i->callbacks->environment, i->name, 2, "logStatusDiscard",
                                 "#r0# = %g is more than %d", v[k], 1000000);
            return 2;
        }
        i->u = v[k];
    }
    return 0;
}
int fmi2GetReal(void *c, const unsigned *r, size_t n, double *v) {
    Instance *i = c;
    for (size_t k = 0; k < n; k++) {
        if (r[k] == 0) v[k] = i->u;
        else if (r[k] == 1) v[k] = i->y;
        else return unknown(i, r[k]);
    }
    return 0;
}
int fmi2SetInteger(void *c, const unsigned *r, size_t n, const int *v) {
    for (size_t k = 0; k < n; k++) { if (r[k] != 2) return unknown(c, r[k]); ((Instance *)c)->behaviour = v[k]; }
    return 0;
}
int fmi2GetInteger(void *c, const unsigned *r, size_t n, int *v) {
    for (size_t k = 0; k < n; k++) { if (r[k] != 2) return unknown(c, r[k]); v[k] = ((Instance *)c)->behaviour; }
    return 0;
}
int fmi2SetBoolean(void *c, const unsigned *r, size_t n, const int *v) {
    (void)r; for (size_t k = 0; k < n; k++) ((Instance *)c)->flag = v[k]; return 0;
}
int fmi2GetBoolean(void *c, const unsigned *r, size_t n, int *v) {
    /* FMI allows any number but zero for true. */
    (void)r; for (size_t k = 0; k < n; k++) v[k] = ((Instance *)c)->flag ? -5 : 0; return 0;
}
int fmi2SetString(void *c, const unsigned *r, size_t n, const char *const *v) {
    (void)r; (void)n; strncpy(((Instance *)c)->text, v[0], 63); return 0;
}
int fmi2GetString(void *c, const unsigned *r, size_t n, const char **v) {
    (void)r; (void)n; v[0] = ((Instance *)c)->text; return 0;
}
int fmi2GetRealStatus(void *c, int kind, double *v) {
    if (kind != 2) return 2;
    *v = ((Instance *)c)->last;
    return 0;
}
int fmi2GetBooleanStatus(void *c, int kind, int *v) {
    if (kind != 3) return 2;
    *v = ((Instance *)c)->behaviour == END;
    return 0;
}
int fmi2DoStep(void *c, double t, double h, int final) {
    Instance *i = c;
    (void)final;
    i->last = t + h;
    if (i->behaviour == PRINT) { printf("hello from %s\n", i->name); fflush(stdout); }
    if (i->behaviour == FLOOD)
        for (int k = 0; k < 1000; k++)
            i->callbacks->logger(i->callbacks->environment, i->name, 0, "logAll", "message %d at %.6f", k, t);
    if (t + h > 0.45) {
        switch (i->behaviour) {
        case ABORT: fprintf(stderr, "the end is near\n"); abort();
        case SEGMENTATION: *(volatile int *)8 = 1; break;
        case EXIT: _exit(7);
        case EXIT_ZERO: exit(0);
        case NO_NUMBER: i->y = 0.0 / 0.0; return 0;
        case DISCARD: if (h > 0.03) { i->last = t + 0.5 * h; return 2; } break;
        case END: return 2;
        case HANG: {
            const char *sign = getenv("UNRULY_SIGN");
            if (sign) fclose(fopen(sign, "w"));
            for (;;) pause();
        }
        case FAIL:
            i->callbacks->logger(i->callbacks->environment, i->name, 3, "logStatusError", "%s gave up at %.2f s", i->name, t);
            return 3;
        case FATAL:
            i->callbacks->logger(i->callbacks->environment, i->name, 4, "logStatusFatal", "%s", "100 % lost");
            return 4;
        }
    }
    i->y += h * i->u;
    return 0;
}
