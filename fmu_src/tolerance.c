#include "tolerance.h"

#include <math.h>

/* bits of told_tolerances */
enum { RELATIVE = 1, ABSOLUTE = 2 };

bool tolerance_is_possible(double value)
{
    return value >= LEAST_TOLERANCE && value <= LARGEST_TOLERANCE;
}

void tolerance_told(Instance *c, int64_t index)
{
    if (c->core->mode != INSTANTIATED) return; /* the master's was told already */
    if (index == c->ints[AT_tolerance]) c->core->told_tolerances |= RELATIVE;
    if (index == c->ints[AT_absolute_tolerance]) c->core->told_tolerances |= ABSOLUTE;
}

/* Whether the solver chooses its steps by tolerances: then they are parameters. */
static bool has_tolerances(const Instance *c)
{
    for (int64_t i = 0; i < c->resource.n.variables; i++)
        if (c->resource.variables[i].kind == VARIABLE_TUNABLE
            && c->resource.variables[i].index == c->ints[AT_tolerance])
            return true;
    return false;
}

static void set_tolerance(Instance *c, int which, int64_t place, double value)
{
    if ((c->core->told_tolerances & which) || c->reals[place] == value) return;
    c->reals[place] = value;
    c->core->prepared = 0;
}

Status tolerance_take(Instance *c, const double *tolerance)
{
    int64_t at = c->ints[AT_tolerance], at_absolute = c->ints[AT_absolute_tolerance];
    double scene = c->resource.reals[at], absolute = c->resource.reals[at_absolute];
    double wanted = tolerance ? *tolerance : scene;

    if (!has_tolerances(c))
        return tolerance ? log_tell(&c->log, STATUS_OK,
                                    "the tolerance %g is not used: the solver takes fixed steps",
                                    *tolerance)
                         : STATUS_OK;
    if (c->exchanges)
        return tolerance
                   ? log_tell(&c->log, STATUS_OK,
                              "the tolerance %g is for the solver of model exchange", *tolerance)
                   : STATUS_OK;

    set_tolerance(c, RELATIVE, at, wanted);
    if (wanted != scene)
        absolute = fmin(fmax(absolute * (wanted / scene), LEAST_TOLERANCE), LARGEST_TOLERANCE);
    set_tolerance(c, ABSOLUTE, at_absolute, absolute);

    if (!tolerance || wanted == scene) return STATUS_OK;
    if (c->core->told_tolerances & RELATIVE)
        return log_tell(&c->log, STATUS_OK,
                        "the tolerance %g is not used: solver.tolerance was set, to %g", wanted,
                        c->reals[at]);
    if (wanted > scene)
        log_tell(&c->log, STATUS_WARNING,
                 "the tolerance %g is looser than the scene's, %g: results will be less exact",
                 wanted, scene);
    else
        log_tell(&c->log, STATUS_OK, "the tolerance %g counts instead of the scene's, %g", wanted,
                 scene);
    return STATUS_OK;
}
