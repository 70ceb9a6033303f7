/* Events: where a joint comes to its stops, where tables over a coordinate have kinks, and at what time those over time have.

   Between two kinks a coordinate is in a piece of its table, which is held until an event is handled; its indicators change
   their sign a little beyond the ends of that piece. So each way through a kink is one event, and none is where a coordinate
   trembles at it by less. */
#ifndef MBDFMI_EVENTS_H
#define MBDFMI_EVENTS_H

#include "instance.h"

/* What an event comes to; times in s. */
typedef struct {
    bool states_changed;
    bool next_time_defined;
    double next_time;
} Event;

/* Brings c->indicators up to date. */
Status events_indicators(Instance *c);

/* Handles an event: pieces to where coordinates are, and the time of the next. */
Status events_settle(Instance *c, Event *event);

/* Whether any indicator has another sign than in `before`. */
bool events_crossed(const Instance *c, const double before[]);

/* Advances from `at` by h, where indicators change their sign on the way, to the first such place, a little beyond it: `before`
   is what they are at `at`, and `block` the instance there, c->core_size bytes. h: how far it went. */
Status events_advance_to(Instance *c, double at, double *h, const double before[],
                         const void *block);

#endif
