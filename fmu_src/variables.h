/* Values of variables by value reference. */
#ifndef MBDFMI_VARIABLES_H
#define MBDFMI_VARIABLES_H

#include "instance.h"

/* Brings what is asked for up to date. */
Status variables_get(Instance *c, const uint32_t vr[], size_t n, double value[]);

/* Sets all or nothing. */
Status variables_set(Instance *c, const uint32_t vr[], size_t n, const double value[]);

/* Sets derivatives of inputs, order 1 to N_DERIVATIVE - 1, at the start of the next step; all or
   nothing. */
Status variables_set_derivatives(Instance *c, const uint32_t vr[], size_t n, const int32_t order[],
                                 const double value[]);

#endif
