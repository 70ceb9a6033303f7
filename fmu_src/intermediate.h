/* Steps of FMI 3.0: one that is discarded leaves the instance as it was, and where the master asks for it it
   sees points within a step and may return from one. */
#ifndef MBDFMI_INTERMEDIATE_H
#define MBDFMI_INTERMEDIATE_H

#include "instance.h"

/* Advances from the communication point t by H (s), or less: then *early. */
Status intermediate_step(Instance *c, double t, double H, bool *early);

#endif
