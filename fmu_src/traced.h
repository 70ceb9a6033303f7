/* Derivatives by the tape: exact, where it has been written and holds. */
#ifndef MBDFMI_TRACED_H
#define MBDFMI_TRACED_H

#include "columns.h"
#include "tape.h"

/* Finds the derivatives of all by n <= TAPE_LANES knowns, each in its lane; or along a seed of them, in
   lane 0. No tunable parameter may be among several lanes. False where they are to be found otherwise. */
bool traced_each(Instance *c, const uint32_t known[], size_t n);
bool traced_along(Instance *c, const uint32_t known[], size_t n, const double seed[]);

/* Adds what was found in a lane to a column; false, and nothing is added, where the tape does not hold along
   it. */
bool traced_add(const Instance *c, int lane, Part part, double column[]);

/* Whether all columns of states and inputs are found at once as soon as n are. */
bool traced_is_whole(Instance *c, size_t n);

/* The derivatives of x', then of outputs, by each state and each input, in columns of this length one
   after another, to be freed; NULL where they are to be found otherwise. */
double *traced_jacobian(Instance *c, size_t *length);

void traced_free(Instance *c);

#endif
