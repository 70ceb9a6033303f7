#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "aside.h"
#include "columns.h"
#include "kernels.h"
#include "rest.h"
#include "survey.h"
#include "tolerance.h"
#include "traced.h"

/* ---- what kernels say ---- */

/* Where an array of the state is. */
static double *in_state(const Instance *c, int array)
{
    return c->state + c->ints[array];
}

/* Writes a text in which %s stands for the name and each %g for the next of the numbers. The text
   comes from a file and is never a format. */
static void fill_in(char *to, size_t size, const char *text, const char *name,
                    const double numbers[NOTICE_WIDTH - 1])
{
    const char *end = to + size - 1;
    char digits[32];

    for (int k = 0; *text && to < end;) {
        const char *word = NULL;

        if (strncmp(text, "%s", 2) == 0) word = name;
        if (strncmp(text, "%g", 2) == 0 && k < NOTICE_WIDTH - 1) {
            snprintf(digits, sizeof digits, "%.6g", numbers[k++]);
            word = digits;
        }
        if (!word) {
            *to++ = *text++;
            continue;
        }
        while (*word && to < end) *to++ = *word++;
        text += 2;
    }
    *to = '\0';
}

/* Tells what a status means, with the numbers of its text. */
static Status tell(Instance *c, Status severity, const char *doing, int64_t status,
                   const double numbers[NOTICE_WIDTH - 1])
{
    char told[LONGEST_MESSAGE - 256];
    int64_t code = status % PLACE, place = status / PLACE;
    const Resource *r = &c->resource;
    const char *text = resource_message(r, code);
    const char *name = resource_place(r, place);

    if (text)
        fill_in(told, sizeof told, text, name, numbers);
    else
        snprintf(told, sizeof told, "failure %d at %s", (int)code, name);
    return log_tell(&c->log, severity, "%s at t = %.9g s: %s", doing, *in_state(c, AT_time), told);
}

/* Tells what a kernel said; OK when it said nothing. `severity` is that of a failure. */
static Status report(Instance *c, Status severity, const char *doing, int32_t broken,
                     int64_t status)
{
    static const double none[NOTICE_WIDTH - 1] = {0};

    if (broken)
        return log_tell(&c->log, STATUS_FATAL, "%s: internal failure %d", doing, (int)broken);
    return status == CODE_OK ? STATUS_OK : tell(c, severity, doing, status, none);
}

/* Tells the notices of the kernels, once; the state may come from outside. */
static void tell_notices(Instance *c, Status severity, const char *doing)
{
    double *untold = in_state(c, AT_notices), count = *untold;

    *untold = 0;
    for (int k = 0; k < MOST_NOTICES && k < count; k++) {
        const double *notice = in_state(c, AT_notice) + NOTICE_WIDTH * k;
        if (notice[0] > 0 && notice[0] < INT32_MAX) {
            int64_t code = (int64_t)notice[0] % PLACE;
            bool event = code == CODE_STIFF || code == CODE_NOT_STIFF;
            tell(c, severity == STATUS_OK && !event ? STATUS_WARNING : severity, doing,
                 (int64_t)notice[0], notice + 1);
        }
    }
    if (count > MOST_NOTICES)
        log_tell(&c->log, severity, "%s: and %.9g more of this kind", doing, count - MOST_NOTICES);
}

/* ---- kernels ---- */

double *instance_x(const Instance *c)
{
    return in_state(c, AT_x);
}

static size_t size_of_x(const Instance *c)
{
    return (size_t)c->ints[COUNT_n_x] * sizeof(double);
}

/* Puts the state at rest, and on the constraints as they are with the present parameters. */
static Status take_rest(Instance *c)
{
    void *excinfo;
    int64_t status = CODE_OK;

    memcpy(instance_x(c), c->resource.rest, size_of_x(c));
    int32_t broken = mbdfmi_lead(&status, &excinfo, M_OF(c), D_OF(c));
    return report(c, STATUS_ERROR, "start at rest", broken, status);
}

