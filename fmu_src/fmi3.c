/* The functions of FMI 3.0: types, statuses and the log of the standard, over an
   instance that knows nothing of it. A call that is refused (fmi3Error) changes nothing: the instance
   can be used on, though the standard does not promise it. */
#include "derivatives.h"
#include "exchange.h"
#include "fmi3Functions.h"
#include "instance.h"
#include "snapshot.h"
#include "variables.h"

#define ANY_MODE    (INSTANTIATED | INITIALIZATION | INITIALIZED | TERMINATED)
#define WRITABLE    (INSTANTIATED | INITIALIZATION | STEP_COMPLETE | EXCHANGE_MODES)
#define INITIALIZED (STEP_MODES | EXCHANGE_MODES)
#define STEPPED     (STEP_MODES | TERMINATED)
#define INTEGRATED  (INITIALIZATION | EXCHANGE_MODES | TERMINATED)

static fmi3Status status_of(Status status)
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
    (void)earlyReturnAllowed;
    (void)requiredIntermediateVariables;
    (void)intermediateUpdate;
    if (c && eventModeUsed)
        return refuse(c, "eventModeUsed: this FMU has no event mode (hasEventMode = false)");
    if (c && nRequiredIntermediateVariables > 0)
        return refuse(c, "requiredIntermediateVariables: this FMU tells none "
                         "(providesIntermediateUpdate = false)");
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
    ENTER(ANY_MODE);
    return status_of(variables_get_arrays(c, valueReferences, nValueReferences, values, nValues));
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    ENTER(WRITABLE);
    return status_of(variables_set_arrays(c, valueReferences, nValueReferences, values, nValues));
}

/* All variables are Float64: any reference to another type is refused. */
static fmi3Status no_variable(Instance *c, const fmi3ValueReference vr[], size_t n,
                              const char *type)
{
    if (n == 0) return fmi3OK;
    if (!vr) REFUSE("NULL instead of an array");
    REFUSE("value reference %u is no %s: all variables of this FMU are Float64", vr[0], type);
}

