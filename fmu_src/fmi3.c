/* The functions of FMI 3.0: types, statuses and the log of the standard, over an
   instance that knows nothing of it. A call that is refused (fmi3Error) changes nothing: the instance
   can be used on, though the standard does not promise it. */
#include "course.h"
#include "derivatives.h"
#include "exchange.h"
#include "fmi3_calls.h"
#include "intermediate.h"
#include "rest.h"
#include "snapshot.h"
#include "variables.h"

/* ---- library and log ---- */

const char *fmi3GetVersion(void)
{
    return fmi3Version;
}

/* In a message #12# stands for a variable: the sign is doubled. */
static void tell_master(const Log *log, Status status, const char *category, const char *text)
{
    char message[2 * LONGEST_MESSAGE], *to = message;

    for (; *text; text++) {
        if (*text == '#') *to++ = *text;
        *to++ = *text;
    }
    *to = '\0';
    ((fmi3LogMessageCallback)log->logger)(log->environment, status_of(status), category, message);
}

fmi3Status fmi3SetDebugLogging(fmi3Instance instance, fmi3Boolean loggingOn, size_t nCategories,
                               const fmi3String categories[])
{
    ENTER(ANY_MODE);
    return status_of(instance_choose_log(c, loggingOn, nCategories, categories));
}

/* ---- life ---- */

static Instance *instantiate(fmi3String name, fmi3String token, fmi3String path,
                             fmi3Boolean loggingOn, fmi3InstanceEnvironment environment,
                             fmi3LogMessageCallback logMessage)
{
    Log log = {0};

    if (logMessage) {
        log.send = tell_master;
        log.logger = (void (*)(void))logMessage;
        log.environment = environment;
    }
    log.logged[LOG_ALL] = loggingOn;
    return instance_create(name, token, path, &log);
}

/* No instance, with the reason in the log. */
static fmi3Instance refuse(Instance *c, const char *why)
{
    log_tell(&c->log, STATUS_ERROR, "%s", why);
    instance_free(c);
    return NULL;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible,
                                          fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    Instance *c = instantiate(instanceName, instantiationToken, resourcePath, loggingOn,
                              instanceEnvironment, logMessage);

    (void)visible;
    if (!c || instance_exchange(c)) return c;
    instance_free(c);
    return NULL;
}

/* Lets the master see a point within a step. */
static bool tell_point(Instance *c, double time, bool may_return, double *until)
{
    fmi3Boolean requested = fmi3False;

    *until = time;
    ((fmi3IntermediateUpdateCallback)c->update)(c->log.environment, time, fmi3False, fmi3True,
                                                fmi3True, may_return, &requested, until);
    return may_return && requested;
}

fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3Boolean eventModeUsed,
    fmi3Boolean earlyReturnAllowed, const fmi3ValueReference requiredIntermediateVariables[],
    size_t nRequiredIntermediateVariables, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3IntermediateUpdateCallback intermediateUpdate)
{
    Instance *c = instantiate(instanceName, instantiationToken, resourcePath, loggingOn,
                              instanceEnvironment, logMessage);

    (void)visible;
    (void)requiredIntermediateVariables; /* all can be had */
    if (c && nRequiredIntermediateVariables > 0 && !intermediateUpdate)
        return refuse(c, "requiredIntermediateVariables: there is no intermediateUpdate to tell "
                         "them to");
    if (c && eventModeUsed && !instance_use_events(c)) return refuse(c, "no event mode");
    if (c && intermediateUpdate) {
        c->at_point = tell_point;
        c->update = (void (*)(void))intermediateUpdate;
    }
    if (c) c->may_return = earlyReturnAllowed;
    return c;
}

fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String instanceName, fmi3String instantiationToken, fmi3String resourcePath,
    fmi3Boolean visible, fmi3Boolean loggingOn, fmi3InstanceEnvironment instanceEnvironment,
    fmi3LogMessageCallback logMessage, fmi3ClockUpdateCallback clockUpdate,
    fmi3LockPreemptionCallback lockPreemption, fmi3UnlockPreemptionCallback unlockPreemption)
{
    Instance *c = instantiate(instanceName, instantiationToken, resourcePath, loggingOn,
                              instanceEnvironment, logMessage);

    (void)visible;
    (void)clockUpdate;
    (void)lockPreemption;
    (void)unlockPreemption;
    return c ? refuse(c, "this FMU is not for scheduled execution") : NULL;
}

