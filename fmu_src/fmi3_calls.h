/* What the functions of FMI 3.0 have in common: modes, statuses, and how each begins. */
#ifndef MBDFMI_FMI3_CALLS_H
#define MBDFMI_FMI3_CALLS_H

#include "fmi3Functions.h"
#include "instance.h"

#define ANY_MODE    (INSTANTIATED | INITIALIZATION | INITIALIZED | TERMINATED)
#define WRITABLE    (INSTANTIATED | INITIALIZATION | STEP_COMPLETE | EXCHANGE_MODES)
#define INITIALIZED (STEP_MODES | EXCHANGE_MODES)
#define STEPPED     (STEP_MODES | TERMINATED)
#define INTEGRATED  (INITIALIZATION | EXCHANGE_MODES | TERMINATED)

static inline fmi3Status status_of(Status status)
{
    switch (status) {
        case STATUS_OK:      return fmi3OK;
        case STATUS_WARNING: return fmi3Warning;
        case STATUS_DISCARD: return fmi3Discard;
        case STATUS_ERROR:   return fmi3Error;
        default:             return fmi3Fatal;
    }
}

/* Begins every function that works on an instance. */
#define ENTER(modes)                                                                               \
    Instance *c = instance;                                                                        \
    if (!instance_enter(c, __func__, modes)) return fmi3Error

#define REFUSE(...) return status_of(instance_refuse(c, __VA_ARGS__))

/* No variable is of another type but those of fmi3.c: any reference is refused. */
static inline fmi3Status no_variable(Instance *c, const fmi3ValueReference vr[], size_t n,
                                     const char *type)
{
    if (n == 0) return fmi3OK;
    if (!vr) REFUSE("NULL instead of an array");
    REFUSE("value reference %u is no %s: this FMU has none", vr[0], type);
}

#endif
