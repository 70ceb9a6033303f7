/* One instance of the FMU: its memory, its life, its log, and the calls of the kernels. */
#ifndef MBDFMI_INSTANCE_H
#define MBDFMI_INSTANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "fmi2Functions.h"
#include "resource.h"

/* the states of the standard's state machine that are reached here */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    STEP_FAILED = 8,
    TERMINATED = 16
} Mode;

typedef enum {
    LOG_EVENTS,
    LOG_WARNING,
    LOG_DISCARD,
    LOG_ERROR,
    LOG_FATAL,
    LOG_ALL,
    N_CATEGORIES
} Category;

extern const char *const CATEGORY_NAMES[N_CATEGORIES];

/* What a snapshot holds: this, and behind it in the same block of memory reals, state, u. */
typedef struct {
    double start_time, stop_time; /* s; stop_time is infinite when the master gave none */
    double time;                  /* s, the master's: its last point plus its last step */
    double step;                  /* s, the last step taken; 0 before the first */
    int64_t mode;                 /* a Mode */
    int64_t prepared;             /* 1: the state knows the present parameters */
    int64_t started;              /* 1: the state follows from the present start values */
} Core;

typedef struct {
    char *name;
    fmi2CallbackFunctions callbacks;
    bool logged[N_CATEGORIES];

    Resource resource;

    const int64_t *ints; /* the resource's */
    Core *core;          /* the block of core_size bytes */
    size_t core_size;
    double *reals, *state, *u; /* parts of that block */

    double *work, *y;
    bool current; /* y follows from the present reals, state and u */
} Instance;

/* NULL, with the reason in the log, when the resource or the GUID is not good. */
Instance *instance_create(const char *name, const char *guid, const char *location,
                          const fmi2CallbackFunctions *callbacks, bool logging);

void instance_free(Instance *c);

/* back to the start: as after instance_create, the log settings apart */
void instance_reset(Instance *c);

/* Tells the master and returns `status`, so that a refusal is one line. Warnings and errors always
   reach the logger, the rest when its category is switched on. */
fmi2Status instance_log(Instance *c, fmi2Status status, const char *format, ...);

/* Brings the state up to date with the parameters and, before the simulation, the start values. */
fmi2Status instance_prepare(Instance *c);

/* Tells what is to be known of the model and its start, once the start stands. */
void instance_warn(Instance *c);

/* Brings y up to date too. */
fmi2Status instance_outputs(Instance *c);

/* Advances from the communication point t by H (s), both already checked. */
fmi2Status instance_step(Instance *c, double t, double H);

#endif
