/* Snapshots of an instance: a head and a copy of its block of memory. The bytes of a snapshot are
   also its serialised form. */
#ifndef MBDFMI_SNAPSHOT_H
#define MBDFMI_SNAPSHOT_H

#include "instance.h"

typedef struct Snapshot Snapshot;

/* Fills the given snapshot, or a new one when it is NULL; NULL when memory is short. */
Snapshot *snapshot_take(const Instance *c, Snapshot *s);

void snapshot_restore(Instance *c, const Snapshot *s);

void snapshot_free(Snapshot *s);

/* NULL when the snapshot is one of this model, else what is wrong with it. */
const char *snapshot_fault(const Instance *c, const Snapshot *s);

size_t snapshot_size(const Instance *c);

/* snapshot_size bytes */
void snapshot_write(const Instance *c, const Snapshot *s, char *bytes);

/* Fills the given snapshot, or a new one when it is NULL; NULL and *fault when refused. */
Snapshot *snapshot_read(const Instance *c, Snapshot *s, const char *bytes, size_t size,
                        const char **fault);

#endif
