/* The entry points of the compiled kernels, declared in layout.h, and what there is to know of them.

   Each returns 0 (anything else: an internal failure) and writes to *status code + PLACE*place,
   0 when all is well; the texts of the codes and the names of the places are in the resource file.
   excinfo is numba's and stays unused.

   ints    structure of the model, read only, shared by everything
   reals   parameters and constants of one instance, SI units
   state   state of one instance: in AT_time its time (s), in AT_notices the number of notices to
           tell in the log, in AT_notice the first MOST_NOTICES of them; the rest is the kernels'
           own, what prepare derives from the parameters too
   work    scratch, zero at first; AT_lu_known and AT_stages_here are to be 0 when the state is not that
           of the last call
   u       N_DERIVATIVE*n_u: values of the inputs, then their derivatives of order 1 to 5 at the
           start of the step, which carries the values to its end and clears the derivatives
   y       n_y outputs

   mbdfmi_prepare      after any change of a parameter, before anything else uses it
   mbdfmi_initialise   start values -> state at the time t0 (s)
   mbdfmi_step         advances by H (s); on failure the state is that of the last accepted inner step
   mbdfmi_complete     notices of a state that a solver outside has come to
   mbdfmi_outputs      y at the present state
*/
#ifndef MBDFMI_KERNELS_H
#define MBDFMI_KERNELS_H

#include "layout.h" /* written when a library is linked, see mbdfmi/export/header.py */

#endif
