#include "columns.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "aside.h"
#include "kernels.h"
#include "traced.h"
#include "variables.h"

/* What inputs that are efforts move by: all is affine in them, and what does not depend on them is to be
   small beside it. */
#define LARGE 0x1p30

/* Parts of the largest number of its array, and any number, below which a parameter is as good as 0. */
#define SMALL_PART 1e-3
#define SMALLEST   1e-13

#define N_SAMPLE 6

/* Differences: where knowns move to, in strides, and what comes of it counts; the stride is a part of
   their sizes, at which what is left out is as small as rounding. */
typedef struct {
    int n;
    double stride, place[N_SAMPLE], weight[N_SAMPLE];
} Formula;

/* of order 6, and of order 4 at places that it has too: where both disagree by more than a part of what they find,
   the stride is too long, as beside a singular position, and a quarter of it is tried, so many times at most */
static const Formula CENTRAL = {6,
                                6e-3,
                                {1, -1, 2, -2, 3, -3},
                                {45.0 / 60, -45.0 / 60, -9.0 / 60, 9.0 / 60, 1.0 / 60, -1.0 / 60}};
static const double ROUGH[N_SAMPLE] = {8.0 / 12, -8.0 / 12, -1.0 / 12, 1.0 / 12};
#define AGREE 3e-6
#define TRIES 4

/* of order 4, of parameters that are 0 and often cannot be less */
static const Formula FORWARD = {
    5, 1e-3, {0, 1, 2, 3, 4}, {-25.0 / 12, 48.0 / 12, -36.0 / 12, 16.0 / 12, -3.0 / 12}};

static const Formula AFFINE = {2, LARGE, {0, 1}, {-1, 1}};

typedef struct Columns {
    uint64_t point;           /* of the instance, that all this is of */
    size_t asked;             /* evaluations along more than one known */
    double **column[N_PART];  /* by value reference, NULL: none yet; they stay for the next point */
    bool *has[N_PART];        /* whether it is known */
    double *base[N_PART_ALL]; /* the unknowns there */
    bool has_base[N_PART_ALL];
} Columns;

size_t columns_height(const Instance *c, Part part)
{
    if (part == PREPARED) return (size_t)c->resource.n.state;
    return part == OUTPUTS ? (size_t)c->resource.n.y : (size_t)c->ints[COUNT_n_x];
}

static void forget(Instance *c)
{
    Columns *k = c->columns;

    for (int part = 0; part < N_PART; part++)
        memset(k->has[part], 0, (size_t)c->resource.n.variables * sizeof(bool));
    memset(k->has_base, 0, sizeof k->has_base);
    k->asked = 0;
    k->point = c->point;
}

void columns_free(Instance *c)
{
    Columns *k = c->columns;

    if (!k) return;
    for (int part = 0; part < N_PART; part++) {
        for (int64_t i = 0; k->column[part] && i < c->resource.n.variables; i++)
            free(k->column[part][i]);
        free(k->column[part]);
        free(k->has[part]);
    }
    for (int part = 0; part < N_PART_ALL; part++) free(k->base[part]);
    free(k);
    c->columns = NULL;
}

/* What is kept, of the instance as it is now; NULL when there is no memory. */
static Columns *columns_of(Instance *c)
{
    if (!c->columns) {
        Columns *k = c->columns = calloc(1, sizeof *k);
        if (!k) return NULL;

        bool complete = true;

        for (int part = 0; part < N_PART; part++) {
            k->column[part] = calloc((size_t)c->resource.n.variables + 1, sizeof(double *));
            k->has[part] = calloc((size_t)c->resource.n.variables + 1, sizeof(bool));
            complete = complete && k->column[part] && k->has[part];
        }
        for (int part = 0; part < N_PART_ALL; part++) {
            k->base[part] = malloc((columns_height(c, part) + 1) * sizeof(double));
            complete = complete && k->base[part];
        }
        if (!complete) {
            columns_free(c);
            return NULL;
        }
        k->point = c->point;
    }
    if (c->columns->point != c->point) forget(c);
    return c->columns;
}

