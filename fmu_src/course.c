#include "course.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "aside.h"
#include "kernels.h"

/* Part of the time in which the fastest state changes by its size, and that time at most, s. Outputs that
   are slow beside it are known better from longer strides. */
#define STRIDE       3e-3
#define LONGEST_TIME 1.0
#define N_LENGTH     3
#define LENGTHEN     8

#define N_SAMPLE 5

/* Where the samples are, and how they count in a first and a second derivative. */
static const double PLACE_OF[N_SAMPLE] = {0, 1, -1, 2, -2};

/* The same of order 2, to see how good the others are. */
static const double ROUGH_OF[MOST_OUTPUT_ORDER][N_SAMPLE] = {{0, 0.5, -0.5, 0, 0},
                                                             {-2, 1, 1, 0, 0}};
static const double WEIGHT_OF[MOST_OUTPUT_ORDER][N_SAMPLE] = {
    {0, 8.0 / 12, -8.0 / 12, -1.0 / 12, 1.0 / 12},
    {-30.0 / 12, 16.0 / 12, 16.0 / 12, -1.0 / 12, -1.0 / 12}};

/* The motion: x' and x'' now, and the stride (s). */
typedef struct {
    double *x1, *x2;
    double stride;
} Course;

static size_t n_y(const Instance *c)
{
    return (size_t)c->resource.n.y;
}

static size_t n_x(const Instance *c)
{
    return (size_t)c->ints[COUNT_n_x];
}

/* The instance, from where it began, moved on by a time (s). */
static void move(Instance *c, const Course *course, double time)
{
    int64_t n_u = c->resource.n.u;
    double *now = c->state + c->ints[AT_time];

    aside_return(c);
    for (size_t k = 0; k < n_x(c); k++)
        instance_x(c)[k] += time * (course->x1[k] + time / 2 * course->x2[k]);
    for (int64_t k = 0; k < n_u; k++) {
        double power = 1;
        for (int order = 1; order < N_DERIVATIVE; order++) {
            power *= time / order;
            c->u[k] += power * c->u[order * n_u + k];
        }
    }
    now[0] += time;
}

static double stride_of(const Instance *c, const double *x1)
{
    const double *nominal = c->reals + c->ints[AT_x_nominal];
    double time = LONGEST_TIME;

    for (size_t k = 0; k < n_x(c); k++)
        if (x1[k] != 0) time = fmin(time, nominal[k] / fabs(x1[k]));
    return STRIDE * time;
}

static Status find_rates(Instance *c, Course *course)
{
    Status result = instance_rates(c);
    if (result != STATUS_OK) return result;

    memcpy(course->x1, c->rates, n_x(c) * sizeof(double));
    course->stride = stride_of(c, course->x1);

    double *x2 = calloc(n_x(c) + 1, sizeof(double));
    if (!x2) return instance_refuse(c, "out of memory");
    for (int i = 1; i < N_SAMPLE && result == STATUS_OK; i++) {
        move(c, course, PLACE_OF[i] * course->stride);
        result = instance_rates(c);
        double weight = WEIGHT_OF[0][i] / course->stride;
        for (size_t k = 0; k < n_x(c); k++) x2[k] += weight * c->rates[k];
    }
    memcpy(course->x2, x2, n_x(c) * sizeof(double));
    free(x2);
    return result;
}

/* Samples of all outputs, one after another, and what else is known of them: how large rounding is in
   each, and how far each derivative found so far is off at most. */
typedef struct {
    double *sample, *noise, *doubt;
} Sight;

static Status take_samples(Instance *c, const Course *course, double stride, Sight *sight)
{
    Status result = STATUS_OK;

    for (int i = 0; i < N_SAMPLE && result == STATUS_OK; i++) {
        move(c, course, PLACE_OF[i] * stride);
        result = instance_outputs(c);
        memcpy(sight->sample + (size_t)i * n_y(c), c->y, n_y(c) * sizeof(double));
    }
    return result;
}

static double weighted(const double *sample, size_t n, const double weight[N_SAMPLE])
{
    double sum = 0;

    for (int i = 0; i < N_SAMPLE; i++) sum += weight[i] * sample[(size_t)i * n];
    return sum;
}

/* From samples so close that their fourth differences are rounding. */
static void see_noise(const Instance *c, Sight *sight)
{
    static const double fourth[N_SAMPLE] = {6, -4, -4, 1, 1};

    for (size_t k = 0; k < n_y(c); k++)
        sight->noise[k] = 4 * DBL_EPSILON * fabs(sight->sample[k])
                          + fabs(weighted(sight->sample + k, n_y(c), fourth));
}

/* Takes to c->course what is better known from samples of a stride, `part` of the time of the fastest
   state, than from those before. The error of order 4 is that of order 2 times about the square of this part,
   or of the part that shows. */
static void see_derivatives(Instance *c, double stride, double part, Sight *sight)
{
    size_t n = n_y(c);

    for (size_t k = 0; k < MOST_OUTPUT_ORDER * n; k++) {
        size_t order = k / n;
        double divisor = pow(stride, 1 + (double)order);
        double fine = weighted(sight->sample + k % n, n, WEIGHT_OF[order]) / divisor;
        double off = fabs(fine - weighted(sight->sample + k % n, n, ROUGH_OF[order]) / divisor);
        double shown = off > 0 ? fmin(1, off / fabs(fine)) : 0;
        double doubt = sight->noise[k % n] / divisor + off * fmax(shown, part * part);

        if (doubt < sight->doubt[k] || !(sight->doubt[k] < INFINITY)) {
            c->course[k] = fine;
            sight->doubt[k] = doubt;
        }
    }
}

