/* The start at rest, where the resource has one: a Boolean parameter asks for it. */
#ifndef MBDFMI_REST_H
#define MBDFMI_REST_H

#include "instance.h"

/* Values of Boolean variables: there is one, where a start at rest is offered. `type` : what the standard
   calls them. Refuse other references, and a NULL; setting, all or nothing, what is fixed by now. */
Status rest_check_references(Instance *c, const uint32_t vr[], size_t n, const void *value,
                             const char *type);
Status rest_set(Instance *c, bool rests);

/* Warns where a start at rest was asked for and is none, by values other than those that the rest was
   found for, or where start values were set that it does not take. */
Status rest_check(Instance *c);

#endif
