/* Values of variables by value reference. */
#ifndef MBDFMI_VARIABLES_H
#define MBDFMI_VARIABLES_H

#include "instance.h"

/* Where the value of a variable is. */
double *variables_place(const Instance *c, uint32_t vr);

/* Brings what is asked for up to date. */
Status variables_get(Instance *c, const uint32_t vr[], size_t n, double value[]);

/* Sets all or nothing. */
Status variables_set(Instance *c, const uint32_t vr[], size_t n, const double value[]);

/* The same where a value reference means a whole array: that of its first element means all of them,
   those of the others nothing; behind the last variable stands time. `room` is the length of
   `value`. */
Status variables_get_arrays(Instance *c, const uint32_t vr[], size_t n, double value[],
                            size_t room);
Status variables_set_arrays(Instance *c, const uint32_t vr[], size_t n, const double value[],
                            size_t room);

/* Sets derivatives of inputs, order 1 to N_DERIVATIVE - 1, at the start of the next step; all or
   nothing. */
Status variables_set_derivatives(Instance *c, const uint32_t vr[], size_t n, const int32_t order[],
                                 const double value[]);

#endif