/* The derivatives of all outputs to c->course, those of an order behind those of the one before. */
static Status see_course(Instance *c, Course *course)
{
    size_t n = n_y(c);
    Status result = find_rates(c, course);
    if (result != STATUS_OK) return result;

    Sight sight = {.sample = malloc((N_SAMPLE + 1 + MOST_OUTPUT_ORDER) * (n + 1) * sizeof(double))};
    if (!sight.sample) return instance_refuse(c, "out of memory");
    sight.noise = sight.sample + N_SAMPLE * n;
    sight.doubt = sight.noise + n;
    for (size_t k = 0; k < MOST_OUTPUT_ORDER * n; k++) sight.doubt[k] = INFINITY;

    double stride = course->stride, part = STRIDE;
    result = take_samples(c, course, stride / LENGTHEN, &sight);
    if (result == STATUS_OK) see_noise(c, &sight);
    for (int k = 0; k < N_LENGTH && result == STATUS_OK; k++) {
        Status seen = take_samples(c, course, stride, &sight);

        /* longer ones may lead where the motion cannot be */
        if (seen == STATUS_OK) see_derivatives(c, stride, part, &sight);
        if (k == 0) result = seen;
        stride *= LENGTHEN;
        part *= LENGTHEN;
    }
    free(sight.sample);
    return result;
}

/* Brings c->course up to date. */
static Status find_derivatives(Instance *c)
{
    size_t size = MOST_OUTPUT_ORDER * n_y(c) * sizeof(double);

    if (c->course && c->course_point == c->point) return STATUS_OK;

    Status result = aside_begin(c);
    if (result != STATUS_OK) return result;

    Course course = {.x1 = calloc(2 * n_x(c) + 1, sizeof(double))};
    if (!c->course) c->course = malloc(size + 1);
    if (course.x1 && c->course) {
        course.x2 = course.x1 + n_x(c);
        result = see_course(c, &course);
    } else
        result = instance_refuse(c, "out of memory");
    aside_end(c);
    c->course_point = result == STATUS_OK ? c->point : 0;
    free(course.x1);
    return result;
}

static Status check(Instance *c, uint32_t vr, int32_t order)
{
    if (vr >= c->resource.n.variables) return instance_refuse(c, "unknown value reference %u", vr);
    if (c->resource.variables[vr].kind != VARIABLE_OUTPUT)
        return instance_refuse(c, "'%s' (value reference %u) is no output", c->resource.names[vr],
                               vr);
    if (order < 1 || order > MOST_OUTPUT_ORDER)
        return instance_refuse(c, "order %d of '%s': orders 1 to %d are known", (int)order,
                               c->resource.names[vr], MOST_OUTPUT_ORDER);
    return STATUS_OK;
}

Status course_derivatives(Instance *c, const uint32_t vr[], size_t n, const int32_t order[],
                          double value[])
{
    if (n == 0) return STATUS_OK;
    if (!vr || !order || !value) return instance_refuse(c, "NULL instead of an array");
    if (c->ints[COUNT_n_command] > 0)
        return instance_refuse(c, "inputs command motions, whose course is not known: this FMU "
                                  "gives none (maxOutputDerivativeOrder = 0)");

    Status result = STATUS_OK;
    for (size_t i = 0; i < n && result == STATUS_OK; i++) result = check(c, vr[i], order[i]);
    if (result != STATUS_OK) return result;

    result = find_derivatives(c);
    for (size_t i = 0; i < n && result == STATUS_OK; i++) {
        value[i] =
            c->course[(size_t)(order[i] - 1) * n_y(c) + (size_t)c->resource.variables[vr[i]].index];
        if (!isfinite(value[i]))
            result = instance_refuse(c, "the derivative of '%s' (value reference %u) is %g",
                                     c->resource.names[vr[i]], vr[i], value[i]);
    }
    return result;
}

Status course_derivatives_of_arrays(Instance *c, const uint32_t vr[], size_t n,
                                    const int32_t order[], double value[], size_t n_value)
{
    size_t total = 0;

    if (n > 0 && !(vr && order)) return instance_refuse(c, "NULL instead of an array");
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= c->resource.n.variables || c->resource.variables[vr[i]].length == 0)
            return instance_refuse(c, "value reference %u is that of no output", vr[i]);
        total += (size_t)c->resource.variables[vr[i]].length;
    }
    if (total != n_value)
        return instance_refuse(c, "%zu values for outputs of %zu", n_value, total);

    uint32_t *element = malloc((total + 1) * sizeof *element);
    int32_t *its_order = malloc((total + 1) * sizeof *its_order);
    Status result = element && its_order ? STATUS_OK : instance_refuse(c, "out of memory");
    size_t count = 0;

    for (size_t i = 0; i < n && result == STATUS_OK; i++)
        for (int64_t k = 0; k < c->resource.variables[vr[i]].length; k++) {
            element[count] = vr[i] + (uint32_t)k;
            its_order[count++] = order[i];
        }
    if (result == STATUS_OK) result = course_derivatives(c, element, total, its_order, value);
    free(element);
    free(its_order);
    return result;
}