size_t *columns_asked(Instance *c)
{
    Columns *k = columns_of(c);

    return k ? &k->asked : NULL;
}

bool columns_has(const Instance *c, uint32_t known, Part part)
{
    const Columns *k = c->columns;

    return k && k->point == c->point && k->has[part][known];
}

static const double *unknowns(const Instance *c, Part part)
{
    return part == OUTPUTS ? c->y : part == RATES ? c->rates : c->state;
}

static void keep_base(Instance *c, Part part)
{
    memcpy(c->columns->base[part], unknowns(c, part), columns_height(c, part) * sizeof(double));
    c->columns->has_base[part] = true;
}

/* Between this and aside_end knowns may move. */
static Status begin(Instance *c)
{
    if (!columns_of(c)) return instance_refuse(c, "out of memory");

    Status result = aside_begin(c);
    if (result != STATUS_OK) return result;
    if (c->current) keep_base(c, OUTPUTS);
    if (c->is_rated) keep_base(c, RATES);
    return STATUS_OK;
}

static Status evaluate(Instance *c, Part part)
{
    if (part == PREPARED) return instance_prepare(c);
    return part == OUTPUTS ? instance_outputs(c) : instance_rates(c);
}

/* The unknowns where the instance is, once. */
static Status find_base(Instance *c, Part part)
{
    if (c->columns->has_base[part]) return STATUS_OK;
    aside_return(c);

    Status result = evaluate(c, part);
    if (result == STATUS_OK) keep_base(c, part);
    return result;
}

/* The knowns moved by h along the seed. */
static void move(Instance *c, const uint32_t known[], size_t n, const double seed[], double h)
{
    aside_return(c);
    for (size_t i = 0; i < n; i++) {
        int64_t kind = c->resource.variables[known[i]].kind;

        if (seed[i] == 0) continue;
        *variables_place(c, known[i]) += h * seed[i];
        if (kind == VARIABLE_TUNABLE) c->core->prepared = 0;
        if (c->core->mode == INITIALIZATION) c->core->started = 0;
    }
}

/* Adds the differences of a formula along the seed to sum[], and those of the rough one, unless NULL, to rough[]. */
static Status differ(Instance *c, const Formula *formula, double h, const uint32_t known[],
                     size_t n, const double seed[], Part part, double sum[], double rough[])
{
    Status result = STATUS_OK;
    size_t height = columns_height(c, part);

    for (int i = 0; i < formula->n && result == STATUS_OK; i++) {
        const double *value = unknowns(c, part);

        if (formula->place[i] == 0) {
            result = find_base(c, part);
            value = c->columns->base[part];
        } else {
            move(c, known, n, seed, formula->place[i] * h);
            result = evaluate(c, part);
        }
        double weight = formula->weight[i] / h;
        for (size_t k = 0; k < height && result == STATUS_OK; k++) sum[k] += weight * value[k];
        for (size_t k = 0; k < height && result == STATUS_OK && rough; k++)
            rough[k] += ROUGH[i] / h * value[k];
    }
    return result;
}

/* How far the differences of both orders are apart, by the larger of themselves and a thousandth of the largest. */
static double apart(const double fine[], const double rough[], size_t height)
{
    double largest = 0, worst = 0;

    for (size_t k = 0; k < height; k++) largest = fmax(largest, fabs(fine[k]));
    for (size_t k = 0; k < height && largest > 0; k++)
        worst = fmax(worst, fabs(fine[k] - rough[k]) / fmax(fabs(fine[k]), 1e-3 * largest));
    return worst;
}

