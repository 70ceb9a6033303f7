#include "snapshot.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "crc32.h"
#include "kernels.h"

#define VERSION 5

static const char MAGIC[8] = {'m', 'b', 'd', 'f', 'm', 'i', '\0', 'S'};

typedef struct {
    uint64_t
        none; /* 0: some masters (fmusim 0.0.39) take the first word for a pointer to the state */
    char magic[8];
    uint32_t version;
    uint32_t crc; /* of core and what follows, in the serialised form */
    int64_t n_reals, n_state, n_u;
    char guid[GUID_SIZE];
    Core core; /* and the rest of the instance's block */
} Snapshot;

#define HEAD_SIZE offsetof(Snapshot, core)

static size_t size_of(const Instance *c)
{
    return HEAD_SIZE + c->core_size;
}

/* NULL when the snapshot is one of this model, else what is wrong with it. */
static const char *fault_of(const Instance *c, const Snapshot *s)
{
    const Resource *r = &c->resource;

    if (!s) return "it is NULL";
    if (s->none != 0 || memcmp(s->magic, MAGIC, sizeof MAGIC) != 0)
        return "it is not a state of an FMU made by mbdfmi";
    if (s->version != VERSION) return "it has another format";
    if (memcmp(s->guid, r->guid, GUID_SIZE) != 0) return "it belongs to another FMU";
    if (s->n_reals != r->n.reals || s->n_state != r->n.state || s->n_u != r->n.u)
        return "its sizes are not those of this FMU";
    if (s->core.mode == EVENT && !c->exchanges)
        return c->has_events ? NULL : "it is one in event mode, and this instance has none";
    if (s->core.mode & (c->exchanges ? STEP_MODES : EXCHANGE_MODES))
        return c->exchanges ? "it is one of co-simulation" : "it is one of model exchange";
    return NULL;
}

static Status check(Instance *c, const Snapshot *s)
{
    const char *fault = fault_of(c, s);

    return fault ? instance_refuse(c, "the FMU state is refused: %s", fault) : STATUS_OK;
}

/* The snapshot that *state is, or a new one when it is NULL; NULL, and `result` says why. */
static Snapshot *make_room(Instance *c, void **state, Status *result)
{
    if (!state) {
        *result = instance_refuse(c, "FMUstate is NULL");
        return NULL;
    }
    if (*state) {
        *result = check(c, *state);
        return *result == STATUS_OK ? *state : NULL;
    }

    Snapshot *s = malloc(size_of(c));
    *result = s ? STATUS_OK : instance_refuse(c, "out of memory");
    return s;
}

Status snapshot_get(Instance *c, void **state)
{
    const Resource *r = &c->resource;
    Status result;
    Snapshot *s = make_room(c, state, &result);

    if (!s) return result;
    s->none = 0;
    memcpy(s->magic, MAGIC, sizeof MAGIC);
    s->version = VERSION;
    s->crc = 0;
    s->n_reals = r->n.reals;
    s->n_state = r->n.state;
    s->n_u = r->n.u;
    memcpy(s->guid, r->guid, GUID_SIZE);
    memcpy((char *)s + HEAD_SIZE, c->core, c->core_size);
    *state = s;
    return STATUS_OK;
}

Status snapshot_set(Instance *c, const void *state)
{
    Status result = check(c, state);

    if (result != STATUS_OK) return result;
    instance_restore(c, (const char *)state + HEAD_SIZE);
    return STATUS_OK;
}

Status snapshot_free(Instance *c, void **state)
{
    if (!state || !*state) return STATUS_OK;

    Status result = check(c, *state);
    if (result != STATUS_OK) return result;
    free(*state);
    *state = NULL;
    return STATUS_OK;
}

Status snapshot_size(Instance *c, const void *state, size_t *size)
{
    Status result = check(c, state);

    if (result != STATUS_OK) return result;
    if (!size) return instance_refuse(c, "size is NULL");
    *size = size_of(c);
    return STATUS_OK;
}

