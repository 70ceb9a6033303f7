/* One instance of the model: its memory, its life, and the calls of the kernels. A call that is
   refused (STATUS_ERROR) changes nothing. */
#ifndef MBDFMI_INSTANCE_H
#define MBDFMI_INSTANCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "log.h"
#include "resource.h"

/* the states of FMI's state machine that are reached here */
typedef enum {
    INSTANTIATED = 1,
    INITIALIZATION = 2,
    STEP_COMPLETE = 4,
    STEP_FAILED = 8,
    TERMINATED = 16,
    EVENT = 32,
    CONTINUOUS_TIME = 64,
    INTERMEDIATE = 128 /* at a point within a step, which the master is let see */
} Mode;

#define EXCHANGE_MODES (EVENT | CONTINUOUS_TIME)
#define STEP_MODES     (STEP_COMPLETE | STEP_FAILED)

/* What a snapshot holds: this, and behind it in the same block of memory reals, state, u. */
typedef struct {
    double start_time, stop_time; /* s; stop_time is infinite when the master gave none */
    double time;                  /* s, the master's: its last point plus its last step */
    double step;                  /* s, the last step taken; 0 before the first */
    double event_time;            /* s, of model exchange: the next kink of what moves by time */
    int64_t mode;                 /* a Mode */
    int64_t prepared;             /* 1: the state knows the present parameters */
    int64_t started;              /* 1: the state follows from the present start values */
    int64_t told_tolerances;      /* a bit for each tolerance that was set as a parameter */
    int64_t rests;                /* 1: it starts at rest, as the resource has it */
} Core;

typedef struct Instance {
    Log log;
    const char *function; /* that the master has called, for the log */

    Resource resource;
    const int64_t *ints; /* the resource's */

    Core *core; /* the block of core_size bytes */
    size_t core_size;
    double *reals, *state, *u; /* parts of that block */
    double *piece;             /* too: of what is watched for kinks; see events.h */

    double *work, *y;
    bool current; /* y follows from the present reals, state and u */

    /* model exchange: x is what the solver outside gave; led is the nearest that keeps to the
       constraints, and all else is of that */
    bool exchanges;
    int64_t first_state, n_states, n_indicators; /* of the variables */
    double *given, *led, *rates, *indicators;
    bool is_led, is_rated, is_indicated; /* follow from the present reals, state and u */

    /* what is told beside the outputs, once it is asked for; see survey.h */
    double *surveyed;
    int64_t *survey_ints[N_SURVEY];
    double *survey_reals[N_SURVEY];
    bool is_surveyed[N_SURVEY]; /* likewise */

    bool has_events;  /* co-simulation with event mode */
    double *crossing; /* room for three sets of indicators; then */
    Core *part;       /* room for the block, at the start of a part of a step */

    /* points within a step, where the master wants to see them: it may ask to return at *until */
    bool (*at_point)(struct Instance *c, double time, bool may_return, double *until);
    void (*update)(void);
    bool may_return;

    uint64_t point;          /* counts changes of what follows from reals, state and u */
    struct Aside *aside;     /* room for evaluations aside, once there are any; see aside.h */
    double *course;          /* derivatives of outputs by time, once they are asked for ... */
    uint64_t course_point;   /* ... and of when */
    struct Columns *columns; /* derivatives, once they are asked for; see columns.h */
    struct Traced *traced;   /* what they are found by; see traced.h */

    Core *before; /* room for a copy of the block, once instance_keep is called */
} Instance;

/* NULL, with the reason in the log, when the resource or the GUID is not good. `log` is copied, its
   name apart. */
Instance *instance_create(const char *name, const char *guid, const char *location, const Log *log);

/* The instance for co-simulation with event mode; false, with the reason in the log, without memory. */
bool instance_use_events(Instance *c);

/* The instance for model exchange; false, with the reason in the log, when the model is not. */
bool instance_exchange(Instance *c);

/* Does nothing from within the master's logger. */
void instance_free(Instance *c);

/* Begins a call of a function that is allowed in some modes, or-ed; false when it is not, or the call comes from
   within the master's logger. */
bool instance_enter(Instance *c, const char *function, int modes);

/* Tells the log that the function is refused, and why. */
Status instance_refuse(Instance *c, const char *format, ...);

/* Switches categories of the log on or off, all when n is 0. */
Status instance_choose_log(Instance *c, bool on, size_t n, const char *const categories[]);

/* Times in s; `tolerance` and `stop_time` are NULL when the master gives none. */
Status instance_setup(Instance *c, const double *tolerance, double start_time,
                      const double *stop_time);

/* Ends the initialisation: the start stands, and what is to be known of it is told. */
Status instance_start(Instance *c);

/* Whether a step from the communication point t by H (s) can be begun. */
Status instance_check_step(Instance *c, double t, double H);

/* The step from t that a master means by H (s). One that forms H as the difference of two times is off by
   their rounding: it is the last step's H again, so that all ways to count time give the same bits. */
double instance_same_step(const Instance *c, double t, double H);

/* Advances from t by H, both checked. */
Status instance_advance(Instance *c, double t, double H);

/* Both. */
Status instance_step(Instance *c, double t, double H);

/* Room for a copy of the block, and the block as it is in it; NULL, and refused, without memory. */
Core *instance_keep(Instance *c);

/* Makes `block`, core_size bytes, that of the instance. */
void instance_restore(Instance *c, const void *block);

Status instance_terminate(Instance *c);

/* Back to the start: as after instance_create, the log's settings apart. */
Status instance_reset(Instance *c);

/* Begins a use of the state: parameters and start values are taken up. */
Status instance_prepare(Instance *c);

/* x = q | v | z, in the state */
double *instance_x(const Instance *c);

/* What follows from reals, state and u no longer does. */
void instance_changed(Instance *c);

/* Bring led, rates up to date. */
Status instance_lead(Instance *c);
Status instance_rates(Instance *c);

/* Between these two a kernel sees the state on the constraints, where a solver outside gave another. */
Status instance_begin(Instance *c);
void instance_end(Instance *c);

/* Tells what there is to tell of a state that a solver outside has come to. */
Status instance_complete(Instance *c);

/* Tells what a kernel of a state said; OK when it said nothing. */
Status instance_report(Instance *c, const char *doing, int32_t broken, int64_t status);

/* Brings y, and the state before it, up to date with parameters, start values and inputs. */
Status instance_outputs(Instance *c);

#endif
