#include "intermediate.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "events.h"

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

/* Whether indicators are looked at. */
static bool watches(const Instance *c)
{
    return c->has_events && c->n_indicators > 0;
}

/* Commanded motions are told anew at each communication point: their step is one. */
static int n_parts(const Instance *c)
{
    return (c->at_point || watches(c)) && c->ints[COUNT_n_command] == 0 ? N_PART : 1;
}

/* Whether a step ends at an event in it. */
static bool returns(const Instance *c)
{
    return c->may_return && c->ints[COUNT_n_command] == 0;
}

/* A part of a step: when an indicator changes its sign, *event, and where the master lets it the part ends there. */
static Status advance_part(Instance *c, double at, double *h, bool *event)
{
    if (!watches(c)) return instance_advance(c, at, *h);

    double *before = c->crossing + 2 * c->n_indicators;
    Status result = events_indicators(c);

    if (result != STATUS_OK) return result;
    memcpy(before, c->indicators, (size_t)c->n_indicators * sizeof *before);
    memcpy(c->part, c->core, c->core_size);
    result = instance_advance(c, at, *h);
    if (result == STATUS_OK) result = events_indicators(c);
    if (result != STATUS_OK || !events_crossed(c, before)) return result;
    *event = true;
    return returns(c) ? events_advance_to(c, at, h, before, c->part) : STATUS_OK;
}

/* Where the master asks to return within a part, the part ends there. */
static Status step_by_parts(Instance *c, double t, double H, StepEnd *end)
{
    int n = n_parts(c);
    double whole = instance_same_step(c, t, H), until = INFINITY, at = t;
    Status result = STATUS_OK;

    for (int k = 1; k <= n && result == STATUS_OK && !end->early; k++) {
        double next = k < n ? t + whole * ((double)k / n) : t + H;
        bool asked = until < next;
        double part = asked ? until - at : whole / n, h = part;

        result = advance_part(c, at, &h, &end->event);
        bool stopped = end->event && returns(c);
        at = stopped && h < part ? at + h : asked ? until : next;
        end->early = asked || (stopped && at < t + H);
        c->core->time = result == STATUS_OK ? at : c->core->time;
        if (result == STATUS_OK && c->at_point && !asked) {
            see_point(c, k < n && !end->early, &until);
            end->early = end->early || (k < n && !(until > at));
        }
    }
    if (result == STATUS_OK) c->core->step = end->early ? at - t : whole;
    return result;
}

/* The step as far as to the next event that time brings, where that is within it. */
static double until_event(const Instance *c, double t, double H, StepEnd *end)
{
    double to = c->core->event_time - t;

    if (!c->has_events || !(to <= H + 16 * DBL_EPSILON * fabs(t))) return H;
    end->event = true;
    end->early = returns(c) && to > 0 && to < H - 16 * DBL_EPSILON * fabs(t);
    return end->early ? to : H;
}

Status intermediate_step(Instance *c, double t, double H, StepEnd *end)
{
    *end = (StepEnd){0};

    Status result = instance_check_step(c, t, H);
    if (result != STATUS_OK) return result;

    const Core *before = instance_keep(c);
    if (!before) return STATUS_ERROR;

    StepEnd by_time = {0};
    H = until_event(c, t, H, &by_time);
    result = step_by_parts(c, t, H, end);
    end->event = end->event || (by_time.event && !end->early);
    end->early = end->early || by_time.early;
    if (result == STATUS_DISCARD) {
        instance_restore(c, before);
        *end = (StepEnd){0};
    }
    return result;
}
