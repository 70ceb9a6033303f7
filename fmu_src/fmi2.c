/* The functions of FMI 2.0: types, statuses and the log of the standard, over an
   instance that knows nothing of it. A call that is refused (fmi2Error) changes nothing: the instance
   can be used on, though the standard does not promise it. */
#include <string.h>

#include "course.h"
#include "derivatives.h"
#include "exchange.h"
#include "fmi2Functions.h"
#include "instance.h"
#include "rest.h"
#include "snapshot.h"
#include "variables.h"

#define ANY_MODE   (INSTANTIATED | INITIALIZATION | STEP_MODES | EXCHANGE_MODES | TERMINATED)
#define READABLE   (INITIALIZATION | STEP_MODES | EXCHANGE_MODES | TERMINATED)
#define WRITABLE   (INSTANTIATED | INITIALIZATION | STEP_COMPLETE | EXCHANGE_MODES)
#define STEPPED    (STEP_MODES | TERMINATED)
#define INTEGRATED (INITIALIZATION | EXCHANGE_MODES | TERMINATED)

static fmi2Status status_of(Status status)
{
    switch (status) {
        case STATUS_OK:      return fmi2OK;
        case STATUS_WARNING: return fmi2Warning;
        case STATUS_DISCARD: return fmi2Discard;
        case STATUS_ERROR:   return fmi2Error;
        default:             return fmi2Fatal;
    }
}

/* Begins every function that works on an instance. */
#define ENTER(component, modes)                                                                    \
    Instance *c = component;                                                                       \
    if (!instance_enter(c, __func__, modes)) return fmi2Error

#define REFUSE(...) return status_of(instance_refuse(c, __VA_ARGS__))

/* ---- library and log ---- */

const char *fmi2GetTypesPlatform(void)
{
    return fmi2TypesPlatform;
}

const char *fmi2GetVersion(void)
{
    return fmi2Version;
}

/* The logger takes a format (%) in which #r12# stands for a variable: both signs are doubled. */
static void tell_master(const Log *log, Status status, const char *category, const char *text)
{
    char message[2 * LONGEST_MESSAGE], *to = message;

    for (; *text; text++) {
        if (*text == '%' || *text == '#') *to++ = *text;
        *to++ = *text;
    }
    *to = '\0';
    ((fmi2CallbackLogger)log->logger)(log->environment, log->name ? log->name : "",
                                      status_of(status), category, message);
}

fmi2Status fmi2SetDebugLogging(fmi2Component component, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    ENTER(component, ANY_MODE);
    return status_of(instance_choose_log(c, loggingOn, nCategories, categories));
}

/* ---- life ---- */

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation,
                              const fmi2CallbackFunctions *functions, fmi2Boolean visible,
                              fmi2Boolean loggingOn)
{
    Log log = {0};

    (void)visible;
    if (functions && functions->logger) {
        log.send = tell_master;
        log.logger = (void (*)(void))functions->logger;
        log.environment = functions->componentEnvironment;
    }
    log.logged[LOG_ALL] = loggingOn;

    Instance *c = instance_create(instanceName, fmuGUID, fmuResourceLocation, &log);

    if (c && fmuType != fmi2CoSimulation && !instance_exchange(c)) {
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
    return status_of(instance_setup(c, toleranceDefined ? &tolerance : NULL, startTime,
                                    stopTimeDefined ? &stopTime : NULL));
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
    return status_of(instance_start(c));
}

fmi2Status fmi2Terminate(fmi2Component component)
{
    ENTER(component, STEP_MODES | EXCHANGE_MODES);
    return status_of(instance_terminate(c));
}

fmi2Status fmi2Reset(fmi2Component component)
{
    ENTER(component, ANY_MODE);
    return status_of(instance_reset(c));
}

/* ---- variables ---- */

fmi2Status fmi2GetReal(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                       fmi2Real value[])
{
    ENTER(component, READABLE);
    return status_of(variables_get(c, vr, nvr, value));
}

fmi2Status fmi2SetReal(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                       const fmi2Real value[])
{
    ENTER(component, WRITABLE);
    return status_of(variables_set(c, vr, nvr, value));
}

fmi2Status fmi2SetRealInputDerivatives(fmi2Component component, const fmi2ValueReference vr[],
                                       size_t nvr, const fmi2Integer order[],
                                       const fmi2Real value[])
{
    ENTER(component, INSTANTIATED | INITIALIZATION | STEP_COMPLETE);
    if (c->exchanges) REFUSE("derivatives of inputs are for co-simulation");
    return status_of(variables_set_derivatives(c, vr, nvr, order, value));
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component component, const fmi2ValueReference vr[],
                                        size_t nvr, const fmi2Integer order[], fmi2Real value[])
{
    ENTER(component, STEPPED);
    return status_of(course_derivatives(c, vr, nvr, order, value));
}

fmi2Status fmi2GetDirectionalDerivative(fmi2Component component,
                                        const fmi2ValueReference vUnknown_ref[], size_t nUnknown,
                                        const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    ENTER(component, READABLE);
    return status_of(
        derivatives_along(c, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown));
}

/* No variable is of another type: any reference is refused. */
static fmi2Status no_variable(Instance *c, const fmi2ValueReference vr[], size_t nvr,
                              const char *type)
{
    if (nvr == 0) return fmi2OK;
    if (!vr) REFUSE("NULL instead of an array");
    REFUSE("value reference %u is no %s: this FMU has none", vr[0], type);
}

fmi2Status fmi2GetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Integer value[])
{
    ENTER(component, READABLE);
    (void)value;
    return no_variable(c, vr, nvr, "Integer");
}

