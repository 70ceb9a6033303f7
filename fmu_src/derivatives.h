/* Directional and adjoint derivatives, exact by the scene's tape where that holds, else from differences: of
   what is affine in the knowns exact to rounding, else of order 6, some ten digits of smooth functions.
   What was found is kept until the instance changes. */
#ifndef MBDFMI_DERIVATIVES_H
#define MBDFMI_DERIVATIVES_H

#include "instance.h"

/* Of outputs and rates by inputs, tunable parameters and, in model exchange, states, along `seed`. The
   instance stays as it is. */
Status derivatives_along(Instance *c, const uint32_t unknown[], size_t n_unknown,
                         const uint32_t known[], size_t n_known, const double seed[],
                         double sensitivity[]);

/* The same where a value reference means a whole array; n_seed and n_sensitivity are lengths. Adjoint:
   the seed is of the unknowns, the sensitivity by the knowns. */
Status derivatives_of_arrays(Instance *c, bool adjoint, const uint32_t unknown[], size_t n_unknown,
                             const uint32_t known[], size_t n_known, const double seed[],
                             size_t n_seed, double sensitivity[], size_t n_sensitivity);

#endif
