/* Whether a rest is one that the motion comes back to. */
#ifndef MBDFMI_STABILITY_H
#define MBDFMI_STABILITY_H

#include "instance.h"

/* The rate (1/s) at which what is off grows about the state as it is, which is at rest; 0 where nothing grows, or
   where it is not known: in models of many coordinates, without memory, where a state beside it has no rates. */
double stability_growth(Instance *c);

#endif
