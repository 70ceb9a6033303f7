#include "intermediate.h"

#include <math.h>

/* A step is seen at the ends of so many equal parts. The motion hardly knows of them: where inputs stay, inner
   steps do not stop at them. */
#define N_PART 10

/* Lets the master see where the instance is; when it asks to return, that time goes to *until. */
static void see_point(Instance *c, bool may_return, double *until)
{
    double wanted;

    c->core->mode = INTERMEDIATE;
    if (c->at_point(c, c->core->time, may_return && c->may_return, &wanted)) *until = wanted;
    c->core->mode = STEP_COMPLETE;
}

/* Commanded motions are told anew at each communication point: their step is one. */
static int n_parts(const Instance *c)
{
    return c->at_point && c->ints[COUNT_n_command] == 0 ? N_PART : 1;
}

/* Where the master asks to return within a part, the part ends there. */
static Status step_by_parts(Instance *c, double t, double H, bool *early)
{
    int n = n_parts(c);
    double whole = instance_same_step(c, t, H), until = INFINITY, at = t;
    Status result = STATUS_OK;

    for (int k = 1; k <= n && result == STATUS_OK && !*early; k++) {
        double next = k < n ? t + whole * ((double)k / n) : t + H;

        *early = until < next;
        result = instance_advance(c, at, *early ? until - at : whole / n);
        at = *early ? until : next;
        c->core->time = result == STATUS_OK ? at : c->core->time;
        if (result == STATUS_OK && c->at_point && !*early) {
            see_point(c, k < n, &until);
            *early = k < n && !(until > at);
        }
    }
    if (result == STATUS_OK) c->core->step = *early ? at - t : whole;
    return result;
}

Status intermediate_step(Instance *c, double t, double H, bool *early)
{
    *early = false;

    Status result = instance_check_step(c, t, H);
    if (result != STATUS_OK) return result;

    const Core *before = instance_keep(c);
    if (!before) return STATUS_ERROR;

    result = step_by_parts(c, t, H, early);
    if (result == STATUS_DISCARD) {
        instance_restore(c, before);
        *early = false;
    }
    return result;
}