/* Brings the state up to date with the parameters and, before the simulation, the start values. */
Status instance_prepare(Instance *c)
{
    void *excinfo;
    int64_t status = CODE_OK;

    /* the start too: prepare clears the notices of an earlier one */
    if (!c->core->prepared || !c->core->started) {
        int32_t broken = mbdfmi_prepare(&status, &excinfo, M_OF(c), D_OF(c));
        Status result = report(c, STATUS_ERROR, "parameters", broken, status);
        if (result != STATUS_OK) return result;
        c->core->prepared = 1;
    }

    if (!c->core->started) {
        int32_t broken =
            mbdfmi_initialise(&status, &excinfo, M_OF(c), D_OF(c), c->core->start_time);
        Status result = report(c, STATUS_ERROR, "initialisation", broken, status);
        if (result != STATUS_OK) {
            tell_notices(c, STATUS_ERROR, "initialisation");
            return result;
        }
        if (c->core->rests) result = take_rest(c);
        if (result != STATUS_OK) return result;
        c->core->started = 1;
    }
    return STATUS_OK;
}

void instance_changed(Instance *c)
{
    c->current = c->is_led = c->is_rated = c->is_indicated = false;
    memset(c->is_surveyed, 0, sizeof c->is_surveyed);
    c->point++;
}

/* A solver outside may try again from nearer by. */
static Status severity_of(const Instance *c)
{
    return c->exchanges ? STATUS_DISCARD : STATUS_ERROR;
}

Status instance_report(Instance *c, const char *doing, int32_t broken, int64_t status)
{
    return report(c, severity_of(c), doing, broken, status);
}

Status instance_lead(Instance *c)
{
    Status result = instance_prepare(c);

    if (result != STATUS_OK || c->is_led) return result;

    /* commanded motions are where inputs tell them; to look at anything reads these */
    if (c->ints[COUNT_n_command] > 0) result = survey_run(c, SURVEY_WATCHED);
    if (result != STATUS_OK) return result;

    void *excinfo;
    int64_t status = CODE_OK;

    memcpy(c->given, instance_x(c), size_of_x(c));
    int32_t broken = mbdfmi_lead(&status, &excinfo, M_OF(c), D_OF(c));
    memcpy(c->led, instance_x(c), size_of_x(c));
    memcpy(instance_x(c), c->given, size_of_x(c));

    result = report(c, severity_of(c), "states", broken, status);
    c->is_led = result == STATUS_OK;
    return result;
}

Status instance_begin(Instance *c)
{
    if (!c->exchanges) return instance_prepare(c);

    Status result = instance_lead(c);
    if (result != STATUS_OK) return result;
    memcpy(c->given, instance_x(c), size_of_x(c));
    memcpy(instance_x(c), c->led, size_of_x(c));
    return STATUS_OK;
}

void instance_end(Instance *c)
{
    if (c->exchanges) memcpy(instance_x(c), c->given, size_of_x(c));
}

Status instance_rates(Instance *c)
{
    if (c->is_rated) return STATUS_OK;

    Status result = instance_begin(c);
    if (result != STATUS_OK) return result;

    void *excinfo;
    int64_t status = CODE_OK;
    int32_t broken = mbdfmi_rates(&status, &excinfo, M_OF(c), D_OF(c));

    instance_end(c);
    memcpy(c->rates, c->work + c->ints[AT_x_rate], size_of_x(c));
    result = report(c, severity_of(c), "rates", broken, status);
    c->is_rated = result == STATUS_OK;
    return result;
}

Status instance_complete(Instance *c)
{
    void *excinfo;
    int64_t status = CODE_OK;
    int32_t broken = mbdfmi_complete(&status, &excinfo, M_OF(c), D_OF(c));

    tell_notices(c, STATUS_OK, "step");
    return report(c, severity_of(c), "step", broken, status);
}

Status instance_outputs(Instance *c)
{
    if (c->current) return STATUS_OK;

    Status result = instance_begin(c);
    if (result != STATUS_OK) return result;

    void *excinfo;
    int64_t status = CODE_OK;
    int32_t broken = mbdfmi_outputs(&status, &excinfo, M_OF(c), D_OF(c), c->y);

    instance_end(c);

    /* a value that is not finite is refused where it is asked for */
    if (status % PLACE == CODE_OUTPUT_NOT_FINITE) status = CODE_OK;

    result = report(c, severity_of(c), "outputs", broken, status);
    c->current = result == STATUS_OK;
    return result;
}

