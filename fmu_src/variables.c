#include "variables.h"

#include <math.h>
#include <string.h>

static int64_t kind_of(const Instance *c, uint32_t vr)
{
    return c->resource.variables[vr].kind;
}

/* Where the value of a variable is. */
static double *place_of(const Instance *c, uint32_t vr)
{
    int64_t index = c->resource.variables[vr].index;

    switch (kind_of(c, vr)) {
        case VARIABLE_INPUT:  return c->u + index;
        case VARIABLE_OUTPUT: return c->y + index;
        default:              return c->reals + index;
    }
}

/* Refuses references to nothing, and NULL for an array that has elements. */
static Status check_references(Instance *c, const uint32_t vr[], size_t n, const void *value)
{
    if (n > 0 && !(vr && value)) return instance_refuse(c, "NULL instead of an array");
    for (size_t i = 0; i < n; i++)
        if (vr[i] >= c->resource.n.variables)
            return instance_refuse(c, "unknown value reference %u", vr[i]);
    return STATUS_OK;
}

Status variables_get(Instance *c, const uint32_t vr[], size_t n, double value[])
{
    const char **names = c->resource.names;
    Status result = check_references(c, vr, n, value);

    for (size_t i = 0; i < n && result == STATUS_OK; i++) {
        if (kind_of(c, vr[i]) == VARIABLE_OUTPUT) result = instance_outputs(c);
        if (result == STATUS_OK) value[i] = *place_of(c, vr[i]);
        if (result == STATUS_OK && !isfinite(value[i]))
            return instance_refuse(c, "'%s' (value reference %u) is %g", names[vr[i]], vr[i],
                                   value[i]);
    }
    return result;
}

/* Refuses what may not be set. */
static Status check_set(Instance *c, uint32_t vr, double value)
{
    const char *name = c->resource.names[vr];
    bool running = c->core->mode == STEP_COMPLETE;

    if (kind_of(c, vr) == VARIABLE_OUTPUT)
        return instance_refuse(c, "'%s' (value reference %u) is an output and cannot be set", name,
                               vr);
    if (running && kind_of(c, vr) == VARIABLE_FIXED)
        return instance_refuse(
            c, "the parameter '%s' (value reference %u) is fixed after the initialization", name,
            vr);
    if (!isfinite(value))
        return instance_refuse(c, "%g is no value for '%s' (value reference %u)", value, name, vr);
    return STATUS_OK;
}

Status variables_set(Instance *c, const uint32_t vr[], size_t n, const double value[])
{
    Status result = check_references(c, vr, n, value);

    for (size_t i = 0; i < n && result == STATUS_OK; i++) result = check_set(c, vr[i], value[i]);
    if (result != STATUS_OK) return result;

    for (size_t i = 0; i < n; i++) {
        double *place = place_of(c, vr[i]);

        /* a value that stands already changes nothing, not even what the solver remembers */
        if (memcmp(place, &value[i], sizeof *place) == 0) continue;

        *place = value[i];
        c->current = false;
        if (c->core->mode != STEP_COMPLETE) c->core->started = 0;
        if (kind_of(c, vr[i]) != VARIABLE_INPUT) c->core->prepared = 0;
    }
    return STATUS_OK;
}

/* Refuses what is no derivative of an input. */
static Status check_derivative(Instance *c, uint32_t vr, int32_t order, double value)
{
    const char *name = c->resource.names[vr];

    if (kind_of(c, vr) != VARIABLE_INPUT)
        return instance_refuse(c, "'%s' (value reference %u) is not an input", name, vr);
    if (order < 1 || order >= N_DERIVATIVE)
        return instance_refuse(c, "order %d of '%s': orders 1 to %d are known", (int)order, name,
                               N_DERIVATIVE - 1);
    if (!isfinite(value))
        return instance_refuse(c, "%g is no derivative of '%s' (value reference %u)", value, name,
                               vr);
    return STATUS_OK;
}

Status variables_set_derivatives(Instance *c, const uint32_t vr[], size_t n, const int32_t order[],
                                 const double value[])
{
    Status result = check_references(c, vr, n, order ? value : NULL);

    for (size_t i = 0; i < n && result == STATUS_OK; i++)
        result = check_derivative(c, vr[i], order[i], value[i]);
    if (result != STATUS_OK) return result;

    for (size_t i = 0; i < n; i++) place_of(c, vr[i])[order[i] * c->resource.n.u] = value[i];

    /* the speed of a commanded motion may be a derivative of its position */
    c->current = false;
    return STATUS_OK;
}
