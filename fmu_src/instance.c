#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

const char *const CATEGORY_NAMES[N_CATEGORIES] = {"logEvents",        "logStatusWarning",
                                                  "logStatusDiscard", "logStatusError",
                                                  "logStatusFatal",   "logAll"};

/* ---- log ---- */

static Category category_of(fmi2Status status)
{
    switch (status) {
        case fmi2Warning: return LOG_WARNING;
        case fmi2Discard: return LOG_DISCARD;
        case fmi2Error:   return LOG_ERROR;
        case fmi2Fatal:   return LOG_FATAL;
        default:          return LOG_EVENTS;
    }
}

fmi2Status instance_log(Instance *c, fmi2Status status, const char *format, ...)
{
    Category category = category_of(status);
    bool wanted = category == LOG_WARNING || category == LOG_ERROR || category == LOG_FATAL
                  || c->logged[LOG_ALL] || c->logged[category];

    if (!wanted || !c->callbacks.logger) return status;

    char text[1024], message[2 * sizeof text];
    va_list args;

    va_start(args, format);
    vsnprintf(text, sizeof text, format, args);
    va_end(args);

    /* the logger takes a format (%) in which #r12# stands for a variable: double both signs */
    char *to = message;
    for (const char *from = text; *from; from++) {
        if (*from == '%' || *from == '#') *to++ = *from;
        *to++ = *from;
    }
    *to = '\0';

    c->callbacks.logger(c->callbacks.componentEnvironment, c->name, status,
                        CATEGORY_NAMES[category], message);
    return status;
}

/* Where an array of the state is. */
static double *in_state(const Instance *c, int array)
{
    return c->state + c->ints[array];
}

/* Writes a text in which %s stands for the name and each %g for the next of two numbers. The text
   comes from a file and is never a format. */
