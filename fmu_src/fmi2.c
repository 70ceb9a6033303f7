/* The functions of FMI 2.0 for co-simulation. A call that is refused (fmi2Error) changes nothing:
   the instance can be used on, though the standard does not promise it. */
#include <float.h>
#include <math.h>
#include <string.h>

#include "instance.h"
#include "kernels.h"
#include "snapshot.h"

#define ANY_MODE (INSTANTIATED | INITIALIZATION | STEP_COMPLETE | STEP_FAILED | TERMINATED)
#define READABLE (INITIALIZATION | STEP_COMPLETE | STEP_FAILED | TERMINATED)
#define WRITABLE (INSTANTIATED | INITIALIZATION | STEP_COMPLETE)
#define STEPPED  (STEP_COMPLETE | STEP_FAILED | TERMINATED)

static const char *mode_name(int64_t mode)
{
    switch (mode) {
        case INSTANTIATED:   return "instantiated";
        case INITIALIZATION: return "initialization mode";
        case STEP_COMPLETE:  return "step complete";
        case STEP_FAILED:    return "step failed";
        default:             return "terminated";
    }
}

static bool allowed(Instance *c, int modes, const char *function)
{
    if (!c) return false;
    if (c->core->mode & modes) return true;
    instance_log(c, fmi2Error, "%s is not allowed in the state '%s'", function,
                 mode_name(c->core->mode));
    return false;
}

/* Begins every function that works on an instance. */
#define ENTER(component, modes)                                                                    \
    Instance *c = component;                                                                       \
    if (!allowed(c, modes, __func__)) return fmi2Error

#define REFUSE(...) return instance_log(c, fmi2Error, __VA_ARGS__)

/* ---- library and log ---- */

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    ENTER(component, ANY_MODE);

    bool logged[N_CATEGORIES] = {false};

    if (nCategories > 0 && !categories) REFUSE("%s: categories is NULL", __func__);
    for (size_t i = 0; i < nCategories; i++) {
        const char *name = categories[i] ? categories[i] : "NULL";
        int k = 0;

        while (k < N_CATEGORIES && strcmp(name, CATEGORY_NAMES[k]) != 0) k++;
        if (k == N_CATEGORIES) REFUSE("%s: unknown category '%s'", __func__, name);
        logged[k] = loggingOn;
    }
    if (nCategories == 0) logged[LOG_ALL] = loggingOn;

    memcpy(c->logged, logged, sizeof logged);
    return fmi2OK;
}

/* ---- life ---- */

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn)
{
    (void)visible;
    Instance *c = instance_create(instanceName, fmuGUID, fmuResourceLocation, functions, loggingOn);

    if (c && fmuType != fmi2CoSimulation) {
        instance_log(c, fmi2Error, "this FMU is for co-simulation only");
        instance_free(c);
        return NULL;
    }
    return c;
}

void fmi2FreeInstance(fmi2Component component)
{
    if (component) instance_free(component);
}

fmi2Status fmi2SetupExperiment(fmi2Component component, fmi2Boolean toleranceDefined,
                               fmi2Real tolerance, fmi2Real startTime, fmi2Boolean stopTimeDefined,
                               fmi2Real stopTime)
{
    ENTER(component, INSTANTIATED);

    if (toleranceDefined && !(isfinite(tolerance) && tolerance > 0))
        REFUSE("%s: the tolerance is %g and must be positive", __func__, tolerance);
    if (!isfinite(startTime)) REFUSE("%s: the start time is %g", __func__, startTime);
    if (stopTimeDefined && !(stopTime >= startTime))
        REFUSE("%s: the stop time %.9g s is before the start time %.9g s", __func__, stopTime,
               startTime);

    c->core->start_time = c->core->time = startTime;
    c->core->stop_time = stopTimeDefined ? stopTime : INFINITY;
    c->core->started = 0;
    c->current = false;

    /* the same digits from every master */
    if (toleranceDefined)
        return instance_log(c, fmi2OK, "the tolerance %g is not used: the scene's own holds",
                            tolerance);
    return fmi2OK;
}

fmi2Status fmi2EnterInitializationMode(fmi2Component component)
{
    ENTER(component, INSTANTIATED);
    c->core->mode = INITIALIZATION;
    return fmi2OK;
}

