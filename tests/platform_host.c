/* A master for FMUs of any platform: FMI 2.0 or 3.0, co-simulation, bare calls, and all outputs as they are to the bit.

   platform_host FMI LIBRARY RESOURCES GUID STEPS H INPUT,... OUTPUT,... INPUTS OUTPUTS
   (value references, "-" for none; how many numbers they are)

   It steps with inputs that change, saves the state halfway, goes on to the end, goes back, and goes on again:
   that must be the same to the bit. Prints the outputs at each point, a line of hexadecimal numbers each. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"
#include "fmi3Functions.h"

#ifdef _WIN32
#include <windows.h>
static void *open_library(const char *path)
{
    return (void *)LoadLibraryA(path);
}
static void *symbol(void *library, const char *name)
{
    return (void *)(size_t)GetProcAddress((HMODULE)library, name);
}
#else
#include <dlfcn.h>
static void *open_library(const char *path)
{
    return dlopen(path, RTLD_NOW | RTLD_LOCAL);
}
static void *symbol(void *library, const char *name)
{
    return dlsym(library, name);
}
#endif

#define MOST 4096

static void *library;
static void *fmu;
static int fmi;
static unsigned input[MOST], output[MOST];
static size_t n_input, n_output; /* of references */
static size_t inputs, outputs;   /* of numbers */

static void fail(const char *what)
{
    fprintf(stderr, "%s failed\n", what);
    exit(1);
}

static void told(fmi2ComponentEnvironment e, fmi2String name, fmi2Status status,
                 fmi2String category, fmi2String message, ...)
{
    (void)e;
    (void)category;
    if (status > fmi2Warning) fprintf(stderr, "%s: %s\n", name, message);
}

static void told3(fmi3InstanceEnvironment e, fmi3Status status, fmi3String category,
                  fmi3String message)
{
    (void)e;
    (void)category;
    if (status > fmi3Warning) fprintf(stderr, "%s\n", message);
}

#define FUNCTION(name) ((name##TYPE *)(size_t)symbol(library, #name))
#define ALONE(name)                                                                                \
    do {                                                                                           \
        if ((int)FUNCTION(name)(fmu) > 1) fail(#name);                                             \
    } while (0)
#define DO(name, ...)                                                                              \
    do {                                                                                           \
        if ((int)FUNCTION(name)(fmu, __VA_ARGS__) > 1) fail(#name);                                \
    } while (0)

static size_t references(const char *list, unsigned to[])
{
    size_t n = 0;
    char *end;

    if (*list == '-') return 0;
    for (; *list && n < MOST; list = *end ? end + 1 : end)
        to[n++] = (unsigned)strtoul(list, &end, 10);
    return n;
}

static void start(const char *guid, const char *resources)
{
    static const fmi2CallbackFunctions calls = {told, calloc, free, NULL, NULL};

    if (fmi == 2) {
        fmu = FUNCTION(fmi2Instantiate)("it", fmi2CoSimulation, guid, resources, &calls, fmi2False,
                                        fmi2False);
        if (!fmu) fail("fmi2Instantiate");
        DO(fmi2SetupExperiment, fmi2False, 0, 0, fmi2False, 0);
        ALONE(fmi2EnterInitializationMode);
        ALONE(fmi2ExitInitializationMode);
    } else {
        fmu =
            FUNCTION(fmi3InstantiateCoSimulation)("it", guid, resources, fmi3False, fmi3False,
                                                  fmi3False, fmi3False, NULL, 0, NULL, told3, NULL);
        if (!fmu) fail("fmi3InstantiateCoSimulation");
        DO(fmi3EnterInitializationMode, fmi3False, 0, 0, fmi3False, 0);
        ALONE(fmi3ExitInitializationMode);
    }
}

static void step(double t, double H, const double u[], double y[])
{
    if (fmi == 2) {
        DO(fmi2SetReal, input, n_input, u);
        DO(fmi2DoStep, t, H, fmi2True);
        DO(fmi2GetReal, output, n_output, y);
    } else {
        fmi3Boolean event, ended, early;
        fmi3Float64 reached;
        DO(fmi3SetFloat64, input, n_input, u, inputs);
        DO(fmi3DoStep, t, H, fmi3True, &event, &ended, &early, &reached);
        DO(fmi3GetFloat64, output, n_output, y, outputs);
    }
}

/* From point `from` on to `to`; the outputs at each to `found`. */
static void go(int from, int to, double H, double *found)
{
    for (int k = from; k < to; k++) {
        double u[MOST];
        for (size_t i = 0; i < inputs; i++) u[i] = ((k + 3 * (int)i) % 7 - 3) * 0.125;
        step(k * H, H, u, found + (size_t)k * outputs);
    }
}

int main(int n, char **given)
{
    if (n != 11) fail("reading the arguments");
    fmi = atoi(given[1]);
    library = open_library(given[2]);
    if (!library) fail("opening the library");

    int steps = atoi(given[5]), half = steps / 2;
    double H = atof(given[6]);
    n_input = references(given[7], input);
    n_output = references(given[8], output);
    inputs = (size_t)atoi(given[9]);
    outputs = (size_t)atoi(given[10]);
    if (inputs > MOST) fail("having room for all inputs");
    start(given[4], given[3]);

    size_t size = (size_t)(steps + 1) * outputs;
    double *first = calloc(size, sizeof(double)), *second = calloc(size, sizeof(double));
    void *state = NULL;
    go(0, half, H, first);
    if (fmi == 2)
        DO(fmi2GetFMUstate, &state);
    else
        DO(fmi3GetFMUState, &state);
    go(half, steps, H, first);
    if (fmi == 2)
        DO(fmi2SetFMUstate, state);
    else
        DO(fmi3SetFMUState, state);
    memcpy(second, first, size * sizeof(double));
    go(half, steps, H, second);
    if (memcmp(first, second, size * sizeof(double)) != 0) fail("going back");
    for (int k = 0; k < steps; k++)
        for (size_t i = 0; i < outputs; i++)
            printf("%a%c", first[(size_t)k * outputs + i], i + 1 < outputs ? ' ' : '\n');
    if (fmi == 2) {
        DO(fmi2FreeFMUstate, &state);
        FUNCTION(fmi2FreeInstance)(fmu);
    } else {
        DO(fmi3FreeFMUState, &state);
        FUNCTION(fmi3FreeInstance)(fmu);
    }
    return 0;
}
