/* Evaluations aside: between begin and end an instance may be moved at will, and after them it is, to the
   bit, as if nothing had been done. */
#ifndef MBDFMI_ASIDE_H
#define MBDFMI_ASIDE_H

#include "instance.h"

/* The instance is prepared first; refused when that fails or there is no memory. */
Status aside_begin(Instance *c);

/* Back to where it began, to move on from there. */
void aside_return(Instance *c);

void aside_end(Instance *c);

void aside_free(Instance *c);

#endif
