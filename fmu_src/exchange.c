#include "exchange.h"

#include <math.h>
#include <string.h>

#include "kernels.h"

/* Parts of the states' sizes: how far they may be off the constraints until the solver is told, and
   what is rounding. */
#define DRIFT    1e-3
#define ROUNDING 1e-12

/* Velocities are led by what is known of the positions a step of Newton before: how often, at most, until
   nothing changes. */
#define MOST_LED 4

static Status check_length(Instance *c, const double array[], size_t n, int64_t expected)
{
    if (n > 0 && !array) return instance_refuse(c, "NULL instead of an array");
    if ((int64_t)n == expected) return STATUS_OK;
    return instance_refuse(c, "an array of %zu, there are %lld", n, (long long)expected);
}

/* Where state i of the variables is in x. */
static int64_t place_of(const Instance *c, size_t i)
{
    return c->resource.variables[c->first_state + (int64_t)i].index;
}

/* The time that the kernels see. */
static void see_time(Instance *c, double time)
{
    double *now = c->state + c->ints[AT_time];

    if (time == now[0] && now[1] == 0) return;
    now[0] = time;
    now[1] = 0;
    instance_changed(c);
}

Status exchange_set_time(Instance *c, double time)
{
    if (!isfinite(time)) return instance_refuse(c, "the time is %g", time);
    c->core->time = time;

    /* up to an event what jumps there has its values from before */
    if (c->core->mode == CONTINUOUS_TIME && time == c->core->event_time)
        time = nextafter(time, -INFINITY);
    see_time(c, time);
    return STATUS_OK;
}

Status exchange_set_states(Instance *c, const double x[], size_t n)
{
    Status result = check_length(c, x, n, c->n_states);

    for (size_t i = 0; i < n && result == STATUS_OK; i++)
        if (!isfinite(x[i])) result = instance_refuse(c, "state %zu is %g", i + 1, x[i]);
    if (result != STATUS_OK) return result;

    for (size_t i = 0; i < n; i++) instance_x(c)[place_of(c, i)] = x[i];
    instance_changed(c);
    return STATUS_OK;
}

Status exchange_get_states(Instance *c, double x[], size_t n)
{
    Status result = check_length(c, x, n, c->n_states);

    if (result == STATUS_OK) result = instance_prepare(c);
    for (size_t i = 0; i < n && result == STATUS_OK; i++) x[i] = instance_x(c)[place_of(c, i)];
    return result;
}

Status exchange_get_rates(Instance *c, double rates[], size_t n)
{
    Status result = check_length(c, rates, n, c->n_states);

    if (result == STATUS_OK) result = instance_rates(c);
    for (size_t i = 0; i < n && result == STATUS_OK; i++) rates[i] = c->rates[place_of(c, i)];
    return result;
}

Status exchange_get_nominals(Instance *c, double nominals[], size_t n)
{
    Status result = check_length(c, nominals, n, c->n_states);

    for (size_t i = 0; i < n && result == STATUS_OK; i++)
        nominals[i] = c->reals[c->ints[AT_x_nominal] + place_of(c, i)];
    return result;
}

Status exchange_get_indicators(Instance *c, double z[], size_t n)
{
    Status result = check_length(c, z, n, c->n_indicators);

    if (result == STATUS_OK) result = events_indicators(c);
    for (size_t i = 0; i < n && result == STATUS_OK; i++) z[i] = c->indicators[i];
    return result;
}

/* Whether the state on the constraints is further off the given one than a part of its size. */
static bool is_off(const Instance *c, double part)
{
    const double *nominal = c->reals + c->ints[AT_x_nominal];

    for (int64_t k = 0; k < c->ints[COUNT_n_x]; k++)
        if (!(fabs(c->led[k] - instance_x(c)[k]) <= part * nominal[k])) return true;
    return false;
}

Status exchange_complete_step(Instance *c, bool *wanted)
{
    Status result = instance_lead(c);

    *wanted = result == STATUS_OK && is_off(c, DRIFT);
    return result == STATUS_OK ? instance_complete(c) : result;
}

Status exchange_update(Instance *c, Event *event)
{
    see_time(c, c->core->time);

    Status result = instance_lead(c);

    if (result != STATUS_OK) return result;
    event->states_changed = is_off(c, ROUNDING);
    for (int i = 0; i < MOST_LED && result == STATUS_OK && is_off(c, ROUNDING); i++) {
        memcpy(instance_x(c), c->led, (size_t)c->ints[COUNT_n_x] * sizeof(double));
        instance_changed(c);
        result = instance_lead(c);
    }
    return result == STATUS_OK ? events_settle(c, event) : result;
}
