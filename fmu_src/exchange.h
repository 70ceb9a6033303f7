/* Model exchange: a solver outside integrates the states. What it gives need not keep to the
   constraints: rates and outputs are those of the nearest state that does, and only when it has gone
   far from that is the solver asked to take it on. */
#ifndef MBDFMI_EXCHANGE_H
#define MBDFMI_EXCHANGE_H

#include "events.h"

Status exchange_set_time(Instance *c, double time);

/* The states, their rates and sizes, in the order of their variables; n: the length of the array. */
Status exchange_set_states(Instance *c, const double x[], size_t n);
Status exchange_get_states(Instance *c, double x[], size_t n);
Status exchange_get_rates(Instance *c, double rates[], size_t n);
Status exchange_get_nominals(Instance *c, double nominals[], size_t n);
Status exchange_get_indicators(Instance *c, double z[], size_t n);

/* `wanted`: an event, in which the states go back to the constraints. */
Status exchange_complete_step(Instance *c, bool *wanted);

Status exchange_update(Instance *c, Event *event);

#endif
