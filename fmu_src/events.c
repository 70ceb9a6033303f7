#include "events.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "kernels.h"
#include "survey.h"

/* An indicator of an end that is not there. */
#define FAR 1e30

/* Part of the largest kink by which a coordinate is beyond one before that is an event. */
#define SLACK 1e-9

/* Part of a step to which an event in it is found, and how often it is tried at most. */
#define FOUND      1e-10
#define MOST_TRIED 80

/* Kinks of a number that is watched. */
typedef struct {
    const double *at;
    int64_t n;
    double slack;
} Kinks;

static Kinks first_kinks(const Instance *c)
{
    return (Kinks){c->resource.kinks, 0, 0};
}

/* Those of number i, on from those of the one before it. */
static void next_kinks(const Instance *c, int64_t i, Kinks *k)
{
    double largest = 0;

    k->at += k->n;
    k->n = c->resource.n_kinks[i];
    for (int64_t j = 0; j < k->n; j++) largest = fmax(largest, fabs(k->at[j]));
    k->slack = SLACK * (largest > 0 ? largest : 1);
}

/* How many kinks are below x. */
static int64_t below(const Kinks *k, double x)
{
    int64_t n = 0;

    while (n < k->n && k->at[n] < x) n++;
    return n;
}

/* How far x is below the upper end of a piece, and above its lower one. */
static void see(const Kinks *k, int64_t piece, double x, double indicator[2])
{
    indicator[0] = piece < k->n ? k->at[piece] + k->slack - x : FAR;
    indicator[1] = piece > 0 ? x - (k->at[piece - 1] - k->slack) : FAR;
}

static int64_t n_watched(const Instance *c)
{
    return c->resource.survey[SURVEY_WATCHED].n_y;
}

/* The piece that is held, counted from 1; 0: none is yet. */
static int64_t piece_of(const Instance *c, int64_t i, const Kinks *k, double x)
{
    return c->piece[i] > 0 ? (int64_t)c->piece[i] - 1 : below(k, x);
}

static Status find_indicators(Instance *c)
{
    void *excinfo;
    int64_t status = CODE_OK;
    double *to = c->indicators + 2 * c->ints[COUNT_n_stop];
    const double *x = survey_numbers(c, SURVEY_WATCHED);
    Kinks k = first_kinks(c);

    int32_t broken = mbdfmi_indicators(&status, &excinfo, M_OF(c), D_OF(c), c->indicators);
    Status result = instance_report(c, "event indicators", broken, status);

    if (result == STATUS_OK && n_watched(c) > 0) result = survey_run(c, SURVEY_WATCHED);
    for (int64_t i = 0; i < n_watched(c) && result == STATUS_OK; i++) {
        next_kinks(c, i, &k);
        see(&k, piece_of(c, i, &k, x[i]), x[i], to + 2 * i);
    }
    return result;
}

Status events_indicators(Instance *c)
{
    if (c->is_indicated) return STATUS_OK;

    Status result = instance_begin(c);
    if (result != STATUS_OK) return result;
    result = find_indicators(c);
    instance_end(c);
    c->is_indicated = result == STATUS_OK;
    return result;
}

/* Pieces to where coordinates are; one that is hardly beyond a kink holds on to what is held. */
static void settle_pieces(Instance *c)
{
    const double *x = survey_numbers(c, SURVEY_WATCHED);
    Kinks k = first_kinks(c);
    double to[2];

    for (int64_t i = 0; i < n_watched(c); i++) {
        next_kinks(c, i, &k);
        see(&k, piece_of(c, i, &k, x[i]), x[i], to);
        if (c->piece[i] == 0 || fmin(to[0], to[1]) < k.slack / 2)
            c->piece[i] = 1 + (double)below(&k, x[i]);
    }
}

Status events_settle(Instance *c, Event *event)
{
    void *excinfo;

    /* anew, for places of what is watched as they are */
    c->is_indicated = false;

    Status result = events_indicators(c);
    if (result != STATUS_OK) return result;
    settle_pieces(c);
    c->is_indicated = false;

    int32_t broken = mbdfmi_next_kink(&event->next_time, &excinfo, M_OF(c), D_OF(c));
    if (broken) return log_tell(&c->log, STATUS_FATAL, "internal failure %d", (int)broken);
    c->core->event_time = event->next_time;
    event->next_time_defined = isfinite(event->next_time);
    return STATUS_OK;
}

static bool differs(double a, double b)
{
    return (a < 0) != (b < 0);
}

bool events_crossed(const Instance *c, const double before[])
{
    for (int64_t i = 0; i < c->n_indicators; i++)
        if (differs(before[i], c->indicators[i])) return true;
    return false;
}

/* Where between two places, as parts of the way, the first indicator is 0 by straight lines. */
static double first_zero(const Instance *c, const double low[], const double high[])
{
    double first = 1;

    for (int64_t i = 0; i < c->n_indicators; i++)
        if (differs(low[i], high[i])) first = fmin(first, low[i] / (low[i] - high[i]));
    return first;
}

/* The instance and its indicators at a part of the way. */
static Status go(Instance *c, double at, double h, const void *block)
{
    instance_restore(c, block);

    Status result = instance_advance(c, at, h);
    return result == STATUS_OK ? events_indicators(c) : result;
}

Status events_advance_to(Instance *c, double at, double *h, const double before[],
                         const void *block)
{
    size_t size = (size_t)c->n_indicators * sizeof(double);
    double *low = c->crossing, *high = low + c->n_indicators;
    double from = 0, to = *h, close = FOUND * to + 4 * DBL_EPSILON * fabs(at);
    bool beyond = true; /* whether the last place was */
    Status result = STATUS_OK;

    memcpy(low, before, size);
    memcpy(high, c->indicators, size);
    for (int i = 0; i < MOST_TRIED && to - from > 3 * close && result == STATUS_OK; i++) {
        double zero = from + (to - from) * first_zero(c, low, high);
        double next = i % 3 == 2 ? 0.5 * (from + to) : zero + (beyond ? -close : close);

        next = fmin(fmax(next, from + close), to - close);
        result = go(c, at, next, block);
        if (result != STATUS_OK) break;
        beyond = events_crossed(c, before);
        *(beyond ? &to : &from) = next;
        memcpy(beyond ? high : low, c->indicators, size);
    }
    *h = to;
    return result == STATUS_OK && !beyond ? go(c, at, to, block) : result;
}