static void fill_in(char *to, size_t size, const char *text, const char *name,
                    const double numbers[2])
{
    const char *end = to + size - 1;
    char digits[32];

    for (int k = 0; *text && to < end;) {
        const char *word = NULL;

        if (strncmp(text, "%s", 2) == 0) word = name;
        if (strncmp(text, "%g", 2) == 0 && k < 2) {
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

/* Tells what a status means, with up to two numbers for its text. */
static fmi2Status tell(Instance *c, fmi2Status severity, const char *doing, int64_t status,
                       const double numbers[2])
{
    char told[768];
    int64_t code = status % PLACE, place = status / PLACE;
    const Resource *r = &c->resource;
    const char *text = resource_message(r, code);
    const char *name = "?";

    /* the places are followed by the outputs */
    if (place >= 0 && place < r->n_places)
        name = r->places[place];
    else if (place >= 0 && place < r->n_places + r->n_y)
        name = r->names[r->n_u + place - r->n_places];

    if (text)
        fill_in(told, sizeof told, text, name, numbers);
    else
        snprintf(told, sizeof told, "failure %d at %s", (int)code, name);
    return instance_log(c, severity, "%s at t = %.9g s: %s", doing, *in_state(c, AT_time), told);
}

/* Tells what a kernel said; OK when it said nothing. `severity` is that of a failure. */
static fmi2Status report(Instance *c, fmi2Status severity, const char *doing, int32_t broken,
                         int64_t status)
{
    static const double none[2] = {0, 0};

    if (broken) return instance_log(c, fmi2Fatal, "%s: internal failure %d", doing, (int)broken);
    return status == 0 ? fmi2OK : tell(c, severity, doing, status, none);
}

/* Tells the notices of the kernels, once; the state may come from outside. */
static void tell_notices(Instance *c, fmi2Status severity, const char *doing)
{
    double *untold = in_state(c, AT_notices), count = *untold;

    *untold = 0;
    for (int k = 0; k < MOST_NOTICES && k < count; k++) {
        const double *notice = in_state(c, AT_notice) + NOTICE_WIDTH * k;
        if (notice[0] > 0 && notice[0] < INT32_MAX) {
            int64_t code = (int64_t)notice[0] % PLACE;
            bool event = code == CODE_STIFF || code == CODE_NOT_STIFF;
            tell(c, severity == fmi2OK && !event ? fmi2Warning : severity, doing,
                 (int64_t)notice[0], notice + 1);
        }
    }
    if (count > MOST_NOTICES)
        instance_log(c, severity, "%s: and %.9g more of this kind", doing, count - MOST_NOTICES);
}

void instance_warn(Instance *c)
{
    for (int64_t i = 0; i < c->resource.n_notices; i++)
        instance_log(c, fmi2Warning, "%s", c->resource.notices[i]);
    tell_notices(c, fmi2Warning, "initialisation");
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

    c->core_size =
        sizeof(Core) + (size_t)(r->n_reals + r->n_state + N_DERIVATIVE * r->n_u) * sizeof(double);
    c->core = calloc(1, c->core_size);
    c->work = calloc((size_t)r->n_work + 1, sizeof(double));
    c->y = calloc((size_t)r->n_y + 1, sizeof(double));
    if (!c->core || !c->work || !c->y) return false;

    c->ints = r->ints;
    c->reals = (double *)(c->core + 1);
    c->state = c->reals + r->n_reals;
    c->u = c->state + r->n_state;
    return true;
}

Instance *instance_create(const char *name, const char *guid, const char *location,
                          const fmi2CallbackFunctions *callbacks, bool logging)
{
    char why[1024];
    Instance *c = calloc(1, sizeof *c);

    if (!c) return NULL;
    c->logged[LOG_ALL] = logging;
    if (callbacks) c->callbacks = *callbacks;
    c->name = copy_text(name ? name : "");

    if (!c->name)
        instance_log(c, fmi2Error, "out of memory");
    else if (!name || !*name)
        instance_log(c, fmi2Error, "the instance needs a name");
    else if (!guid)
        instance_log(c, fmi2Error, "the GUID is missing");
    else if (!location)
        instance_log(c, fmi2Error, "the resource location is missing");
    else if (!resource_read(&c->resource, location, why, sizeof why))
        instance_log(c, fmi2Error, "%s", why);
    else if (strcmp(guid, c->resource.guid) != 0)
        instance_log(c, fmi2Error, "the GUID is '%s', that of the resource file is '%s'", guid,
                     c->resource.guid);
    else if (!allocate(c))
        instance_log(c, fmi2Error, "out of memory");
    else {
        instance_reset(c);
        return c;
    }

    instance_free(c);
    return NULL;
}

void instance_free(Instance *c)
{
    resource_free(&c->resource);
    free(c->core);
    free(c->work);
    free(c->y);
    free(c->name);
    free(c);
}

void instance_reset(Instance *c)
{
    const Resource *r = &c->resource;

    memset(c->core, 0, c->core_size);
    memset(c->work, 0, (size_t)r->n_work * sizeof(double));
    memcpy(c->reals, r->reals, (size_t)r->n_reals * sizeof(double));
    memcpy(c->u, r->u_start, (size_t)r->n_u * sizeof(double));
    c->core->stop_time = INFINITY;
    c->core->mode = INSTANTIATED;
    c->current = false;
}

/* ---- kernels ---- */

fmi2Status instance_prepare(Instance *c)
{
    void *excinfo;
    int64_t status = 0;

    /* the start too: prepare clears the notices of an earlier one */
    if (!c->core->prepared || !c->core->started) {
        int32_t broken = mbdfmi_prepare(&status, &excinfo, M_OF(c), D_OF(c));
        fmi2Status result = report(c, fmi2Error, "parameters", broken, status);
        if (result != fmi2OK) return result;
        c->core->prepared = 1;
    }

    if (!c->core->started) {
        int32_t broken =
            mbdfmi_initialise(&status, &excinfo, M_OF(c), D_OF(c), c->core->start_time);
        fmi2Status result = report(c, fmi2Error, "initialisation", broken, status);
        if (result != fmi2OK) {
            tell_notices(c, fmi2Error, "initialisation");
            return result;
        }
        c->core->started = 1;
    }
    return fmi2OK;
}

fmi2Status instance_outputs(Instance *c)
{
    if (c->current) return fmi2OK;

    fmi2Status result = instance_prepare(c);
    if (result != fmi2OK) return result;

    void *excinfo;
    int64_t status = 0;
    int32_t broken = mbdfmi_outputs(&status, &excinfo, M_OF(c), D_OF(c), c->y);

    /* a value that is not finite is refused where it is asked for */
    if (status % PLACE == CODE_OUTPUT_NOT_FINITE) status = 0;

    result = report(c, fmi2Error, "outputs", broken, status);
    c->current = result == fmi2OK;
    return result;
}

fmi2Status instance_step(Instance *c, double t, double H)
{
    fmi2Status result = instance_prepare(c);
    if (result != fmi2OK) return result;

    Core *core = c->core;
    double end = t + H;

    /* A master that forms H as the difference of two times is off by their rounding: take the
       last step's H again, so that all ways to count time give the same bits. */
    double rounding = 4 * DBL_EPSILON * fmax(fabs(t), fabs(end));
    if (core->step > 0 && fabs(H - core->step) <= rounding) H = core->step;

    void *excinfo;
    int64_t status = 0;
    double before = *in_state(c, AT_time);
    int32_t broken = mbdfmi_step(&status, &excinfo, M_OF(c), D_OF(c), H);

    tell_notices(c, fmi2OK, "step");
    result = report(c, fmi2Discard, "step", broken, status);
    c->current = false;
    if (result == fmi2OK) {
        core->time = end;
        core->step = H;
    } else {
        core->time = t + (*in_state(c, AT_time) - before);
        core->mode = STEP_FAILED;
    }
    return result;
}
