#include "traced.h"

#include <math.h>
#include <stdlib.h>

#include "kernels.h"

/* Part of the states' sizes that they may be off closed loops: Newton's step, which the tape has, has the
   derivative of the way to them on them alone. */
#define OFF 1e-11

typedef struct Traced {
    Tape *tape;
    uint64_t point; /* of the instance, that the values are of */
    bool has_values, holds;
} Traced;

void traced_free(Instance *c)
{
    if (!c->traced) return;
    tape_free(c->traced->tape);
    free(c->traced);
    c->traced = NULL;
}

static bool is_off(const Instance *c)
{
    const double *nominal = c->reals + c->ints[AT_x_nominal];

    for (int64_t k = 0; k < c->ints[COUNT_n_x]; k++)
        if (!(fabs(c->led[k] - instance_x(c)[k]) <= OFF * nominal[k])) return true;
    return false;
}

/* Whether the tape holds where the instance is. */
static bool evaluate(Instance *c)
{
    Tape *tape = c->traced->tape;

    if (instance_prepare(c) != STATUS_OK) return false;
    if (!c->exchanges) return tape_evaluate(tape, c, instance_x(c), instance_x(c), false);
    if (instance_lead(c) != STATUS_OK) return false;
    if (c->ints[COUNT_n_row] == 0) return tape_evaluate(tape, c, instance_x(c), c->led, true);
    return !is_off(c) && tape_evaluate(tape, c, c->led, c->led, true);
}

/* Before the simulation parameters act through the start too, which no tape knows. */
static bool begin(Instance *c)
{
    if (c->resource.n.operations == 0 || c->core->mode == INITIALIZATION) return false;
    if (!c->traced) {
        c->traced = calloc(1, sizeof *c->traced);
        if (!c->traced) return false;
        c->traced->tape = tape_create(&c->resource);
        if (!c->traced->tape) {
            traced_free(c);
            return false;
        }
    }

    Traced *t = c->traced;
    if (!t->has_values || t->point != c->point) {
        t->holds = evaluate(c);
        t->point = c->point;
        t->has_values = true;
    }
    if (t->holds) tape_rest(t->tape);
    return t->holds;
}

static const Variable *variable(const Instance *c, uint32_t vr)
{
    return &c->resource.variables[vr];
}

/* Moves what a variable stands in. */
static void move(Instance *c, uint32_t known, int lane, double seed)
{
    Tape *tape = c->traced->tape;
    int64_t index = variable(c, known)->index;

    switch (variable(c, known)->kind) {
        case VARIABLE_INPUT: tape_move(tape, LEAF_U, index, lane, seed); break;
        case VARIABLE_STATE: tape_move(tape, LEAF_STATE, c->ints[AT_x] + index, lane, seed); break;
        default:             tape_move(tape, LEAF_REALS, index, lane, seed);
    }
}

bool traced_each(Instance *c, const uint32_t known[], size_t n)
{
    if (!begin(c)) return false;
    for (size_t i = 0; i < n; i++) move(c, known[i], (int)i, 1);
    tape_forward(c->traced->tape);
    return true;
}

/* Moves what follows from tunable parameters: polynomials of them, so that differences are exact. */
static bool move_prepared(Instance *c, const uint32_t known[], size_t n, const double seed[])
{
    size_t height = columns_height(c, PREPARED);
    double *sum = calloc(height + n + 1, sizeof(double));
    bool any = false;

    if (!sum) return false;

    double *of_parameters = sum + height;
    for (size_t i = 0; i < n; i++)
        if (variable(c, known[i])->kind == VARIABLE_TUNABLE && seed[i] != 0) {
            of_parameters[i] = seed[i];
            any = true;
        }

    bool good = !any || columns_add_along(c, known, n, of_parameters, PREPARED, sum) == STATUS_OK;
    if (any && good) tape_move_state(c->traced->tape, sum);
    free(sum);
    return good;
}

bool traced_along(Instance *c, const uint32_t known[], size_t n, const double seed[])
{
    if (!begin(c)) return false;
    for (size_t i = 0; i < n; i++)
        if (seed[i] != 0) move(c, known[i], 0, seed[i]);
    if (!move_prepared(c, known, n, seed)) return false;
    tape_forward(c->traced->tape);
    return true;
}

bool traced_add(const Instance *c, int lane, Part part, double column[])
{
    const Tape *tape = c->traced->tape;
    int64_t first = part == OUTPUTS ? c->ints[COUNT_n_x] : 0;
    size_t height = columns_height(c, part);

    if (!tape_holds(tape, lane)) return false;
    for (size_t k = 0; k < height; k++)
        if (!isfinite(tape_rate(tape, first + (int64_t)k, lane))) return false;
    for (size_t k = 0; k < height; k++) column[k] += tape_rate(tape, first + (int64_t)k, lane);
    return true;
}

bool traced_is_whole(Instance *c, size_t n)
{
    if (!begin(c)) return false;
    return tape_n_sweeps(c->traced->tape) <= (int64_t)((n + TAPE_LANES - 1) / TAPE_LANES);
}

double *traced_jacobian(Instance *c, size_t *length)
{
    size_t width = (size_t)(c->ints[COUNT_n_x] + c->resource.n.u);

    if (!begin(c)) return NULL;
    *length = (size_t)c->resource.n.results;

    double *jacobian = calloc(width * *length + 1, sizeof(double));
    if (jacobian) tape_add_jacobian(c->traced->tape, jacobian);
    return jacobian;
}
