/* Steps of FMI 3.0: one that is discarded leaves the instance as it was, and where the master asks for it it
   sees points within a step and may return from one. With event mode a step tells of events, and ends at the first where the
   master lets it. */
#ifndef MBDFMI_INTERMEDIATE_H
#define MBDFMI_INTERMEDIATE_H

#include "instance.h"

/* How a step ended: before its time, at or behind an event. */
typedef struct {
    bool early, event;
} StepEnd;

/* Advances from the communication point t by H (s), or less. */
Status intermediate_step(Instance *c, double t, double H, StepEnd *end);

#endif