fmi2Status fmi2ExitInitializationMode(fmi2Component component)
{
    ENTER(component, INITIALIZATION);

    fmi2Status result = instance_prepare(c);
    if (result != fmi2OK) return result;

    c->core->mode = STEP_COMPLETE;
    instance_warn(c);
    return instance_log(c, fmi2OK, "initialised at t = %.9g s", c->core->start_time);
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    ENTER(component, STEP_COMPLETE | STEP_FAILED);
    c->core->mode = TERMINATED;
    return instance_log(c, fmi2OK, "terminated at t = %.9g s", c->core->time);
}

fmi2Status fmi2Reset(fmi2Component component)
{
    ENTER(component, ANY_MODE);
    instance_reset(c);
    return instance_log(c, fmi2OK, "reset");
}

/* ---- variables ---- */

/* Value references count inputs, outputs, parameters, in this order. */
static bool is_input(const Instance *c, fmi2ValueReference vr)
{
    return vr < c->resource.n_u;
}

static bool is_output(const Instance *c, fmi2ValueReference vr)
{
    return !is_input(c, vr) && vr < c->resource.n_u + c->resource.n_y;
}

static bool is_known(const Instance *c, fmi2ValueReference vr)
{
    return vr < c->resource.n_u + c->resource.n_y + c->resource.n_param;
}

static int64_t parameter_of(const Instance *c, fmi2ValueReference vr)
{
    return vr - c->resource.n_u - c->resource.n_y;
}

/* Arrays of n elements must be there unless n is 0. */
static fmi2Status check_arrays(Instance *c, const char *function, size_t n, const void *vr,
                               const void *value)
{
    if (n > 0 && !(vr && value)) REFUSE("%s: NULL instead of an array", function);
    return fmi2OK;
}

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                       fmi2Real value[])
{
    ENTER(component, READABLE);

    const Resource *r = &c->resource;
    fmi2Status result = check_arrays(c, __func__, nvr, vr, value);

    for (size_t i = 0; i < nvr && result == fmi2OK; i++) {
        if (!is_known(c, vr[i])) REFUSE("%s: unknown value reference %u", __func__, vr[i]);

        if (is_input(c, vr[i]))
            value[i] = c->u[vr[i]];
        else if (is_output(c, vr[i])) {
            result = instance_outputs(c);
            if (result == fmi2OK) value[i] = c->y[vr[i] - r->n_u];
        } else
            value[i] = c->reals[r->param_index[parameter_of(c, vr[i])]];

        if (result == fmi2OK && !isfinite(value[i]))
            REFUSE("%s: '%s' (value reference %u) is %g", __func__, r->names[vr[i]], vr[i],
                   value[i]);
    }
    return result;
}

