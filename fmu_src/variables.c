#include "variables.h"

#include <math.h>
#include <string.h>

#include "events.h"
#include "survey.h"
#include "tolerance.h"

static int64_t kind_of(const Instance *c, uint32_t vr)
{
    return c->resource.variables[vr].kind;
}

/* Whether it follows from others. */
static bool is_calculated(const Instance *c, uint32_t vr)
{
    int64_t kind = kind_of(c, vr);

    return kind == VARIABLE_OUTPUT || kind == VARIABLE_STATE || kind == VARIABLE_RATE
           || kind == VARIABLE_INDICATOR || kind == VARIABLE_LOCAL;
}

/* Whether it is a state that a solver outside may set: some (CasADi) set them one by one. */
static bool is_solved(const Instance *c, uint32_t vr)
{
    return kind_of(c, vr) == VARIABLE_STATE && (c->core->mode & EXCHANGE_MODES);
}

/* Brings the value of a variable up to date. */
static Status find(Instance *c, uint32_t vr)
{
    switch (kind_of(c, vr)) {
        case VARIABLE_OUTPUT:    return instance_outputs(c);
        case VARIABLE_STATE:     return instance_prepare(c);
        case VARIABLE_RATE:      return instance_rates(c);
        case VARIABLE_INDICATOR: return events_indicators(c);
        case VARIABLE_LOCAL:     return survey_local(c, c->resource.variables[vr].index);
        default:                 return STATUS_OK;
    }
}

double *variables_place(const Instance *c, uint32_t vr)
{
    int64_t index = c->resource.variables[vr].index;

    switch (kind_of(c, vr)) {
        case VARIABLE_INPUT:     return c->u + index;
        case VARIABLE_OUTPUT:    return c->y + index;
        case VARIABLE_STATE:     return instance_x(c) + index;
        case VARIABLE_RATE:      return c->rates + index;
        case VARIABLE_INDICATOR: return c->indicators + index;
        case VARIABLE_LOCAL:     return c->surveyed + index;
        default:                 return c->reals + index;
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

/* The value of a variable, brought up to date. */
static Status get(Instance *c, uint32_t vr, double *value)
{
    const char *name = c->resource.names[vr];

    if (is_calculated(c, vr) && c->core->mode == INSTANTIATED)
        return instance_refuse(
            c,
            "'%s' (value reference %u) is calculated and has no value before the "
            "initialization",
            name, vr);

    Status result = find(c, vr);
    if (result != STATUS_OK) return result;

    *value = *variables_place(c, vr);
    if (isfinite(*value)) return STATUS_OK;
    return instance_refuse(c, "'%s' (value reference %u) is %g", name, vr, *value);
}

Status variables_get(Instance *c, const uint32_t vr[], size_t n, double value[])
{
    Status result = check_references(c, vr, n, value);

    for (size_t i = 0; i < n && result == STATUS_OK; i++) result = get(c, vr[i], &value[i]);
    return result;
}

/* Refuses what may not be set. */
static Status check_set(Instance *c, uint32_t vr, double value)
{
    const char *name = c->resource.names[vr];
    bool running = c->core->mode & (STEP_MODES | EXCHANGE_MODES);

    if (is_calculated(c, vr) && !is_solved(c, vr))
        return instance_refuse(c, "'%s' (value reference %u) is %s and cannot be set", name, vr,
                               kind_of(c, vr) == VARIABLE_OUTPUT ? "an output" : "calculated");
    if (kind_of(c, vr) == VARIABLE_CONSTANT)
        return instance_refuse(c, "the parameter '%s' (value reference %u) is bound: a constant",
                               name, vr);
    if (running && kind_of(c, vr) == VARIABLE_FIXED)
        return instance_refuse(
            c, "the parameter '%s' (value reference %u) is fixed after the initialization", name,
            vr);
    if (c->core->mode == CONTINUOUS_TIME && kind_of(c, vr) != VARIABLE_INPUT && !is_solved(c, vr))
        return instance_refuse(
            c, "the parameter '%s' (value reference %u) can be set in event mode only", name, vr);
    if (!isfinite(value))
        return instance_refuse(c, "%g is no value for '%s' (value reference %u)", value, name, vr);
    return STATUS_OK;
}

static void set(Instance *c, uint32_t vr, double value)
{
    double *place = variables_place(c, vr);

    if (kind_of(c, vr) == VARIABLE_TUNABLE) tolerance_told(c, c->resource.variables[vr].index);

    /* a value that stands already changes nothing, not even what the solver remembers */
    if (memcmp(place, &value, sizeof *place) == 0) return;

    *place = value;
    instance_changed(c);
    if (c->core->mode & (INSTANTIATED | INITIALIZATION)) c->core->started = 0;
    if (kind_of(c, vr) != VARIABLE_INPUT && !is_solved(c, vr)) c->core->prepared = 0;
}

Status variables_set(Instance *c, const uint32_t vr[], size_t n, const double value[])
{
    Status result = check_references(c, vr, n, value);

    for (size_t i = 0; i < n && result == STATUS_OK; i++) result = check_set(c, vr[i], value[i]);
    for (size_t i = 0; i < n && result == STATUS_OK; i++) set(c, vr[i], value[i]);
    return result;
}

/* ---- arrays ---- */

static bool is_time(const Instance *c, uint32_t vr)
{
    return vr == c->resource.n.variables;
}

/* How many values a reference means. */
static size_t length_of(const Instance *c, uint32_t vr)
{
    return is_time(c, vr) ? 1 : (size_t)c->resource.variables[vr].length;
}

/* Refuses references to nothing or to an element, and a wrong number of values. */
static Status check_arrays(Instance *c, const uint32_t vr[], size_t n, const double value[],
                           size_t room)
{
    size_t needed = 0;

    if ((n > 0 && !vr) || (room > 0 && !value))
        return instance_refuse(c, "NULL instead of an array");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] > c->resource.n.variables)
            return instance_refuse(c, "unknown value reference %u", vr[i]);
        if (length_of(c, vr[i]) == 0)
            return instance_refuse(c,
                                   "value reference %u is the element '%s' of an array: only the "
                                   "whole has a reference",
                                   vr[i], c->resource.names[vr[i]]);
        needed += length_of(c, vr[i]);
    }
    if (needed != room) return instance_refuse(c, "%zu values for variables of %zu", room, needed);
    return STATUS_OK;
}