void fmi3FreeInstance(fmi3Instance instance)
{
    if (instance) instance_free(instance);
}

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    ENTER(INSTANTIATED);
    Status result = instance_setup(c, toleranceDefined ? &tolerance : NULL, startTime,
                                   stopTimeDefined ? &stopTime : NULL);

    if (result == STATUS_OK) c->core->mode = INITIALIZATION;
    return status_of(result);
}

fmi3Status fmi3ExitInitializationMode(fmi3Instance instance)
{
    ENTER(INITIALIZATION);
    return status_of(instance_start(c));
}

fmi3Status fmi3Terminate(fmi3Instance instance)
{
    ENTER(INITIALIZED);
    return status_of(instance_terminate(c));
}

fmi3Status fmi3Reset(fmi3Instance instance)
{
    ENTER(ANY_MODE);
    return status_of(instance_reset(c));
}

/* ---- variables ---- */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Float64 values[], size_t nValues)
{
    ENTER(ANY_MODE | INTERMEDIATE);
    return status_of(variables_get_arrays(c, valueReferences, nValueReferences, values, nValues));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    ENTER(WRITABLE);
    return status_of(variables_set_arrays(c, valueReferences, nValueReferences, values, nValues));
}

fmi3Status fmi3GetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Boolean values[], size_t nValues)
{
    ENTER(ANY_MODE | INTERMEDIATE);
    Status result = rest_check_references(c, valueReferences, nValueReferences, values, "Boolean");

    if (result == STATUS_OK && nValues != nValueReferences)
        REFUSE("%zu values for variables of %zu", nValues, nValueReferences);
    for (size_t i = 0; i < nValueReferences && result == STATUS_OK; i++)
        values[i] = c->core->rests != 0;
    return status_of(result);
}

fmi3Status fmi3SetBoolean(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Boolean values[], size_t nValues)
{
    ENTER(WRITABLE);
    Status result = rest_check_references(c, valueReferences, nValueReferences, values, "Boolean");

    if (result == STATUS_OK && nValues != nValueReferences)
        REFUSE("%zu values for variables of %zu", nValues, nValueReferences);
    for (size_t i = 0; i < nValueReferences && result == STATUS_OK; i++)
        result = rest_set(c, values[i]);
    return status_of(result);
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t nUnknowns, const fmi3ValueReference knowns[],
                                        size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ENTER(INITIALIZATION | INITIALIZED | INTERMEDIATE | TERMINATED);
    return status_of(derivatives_of_arrays(c, false, unknowns, nUnknowns, knowns, nKnowns, seed,
                                           nSeed, sensitivity, nSensitivity));
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t nUnknowns, const fmi3ValueReference knowns[],
                                    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ENTER(INITIALIZATION | INITIALIZED | INTERMEDIATE | TERMINATED);
    return status_of(derivatives_of_arrays(c, true, unknowns, nUnknowns, knowns, nKnowns, seed,
                                           nSeed, sensitivity, nSensitivity));
}

/* ---- snapshots ---- */

fmi3Status fmi3GetFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ENTER(ANY_MODE);
    return status_of(snapshot_get(c, FMUState));
}

fmi3Status fmi3SetFMUState(fmi3Instance instance, fmi3FMUState FMUState)
{
    ENTER(ANY_MODE);
    return status_of(snapshot_set(c, FMUState));
}

fmi3Status fmi3FreeFMUState(fmi3Instance instance, fmi3FMUState *FMUState)
{
    ENTER(ANY_MODE);
    return status_of(snapshot_free(c, FMUState));
}

fmi3Status fmi3SerializedFMUStateSize(fmi3Instance instance, fmi3FMUState FMUState, size_t *size)
{
    ENTER(ANY_MODE);
    return status_of(snapshot_size(c, FMUState, size));
}

fmi3Status fmi3SerializeFMUState(fmi3Instance instance, fmi3FMUState FMUState,
                                 fmi3Byte serializedState[], size_t size)
{
    ENTER(ANY_MODE);
    return status_of(snapshot_serialise(c, FMUState, serializedState, size));
}

fmi3Status fmi3DeserializeFMUState(fmi3Instance instance, const fmi3Byte serializedState[],
                                   size_t size, fmi3FMUState *FMUState)
{
    ENTER(ANY_MODE);
    return status_of(snapshot_deserialise(c, serializedState, size, FMUState));
}

/* ---- events and model exchange ---- */

