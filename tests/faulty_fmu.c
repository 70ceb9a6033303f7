/* An FMU of FMI 2.0, x' = u and y = x + 2u, for co-simulation and model exchange, that does all well; with FAULTY it does all
   that a probe asks for wrong. An event at each half second, and where x goes through 0.01, changes nothing. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "fmi2Functions.h"

#ifdef FAULTY
enum { FAULTY_ = 1 };
#else
enum { FAULTY_ = 0 };
#endif

enum { U, Y, K, X, DX, N };

typedef struct {
    double v[N], x, t, du;
    int runs, exchanges, calls;
} State;

static int instances; /* of the process: what ought to be of each */

static State *of(fmi2Component c)
{
    return c;
}

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

static void start(State *s)
{
    memset(s, 0, sizeof *s);
    s->v[K] = FAULTY_ ? 4.0 : 3.0;
    s->x = FAULTY_ ? 0.5 : 0.0;
}

fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String location,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean logging)
{
    State *s = malloc(sizeof *s);

    (void)name, (void)guid, (void)location, (void)functions, (void)visible, (void)logging;
    start(s);
    s->exchanges = type == fmi2ModelExchange;
    s->runs = instances++;
    return s;
}

void fmi2FreeInstance(fmi2Component c)
{
    free(c);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean given, fmi2Real tolerance, fmi2Real t,
                               fmi2Boolean stops, fmi2Real stop)
{
    (void)given, (void)tolerance, (void)stops, (void)stop;
    of(c)->t = t;
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Terminate(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2Reset(fmi2Component c)
{
    int exchanges = of(c)->exchanges;

    if (!FAULTY_) start(c);
    of(c)->exchanges = exchanges;
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    State *s = of(c);

    for (size_t i = 0; i < n; i++) {
        if (!FAULTY_ && vr[i] >= N) return fmi2Error;
        s->v[Y] = s->x + 2 * s->v[U] + (FAULTY_ ? 1e-3 * s->runs : 0);
        s->v[X] = s->x;
        s->v[DX] = s->v[U];
        value[i] = s->v[vr[i]];
    }
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                       const fmi2Real value[])
{
    for (size_t i = 0; i < n; i++) {
        if (!FAULTY_ && (vr[i] >= N || !isfinite(value[i]))) return fmi2Error;
        if (!FAULTY_ || vr[i] != K) of(c)->v[vr[i]] = value[i];
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    (void)vr, (void)order;
    if (n > 0 && !FAULTY_) of(c)->du = value[0];
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                        const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order;
    for (size_t i = 0; i < n; i++) value[i] = FAULTY_ ? NAN : of(c)->v[U];
    return fmi2OK;
}

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real H, fmi2Boolean no)
{
    State *s = of(c);

    (void)no;
    if (FAULTY_)
        while (isnan(H)) sleep(1);
    else if (!(H > 0) || fabs(t - s->t) > 1e-6 * H)
        return fmi2Error;

    /* the faulty one takes its steps on a grid of its own */
    if (FAULTY_)
        for (; s->t < t + H - 1e-17; s->t += 1e-4) s->x += 1e-4 * s->v[U];
    else
        s->x += H * (s->v[U] + H / 2 * s->du);
    s->v[U] += H * s->du;
    s->du = 0;
    if (!FAULTY_) s->t = t + H;
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    if (!*state) *state = malloc(sizeof(State));
    memcpy(*state, c, sizeof(State));
    if (FAULTY_) ((State *)*state)->x += 1e-6;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state)
{
    memcpy(c, state, sizeof(State));
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state)
{
    (void)c;
    free(*state);
    *state = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size)
{
    (void)c, (void)state;
    *size = sizeof(State);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size)
{
    (void)c;
    memcpy(bytes, state, size);
    if (FAULTY_)
        memcpy(bytes, &state, sizeof state); /* its address: what another process has not */
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size,
                                   fmi2FMUstate *state)
{
    void *from;

    (void)c;
    memcpy(&from, bytes, sizeof from);
    *state = malloc(size);
    memcpy(*state, FAULTY_ ? from : bytes, size);
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                        size_t n, const fmi2ValueReference known[], size_t m,
                                        const fmi2Real seed[], fmi2Real sensitivity[])
{
    (void)c;
    for (size_t i = 0; i < n; i++) {
        sensitivity[i] = 0;
        for (size_t j = 0; j < m; j++) {
            double one = unknown[i] == Y ? (known[j] == U ? 2.0 : 1.0) : known[j] == U ? 1.0 : 0.0;
            sensitivity[i] += (FAULTY_ ? 0.5 : 1.0) * one * seed[j];
        }
    }
    return fmi2OK;
}

/* model exchange */

fmi2Status fmi2EnterEventMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *info)
{
    State *s = of(c);

    memset(info, 0, sizeof *info);
    info->nextEventTimeDefined = fmi2True;
    info->nextEventTime = FAULTY_ ? s->t - 1 : 0.5 * floor(s->t / 0.5 + 1.0);
    if (FAULTY_) s->x += 1e-9;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c)
{
    (void)c;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean no, fmi2Boolean *event,
                                       fmi2Boolean *end)
{
    (void)no;
    *event = *end = fmi2False;
    if (FAULTY_) of(c)->x += 1e-9;
    return fmi2OK;
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real t)
{
    of(c)->t = t;
    return fmi2OK;
}

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t n)
{
    if (!FAULTY_ && (n != 1 || !isfinite(x[0]))) return fmi2Error;
    of(c)->x = FAULTY_ ? (float)x[0] : x[0];
    return fmi2OK;
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    if (n != 1) return fmi2Error;
    x[0] = of(c)->x;
    return fmi2OK;
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real rates[], size_t n)
{
    if (n != 1) return fmi2Error;
    rates[0] = of(c)->v[U] + (FAULTY_ ? 1e-9 * of(c)->calls++ + 0 * of(c)->x : 0);
    return fmi2OK;
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real z[], size_t n)
{
    if (n != 1) return fmi2Error;
    z[0] = FAULTY_ ? (of(c)->calls++ % 2 ? 1.0 : -1.0) : of(c)->x - 0.01;
    return fmi2OK;
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x[], size_t n)
{
    (void)c;
    if (n != 1) return fmi2Error;
    x[0] = FAULTY_ ? 0.0 : 1.0;
    return fmi2OK;
}

