#include "rest.h"

#include <math.h>
#include <string.h>

#include "stability.h"

/* what accelerations (m/s2, rad/s2) may be off that are those of the rest */
#define AT_REST 1e-6

/* Behind the numbers, and behind the time of FMI 3.0. */
static uint32_t reference_of(const Instance *c)
{
    return (uint32_t)c->resource.n.variables + 1;
}

Status rest_check_references(Instance *c, const uint32_t vr[], size_t n, const void *value,
                             const char *type)
{
    if (n > 0 && !vr) return instance_refuse(c, "NULL instead of an array");
    for (size_t i = 0; i < n; i++)
        if (c->resource.n.rest == 0)
            return instance_refuse(
                c, "value reference %u is no %s: this FMU has none (it offers no start at rest)",
                vr[i], type);
        else if (vr[i] != reference_of(c))
            return instance_refuse(c,
                                   "value reference %u is no %s: the only one is %u, "
                                   "'solver.start_at_equilibrium'",
                                   vr[i], type, reference_of(c));
    if (n > 0 && !value) return instance_refuse(c, "NULL instead of an array");
    return STATUS_OK;
}

Status rest_set(Instance *c, bool rests)
{
    if (!(c->core->mode & (INSTANTIATED | INITIALIZATION)))
        return instance_refuse(c,
                               "the parameter 'solver.start_at_equilibrium' (value reference %u) "
                               "is fixed after the initialization",
                               reference_of(c));
    if (c->core->rests == rests) return STATUS_OK;
    c->core->rests = rests;
    c->core->started = 0;
    instance_changed(c);
    return STATUS_OK;
}

/* Warns of start values that were set in vain. */
static void warn_of_starts(Instance *c)
{
    const Resource *r = &c->resource;
    const char *first = NULL;
    int count = 0;

    for (int64_t i = 0; i < r->n.variables; i++) {
        int64_t k = r->variables[i].index;

        if (r->variables[i].kind != VARIABLE_FIXED || c->reals[k] == r->reals[k]) continue;
        if (count++ == 0) first = r->names[i];
    }
    if (count > 0)
        log_tell(&c->log, STATUS_WARNING,
                 "start at rest: start values that were set do not act: '%s'%s", first,
                 count > 1 ? " and others" : "");
}

/* The node whose velocity coordinate this is. */
static const char *name_of(const Instance *c, int64_t coordinate)
{
    const int64_t *first = c->ints + c->ints[AT_body_v];
    int64_t node = 1;

    for (int64_t i = 1; i < c->ints[COUNT_n_body]; i++)
        if (first[i] <= coordinate && first[i] >= first[node]) node = i;
    return resource_place(&c->resource, node);
}

#ifdef MBDFMI_WITHOUT_REST /* a library of one scene whose FMUs offer none */
#define warn_of_growth(c) ((void)(c))
#else
/* Whether anything is not what the rest was found for, which is stable. */
static bool is_changed(const Instance *c)
{
    const Resource *r = &c->resource;

    return memcmp(c->u, r->u_start, (size_t)r->n.u * sizeof(double)) != 0
           || memcmp(c->reals, r->reals, (size_t)r->n.reals * sizeof(double)) != 0;
}

/* Warns of a rest that is none to come back to. */
static void warn_of_growth(Instance *c)
{
    double growth = is_changed(c) ? stability_growth(c) : 0;

    if (growth > 0)
        log_tell(
            &c->log, STATUS_WARNING,
            "start at rest: it is not stable with the present parameters and inputs, as it was "
            "for those of the scene: what is off grows e-fold in %.3g s",
            1 / growth);
}
#endif

Status rest_check(Instance *c)
{
    if (!c->core->rests) return STATUS_OK;

    Status result = instance_rates(c);
    if (result != STATUS_OK) return result;

    int64_t n_q = c->ints[COUNT_n_q], worst = 0;
    double most = 0;

    for (int64_t k = 0; k < c->ints[COUNT_n_v]; k++) {
        double off = fabs(c->rates[n_q + k] - c->resource.rest_rates[n_q + k]);

        if (off > most) {
            most = off;
            worst = k;
        }
    }
    if (most > AT_REST)
        log_tell(
            &c->log, STATUS_WARNING,
            "start at rest: it is no rest with the present parameters and inputs, as it was found "
            "for those of the scene: '%s' starts with %.3g (m/s2 or rad/s2)",
            name_of(c, worst), most);
    else
        warn_of_growth(c);
    warn_of_starts(c);
    return STATUS_OK;
}