/* Adds central differences along the seed to sum[], of those of several strides that agree best. */
static Status differ_central(Instance *c, double h, const uint32_t known[], size_t n,
                             const double seed[], Part part, double sum[])
{
    size_t height = columns_height(c, part);
    double *best = calloc(3 * height + 1, sizeof(double)), least = INFINITY;

    if (!best) return instance_refuse(c, "out of memory");

    double *fine = best + height, *rough = fine + height;
    Status result = STATUS_OK;

    for (int k = 0; k < TRIES && result == STATUS_OK && least > AGREE; k++, h /= 4) {
        memset(fine, 0, 2 * height * sizeof(double));
        result = differ(c, &CENTRAL, h, known, n, seed, part, fine, rough);
        if (result != STATUS_OK && k > 0) {
            /* what was found before stands */
            result = STATUS_OK;
            break;
        }
        double doubt = apart(fine, rough, height);

        if (result == STATUS_OK && (k == 0 || doubt < least)) {
            least = doubt;
            memcpy(best, fine, height * sizeof(double));
        }
    }
    for (size_t k = 0; k < height && result == STATUS_OK; k++) sum[k] += best[k];
    free(best);
    return result;
}

/* ---- sizes ---- */

/* Whether it is an effort, which all that follows is affine in; a commanded motion is none. */
static bool is_effort(const Instance *c, uint32_t vr)
{
    return c->resource.variables[vr].kind == VARIABLE_INPUT && c->ints[COUNT_n_command] == 0;
}

/* The largest number of the array that a variable is an element of. */
static double largest_of_array(const Instance *c, uint32_t vr)
{
    const Variable *variables = c->resource.variables;
    uint32_t first = vr;
    double largest = 0;

    while (first > 0 && variables[first].length == 0) first--;
    for (int64_t k = 0; k < variables[first].length; k++)
        largest = fmax(largest, fabs(*variables_place(c, first + (uint32_t)k)));
    return largest;
}

/* How large a known is, or may be; of a parameter that is 0, *none. */
static double size_of(const Instance *c, uint32_t vr, bool *none)
{
    const Variable *variable = &c->resource.variables[vr];
    double value = fabs(*variables_place(c, vr));

    if (variable->kind == VARIABLE_STATE) return c->reals[c->ints[AT_x_nominal] + variable->index];
    if (variable->kind == VARIABLE_TUNABLE) {
        double least = SMALL_PART * largest_of_array(c, vr);

        *none = *none || value == 0;
        value = fmax(value, least);
    }
    return value > SMALLEST ? value : 1;
}

/* h such that a known of this value moves by multiples of it without rounding. */
static double without_rounding(double value, double h)
{
    double far = 8 * fabs(value);
    double snapped = far + h - far;

    return snapped > 0 ? snapped : h;
}

/* columns_add_along by differences. */
static Status differ_along(Instance *c, const uint32_t known[], size_t n, const double seed[],
                           Part part, double sum[])
{
    bool none = false;
    size_t others = 0;
    double h = INFINITY, largest = 0, last = 0;
    double *of_efforts = calloc(2 * n + 1, sizeof(double));

    if (!of_efforts) return instance_refuse(c, "out of memory");

    double *of_others = of_efforts + n;
    Status result = begin(c);

    if (result != STATUS_OK) {
        free(of_efforts);
        return result;
    }
    for (size_t i = 0; i < n; i++) {
        if (seed[i] == 0) continue;
        if (is_effort(c, known[i])) {
            of_efforts[i] = seed[i];
            largest = fmax(largest, fabs(seed[i]) / fmax(1, fabs(*variables_place(c, known[i]))));
        } else {
            of_others[i] = seed[i];
            others++;
            last = copysign(*variables_place(c, known[i]), seed[i]);
            h = fmin(h, size_of(c, known[i], &none) / fabs(seed[i]));
        }
    }
    if (largest > 0)
        result = differ(c, &AFFINE, LARGE / largest, known, n, of_efforts, part, sum, NULL);
    h *= none ? FORWARD.stride : CENTRAL.stride;
    if (others == 1) h = copysign(without_rounding(last, h), none ? last : h);
    if (others > 0 && result == STATUS_OK)
        result = none ? differ(c, &FORWARD, h, known, n, of_others, part, sum, NULL)
                      : differ_central(c, h, known, n, of_others, part, sum);
    aside_end(c);
    free(of_efforts);
    return result;
}

