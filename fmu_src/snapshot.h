/* Snapshots of an instance: a head and a copy of its block of memory. The bytes of a snapshot are
   also its serialised form. To a master they are pointers to it knows not what; one that is not of
   this model is refused. */
#ifndef MBDFMI_SNAPSHOT_H
#define MBDFMI_SNAPSHOT_H

#include "instance.h"

/* Fills the snapshot *state, or a new one when it is NULL. */
Status snapshot_get(Instance *c, void **state);

Status snapshot_set(Instance *c, const void *state);

/* Frees *state, if there is one, and makes it NULL. */
Status snapshot_free(Instance *c, void **state);

Status snapshot_size(Instance *c, const void *state, size_t *size);

Status snapshot_serialise(Instance *c, const void *state, void *bytes, size_t size);

/* Fills the snapshot *state, or a new one when it is NULL. */
Status snapshot_deserialise(Instance *c, const void *bytes, size_t size, void **state);

#endif