fmi2Status fmi2GetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          fmi2Boolean value[])
{
    ENTER(component, READABLE);
    Status result = rest_check_references(c, vr, nvr, value, "Boolean");

    for (size_t i = 0; i < nvr && result == STATUS_OK; i++) value[i] = c->core->rests != 0;
    return status_of(result);
}

fmi2Status fmi2GetString(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                         fmi2String value[])
{
    ENTER(component, READABLE);
    (void)value;
    return no_variable(c, vr, nvr, "String");
}

fmi2Status fmi2SetInteger(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Integer value[])
{
    ENTER(component, WRITABLE);
    (void)value;
    return no_variable(c, vr, nvr, "Integer");
}

fmi2Status fmi2SetBoolean(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                          const fmi2Boolean value[])
{
    ENTER(component, WRITABLE);
    Status result = rest_check_references(c, vr, nvr, value, "Boolean");

    for (size_t i = 0; i < nvr && result == STATUS_OK; i++)
        result = rest_set(c, value[i] != fmi2False);
    return status_of(result);
}

fmi2Status fmi2SetString(fmi2Component component, const fmi2ValueReference vr[], size_t nvr,
                         const fmi2String value[])
{
    ENTER(component, WRITABLE);
    (void)value;
    return no_variable(c, vr, nvr, "String");
}

/* ---- snapshots ---- */

fmi2Status fmi2GetFMUstate(fmi2Component component, fmi2FMUstate *FMUstate)
{
    ENTER(component, ANY_MODE);
    return status_of(snapshot_get(c, FMUstate));
}

fmi2Status fmi2SetFMUstate(fmi2Component component, fmi2FMUstate FMUstate)
{
    ENTER(component, ANY_MODE);
    return status_of(snapshot_set(c, FMUstate));
}

fmi2Status fmi2FreeFMUstate(fmi2Component component, fmi2FMUstate *FMUstate)
{
    ENTER(component, ANY_MODE);
    return status_of(snapshot_free(c, FMUstate));
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component component, fmi2FMUstate FMUstate, size_t *size)
{
    ENTER(component, ANY_MODE);
    return status_of(snapshot_size(c, FMUstate, size));
}

fmi2Status fmi2SerializeFMUstate(fmi2Component component, fmi2FMUstate FMUstate,
                                 fmi2Byte serializedState[], size_t size)
{
    ENTER(component, ANY_MODE);
    return status_of(snapshot_serialise(c, FMUstate, serializedState, size));
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component component, const fmi2Byte serializedState[],
                                   size_t size, fmi2FMUstate *FMUstate)
{
    ENTER(component, ANY_MODE);
    return status_of(snapshot_deserialise(c, serializedState, size, FMUstate));
}

/* ---- model exchange ---- */

fmi2Status fmi2EnterEventMode(fmi2Component component)
{
    ENTER(component, CONTINUOUS_TIME);
    c->core->mode = EVENT;
    return fmi2OK;
}

