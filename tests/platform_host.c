/* A master for FMUs of any platform: FMI 2.0, co-simulation, bare calls, and all outputs as they are to the bit.

   platform_host LIBRARY RESOURCES GUID STEPS H INPUT,... OUTPUT,...   (value references; "-" for none)

   It steps with inputs that change, saves the state halfway, goes on to the end, goes back, and goes on again:
   that must be the same to the bit. Prints the outputs at each point, a line of hexadecimal numbers each. */
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi2Functions.h"

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
static fmi2Component fmu;
static unsigned input[MOST], output[MOST];
static size_t n_input, n_output;

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

#define FUNCTION(name) ((name##TYPE *)(size_t)symbol(library, #name))
#define DO(name, ...)                                                                              \
    do {                                                                                           \
        if (FUNCTION(name)(fmu, __VA_ARGS__) > fmi2Warning) fail(#name);                           \
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

/* From point `from` on to `to`; the outputs at each to `found`. */
static void go(int from, int to, double H, double *found)
{
    for (int k = from; k < to; k++) {
        double u[MOST];
        for (size_t i = 0; i < n_input; i++) u[i] = ((k + 3 * (int)i) % 7 - 3) * 0.125;
        DO(fmi2SetReal, input, n_input, u);
        DO(fmi2DoStep, k * H, H, fmi2True);
        DO(fmi2GetReal, output, n_output, found + (size_t)k * n_output);
    }
}

int main(int n, char **given)
{
    if (n != 8) fail("reading the arguments");
    library = open_library(given[1]);
    if (!library) fail("opening the library");

    const fmi2CallbackFunctions calls = {told, calloc, free, NULL, NULL};
    int steps = atoi(given[4]), half = steps / 2;
    double H = atof(given[5]);
    n_input = references(given[6], input);
    n_output = references(given[7], output);
    fmu = FUNCTION(fmi2Instantiate)("it", fmi2CoSimulation, given[3], given[2], &calls, fmi2False,
                                    fmi2False);
    if (!fmu) fail("fmi2Instantiate");
    DO(fmi2SetupExperiment, fmi2False, 0, 0, fmi2False, 0);
    if (FUNCTION(fmi2EnterInitializationMode)(fmu) > fmi2Warning)
        fail("fmi2EnterInitializationMode");
    if (FUNCTION(fmi2ExitInitializationMode)(fmu) > fmi2Warning) fail("fmi2ExitInitializationMode");

    size_t size = (size_t)(steps + 1) * n_output;
    double *first = calloc(size, sizeof(double)), *second = calloc(size, sizeof(double));
    fmi2FMUstate state = NULL;
    go(0, half, H, first);
    DO(fmi2GetFMUstate, &state);
    go(half, steps, H, first);
    DO(fmi2SetFMUstate, state);
    memcpy(second, first, size * sizeof(double));
    go(half, steps, H, second);
    if (memcmp(first, second, size * sizeof(double)) != 0) fail("going back");
    for (int k = 0; k < steps; k++)
        for (size_t i = 0; i < n_output; i++)
            printf("%a%c", first[(size_t)k * n_output + i], i + 1 < n_output ? ' ' : '\n');
    DO(fmi2FreeFMUstate, &state);
    FUNCTION(fmi2FreeInstance)(fmu);
    return 0;
}
