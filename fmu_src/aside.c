#include "aside.h"

#include <stdlib.h>
#include <string.h>

typedef struct Aside {
    Core *block;     /* the instance's */
    double *derived; /* y, led, rates, indicators */
    bool current, is_led, is_rated, is_indicated;
    uint64_t point;
} Aside;

static double *exchange(double *kept, double *array, size_t n, bool keep)
{
    memcpy(keep ? kept : array, keep ? array : kept, n * sizeof(double));
    return kept + n;
}

static size_t n_indicators(const Instance *c)
{
    return 2 * (size_t)(c->ints[COUNT_n_stop] + c->resource.survey[SURVEY_WATCHED].n_y);
}

static void exchange_all(Instance *c, double *kept, bool keep)
{
    size_t n_x = (size_t)c->ints[COUNT_n_x];

    kept = exchange(kept, c->y, (size_t)c->resource.n.y, keep);
    kept = exchange(kept, c->led, n_x, keep);
    kept = exchange(kept, c->rates, n_x, keep);
    exchange(kept, c->indicators, n_indicators(c), keep);
}

static size_t length_of_derived(const Instance *c)
{
    return (size_t)(c->resource.n.y + 2 * c->ints[COUNT_n_x]) + n_indicators(c);
}

void aside_free(Instance *c)
{
    if (!c->aside) return;
    free(c->aside->block);
    free(c->aside->derived);
    free(c->aside);
    c->aside = NULL;
}

static bool allocate(Instance *c)
{
    if (c->aside) return true;
    c->aside = calloc(1, sizeof *c->aside);
    if (!c->aside) return false;

    c->aside->block = malloc(c->core_size);
    c->aside->derived = malloc((length_of_derived(c) + 1) * sizeof(double));
    if (c->aside->block && c->aside->derived) return true;
    aside_free(c);
    return false;
}

Status aside_begin(Instance *c)
{
    if (!allocate(c)) return instance_refuse(c, "out of memory");

    Status result = instance_prepare(c);
    if (result != STATUS_OK) return result;

    Aside *a = c->aside;
    memcpy(a->block, c->core, c->core_size);
    exchange_all(c, a->derived, true);
    a->current = c->current;
    a->is_led = c->is_led;
    a->is_rated = c->is_rated;
    a->is_indicated = c->is_indicated;
    a->point = c->point;
    return STATUS_OK;
}

void aside_return(Instance *c)
{
    instance_restore(c, c->aside->block);
}

void aside_end(Instance *c)
{
    Aside *a = c->aside;

    aside_return(c);
    exchange_all(c, a->derived, false);
    c->current = a->current;
    c->is_led = a->is_led;
    c->is_rated = a->is_rated;
    c->is_indicated = a->is_indicated;
    c->point = a->point;
}
