/* The model that an instance is made of, read from resources/model.bin.

   The file, little endian:
     char magic[8]: RESOURCE_MAGIC; uint32 version: RESOURCE_VERSION
     uint32 crc32 and uint64 length of all that follows
     Sizes n
     char guid[GUID_SIZE]
     int64 ints[n.ints]; double reals[n.reals]; double u_start[n.u]
     Variable variables[n.variables], by value reference
     int64 survey_ints[n.survey_ints]; double survey_reals[n.survey_reals]: see survey.h
     unsigned char told[32]: a digest of what modelDescription.xml says of the variables
     the tape (tape.h): double constants[n.constants]; Operation operations[n.operations];
     TapeGuard guards[n.guards]; int32 results[n.results]; zeros up to a multiple of 8 bytes
     double rest[n.rest], rest_rates[n.rest]: the state at rest and x' there, where a start there is
     offered; n.rests: 1 where it is that of runs that say nothing else
     NUL-terminated UTF-8: names of the variables, n.places places, for each of the n.messages
     messages its code in decimal and its text, n.notices notices

   The GUID is the beginning of the SHA-256 of the first N_SEALED sizes, the numbers and `told`. The
   kernels follow the indices in ints without looking: only what hashes to the GUID that the
   description has reaches them. Those of the tape are looked at when it is read.
*/
#ifndef MBDFMI_RESOURCE_H
#define MBDFMI_RESOURCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "layout.h" /* Sizes, Variable, RESOURCE_..., GUID_SIZE */

/* a, b, c, d: operations before it, places, or constants; see tape.c */
typedef struct {
    int32_t op, a, b, c, d;
} Operation;

/* a condition that the tape rests on */
typedef struct {
    int32_t operation, holds;
} TapeGuard;

/* Lists of outputs beside those of the model: of locals, those that need no accelerations and those that do; and of what is
   watched for kinks. */
typedef enum { SURVEY_MOTION, SURVEY_EFFORTS, SURVEY_WATCHED, N_SURVEY } Surveyed;

/* One of them: what stands behind the model's ints, a head of its own first, and reals; no ints: there is none. */
typedef struct {
    const int64_t *ints;
    const double *reals;
    int64_t n_ints, n_reals, n_work, n_y;
} Survey;

typedef struct {
    Sizes n;
    char guid[GUID_SIZE]; /* NUL-padded, and NUL-terminated */

    const int64_t *ints;
    const double *reals;       /* start values of an instance's reals */
    const double *u_start;     /* start values of the inputs */
    const Variable *variables; /* by value reference; each lies in its buffer */

    const int64_t *survey_ints;
    const double *survey_reals;
    Survey survey[N_SURVEY];
    const int64_t *n_kinks; /* of each number that is watched */
    const double *kinks;

    const double *constants;
    const Operation *operations;
    const TapeGuard *guards; /* the first n.led_guards: of the way to the constraints */
    const int32_t *results;  /* operations of x', then of the outputs; none without a tape */

    const double *rest, *rest_rates; /* n.rest each, which is n_x or 0 */

    const char **names; /* of the variables */
    const char **places;
    const char **messages; /* 2*n.messages: code, text, code, text ... */
    const char **notices;  /* what to warn of when an instance starts */

    unsigned char *data; /* owns what the pointers above point to */
} Resource;

/* Reads model.bin in the folder that the URI (file:/..., file:///..., percent-encoded) or plain
   path `location` names. On failure nothing is held and `why` explains. */
bool resource_read(Resource *r, const char *location, char *why, size_t why_size);

void resource_free(Resource *r);

/* Whether the arrays of a head of ints lie in buffers of these lengths, by Buffer. */
bool resource_is_arranged(const int64_t head[], const int64_t length[], char *why, size_t why_size);

/* the text of a status code, or NULL */
const char *resource_message(const Resource *r, int64_t code);

/* the name of the place of a status; the places are followed by the outputs */
const char *resource_place(const Resource *r, int64_t place);

#endif
