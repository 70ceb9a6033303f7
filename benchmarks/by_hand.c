/* Reduced equations of three problems of the report, derived by hand: what a program for that mechanism alone costs. */

#include <string.h>

#include "dop853.h"

static const double GRAVITY = 9.81;

/* Two uniform bars of 1 kg and 1 m, planar: angles from the horizontal and their rates. */
static void double_pendulum(void *system, const double *x, double *rate)
{
    (void)system;
    const double c = 0.5 * cos(x[0] - x[1]), s = 0.5 * sin(x[0] - x[1]);
    const double b0 = -s * x[3] * x[3] - 1.5 * GRAVITY * cos(x[0]);
    const double b1 = s * x[2] * x[2] - 0.5 * GRAVITY * cos(x[1]);
    const double m00 = 4.0 / 3.0, m11 = 1.0 / 3.0, determinant = m00 * m11 - c * c;
    rate[0] = x[2];
    rate[1] = x[3];
    rate[2] = (m11 * b0 - c * b1) / determinant;
    rate[3] = (m00 * b1 - c * b0) / determinant;
}

/* Euler's equations about the fixed point, 15 kg at (0, 1, 0); Euler parameters, scalar last, and w, body axes. */
static void heavy_top(void *system, const double *x, double *rate)
{
    (void)system;
    const double J0 = 15.234375, J1 = 0.46875, J2 = 15.234375, weight = 15.0 * GRAVITY;
    const double *E = x, *w = x + 4;
    /* the weight in body axes: the third row of A, times its arm (0, 1, 0) */
    const double up0 = 2.0 * (E[0] * E[2] - E[1] * E[3]),
                 up2 = 1.0 - 2.0 * (E[0] * E[0] + E[1] * E[1]);
    rate[0] = 0.5 * (E[3] * w[0] + E[1] * w[2] - E[2] * w[1]);
    rate[1] = 0.5 * (E[3] * w[1] + E[2] * w[0] - E[0] * w[2]);
    rate[2] = 0.5 * (E[3] * w[2] + E[0] * w[1] - E[1] * w[0]);
    rate[3] = -0.5 * (E[0] * w[0] + E[1] * w[1] + E[2] * w[2]);
    rate[4] = ((J1 - J2) * w[1] * w[2] - weight * up2) / J0;
    rate[5] = (J2 - J0) * w[2] * w[0] / J1;
    rate[6] = ((J0 - J1) * w[0] * w[1] + weight * up0) / J2;
}

/* A planar four-bar by the angle of its crank: directions of the bars, and their turns for a turn of the crank. */
typedef struct {
    double e[3][2], k[3];
} FourBar;

static const double CRANK = 1.0, COUPLER = 2.5, ROCKER = 2.0, GROUND = 2.0;

static double cross(const double *a, const double *b)
{
    return a[0] * b[1] - a[1] * b[0];
}

static double dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1];
}

/* The closure in closed form: coupler and rocker are sides of a triangle on the line from crank to rocker pivot. */
static FourBar close_four_bar(double crank)
{
    FourBar f;
    f.e[0][0] = cos(crank);
    f.e[0][1] = sin(crank);
    const double d[2] = {GROUND - CRANK * f.e[0][0], -CRANK * f.e[0][1]};
    const double square = dot(d, d), b2 = COUPLER * COUPLER, c2 = ROCKER * ROCKER;
    const double along = (b2 + square - c2) / (2.0 * square),
                 across = sqrt(b2 / square - along * along);

    for (int i = 0; i < 2; i++) {
        const double tip = along * d[i] + across * (i == 0 ? -d[1] : d[0]);
        f.e[1][i] = tip / COUPLER;
        f.e[2][i] = (tip - d[i]) / ROCKER;
    }

    const double x23 = cross(f.e[1], f.e[2]);
    f.k[0] = 1.0;
    f.k[1] = -CRANK * cross(f.e[0], f.e[2]) / (COUPLER * x23);
    f.k[2] = -CRANK * cross(f.e[0], f.e[1]) / (ROCKER * x23);
    return f;
}

/* Uniform bars of 1 kg: I(q) q'' + I'(q) q'^2 / 2 + V'(q) = 0. */
static void four_bar(void *system, const double *x, double *rate)
{
    (void)system;
    const FourBar f = close_four_bar(x[0]);
    const double k2 = f.k[1], k3 = f.k[2], x23 = cross(f.e[1], f.e[2]);
    const double c12 = dot(f.e[0], f.e[1]), c13 = dot(f.e[0], f.e[2]), c23 = dot(f.e[1], f.e[2]);
    const double x12 = cross(f.e[0], f.e[1]), a = CRANK, b = COUPLER, c = ROCKER;
    const double bend2 = (a * c13 + b * k2 * k2 * c23 - c * k3 * k3) / (b * x23);
    const double bend3 = (a * c12 + b * k2 * k2 - c * k3 * k3 * c23) / (c * x23);
    const double coupler = b * b / 3.0, rocker = c * c / 3.0;
    const double inertia =
        a * a / 3.0 + a * a + a * b * k2 * c12 + coupler * k2 * k2 + rocker * k3 * k3;
    /* d c12 / dq = x12 (1 - k2) */
    const double half_slope = 0.5 * a * b * (bend2 * c12 + k2 * x12 * (1.0 - k2))
                              + coupler * k2 * bend2 + rocker * k3 * bend3;
    const double pull =
        GRAVITY * (1.5 * a * f.e[0][0] + 0.5 * b * k2 * f.e[1][0] + 0.5 * c * k3 * f.e[2][0]);
    rate[0] = x[1];
    rate[1] = -(half_slope * x[1] * x[1] + pull) / inertia;
}

/* Each system called where it is known, so that it is inlined. */
long by_hand_run(int system, int n, const double *start, const double *times, int n_time,
                 double tolerance, double *rows)
{
    double x[8];
    memcpy(x, start, n * sizeof *x);

    switch (system) {
        case 0:  return dop853(double_pendulum, 0, 4, x, times, n_time, tolerance, rows);
        case 1:  return dop853(heavy_top, 0, 7, x, times, n_time, tolerance, rows);
        default: return dop853(four_bar, 0, 2, x, times, n_time, tolerance, rows);
    }
}

#define MANY(rates)                                                                                \
    for (; times > 0; times--) {                                                                   \
        rates(0, x, rate);                                                                         \
        for (int k = 0; k < n; k++) x[k] += 1e-12 * rate[k];                                       \
    }

/* That many evaluations, each at a state that follows from the one before. */
void by_hand_many(int system, int n, long times, double *x)
{
    double rate[8];

    switch (system) {
        case 0:  MANY(double_pendulum) break;
        case 1:  MANY(heavy_top) break;
        default: MANY(four_bar) break;
    }
}

/* Angles (rad) and rates of all three bars, by that of the crank. */
void by_hand_four_bar(const double *x, double *angles, double *rates)
{
    const FourBar f = close_four_bar(x[0]);

    for (int k = 0; k < 3; k++) {
        angles[k] = atan2(f.e[k][1], f.e[k][0]);
        rates[k] = f.k[k] * x[1];
    }
}
