/* The motion on from now: derivatives of outputs by time. */
#ifndef MBDFMI_COURSE_H
#define MBDFMI_COURSE_H

#include "instance.h"

#define MOST_OUTPUT_ORDER 2

/* Of outputs by time, order 1 to MOST_OUTPUT_ORDER, by differences of order 4; inputs go on by the
   derivatives that were set, and stay where none were. The instance stays as it is. */
Status course_derivatives(Instance *c, const uint32_t vr[], size_t n, const int32_t order[],
                          double value[]);

/* The same where a value reference means a whole array, with one order; n_value: length of `value`. */
Status course_derivatives_of_arrays(Instance *c, const uint32_t vr[], size_t n,
                                    const int32_t order[], double value[], size_t n_value);

#endif
