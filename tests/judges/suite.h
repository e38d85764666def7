/* What the suites of calls for both versions of FMI have in common. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <float.h>
#include <locale.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { THREADS = 4 };
static uint64_t seed = 0x9e3779b97f4a7c15u;

static uint64_t any(void) {
    seed ^= seed << 13;
    seed ^= seed >> 7;
    seed ^= seed << 17;
    return seed;
}

static void fail(const char *what) {
    printf("%s\n", what);
    exit(1);
}

static double odd_number(void) {
    static const double numbers[] = {0.0, -0.0, 1.0, -1.0, 1e-6, -3e-5, 100.0, 1e-3, 1e30, -1e300, DBL_MIN, 5e-324};
    switch (any() % 16) {
    case 0: return NAN;
    case 1: return INFINITY;
    case 2: return -INFINITY;
    default: return numbers[any() % (sizeof numbers / sizeof *numbers)];
    }
}

/* Of all numbers one after the other. */
static const uint64_t NOTHING = 14695981039346656037u;

static uint64_t digest(uint64_t before, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    return (before ^ bits) * 1099511628211u;
}

/* The same run alone and in threads, which store the digest of all numbers. */
static void threads(void *(*run)(void *)) {
    pthread_t running[THREADS];
    uint64_t alone, digests[THREADS];
    run(&alone);
    /* Where LOCPATH has one with a decimal comma. */
    const char *point = setlocale(LC_ALL, "comma") ? localeconv()->decimal_point : ".";
    for (int k = 0; k < THREADS; k++)
        if (pthread_create(&running[k], NULL, run, &digests[k])) fail("no thread");
    for (int k = 0; k < THREADS; k++) {
        pthread_join(running[k], NULL);
        if (digests[k] != alone) fail("a thread has other numbers");
    }
    printf("%d, equal bit by bit, decimal `%s` | ", THREADS, point);
}

static long resident(void) {
    long pages = 0, all;
    FILE *file = fopen("/proc/self/statm", "r");
    if (file == NULL || fscanf(file, "%ld %ld", &all, &pages) != 2) fail("no memory figures");
    fclose(file);
    return pages * 4;
}

/* Memory over resets, of which the first tenth does not count. */
static void memory(void (*start_step_and_reset)(void *), void *one, long resets) {
    long before = 0;
    for (long k = 0; k < resets; k++) {
        if (k == resets / 10) before = resident();
        start_step_and_reset(one);
    }
    long grown = resident() - before;
    printf("%+ld", grown);
    /* Few resets are run under valgrind, whose own memory grows. */
    if (resets > 10000 && grown > 256) fail(" kB grown");
}