double instance_same_step(const Instance *c, double t, double H)
{
    double end = t + H, rounding = 4 * DBL_EPSILON * fmax(fabs(t), fabs(end));

    return c->core->step > 0 && fabs(H - c->core->step) <= rounding ? c->core->step : H;
}

Status instance_advance(Instance *c, double t, double H)
{
    Core *core = c->core;
    double end = t + H;

    H = instance_same_step(c, t, H);

    void *excinfo;
    int64_t status = CODE_OK;
    double before = *in_state(c, AT_time);
    int32_t broken = mbdfmi_step(&status, &excinfo, M_OF(c), D_OF(c), H);

    tell_notices(c, STATUS_OK, "step");
    Status result = report(c, STATUS_DISCARD, "step", broken, status);
    instance_changed(c);
    if (result == STATUS_OK) {
        core->time = end;
        core->step = H;
    } else {
        core->time = t + (*in_state(c, AT_time) - before);
        core->mode = STEP_FAILED;
    }
    return result;
}

/* ---- life ---- */

static char *copy_text(const char *text)
{
    char *copy = malloc(strlen(text) + 1);

    return copy ? strcpy(copy, text) : NULL;
}

static bool allocate(Instance *c)
{
    const Resource *r = &c->resource;
    int64_t n_watched = r->survey[SURVEY_WATCHED].n_y;
    int64_t n = r->n.reals + r->n.state + N_DERIVATIVE * r->n.u + n_watched;

    c->core_size = sizeof(Core) + (size_t)n * sizeof(double);
    c->core = calloc(1, c->core_size);
    c->work = calloc((size_t)survey_work(r) + 1, sizeof(double));
    c->y = calloc((size_t)r->n.y + 1, sizeof(double));
    size_t n_x = (size_t)r->ints[COUNT_n_x] + 1,
           n_indicators = 2 * (size_t)(r->ints[COUNT_n_stop] + n_watched) + 1;
    c->given = calloc(n_x, sizeof(double));
    c->led = calloc(n_x, sizeof(double));
    c->rates = calloc(n_x, sizeof(double));
    c->indicators = calloc(n_indicators, sizeof(double));
    c->surveyed = calloc((size_t)survey_y(r) + 1, sizeof(double));
    if (!c->core || !c->work || !c->y || !c->given || !c->led || !c->rates || !c->indicators
        || !c->surveyed)
        return false;

    c->ints = r->ints;
    c->reals = (double *)(c->core + 1);
    c->state = c->reals + r->n.reals;
    c->u = c->state + r->n.state;
    c->piece = c->u + N_DERIVATIVE * r->n.u;
    return true;
}

/* Finds the states and the indicators of events among the variables. */
static void find_states(Instance *c)
{
    const Resource *r = &c->resource;

    for (int64_t i = 0; i < r->n.variables; i++) {
        if (r->variables[i].kind == VARIABLE_STATE && c->n_states++ == 0) c->first_state = i;
        if (r->variables[i].kind == VARIABLE_INDICATOR) c->n_indicators++;
    }
}

/* Sets all memory to the start. */
static void restart(Instance *c)
{
    const Resource *r = &c->resource;

    memset(c->core, 0, c->core_size);
    memset(c->work, 0, (size_t)r->n.work * sizeof(double));
    memcpy(c->reals, r->reals, (size_t)r->n.reals * sizeof(double));
    memcpy(c->u, r->u_start, (size_t)r->n.u * sizeof(double));
    c->core->stop_time = c->core->event_time = INFINITY;
    c->core->mode = INSTANTIATED;
    c->core->rests = r->n.rests;
    instance_changed(c);
}