/* what there must be, and nothing asks for */

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String names[])
{
    (void)c, (void)on, (void)n, (void)names;
    return fmi2OK;
}

fmi2Status fmi2CancelStep(fmi2Component c)
{
    (void)c;
    return fmi2Error;
}

#define NONE(Type)                                                                                 \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n,             \
                             fmi2##Type value[])                                                   \
    {                                                                                              \
        (void)c, (void)vr, (void)n, (void)value;                                                   \
        return fmi2Error;                                                                          \
    }                                                                                              \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t n,             \
                             const fmi2##Type value[])                                             \
    {                                                                                              \
        (void)c, (void)vr, (void)n, (void)value;                                                   \
        return fmi2Error;                                                                          \
    }

NONE(Integer)
NONE(Boolean)
NONE(String)

#define NO_STATUS(Name, Type)                                                                      \
    fmi2Status fmi2Get##Name(fmi2Component c, const fmi2StatusKind kind, Type *value)              \
    {                                                                                              \
        (void)c, (void)kind, (void)value;                                                          \
        return fmi2Discard;                                                                        \
    }

NO_STATUS(Status, fmi2Status)
NO_STATUS(RealStatus, fmi2Real)
NO_STATUS(IntegerStatus, fmi2Integer)
NO_STATUS(BooleanStatus, fmi2Boolean)
NO_STATUS(StringStatus, fmi2String)