/* Refuses what may not be set, before anything is. */
static fmi2Status check_set(Instance *c, const char *function, fmi2ValueReference vr, double value)
{
    const Resource *r = &c->resource;
    bool running = c->core->mode == STEP_COMPLETE;

    if (!is_known(c, vr)) REFUSE("%s: unknown value reference %u", function, vr);
    if (is_output(c, vr))
        REFUSE("%s: '%s' (value reference %u) is an output and cannot be set", function,
               r->names[vr], vr);
    if (running && !is_input(c, vr) && !r->param_tunable[parameter_of(c, vr)])
        REFUSE("%s: the parameter '%s' (value reference %u) is fixed after the initialization",
               function, r->names[vr], vr);
    if (!isfinite(value))
        REFUSE("%s: %g is no value for '%s' (value reference %u)", function, value, r->names[vr],
               vr);
    return fmi2OK;
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[])
{
    ENTER(component, WRITABLE);

    fmi2Status result = check_arrays(c, __func__, nvr, vr, value);

    for (size_t i = 0; i < nvr && result == fmi2OK; i++)
        result = check_set(c, __func__, vr[i], value[i]);
    if (result != fmi2OK) return result;

    for (size_t i = 0; i < nvr; i++) {
        bool input = is_input(c, vr[i]);
        double *place =
            input ? &c->u[vr[i]] : &c->reals[c->resource.param_index[parameter_of(c, vr[i])]];

        /* a value that stands already changes nothing, not even what the solver remembers */
        if (memcmp(place, &value[i], sizeof *place) == 0) continue;

        *place = value[i];
        c->current = false;
        if (c->core->mode != STEP_COMPLETE) c->core->started = 0;
        if (!input) c->core->prepared = 0;
    }
    return fmi2OK;
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference vr[],
                                       size_t nvr, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    ENTER(component, WRITABLE);

    const Resource *r = &c->resource;

    if (nvr > 0 && !(vr && order && value)) REFUSE("%s: NULL instead of an array", __func__);
    for (size_t i = 0; i < nvr; i++) {
        if (!is_known(c, vr[i])) REFUSE("%s: unknown value reference %u", __func__, vr[i]);

        const char *name = r->names[vr[i]];
        if (!is_input(c, vr[i]))
            REFUSE("%s: '%s' (value reference %u) is not an input", __func__, name, vr[i]);
        if (order[i] < 1 || order[i] >= N_DERIVATIVE)
            REFUSE("%s: order %d of '%s': orders 1 to %d are known", __func__, order[i], name,
                   N_DERIVATIVE - 1);
        if (!isfinite(value[i]))
            REFUSE("%s: %g is no derivative of '%s' (value reference %u)", __func__, value[i], name,
                   vr[i]);
    }
    for (size_t i = 0; i < nvr; i++) c->u[order[i] * r->n_u + vr[i]] = value[i];

    // the speed of a commanded motion may be a derivative of its position
    c->current = false;
    return fmi2OK;
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference vr[],
                                        size_t nvr, const fmi2Integer order[], fmi2Real value[])
{
    ENTER(component, STEPPED);
    (void)vr;
    (void)order;
    (void)value;
    if (nvr > 0) REFUSE("%s: this FMU gives none (maxOutputDerivativeOrder = 0)", __func__);
    return fmi2OK;
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component,
                                        const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    ENTER(component, READABLE);
    (void)vUnknown_ref;
    (void)nUnknown;
    (void)vKnown_ref;
    (void)nKnown;
    (void)dvKnown;
    (void)dvUnknown;
    REFUSE("%s: this FMU gives none (providesDirectionalDerivative = false)", __func__);
}

/* All variables are Real: any reference to another type is refused. */
static fmi2Status no_variable(Instance *c, const char *function, const fmi2ValueReference vr[],
                              size_t nvr, const char *type)
{
    if (nvr == 0) return fmi2OK;
    if (!vr) REFUSE("%s: NULL instead of an array", function);
    REFUSE("%s: value reference %u is no %s: all variables of this FMU are Real", function, vr[0],
           type);
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Integer value[])
{
    ENTER(component, READABLE);
    (void)value;
    return no_variable(c, __func__, vr, nvr, "Integer");
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Boolean value[])
{
    ENTER(component, READABLE);
    (void)value;
    return no_variable(c, __func__, vr, nvr, "Boolean");
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[])
{
    ENTER(component, READABLE);
    (void)value;
    return no_variable(c, __func__, vr, nvr, "String");
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[])
{
    ENTER(component, WRITABLE);
    (void)value;
    return no_variable(c, __func__, vr, nvr, "Integer");
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[])
{
    ENTER(component, WRITABLE);
    (void)value;
    return no_variable(c, __func__, vr, nvr, "Boolean");
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[])
{
    ENTER(component, WRITABLE);
    (void)value;
    return no_variable(c, __func__, vr, nvr, "String");
}

/* ---- snapshots ---- */

