#include "derivatives.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"
#include "variables.h"

/* Part of their sizes by which the knowns move at most. */
#define STRIDE 1e-3

/* Where they move to, and what comes of it counts: (8 (f(h) - f(-h)) - (f(2h) - f(-2h))) / 12h. */
static const double PLACE_OF[4] = {1, -1, 2, -2};
static const double WEIGHT_OF[4] = {8.0 / 12, -8.0 / 12, -1.0 / 12, 1.0 / 12};

static const Variable *variable(const Instance *c, uint32_t vr)
{
    return &c->resource.variables[vr];
}

static Status check(Instance *c, const uint32_t unknown[], size_t n_unknown, const uint32_t known[],
                    size_t n_known, const double seed[], const double sensitivity[])
{
    const char **names = c->resource.names;
    int64_t n = c->resource.n.variables;

    if ((n_unknown > 0 && !(unknown && sensitivity)) || (n_known > 0 && !(known && seed)))
        return instance_refuse(c, "NULL instead of an array");

    for (size_t i = 0; i < n_unknown; i++) {
        if (unknown[i] >= n) return instance_refuse(c, "unknown value reference %u", unknown[i]);
        int64_t kind = variable(c, unknown[i])->kind;
        if (kind != VARIABLE_OUTPUT && kind != VARIABLE_RATE)
            return instance_refuse(c, "'%s' (value reference %u) is no output and no rate",
                                   names[unknown[i]], unknown[i]);
    }
    for (size_t i = 0; i < n_known; i++) {
        if (known[i] >= n) return instance_refuse(c, "unknown value reference %u", known[i]);
        int64_t kind = variable(c, known[i])->kind;
        if (kind != VARIABLE_INPUT && kind != VARIABLE_TUNABLE
            && !(kind == VARIABLE_STATE && c->exchanges))
            return instance_refuse(
                c,
                "'%s' (value reference %u) is no input, no tunable parameter and "
                "no state of model exchange",
                names[known[i]], known[i]);
        if (!isfinite(seed[i]))
            return instance_refuse(c, "the seed of '%s' is %g", names[known[i]], seed[i]);
    }
    return STATUS_OK;
}

/* How large a known is, or may be. */
static double size_of(const Instance *c, uint32_t vr)
{
    double value = fabs(*variables_place(c, vr));

    if (variable(c, vr)->kind == VARIABLE_STATE)
        return fmax(value, c->reals[c->ints[AT_x_nominal] + variable(c, vr)->index]);
    return value > 0 ? value : 1;
}

/* The instance's knowns moved by h along the seed; before, it was as `block` says. */
static void move(Instance *c, const void *block, const uint32_t known[], size_t n,
                 const double seed[], double h)
{
    instance_restore(c, block);
    for (size_t i = 0; i < n; i++) {
        if (seed[i] == 0) continue;
        *variables_place(c, known[i]) += h * seed[i];
        if (variable(c, known[i])->kind == VARIABLE_TUNABLE) c->core->prepared = 0;
        if (c->core->mode == INITIALIZATION) c->core->started = 0;
    }
}

Status derivatives_along(Instance *c, const uint32_t unknown[], size_t n_unknown,
                         const uint32_t known[], size_t n_known, const double seed[],
                         double sensitivity[])
{
    Status result = check(c, unknown, n_unknown, known, n_known, seed, sensitivity);
    if (result != STATUS_OK) return result;

    double h = INFINITY;
    for (size_t i = 0; i < n_known; i++)
        if (seed[i] != 0) h = fmin(h, STRIDE * size_of(c, known[i]) / fabs(seed[i]));
    for (size_t i = 0; i < n_unknown; i++) sensitivity[i] = 0;
    if (!isfinite(h)) return STATUS_OK;

    Core *block = malloc(c->core_size);
    double *value = malloc((n_unknown + 1) * sizeof(double));
    if (!block || !value) result = instance_refuse(c, "out of memory");

    if (result == STATUS_OK) memcpy(block, c->core, c->core_size);
    for (int k = 0; k < 4 && result == STATUS_OK; k++) {
        move(c, block, known, n_known, seed, PLACE_OF[k] * h);
        result = variables_get(c, unknown, n_unknown, value);
        for (size_t i = 0; i < n_unknown && result == STATUS_OK; i++)
            sensitivity[i] += WEIGHT_OF[k] / h * value[i];
    }
    if (block && value) instance_restore(c, block);

    free(block);
    free(value);
    return result;
}

/* The references of all elements of arrays, to be freed; their number in *n. NULL, and `result` says
   why. */
static uint32_t *elements_of(Instance *c, const uint32_t vr[], size_t *n, Status *result)
{
    size_t count = 0, total = 0;

    if (*n > 0 && !vr) {
        *result = instance_refuse(c, "NULL instead of an array");
        return NULL;
    }
    for (size_t i = 0; i < *n; i++) {
        if (vr[i] >= c->resource.n.variables || variable(c, vr[i])->length == 0) {
            *result = instance_refuse(c, "value reference %u is that of no variable here", vr[i]);
            return NULL;
        }
        total += (size_t)variable(c, vr[i])->length;
    }

    uint32_t *elements = malloc((total + 1) * sizeof *elements);
    *result = elements ? STATUS_OK : instance_refuse(c, "out of memory");
    for (size_t i = 0; i < *n && elements; i++)
        for (int64_t k = 0; k < variable(c, vr[i])->length; k++)
            elements[count++] = vr[i] + (uint32_t)k;
    *n = total;
    return elements;
}

Status derivatives_of_arrays(Instance *c, const uint32_t unknown[], size_t n_unknown,
                             const uint32_t known[], size_t n_known, const double seed[],
                             size_t n_seed, double sensitivity[], size_t n_sensitivity)
{
    Status result = STATUS_OK;
    uint32_t *wanted = elements_of(c, unknown, &n_unknown, &result);
    uint32_t *moved = wanted ? elements_of(c, known, &n_known, &result) : NULL;

    if (moved && (n_seed != n_known || n_sensitivity != n_unknown))
        result = instance_refuse(c, "%zu seeds for %zu knowns, %zu places for %zu unknowns", n_seed,
                                 n_known, n_sensitivity, n_unknown);
    else if (moved)
        result = derivatives_along(c, wanted, n_unknown, moved, n_known, seed, sensitivity);
    free(wanted);
    free(moved);
    return result;
}