Status columns_add_along(Instance *c, const uint32_t known[], size_t n, const double seed[],
                         Part part, double sum[])
{
    if (part != PREPARED && traced_along(c, known, n, seed) && traced_add(c, 0, part, sum))
        return STATUS_OK;
    return differ_along(c, known, n, seed, part, sum);
}

/* Room for the column of a known; NULL when there is no memory. */
static double *room_for(Instance *c, uint32_t known, Part part)
{
    double **column = &c->columns->column[part][known];

    if (!*column) *column = malloc((columns_height(c, part) + 1) * sizeof(double));
    return *column;
}

/* Keeps the columns of a known that the tape has found in a lane. */
static void keep_traced(Instance *c, uint32_t known, int lane)
{
    for (Part part = OUTPUTS; part < N_PART; part++) {
        if (columns_has(c, known, part)) continue;
        double *column = room_for(c, known, part);
        if (!column) continue;
        memset(column, 0, columns_height(c, part) * sizeof(double));
        c->columns->has[part][known] = traced_add(c, lane, part, column);
    }
}

/* Keeps the columns of a known that stand one behind the other in `found`; none that is not finite. */
static void keep_found(Instance *c, uint32_t known, const double found[])
{
    const size_t from[N_PART] = {[OUTPUTS] = (size_t)c->ints[COUNT_n_x], [RATES] = 0};

    for (Part part = OUTPUTS; part < N_PART; part++) {
        size_t height = columns_height(c, part);
        double *column = columns_has(c, known, part) ? NULL : room_for(c, known, part);
        bool good = column;

        for (size_t k = 0; k < height && good; k++) good = isfinite(found[from[part] + k]);
        if (!good) continue;
        memcpy(column, found + from[part], height * sizeof(double));
        c->columns->has[part][known] = true;
    }
}

/* Finds by the tape the columns of all states and inputs. */
static void find_whole(Instance *c)
{
    size_t length, n_x = (size_t)c->ints[COUNT_n_x];
    double *found = traced_jacobian(c, &length);

    for (uint32_t i = 0; found && i < c->resource.n.variables; i++) {
        const Variable *v = &c->resource.variables[i];
        if (v->kind == VARIABLE_STATE) keep_found(c, i, found + (size_t)v->index * length);
        if (v->kind == VARIABLE_INPUT) keep_found(c, i, found + (n_x + (size_t)v->index) * length);
    }
    free(found);
}

/* Finds by the tape, where it can, the columns of a known, and of others with it where that costs as much:
   of all states and inputs, or of those behind it that are of its kind. */
static void find_traced(Instance *c, uint32_t known)
{
    static const double one = 1;
    const Variable *variables = c->resource.variables;
    uint32_t lane[TAPE_LANES];
    size_t n = 0, n_kind = 0;

    if (variables[known].kind == VARIABLE_TUNABLE) {
        if (traced_along(c, &known, 1, &one)) keep_traced(c, known, 0);
        return;
    }
    for (uint32_t i = 0; i < c->resource.n.variables; i++) {
        if (variables[i].kind != variables[known].kind) continue;
        if (i >= known && n < TAPE_LANES) lane[n++] = i;
        n_kind++;
    }
    if (traced_is_whole(c, n_kind)) {
        find_whole(c);
    } else if (traced_each(c, lane, n)) {
        for (size_t i = 0; i < n; i++) keep_traced(c, lane[i], (int)i);
    }
}

const double *columns_get(Instance *c, uint32_t known, Part part, Status *result)
{
    static const double one = 1;

    *result = STATUS_OK;
    if (columns_has(c, known, part)) return c->columns->column[part][known];

    Columns *k = columns_of(c);
    if (k) find_traced(c, known);
    if (columns_has(c, known, part)) return k->column[part][known];

    double *column = k ? room_for(c, known, part) : NULL;

    if (!column) {
        *result = instance_refuse(c, "out of memory");
        return NULL;
    }
    memset(column, 0, columns_height(c, part) * sizeof(double));
    *result = differ_along(c, &known, 1, &one, part, column);
    k->has[part][known] = *result == STATUS_OK;
    return *result == STATUS_OK ? column : NULL;
}
