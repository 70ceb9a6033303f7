/* The tape of a scene: x' and outputs as one line of operations, written by mbdfmi/export/tape.py, and
   exact derivatives by it: along several seeds at once, or of all results by rows.

   Its first part leads from the state that a solver gave to the one that keeps to the constraints, `led`;
   the second leads on from there, or in co-simulation from the instance's own state. It holds where its
   guards do, and where nothing that it takes for equal is moved apart. */
#ifndef MBDFMI_TAPE_H
#define MBDFMI_TAPE_H

#include "graph.h"
#include "instance.h"

/* Seeds at once. */
#define TAPE_LANES GRAPH_LANES

typedef struct Tape Tape;

/* Bytes of the tape in the resource file. */
int64_t tape_size(const Sizes *n);

/* Takes the tape of a resource from `data`, tape_size bytes; false when an index in it leads nowhere. */
bool tape_take(Resource *r, const unsigned char *data);

/* NULL when there is no memory. */
Tape *tape_create(const Resource *r);

void tape_free(Tape *t);

/* All values for the buffers of an instance. x: the state that was given; led: the one on from which the
   second part goes; by_led: whether that follows from the first. False where the tape does not hold. */
bool tape_evaluate(Tape *t, const Instance *c, const double x[], const double led[], bool by_led);

/* All seeds to 0. */
void tape_rest(Tape *t);

/* Adds to a leaf's seed in a lane: whatever stands at a place of a buffer (LEAF_...). */
void tape_move(Tape *t, int buffer, int64_t place, int lane, double seed);

/* Adds to the seeds of leaves in the state, in lane 0. */
void tape_move_state(Tape *t, const double seed[]);

/* The derivatives of all operations. */
void tape_forward(Tape *t);

/* Those of result i in a lane. */
double tape_rate(const Tape *t, int64_t i, int lane);

/* Whether the tape holds along a lane's seed too. */
bool tape_holds(const Tape *t, int lane);

/* In how many sweeps tape_add_jacobian goes over all operations, tape_forward in one; INT64_MAX where
   what the tape takes for equal may be moved apart, and has to be looked at along each seed. */
int64_t tape_n_sweeps(const Tape *t);

/* Adds the derivatives of all results by each state, then by each input. */
void tape_add_jacobian(Tape *t, double jacobian[]);

#endif
