/* The functions of FMI 3.0 for what this FMU does not have: each is there, and refuses. */
#include "fmi3_calls.h"

/* ---- other types ---- */

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
