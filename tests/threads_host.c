/* Eight threads with instances of their own of one FMU, in all four kinds at once, under the sanitizer of threads.

   threads_host RESOURCES_AS_URI RESOURCES GUID STATES OUTPUT,... OUTPUT,... NUMBERS   (outputs of FMI 2, those of FMI 3 and how
   many numbers these are)

   Each begins, runs, saves, restores, resets, runs again and ends; threads of one kind must find the
   same to the bit. */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

enum { N_THREAD = 8, N_KIND = 4, STEPS = 30, MOST = 4096, ROUNDS = 3 };

static const char *resources2, *resources3, *guid;
static size_t n_states, n_output2, n_output3, outputs3;
static unsigned output2[MOST], output3[MOST];
static double found[N_THREAD][MOST];

#define MUST(call)                                                                                 \
    do {                                                                                           \
        if ((int)(call) > 1) {                                                                     \
            fprintf(stderr, "%s failed\n", #call);                                                 \
            exit(1);                                                                               \
        }                                                                                          \
    } while (0)

static void told2(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status,
                  fmi2String category, fmi2String message, ...)
{
    (void)e, (void)name, (void)category;
    if (status > fmi2Warning) fprintf(stderr, "%s\n", message);
}

static void told3(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category,
                  fmi3String message)
{
    (void)e, (void)category;
    if (status > fmi3Warning) fprintf(stderr, "%s\n", message);
}

static void solve2(fmi2Component c)
{
    double x[MOST], rates[MOST];
    fmi2EventInfo info;
    fmi2Boolean event, end;

    do MUST(fmi2NewDiscreteStates(c, &info));
    while (info.newDiscreteStatesNeeded);
    MUST(fmi2EnterContinuousTimeMode(c));
    for (int k = 0; k < STEPS; k++) {
        MUST(fmi2GetContinuousStates(c, x, n_states));
        MUST(fmi2GetDerivatives(c, rates, n_states));
        for (size_t i = 0; i < n_states; i++) x[i] += 1e-4 * rates[i];
        MUST(fmi2SetTime(c, (k + 1) * 1e-4));
        MUST(fmi2SetContinuousStates(c, x, n_states));
        MUST(fmi2CompletedIntegratorStep(c, fmi2True, &event, &end));
    }
}

static void solve3(fmi3Instance c)
{
    double x[MOST], rates[MOST], time;
    fmi3Boolean again, a, b, d, e;

    do MUST(fmi3UpdateDiscreteStates(c, &again, &a, &b, &d, &e, &time));
    while (again);
    MUST(fmi3EnterContinuousTimeMode(c));
    for (int k = 0; k < STEPS; k++) {
        MUST(fmi3GetContinuousStates(c, x, n_states));
        MUST(fmi3GetContinuousStateDerivatives(c, rates, n_states));
        for (size_t i = 0; i < n_states; i++) x[i] += 1e-4 * rates[i];
        MUST(fmi3SetTime(c, (k + 1) * 1e-4));
        MUST(fmi3SetContinuousStates(c, x, n_states));
        MUST(fmi3CompletedIntegratorStep(c, fmi3True, &a, &b));
    }
}

static void run2(int exchanges, double *y)
{
    static const fmi2CallbackFunctions calls = {told2, calloc, free, NULL, NULL};
    fmi2Component c = fmi2Instantiate("it", exchanges ? fmi2ModelExchange : fmi2CoSimulation, guid,
                                      resources2, &calls, fmi2False, fmi2True);
    fmi2FMUstate state = NULL;

    if (!c) exit(1);
    for (int round = 0; round < ROUNDS; round++) {
        MUST(fmi2SetupExperiment(c, fmi2False, 0, 0, fmi2False, 0));
        MUST(fmi2EnterInitializationMode(c));
        MUST(fmi2ExitInitializationMode(c));
        if (exchanges)
            solve2(c);
        else
            for (int k = 0; k < STEPS; k++) MUST(fmi2DoStep(c, k * 0.01, 0.01, fmi2True));
        MUST(fmi2GetFMUstate(c, &state));
        MUST(fmi2SetFMUstate(c, state));
        MUST(fmi2GetReal(c, output2, n_output2, y));
        MUST(fmi2Reset(c));
    }
    MUST(fmi2FreeFMUstate(c, &state));
    fmi2FreeInstance(c);
}

static void run3(int exchanges, double *y)
{
    fmi3Instance c =
        exchanges
            ? fmi3InstantiateModelExchange("it", guid, resources3, fmi3False, fmi3True, NULL, told3)
            : fmi3InstantiateCoSimulation("it", guid, resources3, fmi3False, fmi3True, fmi3False,
                                          fmi3False, NULL, 0, NULL, told3, NULL);
    fmi3FMUState state = NULL;
    fmi3Boolean event, ended, early;
    fmi3Float64 reached;

    if (!c) exit(1);
    for (int round = 0; round < ROUNDS; round++) {
        MUST(fmi3EnterInitializationMode(c, fmi3False, 0, 0, fmi3False, 0));
        MUST(fmi3ExitInitializationMode(c));
        if (exchanges)
            solve3(c);
        else
            for (int k = 0; k < STEPS; k++)
                MUST(fmi3DoStep(c, k * 0.01, 0.01, fmi3True, &event, &ended, &early, &reached));
        MUST(fmi3GetFMUState(c, &state));
        MUST(fmi3SetFMUState(c, state));
        MUST(fmi3GetFloat64(c, output3, n_output3, y, outputs3));
        MUST(fmi3Reset(c));
    }
    MUST(fmi3FreeFMUState(c, &state));
    fmi3FreeInstance(c);
}

static void *work(void *number)
{
    int k = (int)(size_t)number, kind = k % N_KIND;

    (kind < 2 ? run2 : run3)(kind % 2, found[k]);
    return NULL;
}

static size_t references(const char *list, unsigned to[])
{
    size_t n = 0;
    char *end;

    for (; *list && n < MOST; list = *end ? end + 1 : end)
        to[n++] = (unsigned)strtoul(list, &end, 10);
    return n;
}

int main(int n, char **given)
{
    pthread_t thread[N_THREAD];

    if (n != 8) return 2;
    resources2 = given[1];
    resources3 = given[2];
    guid = given[3];
    n_states = (size_t)atoi(given[4]);
    n_output2 = references(given[5], output2);
    n_output3 = references(given[6], output3);
    outputs3 = (size_t)atoi(given[7]);
    for (size_t k = 0; k < N_THREAD; k++)
        if (pthread_create(&thread[k], NULL, work, (void *)k)) return 3;
    for (int k = 0; k < N_THREAD; k++) pthread_join(thread[k], NULL);
    for (int k = N_KIND; k < N_THREAD; k++)
        if (memcmp(found[k], found[k - N_KIND], sizeof found[k])) {
            fprintf(stderr, "threads %d and %d find different values\n", k, k - N_KIND);
            return 4;
        }
    puts("as one");
    return 0;
}
