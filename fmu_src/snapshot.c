#include "snapshot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "kernels.h"

#define VERSION 1

static const char MAGIC[8] = {'m', 'b', 'd', 'f', 'm', 'i', '\0', 'S'};

struct Snapshot {
    char magic[8];
    uint32_t version;
    uint32_t crc; /* of core and what follows, in the serialised form */
    int64_t n_reals, n_state, n_u;
    char guid[GUID_SIZE];
    Core core; /* and the rest of the instance's block */
};

#define HEAD_SIZE offsetof(Snapshot, core)

size_t snapshot_size(const Instance *c)
{
    return HEAD_SIZE + c->core_size;
}

Snapshot *snapshot_take(const Instance *c, Snapshot *s)
{
    const Resource *r = &c->resource;

    if (!s) s = malloc(snapshot_size(c));
    if (!s) return NULL;

    memcpy(s->magic, MAGIC, sizeof MAGIC);
    s->version = VERSION;
    s->crc = 0;
    s->n_reals = r->n_reals;
    s->n_state = r->n_state;
    s->n_u = r->n_u;
    memcpy(s->guid, r->guid, GUID_SIZE);
    memcpy((char *)s + HEAD_SIZE, c->core, c->core_size);
    return s;
}

void snapshot_restore(Instance *c, const Snapshot *s)
{
    c->current = false;
    memcpy(c->core, (const char *)s + HEAD_SIZE, c->core_size);
    c->work[c->ints[AT_lu_known]] = 0;
}

void snapshot_free(Snapshot *s)
{
    free(s);
}

const char *snapshot_fault(const Instance *c, const Snapshot *s)
{
    const Resource *r = &c->resource;

    if (memcmp(s->magic, MAGIC, sizeof MAGIC) != 0)
        return "it is not a state of an FMU made by mbdfmi";
    if (s->version != VERSION) return "it has another format";
    if (memcmp(s->guid, r->guid, GUID_SIZE) != 0) return "it belongs to another FMU";
    if (s->n_reals != r->n_reals || s->n_state != r->n_state || s->n_u != r->n_u)
        return "its sizes are not those of this FMU";
    return NULL;
}

void snapshot_write(const Instance *c, const Snapshot *s, char *bytes)
{
    uint32_t crc = crc32_of((const char *)s + HEAD_SIZE, c->core_size);

    memcpy(bytes, s, snapshot_size(c));
    memcpy(bytes + offsetof(Snapshot, crc), &crc, sizeof crc);
}

/* Whether the core and the numbers behind it could be those of an instance. What the kernels keep in
   the state is theirs to judge: they end a step or an output that is not finite. */
static bool possible(const Instance *c, const Core *core)
{
    const Resource *r = &c->resource;
    const double *reals = (const double *)(core + 1), *state = reals + r->n_reals;
    const double *u = state + r->n_state;
    int64_t mode = core->mode;

    if (mode != INSTANTIATED && mode != INITIALIZATION && mode != STEP_COMPLETE
        && mode != STEP_FAILED && mode != TERMINATED)
        return false;
    if ((core->prepared | core->started | 1) != 1) return false;
    if (mode != INSTANTIATED && mode != INITIALIZATION && !core->started) return false;
    if (!(isfinite(core->start_time) && isfinite(core->time) && core->stop_time >= core->start_time
          && core->step >= 0 && isfinite(core->step) && isfinite(state[r->ints[AT_time]])))
        return false;

    for (int64_t i = 0; i < r->n_reals; i++)
        if (!isfinite(reals[i]) && !(reals[i] == r->reals[i])) return false;
    for (int64_t i = 0; i < N_DERIVATIVE * r->n_u; i++)
        if (!isfinite(u[i])) return false;
    return true;
}

Snapshot *snapshot_read(const Instance *c, Snapshot *s, const char *bytes, size_t size,
                        const char **fault)
{
    if (size != snapshot_size(c)) {
        *fault = "its length is not that of a state of this FMU";
        return NULL;
    }

    Snapshot *copy = malloc(size);
    if (!copy) {
        *fault = "out of memory";
        return NULL;
    }
    memcpy(copy, bytes, size);

    *fault = snapshot_fault(c, copy);
    if (!*fault && crc32_of(bytes + HEAD_SIZE, c->core_size) != copy->crc)
        *fault = "its checksum is wrong: damaged";
    if (!*fault && !possible(c, &copy->core)) *fault = "it holds impossible values";
    if (*fault) {
        free(copy);
        return NULL;
    }

    if (!s) return copy;
    memcpy(s, copy, size);
    free(copy);
    return s;
}