Instance *instance_create(const char *name, const char *guid, const char *location, const Log *log)
{
    char why[LONGEST_MESSAGE];
    Instance *c = calloc(1, sizeof *c);

    if (!c) {
        Log alone = *log;

        alone.name = (char *)(name ? name : "");
        log_tell(&alone, STATUS_ERROR, "out of memory");
        return NULL;
    }
    c->log = *log;
    c->log.name = copy_text(name ? name : "");

    if (!c->log.name)
        log_tell(&c->log, STATUS_ERROR, "out of memory");
    else if (!name || !*name)
        log_tell(&c->log, STATUS_ERROR, "the instance needs a name");
    else if (!guid)
        log_tell(&c->log, STATUS_ERROR, "the GUID is missing");
    else if (!location)
        log_tell(&c->log, STATUS_ERROR, "the resource location is missing");
    else if (!resource_read(&c->resource, location, why, sizeof why))
        log_tell(&c->log, STATUS_ERROR, "%s", why);
    else if (strcmp(guid, c->resource.guid) != 0)
        log_tell(&c->log, STATUS_ERROR, "the GUID is '%s', that of the resource file is '%s'", guid,
                 c->resource.guid);
    else if (*mbdfmi_only_guid && strcmp(mbdfmi_only_guid, guid) != 0)
        log_tell(&c->log, STATUS_ERROR, "the library is of one scene, '%s', and the GUID is '%s'",
                 mbdfmi_only_guid, guid);
    else if (!allocate(c))
        log_tell(&c->log, STATUS_ERROR, "out of memory");
    else {
        find_states(c);
        restart(c);
        return c;
    }

    instance_free(c);
    return NULL;
}

bool instance_use_events(Instance *c)
{
    c->crossing = malloc((3 * (size_t)c->n_indicators + 1) * sizeof(double));
    c->part = malloc(c->core_size);
    c->has_events = c->crossing && c->part;
    if (!c->has_events) log_tell(&c->log, STATUS_ERROR, "out of memory");
    return c->has_events;
}

bool instance_exchange(Instance *c)
{
    c->exchanges = c->n_states > 0;
    if (!c->exchanges)
        log_tell(&c->log, STATUS_ERROR,
                 "this FMU is for co-simulation only: it has no states, too many, or inputs that "
                 "command motions without their accelerations");
    return c->exchanges;
}

void instance_free(Instance *c)
{
    if (c->log.is_sending) return;
    columns_free(c);
    traced_free(c);
    free(c->course);
    aside_free(c);
    resource_free(&c->resource);
    free(c->core);
    free(c->before);
    free(c->work);
    free(c->y);
    free(c->given);
    free(c->led);
    free(c->rates);
    free(c->indicators);
    free(c->surveyed);
    free(c->crossing);
    free(c->part);
    survey_free(c);
    free(c->log.name);
    free(c);
}

/* ---- calls ---- */

static const char *mode_name(int64_t mode)
{
    switch (mode) {
        case INSTANTIATED:    return "instantiated";
        case INITIALIZATION:  return "initialization mode";
        case STEP_COMPLETE:   return "step complete";
        case STEP_FAILED:     return "step failed";
        case EVENT:           return "event mode";
        case CONTINUOUS_TIME: return "continuous-time mode";
        case INTERMEDIATE:    return "intermediate update";
        default:              return "terminated";
    }
}

bool instance_enter(Instance *c, const char *function, int modes)
{
    if (!c || c->log.is_sending)
        return false; /* a logger that calls back, in the middle of a call */
    c->function = function;
    if (c->core->mode & modes) return true;
    log_tell(&c->log, STATUS_ERROR, "%s is not allowed in the state '%s'", function,
             mode_name(c->core->mode));
    return false;
}

Status instance_refuse(Instance *c, const char *format, ...)
{
    char why[LONGEST_MESSAGE];
    va_list args;

    va_start(args, format);
    vsnprintf(why, sizeof why, format, args);
    va_end(args);
    return log_tell(&c->log, STATUS_ERROR, "%s: %s", c->function, why);
}

Status instance_choose_log(Instance *c, bool on, size_t n, const char *const categories[])
{
    if (n > 0 && !categories) return instance_refuse(c, "categories is NULL");

    const char *unknown = log_choose(&c->log, on, n, categories);
    return unknown ? instance_refuse(c, "unknown category '%s'", unknown) : STATUS_OK;
}