/* OK when FMUstate is a snapshot of this FMU. */
static fmi2Status check_snapshot(Instance *c, const char *function, fmi2FMUstate FMUstate)
{
    const char *fault = FMUstate ? snapshot_fault(c, FMUstate) : "it is NULL";

    if (fault) REFUSE("%s: the FMU state is refused: %s", function, fault);
    return fmi2OK;
}

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *FMUstate)
{
    ENTER(component, ANY_MODE);
    if (!FMUstate) REFUSE("%s: FMUstate is NULL", __func__);
    if (*FMUstate && check_snapshot(c, __func__, *FMUstate) != fmi2OK) return fmi2Error;

    Snapshot *s = snapshot_take(c, *FMUstate);
    if (!s) REFUSE("%s: out of memory", __func__);

    *FMUstate = s;
    return fmi2OK;
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate FMUstate)
{
    ENTER(component, ANY_MODE);
    if (check_snapshot(c, __func__, FMUstate) != fmi2OK) return fmi2Error;
    snapshot_restore(c, FMUstate);
    return fmi2OK;
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *FMUstate)
{
    ENTER(component, ANY_MODE);
    if (!FMUstate || !*FMUstate) return fmi2OK;
    if (check_snapshot(c, __func__, *FMUstate) != fmi2OK) return fmi2Error;
    snapshot_free(*FMUstate);
    *FMUstate = NULL;
    return fmi2OK;
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate FMUstate, size_t *size)
{
    ENTER(component, ANY_MODE);
    if (check_snapshot(c, __func__, FMUstate) != fmi2OK) return fmi2Error;
    if (!size) REFUSE("%s: size is NULL", __func__);
    *size = snapshot_size(c);
    return fmi2OK;
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate FMUstate,
                                 fmi2Byte serializedState[], size_t size)
{
    ENTER(component, ANY_MODE);
    if (check_snapshot(c, __func__, FMUstate) != fmi2OK) return fmi2Error;
    if (!serializedState) REFUSE("%s: serializedState is NULL", __func__);
    if (size < snapshot_size(c))
        REFUSE("%s: %zu bytes are given, %zu are needed", __func__, size, snapshot_size(c));
    snapshot_write(c, FMUstate, serializedState);
    return fmi2OK;
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte serializedState[],
                                   size_t size, fmi2FMUstate *FMUstate)
{
    ENTER(component, ANY_MODE);
    if (!serializedState) REFUSE("%s: serializedState is NULL", __func__);
    if (!FMUstate) REFUSE("%s: FMUstate is NULL", __func__);
    if (*FMUstate && check_snapshot(c, __func__, *FMUstate) != fmi2OK) return fmi2Error;

    const char *fault;
    Snapshot *s = snapshot_read(c, *FMUstate, serializedState, size, &fault);
    if (!s) REFUSE("%s: the serialised state is refused: %s", __func__, fault);

    *FMUstate = s;
    return fmi2OK;
}

/* ---- steps ---- */

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    ENTER(component, STEP_COMPLETE);
    (void)noSetFMUStatePriorToCurrentPoint;

    double t = currentCommunicationPoint, H = communicationStepSize;
    double time = c->core->time, stop = c->core->stop_time;

    if (!(isfinite(H) && H > 0))
        REFUSE("%s: the step size is %g s and must be positive", __func__, H);

    /* a master's own way to count time shows as rounding */
    double slack = 1e-6 * H + 16 * DBL_EPSILON * fabs(time);
    if (!(fabs(t - time) <= slack))
        REFUSE("%s: the communication point is t = %.17g s, this FMU is at t = %.17g s", __func__,
               t, time);
    if (!isfinite(t + H)) REFUSE("%s: the step from t = %g s by %g s has no end", __func__, t, H);
    if (t + H > stop + slack)
        REFUSE("%s: the step ends at t = %.9g s, after the stop time %.9g s", __func__, t + H,
               stop);

    return instance_step(c, t, H);
}

/* No step is ever pending. */
fmi2Status fmi2CancelStep(fmi2Component component)
{
    ENTER(component, 0);
    return fmi2OK;
}

/* ---- status ---- */

static fmi2Status no_status(Instance *c, const char *function, fmi2StatusKind s)
{
    return instance_log(c, fmi2Discard, "%s: no status of kind %d: no step is ever pending",
                        function, (int)s);
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind s, fmi2Status *value)
{
    ENTER(component, STEPPED);
    (void)value;
    return no_status(c, __func__, s);
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind s, fmi2Real *value)
{
    ENTER(component, STEPPED);
    if (!value) REFUSE("%s: value is NULL", __func__);
    if (s != fmi2LastSuccessfulTime) return no_status(c, __func__, s);
    *value = c->core->time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind s, fmi2Integer *value)
{
    ENTER(component, STEPPED);
    (void)value;
    return no_status(c, __func__, s);
}

/* A failed step cannot be continued from where it stopped: the FMU asks for the end. */
fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind s, fmi2Boolean *value)
{
    ENTER(component, STEPPED);
    if (!value) REFUSE("%s: value is NULL", __func__);
    if (s != fmi2Terminated) return no_status(c, __func__, s);
    *value = c->core->mode == STEP_FAILED ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind s, fmi2String *value)
{
    ENTER(component, STEPPED);
    (void)value;
    return no_status(c, __func__, s);
}
