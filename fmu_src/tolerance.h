/* Which tolerance the solver of co-simulation keeps to: a parameter that was set, else the master's, else the
   scene's. */
#ifndef MBDFMI_TOLERANCE_H
#define MBDFMI_TOLERANCE_H

#include "instance.h"

bool tolerance_is_possible(double value);

/* The parameter at a place in reals was set. */
void tolerance_told(Instance *c, int64_t index);

/* Takes up the master's tolerance, for the relative one of the scene and, in proportion, the absolute one, as
   far as these were not set as parameters; the scene's where it is NULL. */
Status tolerance_take(Instance *c, const double *tolerance);

#endif
