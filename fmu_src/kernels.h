/* The entry points of the compiled kernels, and all that the wrapper knows of them.

   Each returns 0 (anything else: an internal failure) and writes to *status
   code + 256*place, 0 when all is well; the texts of the codes and the names of the
   places are in the resource file. excinfo is numba's and stays unused.

   ints    structure of the model, read only, shared by everything
   reals   parameters and constants of one instance, SI units
   state   state of one instance: state[0] is the time (s), state[2] the number of notices to tell
           in the log, from state[3] on a status and two numbers for each of the first MOST_NOTICES;
           the rest is the kernels' own, what prepare derives from the parameters too
   work    scratch, zero at first; work[0] is to be 0 when the state is not that of the last call
   u       N_DERIVATIVE*n_u: values of the inputs, then their derivatives of order 1 to 5 at the
           start of the step, which carries the values to its end and clears the derivatives
   y       n_y outputs
*/
#ifndef MBDFMI_KERNELS_H
#define MBDFMI_KERNELS_H

#include <stdint.h>

#define N_DERIVATIVE 6

/* of status.py: notices of a step that are events in the log (others are warnings), and a failure that is of
   single values */
enum { STIFF = 10, NOT_STIFF = 11, OUTPUT_NOT_FINITE = 13 };

#define MOST_NOTICES    16
#define N_HEAD_OF_STATE (3 + 3 * MOST_NOTICES)

/* after any change of a parameter, before anything else uses it */
int32_t mbdfmi_prepare(int64_t *status, void **excinfo, const int64_t *ints, double *reals,
                       const int64_t *ints_again, double *state, double *work, double *u);

/* start values -> state at the time t0 (s) */
int32_t mbdfmi_initialise(int64_t *status, void **excinfo, const int64_t *ints, double *reals,
                          const int64_t *ints_again, double *state, double *work, double *u,
                          double t0);

/* advances by H (s); on failure the state is that of the last accepted inner step */
int32_t mbdfmi_step(int64_t *status, void **excinfo, const int64_t *ints, double *reals,
                    const int64_t *ints_again, double *state, double *work, double *u, double H);

/* y at the present state */
int32_t mbdfmi_outputs(int64_t *status, void **excinfo, const int64_t *ints, double *reals,
                       const int64_t *ints_again, double *state, double *work, double *u,
                       double *y);

#endif
