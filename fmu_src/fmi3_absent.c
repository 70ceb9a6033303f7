/* The functions of FMI 3.0 for what this FMU does not have: each is there, and refuses. */
#include "fmi3_calls.h"

/* What all functions for variables do that are not there: one place for it, it is long beside a call. */
static fmi3Status absent(Instance *c, const char *function, int modes,
                         const fmi3ValueReference vr[], size_t n, const char *type)
{
    return instance_enter(c, function, modes) ? no_variable(c, vr, n, type) : fmi3Error;
}

#define ABSENT(modes, type)                                                                        \
    return absent(instance, __func__, modes, valueReferences, nValueReferences, type)

/* ---- other types ---- */

#define NO_VARIABLES(Type)                                                                         \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],    \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues)         \
    {                                                                                              \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        ABSENT(ANY_MODE, #Type);                                                                   \
    }                                                                                              \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],    \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues)   \
    {                                                                                              \
        (void)values;                                                                              \
        (void)nValues;                                                                             \
        ABSENT(WRITABLE, #Type);                                                                   \
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
NO_VARIABLES(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, size_t valueSizes[], fmi3Binary values[],
                         size_t nValues)
{
    (void)valueSizes;
    (void)values;
    (void)nValues;
    ABSENT(ANY_MODE, "Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, const size_t valueSizes[],
                         const fmi3Binary values[], size_t nValues)
{
    (void)valueSizes;
    (void)values;
    (void)nValues;
    ABSENT(WRITABLE, "Binary");
}

/* ---- other modes, dependencies by elements, clocks ---- */

/* arguments that nothing looks at */
#pragma GCC diagnostic ignored "-Wunused-parameter"

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
#define NEVER() return absent(instance, __func__, 0, NULL, 0, "")

fmi3Status fmi3EnterConfigurationMode(fmi3Instance instance)
{
    NEVER();
}

fmi3Status fmi3ExitConfigurationMode(fmi3Instance instance)
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
#define NO_CLOCK() ABSENT(ANY_MODE, "Clock")

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
