/* Two bar elements on frictional supports under a cycle of load: Newton's method with the contacts' tangents.
 *
 *     |====(1)====o====(2)====o---> P(t)
 *     |           |           |
 *                ###         ###      a contact at each free node
 *
 * Equilibrium of the nodes: K u + T(u) = (0, P). T depends on the way that u has gone, so that every iteration goes from the
 * state that was saved at the last equilibrium. With the tangents dT/du the iterations converge quadratically: the
 * program measures the order over the last changes above rounding and fails where it is below 1.7.
 *
 *     cc newton.c $(pkg-config --cflags --libs stickslip) -lm && ./a.out friction.toml
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <stickslip.h>

enum { NODES = 2, STEPS = 24, MOST_ITERATIONS = 10 };

static const double BAR = 5e6;      /* N/m, stiffness of one element */
static const double LOAD = 260.0;   /* N, amplitude */
static const double ROUNDING = 1e-17; /* m, relative to the 50 um that the end moves */

typedef struct {
    stickslip_model *contact[NODES];
    stickslip_state *saved[NODES];
    size_t displacement, force; /* places of the variables */
    size_t inputs, outputs;
    double *input, *output, *tangent; /* room for one contact */
} problem;

static void need(stickslip_status status) {
    if (status != STICKSLIP_STATUS_OK) {
        fprintf(stderr, "%s\n", stickslip_error_text());
        exit(EXIT_FAILURE);
    }
}

static void *room(size_t count, size_t size) {
    void *memory = calloc(count, size);
    if (memory == NULL) {
        fprintf(stderr, "no memory is left\n");
        exit(EXIT_FAILURE);
    }
    return memory;
}

static char *read_text(const char *path) {
    FILE *file = fopen(path, "rb");
    if (file == NULL) {
        perror(path);
        exit(EXIT_FAILURE);
    }
    char *text = room(1 << 16, 1);
    size_t length = fread(text, 1, (1 << 16) - 1, file);
    text[length] = '\0';
    fclose(file);
    return text;
}

static problem set_up(const char *path) {
    problem p = {0};
    char *text = read_text(path);
    need(stickslip_create(text, &p.contact[0]));
    free(text);
    const stickslip_model *first = p.contact[0];
    p.inputs = stickslip_variable_count(first, STICKSLIP_KIND_INPUT);
    p.outputs = stickslip_variable_count(first, STICKSLIP_KIND_OUTPUT);
    need(stickslip_variable_find(first, STICKSLIP_KIND_INPUT, "displacement", &p.displacement));
    need(stickslip_variable_find(first, STICKSLIP_KIND_OUTPUT, "force", &p.force));
    p.input = room(p.inputs, sizeof *p.input);
    p.output = room(p.outputs, sizeof *p.output);
    p.tangent = room(p.inputs * p.outputs, sizeof *p.tangent);
    /* The load that presses stays as the file has it. */
    size_t load;
    need(stickslip_variable_find(first, STICKSLIP_KIND_INPUT, "normal_load", &load));
    p.input[load] = 147.15;
    need(stickslip_start(p.contact[0], p.input, 0.0, NULL));
    for (int node = 1; node < NODES; node++) {
        need(stickslip_copy(first, &p.contact[node]));
    }
    return p;
}

static void free_all(problem *p) {
    for (int node = 0; node < NODES; node++) {
        stickslip_state_free(p->saved[node]);
        stickslip_free(p->contact[node]);
    }
    free(p->input);
    free(p->output);
    free(p->tangent);
}

/* The force of a contact that goes from its last equilibrium to u, and its derivative. */
static double force_at(problem *p, int node, double u, double *derivative) {
    need(stickslip_restore(p->contact[node], p->saved[node]));
    p->input[p->displacement] = u;
    need(stickslip_step(p->contact[node], p->input, 1.0, p->output));
    need(stickslip_tangent(p->contact[node], p->tangent));
    *derivative = p->tangent[p->force * p->inputs + p->displacement];
    return p->output[p->force];
}

/* One iteration: changes u; returns the length of the change. */
static double iterate(problem *p, double u[NODES], double load) {
    double d0, d1;
    double f0 = force_at(p, 0, u[0], &d0), f1 = force_at(p, 1, u[1], &d1);
    double r0 = -(2.0 * BAR * u[0] - BAR * u[1] + f0);
    double r1 = load - (BAR * u[1] - BAR * u[0] + f1);
    double a = 2.0 * BAR + d0, b = -BAR, c = BAR + d1;
    double determinant = a * c - b * b;
    double s0 = (c * r0 - b * r1) / determinant, s1 = (a * r1 - b * r0) / determinant;
    u[0] += s0;
    u[1] += s1;
    return hypot(s0, s1);
}

/* Newton's method for one load; returns the order with which its last changes fell, or 0 where there are too few. */
static double solve(problem *p, double u[NODES], double load) {
    double change[MOST_ITERATIONS];
    int count = 0;
    for (int node = 0; node < NODES; node++) {
        need(stickslip_save(p->contact[node], &p->saved[node]));
    }
    do {
        if (count == MOST_ITERATIONS) {
            fprintf(stderr, "no equilibrium at %g N\n", load);
            exit(EXIT_FAILURE);
        }
        change[count] = iterate(p, u, load);
    } while (change[count++] > ROUNDING);
    printf("%8.2f N: changes", load);
    for (int k = 0; k < count; k++) {
        printf(" %.1e", change[k]);
    }
    /* The last change is at the limit of rounding; the three before it tell the order. */
    double order = 0.0;
    if (count >= 4 && change[count - 2] > 10.0 * ROUNDING) {
        order = log(change[count - 2] / change[count - 3]) / log(change[count - 3] / change[count - 4]);
        printf(" m, order %.2f\n", order);
    } else {
        printf(" m\n");
    }
    return order;
}

int main(int argc, char **argv) {
    if (argc != 2) {
        fprintf(stderr, "usage: %s model.toml\n", argv[0]);
        return EXIT_FAILURE;
    }
    problem p = set_up(argv[1]);
    double u[NODES] = {0.0, 0.0}, lowest = INFINITY, work = 0.0;
    const double pi = 3.14159265358979323846;
    double before = 0.0, load_before = 0.0;
    for (int step = 1; step <= STEPS; step++) {
        double load = LOAD * sin(2.0 * pi * step / STEPS);
        double order = solve(&p, u, load);
        if (order != 0.0) {
            lowest = fmin(lowest, order);
        }
        work += 0.5 * (load + load_before) * (u[1] - before);
        before = u[1];
        load_before = load;
    }
    printf("the load has done %.3e J of work in a cycle\n", work);
    free_all(&p);
    if (!(lowest > 1.7 && lowest < INFINITY) || work <= 0.0) {
        fprintf(stderr, "the lowest order is %.2f\n", lowest);
        return EXIT_FAILURE;
    }
    return EXIT_SUCCESS;
}