#define ENTER_EXCHANGE(modes)                                                                      \
    ENTER(modes);                                                                                  \
    if (!c->exchanges) REFUSE("is for model exchange")

fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    Instance *c = instance;
    int stepping = c && c->has_events ? STEP_COMPLETE : 0;

    if (!instance_enter(c, __func__, CONTINUOUS_TIME | stepping)) return fmi3Error;
    c->core->mode = EVENT;
    return fmi3OK;
}

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    ENTER(EVENT);
    if (!(discreteStatesNeedUpdate && terminateSimulation && nominalsOfContinuousStatesChanged
          && valuesOfContinuousStatesChanged && nextEventTimeDefined && nextEventTime))
        REFUSE("NULL instead of a place for a result");

    Event event = {0};
    Status result = c->exchanges ? exchange_update(c, &event) : events_settle(c, &event);

    *discreteStatesNeedUpdate = *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = event.states_changed;
    *nextEventTimeDefined = event.next_time_defined;
    *nextEventTime = event.next_time_defined ? event.next_time : 0;
    return status_of(result);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ENTER_EXCHANGE(EVENT);
    c->core->mode = CONTINUOUS_TIME;
    return fmi3OK;
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    ENTER(EVENT);
    if (c->exchanges) REFUSE("is for co-simulation");
    c->core->mode = STEP_COMPLETE;
    return fmi3OK;
}

fmi3Status fmi3CompletedIntegratorStep(fmi3Instance instance,
                                       fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi3Boolean *enterEventMode,
                                       fmi3Boolean *terminateSimulation)
{
    ENTER(CONTINUOUS_TIME);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!(enterEventMode && terminateSimulation)) REFUSE("NULL instead of a place for a result");

    bool wanted;
    Status result = exchange_complete_step(c, &wanted);

    *enterEventMode = wanted;
    *terminateSimulation = fmi3False;
    return status_of(result);
}

fmi3Status fmi3SetTime(fmi3Instance instance, fmi3Float64 time)
{
    ENTER_EXCHANGE(EXCHANGE_MODES);
    return status_of(exchange_set_time(c, time));
}

fmi3Status fmi3SetContinuousStates(fmi3Instance instance, const fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    ENTER(CONTINUOUS_TIME);
    return status_of(exchange_set_states(c, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetContinuousStateDerivatives(fmi3Instance instance, fmi3Float64 derivatives[],
                                             size_t nContinuousStates)
{
    ENTER_EXCHANGE(INTEGRATED);
    return status_of(exchange_get_rates(c, derivatives, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[],
                                  size_t nEventIndicators)
{
    ENTER_EXCHANGE(INTEGRATED);
    return status_of(exchange_get_indicators(c, eventIndicators, nEventIndicators));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    ENTER_EXCHANGE(INTEGRATED);
    return status_of(exchange_get_states(c, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
                                             size_t nContinuousStates)
{
    ENTER_EXCHANGE(INTEGRATED);
    return status_of(exchange_get_nominals(c, nominals, nContinuousStates));
}

static fmi3Status tell_number(Instance *c, int64_t number, size_t *place)
{
    if (!c->exchanges) REFUSE("is for model exchange");
    if (!place) REFUSE("NULL instead of a place for the result");
    *place = (size_t)number;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    ENTER(ANY_MODE);
    return tell_number(c, c->n_indicators, nEventIndicators);
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    ENTER(ANY_MODE);
    return tell_number(c, c->n_states, nContinuousStates);
}

/* ---- steps ---- */

/* A step that is discarded leaves the instance as it was before. */
fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize,
                      fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    ENTER(STEP_COMPLETE);
    (void)noSetFMUStatePriorToCurrentPoint;
    if (!(eventHandlingNeeded && terminateSimulation && earlyReturn && lastSuccessfulTime))
        REFUSE("NULL instead of a place for a result");

    StepEnd end;
    Status result = intermediate_step(c, currentCommunicationPoint, communicationStepSize, &end);

    *eventHandlingNeeded = end.event;
    *terminateSimulation = fmi3False;
    *earlyReturn = end.early;
    *lastSuccessfulTime = c->core->time;
    return status_of(result);
}

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance,
                                    const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t nValues)
{
    ENTER(STEPPED | INTERMEDIATE);
    return status_of(course_derivatives_of_arrays(c, valueReferences, nValueReferences, orders,
                                                  values, nValues));
}
