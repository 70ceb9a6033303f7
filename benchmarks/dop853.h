/* Dormand and Prince's pair of order 8(5,3) with our tableau (HNW I, II.5 and II.10), for C and C++. */

#ifndef DOP853_H
#define DOP853_H

#include <math.h>

#include "tableau.h" /* of mbdfmi/kernels/steppers/tableaux.py: STAGES, WEIGHTS[STAGES][STAGES], ERRORS[2][STAGES] */

#define MOST_STATES 2048

/* x' of x, of a system */
typedef void (*Rates)(void *system, const double *x, double *rate);

static double error_of(const double k[][MOST_STATES], const double *x, const double *next, int n,
                       double h, double tolerance)
{
    double squares[2] = {0.0, 0.0};

    for (int i = 0; i < n; i++) {
        const double size = fmax(fabs(x[i]), fabs(next[i]));

        for (int e = 0; e < 2; e++) {
            double sum = 0.0;

            for (int j = 0; j < STAGES; j++) {
                sum += ERRORS[e][j] * k[j][i];
            }

            sum /= tolerance * (1.0 + size);
            squares[e] += sum * sum;
        }
    }

    const double below = squares[FINE] + 0.01 * squares[1 - FINE];
    return below > 0.0 ? h * squares[FINE] / sqrt(below * n) : 0.0;
}

/* x[n] from 0 over n_time times, where it stops, into rows[n_time][n]. Returns the number of evaluations, -1 for none. */
static long dop853(Rates rates, void *system, int n, double *x, const double *times, int n_time,
                   double tolerance, double *rows)
{
    static double k[STAGES][MOST_STATES], next[MOST_STATES];
    long evaluations = 1;
    double t = 0.0, h = 1e-3 * times[0];
    rates(system, x, k[0]);

    for (int row = 0; row < n_time; row++) {
        while (t < times[row]) {
            const double left = times[row] - t;
            const int cut = h >= left * (1.0 - 1e-9);
            const double step = cut ? left : h;

            for (int j = 1; j < STAGES; j++) {
                for (int i = 0; i < n; i++) {
                    double sum = 0.0;

                    for (int l = 0; l < j; l++) {
                        sum += WEIGHTS[j][l] * k[l][i];
                    }

                    next[i] = x[i] + step * sum;
                }

                rates(system, next, k[j]);
            }

            evaluations += STAGES - 1;
            const double error = error_of(k, x, next, n, step, tolerance);

            if (!(error < 1e30)) {
                return -1;
            }

            const double factor =
                fmin(6.0, fmax(1.0 / 3.0, 0.9 * pow(fmax(error, 1e-10), -1.0 / 8.0)));

            if (error < 1.0) {
                t = cut ? times[row] : t + step;

                for (int i = 0; i < n; i++) {
                    x[i] = next[i];
                    k[0][i] = k[STAGES - 1][i];
                }

                /* a step that the end cut short says little about the next */
                h = cut ? fmax(h, step * factor) : step * factor;
            } else {
                h = step * fmin(factor, 1.0);
            }
        }

        for (int i = 0; i < n; i++) {
            rows[row * n + i] = x[i];
        }
    }

    return evaluations;
}

#endif
