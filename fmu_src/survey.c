#include "survey.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

#define N_LENGTH 4

/* Takes the next n numbers, of 8 bytes each, of what is left. */
static const void *take(const char **from, int64_t *left, int64_t n)
{
    const char *found = *from;

    if (n < 0 || n > *left) return NULL;
    *from += 8 * n;
    *left -= n;
    return found;
}

/* The lengths of all surveys, and where their numbers are. */
static bool take_surveys(Resource *r, const char **ints, int64_t *n_ints, const char **reals,
                         int64_t *n_reals)
{
    const int64_t *length = take(ints, n_ints, N_LENGTH * N_SURVEY);

    for (int k = 0; length && k < N_SURVEY; k++, length += N_LENGTH) {
        Survey *s = &r->survey[k];
        *s = (Survey){take(ints, n_ints, length[0]),
                      take(reals, n_reals, length[1]),
                      length[0],
                      length[1],
                      length[2],
                      length[3]};
        if (!s->ints || !s->reals) return false;
    }
    return length != NULL;
}

/* The kinks of what is watched. */
static bool take_kinks(Resource *r, const char **ints, int64_t *n_ints, const char **reals,
                       int64_t *n_reals)
{
    int64_t n = r->survey[SURVEY_WATCHED].n_y, total = 0;

    r->n_kinks = take(ints, n_ints, n);
    if (!r->n_kinks) return false;
    for (int64_t i = 0; i < n; i++) {
        if (r->n_kinks[i] < 0 || r->n_kinks[i] > *n_reals) return false;
        total += r->n_kinks[i];
    }
    r->kinks = take(reals, n_reals, total);
    return r->kinks && *n_ints == 0 && *n_reals == 0;
}

static bool is_good(const Resource *r, const Survey *s, char *why, size_t why_size)
{
    if (s->n_ints == 0) return s->n_y == 0;

    const int64_t length[N_BUFFER] = {
        [IN_INTS] = r->n.ints + s->n_ints,
        [IN_REALS] = r->n.reals + s->n_reals,
        [IN_STATE] = r->n.state,
        [IN_WORK] = s->n_work,
    };
    return s->n_ints >= HEADER_LENGTH && s->n_work >= r->n.work && s->ints[COUNT_n_y] == s->n_y
           && resource_is_arranged(s->ints, length, why, why_size);
}

bool survey_take(Resource *r, char *why, size_t why_size)
{
    const char *ints = (const char *)r->survey_ints, *reals = (const char *)r->survey_reals;
    int64_t n_ints = r->n.survey_ints, n_reals = r->n.survey_reals;

    snprintf(why, why_size, "its surveys do not agree with its sizes");
    if (!take_surveys(r, &ints, &n_ints, &reals, &n_reals)) return false;
    if (!take_kinks(r, &ints, &n_ints, &reals, &n_reals)) return false;
    for (int k = 0; k < N_SURVEY; k++)
        if (!is_good(r, &r->survey[k], why, why_size)) return false;
    return true;
}

int64_t survey_work(const Resource *r)
{
    int64_t most = r->n.work;

    for (int k = 0; k < N_SURVEY; k++)
        if (r->survey[k].n_work > most) most = r->survey[k].n_work;
    return most;
}

int64_t survey_y(const Resource *r)
{
    int64_t n = 0;

    for (int k = 0; k < N_SURVEY; k++) n += r->survey[k].n_y;
    return n;
}

double *survey_numbers(const Instance *c, Surveyed which)
{
    double *y = c->surveyed;

    for (int k = 0; k < (int)which; k++) y += c->resource.survey[k].n_y;
    return y;
}

void survey_free(Instance *c)
{
    for (int k = 0; k < N_SURVEY; k++) {
        free(c->survey_ints[k]);
        free(c->survey_reals[k]);
    }
}

/* ints and reals of a survey, their first parts as the model's. */
static bool make_room(Instance *c, Surveyed which)
{
    const Resource *r = &c->resource;
    const Survey *s = &r->survey[which];
    size_t n_ints = (size_t)r->n.ints, n_reals = (size_t)r->n.reals;

    if (c->survey_reals[which]) return true;

    int64_t *ints = malloc((n_ints + (size_t)s->n_ints) * sizeof *ints);
    double *reals = malloc((n_reals + (size_t)s->n_reals + 1) * sizeof *reals);

    if (!ints || !reals) {
        free(ints);
        free(reals);
        return false;
    }
    memcpy(ints, r->ints, n_ints * sizeof *ints);
    memcpy(ints, s->ints, HEADER_LENGTH * sizeof *ints);
    memcpy(ints + n_ints, s->ints + HEADER_LENGTH,
           ((size_t)s->n_ints - HEADER_LENGTH) * sizeof *ints);
    memcpy(reals + n_reals, s->reals, (size_t)s->n_reals * sizeof *reals);
    c->survey_ints[which] = ints;
    c->survey_reals[which] = reals;
    return true;
}

Status survey_run(Instance *c, Surveyed which)
{
    if (c->resource.survey[which].n_ints == 0) return STATUS_OK;
    if (!make_room(c, which)) return instance_refuse(c, "out of memory");

    const int64_t *ints = c->ints;
    double *reals = c->reals;
    void *excinfo;
    int64_t status = CODE_OK;

    memcpy(c->survey_reals[which], reals, (size_t)c->resource.n.reals * sizeof *reals);
    c->ints = c->survey_ints[which];
    c->reals = c->survey_reals[which];
    int32_t broken = mbdfmi_outputs(&status, &excinfo, M_OF(c), D_OF(c), survey_numbers(c, which));
    c->ints = ints;
    c->reals = reals;

    if (status % PLACE == CODE_OUTPUT_NOT_FINITE) status = CODE_OK;
    return instance_report(c, "locals", broken, status);
}

Status survey_local(Instance *c, int64_t index)
{
    Surveyed which = index < c->resource.survey[SURVEY_MOTION].n_y ? SURVEY_MOTION : SURVEY_EFFORTS;

    if (c->is_surveyed[which]) return STATUS_OK;

    Status result = instance_begin(c);
    if (result != STATUS_OK) return result;
    result = survey_run(c, which);
    instance_end(c);
    c->is_surveyed[which] = result == STATUS_OK;
    return result;
}