fmi2Status fmi2NewDiscreteStates(fmi2Component component, fmi2EventInfo *info)
{
    ENTER(component, EVENT);
    if (!info) REFUSE("NULL instead of a place for the result");

    Event event = {0};
    Status result = exchange_update(c, &event);

    memset(info, 0, sizeof *info);
    info->valuesOfContinuousStatesChanged = event.states_changed;
    info->nextEventTimeDefined = event.next_time_defined;
    info->nextEventTime = event.next_time_defined ? event.next_time : 0;
    return status_of(result);
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component component)
{
    ENTER(component, EVENT);
    c->core->mode = CONTINUOUS_TIME;
    return fmi2OK;
}

fmi2Status fmi2CompletedIntegratorStep(fmi2Component component,
                                       fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode,
                                       fmi2Boolean *terminateSimulation)
{
    ENTER(component, CONTINUOUS_TIME);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!(enterEventMode && terminateSimulation)) REFUSE("NULL instead of a place for the result");

    bool wanted;
    Status result = exchange_complete_step(c, &wanted);

    *enterEventMode = wanted;
    *terminateSimulation = fmi2False;
    return status_of(result);
}

fmi2Status fmi2SetTime(fmi2Component component, fmi2Real time)
{
    ENTER(component, EXCHANGE_MODES);
    return status_of(exchange_set_time(c, time));
}

fmi2Status fmi2SetContinuousStates(fmi2Component component, const fmi2Real x[], size_t nx)
{
    ENTER(component, CONTINUOUS_TIME);
    return status_of(exchange_set_states(c, x, nx));
}

fmi2Status fmi2GetDerivatives(fmi2Component component, fmi2Real derivatives[], size_t nx)
{
    ENTER(component, INTEGRATED);
    return status_of(exchange_get_rates(c, derivatives, nx));
}

fmi2Status fmi2GetEventIndicators(fmi2Component component, fmi2Real eventIndicators[], size_t ni)
{
    ENTER(component, INTEGRATED);
    return status_of(exchange_get_indicators(c, eventIndicators, ni));
}

fmi2Status fmi2GetContinuousStates(fmi2Component component, fmi2Real x[], size_t nx)
{
    ENTER(component, INTEGRATED);
    return status_of(exchange_get_states(c, x, nx));
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component component, fmi2Real x_nominal[],
                                             size_t nx)
{
    ENTER(component, ANY_MODE);
    return status_of(exchange_get_nominals(c, x_nominal, nx));
}

/* ---- steps ---- */

fmi2Status fmi2DoStep(fmi2Component component, fmi2Real currentCommunicationPoint,
                      fmi2Real communicationStepSize, fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    ENTER(component, STEP_COMPLETE);
    (void)noSetFMUStatePriorToCurrentPoint;
    return status_of(instance_step(c, currentCommunicationPoint, communicationStepSize));
}

/* No step is ever pending. */
fmi2Status fmi2CancelStep(fmi2Component component)
{
    ENTER(component, 0);
    return fmi2OK;
}

/* ---- status ---- */

static fmi2Status no_status(Instance *c, fmi2StatusKind s)
{
    return status_of(log_tell(&c->log, STATUS_DISCARD,
                              "%s: no status of kind %d: no step is ever pending", c->function,
                              (int)s));
}

fmi2Status fmi2GetStatus(fmi2Component component, const fmi2StatusKind s, fmi2Status *value)
{
    ENTER(component, STEPPED);
    (void)value;
    return no_status(c, s);
}

fmi2Status fmi2GetRealStatus(fmi2Component component, const fmi2StatusKind s, fmi2Real *value)
{
    ENTER(component, STEPPED);
    if (!value) REFUSE("value is NULL");
    if (s != fmi2LastSuccessfulTime) return no_status(c, s);
    *value = c->core->time;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component component, const fmi2StatusKind s, fmi2Integer *value)
{
    ENTER(component, STEPPED);
    (void)value;
    return no_status(c, s);
}

/* A failed step cannot be continued from where it stopped: the FMU asks for the end. */
fmi2Status fmi2GetBooleanStatus(fmi2Component component, const fmi2StatusKind s, fmi2Boolean *value)
{
    ENTER(component, STEPPED);
    if (!value) REFUSE("value is NULL");
    if (s != fmi2Terminated) return no_status(c, s);
    *value = c->core->mode == STEP_FAILED ? fmi2True : fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStringStatus(fmi2Component component, const fmi2StatusKind s, fmi2String *value)
{
    ENTER(component, STEPPED);
    (void)value;
    return no_status(c, s);
}