#define NO_VARIABLES(Type)                                                                         \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],    \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues)         \
    {                                                                                              \
        ENTER(ANY_MODE);                                                                           \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        return no_variable(c, valueReferences, nValueReferences, #Type);                           \
    }                                                                                              \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],    \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues)   \
    {                                                                                              \
        ENTER(WRITABLE);                                                                           \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        return no_variable(c, valueReferences, nValueReferences, #Type);                           \
    }

NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(Int32)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, size_t valueSizes[], fmi3Binary values[],
                         size_t nValues)
{
    ENTER(ANY_MODE);
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return no_variable(c, valueReferences, nValueReferences, "Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, const size_t valueSizes[],
                         const fmi3Binary values[], size_t nValues)
{
    ENTER(WRITABLE);
    (void)valueSizes;
    (void)values;
    (void)nValues;
    return no_variable(c, valueReferences, nValueReferences, "Binary");
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t nUnknowns, const fmi3ValueReference knowns[],
                                        size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                        fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ENTER(INITIALIZATION | INITIALIZED | TERMINATED);
    return status_of(derivatives_of_arrays(c, unknowns, nUnknowns, knowns, nKnowns, seed, nSeed,
                                           sensitivity, nSensitivity));
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

/* ---- model exchange ---- */

/* In co-simulation there is no event mode. */
fmi3Status fmi3EnterEventMode(fmi3Instance instance)
{
    ENTER(CONTINUOUS_TIME);
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
    Status result = exchange_update(c, &event);

    *discreteStatesNeedUpdate = *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = event.states_changed;
    *nextEventTimeDefined = event.next_time_defined;
    *nextEventTime = event.next_time_defined ? event.next_time : 0;
    return status_of(result);
}

fmi3Status fmi3EnterContinuousTimeMode(fmi3Instance instance)
{
    ENTER(EVENT);
    c->core->mode = CONTINUOUS_TIME;
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
    ENTER(EXCHANGE_MODES);
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
    ENTER(INTEGRATED);
    return status_of(exchange_get_rates(c, derivatives, nContinuousStates));
}

fmi3Status fmi3GetEventIndicators(fmi3Instance instance, fmi3Float64 eventIndicators[],
                                  size_t nEventIndicators)
{
    ENTER(INTEGRATED);
    return status_of(exchange_get_indicators(c, eventIndicators, nEventIndicators));
}

fmi3Status fmi3GetContinuousStates(fmi3Instance instance, fmi3Float64 continuousStates[],
                                   size_t nContinuousStates)
{
    ENTER(INTEGRATED);
    return status_of(exchange_get_states(c, continuousStates, nContinuousStates));
}

fmi3Status fmi3GetNominalsOfContinuousStates(fmi3Instance instance, fmi3Float64 nominals[],
                                             size_t nContinuousStates)
{
    ENTER(INTEGRATED);
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

    Status result = instance_try_step(c, currentCommunicationPoint, communicationStepSize);

    *eventHandlingNeeded = *terminateSimulation = *earlyReturn = fmi3False;
    *lastSuccessfulTime = c->core->time;
    return status_of(result);
}

/* ---- what this FMU does not have ---- */

/* arguments that nothing looks at */
#pragma GCC diagnostic ignored "-Wunused-parameter"

fmi3Status fmi3GetOutputDerivatives(fmi3Instance instance,
                                    const fmi3ValueReference valueReferences[],
                                    size_t nValueReferences, const fmi3Int32 orders[],
                                    fmi3Float64 values[], size_t nValues)
{
    ENTER(STEPPED);
    if (nValueReferences > 0) REFUSE("this FMU gives none (maxOutputDerivativeOrder = 0)");
    return fmi3OK;
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                    size_t nUnknowns, const fmi3ValueReference knowns[],
                                    size_t nKnowns, const fmi3Float64 seed[], size_t nSeed,
                                    fmi3Float64 sensitivity[], size_t nSensitivity)
{
    ENTER(INITIALIZATION | INITIALIZED | TERMINATED);
    REFUSE("this FMU gives none (providesAdjointDerivatives = false)");
}

fmi3Status fmi3GetNumberOfVariableDependencies(fmi3Instance instance,
                                               fmi3ValueReference valueReference,
                                               size_t *nDependencies)
{
    ENTER(ANY_MODE);
    REFUSE("modelDescription.xml tells them (providesPerElementDependencies = false)");
}

fmi3Status fmi3GetVariableDependencies(fmi3Instance instance, fmi3ValueReference dependent,
                                       size_t elementIndicesOfDependent[],
                                       fmi3ValueReference independents[],
                                       size_t elementIndicesOfIndependents[],
                                       fmi3DependencyKind dependencyKinds[], size_t nDependencies)
{
    ENTER(ANY_MODE);
    REFUSE("modelDescription.xml tells them (providesPerElementDependencies = false)");
}

/* Refused in every state: modes that are never entered, and what belongs to them. */
#define NEVER()                                                                                    \
    ENTER(0);                                                                                      \
    return fmi3OK

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    NEVER();
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
{
    NEVER();
}

fmi3Status fmi3EnterStepMode(fmi3Instance instance)
{
    NEVER();
}

fmi3Status fmi3EvaluateDiscreteStates(fmi3Instance instance)
{
    NEVER();
}

fmi3Status fmi3ActivateModelPartition(fmi3Instance instance, fmi3ValueReference clockReference,
                                      fmi3Float64 activationTime)
{
    NEVER();
}

/* No variable is a clock. */
#define NO_CLOCK()                                                                                 \
    ENTER(ANY_MODE);                                                                               \
    return no_variable(c, valueReferences, nValueReferences, "Clock")

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, fmi3Clock values[])
{
    NO_CLOCK();
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, const fmi3Clock values[])
{
    NO_CLOCK();
}

fmi3Status fmi3GetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, fmi3Float64 intervals[],
                                  fmi3IntervalQualifier qualifiers[])
{
    NO_CLOCK();
}

fmi3Status fmi3GetIntervalFraction(fmi3Instance instance,
                                   const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, fmi3UInt64 counters[],
                                   fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
{
    NO_CLOCK();
}

fmi3Status fmi3GetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, fmi3Float64 shifts[])
{
    NO_CLOCK();
}

fmi3Status fmi3GetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, fmi3UInt64 counters[],
                                fmi3UInt64 resolutions[])
{
    NO_CLOCK();
}

fmi3Status fmi3SetIntervalDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                  size_t nValueReferences, const fmi3Float64 intervals[])
{
    NO_CLOCK();
}

fmi3Status fmi3SetIntervalFraction(fmi3Instance instance,
                                   const fmi3ValueReference valueReferences[],
                                   size_t nValueReferences, const fmi3UInt64 counters[],
                                   const fmi3UInt64 resolutions[])
{
    NO_CLOCK();
}

fmi3Status fmi3SetShiftDecimal(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                               size_t nValueReferences, const fmi3Float64 shifts[])
{
    NO_CLOCK();
}

fmi3Status fmi3SetShiftFraction(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                                size_t nValueReferences, const fmi3UInt64 counters[],
                                const fmi3UInt64 resolutions[])
{
    NO_CLOCK();
}