Status snapshot_serialise(Instance *c, const void *state, void *bytes, size_t size)
{
    Status result = check(c, state);

    if (result != STATUS_OK) return result;
    if (!bytes) return instance_refuse(c, "serializedState is NULL");
    if (size < size_of(c))
        return instance_refuse(c, "%zu bytes are given, %zu are needed", size, size_of(c));

    uint32_t crc = crc32_of((const char *)state + HEAD_SIZE, c->core_size);
    memcpy(bytes, state, size_of(c));
    memcpy((char *)bytes + offsetof(Snapshot, crc), &crc, sizeof crc);
    return STATUS_OK;
}

/* Whether the core and the numbers behind it could be those of an instance. What the kernels keep in
   the state is theirs to judge: they end a step or an output that is not finite. */
static bool is_possible(const Instance *c, const Core *core)
{
    const Resource *r = &c->resource;
    const double *reals = (const double *)(core + 1), *state = reals + r->n.reals;
    const double *u = state + r->n.state, *piece = u + N_DERIVATIVE * r->n.u;
    int64_t mode = core->mode;

    if (mode != INSTANTIATED && mode != INITIALIZATION && mode != STEP_COMPLETE
        && mode != STEP_FAILED && mode != TERMINATED && mode != EVENT && mode != CONTINUOUS_TIME)
        return false;
    if (isnan(core->event_time)) return false;
    if ((core->rests | 1) != 1 || core->rests > (r->n.rest > 0)) return false;
    if ((core->prepared | core->started | 1) != 1 || (core->told_tolerances | 3) != 3) return false;
    if (mode != INSTANTIATED && mode != INITIALIZATION && !core->started) return false;
    if (!(isfinite(core->start_time) && isfinite(core->time) && core->stop_time >= core->start_time
          && core->step >= 0 && isfinite(core->step) && isfinite(state[r->ints[AT_time]])))
        return false;

    for (int64_t i = 0; i < r->n.reals; i++)
        if (!isfinite(reals[i]) && !(reals[i] == r->reals[i])) return false;
    for (int64_t i = 0; i < N_DERIVATIVE * r->n.u; i++)
        if (!isfinite(u[i])) return false;
    for (int64_t i = 0; i < r->survey[SURVEY_WATCHED].n_y; i++)
        if (!(piece[i] >= 0 && piece[i] <= 1 + (double)r->n_kinks[i])) return false;
    return true;
}

/* What is wrong with a serialised state, a copy of size_of(c) bytes; NULL when nothing is. */
static const char *fault_of_bytes(const Instance *c, const Snapshot *copy)
{
    const char *fault = fault_of(c, copy);

    if (fault) return fault;
    if (crc32_of((const char *)copy + HEAD_SIZE, c->core_size) != copy->crc)
        return "its checksum is wrong: damaged";
    return is_possible(c, &copy->core) ? NULL : "it holds impossible values";
}

Status snapshot_deserialise(Instance *c, const void *bytes, size_t size, void **state)
{
    if (!bytes) return instance_refuse(c, "serializedState is NULL");
    if (!state) return instance_refuse(c, "FMUstate is NULL");
    if (size != size_of(c))
        return instance_refuse(c, "the serialised state is refused: its length is not that of a "
                                  "state of this FMU");

    /* a copy: the bytes may lie at any address, and *state is to stay as it is on a fault */
    Snapshot *copy = malloc(size);
    if (!copy) return instance_refuse(c, "out of memory");
    memcpy(copy, bytes, size);

    const char *fault = fault_of_bytes(c, copy);
    Status result;
    Snapshot *s = NULL;

    if (fault)
        result = instance_refuse(c, "the serialised state is refused: %s", fault);
    else
        s = make_room(c, state, &result);
    if (s) {
        memcpy(s, copy, size);
        *state = s;
    }
    free(copy);
    return result;
}
