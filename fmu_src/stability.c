#include "stability.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "kernels.h"

/* More coordinates than these take too long to look at. */
#define MOST_COORDINATES 200

/* How far coordinates are moved, in parts of their sizes: rounding and curvature are alike small then. */
#define WAY 1e-4

/* A power of I + B/size of 2^26 shows what grows by more than 1e-7 of what is stiffest. */
#define SQUARINGS 26
#define MEASURED  22
#define GROWS     1e-7

typedef struct {
    Instance *c;
    double *moved; /* x, to be looked at */
    int64_t n_q, n_v, n_x;
} Look;

/* Accelerations into a[n_v] of the state moved to the constraints from l->moved. */
static bool accelerations(const Look *l, double a[])
{
    Instance *c = l->c;
    void *excinfo;
    int64_t status = CODE_OK;

    memcpy(instance_x(c), l->moved, (size_t)l->n_x * sizeof(double));
    if (mbdfmi_lead(&status, &excinfo, M_OF(c), D_OF(c)) || status != CODE_OK) return false;
    if (mbdfmi_rates(&status, &excinfo, M_OF(c), D_OF(c)) || status != CODE_OK) return false;
    memcpy(a, c->work + c->ints[AT_x_rate] + l->n_q, (size_t)l->n_v * sizeof(double));
    return true;
}

/* How positions move with velocity coordinate j into way[n_q], far enough to look. */
static bool way_of(const Look *l, const double x[], int64_t j, double way[])
{
    Instance *c = l->c;
    const double *nominal = c->reals + c->ints[AT_x_nominal];
    void *excinfo;
    int64_t status = CODE_OK;
    double length = INFINITY;

    memcpy(instance_x(c), x, (size_t)l->n_x * sizeof(double));
    for (int64_t i = 0; i < l->n_v; i++) instance_x(c)[l->n_q + i] = i == j;
    if (mbdfmi_rates(&status, &excinfo, M_OF(c), D_OF(c)) || status != CODE_OK) return false;

    memcpy(way, c->work + c->ints[AT_x_rate], (size_t)l->n_q * sizeof(double));
    for (int64_t k = 0; k < l->n_q; k++)
        if (way[k] != 0) length = fmin(length, WAY * nominal[k] / fabs(way[k]));
    if (!(length < INFINITY)) length = 0;
    for (int64_t k = 0; k < l->n_q; k++) way[k] *= length;
    way[l->n_q] = length;
    return true;
}

/* B[n_v][n_v], accelerations by displacements, by rows; room for 2 n_v + n_q + 1 numbers. */
static bool stiffness(const Look *l, const double x[], double *B, double *room)
{
    int64_t n = l->n_v;
    double *up = room, *down = room + n, *way = room + 2 * n;

    for (int64_t j = 0; j < n; j++) {
        if (!way_of(l, x, j, way)) return false;
        for (int side = 0; side < 2; side++) {
            memcpy(l->moved, x, (size_t)l->n_x * sizeof(double));
            for (int64_t k = 0; k < l->n_q; k++) l->moved[k] += side ? -way[k] : way[k];
            if (!accelerations(l, side ? down : up)) return false;
        }
        double length = way[l->n_q];
        for (int64_t i = 0; i < n; i++)
            B[i * n + j] = length > 0 ? (up[i] - down[i]) / (2 * length) : 0;
    }
    return true;
}

/* The largest sum of absolute values of a row. */
static double size_of(const double *A, int64_t n)
{
    double size = 0;

    for (int64_t i = 0; i < n; i++) {
        double sum = 0;
        for (int64_t j = 0; j < n; j++) sum += fabs(A[i * n + j]);
        size = fmax(size, sum);
    }
    return size;
}

/* The largest real part of an eigenvalue of B, in parts of its size, by powers of I + B/size; B is lost. */
static double largest(double *B, double size, double *squared, int64_t n)
{
    double grown = 0, measured = 0, steps = 1;

    for (int64_t k = 0; k < n * n; k++) B[k] = B[k] / size + (k % (n + 1) == 0);

    for (int round = 0; round < SQUARINGS; round++) {
        for (int64_t i = 0; i < n; i++) {
            for (int64_t j = 0; j < n; j++) squared[i * n + j] = 0;
            for (int64_t k = 0; k < n; k++) {
                double part = B[i * n + k];
                if (part != 0)
                    for (int64_t j = 0; j < n; j++) squared[i * n + j] += part * B[k * n + j];
            }
        }

        double length = size_of(squared, n);
        if (!(length > 0 && length < INFINITY)) return 0;
        for (int64_t k = 0; k < n * n; k++) B[k] = squared[k] / length;

        grown = 2 * grown + log(length);
        steps *= 2;
        if (round == MEASURED - 1) measured = grown;
    }
    return expm1((grown - measured) / (steps - ldexp(1, MEASURED)));
}

double stability_growth(Instance *c)
{
    int64_t n = c->ints[COUNT_n_v], n_q = c->ints[COUNT_n_q], n_x = c->ints[COUNT_n_x];
    size_t n_state = (size_t)c->resource.n.state;
    double growth = 0;

    if (n == 0 || n > MOST_COORDINATES) return 0;

    size_t numbers =
        n_state + 2 * (size_t)n_x + 2 * (size_t)(n * n) + 2 * (size_t)n + (size_t)n_q + 1;
    double *room = malloc(numbers * sizeof(double));
    if (!room) return 0;

    double *x = room + n_state, *B = x + 2 * n_x, *squared = B + n * n, *rest = squared + n * n;
    Look look = {c, x + n_x, n_q, n, n_x};

    memcpy(room, c->state, n_state * sizeof(double));
    memcpy(x, instance_x(c), (size_t)n_x * sizeof(double));
    if (stiffness(&look, x, B, rest)) {
        double size = size_of(B, n);
        double part = size > 0 && size < INFINITY ? largest(B, size, squared, n) : 0;
        growth = part > GROWS ? sqrt(part * size) : 0;
    }
    memcpy(c->state, room, n_state * sizeof(double));
    instance_changed(c);
    free(room);
    return growth;
}
