#include "derivatives.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "columns.h"
#include "variables.h"

static const Variable *variable(const Instance *c, uint32_t vr)
{
    return &c->resource.variables[vr];
}

static Part part_of(const Instance *c, uint32_t unknown)
{
    return variable(c, unknown)->kind == VARIABLE_OUTPUT ? OUTPUTS : RATES;
}

/* Refuses what is no unknown, what is no known, and seeds that are not finite. */
static Status check(Instance *c, const uint32_t unknown[], size_t n_unknown, const uint32_t known[],
                    size_t n_known, const double seed[], size_t n_seed, const double sensitivity[])
{
    const char **names = c->resource.names;
    int64_t n = c->resource.n.variables;

    if ((n_unknown > 0 && !unknown) || (n_known > 0 && !known) || (n_seed > 0 && !seed)
        || !sensitivity)
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
    }
    for (size_t i = 0; i < n_seed; i++)
        if (!isfinite(seed[i])) return instance_refuse(c, "seed %zu is %g", i + 1, seed[i]);
    return STATUS_OK;
}

/* Whether any of the unknowns is of a part. */
static bool has_part(const Instance *c, const uint32_t unknown[], size_t n, Part part)
{
    for (size_t i = 0; i < n; i++)
        if (part_of(c, unknown[i]) == part) return true;
    return false;
}

/* Whether the columns of a part are to be found along the seed one by one: but one is missing, or as many
   evaluations along several were made already. */
static bool by_columns(Instance *c, const uint32_t known[], size_t n, const double seed[],
                       Part part)
{
    size_t missing = 0, *asked = columns_asked(c);

    for (size_t i = 0; i < n; i++)
        if (seed[i] != 0 && !columns_has(c, known[i], part)) missing++;
    return missing < 2 || !asked || (*asked)++ >= missing;
}

/* Adds the derivatives of the unknowns of a part, by columns that are kept. */
static Status add_columns(Instance *c, const uint32_t unknown[], size_t n_unknown,
                          const uint32_t known[], size_t n_known, const double seed[], Part part,
                          double sensitivity[])
{
    for (size_t i = 0; i < n_known; i++) {
        Status result = STATUS_OK;

        if (seed[i] == 0) continue;
        const double *column = columns_get(c, known[i], part, &result);
        if (!column) return result;
        for (size_t k = 0; k < n_unknown; k++)
            if (part_of(c, unknown[k]) == part)
                sensitivity[k] += seed[i] * column[variable(c, unknown[k])->index];
    }
    return STATUS_OK;
}

/* Adds those that evaluations along the seed tell. */
static Status add_along(Instance *c, const uint32_t unknown[], size_t n_unknown,
                        const uint32_t known[], size_t n_known, const double seed[], Part part,
                        double sensitivity[])
{
    double *sum = calloc(columns_height(c, part) + 1, sizeof(double));
    Status result = sum ? columns_add_along(c, known, n_known, seed, part, sum)
                        : instance_refuse(c, "out of memory");

    for (size_t k = 0; k < n_unknown && result == STATUS_OK; k++)
        if (part_of(c, unknown[k]) == part) sensitivity[k] += sum[variable(c, unknown[k])->index];
    free(sum);
    return result;
}

/* Refuses results that are not finite. */
static Status check_result(Instance *c, const uint32_t vr[], size_t n, const double sensitivity[])
{
    for (size_t i = 0; i < n; i++)
        if (!isfinite(sensitivity[i]))
            return instance_refuse(c, "the derivative at '%s' (value reference %u) is %g",
                                   c->resource.names[vr[i]], vr[i], sensitivity[i]);
    return STATUS_OK;
}

Status derivatives_along(Instance *c, const uint32_t unknown[], size_t n_unknown,
                         const uint32_t known[], size_t n_known, const double seed[],
                         double sensitivity[])
{
    if (n_unknown == 0) return STATUS_OK;
    Status result = check(c, unknown, n_unknown, known, n_known, seed, n_known, sensitivity);

    if (result == STATUS_OK) memset(sensitivity, 0, n_unknown * sizeof(double));
    for (Part part = OUTPUTS; part < N_PART && result == STATUS_OK; part++) {
        if (!has_part(c, unknown, n_unknown, part)) continue;
        result = (by_columns(c, known, n_known, seed, part) ? add_columns : add_along)(
            c, unknown, n_unknown, known, n_known, seed, part, sensitivity);
    }
    return result == STATUS_OK ? check_result(c, unknown, n_unknown, sensitivity) : result;
}

/* The derivative of the unknowns, weighted by the seed, by each known. */
static Status adjoint_of(Instance *c, const uint32_t unknown[], size_t n_unknown,
                         const uint32_t known[], size_t n_known, const double seed[],
                         double sensitivity[])
{
    if (n_known == 0) return STATUS_OK;
    Status result = check(c, unknown, n_unknown, known, n_known, seed, n_unknown, sensitivity);

    for (size_t j = 0; j < n_known && result == STATUS_OK; j++) {
        const double *column[N_PART] = {NULL};
        for (Part part = OUTPUTS; part < N_PART && result == STATUS_OK; part++)
            if (has_part(c, unknown, n_unknown, part))
                column[part] = columns_get(c, known[j], part, &result);
        double sum = 0;
        for (size_t i = 0; i < n_unknown && result == STATUS_OK; i++)
            sum += seed[i] * column[part_of(c, unknown[i])][variable(c, unknown[i])->index];
        sensitivity[j] = sum;
    }
    return result == STATUS_OK ? check_result(c, known, n_known, sensitivity) : result;
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

Status derivatives_of_arrays(Instance *c, bool adjoint, const uint32_t unknown[], size_t n_unknown,
                             const uint32_t known[], size_t n_known, const double seed[],
                             size_t n_seed, double sensitivity[], size_t n_sensitivity)
{
    Status result = STATUS_OK;
    uint32_t *wanted = elements_of(c, unknown, &n_unknown, &result);
    uint32_t *moved = wanted ? elements_of(c, known, &n_known, &result) : NULL;

    size_t seeds = adjoint ? n_unknown : n_known, places = adjoint ? n_known : n_unknown;

    if (moved && (n_seed != seeds || n_sensitivity != places))
        result = instance_refuse(c, "%zu seeds for %zu %s, %zu places for %zu %s", n_seed, seeds,
                                 adjoint ? "unknowns" : "knowns", n_sensitivity, places,
                                 adjoint ? "knowns" : "unknowns");
    else if (moved && adjoint)
        result = adjoint_of(c, wanted, n_unknown, moved, n_known, seed, sensitivity);
    else if (moved)
        result = derivatives_along(c, wanted, n_unknown, moved, n_known, seed, sensitivity);
    free(wanted);
    free(moved);
    return result;
}