Status instance_setup(Instance *c, const double *tolerance, double start_time,
                      const double *stop_time)
{
    if (tolerance && !tolerance_is_possible(*tolerance))
        return instance_refuse(c, "the tolerance is %g and must be from %g to %g", *tolerance,
                               LEAST_TOLERANCE, LARGEST_TOLERANCE);
    if (!isfinite(start_time)) return instance_refuse(c, "the start time is %g", start_time);
    if (stop_time && !(*stop_time >= start_time))
        return instance_refuse(c, "the stop time %.9g s is before the start time %.9g s",
                               *stop_time, start_time);

    c->core->start_time = c->core->time = start_time;
    c->core->stop_time = stop_time ? *stop_time : INFINITY;
    c->core->started = 0;
    instance_changed(c);
    return tolerance_take(c, tolerance);
}

Status instance_start(Instance *c)
{
    const Resource *r = &c->resource;
    Status result = instance_prepare(c);

    if (result == STATUS_OK) result = rest_check(c);
    if (result != STATUS_OK) return result;
    c->core->mode = c->exchanges || c->has_events ? EVENT : STEP_COMPLETE;
    c->point++; /* parameters no longer act on the start */

    for (int64_t i = 0; i < r->n.notices; i++)
        log_tell(&c->log, STATUS_WARNING, "%s", r->notices[i]);
    tell_notices(c, STATUS_WARNING, "initialisation");
    return log_tell(&c->log, STATUS_OK, "initialised at t = %.9g s", c->core->start_time);
}

Status instance_check_step(Instance *c, double t, double H)
{
    double time = c->core->time;

    if (!(isfinite(H) && H > 0))
        return instance_refuse(c, "the step size is %g s and must be positive", H);

    /* a master's own way to count time shows as rounding */
    double slack = 1e-6 * H + 16 * DBL_EPSILON * fabs(time);
    if (!(fabs(t - time) <= slack))
        return instance_refuse(
            c, "the communication point is t = %.17g s, this FMU is at t = %.17g s", t, time);
    if (!isfinite(t + H))
        return instance_refuse(c, "the step from t = %g s by %g s has no end", t, H);
    if (t + H > c->core->stop_time + slack)
        return instance_refuse(c, "the step ends at t = %.9g s, after the stop time %.9g s", t + H,
                               c->core->stop_time);

    return instance_prepare(c);
}

Status instance_step(Instance *c, double t, double H)
{
    Status result = instance_check_step(c, t, H);

    return result == STATUS_OK ? instance_advance(c, t, H) : result;
}

void instance_restore(Instance *c, const void *block)
{
    memcpy(c->core, block, c->core_size);
    c->work[c->ints[AT_lu_known]] = c->work[c->ints[AT_stages_here]] = 0;
    instance_changed(c);
}

Core *instance_keep(Instance *c)
{
    if (!c->before) c->before = malloc(c->core_size);
    if (!c->before) {
        instance_refuse(c, "out of memory");
        return NULL;
    }
    return memcpy(c->before, c->core, c->core_size);
}

/* How often a library of one scene was not of use: its traced kernel had to leave it to the generic
   one. */
static void tell_generic_evaluations(Instance *c)
{
    double generic = c->work[c->ints[AT_generic_evaluations]];
    double all = *in_state(c, AT_evaluations);
    const double *calls = c->work + c->ints[AT_generic_calls];

    if (*mbdfmi_only_guid)
        log_tell(&c->log, STATUS_OK,
                 "of %.0f evaluations %.0f were left by the kernel traced for the scene to the "
                 "generic one, and %.0f projections, %.0f Jacobians, %.0f sets of outputs",
                 all, generic, calls[0], calls[1], calls[2]);
}

Status instance_terminate(Instance *c)
{
    tell_generic_evaluations(c);
    c->core->mode = TERMINATED;
    return log_tell(&c->log, STATUS_OK, "terminated at t = %.9g s", c->core->time);
}

Status instance_reset(Instance *c)
{
    restart(c);
    return log_tell(&c->log, STATUS_OK, "reset");
}