Status variables_get_arrays(Instance *c, const uint32_t vr[], size_t n, double value[], size_t room)
{
    Status result = check_arrays(c, vr, n, value, room);

    for (size_t i = 0; i < n && result == STATUS_OK; i++) {
        if (is_time(c, vr[i]))
            *value++ = c->core->time;
        else
            for (size_t k = 0; k < length_of(c, vr[i]) && result == STATUS_OK; k++)
                result = get(c, vr[i] + (uint32_t)k, value++);
    }
    return result;
}

Status variables_set_arrays(Instance *c, const uint32_t vr[], size_t n, const double value[],
                            size_t room)
{
    Status result = check_arrays(c, vr, n, value, room);
    const double *from = value;

    for (size_t i = 0; i < n && result == STATUS_OK; i++) {
        if (is_time(c, vr[i])) return instance_refuse(c, "time cannot be set");
        for (size_t k = 0; k < length_of(c, vr[i]) && result == STATUS_OK; k++)
            result = check_set(c, vr[i] + (uint32_t)k, *from++);
    }
    if (result != STATUS_OK) return result;

    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < length_of(c, vr[i]); k++) set(c, vr[i] + (uint32_t)k, *value++);
    return STATUS_OK;
}

/* ---- derivatives ---- */

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

    for (size_t i = 0; i < n; i++) variables_place(c, vr[i])[order[i] * c->resource.n.u] = value[i];

    /* the speed of a commanded motion may be a derivative of its position */
    instance_changed(c);
    return STATUS_OK;
}
